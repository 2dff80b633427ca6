//! Quantised records: residuals against the expected output of the quantiser, and when quantisation is worth a name.

use super::{
    candidates::with_one_more,
    fitted::Fitted,
    hypothesis::Hypothesis,
    quantiser::{self, Rounding},
    selection::Study,
    space::Space,
};
use actuator_fmu::parameters::Model;

impl Study<'_> {
    /// Where the measurement was rounded coarsely, residuals are taken from what is to be expected of the rounding.
    pub fn expect_rounding(&mut self) {
        // Of what the past of a residual does not foretell.
        const FINE: f64 = 0.3;
        let Some(step) = self.lattice() else { return };
        let free = Hypothesis { base_free: true, ..Hypothesis::default() };
        let Some(mut fitted) = self.fit(free, self.given) else { return };
        let innovations = fitted.noise.iter().map(|noise| noise.innovation_rms).fold(f64::INFINITY, f64::min);
        if step < FINE * innovations {
            // As fine as the digits of a file. Where it shows after all, it does so once the rest is explained.
            return;
        }
        if step < fitted.rms() {
            // Whatever is missing may hide the rounding.
            let nearer = with_one_more(&fitted, self.given, &self.fit);
            let Some(nearest) = nearer.into_iter().next().filter(|nearest| nearest.rms() < step) else { return };
            fitted = nearest;
        }
        self.expect_rounding_of(&fitted.model);
    }

    /// Takes the noise ahead of the rounding to be what leaves least of the fitted records behind this model. Whether that is another than
    /// before.
    pub fn expect_rounding_of(&mut self, model: &Model) -> bool {
        // From next to none to that from which on hardly anything is left of the lattice.
        const NOISE: [f64; 6] = [0.035, 0.055, 0.08, 0.12, 0.18, 0.27];
        // In steps; rounding alone leaves 0.29.
        const DROWNED: f64 = 2.0;
        let before = self.fit.first().and_then(|trace| trace.rounding);
        let Some(step) = self.lattice() else { return false };
        let space = Space::new(Hypothesis::default(), model, &self.given.base, 0.0);
        let mut left = |rounding: Option<Rounding>| {
            self.fit.iter_mut().for_each(|trace| trace.rounding = rounding);
            Fitted::at(space.clone(), Vec::new(), &self.fit).map_or(f64::INFINITY, |at| at.rms())
        };
        let mut best = (left(None), None);
        if best.0 < DROWNED * step {
            for rounding in NOISE.map(|noise| Some(Rounding { step, noise })) {
                let rms = left(rounding);
                if rms < best.0 {
                    best = (rms, rounding);
                }
            }
        }
        // A lattice finer than what is left does not show.
        best.1 = best.1.filter(|_| best.0 < step);
        self.fit.iter_mut().chain(&mut self.check).for_each(|trace| trace.rounding = best.1);
        best.1 != before
    }

    /// Step of the lattice on which all measurements lie.
    pub fn lattice(&self) -> Option<f64> {
        let steps: Vec<f64> =
            self.fit.iter().chain(&self.check).map(|trace| quantiser::step(trace.record.position())).collect();
        let (least, greatest) =
            steps.iter().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), step| (low.min(*step), high.max(*step)));
        (least > 0.0 && greatest < 1.01 * least).then_some(least)
    }

    /// Step of a lattice that is coarse beside the noise.
    pub fn quantisation(&self, noise_rms: f64) -> Option<f64> {
        // A step q adds q²/12 to the variance; this share of it is worth a name.
        const MATERIAL_SHARE: f64 = 0.02;
        let known = self.given.effects.active().any(|(effect, _)| effect.name == "quantisation");
        let step = self.lattice()?;
        (!known && step * step / 12.0 > MATERIAL_SHARE * noise_rms * noise_rms).then_some(step)
    }
}
