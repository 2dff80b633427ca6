//! The solution over one segment: pole, drive and output effects as series, up to the first event.

use super::{
    constants::Actuator,
    signals::{Failure, Inputs},
    state::State,
};
use crate::{
    command::EffectInputs,
    effects::{OUTPUT_EFFECTS, UNLIMITED},
    error::{Error, Result},
    motion::{DriveOperation, DriveState, Event, Forcing, Motion},
    operator::{FAST_POLE_RATIO, Piece, Segment, SegmentResponse},
    parameters::Order,
    series::{Decay, RECIPROCAL, Series, TERMS},
    transition::Ramp,
};

/// Instants are equal within this share of a step.
const TIME_RESOLUTION: f64 = 1e-14;

/// As above in [s], at least the rounding of the time, for a step that starts at `start` [s].
#[inline]
pub(super) fn time_resolution(duration: f64, start: f64) -> f64 {
    (TIME_RESOLUTION * duration).max(4.0 * f64::EPSILON * start.abs())
}

/// Relative tolerance of positions in a segment: about 500 roundings.
const ROUNDING: f64 = 1e-13;

/// A series has converged when its last terms are below this share of its largest: about four roundings.
const CONVERGENCE_TOLERANCE: f64 = 1e-15;

/// Positions [deg] and rates [deg/s] below this are treated as 0, which keeps the coefficients of their series out of the subnormal range.
const DECAYED: f64 = 1e-250;

/// Maximum position [deg] in a step with effects: the cube of a larger one would overflow.
const LARGEST_POSITION: f64 = 1e60;

/// Maximum number of halvings of a segment for a series to converge; beyond it the motion is considered divergent.
const MAX_HALVINGS: u32 = 40;

/// Inputs from one instant on.
pub(super) struct SegmentInputs {
    /// Command behind its effects, as long as this piece lasts.
    pub command: Piece,
    pub load: Ramp,
    pub failure: Failure,
    /// Time since the start [s].
    pub time: f64,
}

/// The solution over one segment. It is filled in place, since series are large to copy.
#[derive(Debug, Clone)]
pub(super) struct SegmentSolution {
    pub segment: Segment,
    pole: Series,
    motion: Motion,
    /// The event of the drive that ends the segment.
    event: Option<Event>,
    /// Response of each active output effect.
    responses: [SegmentResponse; OUTPUT_EFFECTS],
    active: usize,
}

impl Default for SegmentSolution {
    fn default() -> Self {
        let segment = Segment { length: 0.0, largest_pole: 0.0, terms: 0, negligible: 0.0, tolerance: 0.0, until: 1.0 };
        Self {
            segment,
            pole: Series::polynomial(&[0.0]),
            motion: Motion::default(),
            event: None,
            responses: [Series::polynomial(&[0.0]).into(); OUTPUT_EFFECTS],
            active: 0,
        }
    }
}

impl Actuator {
    /// Solves the next segment, no longer than the command piece; returns the number of lengths tried.
    pub(super) fn solve_segment(
        &self,
        state: &State,
        inputs: &SegmentInputs,
        solution: &mut SegmentSolution,
    ) -> Result<u32> {
        // Only the cubic spring makes it depend on position.
        let of_position = if self.terms.cubic == 0.0 { 0.0 } else { self.terms.pole(state.position) };
        let largest_pole = self.largest_pole.max(of_position);
        // Equal segments, as few as the series allows.
        let whole = inputs.command.length;
        let ratio = whole * largest_pole / self.accuracy.longest;
        let mut length = if ratio > 1.0 { whole / ratio.ceil() } else { whole };
        let halvings = if self.terms.diverges(state.position) { 0 } else { MAX_HALVINGS };
        for halved in 0..halvings {
            self.solve_for_length(state, inputs, length, largest_pole, solution)?;
            if self.terms.cubic == 0.0
                || solution.motion.truncation() < CONVERGENCE_TOLERANCE.max(self.accuracy.negligible)
            {
                return Ok(halved + 1);
            }
            length *= 0.5;
        }
        let found = format!("a surface that runs away from position {:.3e}", state.position);
        Err(Error::new("motion in this step", found, "a stable actuator")
            .remedy("a negative amplitude_gain.cubic has no equilibrium at large commands"))
    }

    /// Solves a segment of this length. Not inlined: the compiler would otherwise keep length-independent values in memory for a further
    /// iteration, which is rare.
    #[inline(never)]
    fn solve_for_length(
        &self,
        state: &State,
        inputs: &SegmentInputs,
        length: f64,
        largest_pole: f64,
        solution: &mut SegmentSolution,
    ) -> Result<()> {
        let SegmentInputs { command, load, failure, time } = inputs;
        let SegmentSolution { segment, pole, motion, event, responses, active } = solution;
        let terms = &self.terms;
        let linear = self.accuracy.terms_needed(largest_pole * length);
        self.pole(state.pole, self.command.demand(*command, *time, length), length, linear, pole);
        let stop;
        let (target, operation) = match failure {
            Failure::None => (&*pole, DriveOperation::Active),
            Failure::Passive => (&*pole, DriveOperation::Passive),
            Failure::Stuck => (&*pole, DriveOperation::Stuck),
            Failure::HardoverPositive | Failure::HardoverNegative => {
                let positive = *failure == Failure::HardoverPositive;
                let limit = if positive { terms.max.min(UNLIMITED) } else { terms.min.max(-UNLIMITED) };
                stop = Series::polynomial(&[limit]);
                (&stop, DriveOperation::Active)
            }
        };
        let forcing = Forcing { target, load: [load.value, load.slope * length], operation };
        let from = terms.clamped_to_limits(DriveState { position: state.position, rate: state.rate });
        let (low, high) = target.bounds();
        let size = from.position.abs() + (from.rate * length).abs() + low.abs().max(high.abs()) + load.value.abs();
        if size.is_nan() || size > LARGEST_POSITION {
            return Err(too_large(state, size));
        }
        let tolerance = ROUNDING * size;
        // The number of terms that the products of series in the cubic spring need is known only once they are formed.
        let count = if terms.cubic == 0.0 { linear } else { TERMS };
        let negligible = self.accuracy.negligible;
        *segment = Segment { length, largest_pole: self.largest_pole, terms: count, negligible, tolerance, until: 1.0 };
        *event = None;
        if let Some((tau, first)) = terms.motion(from, &forcing, *segment, motion) {
            (segment.until, *event) = (tau, Some(first));
        }
        *active = self.output_effects.len();
        for (index, effect) in self.output_effects.iter().enumerate() {
            let input = if index == 0 { &motion.position } else { &responses[index - 1].output };
            let memory = &state.memory[effect.memory..];
            let response = effect.operator.segment_response(&effect.parameters, memory, input, *segment);
            if let Some(tau) = response.valid_until.filter(|tau| *tau < segment.until) {
                (segment.until, *event) = (tau, None);
            }
            responses[index] = response;
        }
        Ok(())
    }

