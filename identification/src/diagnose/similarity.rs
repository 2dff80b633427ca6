//! Derivatives of a simulated position that need no simulation of their own.
//!
//! Without a load and without anything that changes with time, a motion under a later command is the same motion later:
//!
//! ```text
//! ∂y/∂T = -dy/dt
//! ```
//!
//! If all positions scale alike, that is the gain k and every parameter θᵢ behind it whose unit has the mᵢ-th power of a position, so does the motion
//! (Euler's theorem on homogeneous functions):
//!
//! ```text
//! y(λ k, λ^mᵢ θᵢ) = λ y(k, θᵢ),    ∂y/∂ln k = y - Σ mᵢ θᵢ ∂y/∂θᵢ
//! ```

use super::{
    coordinate::{Scale, Target},
    delay_response::DelayResponse,
    space::Space,
    trace::{Simulated, Trace},
};
use actuator_fmu::{
    effects::{Act, Effects},
    parameters::{Model, PositionUnit},
};

/// Greatest initial position, relative to the largest one, that counts as zero: it does not scale with the gain, and a motion forgets it only
/// as it settles.
const NEGLIGIBLE_START: f64 = 0.05;

/// The elements of a vector whose derivatives follow from the motion of a record, and from the other derivatives.
pub struct Similarity {
    delay: Option<FreeDelay>,
    gain: Option<FreeGain>,
}

struct FreeDelay {
    place: usize,
    /// Its derivative by the element [s].
    slope: f64,
    response: DelayResponse,
}

struct FreeGain {
    place: usize,
    /// For each parameter that scales with it its place, and mᵢ θᵢ over its derivative by the element.
    scaled: Vec<(usize, f64)>,
}

impl Similarity {
    /// Of a vector, its model and its motion through a record.
    pub fn of(space: &Space, x: &[f64], model: &Model, trace: &Trace<'_>, simulated: &Simulated) -> Self {
        let is_alike = trace.record.load().is_none() && trace.quantiser.is_none();
        let largest = || simulated.position.iter().fold(0.0, |largest: f64, position| largest.max(position.abs()));
        let scales = is_alike && trace.start.abs() <= NEGLIGIBLE_START * largest();
        Self {
            delay: delay(space, x, model, trace).filter(|_| is_alike),
            gain: gain(space, x, model).filter(|_| scales),
        }
    }

    /// Whether the derivative of an element follows.
    pub fn gives(&self, place: usize) -> bool {
        let is_gain = self.gain.as_ref().is_some_and(|gain| gain.place == place);
        is_gain || self.delay.as_ref().is_some_and(|delay| delay.place == place)
    }

    /// Fills in the derivatives that follow, over the samples after settling.
    pub fn complete(&self, columns: &mut [Vec<f64>], simulated: &Simulated, settling: usize) {
        if let Some(FreeDelay { place, slope, response }) = &self.delay {
            columns[*place] = response.of(simulated)[settling..].iter().map(|change| slope * change).collect();
        }
        if let Some(gain) = &self.gain {
            let mut column = simulated.position[settling..].to_vec();
            for (other, factor) in &gain.scaled {
                column.iter_mut().zip(&columns[*other]).for_each(|(value, other)| *value -= factor * other);
            }
            columns[gain.place] = column;
        }
    }
}

/// Whether the derivative by a delay follows from the rate of the drive.
pub fn needs_rate(space: &Space, model: &Model, trace: &Trace<'_>) -> bool {
    let is_ahead = |act: &Act| matches!(act, Act::Delay | Act::Command(_) | Act::Loop(_));
    delay_place(space).is_some()
        && !trace.averages_delay()
        && model.effects.active().all(|(effect, _)| is_ahead(&effect.act))
}

fn delay_place(space: &Space) -> Option<usize> {
    let index = Effects::parameters().position(|(effect, _)| matches!(effect.act, Act::Delay))?;
    space.place(Target::Effect(index))
}

