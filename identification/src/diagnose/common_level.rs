//! A level that all records share and that is the largest part of the difference.
//!
//! It may be a new bias of the sensor, or the zero that the sensor always had: a model without a bias does not distinguish them, and healthy
//! actuators usually differ from their models by some level. It is listed with its size. A level that drifts alike in all records is a bias, and
//! leads.

use super::{
    candidates::add_measurement_term,
    diagnosis::Lead,
    fitted::Fitted,
    hypothesis::{Hypothesis, MeasurementTerm, family},
    outcome::{CLOSES_NOTHING, Outcome, Standing},
    plain_fit::PlainFit,
    selection::StructureSelection,
    space::Space,
    steady_level::is_steady,
    trace::Trace,
};
use crate::sorting::sort_by_number;
use actuator_fmu::{effects::find, parameters::Model};

const SENSOR_BIAS: &str = "sensor_bias";

/// Place of its drift among the factors of a record, which begin with those of the bias.
const DRIFT: usize = 1;

/// Excess of a model with a level over that of the given model, at most, on fit and on check records.
const GREATEST_LEFT: f64 = 0.35;

/// Excess of a refitted base over that of the model with a level, at least, on both: with a command to one side a wrong gain leaves a level.
const LEAST_LEFT_BY_BASE: f64 = 2.0;

/// The same two for a drift that is nearly the same in three records, each of which shows it by itself: it need not be more than the largest part.
const GREATEST_LEFT_BESIDE_ONE_DRIFT: f64 = 0.5;
const LEAST_LEFT_BY_BASE_BESIDE_ONE_DRIFT: f64 = 1.5;
const ONE_DRIFT_RATIO: f64 = 1.3;

/// Largest over smallest drift among the records, at most; drift over the shortest record relative to the offset, at least.
const GREATEST_DRIFT_RATIO: f64 = 2.0;
const LEAST_DRIFTED: f64 = 0.1;
/// Records that must show the drift besides its offset. Two of a healthy servo-hydraulic actuator drifted alike while they settled.
const FEWEST_RECORDS: usize = 3;

/// Mean square of an effect over that of a bias, about the levels, below which the effect leads instead.
const FAR_LESS: f64 = 0.5;

