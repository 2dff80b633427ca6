//! A bias of the sensor that is the largest part of a difference: the same level, and drift, in every record.
//!
//! What is judged on actuators of another structure has a level of its own in each record, since a reference may be set anew from session to session.
//! A level that all records share is one of the sensor, if neither a base takes it (of a command to one side a gain that is off leaves a level) nor another
//! part of the difference is as large.

use super::{
    fitted::Fitted, hypothesis::Hypothesis, plain_fit::PlainFit, selection::StructureSelection, space::Space,
    steady_level::is_steady,
};
use actuator_fmu::{effects::find, parameters::Model};

/// The effect.
pub const SENSOR_BIAS: &str = "sensor_bias";

/// Of the excess over the noise that the given model leaves, what a bias leaves at most, of fitted and of check records.
const GREATEST_LEFT: f64 = 0.35;

/// Of the mean square that a steady bias leaves of the fitted records, what one that drifts leaves at most.
const CLEARLY_LESS: f64 = 0.6;

/// How many times as much a refitted base leaves of each.
const LEAST_LEFT_BY_BASE: f64 = 2.0;

impl StructureSelection<'_> {
    #[allow(clippy::cast_precision_loss)] // counts of samples and records
    /// The given model with a bias, where that leads: with a drift where that is clearly better, since a short record tells next to nothing of one.
    pub fn leading_bias(&self, base: &Fitted) -> Option<Fitted> {
        let bias = find(SENSOR_BIAS).filter(|bias| self.given.effects.active_values_of(bias.name).is_none())?;
        let hypothesis = Hypothesis { effects: vec![bias.name], ..Hypothesis::default() };
        let drifting = Fitted::at_start(Space::new(hypothesis, self.given, &self.given.base, 0.0), &self.fit)?;
        let without = PlainFit::as_it_is(self.given, &self.fit)?;
        let levels = without.residuals.iter().map(|left| left.iter().sum::<f64>() / left.len().max(1) as f64);
        let offset = levels.sum::<f64>() / without.residuals.len() as f64;
        let effects = self.given.effects.with(bias, &[offset, 0.0]).ok()?;
        let steady = Fitted { model: Model { effects, ..self.given.clone() }, ..drifting.clone() };
        let left = |form: &Fitted| Some(PlainFit::as_it_is(&form.model, &self.fit)?.mean_square());
        let is_better = left(&drifting)? < CLEARLY_LESS * left(&steady)?;
        let forms = if is_better { vec![drifting, steady] } else { vec![steady] };
        forms.into_iter().find(|form| self.objection_to_bias(form, base).is_none())
    }

    /// Why a bias does not lead; none where it does.
    pub fn objection_to_bias(&self, lead: &Fitted, base: &Fitted) -> Option<String> {
        if let Some(reason) = self.as_healthy() {
            return Some(reason);
        }
        let is_largest_part = self.is_largest_part(lead, base).unwrap_or(false);
        (!is_largest_part)
            .then(|| "it is not the largest part of the difference, or not the same in all records".to_owned())
    }

    /// None where a model does not move through the records.
    fn is_largest_part(&self, lead: &Fitted, base: &Fitted) -> Option<bool> {
        let there = lead.on(&self.check)?;
        if !is_steady(&[(lead, &self.fit), (&there, &self.check)]) {
            return Some(false);
        }
        let noise = self.noise.mean_squares();
        let (fitted, checked) = noise.split_at(self.fit.len().min(noise.len()));
        for (traces, noise) in [(&self.fit, fitted), (&self.check, checked)] {
            let [before, after, by_base] =
                [self.given, &lead.model, &base.model].map(|model| PlainFit::as_it_is(model, traces));
            let (before, after, by_base) = (before?, after?, by_base?);
            let [of_given, of_lead, of_base] = [&before, &after, &by_base].map(|fit| above(fit, noise));
            let rises = before.mean_squares().iter().zip(after.mean_squares()).any(|(before, after)| after > *before);
            if rises || of_lead > GREATEST_LEFT * of_given || of_base < LEAST_LEFT_BY_BASE * of_lead {
                return Some(false);
            }
        }
        Some(true)
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
    fn a_level_that_all_records_share_leads_where_it_is_the_largest_part_and_not_levels_of_sessions() {
        let given = Model::from_set(&table()[0]);
        let records = three_records(&given, 3.0);
        let said = |levels: [f64; 3]| {
            let records: Vec<_> =
                records.iter().zip(levels).map(|(record, level)| behind_gear(record, level)).collect();
            let diagnosis = diagnose(&given, &records[..2], &records[2..], &[], None).unwrap();
            let offset = diagnosis.findings.first().map(|finding| (finding.name, finding.parameters[0].value));
            (diagnosis.verdict, offset)
        };
        let (verdict, found) = said([-0.5; 3]);
        let (name, offset) = found.unwrap();
        assert!(verdict == Verdict::Leading && name == "sensor_bias" && (offset + 0.5).abs() < 0.01, "{name} {offset}");
        assert_eq!(said([-0.5, 0.3, -0.2]), (Verdict::Unexplained, None));
        assert_eq!(said([-0.02; 3]), (Verdict::Unexplained, None));
    }
}
