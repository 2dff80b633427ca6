//! A command that is delayed, over the steps of a record.

use super::Trace;
use crate::signal::sampling::Sampling;
use actuator_fmu::transition::Ramp;

impl Trace<'_> {
    /// A command delayed [s] on an even clock, over each step: its line up to a share of the step, that share, and its line from there on; before the
    /// record it is at rest.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of samples
    pub(super) fn delayed_pieces(&self, delay_s: f64, rest: f64) -> impl Iterator<Item = (Ramp, f64, Ramp)> {
        let interval_s = self.record.sampling().interval_s();
        let (whole, share) = divided(delay_s / interval_s);
        let from = whole as usize;
        let line = move |n: Option<usize>| n.map_or(Ramp::held(rest), |n| self.steps[n].inputs.command);
        (0..self.steps.len()).map(move |n| {
            let (before, after) = (line(n.checked_sub(from + 1)), line(n.checked_sub(from)));
            let before = Ramp { value: before.at((1.0 - share) * interval_s), ..before };
            (before, share, after)
        })
    }

    /// Whether a delay acts on average over each step.
    pub fn averages_delay(&self) -> bool {
        self.averages_delay
    }

    /// Share of a step by which a delay exceeds whole steps; none on an uneven clock, where it differs from step to step.
    pub fn share_of_step(&self, delay_s: f64) -> Option<f64> {
        let Sampling::Even(interval_s) = self.record.sampling() else { return None };
        Some(divided(delay_s / interval_s).1)
    }

    /// Mean of a held command over each step, delayed [s].
    ///
    /// ```text
    /// c'[n] = (A(t[n+1] - T) - A(t[n] - T)) / (t[n+1] - t[n]),    A the integral of the command
    /// ```
    pub(super) fn delayed_command(&self, delay_s: f64) -> Vec<f64> {
        match self.record.sampling() {
            Sampling::Even(_) => {
                let pieces = self.delayed_pieces(delay_s, self.record.command()[0]);
                pieces.map(|(before, share, after)| after.value + share * (before.value - after.value)).collect()
            }
            Sampling::Uneven(_) => self.delayed_over_steps(delay_s),
        }
    }

    /// The same on any clock.
    fn delayed_over_steps(&self, delay_s: f64) -> Vec<f64> {
        let (time, command) = (self.record.time(), self.record.command());
        let mut place = 0;
        let mut area_before = 0.0;
        let mut area = |at: f64| -> f64 {
            if at <= time[0] {
                return command[0] * (at - time[0]);
            }
            while place + 1 < time.len() && time[place + 1] <= at {
                area_before += command[place] * (time[place + 1] - time[place]);
                place += 1;
            }
            area_before + command[place] * (at - time[place])
        };
        let mut last = area(time[0] - delay_s);
        time.windows(2)
            .map(|pair| {
                let next = area(pair[1] - delay_s);
                let mean = (next - last) / (pair[1] - pair[0]);
                last = next;
                mean
            })
            .collect()
    }
}

/// Whole steps of a delay, and the share of one more.
fn divided(steps: f64) -> (f64, f64) {
    /// Share of a step below which it is rounding.
    const NO_SHARE: f64 = 1e-9;
    let whole = (steps + NO_SHARE).floor();
    (whole, if steps - whole < NO_SHARE { 0.0 } else { steps - whole })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::trace::APPROXIMATION,
        generated::TestPoint,
        signal::{
            Interpolation,
            excitation::{Excitation, Kind},
            record::Record,
        },
    };
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Model, table},
    };

    fn sweep(interpolation: Interpolation) -> Record {
        let point = TestPoint {
            model: Model::from_set(&table()[0]),
            excitation: Excitation { duration_s: 2.0, ..Excitation::new(Kind::Sweep) },
            interpolation,
            noise_share: 0.0,
            turbulence: None,
            seed: 1,
        };
        point.record("record").unwrap()
    }

    #[test]
    fn a_command_delayed_on_an_even_clock_is_that_of_any_clock() {
        let record = sweep(Interpolation::Held);
        let trace = Trace::new(&record, &table()[0].base);
        let interval_s = record.sampling().interval_s();
        for steps in [0.0, 0.3, 1.0, 7.75, 5000.0] {
            let (even, any) = (trace.delayed_command(steps * interval_s), trace.delayed_over_steps(steps * interval_s));
            assert_eq!(even.len(), any.len());
            assert!(even.iter().zip(&any).all(|(even, any)| (even - any).abs() < 1e-9), "{steps}");
        }
    }

    #[test]
    fn a_search_moves_under_a_delay_as_the_fmu_does() {
        let with = |effects: &[(&str, &[f64])]| {
            let add = |all: Effects, (name, values): &(&str, &[f64])| all.with(find(name).unwrap(), values).unwrap();
            Model { effects: effects.iter().fold(Effects::default(), add), ..Model::from_set(&table()[0]) }
        };
        let others: [&[(&str, &[f64])]; 4] = [
            &[],
            &[("coulomb_friction", &[2000.0])],
            &[("command_rate_limit", &[20.0, 30.0]), ("structural_mode", &[12.0, 0.03, 0.2])],
            &[("backlash", &[0.4]), ("hinge_load", &[0.1, 0.2])],
        ];
        let records = [Interpolation::Held, Interpolation::Linear].map(sweep);
        for (others, record) in others.iter().flat_map(|others| records.iter().map(move |record| (others, record))) {
            let interval_s = record.sampling().interval_s();
            for steps in [0.4, 1.0, 3.7] {
                let delay = [steps * interval_s];
                let all: Vec<(&str, &[f64])> = others.iter().copied().chain([("delay", delay.as_slice())]).collect();
                let (model, trace) = (with(&all), Trace::new(record, &table()[0].base));
                let (search, exact) = (trace.position(&model).unwrap(), trace.exact().position(&model).unwrap());
                let largest = search.iter().zip(&exact).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
                assert!(largest < APPROXIMATION, "{all:?}: {largest}");
            }
        }
    }
}