fn delay(space: &Space, x: &[f64], model: &Model, trace: &Trace<'_>) -> Option<FreeDelay> {
    let place = delay_place(space)?;
    let changes_with_time = |act: &Act| matches!(act, Act::GainDrift(_) | Act::Reading { .. });
    if model.effects.active().any(|(effect, _)| changes_with_time(&effect.act)) {
        return None;
    }
    let coordinate = space.coordinates()[place];
    let response = match trace.averages_delay() {
        true => {
            let share = trace.share_of_step(coordinate.value(x[place]))?;
            DelayResponse::averaged(share, trace.record.sampling().interval_s())
        }
        false if needs_rate(space, model, trace) => DelayResponse::Rate,
        false => return None,
    };
    Some(FreeDelay { place, slope: coordinate.slope(x[place]), response })
}

fn gain(space: &Space, x: &[f64], model: &Model) -> Option<FreeGain> {
    let place = space.place(Target::Base(0))?;
    let mut scaled = Vec::new();
    for (index, (effect, parameter)) in Effects::parameters().enumerate() {
        let power = f64::from(PositionUnit::power(parameter.unit));
        let is_ahead_of_gain = matches!(effect.act, Act::Delay | Act::Command(_) | Act::GainDrift(_));
        // Neutral values are zero or unlimited, which they remain at any scale.
        if is_ahead_of_gain || power == 0.0 || model.effects.values()[index] == parameter.neutral {
            continue;
        }
        let other = space.place(Target::Effect(index))?;
        let by_element = match space.coordinates()[other].scale {
            Scale::Logarithm(_) => 1.0,
            Scale::Linear(_) => x[other],
        };
        scaled.push((other, power * by_element));
    }
    Some(FreeGain { place, scaled })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{
            hypothesis::{DELAY, Hypothesis},
            jacobian::SimulationCache,
            output_error::OutputError,
        },
        estimate::noise::Noise,
        generated::TestPoint,
        signal::{
            Interpolation,
            excitation::{Excitation, Kind},
            record::{Record, rms},
        },
    };
    use actuator_fmu::{effects::find, parameters::table};

    const SAMPLES_OF_DELAY: [f64; 4] = [0.3, 0.5, 1.8, 4.0];

    fn record(kind: Kind) -> Record {
        let point = TestPoint {
            model: Model::from_set(&table()[0]),
            excitation: Excitation { duration_s: 6.0, ..Excitation::new(kind) },
            interpolation: Interpolation::Held,
            noise_share: 0.0,
            turbulence: None,
            seed: 3,
        };
        point.record("record").unwrap()
    }

    /// Gain and delay free beside the effects: the model, and a space that starts there.
    fn with(effects: &[(&'static str, &[f64])]) -> (Space, Model) {
        let add = |all: Effects, (name, values): &(&str, &[f64])| all.with(find(name).unwrap(), values).unwrap();
        let model = Model { effects: effects.iter().fold(Effects::default(), add), ..Model::from_set(&table()[0]) };
        let effects = effects.iter().map(|(name, _)| *name).collect();
        let hypothesis = Hypothesis { effects, base_free: true, ..Hypothesis::default() };
        (Space::new(hypothesis, &model, &model.base, 0.0), model)
    }

    /// Relative error of the derivatives by gain and delay, against central differences of exact simulations; none for one that is not given.
    fn errors(trace: &Trace<'_>, space: &Space, model: &Model) -> [Option<f64>; 2] {
        const STEP: f64 = 1e-4;
        let (noise, cache) = ([Noise::white(1.0)], SimulationCache::default());
        let traces = [trace.clone()];
        let problem = OutputError::new(space, &traces, &noise, &cache);
        let x = space.start();
        let simulated = problem.simulated(&x).unwrap();
        let similar = Similarity::of(space, &x, model, trace, &simulated[0]);
        let columns = &problem.jacobian(&x, &simulated).columns[0];
        [space.place(Target::Base(0)), delay_place(space)].map(|place| {
            let place = place.filter(|place| similar.gives(*place))?;
            let [more, less] = [STEP, -STEP].map(|step| {
                let mut moved = x.clone();
                moved[place] += step;
                trace.exact().position(&space.model(&moved).unwrap()).unwrap()
            });
            let pairs = more.iter().zip(&less).skip(trace.settling);
            let difference: Vec<f64> = pairs.map(|(more, less)| (more - less) / (2.0 * STEP)).collect();
            let error: Vec<f64> = difference.iter().zip(&columns[place]).map(|(one, other)| one - other).collect();
            Some(rms(&error) / rms(&difference))
        })
    }

    #[test]
    fn gain_and_delay_change_a_motion_as_the_laws_say() {
        let alike: [&[(&str, &[f64])]; 9] = [
            &[],
            &[("command_limit", &[-1.0, 1.2])],
            &[("command_rate_limit", &[20.0, 30.0]), ("asymmetric_gain", &[1.1])],
            &[("dead_zone", &[0.1]), ("amplitude_gain", &[0.03])],
            &[("coulomb_friction", &[0.1]), ("hinge_load", &[0.2, 0.05])],
            &[("acceleration_limit", &[3000.0])],
            &[("rate_limit", &[60.0, 50.0])],
            &[("position_limit", &[-1.0, 1.4])],
            &[("command_dead_zone", &[0.1]), ("command_backlash", &[0.1])],
        ];
        for kind in [Kind::Random, Kind::Sweep] {
            let record = record(kind);
            let interval_s = record.sampling().interval_s();
            let trace = Trace::new(&record, &table()[0].base);
            for (effects, steps) in alike.iter().flat_map(|effects| SAMPLES_OF_DELAY.map(|steps| (effects, steps))) {
                let delay = [steps * interval_s];
                let all: Vec<(&'static str, &[f64])> = [&[(DELAY, delay.as_slice())], *effects].concat();
                let (space, model) = with(&all);
                let found = errors(&trace, &space, &model);
                assert!(found.iter().all(|error| error.unwrap() < 2e-3), "{all:?}: {found:?}");
            }
        }
    }

    #[test]
    fn a_delay_on_average_over_each_step_has_the_derivative_of_that_average() {
        let record = record(Kind::Sweep);
        let interval_s = record.sampling().interval_s();
        let coarse = Trace::coarse(&record, &table()[0].base);
        for steps in SAMPLES_OF_DELAY {
            let (space, model) = with(&[(DELAY, &[steps * interval_s])]);
            let x = space.start();
            let place = delay_place(&space).unwrap();
            let simulated = coarse.simulated_while(&model, false, |_, _| true).unwrap();
            let similar = Similarity::of(&space, &x, &model, &coarse, &simulated);
            let mut columns = vec![vec![0.0; record.len() - coarse.settling]; x.len()];
            similar.complete(&mut columns, &simulated, coarse.settling);
            const STEP: f64 = 1e-4;
            let mut moved = x.clone();
            moved[place] += STEP;
            let later = coarse.position(&space.model(&moved).unwrap()).unwrap();
            let pairs = later.iter().zip(&simulated.position).skip(coarse.settling);
            let difference: Vec<f64> = pairs.map(|(later, here)| (later - here) / STEP).collect();
            let pairs = difference.iter().zip(&columns[place]).take(difference.len() - 2);
            let error: Vec<f64> = pairs.map(|(one, other)| one - other).collect();
            assert!(rms(&error) < 1e-3 * rms(&difference), "{steps}: {} {}", rms(&error), rms(&difference));
        }
    }

    #[test]
    fn what_changes_with_time_or_acts_behind_the_drive_gives_no_derivative_by_the_delay() {
        let record = record(Kind::Random);
        let trace = Trace::new(&record, &table()[0].base);
        let delay: (&str, &[f64]) = (DELAY, &[0.004]);
        for effect in [("gain_drift", &[0.01][..]), ("backlash", &[0.1]), ("structural_mode", &[12.0, 0.03, 0.2])] {
            let (space, model) = with(&[delay, effect]);
            let [by_gain, by_delay] = errors(&trace, &space, &model);
            assert!(by_gain.unwrap() < 2e-3 && by_delay.is_none(), "{effect:?}: {by_gain:?} {by_delay:?}");
        }
        // A bias of the sensor scales with nothing.
        let (space, mut model) = with(&[delay]);
        model.effects = model.effects.with(find("sensor_bias").unwrap(), &[0.1, 0.0]).unwrap();
        let simulated = trace.simulated_while(&model, false, |_, _| true).unwrap();
        assert!(!Similarity::of(&space, &space.start(), &model, &trace, &simulated).gives(0));
    }
}
