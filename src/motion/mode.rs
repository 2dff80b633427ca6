//! The drive as a system of differential equations that switches: its mode, what holds in it, its rates. Where a solver integrates,
//! the mode is chosen at events and kept between them, so that the solver meets nothing but smooth equations.

use serde::{Deserialize, Serialize};

use super::{Course, Line, LoopTerms, Point, Power};
use crate::series::Range;

/// Which line of the drive and which course it is on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Mode {
    line: Line,
    course: Course,
}

impl Mode {
    /// A limit of rate, acceleration or position is active.
    #[must_use]
    pub fn is_saturated(&self) -> bool {
        self.course.is_limited() || self.line.saturated
    }
}

/// What acts on the drive at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Acting {
    /// Target of the servo [deg].
    pub target: f64,
    /// Load [deg].
    pub load: f64,
    /// Slopes of target and load, where they are known [deg/s].
    pub slopes: [f64; 2],
    /// What the drive does.
    pub power: Power,
}

/// Long enough for a motion that matters to be more than a rounding, and much shorter than anything that happens [s].
const AN_INSTANT_S: f64 = 1e-12;

/// What holds as long as a line and a course do.
pub(super) struct Conditions {
    /// Target less position [deg].
    pub error: Range,
    /// [deg]
    pub position: Range,
    /// All forces but friction [deg/s²].
    pub force: Range,
    /// [deg/s]
    pub rate: Range,
}

impl LoopTerms {
    /// Numbers that [`LoopTerms::margins`] gives.
    pub const MARGINS: usize = 8;

    pub(super) fn conditions(&self, line: Line, course: Course) -> Conditions {
        let friction = self.omega2 * self.friction;
        let stops = Range { low: self.min, high: self.max };
        let errors = Range { low: line.low, high: line.high };
        let holds = |position: Range, force: Range, rate: Range| Conditions { error: errors, position, force, rate };
        match course {
            Course::Stuck => holds(Range::ALL, Range::ALL, Range::ALL),
            Course::AtRate(rate) if rate > 0.0 => holds(stops, Range::above(friction), Range::ALL),
            Course::AtRate(_) => holds(stops, Range::below(-friction), Range::ALL),
            Course::Sticking => holds(Range::ALL, Range { low: -friction, high: friction }, Range::ALL),
            Course::OnStop(side) if side > 0.0 => holds(Range::ALL, Range::above(-friction), Range::ALL),
            Course::OnStop(_) => holds(Range::ALL, Range::below(friction), Range::ALL),
            Course::Free(direction) => {
                // With friction it may not turn.
                let rate = if friction > 0.0 && direction > 0.0 {
                    Range { low: 0.0, high: self.up }
                } else if friction > 0.0 {
                    Range { low: -self.down, high: 0.0 }
                } else {
                    Range { low: -self.down, high: self.up }
                };
                holds(stops, Range::ALL, rate)
            }
        }
    }

    /// The mode from here on, and the point, put right where it has reached a limit: exactly at that limit from now on.
    #[must_use]
    pub fn settle(&self, before: Option<Mode>, from: Point, acting: Acting) -> (Point, Mode) {
        let mut point = self.inside_limits(from);
        if let Some(Mode { line, course }) = before {
            let Range { low, high } = self.conditions(line, course).rate;
            point.rate = point.rate.clamp(low, high);
        }
        let into_stop =
            point.position >= self.max && point.rate > 0.0 || point.position <= self.min && point.rate < 0.0;
        if into_stop || acting.power == Power::Stuck {
            point.rate = 0.0;
        }
        // A solver may stop exactly where a line ends, or a force: what counts is what comes next.
        let next = Point { position: point.position + point.rate * AN_INSTANT_S, ..point };
        let [target, load] = [acting.target, acting.load];
        let [target, load] = [target + acting.slopes[0] * AN_INSTANT_S, load + acting.slopes[1] * AN_INSTANT_S];
        let line = self.line(target - next.position, acting.power);
        let force = self.force_now(line, target, load, next);
        (point, Mode { line, course: self.course(point, force, acting.power) })
    }

    /// Rates of position [deg/s] and rate [deg/s²].
    #[must_use]
    pub fn rates(&self, mode: Mode, from: Point, acting: Acting) -> [f64; 2] {
        match mode.course {
            Course::Free(direction) => {
                let force = self.force_now(mode.line, acting.target, acting.load, from);
                [from.rate, force - direction * self.omega2 * self.friction]
            }
            Course::AtRate(rate) => [rate, 0.0],
            Course::Sticking | Course::OnStop(_) | Course::Stuck => [0.0, 0.0],
        }
    }

    /// How far everything is inside what holds in this mode: negative where it no longer does.
    #[must_use]
    pub fn margins(&self, mode: Mode, from: Point, acting: Acting) -> [f64; Self::MARGINS] {
        let Conditions { error, position, force, rate } = self.conditions(mode.line, mode.course);
        let pushed = self.force_now(mode.line, acting.target, acting.load, from);
        let [a, b] = error.margins(acting.target - from.position);
        let [c, d] = position.margins(from.position);
        let [e, f] = force.margins(pushed);
        let [g, h] = rate.margins(from.rate);
        [a, b, c, d, e, f, g, h]
    }
}
