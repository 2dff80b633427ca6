//! A lead: an effect that explains the largest part of the difference on unseen records, in a form that reduces the residual and increases it on none
//! of them.

use super::{
    diagnosis::Lead,
    evidence::{REQUIRED_BIC_LEAD, pooled_deviation, shows_clearly},
    fitted::Fitted,
    hypothesis::PARAMETER_SHIFT,
    judgement::Judgement,
    lead_forms::LEAD_ITERATIONS,
    leading_lag::is_delay_or_base,
    leading_oscillation::CHATTER,
    outcome::{CLOSES_NOTHING, Form, Objections, Standing},
    plain_fit::PlainFit,
    rivals::HYSTERESIS,
    selection::StructureSelection,
    trace::{APPROXIMATION, ROUNDING, Trace},
    unseen::{excess, sample_counts},
};
use crate::{digits::with_unit, signal::record::rms};
use actuator_fmu::parameters::Model;

/// Rms of a lead over that without it, on the fit records, at most, where a likelihood confirms it. About the levels: leads have them, but they are
/// not due to the effect.
const LEAST_FALL: f64 = 0.98;

/// Excess of a base alone over that of a lead, on the check records, below which the difference is mainly linear.
const FAR_LESS: f64 = 0.5;
/// Excess over the variance of the noise below which there is none.
const NO_EXCESS: f64 = 0.1;

/// Mean square of a lead over that of the given model, on the check records, at most, where the lead holds only after a refit.
const MOST_OF_CHECK: f64 = 0.5;

/// Rms of a lead over that of the given model, on the fit records, below which the check records need not show the lead.
const CLOSES_FITTED: f64 = 0.5;

/// Mean square of a lead over that of the given model, at most, on the fit records or on the check records: otherwise it is not the largest part of
/// the difference.
const GREATEST_LEFT_OF_EITHER: f64 = 0.6;

/// Excess of hysteresis over that of the given model, on the check records, at most: it acts in all motion, whereas a limit need not be reached.
const LEFT_BY_HYSTERESIS: f64 = 0.5;

/// The same for friction, and for what is tied with friction. Every mechanical actuator has some, also the one to which the given model was fitted: a
/// constant level explains a good half of it, whatever its law, and so does play.
const LEFT_BY_FRICTION: f64 = 0.4;

const FRICTION: &str = "coulomb_friction";

/// Mean square of a base alone over that of the given model, about the levels, below which nearly all of the difference is linear; and that of a lead
/// over that of this base, at most, where the lead is the largest part all the same.
const TAKEN_BY_BASE: f64 = 0.1;
const LEFT_BESIDE_BASE: f64 = 0.5;

/// The objection where a motion does.
const DIVERGES: &str = "a model with it diverges";

