//! Quantised records: residuals against the expected output of the quantiser, and when quantisation is worth a name.

use super::{
    candidates::add_effect,
    fitted::Fitted,
    hypothesis::Hypothesis,
    plain_fit::PlainFit,
    quantiser::{self, Quantiser},
    selection::StructureSelection,
    space::Space,
    trace::Trace,
};
use actuator_fmu::parameters::Model;

impl StructureSelection<'_> {
    /// Where the measurement was quantised coarsely, residuals are taken from the expected output of the quantiser.
    pub fn identify_quantiser(&mut self) {
        // As a share of the innovations.
        const NEGLIGIBLE_STEP: f64 = 0.3;
        let Some(step) = self.quantisation_step() else { return };
        let free = Hypothesis { base_free: true, ..Hypothesis::default() };
        let Some(mut fitted) = self.fit(free, self.given) else { return };
        let innovations = fitted.noise.iter().map(|noise| noise.innovation_rms).fold(f64::INFINITY, f64::min);
        if step < NEGLIGIBLE_STEP * innovations {
            // As fine as the digits of a file. If it matters, it does so once the missing effects are found.
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

    /// Estimates the noise ahead of the quantiser as that with the least residual of this model on the fitted records. Returns whether the
    /// quantiser changed.
    pub fn identify_quantiser_noise(&mut self, model: &Model) -> bool {
        // In steps: from hardly any to enough to linearise the quantiser.
        const NOISE: [f64; 6] = [0.035, 0.055, 0.08, 0.12, 0.18, 0.27];
        // In steps; quantisation alone has 0.29 rms.
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
        // A step finer than the residual does not show.
        best.1 = best.1.filter(|_| best.0 < step);
        self.quantise(best.1);
        best.1 != before
    }

    /// The common quantisation step of all measurements.
    pub fn quantisation_step(&self) -> Option<f64> {
        let steps: Vec<f64> =
            self.fit.iter().chain(&self.check).map(|trace| quantiser::step_of(trace.record.position())).collect();
        let (least, greatest) =
            steps.iter().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), step| (low.min(*step), high.max(*step)));
        (least > 0.0 && greatest < 1.01 * least).then_some(least)
    }

    /// Whether the variance of rounding to this step, q²/12, is most of the mean square that the given model leaves of the fitted and of the check records.
    pub fn is_mostly_rounding(&self, step: f64) -> bool {
        const MOST: f64 = 0.5;
        let is_most = |traces: &[Trace<'_>]| {
            let left = PlainFit::as_it_is(self.given, traces).map(|given| given.mean_square());
            left.is_some_and(|left| step * step / 12.0 > MOST * left)
        };
        is_most(&self.fit) && is_most(&self.check)
    }

    /// The step, where it is coarse beside the noise.
    pub fn significant_quantisation(&self, noise_rms: f64) -> Option<f64> {
        // A step q adds q²/12 to the variance; this share of it is worth a name.
        const MATERIAL_SHARE: f64 = 0.02;
        let known = self.given.effects.active().any(|(effect, _)| effect.name == "quantisation");
        let step = self.quantisation_step()?;
        (!known && step * step / 12.0 > MATERIAL_SHARE * noise_rms * noise_rms).then_some(step)
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        diagnose::{
            Verdict,
            three_records::{behind_gear, measured_as, said, three_records_of},
        },
        signal::record::Record,
    };
    use actuator_fmu::parameters::{Model, table};

    #[test]
    #[ignore = "slow"]
    fn rounding_that_is_most_of_a_difference_leads_beside_an_error_that_nothing_explains() {
        let given = Model::from_set(&table()[0]);
        let of = |step: f64| {
            let rounded = |record: &Record| {
                measured_as(&behind_gear(record, 0.0), |_, position| (position / step).round() * step)
            };
            said(&given, &three_records_of(&given, 3.0, 6.0).iter().map(rounded).collect::<Vec<Record>>())
        };
        let (verdict, found) = of(0.2);
        let (name, values, _) = found.unwrap();
        assert!(verdict == Verdict::Leading && name == "quantisation", "{verdict:?} {name}");
        assert!((values[0] - 0.2).abs() < 1e-6, "{values:?}");
        assert_eq!(of(0.05), (Verdict::Unexplained, None));
    }
}