    /// Pole state: ẋ = p (demand - x), or x = demand for order 2.
    fn pole(&self, now: f64, demand: [f64; 3], length: f64, count: usize, pole: &mut Series) {
        *pole = Series::polynomial(&demand);
        if self.order == Order::Second {
            return;
        }
        let k = self.base.p() * length;
        if self.base.p() > FAST_POLE_RATIO * self.largest_pole {
            // Forced response x = demand - demand' / k + demand'' / k² plus the free response, a decay.
            let [q0, q1, q2] = demand;
            pole.terms[1] = q1 - 2.0 * q2 / k;
            pole.terms[0] = q0 - pole.terms[1] / k;
            pole.decays[0] = Decay { amplitude: now - pole.terms[0], exponent: k };
            return;
        }
        pole.terms[0] = now;
        let mut next = demand[0];
        for n in 0..count - 1 {
            let forced = next;
            next = demand.get(n + 1).copied().unwrap_or(0.0);
            pole.terms[n + 1] = k * RECIPROCAL[n + 1] * (forced - pole.terms[n]);
        }
        pole.length = count;
    }

    /// Advances the state to τ of the segment, where this event occurs.
    pub(super) fn advance(&self, state: &mut State, solution: &SegmentSolution, tau: f64, event: Option<Event>) {
        let SegmentSolution { segment, pole, motion, responses, .. } = solution;
        state.pole = pole.at(tau);
        let drive = motion.at(tau, event, segment.length);
        (state.position, state.rate) = (drive.position, drive.rate);
        state.saturated = motion.saturated;
        let mut input = &motion.position;
        for (effect, SegmentResponse { output, .. }) in self.output_effects.iter().zip(responses) {
            let memory = &mut state.memory[effect.memory..];
            effect.operator.advance(&effect.parameters, memory, input, output, *segment, tau);
            input = output;
        }
        // Decayed motion is set to rest: subnormal numbers would slow down every later segment.
        let settled = |number: f64| if number.abs() < DECAYED { 0.0 } else { number };
        (state.pole, state.position, state.rate) = (settled(state.pole), settled(state.position), settled(state.rate));
        // Read one by one, as they were written: a wide load after narrow stores would stall.
        for number in &mut state.memory {
            if number.abs() < DECAYED {
                *number = 0.0;
            }
        }
    }

    /// Derivatives of position, deflection [deg/s] and rate [deg/s²] under these inputs.
    ///
    /// # Errors
    /// A divergent motion.
    pub fn slopes(&self, state: &State, inputs: Inputs) -> Result<[f64; 3]> {
        let Inputs { command, load, failure } = inputs;
        let length = 0.1 * self.accuracy.longest / self.largest_pole;
        let time_resolution = TIME_RESOLUTION * length;
        let now = Piece { value: command.value, slope: command.slope, length, time_resolution };
        let past = state.history.with(state.history.change(state.time, now));
        let command = self.command.pieces(past, &state.memory, state.time, now, &mut EffectInputs::default());
        let inputs = SegmentInputs { command: Piece { length, ..command }, load, failure, time: state.time };
        let mut solution = SegmentSolution::default();
        self.solve_segment(state, &inputs, &mut solution)?;
        let SegmentSolution { segment, motion, responses, .. } = solution;
        let rate = motion.position.derivative().scaled(1.0 / segment.length);
        let now = motion.rate_at_start(state.rate);
        let (mut deflection, mut position) = (now, now);
        for (effect, response) in self.output_effects.iter().zip(&responses) {
            position = response.output.slope_at_start() / segment.length;
            if !effect.is_sensor {
                deflection = position;
            }
        }
        position +=
            self.measurement_effects.iter().map(|effect| (effect.slope)(&effect.parameters, state.time)).sum::<f64>();
        Ok([position, deflection, rate.slope_at_start() / segment.length])
    }
}

#[cold]
fn too_large(state: &State, size: f64) -> Error {
    let found = format!("{size:.3e}, from a position of {} at a rate of {}", state.position, state.rate);
    Error::new("motion in this step", found, format!("finite numbers up to {LARGEST_POSITION:e}"))
}

impl SegmentSolution {
    /// τ of the first event, with the event if it is one of the drive; 1 if there is no event.
    pub fn end(&self) -> (f64, Option<Event>) {
        (self.segment.until, self.event)
    }
}
