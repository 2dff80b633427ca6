//! A steady load instead of a bias of the sensor, where the starts of the records tell them apart.
//!
//! Once a record has settled the two are equivalent. A bias is there from the first sample on. A load that begins with the record moves an actuator
//! that was at rest without it: beside a bias it would have to have been at rest away from where its command holds it, in each record by just the
//! bias. A load that acted before the record as well cannot be told from a bias.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::{
    evidence::RIVAL_BIC_RANGE, fitted::Fitted, hypothesis::MeasurementTerm, selection::StructureSelection, trace::Trace,
};
use actuator_fmu::effects::find;

const SENSOR_BIAS: &str = "sensor_bias";
const HINGE_LOAD: &str = "hinge_load";

/// Sum over the records of the difference in chi square at their starts, from which on a bias is contradicted: by chance in one case of 700, with
/// the least favourable size of the level.
const CONTRADICTED: f64 = 9.0;
/// Chi square of one record beside the load with a natural start over that with any start, at most.
const AS_GOOD_AS_ANY: f64 = 9.0;
/// Samples at the start of a record that are compared, at most.
const MOST_SAMPLES: usize = 200;
/// Evaluated samples over those at the start, at least, for the covariance of the noise.
const LEAST_RATIO: usize = 4;

impl StructureSelection<'_> {
    /// The same explanation with a steady load instead of a bias of the sensor, if that is as likely and the starts of the records contradict the
    /// bias.
    pub fn load_instead_of_bias(&self, found: Fitted, candidates: &[Fitted]) -> Fitted {
        let is_as_likely = |other: &&Fitted| {
            other.bic < found.bic + RIVAL_BIC_RANGE
                && is_load_instead_of_bias(other, &found)
                && self.matches_on_hold_out(other, &found)
        };
        let likeliest = candidates.iter().filter(is_as_likely).min_by(|a, b| a.bic.total_cmp(&b.bic));
        match likeliest.map(|load| self.refined(load.clone())) {
            Some(load) if self.starts_contradict(&found, &load) => load,
            _ => found,
        }
    }

    /// Whether the starts of all records contradict a hypothesis with a bias of the sensor, and agree with one with a steady load in its place; false
    /// where the two are none.
    pub fn starts_contradict(&self, bias: &Fitted, load: &Fitted) -> bool {
        if !is_load_instead_of_bias(load, bias) {
            return false;
        }
        let (Some(bias_there), Some(load_there)) = (bias.on(&self.check), load.on(&self.check)) else { return false };
        let of_fit = (0..self.fit.len()).map(|index| (&self.fit[index], bias, load, index));
        let of_check = (0..self.check.len()).map(|index| (&self.check[index], &bias_there, &load_there, index));
        let each = of_fit.chain(of_check).map(|(trace, bias, load, index)| against_bias(trace, bias, load, index));
        each.sum::<Option<f64>>().is_some_and(|sum| sum > CONTRADICTED)
    }
}

/// Whether two hypotheses are the same but for a steady load in place of a bias of the sensor, and add nothing else to the measurement.
fn is_load_instead_of_bias(load: &Fitted, bias: &Fitted) -> bool {
    let others = |fitted: &Fitted, level: &str| -> Option<Vec<&'static str>> {
        let effects = &fitted.space.hypothesis.effects;
        let mut others: Vec<&str> = effects.iter().copied().filter(|effect| *effect != level).collect();
        others.sort_unstable();
        (others.len() + 1 == effects.len()).then_some(others)
    };
    let beside_bias = others(bias, SENSOR_BIAS);
    beside_bias.is_some()
        && beside_bias == others(load, HINGE_LOAD)
        && bias.space.terms().all(|term| term == MeasurementTerm::Bias)
        && load.space.terms().next().is_none()
}

