//! The motion of the drive over one segment in one mode, as a series, and the event that ends it.

use super::{
    forcing::Forcing,
    loop_terms::{DriveState, LoopTerms},
    mode::{MotionMode, ServoBranch},
};
use crate::{
    operator::Segment,
    series::{Decay, FACTORIAL, INVERSE_FACTORIAL, RECIPROCAL, Range, Series, Side, TERMS},
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
    /// A change of branch or motion mode, with a continuous state.
    Switch,
    /// The rate reaches this value [deg/s].
    Rate(f64),
    /// The surface reaches the stop at this position \[deg\]; the rate becomes 0.
    Stop(f64),
}

impl LoopTerms {
    /// Sum of all forces but friction over a motion at constant rate.
    fn force(&self, branch: ServoBranch, forcing: &Forcing, position: &Series, length: f64) -> Series {
        let factor = self.omega2 * branch.gain;
        let mut force = if forcing.target.length <= 4 {
            let mut force = Series::polynomial(&[0, 1, 2, 3].map(|n| factor * forcing.target.terms[n]));
            force.decays = forcing.target.decays.map(|decay| Decay { amplitude: factor * decay.amplitude, ..decay });
            force
        } else {
            forcing.target.scaled(factor)
        };
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

    /// Computes the motion from this state; returns the τ of its first event in the segment.
    pub fn motion(
        &self,
        from: DriveState,
        forcing: &Forcing,
        segment: Segment,
        motion: &mut Motion,
    ) -> Option<(f64, Event)> {
        let branch = self.servo_branch(forcing.target.start() - from.position, forcing.operation);
        let force = self.instantaneous_force(&branch, forcing.target.start(), forcing.load[0], &from);
        let mode = self.motion_mode(&from, force, forcing.operation);
        // Filled in place, since series are large to copy.
        match mode {
            MotionMode::Free(direction) => self.free(from, branch, direction, forcing, segment, &mut motion.position),
            _ => motion.position = Series::polynomial(&[from.position, mode.held_rate() * segment.length]),
        }
        (motion.saturated, motion.mode, motion.branch) = (mode.is_at_limit() || branch.saturated, mode, branch);
        self.first_event(motion, forcing, segment)
    }

    /// Free motion; a decay of the target causes a decay of the position, which is subtracted from the start values.
    fn free(
        &self,
        from: DriveState,
        branch: ServoBranch,
        direction: f64,
        forcing: &Forcing,
        segment: Segment,
        position: &mut Series,
    ) {
        let Segment { length, terms, negligible, .. } = segment;
        let h2 = self.omega2 * length * length;
        let damping = self.damping * length;
        let Decay { amplitude, exponent: k } = forcing.target.decays[0];
        let (gain, stiffness) = (branch.gain, branch.gain + self.stiffness);
        let particular = |mean_square: f64| {
            h2 * gain * amplitude / (k * k - damping * k + h2 * (stiffness + 3.0 * self.cubic * mean_square))
        };
        let without = |amplitude: f64| [from.position - amplitude, from.rate * length + k * amplitude];
        let amplitude = if amplitude == 0.0 {
            0.0
        } else if self.cubic == 0.0 {
            particular(0.0)
        } else {
            // The cubic spring is linearised during the short decay, with the impulse of the cubic one.
            let start = particular(from.position * from.position);
            particular(mean_square_of_decay(without(start), start, k))
        };
        position.decays = [Decay { amplitude, exponent: k }, Decay::default()];
        let start = without(amplitude);
        let constant = branch.offset + self.bias + forcing.load[0] - direction * self.friction;
        let forced =
            |n: usize| gain * forcing.target.terms[n] + [constant, forcing.load[1]].get(n).copied().unwrap_or(0.0);
        let count = terms.min(TERMS);
        let stiffness = h2 * stiffness;
        if self.cubic == 0.0 {
            // Number of coefficients of the forces, load included.
            let driven = forcing.target.length.max(2);
            position.length =
                linear(start, |n| h2 * forced(n), driven, [stiffness, damping], count, &mut position.terms);
        } else {
            let driven = forcing.target.length.max(2);
            let factors = [stiffness, damping, h2 * self.cubic];
            position.length = cubic(start, |n| h2 * forced(n), driven, factors, negligible, &mut position.terms);
        }
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
        let conditions = self.conditions(branch, *mode);
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
            // A rate times the segment length is a position difference, to which the tolerance applies.
            let Range { low, high } = conditions.rate;
            let rates = Range { low: low * segment.length, high: high * segment.length };
            let leaves = |until| position.derivative_leaves(rates, tolerance, until);
            consider(&leaves, Event::Rate(high), Event::Rate(low));
        }
        first
    }
}

/// Mean square of a position y = P + P' τ + A e^(-kτ): the y² in d(y³) = 3 y² d(A e^(-kτ)) that gives the same ∫ over the decay:
///
/// ```text
/// ∫ (y³ - (P + P' τ)³) dτ = 3 A/k (P² + 2 P P'/k + 2 P'²/k² + A (P/2 + P'/(4k)) + A²/9)
/// ```
fn mean_square_of_decay([position, slope]: [f64; 2], amplitude: f64, exponent: f64) -> f64 {
    let slope = slope / exponent;
    position * (position + 2.0 * slope)
        + 2.0 * slope * slope
        + amplitude * (0.5 * position + 0.25 * slope + amplitude / 9.0)
}

