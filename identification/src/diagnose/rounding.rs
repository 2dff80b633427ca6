//! Rounded measurements: the lattice that values lie on, and what is to be expected of rounding after noise.

use std::f64::consts::{PI, TAU};

use super::{
    Study,
    candidates::with_one_more,
    fitted::Fitted,
    lattice,
    space::{Hypothesis, Space},
};
use actuator_fmu::parameters::Model;

/// Rounding to a lattice after noise: what is to be expected of it.
///
/// ```text
/// E round(y + e) = y + step/π Σ_k (-1)^k / k exp(-2π²k²s²) sin(2πk y/step),    e normal with deviation s step
/// ```
///
/// The Fourier series of a sawtooth, damped by the noise: from s = 0.4 on nothing is left of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rounding {
    /// Step [deg].
    pub step: f64,
    /// s
    pub noise: f64,
}

impl Rounding {
    /// E round(y + e)
    pub fn expected(&self, position: f64) -> f64 {
        // exp(-2π²k²s²) of the first term left out is below a thousandth.
        const LAST: f64 = 0.6;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a small count
        let terms = (LAST / self.noise).ceil() as u32;
        let angle = TAU * position / self.step;
        let term = |k: u32| {
            let k = f64::from(k);
            (-2.0 * (PI * k * self.noise).powi(2)).exp() / k * (k * angle).sin()
        };
        let sum: f64 = (1..=terms).map(|k| if k % 2 == 0 { term(k) } else { -term(k) }).sum();
        position + self.step / PI * sum
    }
}

impl Study<'_> {
    /// Where the measurement was rounded coarsely, residuals are taken from what is to be expected of the rounding.
    pub(super) fn expect_rounding(&mut self) {
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
    pub(super) fn expect_rounding_of(&mut self, model: &Model) -> bool {
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
    pub(super) fn lattice(&self) -> Option<f64> {
        let steps: Vec<f64> =
            self.fit.iter().chain(&self.check).map(|trace| lattice::step(trace.record.position())).collect();
        let (least, greatest) =
            steps.iter().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), step| (low.min(*step), high.max(*step)));
        (least > 0.0 && greatest < 1.01 * least).then_some(least)
    }

    /// Step of a lattice that is coarse beside the noise.
    pub(super) fn quantisation(&self, noise_rms: f64) -> Option<f64> {
        // A step q adds q²/12 to the variance; this share of it is worth a name.
        const MATERIAL_SHARE: f64 = 0.02;
        let known = self.given.effects.active().any(|(effect, _)| effect.name == "quantisation");
        let step = self.lattice()?;
        (!known && step * step / 12.0 > MATERIAL_SHARE * noise_rms * noise_rms).then_some(step)
    }
}
