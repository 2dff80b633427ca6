//! Phase and times of an instance, and which step may come next.

use serde::{Deserialize, Serialize};

use crate::{
    calls::{Kind, Phase},
    error::{Error, Result},
};

/// Phase and times of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Lifecycle {
    pub kind: Kind,
    pub phase: Phase,
    pub start_time: f64,
    pub time: f64,
    /// [`NO_STOP`] if there is none.
    pub stop_time: f64,
}

/// The largest finite time: a step that ends later has no end.
pub(crate) const NO_STOP: f64 = f64::MAX;

/// Relative to the step: times that differ by less (or by rounding of the time) are the same communication point, since masters accumulate
/// their steps with different rounding.
const COMMUNICATION_POINT_TOLERANCE: f64 = 1e-6;

/// Relative to the step: even with a large time and its coarse rounding, no two steps start from one communication point.
const LARGEST_TOLERANCE: f64 = 0.25;

impl Lifecycle {
    pub fn new(kind: Kind) -> Self {
        Self { kind, phase: Phase::Instantiated, start_time: 0.0, time: 0.0, stop_time: NO_STOP }
    }

    /// End of a step from here.
    ///
    /// # Errors
    /// A step that is not positive and finite, starts elsewhere, or passes the stop time.
    #[inline]
    pub fn end_of_step(&self, current: f64, duration: f64) -> Result<f64> {
        let end = current + duration;
        // The narrowest of all tolerances, met by nearly every step; it is positive if the step is.
        let is_here = (current - self.time).abs() < COMMUNICATION_POINT_TOLERANCE * duration;
        if is_here && end <= self.stop_time { Ok(end) } else { self.end_within_rounding(current, duration) }
    }

    #[cold]
    #[inline(never)]
    fn end_within_rounding(&self, current: f64, duration: f64) -> Result<f64> {
        if !(duration > 0.0 && duration < f64::INFINITY) {
            return Err(Error::new("communicationStepSize", format!("{duration} s"), "finite numbers above 0"));
        }
        let rounding = 1e3 * f64::EPSILON * self.time.abs();
        let tolerance = (COMMUNICATION_POINT_TOLERANCE * duration + rounding).min(LARGEST_TOLERANCE * duration);
        let is_here = (current - self.time).abs() <= tolerance;
        if !is_here {
            let allowed = format!("{} s, where the last step ended", self.time);
            return Err(Error::new("currentCommunicationPoint", format!("{current} s"), allowed));
        }
        let end = current + duration;
        if end.is_finite() && end <= self.stop_time + tolerance {
            return Ok(end);
        }
        let allowed =
            self.stop().map_or_else(|| "finite numbers".into(), |stop| format!("up to the stop time of {stop} s"));
        Err(Error::new("end of the step", format!("{end} s"), allowed))
    }

    /// The stop time, if there is one.
    pub fn stop(&self) -> Option<f64> {
        (self.stop_time != NO_STOP).then_some(self.stop_time)
    }

    /// Refuses values that are impossible for an instance of this kind.
    pub fn check(&self, kind: Kind) -> Result<()> {
        let times = [self.start_time, self.time, self.stop_time];
        if let Some(time) = times.iter().find(|time| !time.is_finite()) {
            return Err(Error::new("FMU state", time, "finite numbers"));
        }
        if self.kind != kind || !Phase::of(kind).contains(&self.phase) {
            let found = format!("a state of an instance for {}", self.kind.name());
            return Err(Error::new("FMU state", found, format!("one of an instance for {}", kind.name())));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time: f64, stop_time: f64) -> Lifecycle {
        Lifecycle { phase: Phase::StepComplete, time, stop_time, ..Lifecycle::new(Kind::CoSimulation) }
    }

    #[test]
    fn a_step_goes_on_where_the_last_one_ended_up_to_rounding() {
        for (time, current, duration, is_legal) in [
            (1.0, 1.0, 0.1, true),
            (1.0, 1.0 + 0.9e-7, 0.1, true),
            (1.0, 1.0 + 1.1e-7, 0.1, false),
            (1e6, 1e6 + 2e-7, 0.1, true),
            (1e6, 1e6 + 4e-7, 0.1, false),
            (1e9, 1e9 + 2e-5, 1e-4, true),
            (1e9, 1e9 + 3e-5, 1e-4, false),
            (1.0, f64::NAN, 0.1, false),
            (0.0, 0.0, 0.0, false),
            (0.0, 0.0, -0.1, false),
            (0.0, 0.0, f64::NAN, false),
            (0.0, 0.0, f64::INFINITY, false),
        ] {
            let found = at(time, NO_STOP).end_of_step(current, duration);
            assert_eq!(found.is_ok(), is_legal, "{time} {current} {duration} {found:?}");
            assert!(found.is_err() || found == Ok(current + duration));
        }
    }

    #[test]
    fn a_step_ends_at_the_stop_time_up_to_rounding() {
        for (stop, duration, is_legal) in [(1.0, 1.0, true), (1.0, 1.0 + 0.9e-6, true), (1.0, 1.0 + 1.1e-6, false)] {
            assert_eq!(at(0.0, stop).end_of_step(0.0, duration).is_ok(), is_legal, "{stop} {duration}");
        }
        let refusal = at(f64::MAX, NO_STOP).end_of_step(f64::MAX, f64::MAX).unwrap_err().to_string();
        assert!(refusal.contains("inf s; allowed: finite numbers"), "{refusal}");
    }
}
