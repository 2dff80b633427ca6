//! The position that a model would have had in a record: exact for held and linear commands at any sampling.

use nalgebra::Vector3;

use crate::{
    frequency::sampled::Sampled,
    parameters::{Base, Order},
    signal::record::{Record, Sampling},
    transition::{Ramp, Transition},
};

/// A model with a delay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delayed {
    /// k, p, ω, ζ.
    pub base: Base,
    /// Second or third.
    pub order: Order,
    /// Between command and actuator [s].
    pub delay_s: f64,
}

/// A record, ready to be simulated many times.
pub struct Drive<'a> {
    record: &'a Record,
    interval: Option<f64>,
}

/// State where a record begins, beyond rest under its first command: (x, δ, v).
pub type Start = Vector3<f64>;

impl<'a> Drive<'a> {
    /// Of a record.
    pub fn new(record: &'a Record) -> Self {
        let interval = match record.sampling() {
            Sampling::Even(interval) => Some(interval),
            Sampling::Uneven(_) => None,
        };
        Self { record, interval }
    }

    /// Position at the samples, from rest under the first command plus `start`.
    pub fn position(&self, model: &Delayed, start: Start) -> Vec<f64> {
        let rest = model.base.k() * self.record.command()[0];
        let state = Vector3::new(rest, rest, 0.0) + start;
        match self.interval {
            Some(interval) => self.evenly(model, interval, state),
            None => self.unevenly(model, state),
        }
    }

    /// Position after a start from 1 in one component of the state, without command, until nothing is left of it.
    pub fn free(&self, model: &Delayed, component: usize) -> Vec<f64> {
        // Of the size of one; below this no sum over a record notices it.
        const NOTHING: f64 = 1e-13;
        let mut state = Vector3::ith(component, 1.0);
        let mut positions = vec![state.y];
        let mut known: Option<Transition> = None;
        let times = self.record.time();
        for pair in times.windows(2) {
            let duration = self.interval.unwrap_or(pair[1] - pair[0]);
            let transition = match &known {
                Some(transition) if transition.duration() == duration => transition,
                _ => known.insert(Transition::new(model.base, model.order, duration)),
            };
            state = transition.apply(state, Ramp::default());
            positions.push(state.y);
            if state.x.abs() + state.y.abs() + (state.z / model.base.omega()).abs() < NOTHING {
                break;
            }
        }
        positions
    }

    fn evenly(&self, model: &Delayed, interval: f64, start: Vector3<f64>) -> Vec<f64> {
        let command = self.record.command();
        let plant = Sampled::new(model.base, model.order, model.delay_s, self.record.interpolation(), interval);
        let count = command.len();
        // Before the record the command was its first value; the taps reach one sample ahead of the lag.
        let lag = plant.lag.min(count);
        let padded: Vec<f64> = std::iter::repeat_n(command[0], lag + 1)
            .chain(command.iter().copied())
            .chain([command[count - 1]])
            .collect();
        let m = plant.free;
        let [b0, b1, b2] = plant.taps;
        let (mut x, mut position, mut rate) = (start.x, start.y, start.z);
        let mut positions = Vec::with_capacity(count);
        positions.push(position);
        for taps in padded.windows(3).take(count - 1) {
            let drive = b0 * taps[0] + b1 * taps[1] + b2 * taps[2];
            let next_position = m[(1, 0)] * x + m[(1, 1)] * position + m[(1, 2)] * rate + drive.y;
            rate = m[(2, 0)] * x + m[(2, 1)] * position + m[(2, 2)] * rate + drive.z;
            x = m[(0, 0)] * x + drive.x;
            position = next_position;
            positions.push(position);
        }
        positions
    }

    fn unevenly(&self, model: &Delayed, start: Vector3<f64>) -> Vec<f64> {
        let mut state = start;
        let mut positions = Vec::with_capacity(self.record.len());
        positions.push(state.y);
        let mut delayed = DelayedSteps::new(self.record, model.delay_s);
        for pair in self.record.time().windows(2) {
            let mut now = pair[0];
            while now < pair[1] {
                let (command, until) = delayed.piece(now);
                let end = until.min(pair[1]);
                state = Transition::new(model.base, model.order, end - now).apply(state, command);
                now = end;
            }
            positions.push(state.y);
        }
        positions
    }
}

/// A command, later: which piece of it acts at a time, and until when.
struct DelayedSteps<'a> {
    time: &'a [f64],
    steps: Vec<Ramp>,
    delay: f64,
    first: f64,
    at: usize,
}

impl<'a> DelayedSteps<'a> {
    fn new(record: &'a Record, delay: f64) -> Self {
        let steps = record.steps().map(|step| step.command).collect();
        Self { time: record.time(), steps, delay, first: record.command()[0], at: 0 }
    }

    /// Times asked for must not fall.
    fn piece(&mut self, now: f64) -> (Ramp, f64) {
        let start = |step: usize| self.time[step] + self.delay;
        if now < start(0) {
            return (Ramp::held(self.first), start(0));
        }
        let last = self.steps.len() - 1;
        let mut at = self.at;
        while at < last && start(at + 1) <= now {
            at += 1;
        }
        let step = self.steps[at];
        let piece = Ramp { value: step.at(now - start(at)), slope: step.slope };
        let until = if at == last { f64::INFINITY } else { start(at + 1) };
        self.at = at;
        (piece, until)
    }
}
