//! Quantised records: residuals from the expected output of the quantiser, and when quantisation is named.

use super::{
    candidates::add_effect,
    diagnosis::Lead,
    fitted::Fitted,
    hypothesis::{Hypothesis, family},
    plain_fit::PlainFit,
    quantiser::Quantiser,
    rivals::HYSTERESIS,
    selection::StructureSelection,
    space::Space,
    trace::Trace,
};
use crate::digits::with_unit;
use actuator_fmu::parameters::Model;

pub const QUANTISATION: &str = "quantisation";

impl StructureSelection<'_> {
    /// Where the measurement is quantised coarsely, residuals are taken from the expected output of the quantiser.
    pub fn identify_quantiser(&mut self) {
        // Step over the rms of the innovations, below which quantisation is negligible.
        const NEGLIGIBLE_STEP: f64 = 0.3;
        let Some(step) = self.quantisation_step() else { return };
        let free = Hypothesis { base_free: true, ..Hypothesis::default() };
        let Some(mut fitted) = self.fit(free, self.given) else { return };
        let innovations = fitted.noise.iter().map(|noise| noise.innovation_rms).fold(f64::INFINITY, f64::min);
        if step < NEGLIGIBLE_STEP * innovations {
            // As fine as the digits of a file. If it matters, it does so only once the missing effects are found.
            return;
        }
        if step < fitted.rms() {
            // The missing effect may hide the quantisation.
            let nearer = add_effect(&fitted, self.given, &self.fit);
            let Some(nearest) = nearer.into_iter().next().filter(|nearest| nearest.rms() < step) else { return };
            fitted = nearest;
        }
        self.identify_quantiser_noise(&fitted.model);
    }

    /// Estimates the noise ahead of the quantiser as that with the smallest residual of this model on the fit records. Returns whether the quantiser
    /// changed.
    pub fn identify_quantiser_noise(&mut self, model: &Model) -> bool {
        // Noise, in steps: from hardly any to enough to linearise the quantiser.
        const NOISE: [f64; 6] = [0.035, 0.055, 0.08, 0.12, 0.18, 0.27];
        // Residual, in steps, above which noise dominates; quantisation alone has 0.29 rms.
        const NOISE_DOMINATED: f64 = 2.0;
        let before = self.quantiser();
        let Some(step) = self.quantisation_step() else { return false };
        let space = Space::new(Hypothesis::default(), model, &self.given.base, 0.0);
        let mut residual_rms = |candidate: Option<Quantiser>| {
            self.fit.iter_mut().for_each(|trace| trace.quantiser = candidate);
            Fitted::at(space.clone(), Vec::new(), &self.fit).map_or(f64::INFINITY, |at| at.rms())
        };
        let mut best = (residual_rms(None), None);
        if best.0 < NOISE_DOMINATED * step {
            for quantiser in NOISE.map(|noise| Some(Quantiser { step, noise })) {
                let rms = residual_rms(quantiser);
                if rms < best.0 {
                    best = (rms, quantiser);
                }
            }
        }
        // A step finer than the residual cannot be identified.
        best.1 = best.1.filter(|_| best.0 < step);
        self.quantise(best.1);
        best.1 != before
    }

    /// The common quantisation step of all measurements.
    pub fn quantisation_step(&self) -> Option<f64> {
        let steps = self.fit.iter().chain(&self.check).map(Trace::step);
        let (least, greatest) =
            steps.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), step| (low.min(step), high.max(step)));
        (least > 0.0 && greatest < 1.01 * least).then_some(least)
    }

    /// Why play or friction narrower than a step of the positions does not lead; none where it is wider, or the positions are not quantised. Within a
    /// step it is not distinguishable from rounding together with another base.
    pub fn is_within_step(&self, lead: &Fitted) -> Option<String> {
        let (band, step) = self.band_and_step(lead)?;
        let unit = self.given.unit().name();
        (band < step).then(|| {
            format!(
                "its width, {}, is less than the step of the positions, {}",
                with_unit(band, 3, unit),
                with_unit(step, 3, unit)
            )
        })
    }

    /// Whether play or friction is so narrow relative to a step, where rounding is most of the difference, that uneven steps, or steps whose edges
    /// depend on the direction, look like it.
    pub fn is_of_uneven_steps(&self, found: &Fitted) -> bool {
        const OF_STEP: f64 = 0.25;
        self.band_and_step(found).is_some_and(|(band, step)| band < OF_STEP * step && self.is_mostly_rounding(step))
    }

    /// Full width of play or friction, and the step of the positions; none without either.
    fn band_and_step(&self, found: &Fitted) -> Option<(f64, f64)> {
        let effect = HYSTERESIS.into_iter().find(|effect| found.space.hypothesis.effects.contains(effect))?;
        let value = found.model.effects.active_values_of(effect)?.first()?;
        let is_whole = effect == "backlash" || effect == "command_backlash";
        Some((if is_whole { *value } else { 2.0 * value }, self.quantisation_step()?))
    }

    /// Whether the variance of rounding to this step, q²/12, is most of the given model's mean square about the levels, on the fit and on the check
    /// records: a healthy actuator has it as well.
    pub fn is_mostly_rounding(&self, step: f64) -> bool {
        const MOST: f64 = 0.5;
        let is_most = |traces: &[Trace<'_>]| {
            let left = PlainFit::beside_levels(self.given, traces).map(|given| given.mean_square());
            left.is_some_and(|left| step * step / 12.0 > MOST * left)
        };
        is_most(&self.fit) && is_most(&self.check)
    }

    /// The rounding of the positions, as a lead beside other parts of the difference; none where it is a negligible share of the given model's mean
    /// square on the check records. It is read from the positions: no search is needed, and no effect explains it.
    pub fn rounding(&self, noise_rms: f64) -> Option<Lead> {
        const NEXT_TO_NOTHING: f64 = 0.01;
        let step = self.significant_quantisation(noise_rms)?;
        let variance = step * step / 12.0;
        let share = variance / PlainFit::as_it_is(self.given, &self.check)?.mean_square();
        (share > NEXT_TO_NOTHING).then(|| Lead {
            name: QUANTISATION,
            family: family(QUANTISATION),
            share: None,
            nonlinear_share: None,
            check_rms: None,
            parameters: [("step", step)].into(),
            only_in: None,
            why_not: format!(
                "all positions are multiples of it: rounding of {} rms, {:.0} % of the variance of the difference",
                with_unit(variance.sqrt(), 3, self.given.unit().name()),
                100.0 * share.min(1.0)
            ),
        })
    }

    /// The step, where it is coarse relative to the noise.
    pub fn significant_quantisation(&self, noise_rms: f64) -> Option<f64> {
        // A step q adds q²/12 to the variance; from this share of the noise's on it is named.
        const MATERIAL_SHARE: f64 = 0.02;
        let known = self.given.effects.active().any(|(effect, _)| effect.name == QUANTISATION);
        let step = self.quantisation_step()?;
        (!known && step * step / 12.0 > MATERIAL_SHARE * noise_rms * noise_rms).then_some(step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{
            Verdict, diagnose,
            measured_noise::MeasuredNoise,
            three_records::{behind_gear, measured_as, said, three_records_of},
        },
        inspect::segments,
        progress::Work,
        signal::{Command, record::Record},
    };
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Model, table},
    };

    fn rounded(record: &Record, step: f64) -> Record {
        measured_as(&behind_gear(record, 0.0), |_, position| (position / step).round() * step)
    }

    #[test]
    #[ignore = "slow"]
    fn rounding_that_is_most_of_a_difference_leads_beside_an_error_that_nothing_explains() {
        let given = Model::from_set(&table()[0]);
        let of = |step: f64| {
            let records = three_records_of(&given, 3.0, 6.0);
            said(&given, &records.iter().map(|record| rounded(record, step)).collect::<Vec<Record>>())
        };
        let (verdict, found) = of(0.2);
        let (name, values, _) = found.unwrap();
        assert!(verdict == Verdict::Leading && name == "quantisation", "{verdict:?} {name}");
        assert!((values[0] - 0.2).abs() < 1e-6, "{values:?}");
        assert_eq!(of(0.05), (Verdict::Unexplained, None));
    }

    #[test]
    #[ignore = "slow"]
    fn rounding_is_most_of_a_difference_about_the_level_of_each_record() {
        let given = Model::from_set(&table()[0]);
        let levels = [0.3, -0.2, 0.1];
        let records = three_records_of(&given, 3.0, 6.0);
        let of = |(record, level): (&Record, f64)| rounded(&measured_as(record, |_, position| position + level), 0.2);
        let found = said(&given, &records.iter().zip(levels).map(of).collect::<Vec<Record>>()).1;
        assert_eq!(found.map(|(name, ..)| name), Some("quantisation"));
    }

    #[test]
    #[ignore = "slow"]
    fn play_within_a_step_of_the_positions_does_not_lead() {
        let given = Model::from_set(&table()[0]);
        let effects = Effects::default().with(find("backlash").unwrap(), &[0.3]).unwrap();
        let records = three_records_of(&Model { effects, ..given.clone() }, 3.0, 6.0);
        let of = |step: f64| {
            let coarse: Vec<Record> = records.iter().map(|record| rounded(record, step)).collect();
            said(&given, &coarse).1.map(|(name, ..)| name)
        };
        assert_eq!(of(0.02), Some("backlash"));
        assert!(of(0.4).is_none_or(|name| name == "quantisation"));
    }

    #[test]
    fn play_of_a_fraction_of_a_step_is_of_uneven_steps_where_rounding_is_most() {
        let given = Model::from_set(&table()[0]);
        let with = |gap: f64| {
            let effects = Effects::default().with(find("backlash").unwrap(), &[gap]).unwrap();
            Model { effects, ..given.clone() }
        };
        let is_of_steps = |gap: f64, step: f64| {
            let records = three_records_of(&with(gap), 3.0, 6.0);
            let coarse = |record: &Record| measured_as(record, |_, position| (position / step).round() * step);
            let records: Vec<Record> = records.iter().map(coarse).collect();
            let (fit, check) = records.split_at(2);
            let noise = MeasuredNoise::of(&records.iter().collect::<Vec<&Record>>(), &[]);
            let work = Work::new(Vec::new(), None);
            let selection = StructureSelection::new(&given, fit, check, noise, None, &work);
            let hypothesis = Hypothesis { effects: vec!["backlash"], ..Hypothesis::default() };
            let found = Fitted::at_start(Space::new(hypothesis, &with(gap), &given.base, 0.0), &selection.fit).unwrap();
            selection.is_of_uneven_steps(&found)
        };
        assert!(is_of_steps(0.2, 1.2) && !is_of_steps(0.4, 1.2));
        // Fine steps are a small part of the difference that play makes.
        assert!(!is_of_steps(0.2, 0.1));
    }

    #[test]
    #[ignore = "slow"]
    fn rounding_that_is_a_lesser_part_is_listed_also_where_rows_were_lost() {
        let given = Model::from_set(&table()[0]);
        let records: Vec<Record> =
            three_records_of(&given, 3.0, 6.0).iter().map(|record| rounded(record, 0.08)).collect();
        let lossy = |record: &Record| {
            let kept = |values: &[f64]| {
                let each = values.iter().enumerate().filter(|(row, _)| row % 97 != 50);
                each.map(|(_, value)| *value).collect::<Vec<f64>>()
            };
            let whole = record.to_command();
            let command = Command { time: kept(&whole.time), command: kept(&whole.command) };
            let position = kept(record.position());
            let made = Record::new(command, position, record.unit(), record.interpolation(), "with rows lost").unwrap();
            segments(made).remove(0)
        };
        let steps = |records: &[Record]| {
            let diagnosis = diagnose(&given, &records[..2], &records[2..], &[], None).unwrap();
            assert_eq!(diagnosis.verdict, Verdict::Unexplained);
            let of_rounding = diagnosis.leads.into_iter().find(|lead| lead.name == "quantisation");
            of_rounding.map(|lead| lead.parameters["step"])
        };
        for records in [records.iter().map(lossy).collect(), records] {
            let step = steps(&records).unwrap();
            assert!((step - 0.08).abs() < 1e-6, "{step}");
        }
    }
}
