//! The motion of the drive over one segment in one mode, as a series, and the event that ends it.

use super::{
    forcing::Forcing,
    loop_terms::{DriveState, LoopTerms},
    mode::{MotionMode, ServoBranch},
};
use crate::{
    operator::Segment,
    series::{Decay, RECIPROCAL, Range, Series, Side, TERMS},
};

/// The motion over a segment.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// δ
    pub position: Series,
    /// A limit of rate, acceleration or position is active.
    pub saturated: bool,
    mode: MotionMode,
    branch: ServoBranch,
}

/// The event that ends a mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// Another branch or mode of motion, with a continuous state.
    Switch,
    /// The rate reaches this value [deg/s].
    Rate(f64),
    /// The surface reaches the stop at this position [deg]; the rate becomes 0.
    Stop(f64),
}

impl LoopTerms {
    /// Sum of all forces but friction over a motion at constant rate.
    fn force(&self, branch: ServoBranch, forcing: &Forcing, position: &Series, length: f64) -> Series {
        let mut force = forcing.target.scaled(self.omega2 * branch.gain);
        force.length = force.length.max(4);
        let [a, b] = [position.terms[0], position.terms[1]];
        let (stiffness, cubic) = (branch.gain + self.stiffness, self.cubic);
        force.terms[0] +=
            self.omega2 * (branch.offset + self.bias + forcing.load[0] - stiffness * a - cubic * a * a * a);
        force.terms[0] -= self.damping / length * b;
        force.terms[1] += self.omega2 * (forcing.load[1] - stiffness * b - 3.0 * cubic * a * a * b);
        force.terms[2] -= self.omega2 * 3.0 * cubic * a * b * b;
        force.terms[3] -= self.omega2 * cubic * b * b * b;
        force
    }

    /// Computes the motion from this state; returns its first event in the segment, by τ.
    pub fn motion(
        &self,
        from: DriveState,
        forcing: &Forcing,
        segment: Segment,
        motion: &mut Motion,
    ) -> Option<(f64, Event)> {
        let branch = self.servo_branch(forcing.target.start() - from.position, forcing.operation);
        let at_constant_rate = |rate: f64| Series::polynomial(&[from.position, rate * segment.length]);
        let force = self.instantaneous_force(branch, forcing.target.start(), forcing.load[0], from);
        let mode = self.motion_mode(from, force, forcing.operation);
        let position = match mode {
            MotionMode::Free(direction) => self.free(from, branch, direction, forcing, segment),
            MotionMode::RateLimited(rate) => at_constant_rate(rate),
            MotionMode::Sticking | MotionMode::AtStop(_) | MotionMode::Stuck => at_constant_rate(0.0),
        };
        *motion = Motion { position, saturated: mode.is_at_limit() || branch.saturated, mode, branch };
        self.first_event(motion, forcing, segment)
    }

    /// Free motion: (n+1)(n+2) a_{n+2} = h² (forces)_n - 2ζω h (n+1) a_{n+1}; a decay of the target gives a decay of the position,
    /// which is subtracted from the start values of the recurrence.
    fn free(
        &self,
        from: DriveState,
        branch: ServoBranch,
        direction: f64,
        forcing: &Forcing,
        segment: Segment,
    ) -> Series {
        let Segment { length, terms, .. } = segment;
        let h2 = self.omega2 * length * length;
        let damping = self.damping * length;
        let Decay { amplitude, exponent: k } = forcing.target.decays[0];
        // During the short decay the cubic spring is linearized at the start position.
        let local = branch.gain + self.stiffness + 3.0 * self.cubic * from.position * from.position;
        let amplitude =
            if amplitude == 0.0 { 0.0 } else { h2 * branch.gain * amplitude / (k * k - damping * k + h2 * local) };

        let mut a = [0.0; TERMS];
        a[0] = from.position - amplitude;
        a[1] = from.rate * length + k * amplitude;
        let stiffness = branch.gain + self.stiffness;
        let mut forced = forcing.target.terms.map(|term| branch.gain * term);
        forced[0] += branch.offset + self.bias + forcing.load[0] - direction * self.friction;
        forced[1] += forcing.load[1];
        let mut square = [0.0; TERMS];
        for n in 0..terms.min(TERMS) - 2 {
            if self.cubic != 0.0 {
                square[n] = product(&a, &a, n);
                forced[n] -= self.cubic * product(&a, &square, n);
            }
            let (one, two) = (RECIPROCAL[n + 1], RECIPROCAL[n + 2]);
            a[n + 2] = two * (h2 * one * (forced[n] - stiffness * a[n]) - damping * a[n + 1]);
        }
        let mut series = Series { terms: a, length: terms, decays: [Decay::default(); 2] };
        series.decays[0] = Decay { amplitude, exponent: k };
        series
    }

