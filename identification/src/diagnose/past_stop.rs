//! Measured positions that contradict a stop, or a side of it: they go beyond it, or end short of it.

use super::{fitted::Fitted, selection::StructureSelection};
use crate::signal::play::range;

const STOP: &str = "position_limit";

/// Distance of positions beyond a stop that contradicts it, in half ranges of the positions and in standard deviations of the noise, of which the
/// larger one counts; and share of the samples of a record beyond it.
const BEYOND_OF_HALF_RANGE: f64 = 0.08;
const BEYOND_OF_NOISE: f64 = 5.0;
const BEYOND_SHARE: f64 = 0.02;

/// Distance by which positions end short of a stop that they never reach, in half ranges of the positions and in standard deviations of the noise, of
/// which the larger one counts.
const SHORT_OF_HALF_RANGE: f64 = 0.03;
const SHORT_OF_NOISE: f64 = 5.0;

impl StructureSelection<'_> {
    /// Why the stop of a lead does not hold: a record is beyond it. Levels of the records, which no model has, may have put it there.
    pub fn passed_stop(&self, lead: &Fitted) -> Option<String> {
        let stop = lead.space.hypothesis.effects.contains(&STOP);
        let &[min, max] = lead.model.effects.active_values_of(STOP).filter(|_| stop)? else { return None };
        let bias = lead.model.effects.active_values_of("sensor_bias").map_or(0.0, |values| values[0]);
        let noise = self.noise.mean_squares();
        self.fit.iter().chain(&self.check).zip(noise).find_map(|(trace, noise)| {
            let share = share_beyond([min + bias, max + bias], trace.record.position(), noise.sqrt());
            (share > BEYOND_SHARE).then(|| {
                let record = trace.record.source().display();
                format!("{record} is beyond the stop in {:.0} % of its samples", 100.0 * share)
            })
        })
    }
}

/// Share of the samples that are clearly beyond stops.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn share_beyond([min, max]: [f64; 2], position: &[f64], noise_rms: f64) -> f64 {
    let (low, high) = range(position);
    let beyond = (BEYOND_OF_HALF_RANGE * 0.5 * (high - low)).max(BEYOND_OF_NOISE * noise_rms);
    let passes = |value: &&f64| !(min - beyond..=max + beyond).contains(*value);
    position.iter().filter(passes).count() as f64 / position.len().max(1) as f64
}

/// Whether positions end clearly short of the lower and of the upper stop.
pub fn ends_short([min, max]: [f64; 2], position: &[f64], noise_rms: f64) -> [bool; 2] {
    let (low, high) = range(position);
    let short = (SHORT_OF_HALF_RANGE * 0.5 * (high - low)).max(SHORT_OF_NOISE * noise_rms);
    [low - min > short, max - high > short]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_tell_whether_they_go_beyond_a_stop_or_end_short_of_it() {
        let motion: Vec<f64> = (0..1000).map(|n| 10.0 * (0.02 * f64::from(n)).sin()).collect();
        let stopped: Vec<f64> = motion.iter().map(|value| value.min(9.0)).collect();
        assert_eq!(share_beyond([-1e9, 9.0], &stopped, 0.01), 0.0);
        // Within eight hundredths of the half range, or five times the noise.
        assert_eq!([share_beyond([-1e9, 8.3], &stopped, 0.01), share_beyond([-1e9, 7.6], &stopped, 0.3)], [0.0, 0.0]);
        assert!(share_beyond([-1e9, 8.0], &stopped, 0.01) > 0.15);
        assert_eq!(ends_short([-10.5, 9.0], &stopped, 0.01), [true, false]);
        assert_eq!(ends_short([-10.2, 9.2], &stopped, 0.01), [false, false]);
        assert_eq!(ends_short([-10.5, 9.2], &stopped, 0.2), [false, false]);
    }
}
