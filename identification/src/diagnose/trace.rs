//! A record ready for simulation: commands and loads of its steps, initial position, settling time.

mod delay;

use std::sync::{Arc, OnceLock};

use super::quantiser::{Quantiser, step_of};
use crate::{
    progress::Work,
    signal::{Interpolation, record::Record, sampling::Sampling},
    spikes::bridge,
};
use actuator_fmu::{
    actuator::{Actuator, Inputs, Outputs, State, Workspace},
    effects::{Effects, find},
    parameters::{Base, Model},
    transition::Ramp,
};

/// One step of a record.
#[derive(Clone)]
struct Step {
    inputs: Inputs,
    duration: f64,
}

/// A record ready to be simulated many times.
#[derive(Clone)]
pub struct Trace<'a> {
    /// The record.
    pub record: &'a Record,
    /// Shared by its copies.
    steps: Arc<[Step]>,
    /// Initial position, at rest [deg].
    pub start: f64,
    /// Samples at its start in which the initial transient settles; they are not evaluated.
    pub settling: usize,
    /// Samples after settling whose position was not measured.
    not_measured: Vec<usize>,
    /// The quantiser of the measurement, where it matters.
    pub quantiser: Option<Quantiser>,
    /// Step of the measured positions, once it was asked for.
    step: OnceLock<f64>,
    /// Whether a delayed command is averaged over each step instead of changing within it: as accurate as thinning, and much faster.
    averages_delay: bool,
    /// Whether the motion is simulated exactly, as in the FMU, and not only as accurately as a search needs.
    is_exact: bool,
    /// Progress of the search that simulates it.
    work: Option<&'a Work<'a>>,
}

/// The simulated position of a model through a record.
#[derive(Debug, Clone)]
pub struct Simulated {
    /// Position, as measured [deg].
    pub position: Vec<f64>,
    /// Rate of the drive [deg/s], where it is asked for.
    pub rate: Option<Vec<f64>>,
}

/// The simulated motion of a model through a record.
pub struct Motion {
    /// Simulated position, as measured [deg].
    pub position: Vec<f64>,
    /// Rate of the drive [deg/s].
    pub rate: Vec<f64>,
    /// Acceleration demand [deg/s²]: ω² (x - δ) at the start of each step, with the x at the end of the step, since a held command jumps there.
    pub acceleration_demand: Vec<f64>,
    /// Whether a limit is reached.
    pub saturated: Vec<bool>,
}

/// Relative error of the rms of a residual as simulated in a search, at most; smaller differences are compared exactly, as the FMUs are stepped.
pub const APPROXIMATION: f64 = 1e-5;

/// Relative rounding error between exact simulations of models that move alike: one with an effect that is not reached takes other steps.
pub const ROUNDING: f64 = 1e-9;

/// Fewest samples at rest for their mean to be the initial position.
const QUIET_SAMPLES: usize = 10;

impl<'a> Trace<'a> {
    /// A record with the settling time of an actuator with this base.
    pub fn new(record: &'a Record, base: &Base) -> Self {
        let loads = record.load();
        let load = |index: usize, duration: f64| {
            let Some(loads) = loads else { return Ramp::default() };
            let slope = match record.interpolation() {
                Interpolation::Held => 0.0,
                Interpolation::Linear => (loads[index + 1] - loads[index]) / duration,
            };
            Ramp { value: loads[index], slope }
        };
        // On an even clock the interval itself: differences of written times vary in their last digits, and each would be a transition of its own.
        let interval = match record.sampling() {
            Sampling::Even(interval) => Some(interval),
            Sampling::Uneven(_) => None,
        };
        let steps = record.steps().enumerate().map(|(index, step)| Step {
            inputs: Inputs { load: load(index, step.duration), ..Inputs::command(step.command) },
            duration: interval.unwrap_or(step.duration),
        });
        let settling = settling(record, base);
        Self {
            record,
            steps: steps.collect(),
            start: start(record),
            settling,
            not_measured: (0..record.len() - settling).filter(|n| !record.is_measured(settling + n)).collect(),
            quantiser: None,
            step: OnceLock::new(),
            averages_delay: false,
            is_exact: false,
            work: None,
        }
    }

    /// For coarse searches: with the delayed command averaged over each step.
    pub fn coarse(record: &'a Record, base: &Base) -> Self {
        Self { averages_delay: record.interpolation() == Interpolation::Held, ..Self::new(record, base) }
    }

    /// The same, simulated exactly.
    pub fn exact(&self) -> Self {
        Self { averages_delay: false, is_exact: true, ..self.clone() }
    }

