//! The drive between two events: the equation of motion with everything that acts on it, as series.
//!
//! ```text
//! δ̈ = drive - 2ζω δ̇ - ω² cubic δ³ + ω² (load + bias - stiffness δ) - friction
//! drive = ω² (error), error = x - δ through the dead zone and the limit of acceleration
//! ```
//!
//! Between two events the drive is one of at most five straight lines of the error, friction has one sign or holds, and the rate is
//! free or stands at a limit: all of that is linear but for the cubic spring, and is solved by series to rounding error. What ends
//! it is looked for in the series and cannot be stepped over.

mod mode;

use serde::{Deserialize, Serialize};

pub use mode::{Acting, Mode};

use crate::{
    operator::Segment,
    series::{Decay, RECIPROCAL, Range, Series, Side, TERMS},
};

/// A spring that pushes outwards this many times as hard as the linear one pulls inwards has let the surface run away. No stop
/// that a surface could have is as far out.
const OUTWARDS: f64 = 1e4;

/// Everything in the equation of motion, [`LoopTerms::linear`] and what effects change in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopTerms {
    /// ω² [1/s²]
    pub omega2: f64,
    /// 2ζω [1/s]
    pub damping: f64,
    /// Half width of the dead zone of the error [deg].
    pub dead_zone: f64,
    /// Greatest acceleration by the drive [deg/s²].
    pub acceleration: f64,
    /// Cubic over linear stiffness [1/deg²].
    pub cubic: f64,
    /// Load stiffness over the actuator's own.
    pub stiffness: f64,
    /// Steady load [deg].
    pub bias: f64,
    /// Friction over ω² [deg].
    pub friction: f64,
    /// Greatest rate upwards [deg/s].
    pub up: f64,
    /// Greatest rate downwards [deg/s].
    pub down: f64,
    /// Least position [deg].
    pub min: f64,
    /// Greatest position [deg].
    pub max: f64,
}

impl LoopTerms {
    /// The loop of eq. (1) and nothing else.
    #[must_use]
    pub fn linear(omega: f64, zeta: f64) -> Self {
        let none = f64::INFINITY;
        Self {
            omega2: omega * omega,
            damping: 2.0 * zeta * omega,
            dead_zone: 0.0,
            acceleration: none,
            cubic: 0.0,
            stiffness: 0.0,
            bias: 0.0,
            friction: 0.0,
            up: none,
            down: none,
            min: -none,
            max: none,
        }
    }

    /// Largest pole of the loop [1/s], at positions up to this [deg].
    #[must_use]
    pub fn pole(&self, position: f64) -> f64 {
        let stiffness = 1.0 + self.stiffness.max(0.0) + 3.0 * self.cubic.abs() * position * position;
        let (omega, half) = ((self.omega2 * stiffness).sqrt(), 0.5 * self.damping);
        if half > omega { half + (half * half - omega * omega).sqrt() } else { omega }
    }

    /// Whether the spring pushes outwards so hard that the surface cannot be meant to be here.
    #[must_use]
    pub fn runs_away(&self, position: f64) -> bool {
        self.cubic * position * position < -OUTWARDS
    }
}

/// What the drive does with its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Power {
    /// It follows.
    On,
    /// It is off: the surface floats.
    Off,
    /// It is stuck where it is.
    Stuck,
}

/// Position and rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// δ [deg]
    pub position: f64,
    /// δ̇ [deg/s]
    pub rate: f64,
}

/// What acts on the drive during a segment.
#[derive(Debug, Clone, Copy)]
pub struct Forcing<'a> {
    /// Target of the servo.
    pub target: &'a Series,
    /// Load at the start and its change over the segment [deg].
    pub load: [f64; 2],
    /// What the drive does.
    pub power: Power,
}

/// One straight line of the drive: ω² (gain × error + offset) while low <= error <= high.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Line {
    gain: f64,
    offset: f64,
    low: f64,
    high: f64,
    saturated: bool,
}

/// How it moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
enum Course {
    /// Freely, with friction against this direction.
    Free(f64),
    /// At a limit of the rate.
    AtRate(f64),
    /// Held by friction.
    Sticking,
    /// On a stop, in this direction.
    OnStop(f64),
    /// Not at all.
    Stuck,
}

impl Course {
    fn is_limited(self) -> bool {
        matches!(self, Self::AtRate(_) | Self::OnStop(_))
    }
}

/// A segment of the motion.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// δ
    pub position: Series,
    /// A limit of rate, acceleration or position is active.
    pub saturated: bool,
    course: Course,
    line: Line,
}

