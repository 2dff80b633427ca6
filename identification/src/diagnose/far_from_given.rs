//! Single effects beside a free base, judged on unseen records, and the best of them if it is adequate.

use std::{f64::consts::TAU, slice::from_ref};

use super::{
    evidence::RIVAL_BIC_RANGE,
    fitted::{Fitted, SearchEffort},
    hypothesis::MeasurementTerm,
    judgement::Judgement,
    leave_one_out,
    outcome::{CLOSES_NOTHING, FAR_BETTER_BIC, PROMISING_SHARE},
    plain_fit::PlainFit,
    selection::StructureSelection,
    thinned::{Thinning, thinned},
    trace::Trace,
    wide,
};
use crate::{
    signal::record::{Record, rms},
    sorting::sort_by_number,
};
use actuator_fmu::parameters::Model;

impl StructureSelection<'_> {
    /// Single effects beside a free base, judged record by record.
    pub fn judge_wide(&self) -> Option<Judgement> {
        let records: Vec<&Record> = self.fit.iter().chain(&self.check).map(|trace| trace.record).collect();
        let records = thinned(&records, self.given.base.omega() / TAU, Thinning::COARSE);
        let coarse = |record| Trace::coarse(record, &self.given.base).part_of(self.work);
        let traces: Vec<Trace<'_>> = records.iter().map(coarse).collect();
        let wide = wide::search(self.given, &traces)?;
        leave_one_out::judge(self.given, &wide, &traces, &self.noise.mean_squares())
    }

    /// Fits the best effects of the wide search by likelihood; returns the best of them if it is adequate.
    pub fn adequate_far_from_given(
        &self,
        judged: &Judgement,
        base: &Fitted,
        candidates: &mut Vec<Fitted>,
    ) -> Option<Fitted> {
        const FITTED: usize = 3;
        let plausible =
            judged.judged.iter().filter(|judged| judged.beats_linear && wide::implausible(&judged.fit).is_none());
        let mut fitted: Vec<Fitted> = plausible
            .take(FITTED)
            .filter_map(|judged| {
                let (_, [start, _]) = self.lead_on_fitted_records(&judged.fit)?;
                if self.predictable(&start)?.share > PROMISING_SHARE {
                    return Some(start);
                }
                let fine = Fitted::search(start.space.clone().starting_at(&start.x)?, &self.fit, SearchEffort::Full)?;
                Some(if fine.rms() <= start.rms() { fine } else { start })
            })
            .collect();
        sort_by_number(&mut fitted, |one| one.bic);
        let best =
            fitted.iter().find(|fitted| self.is_significant(fitted, base) && self.is_adequate(Some(fitted), base));
        // Beside a free base little remains that distinguishes families.
        let is_alone = |best: &Fitted| {
            let mut others =
                fitted.iter().filter(|other| other.space.hypothesis.family() != best.space.hypothesis.family());
            others.all(|other| other.bic > best.bic + RIVAL_BIC_RANGE)
        };
        // Where a candidate near the given base is far better in BIC, the residual of this one is not noise.
        let is_behind = |best: &Fitted| candidates.iter().any(|near| near.bic + FAR_BETTER_BIC < best.bic);
        let is_told = |best: &&Fitted| {
            is_alone(best)
                && !is_behind(best)
                && self.is_within_step(best).is_none()
                && self.closes_something(best) == Some(true)
                && self.widens_unseen(best) != Some(true)
                && self.is_more_than_its_base(best, judged)
        };
        let best = best.filter(is_told).cloned();
        candidates.extend(fitted);
        best
    }

    /// Whether an explanation clearly reduces the residual of the check records about the levels.
    fn closes_something(&self, found: &Fitted) -> Option<bool> {
        let left = |model: &Model| Some(PlainFit::beside_levels(model, &self.check)?.mean_square());
        Some(left(&found.model)? < CLOSES_NOTHING.powi(2) * left(self.given)?)
    }

    /// Whether an explanation without measurement terms has a larger residual than the given model on any check record, levels included, as packaged
    /// models are compared.
    pub fn widens_unseen(&self, found: &Fitted) -> Option<bool> {
        if found.space.hypothesis.effects.iter().any(|effect| MeasurementTerm::of(effect).is_some()) {
            return Some(false);
        }
        let (before, after) =
            (PlainFit::as_it_is(self.given, &self.check)?, PlainFit::as_it_is(&found.model, &self.check)?);
        let mut each = self.check.iter().zip(before.residuals.iter().zip(&after.residuals));
        let widens = |(trace, (before, after)): (&Trace<'_>, (&Vec<f64>, &Vec<f64>))| {
            self.leaves_more(found, [rms(after), rms(before)], from_ref(trace)) == Some(true)
        };
        Some(each.any(widens))
    }

    /// Whether an effect beside its own free base is significant over a free base alone, which includes a delay and levels of the records.
    fn is_more_than_its_base(&self, found: &Fitted, judged: &Judgement) -> bool {
        let PlainFit { space, x, .. } = &judged.base;
        let alone = space.clone().starting_at(x).and_then(|space| Fitted::search(space, &self.fit, SearchEffort::Full));
        alone.is_none_or(|alone| self.is_significant(found, &alone))
    }
}
