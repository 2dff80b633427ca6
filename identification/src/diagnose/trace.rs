//! A record as the diagnosis steps through it: commands and loads of its steps, where it starts, which samples count.

use super::quantiser::Rounding;
use crate::signal::{
    Interpolation,
    record::{Record, Sampling},
};
use actuator_fmu::{
    actuator::{Actuator, Inputs, Outputs, State, Workspace},
    parameters::{Base, Model},
    transition::Ramp,
};

/// One step of a record.
struct Step {
    inputs: Inputs,
    duration: f64,
}

/// A record ready to be simulated many times.
pub struct Trace<'a> {
    /// What it was made from.
    pub record: &'a Record,
    steps: Vec<Step>,
    /// Where it is taken to be at rest before its first sample [deg].
    pub start: f64,
    /// Samples at its start that still show how it started, and do not count.
    pub settling: usize,
    /// How the measurement was rounded, where it was so coarsely that it shows.
    pub rounding: Option<Rounding>,
}

/// How a model moves through a record.
pub struct Motion {
    /// Measured position [deg].
    pub position: Vec<f64>,
    /// Rate of the drive [deg/s].
    pub rate: Vec<f64>,
    /// Acceleration that the drive asks for [deg/s²]: ω² (x - δ) at the start of each step, with the x that the step leads to, since a
    /// held command jumps there.
    pub drive: Vec<f64>,
    /// Whether a limit acts.
    pub saturated: Vec<bool>,
}

/// Of a quiet start, as many samples tell where it is.
const QUIET_SAMPLES: usize = 10;

impl<'a> Trace<'a> {
    /// With the time that an actuator like this one takes to settle.
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
        let steps = record.steps().enumerate().map(|(index, step)| Step {
            inputs: Inputs { load: load(index, step.duration), ..Inputs::command(step.command) },
            duration: step.duration,
        });
        Self { record, steps: steps.collect(), start: start(record), settling: settling(record, base), rounding: None }
    }

    /// Samples that count.
    pub fn counted(&self) -> usize {
        self.record.len() - self.settling
    }

    /// The measured position; none where the motion runs away.
    pub fn position(&self, model: &Model) -> Option<Vec<f64>> {
        let mut positions = Vec::with_capacity(self.steps.len() + 1);
        self.follow(model, |outputs, _| positions.push(outputs.position))?;
        if let Some(rounding) = self.rounding {
            positions.iter_mut().for_each(|position| *position = rounding.expected(*position));
        }
        Some(positions)
    }

    /// All that is seen of a motion.
    pub fn motion(&self, model: &Model) -> Option<Motion> {
        let mut motion = Motion { position: Vec::new(), rate: Vec::new(), drive: Vec::new(), saturated: Vec::new() };
        let omega2 = model.base.omega().powi(2);
        let mut pole = 0.0;
        self.follow(model, |outputs, state| {
            motion.position.push(outputs.position);
            motion.rate.push(outputs.rate);
            if let Some(drive) = motion.drive.last_mut() {
                *drive += omega2 * state.pole;
            }
            motion.drive.push(-omega2 * state.position);
            motion.saturated.push(outputs.saturated);
            pole = state.pole;
        })?;
        if let Some(drive) = motion.drive.last_mut() {
            *drive += omega2 * pole;
        }
        Some(motion)
    }

    /// Shows what goes out at each sample, and the state that it comes from.
    fn follow(&self, model: &Model, mut see: impl FnMut(Outputs, &State)) -> Option<()> {
        let actuator = Actuator::new(model.base, model.order, &model.effects);
        let (low, high) = actuator.stops();
        let mut state = actuator.at_rest(self.start.clamp(low, high));
        let mut workspace = Workspace::default();
        see(actuator.outputs(&state), &state);
        for step in &self.steps {
            actuator.step(&mut state, &mut workspace, step.inputs, step.duration).ok()?;
            see(actuator.outputs(&state), &state);
        }
        Some(())
    }
}

/// Mean position before the command first moves, if that is long enough; else the first sample.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn start(record: &Record) -> f64 {
    let (command, position) = (record.command(), record.position());
    let quiet = command.iter().take_while(|value| **value == command[0]).count();
    if quiet < QUIET_SAMPLES {
        return position[0];
    }
    position[..quiet].iter().sum::<f64>() / quiet as f64
}

/// A start at rest that is wrong by ε is wrong by ε exp(-ζω t) later.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of samples
fn settling(record: &Record, base: &Base) -> usize {
    // exp(-10) is 5e-5.
    const TIME_CONSTANTS: f64 = 10.0;
    // Most of a record must count, however slow the actuator.
    const GREATEST_SHARE: f64 = 0.1;
    let decay = (base.zeta().min(1.0) * base.omega()).min(base.p());
    let interval = match record.sampling() {
        Sampling::Even(interval) | Sampling::Uneven(interval) => interval,
    };
    let samples = TIME_CONSTANTS / decay.max(f64::MIN_POSITIVE) / interval;
    samples.min(GREATEST_SHARE * record.len() as f64) as usize
}