    /// The same, with its simulations counted as part of a search.
    pub(crate) fn part_of(self, work: &'a Work<'a>) -> Self {
        Self { work: Some(work), ..self }
    }

    /// Reports that a least-squares search on this record, and others, begins.
    pub fn begin_search(&self) {
        if let Some(work) = self.work {
            work.begin_search();
        }
    }

    /// Whether free motion is possible at the start: in a part of a record, or where the command moves at once.
    pub fn begins_in_motion(&self) -> bool {
        self.record.offset_s() > 0.0 || quiet_samples(self.record) < QUIET_SAMPLES
    }

    /// A column of ones from where the sensor slipped, over the evaluated samples; none where that is too near their ends for its height to be
    /// determined.
    pub fn slip(&self) -> Option<Vec<f64>> {
        const FEWEST: usize = 50;
        let at = self.record.slip_s()?;
        let after: Vec<f64> =
            self.record.time()[self.settling..].iter().map(|time| f64::from(u8::from(*time >= at))).collect();
        let count = after.iter().filter(|value| **value > 0.0).count();
        (count.min(after.len() - count) >= FEWEST).then_some(after)
    }

    /// Number of samples after settling.
    pub fn evaluated_samples(&self) -> usize {
        self.record.len() - self.settling
    }

    /// Step of which all measured positions are multiples [deg]; 0 where there is none.
    pub fn step(&self) -> f64 {
        *self.step.get_or_init(|| step_of(&self.record.measured_positions()))
    }

    /// Whether the position of each sample was measured, and its sensor did not slip.
    pub fn is_complete(&self) -> bool {
        self.not_measured.is_empty() && self.record.slip_s().is_none()
    }

    /// Values of the evaluated samples, with straight lines where no position was measured: such samples add no information, and noise keeps its
    /// colour.
    pub fn where_measured(&self, mut values: Vec<f64>) -> Vec<f64> {
        bridge(&mut values, &self.not_measured);
        values
    }

    /// The simulated position, as measured; none where the motion diverges.
    pub fn position(&self, model: &Model) -> Option<Vec<f64>> {
        Some(self.simulated_while(model, false, |_, _| true)?.position)
    }

    /// As above, with the rate of the drive if it is asked for, as long as `goes_on` is true of each sample and its position before it is rounded;
    /// none where the simulation ends before the record.
    pub fn simulated_while(
        &self,
        model: &Model,
        with_rate: bool,
        mut goes_on: impl FnMut(usize, f64) -> bool,
    ) -> Option<Simulated> {
        let count = self.steps.len() + 1;
        let mut position = Vec::with_capacity(count);
        let mut rate = with_rate.then(|| Vec::with_capacity(count));
        self.simulate(model, |outputs, _| {
            rate.iter_mut().for_each(|rate| rate.push(outputs.rate));
            position.push(outputs.position);
            goes_on(position.len() - 1, outputs.position)
        })?;
        if let Some(quantiser) = self.quantiser {
            quantiser.round_on_average(&mut position);
        }
        Some(Simulated { position, rate })
    }

    /// The whole motion; none where it diverges.
    pub fn motion(&self, model: &Model) -> Option<Motion> {
        let mut motion =
            Motion { position: Vec::new(), rate: Vec::new(), acceleration_demand: Vec::new(), saturated: Vec::new() };
        let omega2 = model.base.omega().powi(2);
        let mut pole = 0.0;
        self.simulate(model, |outputs, state| {
            motion.position.push(outputs.position);
            motion.rate.push(outputs.rate);
            if let Some(drive) = motion.acceleration_demand.last_mut() {
                *drive += omega2 * state.pole;
            }
            motion.acceleration_demand.push(-omega2 * state.position);
            motion.saturated.push(outputs.saturated);
            pole = state.pole;
            true
        })?;
        if let Some(drive) = motion.acceleration_demand.last_mut() {
            *drive += omega2 * pole;
        }
        Some(motion)
    }

