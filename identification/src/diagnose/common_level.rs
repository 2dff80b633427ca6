//! A level that all records share and that is the largest part of a difference.
//!
//! It may be a bias of the sensor that came, or the zero that the sensor always had: a model without one does not tell them apart, and healthy actuators
//! stand off their models by some level as a rule. It is listed with its size, and leads nothing.

use super::{
    diagnosis::Lead,
    fitted::Fitted,
    hypothesis::{Hypothesis, family},
    plain_fit::PlainFit,
    selection::StructureSelection,
    space::Space,
    steady_level::is_steady,
    trace::Trace,
};
use actuator_fmu::{effects::find, parameters::Model};

const SENSOR_BIAS: &str = "sensor_bias";

/// Of the excess over the noise that the given model leaves, what a level leaves at most, of fitted and of check records.
const GREATEST_LEFT: f64 = 0.35;

/// How many times as much a refitted base leaves of each: of a command to one side a gain that is off leaves a level.
const LEAST_LEFT_BY_BASE: f64 = 2.0;

impl StructureSelection<'_> {
    /// The level, as what is listed of a bias of the sensor; none where the records share none, or another part of the difference is as large.
    #[allow(clippy::cast_precision_loss)] // counts of samples and records
    pub fn common_level(&self, base: &Fitted) -> Option<Lead> {
        let bias = find(SENSOR_BIAS).filter(|bias| self.given.effects.active_values_of(bias.name).is_none())?;
        let hypothesis = Hypothesis { effects: vec![bias.name], ..Hypothesis::default() };
        let here = Fitted::at_start(Space::new(hypothesis, self.given, &self.given.base, 0.0), &self.fit)?;
        if !is_steady(&[(&here, &self.fit), (&here.on(&self.check)?, &self.check)]) {
            return None;
        }
        let without = PlainFit::as_it_is(self.given, &self.fit)?;
        let levels = without.residuals.iter().map(|left| left.iter().sum::<f64>() / left.len().max(1) as f64);
        let offset = levels.sum::<f64>() / without.residuals.len() as f64;
        let effects = self.given.effects.with(bias, &[offset, 0.0]).ok()?;
        let with = Model { effects, ..self.given.clone() };
        let noise = self.noise.mean_squares();
        let (fitted, checked) = noise.split_at(self.fit.len().min(noise.len()));
        let left = |traces: &[Trace<'_>], noise: &[f64]| {
            let [given, with, by_base] =
                [self.given, &with, &base.model].map(|model| PlainFit::as_it_is(model, traces));
            let [given, with, by_base] = [above(&given?, noise), above(&with?, noise), above(&by_base?, noise)];
            let is_largest = with < GREATEST_LEFT * given && by_base > LEAST_LEFT_BY_BASE * with;
            is_largest.then_some(with / given)
        };
        let share = 1.0 - left(&self.fit, fitted)?.max(left(&self.check, checked)?);
        let parameters = bias.parameters.iter().map(|parameter| parameter.name);
        Some(Lead {
            name: bias.name,
            family: family(bias.name),
            share: Some(share),
            nonlinear_share: None,
            check_rms: Some(PlainFit::as_it_is(&with, &self.check)?.mean_square().sqrt()),
            parameters: parameters.zip([offset, 0.0]).collect(),
            only_in: None,
            why_not: "all records share this level: a bias of the sensor, a steady load, or a zero that it always had"
                .to_owned(),
        })
    }
}

/// Sum of what a fit leaves above the noise, in mean squares: short records count as much as long ones.
fn above(fit: &PlainFit, noise: &[f64]) -> f64 {
    fit.mean_squares().iter().zip(noise).map(|(left, noise)| left - noise).sum::<f64>().max(0.0)
}

#[cfg(test)]
mod tests {
    use crate::diagnose::{
        Verdict, diagnose,
        three_records::{behind_gear, three_records},
    };
    use actuator_fmu::parameters::{Model, table};

    #[test]
    fn a_level_that_all_records_share_is_listed_where_it_is_the_largest_part_and_not_levels_of_sessions() {
        let given = Model::from_set(&table()[0]);
        let records = three_records(&given, 3.0);
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
