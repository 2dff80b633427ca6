//! Contacts with a stop: the model would go beyond a level, and the measured position stands at it, however far beyond the model is.

use super::{selection::StructureSelection, trace::Trace};

/// Half width of the band about a level in which a position stands, in standard deviations of the noise; at least this share of the half range of the
/// positions.
const BAND_IN_NOISE: f64 = 4.0;
const BAND_IN_RANGE: f64 = 0.004;
/// Distance of the model beyond a level, at least, in half widths of the band.
const BEYOND: f64 = 2.0;
/// Share of the samples with the model beyond the level in which the position stands there, at least: in the others it is on its way.
const LEAST_HELD: f64 = 0.6;
/// Fewest samples of a contact.
const FEWEST_SAMPLES: usize = 3;
/// Difference between two contacts in the distance of the model beyond the level, at least, in half widths of the band and in half ranges of the
/// positions: a wrong gain, or a command that returns to one value, keeps this distance constant.
const SPREAD_IN_BANDS: f64 = 2.5;
const SPREAD_IN_RANGE: f64 = 0.03;
/// Distance of the level of a record from the mean of the fit records' levels, at most, in half ranges: sensors have an offset of the day.
const SAME_LEVEL: f64 = 0.1;
/// Share of the samples of a record that may lie beyond its level: spikes.
const SPIKES: f64 = 0.005;

/// A stop on one side, as the positions show it.
pub struct Contact {
    /// Level at which they stand, towards that side.
    pub level: f64,
    /// Number of contacts.
    pub contacts: usize,
    /// Whether the distance of the model beyond the level differs between contacts.
    pub is_whatever_the_command: bool,
}

/// Positions of a record towards one side.
struct Side {
    measured: Vec<f64>,
    simulated: Vec<f64>,
    band: f64,
}

impl StructureSelection<'_> {
    /// Whether positions stand at a stop towards the lower or the upper side.
    pub fn stand_at_stop(&self, side: usize) -> bool {
        self.contact_towards([-1.0, 1.0][side]).is_some_and(|contact| contact.is_whatever_the_command)
    }

    /// The level at which positions of the fit records stand on one side, with the contacts of all records; none where they do not stand, or some
    /// record goes beyond it.
    #[allow(clippy::cast_precision_loss)] // a count of records
    pub fn contact_towards(&self, sign: f64) -> Option<Contact> {
        let traces = || self.fit.iter().chain(&self.check);
        let positions = || traces().flat_map(|trace| trace.record.position());
        let (least, greatest) =
            positions().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), one| (low.min(*one), high.max(*one)));
        let half_range = 0.5 * (greatest - least);
        let side = |(trace, noise): (&Trace<'_>, f64)| {
            let towards = |values: &[f64]| -> Vec<f64> {
                let counted = trace.where_measured(values[trace.settling..].to_vec());
                counted.into_iter().map(|value| sign * value).collect()
            };
            let simulated = towards(&trace.position(self.given)?);
            let band = (BAND_IN_NOISE * noise).max(BAND_IN_RANGE * half_range);
            Some(Side { measured: towards(trace.record.position()), simulated, band })
        };
        let noise = self.noise.records.iter().map(|noise| noise.rms);
        let sides: Vec<Side> = traces().zip(noise).map(side).collect::<Option<_>>()?;
        let each: Vec<Option<(f64, Vec<f64>)>> = sides.iter().map(Side::contacts).collect();
        // Check records must show it as well, but do not determine the level.
        let levels: Vec<f64> = each[..self.fit.len()].iter().flatten().map(|(level, _)| *level).collect();
        let level = levels.iter().sum::<f64>() / levels.len() as f64;
        let furthest_apart = SAME_LEVEL * half_range;
        let is_one_level = each.iter().flatten().all(|(other, _)| (other - level).abs() < furthest_apart);
        let is_exceeded = sides.iter().any(|side| side.highest() > level + furthest_apart);
        if levels.is_empty() || !is_one_level || is_exceeded {
            return None;
        }
        let distances: Vec<f64> = each.into_iter().flatten().flat_map(|(_, distances)| distances).collect();
        let (nearest, furthest) =
            distances.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), one| (low.min(*one), high.max(*one)));
        let widest = sides.iter().map(|side| side.band).fold(0.0, f64::max);
        let is_whatever_the_command = furthest - nearest > (SPREAD_IN_BANDS * widest).max(SPREAD_IN_RANGE * half_range);
        Some(Contact { level, contacts: distances.len(), is_whatever_the_command })
    }
}