    fn first_event(&self, motion: &Motion, forcing: &Forcing, segment: Segment) -> Option<(f64, Event)> {
        let Motion { position, mode, branch, .. } = motion;
        let mut first: Option<(f64, Event)> = None;
        let mut consider = |left: &dyn Fn(f64) -> Option<(f64, Side)>, above: Event, below: Event| {
            let until = first.map_or(1.0, |(earlier, _)| earlier);
            if let Some((tau, side)) = left(until).filter(|(tau, _)| first.is_none_or(|_| *tau < until)) {
                first = Some((tau, if side == Side::Above { above } else { below }));
            }
        };
        let tolerance = segment.tolerance;
        let conditions = self.conditions(*branch, *mode);
        if conditions.error.is_bounded() {
            let error = forcing.target.plus(-1.0, position);
            consider(&|until| error.leaves(conditions.error, tolerance, until), Event::Switch, Event::Switch);
        }
        if conditions.position.is_bounded() {
            let leaves = |until| position.leaves(conditions.position, tolerance, until);
            consider(&leaves, Event::Stop(self.max), Event::Stop(self.min));
        }
        if conditions.force.is_bounded() {
            let force = self.force(*branch, forcing, position, segment.length);
            let leaves = |until| force.leaves(conditions.force, self.omega2 * tolerance, until);
            consider(&leaves, Event::Switch, Event::Switch);
        }
        if conditions.rate.is_bounded() {
            // Times the length of the segment a rate becomes a difference of positions, to which the tolerance applies.
            let Range { low, high } = conditions.rate;
            let rates = Range { low: low * segment.length, high: high * segment.length };
            let leaves = |until| position.derivative_leaves(rates, tolerance, until);
            consider(&leaves, Event::Rate(high), Event::Rate(low));
        }
        first
    }
}

/// Coefficient n of a product of series.
fn product(a: &[f64; TERMS], b: &[f64; TERMS], n: usize) -> f64 {
    a[..=n].iter().zip(b[..=n].iter().rev()).map(|(a, b)| a * b).sum()
}

impl Default for Motion {
    /// At rest at 0.
    fn default() -> Self {
        let none = f64::INFINITY;
        let branch = ServoBranch { gain: 0.0, offset: 0.0, low: -none, high: none, saturated: false };
        Self { position: Series::polynomial(&[0.0]), saturated: false, mode: MotionMode::Stuck, branch }
    }
}

impl Motion {
    /// State at τ, with the exact values that the event there sets.
    #[must_use]
    pub fn at(&self, tau: f64, event: Option<Event>, length: f64) -> DriveState {
        let position = self.position.at(tau);
        let rate = match self.mode {
            MotionMode::Free(_) => self.position.slope_at(tau) / length,
            MotionMode::RateLimited(rate) => rate,
            MotionMode::Sticking | MotionMode::AtStop(_) | MotionMode::Stuck => 0.0,
        };
        match event {
            Some(Event::Rate(rate)) => DriveState { position, rate },
            Some(Event::Stop(position)) => DriveState { position, rate: 0.0 },
            Some(Event::Switch) | None => DriveState { position, rate },
        }
    }

    /// The rate at the start of the segment, for this rate before it [deg/s].
    #[must_use]
    pub fn rate_at_start(&self, rate: f64) -> f64 {
        match self.mode {
            MotionMode::Free(_) => rate,
            MotionMode::RateLimited(limit) => limit,
            MotionMode::Sticking | MotionMode::AtStop(_) | MotionMode::Stuck => 0.0,
        }
    }

    /// Magnitude of the last two coefficients relative to the largest: an estimate of the truncation error.
    #[must_use]
    pub fn truncation(&self) -> f64 {
        let terms = &self.position.terms;
        let size = terms.iter().map(|term| term.abs()).fold(f64::MIN_POSITIVE, f64::max);
        (terms[TERMS - 1].abs() + terms[TERMS - 2].abs()) / size
    }
}