/// Chi square at the start of a record beside the bias minus that beside the load; none where no natural start agrees with the load.
fn against_bias(trace: &Trace<'_>, bias: &Fitted, load: &Fitted, index: usize) -> Option<f64> {
    let count = trace.settling.min(MOST_SAMPLES);
    let record = trace.record;
    if count == 0 || record.offset_s() > 0.0 || LEAST_RATIO * count > trace.evaluated_samples() {
        return None;
    }
    let covariance = covariance(&bias.residuals[index], count)?;
    let start = |fitted: &Fitted, level: &dyn Fn(f64) -> f64, at: f64| {
        let left = left_at_start(trace, fitted, at, count)?;
        let left = left.iter().zip(record.time()).map(|(left, time)| left - level(time - record.time()[0]));
        Some(DVector::from_iterator(count, left))
    };
    let chi_square = |left: &DVector<f64>| left.dot(&covariance.solve(left));
    let (offset, drift) = (bias.factors[index][0], bias.factors[index][1]);
    let held = |fitted: &Fitted| fitted.model.base.k() * record.command()[0];

    let beside_bias = [0.0, held(bias)]
        .into_iter()
        .filter_map(|at| Some(chi_square(&start(bias, &|time| offset + drift * time, at)?)))
        .fold(f64::INFINITY, f64::min);
    // At rest without the load, or with it.
    let (least, at) = [0.0, held(load), offset, held(load) + offset]
        .into_iter()
        .filter_map(|at| Some((chi_square(&start(load, &|_| 0.0, at)?), at)))
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let [here, beside] = [at, at + offset].map(|at| start(load, &|_| 0.0, at));
    let (here, beside) = (here?, beside?);
    let change = &beside - &here;
    let by_any_start = change.dot(&covariance.solve(&here)).powi(2) / chi_square(&change).max(f64::MIN_POSITIVE);
    (by_any_start < AS_GOOD_AS_ANY).then_some(beside_bias - least)
}

/// Difference between the first samples of a record and the motion from rest at a position [deg].
fn left_at_start(trace: &Trace<'_>, fitted: &Fitted, at: f64, count: usize) -> Option<Vec<f64>> {
    let mut model = fitted.model.clone();
    // The levels of each record are subtracted.
    if let Some(bias) = find(SENSOR_BIAS).filter(|bias| fitted.space.hypothesis.effects.contains(&bias.name)) {
        model.effects = model.effects.without(bias);
    }
    let mut trace = trace.clone();
    trace.start = at;
    let mut left = Vec::with_capacity(count);
    let goes_on = |sample: usize, position: f64| {
        left.push(trace.record.position()[sample] - position);
        left.len() < count
    };
    // It ends early, and then gives no position.
    let _ = trace.simulated_while(&model, false, goes_on);
    (left.len() == count).then_some(left)
}

/// Covariance of successive samples of noise, from its autocovariance.
#[allow(clippy::cast_precision_loss)] // a count of samples
fn covariance(noise: &[f64], count: usize) -> Option<Cholesky<f64, Dyn>> {
    let lagged = |lag: usize| noise.iter().zip(&noise[lag..]).map(|(a, b)| a * b).sum::<f64>() / noise.len() as f64;
    let of_lag: Vec<f64> = (0..count).map(lagged).collect();
    DMatrix::from_fn(count, count, |row, column| of_lag[row.abs_diff(column)]).cholesky()
}

#[cfg(test)]
mod tests {
    use crate::{
        diagnose::{
            Verdict,
            three_records::{measured_as, said, three_records_of},
        },
        signal::record::Record,
    };
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Model, table},
    };

    fn with(name: &str, values: &[f64]) -> Model {
        let effects = Effects::default().with(find(name).unwrap(), values).unwrap();
        Model { effects, ..Model::from_set(&table()[0]) }
    }

    fn names(records: &[Record]) -> (Verdict, &'static str, Vec<String>) {
        let (verdict, found) = said(&Model::from_set(&table()[0]), records);
        let (name, _, alternatives) = found.unwrap();
        (verdict, name, alternatives)
    }

    #[test]
    fn a_load_that_begins_with_the_records_is_no_bias() {
        let records = three_records_of(&with("hinge_load", &[0.0, 0.2]), 2.0, 6.0);
        assert_eq!(names(&records), (Verdict::Named, "hinge_load", Vec::new()));
    }

    #[test]
    fn a_level_that_is_there_from_the_first_sample_on_may_be_either() {
        let healthy = three_records_of(&Model::from_set(&table()[0]), 2.0, 6.0);
        let records: Vec<Record> =
            healthy.iter().map(|record| measured_as(record, |_, position| position + 0.2)).collect();
        let (verdict, name, alternatives) = names(&records);
        let both = [name, alternatives[0].as_str()];
        assert!(verdict == Verdict::Ambiguous && alternatives.len() == 1, "{verdict:?} {alternatives:?}");
        assert!(both.contains(&"sensor_bias") && both.contains(&"hinge_load"), "{both:?}");
    }
}