    /// Calls `observe` with outputs and state at each sample, as long as it returns true; none if it does not, or the motion diverges.
    fn simulate(&self, model: &Model, mut observe: impl FnMut(Outputs, &State) -> bool) -> Option<()> {
        let mut observe = |outputs: Outputs, state: &State| observe(outputs, state).then_some(());
        let delay = find("delay").filter(|_| self.averages_delay || self.divides_steps());
        let delay_s =
            delay.and_then(|delay| model.effects.active_values_of(delay.name)).map_or(0.0, |values| values[0]);
        let effects = match delay {
            Some(delay) if delay_s > 0.0 => model.effects.without(delay),
            _ => model.effects.clone(),
        };
        let (base, effects) = drifted(model.base, effects, self.record.offset_s())?;
        let actuator = Actuator::new(base, model.order, &effects);
        let actuator = if self.is_exact { actuator } else { actuator.approximate() };
        let mut state = actuator.at_rest(actuator.nearest_held(self.start));
        if let Some(work) = self.work {
            work.add(self.steps.len());
        }
        observe(actuator.outputs(&state), &state)?;
        let mut workspace = Workspace::default();
        let mut advance = |state: &mut State, inputs: Inputs, duration: f64| {
            actuator.step(state, &mut workspace, inputs, duration).ok()
        };
        let under = |step: &Step, command: Ramp| Inputs { load: step.inputs.load, ..Inputs::command(command) };
        if delay_s == 0.0 {
            for step in self.steps.iter() {
                advance(&mut state, step.inputs, step.duration)?;
                observe(actuator.outputs(&state), &state)?;
            }
        } else if self.averages_delay {
            for (step, command) in self.steps.iter().zip(self.delayed_command(delay_s)) {
                advance(&mut state, under(step, Ramp::held(command)), step.duration)?;
                observe(actuator.outputs(&state), &state)?;
            }
        } else {
            let rest = actuator.command_at_rest(state.position);
            for (step, (before, share, after)) in self.steps.iter().zip(self.delayed_pieces(delay_s, rest)) {
                let first = share * step.duration;
                let mut saturated = false;
                if first > 0.0 {
                    advance(&mut state, under(step, before), first)?;
                    saturated = state.saturated;
                }
                let load = Ramp { value: step.inputs.load.at(first), ..step.inputs.load };
                advance(&mut state, Inputs { load, ..under(step, after) }, step.duration - first)?;
                state.saturated |= saturated;
                observe(actuator.outputs(&state), &state)?;
            }
        }
        Some(())
    }

    /// Whether a delayed command divides all steps of a search alike: on an even clock.
    fn divides_steps(&self) -> bool {
        !self.is_exact && matches!(self.record.sampling(), Sampling::Even(_))
    }
}

/// The shortest interval between samples.
pub fn interval_s(traces: &[Trace<'_>]) -> f64 {
    traces.iter().map(|trace| trace.record.sampling().interval_s()).fold(f64::INFINITY, f64::min)
}

/// A base and effects for motion that begins some time after the start of a drift; none where the gain has drifted out of its range.
///
/// ```text
/// k (1 + r (T + t)) = k' (1 + r' t),    k' = k (1 + r T),  r' = r / (1 + r T)
/// ```
fn drifted(base: Base, effects: Effects, after_s: f64) -> Option<(Base, Effects)> {
    let drift = find("gain_drift").filter(|_| after_s > 0.0);
    let Some((drift, rate)) = drift.and_then(|drift| Some((drift, effects.active_values_of(drift.name)?[0]))) else {
        return Some((base, effects));
    };
    let [k, p, omega, zeta] = base.values();
    let factor = 1.0 + rate * after_s;
    let effects = effects.with(drift, &[rate / factor]).ok()?;
    Some((Base::from_values([k * factor, p, omega, zeta]).ok()?, effects))
}

/// Mean position before the command first moves, if that is long enough; otherwise the first sample.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn start(record: &Record) -> f64 {
    let position = record.position();
    let quiet = quiet_samples(record);
    if quiet < QUIET_SAMPLES {
        return position[0];
    }
    position[..quiet].iter().sum::<f64>() / quiet as f64
}

/// Samples before the command first moves.
fn quiet_samples(record: &Record) -> usize {
    record.command().iter().take_while(|value| **value == record.command()[0]).count()
}

/// Samples until an error ε of the initial position has decayed, as ε exp(-ζω t).
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of samples
fn settling(record: &Record, base: &Base) -> usize {
    // exp(-10) is 5e-5.
    const TIME_CONSTANTS: f64 = 10.0;
    // Share of a record that is not evaluated, at most, however slow the actuator; larger for one that begins in motion, whose start is least known.
    const GREATEST_SHARE: f64 = 0.1;
    const GREATEST_SHARE_IN_MOTION: f64 = 0.5;
    let decay = base.pair_decay().min(base.p());
    let interval = match record.sampling() {
        Sampling::Even(interval) | Sampling::Uneven(interval) => interval,
    };
    let samples = TIME_CONSTANTS / decay.max(f64::MIN_POSITIVE) / interval;
    let share = if quiet_samples(record) < QUIET_SAMPLES { GREATEST_SHARE_IN_MOTION } else { GREATEST_SHARE };
    samples.min(share * record.len() as f64) as usize
}
