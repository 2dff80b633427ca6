//! Sides of a limit that no record shows: a search leaves them where it last met the motion, and nothing there is measured.

use super::{
    evidence::REQUIRED_BIC_LEAD, fitted::Fitted, outcome::Standing, selection::StructureSelection, space::Space,
    trace::Trace,
};
use actuator_fmu::{
    effects::{CHAIN, Effect, UNLIMITED},
    parameters::Model,
};

/// Of what a limit takes of the fitted records (sum of squares), what one side takes at least where a difference stays.
const LEAST_SHARE: f64 = 0.02;

impl StructureSelection<'_> {
    /// An explanation without the sides of its limits that take next to nothing of the fitted records, or leave the check records with more. One side stays.
    pub fn without_idle_sides(&self, found: &Fitted, standing: &Standing) -> Fitted {
        let two_sided = |effect: &&&Effect| {
            let is_limit =
                |place: usize| effect.parameters[place].decides && effect.parameters[place].neutral.abs() >= UNLIMITED;
            effect.parameters.len() == 2 && is_limit(0) && is_limit(1) && !self.is_given(effect.name)
        };
        let of_found = |effect: &&&Effect| found.space.hypothesis.effects.contains(&effect.name);
        CHAIN
            .iter()
            .filter(of_found)
            .filter(two_sided)
            .fold(found.clone(), |found, effect| self.without_idle_side(&found, effect, standing).unwrap_or(found))
    }

    /// Without the side of one limit that takes less, where that is idle.
    fn without_idle_side(&self, found: &Fitted, effect: &'static Effect, standing: &Standing) -> Option<Fitted> {
        let lifted = |sides: &[usize], traces: &[Trace<'_>]| {
            let mut values = found.model.effects.values_of(effect.name)?.to_vec();
            sides.iter().for_each(|side| values[*side] = effect.parameters[*side].neutral);
            let model = Model { effects: found.model.effects.with(effect, &values).ok()?, ..found.model.clone() };
            let (hypothesis, chatter_hz) = (found.space.hypothesis.clone(), found.space.chatter_hz(&found.x));
            Fitted::at_start(Space::new(hypothesis, &model, &self.given.base, chatter_hz), traces)
        };
        let own = squares(&lifted(&[], &self.fit)?);
        let whole = squares(&lifted(&[0, 1], &self.fit)?) - own;
        let each = [0, 1].map(|side| Some((side, squares(&lifted(&[side], &self.fit)?) - own)));
        let (side, taken) = each.into_iter().flatten().min_by(|a, b| a.1.total_cmp(&b.1))?;
        #[allow(clippy::cast_precision_loss)] // a count of samples
        let count = self.fit.iter().map(Trace::evaluated_samples).sum::<usize>() as f64;
        let shows = match standing {
            Standing::Adequate => count * (taken / own.max(f64::MIN_POSITIVE)).ln_1p() > REQUIRED_BIC_LEAD,
            _ => taken > LEAST_SHARE * whole,
        };
        let there = |sides: &[usize]| lifted(sides, &self.check).map(|there| squares(&there));
        let is_contradicted = there(&[side])? < there(&[])?;
        (!shows || is_contradicted).then(|| lifted(&[side], &self.fit)).flatten()
    }
}

/// Sum of squares of what is left.
fn squares(fitted: &Fitted) -> f64 {
    fitted.residuals.iter().flatten().map(|left| left * left).sum()
}