/// Why a motion ceases to hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// Another line of the drive, another course: nothing to set.
    Switch,
    /// The rate reached this value exactly [deg/s].
    Rate(f64),
    /// A stop at this position [deg].
    Stop(f64),
}

impl LoopTerms {
    fn line(&self, error: f64, power: Power) -> Line {
        let none = f64::INFINITY;
        let (dead, full) = (self.dead_zone, self.acceleration / self.omega2);
        let side = if error < 0.0 { -1.0 } else { 1.0 };
        let between = |low: f64, high: f64| if side > 0.0 { (low, high) } else { (-high, -low) };
        if power != Power::On {
            Line { gain: 0.0, offset: 0.0, low: -none, high: none, saturated: false }
        } else if error.abs() > dead + full {
            let (low, high) = between(dead + full, none);
            Line { gain: 0.0, offset: side * full, low, high, saturated: true }
        } else if dead > 0.0 && error.abs() <= dead {
            Line { gain: 0.0, offset: 0.0, low: -dead, high: dead, saturated: false }
        } else if dead > 0.0 {
            let (low, high) = between(dead, dead + full);
            Line { gain: 1.0, offset: -side * dead, low, high, saturated: false }
        } else {
            Line { gain: 1.0, offset: 0.0, low: -full, high: full, saturated: false }
        }
    }

    /// All forces but friction, now.
    fn force_now(&self, line: Line, target: f64, load: f64, from: Point) -> f64 {
        let Point { position, rate } = from;
        let pull = line.gain * (target - position) + line.offset;
        let load = self.bias + load - self.stiffness * position - self.cubic * position.powi(3);
        self.omega2 * (pull + load) - self.damping * rate
    }

    /// The same over a motion along a straight line.
    fn force(&self, line: Line, forcing: &Forcing, position: &Series, length: f64) -> Series {
        let mut force = forcing.target.scaled(self.omega2 * line.gain);
        force.length = force.length.max(4);
        let [a, b] = [position.terms[0], position.terms[1]];
        let (pull, cubic) = (line.gain + self.stiffness, self.cubic);
        force.terms[0] += self.omega2 * (line.offset + self.bias + forcing.load[0] - pull * a - cubic * a * a * a);
        force.terms[0] -= self.damping / length * b;
        force.terms[1] += self.omega2 * (forcing.load[1] - pull * b - 3.0 * cubic * a * a * b);
        force.terms[2] -= self.omega2 * 3.0 * cubic * a * b * b;
        force.terms[3] -= self.omega2 * cubic * b * b * b;
        force
    }

    /// Fills in the motion that starts here; returns its first event in the segment.
    pub fn motion(
        &self,
        from: Point,
        forcing: &Forcing,
        segment: Segment,
        motion: &mut Motion,
    ) -> Option<(f64, Event)> {
        let line = self.line(forcing.target.start() - from.position, forcing.power);
        let straight = |rate: f64| Series::polynomial(&[from.position, rate * segment.length]);
        let force = self.force_now(line, forcing.target.start(), forcing.load[0], from);
        let course = self.course(from, force, forcing.power);
        let position = match course {
            Course::Free(direction) => self.free(from, line, direction, forcing, segment),
            Course::AtRate(rate) => straight(rate),
            Course::Sticking | Course::OnStop(_) | Course::Stuck => straight(0.0),
        };
        *motion = Motion { position, saturated: course.is_limited() || line.saturated, course, line };
        self.first_event(motion, forcing, segment)
    }

    fn course(&self, from: Point, force: f64, power: Power) -> Course {
        let friction = self.omega2 * self.friction;
        let Point { position, rate } = from;
        if power == Power::Stuck {
            Course::Stuck
        } else if position >= self.max && rate >= 0.0 && force >= -friction {
            Course::OnStop(1.0)
        } else if position <= self.min && rate <= 0.0 && force <= friction {
            Course::OnStop(-1.0)
        } else if rate == 0.0 && friction > 0.0 && force.abs() <= friction {
            Course::Sticking
        } else if rate >= self.up && force > friction {
            Course::AtRate(self.up)
        } else if rate <= -self.down && force < -friction {
            Course::AtRate(-self.down)
        } else {
            Course::Free(if rate == 0.0 { force.signum() } else { rate.signum() })
        }
    }