/// Coefficients of ÿ = f - P y - D ẏ from these start values, `count` of them or one more; returns how many. In terms of derivatives b_n =
/// n! a_n: b_{n+2} = n! f_n - P b_n - D b_{n+1}; from `driven` on, where f ends, two are computed from two at once.
fn linear(
    start: [f64; 2],
    force: impl Fn(usize) -> f64,
    driven: usize,
    [stiffness, damping]: [f64; 2],
    count: usize,
    into: &mut [f64; TERMS],
) -> usize {
    let [mut x, mut y] = start;
    let mut n = 0;
    *into = [0.0; TERMS];
    (into[0], into[1]) = (x, y);
    while n < driven && n + 2 < count {
        (x, y) = (y, FACTORIAL[n] * force(n) - stiffness * x - damping * y);
        into[n + 2] = INVERSE_FACTORIAL[n + 2] * y;
        n += 1;
    }
    let (by_x, by_y) = (damping * stiffness, damping * damping - stiffness);
    while n + 2 < count {
        (x, y) = (-stiffness * x - damping * y, by_x * x + by_y * y);
        into[n + 2] = INVERSE_FACTORIAL[n + 2] * x;
        if n + 3 < TERMS {
            into[n + 3] = INVERSE_FACTORIAL[n + 3] * y;
        }
        n += 2;
    }
    (n + 2).min(TERMS)
}

/// Coefficients of ÿ = f - P y - D ẏ - C y³ from these start values: all of them or, beyond the forces, until three in a row are negligible
/// (this fraction of the largest); returns how many.
fn cubic(
    start: [f64; 2],
    force: impl Fn(usize) -> f64,
    driven: usize,
    [stiffness, damping, cubic]: [f64; 3],
    negligible: f64,
    a: &mut [f64; TERMS],
) -> usize {
    let mut square = [0.0; TERMS];
    let mut size = start[0].abs().max(start[1].abs());
    *a = [0.0; TERMS];
    [a[0], a[1]] = start;
    // Unrolled, since loops of known length cost half as much.
    macro_rules! coefficients {
        ($($n:literal)*) => {$(
            square[$n] = square_term::<$n>(a);
            let forces = force($n) - cubic * product_term::<$n>(a, &square) - stiffness * a[$n];
            let next = RECIPROCAL[$n + 2] * (RECIPROCAL[$n + 1] * forces - damping * a[$n + 1]);
            a[$n + 2] = next;
            size = size.max(next.abs());
            if $n + 1 >= driven && a[$n].abs() + a[$n + 1].abs() + next.abs() < negligible * size {
                return $n + 3;
            }
        )*};
    }
    coefficients!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17);
    TERMS
}

const _: () = assert!(TERMS == 17 + 3);

/// Coefficient N of the product of two series, in independent partial sums.
fn product_term<const N: usize>(a: &[f64; TERMS], b: &[f64; TERMS]) -> f64 {
    let mut sums = [0.0; 4];
    for n in 0..=N {
        sums[n % 4] += a[n] * b[N - n];
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// Coefficient N of the square of a series.
fn square_term<const N: usize>(a: &[f64; TERMS]) -> f64 {
    let mut sums = [0.0; 2];
    for n in 0..N.div_ceil(2) {
        sums[n % 2] += a[n] * a[N - n];
    }
    let middle = if N.is_multiple_of(2) { a[N / 2] * a[N / 2] } else { 0.0 };
    2.0 * (sums[0] + sums[1]) + middle
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
    /// State at τ, with the exact values set by the event there.
    #[must_use]
    pub fn at(&self, tau: f64, event: Option<Event>, length: f64) -> DriveState {
        let (position, rate) = match self.mode {
            MotionMode::Free(_) => {
                let (position, slope) = self.position.with_slope_at(tau);
                (position, slope / length)
            }
            _ => (self.position.at(tau), self.mode.held_rate()),
        };
        match event {
            Some(Event::Rate(rate)) => DriveState { position, rate },
            Some(Event::Stop(position)) => DriveState { position, rate: 0.0 },
            Some(Event::Switch) | None => DriveState { position, rate },
        }
    }

    /// The rate at the start of the segment, given the rate before it [deg/s].
    #[must_use]
    pub fn rate_at_start(&self, rate: f64) -> f64 {
        if matches!(self.mode, MotionMode::Free(_)) { rate } else { self.mode.held_rate() }
    }

    /// Magnitude of the last two coefficients relative to the largest: an estimate of the truncation error.
    #[must_use]
    pub fn truncation(&self) -> f64 {
        let terms = &self.position.terms;
        let size = terms.iter().map(|term| term.abs()).fold(f64::MIN_POSITIVE, f64::max);
        (terms[TERMS - 1].abs() + terms[TERMS - 2].abs()) / size
    }
}