impl Side {
    /// The highest position without spikes.
    fn highest(&self) -> f64 {
        quantile(self.measured.clone(), 1.0 - SPIKES)
    }

    /// The level at which the position stands where the model is beyond it, and the mean distance beyond in each contact; none where the model hardly
    /// goes there, or the position does not stand.
    #[allow(clippy::cast_precision_loss)] // counts of samples
    fn contacts(&self) -> Option<(f64, Vec<f64>)> {
        let highest = self.highest();
        let near = |position: &&f64| (*position - highest).abs() <= 2.0 * self.band;
        let level = quantile(self.measured.iter().filter(near).copied().collect(), 0.5);
        let pairs: Vec<(f64, f64)> = self.measured.iter().copied().zip(self.simulated.iter().copied()).collect();
        let is_free = |(measured, _): &&(f64, f64)| *measured < level - 2.0 * self.band;
        let [gain, offset] = straight_line(pairs.iter().filter(is_free).copied())?;
        let distance = |(_, simulated): &(f64, f64)| offset + gain * simulated - level;
        let is_beyond = |pair: &(f64, f64)| distance(pair) > BEYOND * self.band;
        let stands = |pair: &(f64, f64)| is_beyond(pair) && (pair.0 - level).abs() <= self.band;
        let count = |is: &dyn Fn(&(f64, f64)) -> bool| pairs.iter().filter(|pair| is(pair)).count() as f64;
        let runs = pairs.chunk_by(|one, next| stands(one) == stands(next));
        let contacts = runs.filter(|run| run.len() >= FEWEST_SAMPLES && stands(&run[0]));
        let distances: Vec<f64> =
            contacts.map(|run| run.iter().map(distance).sum::<f64>() / run.len() as f64).collect();
        let is_stop = !distances.is_empty() && count(&stands) >= LEAST_HELD * count(&is_beyond);
        is_stop.then_some((level, distances))
    }
}

/// Slope and offset of a straight line from simulated to measured positions, by least squares; none where the former do not move.
#[allow(clippy::cast_precision_loss)] // a count of samples
fn straight_line(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> Option<[f64; 2]> {
    let count = pairs.clone().count() as f64;
    let mean = |of: fn((f64, f64)) -> f64| pairs.clone().map(of).sum::<f64>() / count;
    let (measured, simulated) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let (square, product) = (mean(|pair| pair.1 * pair.1), mean(|pair| pair.0 * pair.1));
    let gain = (product - measured * simulated) / (square - simulated * simulated);
    gain.is_finite().then_some([gain, measured - gain * simulated])
}

/// The quantile of some values; not a number where there are none.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a share of a count
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = (share * values.len().saturating_sub(1) as f64).round() as usize;
    values.get(place).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(of: impl Fn(f64) -> [f64; 2]) -> Option<(f64, Vec<f64>)> {
        let pairs: Vec<[f64; 2]> = (0..2000).map(|n| of(0.01 * f64::from(n))).collect();
        let [measured, simulated] = [0, 1].map(|place| pairs.iter().map(|pair| pair[place]).collect());
        Side { measured, simulated, band: 0.02 }.contacts()
    }

    #[test]
    fn a_position_stands_where_more_is_asked_for_and_not_where_gain_or_lag_are_off() {
        let wave = |t: f64| 5.0 * t.sin() + 2.0 * (0.37 * t).sin();
        let (level, distances) = side(|t| [wave(t).min(4.0), wave(t)]).unwrap();
        assert!((level - 4.0).abs() < 1e-9 && distances.len() == 3, "{level} {distances:?}");
        // The gain of the model does not matter.
        let (level, scaled) = side(|t| [wave(t).min(4.0), 0.7 * wave(t)]).unwrap();
        assert!((level - 4.0).abs() < 1e-9 && scaled.len() == 3, "{level} {scaled:?}");
        for (distance, of_scaled) in distances.iter().zip(&scaled) {
            assert!((distance - of_scaled).abs() < 1e-6, "{distances:?} {scaled:?}");
        }
        assert!(side(|t| [0.9 * wave(t), wave(t)]).is_none());
        assert!(side(|t| [wave(t - 0.2), wave(t)]).is_none());
    }
}
