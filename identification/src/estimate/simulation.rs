//! The modelled position in a record: exact for held and linear commands at any sampling.

use nalgebra::Vector3;

use crate::{
    frequency::{DelayedModel, sampled::Sampled},
    progress::Work,
    signal::{delayed, record::Record, sampling::Sampling},
};
use actuator_fmu::transition::{Ramp, Transition};

/// A record prepared for many simulations.
pub struct Simulator<'a> {
    record: &'a Record,
    interval: Option<f64>,
    /// Progress counter.
    work: Option<&'a Work<'a>>,
}

/// Start state of a record relative to rest under its first command: (x, δ, v).
pub type Start = Vector3<f64>;

impl<'a> Simulator<'a> {
    /// For a record.
    pub fn new(record: &'a Record) -> Self {
        let interval = match record.sampling() {
            Sampling::Even(interval) => Some(interval),
            Sampling::Uneven(_) => None,
        };
        Self { record, interval, work: None }
    }

    /// With simulations counted as part of a search.
    pub(crate) fn part_of(self, work: &'a Work<'a>) -> Self {
        Self { work: Some(work), ..self }
    }

    /// Counts this many simulated positions.
    fn count(&self, positions: usize) {
        if let Some(work) = self.work {
            work.add(positions * self.record.len());
        }
    }

    /// Position at the samples, from rest under the first command plus `start`.
    pub fn position(&self, model: &DelayedModel, start: Start) -> Vec<f64> {
        self.count(1);
        let rest = model.base.k() * self.record.command()[0];
        let state = Vector3::new(rest, rest, 0.0) + start;
        match self.interval {
            Some(interval) => self.evenly(model, interval, state),
            None => self.unevenly(model, state),
        }
    }

    /// Position at the samples for several similar models, from the same start.
    pub fn positions(&self, models: &[DelayedModel], start: Start) -> Vec<Vec<f64>> {
        let Some(interval) = self.interval else {
            return models.iter().map(|model| self.position(model, start)).collect();
        };
        let plants: Vec<Sampled> = models.iter().map(|model| self.plant(model, interval)).collect();
        if plants.iter().any(|plant| plant.lag != plants[0].lag) {
            return models.iter().map(|model| self.position(model, start)).collect();
        }
        self.count(models.len());
        let first = |model: &DelayedModel| {
            let rest = model.base.k() * self.record.command()[0];
            Vector3::new(rest, rest, 0.0) + start
        };
        let starts: Vec<Vector3<f64>> = models.iter().map(first).collect();
        let each = plants.chunks(LANES).zip(starts.chunks(LANES));
        each.flat_map(|(plants, starts)| side_by_side(plants, starts, &self.padded(plants[0].lag))).collect()
    }

    /// Position after a start from 1 in one component of the state, without command, until it has decayed.
    pub fn free(&self, model: &DelayedModel, component: usize) -> Vec<f64> {
        // Relative to one; below this it does not affect any sum over a record.
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

    fn plant(&self, model: &DelayedModel, interval: f64) -> Sampled {
        Sampled::new(model.base, model.order, model.delay_s, self.record.interpolation(), interval)
    }

    /// The command delayed by `lag` samples, with one earlier value, for three taps at each sample.
    fn padded(&self, lag: usize) -> Vec<f64> {
        let command = self.record.command();
        std::iter::once(command[0]).chain(delayed(command, lag)).collect()
    }

    fn evenly(&self, model: &DelayedModel, interval: f64, start: Vector3<f64>) -> Vec<f64> {
        let plant = self.plant(model, interval);
        let m = plant.free;
        let [b0, b1, b2] = plant.taps;
        let (mut x, mut position, mut rate) = (start.x, start.y, start.z);
        let padded = self.padded(plant.lag);
        let mut positions = Vec::with_capacity(padded.len());
        positions.push(position);
        for taps in padded.windows(3) {
            let drive = b0 * taps[0] + b1 * taps[1] + b2 * taps[2];
            let next_position = m[(1, 0)] * x + m[(1, 1)] * position + m[(1, 2)] * rate + drive.y;
            rate = m[(2, 0)] * x + m[(2, 1)] * position + m[(2, 2)] * rate + drive.z;
            x = m[(0, 0)] * x + drive.x;
            position = next_position;
            positions.push(position);
        }
        positions
    }

    fn unevenly(&self, model: &DelayedModel, start: Vector3<f64>) -> Vec<f64> {
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

/// Number of models that are stepped together: each step waits for the previous one, so that several cost little more than one.
pub const LANES: usize = 8;

/// The recurrence for up to [`LANES`] models of one lag.
fn side_by_side(plants: &[Sampled], starts: &[Vector3<f64>], padded: &[f64]) -> Vec<Vec<f64>> {
    // Lanes without a model stay zero.
    let lane = |value: &dyn Fn(&Sampled) -> f64| -> [f64; LANES] {
        std::array::from_fn(|lane| plants.get(lane).map_or(0.0, value))
    };
    let free: [[f64; LANES]; 7] =
        [(0, 0), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2)].map(|place| lane(&|plant| plant.free[place]));
    let taps: [[[f64; LANES]; 3]; 3] = [0, 1, 2].map(|tap| [0, 1, 2].map(|row| lane(&|plant| plant.taps[tap][row])));
    let of_start =
        |row: usize| -> [f64; LANES] { std::array::from_fn(|lane| starts.get(lane).map_or(0.0, |start| start[row])) };
    let (mut x, mut position, mut rate) = (of_start(0), of_start(1), of_start(2));
    let mut positions: Vec<Vec<f64>> = starts.iter().map(|_| Vec::with_capacity(padded.len())).collect();
    let store = |positions: &mut Vec<Vec<f64>>, now: &[f64; LANES]| {
        positions.iter_mut().zip(now).for_each(|(column, value)| column.push(*value));
    };
    store(&mut positions, &position);
    for command in padded.windows(3) {
        let drive = |row: usize, lane: usize| {
            taps[0][row][lane] * command[0] + taps[1][row][lane] * command[1] + taps[2][row][lane] * command[2]
        };
        for lane in 0..LANES {
            let (x0, position0, rate0) = (x[lane], position[lane], rate[lane]);
            x[lane] = free[0][lane] * x0 + drive(0, lane);
            position[lane] = free[1][lane] * x0 + free[2][lane] * position0 + free[3][lane] * rate0 + drive(1, lane);
            rate[lane] = free[4][lane] * x0 + free[5][lane] * position0 + free[6][lane] * rate0 + drive(2, lane);
        }
        store(&mut positions, &position);
    }
    positions
}

/// A delayed command: the piece that acts at a time, and its end.
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

    /// Requested times must not decrease.
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
