//! Single effects beside a base that may be anywhere, judged on unseen records; and the best of them that leaves noise.

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
    /// Single effects on a wide base, judged record by record.
    pub fn judge_wide(&self) -> Option<Judgement> {
        let records: Vec<&Record> = self.fit.iter().chain(&self.check).map(|trace| trace.record).collect();
        let records = thinned(&records, self.given.base.omega() / TAU, Thinning::COARSE);
        let coarse = |record| Trace::coarse(record, &self.given.base).part_of(self.work);
        let traces: Vec<Trace<'_>> = records.iter().map(coarse).collect();
        let wide = wide::search(self.given, &traces)?;
        leave_one_out::judge(self.given, &wide, &traces, &self.noise.mean_squares())
    }

    /// The best effects of the wide search fitted by likelihood; the best of them, if it leaves noise.
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
        // Beside a base that may be anywhere little is left to tell families apart.
        let is_alone = |best: &Fitted| {
            let mut others =
                fitted.iter().filter(|other| other.space.hypothesis.family() != best.space.hypothesis.family());
            others.all(|other| other.bic > best.bic + RIVAL_BIC_RANGE)
        };
        // What is far more than noise beside an explanation near the given base is no noise beside this one.
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

    /// Whether an explanation leaves clearly less of the check records than the given model, about the level of each.
    fn closes_something(&self, found: &Fitted) -> Option<bool> {
        let left = |model: &Model| Some(PlainFit::beside_levels(model, &self.check)?.mean_square());
        Some(left(&found.model)? < CLOSES_NOTHING.powi(2) * left(self.given)?)
    }

    /// Whether an explanation without terms of the measurement leaves a check record with more than the given model, levels included, as units are measured.
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

    /// Whether an effect beside a base of its own is significant over such a base without it, levels of the records and a delay included.
    fn is_more_than_its_base(&self, found: &Fitted, judged: &Judgement) -> bool {
        let PlainFit { space, x, .. } = &judged.base;
        let alone = space.clone().starting_at(x).and_then(|space| Fitted::search(space, &self.fit, SearchEffort::Full));
        alone.is_none_or(|alone| self.is_significant(found, &alone))
    }
}