impl StructureSelection<'_> {
    /// A bias that drifts alike in all records, in the given model or beside a base refitted near it, where it is the largest part of the difference:
    /// with its offset, if that is the same in all records, or about the levels. None where there is no such bias. The candidate of a search that has
    /// a bias alone is tried as well.
    pub fn drifting_bias(&self, given: &Fitted, base: &Fitted, candidates: &[Fitted]) -> Option<Fitted> {
        let beside_given = self.bias()?;
        let found = self.as_drifting(&beside_given, given, base);
        let beside_base = || self.as_drifting(&self.bias_beside_base(&beside_given)?, given, base);
        let as_searched = || {
            let is_bias =
                |one: &&Fitted| one.space.hypothesis.effects == [SENSOR_BIAS] && one.space.hypothesis.base_free;
            let here = candidates.iter().find(is_bias)?.clone();
            let there = here.on(&self.check)?;
            self.as_drifting(&[here, there], given, base)
        };
        found.or_else(beside_base).or_else(as_searched)
    }

    /// Whether a lead has a far smaller residual than a bias on the fit and on the check records, about the levels.
    pub fn is_rather_lead(&self, lead: &Fitted, bias: &Fitted) -> bool {
        [&self.fit, &self.check].into_iter().all(|traces| {
            let left = |one: &Fitted| Some(PlainFit::beside_levels(&one.model, traces)?.mean_square());
            left(lead).zip(left(bias)).is_some_and(|(lead, bias)| lead < FAR_LESS * bias)
        })
    }

    /// The outcome on stretches of these records, which are too short for a drift, with a bias identified on the whole records: added to an adequate
    /// explanation where it is significant, otherwise one that drifts and leads.
    pub fn with_bias(&self, outcome: Outcome) -> Outcome {
        if matches!(outcome.standing, Standing::Adequate) {
            let Some(found) = self.beside_bias(outcome.explanation.as_ref().unwrap_or(&outcome.base)) else {
                return outcome;
            };
            let mut candidates = outcome.candidates.clone();
            candidates.push(found.clone());
            sort_by_number(&mut candidates, |one| one.bic);
            return Outcome { candidates, explanation: Some(found), ..outcome };
        }
        let Some(bias) = self.drifting_bias(&outcome.given, &outcome.base, &outcome.candidates) else { return outcome };
        let forms = vec![bias.clone().into()];
        Outcome { explanation: Some(bias), standing: Standing::Leading { forms }, note: None, ..outcome }
    }

    /// An explanation that is adequate about the levels, with a bias of the sensor added; none where that is not significant, not adequate, or does
    /// not reduce the residual of the check records.
    fn beside_bias(&self, current: &Fitted) -> Option<Fitted> {
        let is_bias = |term: MeasurementTerm| term == MeasurementTerm::Bias;
        if current.space.terms().any(is_bias) || self.is_over() {
            return None;
        }
        let found = add_measurement_term(current, self.given, &self.fit);
        let found = self.refined(found.into_iter().find(|found| found.space.terms().any(is_bias))?);
        let left = |model: &Model| Some(PlainFit::as_it_is(model, &self.check)?.mean_square());
        let takes_part = left(&found.model)? < CLOSES_NOTHING.powi(2) * left(&current.model)?;
        (takes_part && self.is_significant(&found, current) && self.is_adequate(Some(&found), current)).then_some(found)
    }

    /// The bias on the fit records, given with that on the check records, if it drifts as required.
    fn as_drifting(&self, [here, there]: &[Fitted; 2], given: &Fitted, base: &Fitted) -> Option<Fitted> {
        let &[offset, drift] = here.model.effects.active_values_of(SENSOR_BIAS)? else { return None };
        let drifts = || here.factors.iter().chain(&there.factors).map(|factors| factors[DRIFT] / drift);
        let (least, greatest) =
            drifts().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), one| (low.min(one), high.max(one)));
        if least <= 0.0 || greatest > GREATEST_DRIFT_RATIO * least || self.as_healthy().is_some() {
            return None;
        }
        let records = self.fit.iter().chain(&self.check).map(|trace| trace.record.duration_s());
        let drifted = drift * records.fold(f64::INFINITY, f64::min);
        // A level that returns to zero began to settle before its record.
        let is_of_one_level = drifts().count() >= FEWEST_RECORDS
            && self.is_steady_bias(here, there)
            && drifted * offset.signum() > LEAST_DRIFTED * offset.abs()
            && self.left_by_level(&here.model, base).is_some()
            && self.stands(&here.clone().into(), given, base);
        let limits = if drifts().count() >= FEWEST_RECORDS && greatest < ONE_DRIFT_RATIO * least {
            [GREATEST_LEFT_BESIDE_ONE_DRIFT, LEAST_LEFT_BY_BASE_BESIDE_ONE_DRIFT]
        } else {
            [GREATEST_LEFT, LEAST_LEFT_BY_BASE]
        };
        (is_of_one_level || self.is_mostly_drift(&here.model, base, limits) == Some(true)).then(|| here.clone())
    }

    /// Whether a model with a drift leaves at most this share of the given model's mean square on the fit and on the check records, about the levels,
    /// without an increase on any record, and the base, and the model without the drift, leave at least so many times as much.
    fn is_mostly_drift(
        &self,
        with: &Model,
        base: &Fitted,
        [greatest_left, least_left_by_base]: [f64; 2],
    ) -> Option<bool> {
        let without = Model { effects: with.effects.without(find(SENSOR_BIAS)?), ..with.clone() };
        let is_most = |traces: &[Trace<'_>]| {
            let [given, with, by_base, without] =
                [self.given, with, &base.model, &without].map(|model| PlainFit::beside_levels(model, traces));
            let (given, with, by_base, without) = (given?, with?, by_base?, without?);
            let grows = with.mean_squares().iter().zip(given.mean_squares()).any(|(with, given)| *with > given);
            let [given, with, by_base, without] = [given, with, by_base, without].map(|fit| fit.mean_square());
            Some(!grows && with < greatest_left * given && by_base.min(without) > least_left_by_base * with)
        };
        Some(is_most(&self.fit)? && is_most(&self.check)?)
    }

    /// A bias of the sensor in the given model, on the fit and on the check records; none where the given model already has one.
    fn bias(&self) -> Option<[Fitted; 2]> {
        let bias = find(SENSOR_BIAS).filter(|bias| self.given.effects.active_values_of(bias.name).is_none())?;
        let hypothesis = Hypothesis { effects: vec![bias.name], ..Hypothesis::default() };
        let here = Fitted::at_start(Space::new(hypothesis, self.given, &self.given.base, 0.0), &self.fit)?;
        let there = here.on(&self.check)?;
        Some([here, there])
    }

    /// The same beside a base refitted near the given one, if the drift in the given model has one sign in all records; none otherwise.
    fn bias_beside_base(&self, [here, there]: &[Fitted; 2]) -> Option<[Fitted; 2]> {
        const ITERATIONS: usize = 12;
        let rises = |fitted: &Fitted| fitted.factors.iter().all(|factors| factors[DRIFT] > 0.0);
        let falls = |fitted: &Fitted| fitted.factors.iter().all(|factors| factors[DRIFT] < 0.0);
        if !(rises(here) && rises(there) || falls(here) && falls(there)) {
            return None;
        }
        let hypothesis = Hypothesis { effects: vec![SENSOR_BIAS], base_free: true, ..Hypothesis::default() };
        let space = Space::new(hypothesis, self.given, &self.given.base, 0.0);
        let here = self.by_likelihood(PlainFit::search(space, &self.fit, ITERATIONS)?)?;
        let there = here.on(&self.check)?;
        (!here.space.is_base_at_bound(&here.x)).then_some([here, there])
    }

    /// Whether a bias is the same in the fit and in the check records.
    fn is_steady_bias(&self, here: &Fitted, there: &Fitted) -> bool {
        is_steady(&[(here, &self.fit), (there, &self.check)])
    }

    /// Excess of a model with a level over that of the given model, the larger of the shares on the fit and on the check records; none where the
    /// level is not the largest part.
    fn left_by_level(&self, with: &Model, base: &Fitted) -> Option<f64> {
        let noise = self.noise.mean_squares();
        let (fitted, checked) = noise.split_at(self.fit.len().min(noise.len()));
        let left = |traces: &[Trace<'_>], noise: &[f64]| {
            let [given, with, by_base] = [self.given, with, &base.model].map(|model| PlainFit::as_it_is(model, traces));
            let [given, with, by_base] = [above(&given?, noise), above(&with?, noise), above(&by_base?, noise)];
            let is_largest = with < GREATEST_LEFT * given && by_base > LEAST_LEFT_BY_BASE * with;
            is_largest.then_some(with / given)
        };
        Some(left(&self.fit, fitted)?.max(left(&self.check, checked)?))
    }

    /// The common level, listed as a bias of the sensor; none where the records share none, or another part of the difference is as large.
    #[allow(clippy::cast_precision_loss)] // counts of samples and records
    pub fn common_level(&self, base: &Fitted) -> Option<Lead> {
        let bias = find(SENSOR_BIAS)?;
        let [here, there] = self.bias()?;
        if !self.is_steady_bias(&here, &there) {
            return None;
        }
        let without = PlainFit::as_it_is(self.given, &self.fit)?;
        let levels = without.residuals.iter().map(|left| left.iter().sum::<f64>() / left.len().max(1) as f64);
        let offset = levels.sum::<f64>() / without.residuals.len() as f64;
        let effects = self.given.effects.with(bias, &[offset, 0.0]).ok()?;
        let with = Model { effects, ..self.given.clone() };
        let share = 1.0 - self.left_by_level(&with, base)?;
        let parameters = bias.parameters.iter().map(|parameter| parameter.name);
        Some(Lead {
            name: bias.name,
            family: family(bias.name),
            share: Some(share),
            nonlinear_share: None,
            check_rms: Some(PlainFit::as_it_is(&with, &self.check)?.mean_square().sqrt()),
            parameters: parameters.zip([offset, 0.0]).collect(),
            only_in: None,
            why_not: "all records share this level: a sensor bias, a steady load, or the original zero of the sensor"
                .to_owned(),
        })
    }
}