impl StructureSelection<'_> {
    /// The first lead that holds, in the first of its forms that does, and its standing; without one the objection to each of them. `suspicions` are
    /// what only check records show beside the explanation near the given base.
    ///
    /// # Errors
    /// The objection to the first form of each lead, by the name of its effect.
    pub fn standing_lead(
        &self,
        judged: &Judgement,
        given: &Fitted,
        base: &Fitted,
        suspicions: &[Lead],
    ) -> Result<(Fitted, Standing), Objections> {
        let mut objections = Objections::new();
        let Some(alone) = self.base_of_its_own(judged) else { return Err(objections) };
        let mut first = None;
        let mut standing = Vec::new();
        // An effect that only a check record shows would vanish behind such a form, which allows for a base that changes with the record.
        let is_base = |suspicion: &Lead| suspicion.name == PARAMETER_SHIFT;
        let may_be_halfway = self.or_beside_own_bases(suspicions.to_vec(), judged).iter().all(is_base);
        for (lead, alternatives) in judged.leads() {
            // A free base includes a delay.
            let shows = |form: &Fitted| lead.effect == "delay" || shows_beside(form, &alone);
            let Some((own, forms)) = self.forms_of_lead(&lead.fit) else {
                objections.insert(lead.effect, DIVERGES.to_owned());
                continue;
            };
            let form_of = |fitted| {
                let is_nearly_all = lead.leaves_nearly_nothing();
                Form { fitted, alternatives: alternatives.clone(), is_nearly_all }
            };
            let stands = |form: &Form| self.stands(form, given, base);
            let mut forms: Vec<Form> = forms.into_iter().filter(shows).map(form_of).collect();
            let mut holds = forms.iter().find(|form| stands(form)).cloned();
            if holds.is_none() && may_be_halfway {
                holds = self.halfway_to_given(&own).map(form_of).filter(stands);
                forms.extend(holds.clone());
            }
            if let Some(form) = holds {
                first.get_or_insert(form.fitted);
                standing.extend(forms);
                continue;
            }
            let of_first = forms.first().and_then(|form| self.objection(form, given, base));
            let hardly_shown = || "a free base alone explains the fit records equally well".to_owned();
            objections.insert(lead.effect, of_first.unwrap_or_else(hardly_shown));
        }
        first.map(|form| (form, Standing::Leading { forms: standing })).ok_or(objections)
    }

    /// The free base, refitted to the fit records alone.
    pub fn base_of_its_own(&self, judged: &Judgement) -> Option<PlainFit> {
        PlainFit::search_from(judged.base.space.clone(), &judged.base.x, &self.fit, LEAD_ITERATIONS)
    }

    /// Whether a lead, with the tied members of its family, holds: it reduces the residual of the fit records, increases that of no check record, and
    /// its residual on these is not far larger than that of a base without it.
    pub fn stands(&self, lead: &Form, given: &Fitted, base: &Fitted) -> bool {
        self.objection(lead, given, base).is_none()
    }

    /// Why a lead does not hold; none where it does.
    pub fn objection(&self, form: &Form, given: &Fitted, base: &Fitted) -> Option<String> {
        let Form { fitted: lead, alternatives, .. } = form;
        if let Some(reason) = self.as_healthy() {
            return Some(reason);
        }
        if lead.space.hypothesis.effects == [CHATTER] {
            return self.objection_to_oscillation(lead, base);
        }
        if is_delay_or_base(lead, alternatives) {
            return self.objection_to_lag(lead);
        }
        if let Some(reason) = self.passed_stop(lead) {
            return Some(reason);
        }
        if let Some(reason) = self.holds_briefly(form).or_else(|| self.is_within_step(lead)) {
            return Some(reason);
        }
        let is_free = lead.space.hypothesis.base_free;
        let beside_other = (!is_free && lead.model.base != self.given.base).then(|| self.without_effect(lead));
        let without = match &beside_other {
            None => Some(if is_free { base } else { given }),
            Some(other) => other.as_ref(),
        };
        if !without.is_some_and(|without| gains(lead, without)) {
            return Some("fitted to the fit records, it hardly reduces their residual".to_owned());
        }
        self.objection_of_records(lead, alternatives, base).unwrap_or_else(|| Some(DIVERGES.to_owned()))
    }

    /// The objection from the residuals: larger than with the given model on a check record or on the fit records together, far larger on the check
    /// records than with a base alone, or nearly as large where that base explains nearly everything. The outer option is none where a motion
    /// diverges.
    #[allow(clippy::option_option)] // whether there is an objection, where that can be decided
    fn objection_of_records(&self, lead: &Fitted, alternatives: &[String], base: &Fitted) -> Option<Option<String>> {
        let against = |after: f64, records: &str, other: &str, before: f64| {
            let [after, before] = [after, before].map(|rms| with_unit(rms, 3, self.given.unit().name()));
            Some(Some(format!(
                "fitted to the fit records, it has a residual of {after} rms on {records}, {other} {before}"
            )))
        };
        let (given, after) =
            (PlainFit::as_it_is(self.given, &self.check)?, PlainFit::as_it_is(&lead.model, &self.check)?);
        for ((trace, after), given) in self.check.iter().zip(&after.residuals).zip(&given.residuals) {
            if self.leaves_more(lead, [rms(after), rms(given)], std::slice::from_ref(trace))? {
                let record = trace.record.source().display();
                return against(rms(after), &record.to_string(), "the given model", rms(given));
            }
        }
        let (given_fit, after_fit) =
            (PlainFit::as_it_is(self.given, &self.fit)?, PlainFit::as_it_is(&lead.model, &self.fit)?);
        let root = |fit: &PlainFit| fit.mean_square().sqrt();
        if self.leaves_more(lead, [root(&after_fit), root(&given_fit)], &self.fit)? {
            return against(root(&after_fit), "these", "the given model", root(&given_fit));
        }
        let leaves_at_most =
            |share: f64, after: &PlainFit, given: &PlainFit| after.mean_square() < share.powi(2) * given.mean_square();
        let closes =
            leaves_at_most(CLOSES_NOTHING, &after, &given) || leaves_at_most(CLOSES_FITTED, &after_fit, &given_fit);
        let either = GREATEST_LEFT_OF_EITHER.sqrt();
        let is_much = leaves_at_most(either, &after, &given) || leaves_at_most(either, &after_fit, &given_fit);
        if !closes || !is_much {
            return against(root(&after), "check records", "the given model", root(&given));
        }
        let left = self.left_of_check(&after, &given);
        let effect = lead.space.hypothesis.effects.last().copied().unwrap_or("");
        let may_be_friction = effect == FRICTION || alternatives.iter().any(|effect| effect == FRICTION);
        let most = if may_be_friction { LEFT_BY_FRICTION } else { LEFT_BY_HYSTERESIS };
        if HYSTERESIS.contains(&effect) && left > most {
            return Some(Some(format!(
                "it acts in all motion, but {:.0} % of the excess remains on check records",
                100.0 * left
            )));
        }
        if self.is_given(effect) {
            // Beside a refitted base the strength of an effect of the given model is free as well.
            return Some(None);
        }
        let (base, base_fit) =
            (PlainFit::as_it_is(&base.model, &self.check)?, PlainFit::as_it_is(&base.model, &self.fit)?);
        let is_of_base = is_of_base(&given, &base, &after) && is_of_base(&given_fit, &base_fit, &after_fit);
        if is_of_base || self.leaves_far_less_of_check(&base, &after) {
            return against(
                root(&after),
                "check records",
                "a refitted base, which explains most of the difference,",
                root(&base),
            );
        }
        Some(None)
    }

    /// Whether the excess of one fit on the check records is far smaller than that of another.
    fn leaves_far_less_of_check(&self, one: &PlainFit, other: &PlainFit) -> bool {
        let noise = &self.noise.mean_squares()[self.fit.len()..];
        let counts = sample_counts(other);
        let of_noise: f64 = noise.iter().zip(&counts).map(|(noise, count)| noise * count).sum();
        let [one, other] = [one, other].map(|fit| excess(&fit.mean_squares(), noise, &counts));
        other > NO_EXCESS * of_noise && one < FAR_LESS * other
    }

    /// Excess of one fit over that of another, on the check records, at most 1; 0 where the former is noise.
    fn left_of_check(&self, after: &PlainFit, before: &PlainFit) -> f64 {
        let noise = self.noise.mean_squares();
        let counts = sample_counts(before);
        let excess = |fit: &PlainFit| excess(&fit.mean_squares(), &noise[self.fit.len()..], &counts);
        (excess(after).max(0.0) / excess(before).max(f64::MIN_POSITIVE)).min(1.0)
    }

    /// Whether a lead has a larger residual on some records than the given model; rms of both as searches simulate them. Where they differ by less
    /// than the accuracy of a search, both are simulated exactly: the motion of a record that hardly reaches the effect is nearly the same.
    pub fn leaves_more(&self, lead: &Fitted, [after, before]: [f64; 2], records: &[Trace<'_>]) -> Option<bool> {
        if (after - before).abs() > APPROXIMATION * before {
            return Some(after > before);
        }
        let exact: Vec<Trace<'_>> = records.iter().map(Trace::exact).collect();
        let left = |model: &Model| Some(PlainFit::as_it_is(model, &exact)?.mean_square().sqrt());
        Some(left(&lead.model)? > (1.0 + ROUNDING) * left(self.given)?)
    }

    /// Whether the mean square of a lead on the check records is less than half of that of the given model.
    pub fn takes_most_of_check(&self, lead: &Fitted) -> bool {
        let left = |model: &Model| Some(PlainFit::as_it_is(model, &self.check)?.mean_square());
        left(&lead.model).zip(left(self.given)).is_some_and(|(after, before)| after < MOST_OF_CHECK * before)
    }
}

