//! Results from parts of long records, refined on the whole ones and judged there.

use super::{
    fitted::{Fitted, SearchEffort},
    leading_oscillation::CHATTER,
    outcome::{Form, Outcome, Standing},
    selection::StructureSelection,
};
use crate::{parallel, sorting::sort_by_number};

impl StructureSelection<'_> {
    /// The outcome of a search on parts of these records: what was found there, refined on the whole records and judged on them.
    pub fn transferred(&self, outcome: Outcome) -> Option<Outcome> {
        // Evaluated, not searched.
        let evaluated = |fitted: &Fitted| Fitted::at(fitted.space.clone(), fitted.x.clone(), &self.fit);
        let on_whole = |fitted: &Fitted| Some(Fitted { converged: fitted.converged, ..evaluated(fitted)? });
        let refined = |fitted: &Fitted| {
            let at = on_whole(fitted)?;
            let space = at.space.clone().starting_at(&at.x)?;
            let fine = Fitted::search(space, &self.fit, SearchEffort::Continued);
            Some(fine.filter(|fine| fine.bic <= at.bic).unwrap_or(at))
        };
        // Number of candidates that a table shows.
        const KEPT: usize = 14;
        let kept = &outcome.candidates[..outcome.candidates.len().min(KEPT)];
        let mut candidates: Vec<Fitted> = parallel::map(kept, evaluated).into_iter().flatten().collect();
        let given = on_whole(&outcome.given)?;
        let base = refined(&outcome.base)?;
        let mut standing = outcome.standing.clone();
        let explanation = match (&outcome.explanation, &outcome.standing) {
            // An effect that reduces the residual on parts of the records may not do so on the whole ones, to which the base has been fitted.
            (Some(_), Standing::Leading { forms }) => {
                let stands = |of: &Form, fitted: Fitted| {
                    let form = Form { fitted, ..of.clone() };
                    self.stands(&form, &given, &base).then_some(form.fitted)
                };
                // Only the whole records determine the frequency of an oscillation.
                let on_these = |fitted: &Fitted| {
                    if fitted.space.hypothesis.effects == [CHATTER] { refined(fitted) } else { on_whole(fitted) }
                };
                let as_it_is = forms.iter().find_map(|form| stands(form, on_these(&form.fitted)?));
                let refitted = |form: &Form| stands(form, self.refitted_lead(&form.fitted)?);
                as_it_is.or_else(|| forms.iter().filter_map(refitted).find(|form| self.takes_most_of_check(form)))
            }
            (Some(found), _) => Some(self.base_instead_of_effects(refined(found)?, &mut candidates)),
            (None, _) => None,
        };
        let (mut objections, mut shown) = (outcome.objections.clone(), outcome.shown.clone());
        if let Some(found) = outcome.explanation.as_ref().filter(|_| explanation.is_none()) {
            standing = Standing::Inadequate;
            if found.space.hypothesis.effects == [CHATTER] {
                shown.extend(refined(found).and_then(|line| self.lesser_oscillation(&line)));
            }
            let forms = if let Standing::Leading { forms } = &outcome.standing { &forms[..] } else { &[] };
            let reason = forms
                .first()
                .and_then(|form| {
                    let form = Form { fitted: on_whole(&form.fitted)?, ..form.clone() };
                    self.objection(&form, &given, &base)
                })
                .map_or_else(String::new, |reason| format!(": {reason}"));
            let effect = found.space.hypothesis.effects.last();
            let objection = format!("it leads on stretches of the records, not on the whole ones{reason}");
            objections.extend(effect.map(|effect| (*effect, objection)));
        }
        candidates.extend(explanation.clone());
        sort_by_number(&mut candidates, |one| one.bic);
        let last = explanation.as_ref().unwrap_or(&base);
        let (misfit, predictable) = (self.misfit(last)?, self.predictable(last)?);
        let note = outcome.note.clone().filter(|_| explanation.is_some());
        Some(Outcome {
            given,
            base,
            candidates,
            explanation,
            standing,
            misfit,
            predictable,
            note,
            shown,
            objections,
            ..outcome
        })
    }

    /// Whether an explanation that is adequate on parts of these records is adequate on the whole ones; true where it was not.
    pub fn holds(&self, outcome: &Outcome) -> bool {
        !matches!(outcome.standing, Standing::Adequate) || self.is_adequate(outcome.explanation.as_ref(), &outcome.base)
    }
}