    /// (n+1)(n+2) a_{n+2} = h² (forces)_n - 2ζω h (n+1) a_{n+1}, for what the decay of the target leaves of the motion.
    fn free(&self, from: Point, line: Line, direction: f64, forcing: &Forcing, segment: Segment) -> Series {
        let Segment { length, terms, .. } = segment;
        let h2 = self.omega2 * length * length;
        let damping = self.damping * length;
        let Decay { amplitude, exponent: k } = forcing.target.decays[0];
        // The decay is so short that the cubic spring is taken at the position where it starts.
        let local = line.gain + self.stiffness + 3.0 * self.cubic * from.position * from.position;
        let amplitude =
            if amplitude == 0.0 { 0.0 } else { h2 * line.gain * amplitude / (k * k - damping * k + h2 * local) };

        let mut a = [0.0; TERMS];
        a[0] = from.position - amplitude;
        a[1] = from.rate * length + k * amplitude;
        let stiffness = line.gain + self.stiffness;
        let mut forced = forcing.target.terms.map(|term| line.gain * term);
        forced[0] += line.offset + self.bias + forcing.load[0] - direction * self.friction;
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
        let Motion { position, course, line, .. } = motion;
        let mut first: Option<(f64, Event)> = None;
        let mut consider = |left: Option<(f64, Side)>, above: Event, below: Event| {
            if let Some((tau, side)) = left.filter(|(tau, _)| first.is_none_or(|(earlier, _)| *tau < earlier)) {
                first = Some((tau, if side == Side::Above { above } else { below }));
            }
        };
        let tolerance = segment.tolerance;
        let holds = self.conditions(*line, *course);
        if holds.error.is_bounded() {
            let error = forcing.target.plus(-1.0, position);
            consider(error.leaves(holds.error, tolerance), Event::Switch, Event::Switch);
        }
        if holds.position.is_bounded() {
            consider(position.leaves(holds.position, tolerance), Event::Stop(self.max), Event::Stop(self.min));
        }
        if holds.force.is_bounded() {
            let held = self.force(*line, forcing, position, segment.length);
            consider(held.leaves(holds.force, self.omega2 * tolerance), Event::Switch, Event::Switch);
        }
        if holds.rate.is_bounded() {
            // Over the segment a rate has the size of a position.
            let Range { low, high } = holds.rate;
            let rates = Range { low: low * segment.length, high: high * segment.length };
            consider(position.derivative_leaves(rates, tolerance), Event::Rate(high), Event::Rate(low));
        }
        first
    }

    /// Inside the limits, if parameters have changed or an event has been overrun by a rounding.
    #[must_use]
    pub fn inside_limits(&self, point: Point) -> Point {
        let Point { position, rate } = point;
        let rate = rate.clamp(-self.down, self.up);
        if position > self.max {
            Point { position: self.max, rate: rate.min(0.0) }
        } else if position < self.min {
            Point { position: self.min, rate: rate.max(0.0) }
        } else {
            Point { position, rate }
        }
    }
}

/// Coefficient n of a product of series.
fn product(a: &[f64; TERMS], b: &[f64; TERMS], n: usize) -> f64 {
    a[..=n].iter().zip(b[..=n].iter().rev()).map(|(a, b)| a * b).sum()
}

impl Default for Motion {
    /// No motion at 0.
    fn default() -> Self {
        let none = f64::INFINITY;
        let line = Line { gain: 0.0, offset: 0.0, low: -none, high: none, saturated: false };
        Self { position: Series::polynomial(&[0.0]), saturated: false, course: Course::Stuck, line }
    }
}

impl Motion {
    /// Where it is at τ, and how fast; at an event, what the event sets.
    #[must_use]
    pub fn at(&self, tau: f64, event: Option<Event>, length: f64) -> Point {
        let position = self.position.at(tau);
        let rate = match self.course {
            Course::Free(_) => self.position.slope_at(tau) / length,
            Course::AtRate(rate) => rate,
            Course::Sticking | Course::OnStop(_) | Course::Stuck => 0.0,
        };
        match event {
            Some(Event::Rate(rate)) => Point { position, rate },
            Some(Event::Stop(position)) => Point { position, rate: 0.0 },
            Some(Event::Switch) | None => Point { position, rate },
        }
    }

    /// The rate at the start, where the drive came with this one [deg/s].
    #[must_use]
    pub fn rate_at_start(&self, rate: f64) -> f64 {
        match self.course {
            Course::Free(_) => rate,
            Course::AtRate(limit) => limit,
            Course::Sticking | Course::OnStop(_) | Course::Stuck => 0.0,
        }
    }

    /// Size of the last coefficients by that of the first ones: 1 where the series has not converged.
    #[must_use]
    pub fn truncation(&self) -> f64 {
        let terms = &self.position.terms;
        let size = terms.iter().map(|term| term.abs()).fold(f64::MIN_POSITIVE, f64::max);
        (terms[TERMS - 1].abs() + terms[TERMS - 2].abs()) / size
    }
}