/// Whether the fit records show more of a lead beside its own free base than a free base alone: what only check records show is a suspicion.
fn shows_beside(form: &Fitted, alone: &PlainFit) -> bool {
    let least = LEAST_FALL * pooled_deviation(&alone.residuals);
    !form.space.hypothesis.base_free || pooled_deviation(&form.residuals) < least
}

/// Whether the fit records show a lead at all: what only check records show is a suspicion. Beside a base of another structure the whitening of a
/// likelihood may take the remainder for noise; a clear reduction about the levels therefore counts whatever the likelihood is.
fn gains(lead: &Fitted, without: &Fitted) -> bool {
    let falls_a_little = pooled_deviation(&lead.residuals) < LEAST_FALL * pooled_deviation(&without.residuals);
    shows_clearly(lead, without) || (falls_a_little && lead.bic + REQUIRED_BIC_LEAD < without.bic)
}

/// Whether a base alone explains nearly all of the difference about the levels, and a lead little of the rest.
fn is_of_base(given: &PlainFit, base: &PlainFit, lead: &PlainFit) -> bool {
    let variance = |fit: &PlainFit| pooled_deviation(&fit.residuals).powi(2);
    variance(base) < TAKEN_BY_BASE * variance(given) && variance(lead) > LEFT_BESIDE_BASE * variance(base)
}