/// Sum over the records of the mean square above the noise: short records count as much as long ones.
fn above(fit: &PlainFit, noise: &[f64]) -> f64 {
    fit.mean_squares().iter().zip(noise).map(|(left, noise)| left - noise).sum::<f64>().max(0.0)
}

#[cfg(test)]
mod tests {
    use crate::{
        diagnose::{
            Verdict, diagnose,
            three_records::{behind_gear, measured_as, said, three_records_of},
        },
        signal::record::Record,
    };
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Base, Model, table},
    };

    #[test]
    #[ignore = "slow"]
    fn a_level_that_drifts_alike_in_all_records_is_a_bias_that_leads() {
        let given = Model::from_set(&table()[0]);
        let records = three_records_of(&given, 3.0, 6.0);
        let of = |levels: [f64; 3], drifts: [f64; 3]| {
            let drifting = |(record, (level, drift)): (&Record, (f64, f64))| {
                measured_as(&behind_gear(record, level), |t, position| position + drift * t)
            };
            let each = levels.into_iter().zip(drifts);
            said(&given, &records.iter().zip(each).map(drifting).collect::<Vec<Record>>())
        };
        let alike = [0.4; 3];
        let (verdict, found) = of(alike, [0.02; 3]);
        let (name, values, _) = found.unwrap();
        assert!(verdict == Verdict::Leading && name == "sensor_bias", "{verdict:?} {name}");
        assert!((values[0] - 0.4).abs() < 0.02 && (values[1] - 0.02).abs() < 0.002, "{values:?}");
        assert_eq!(of(alike, [0.0; 3]).0, Verdict::Unexplained);
        assert_eq!(of(alike, [0.02, 0.02, -0.02]).0, Verdict::Unexplained);
        // Where references were set anew, a drift leads by itself if it is most of the difference about the levels.
        let anew = [0.4, -0.1, 0.2];
        assert_eq!(of(anew, [0.05; 3]).1.map(|(name, ..)| name), Some("sensor_bias"));
        assert_eq!(of(anew, [0.005; 3]).0, Verdict::Unexplained);
    }

    #[test]
    #[ignore = "slow"]
    fn play_leads_before_a_bias_that_drifts_where_it_takes_far_more() {
        let given = Model::from_set(&table()[0]);
        let [k, p, omega, zeta] = given.base.values();
        let base = Base::from_values([0.9 * k, p, 0.7 * omega, zeta]).unwrap();
        let of = |gap: f64, drift: f64| {
            let effects = Effects::default().with(find("backlash").unwrap(), &[gap]).unwrap();
            let drifting = |record: &Record| measured_as(&behind_gear(record, 0.3), |t, position| position + drift * t);
            let records = three_records_of(&Model { base, effects, ..given.clone() }, 3.0, 6.0);
            said(&given, &records.iter().map(drifting).collect::<Vec<Record>>()).1.map(|(name, ..)| name)
        };
        assert_eq!([of(1.2, 0.05), of(0.3, 0.1)], [Some("backlash"), Some("sensor_bias")]);
    }

    #[test]
    #[ignore = "slow"]
    fn a_bias_that_drifts_leads_beside_a_base_that_is_off() {
        let given = Model::from_set(&table()[0]);
        let [k, p, omega, zeta] = given.base.values();
        let of = |drift: f64| {
            let base = Base::from_values([0.85 * k, p, 0.8 * omega, zeta]).unwrap();
            let drifting = |record: &Record| measured_as(&behind_gear(record, 0.3), |t, position| position + drift * t);
            let records = three_records_of(&Model { base, ..given.clone() }, 3.0, 6.0);
            said(&given, &records.iter().map(drifting).collect::<Vec<Record>>())
        };
        let (verdict, found) = of(0.15);
        let (name, values, _) = found.unwrap();
        assert!(verdict == Verdict::Leading && name == "sensor_bias", "{verdict:?} {name}");
        assert!((values[0] - 0.3).abs() < 0.05 && (values[1] - 0.15).abs() < 0.01, "{values:?}");
        assert!(of(0.0).1.is_none_or(|(name, ..)| name != "sensor_bias"));
    }

    #[test]
    #[ignore = "slow"]
    fn a_level_that_all_records_share_is_listed_where_it_is_the_largest_part_and_not_levels_of_sessions() {
        let given = Model::from_set(&table()[0]);
        let records = three_records_of(&given, 3.0, 6.0);
        let listed = |levels: [f64; 3]| {
            let records: Vec<_> =
                records.iter().zip(levels).map(|(record, level)| behind_gear(record, level)).collect();
            let diagnosis = diagnose(&given, &records[..2], &records[2..], &[], None).unwrap();
            assert_eq!(diagnosis.verdict, Verdict::Unexplained);
            diagnosis.leads.first().filter(|lead| lead.name == "sensor_bias").map(|lead| lead.parameters["offset"])
        };
        let offset = listed([-0.5; 3]).unwrap();
        assert!((offset + 0.5).abs() < 0.01, "{offset}");
        assert_eq!((listed([-0.5, 0.3, -0.2]), listed([-0.02; 3])), (None, None));
    }
}
