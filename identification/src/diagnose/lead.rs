//! A lead: an effect that takes the largest part of the difference on unseen records, in the form in which it gains and leaves none of them
//! with more.

use super::{
    evidence::{REQUIRED_BIC_LEAD, pooled_deviation, shows_clearly},
    fitted::Fitted,
    hypothesis::Hypothesis,
    judgement::Judgement,
    leading_lag::is_delay_or_base,
    leading_oscillation::CHATTER,
    outcome::{CLOSES_NOTHING, Form, Objections, Standing},
    plain_fit::PlainFit,
    rivals::HYSTERESIS,
    selection::StructureSelection,
    space::Space,
    trace::{APPROXIMATION, ROUNDING, Trace},
    unseen::{excess, sample_counts},
    wide,
};
use crate::{digits::with_unit, signal::record::rms};
use actuator_fmu::{effects::find, parameters::Model};

/// Share of the deviation of the fitted records' residuals that a lead may leave where a likelihood confirms it: a level of each record, which
/// leads have, is not their effect's.
const LEAST_FALL: f64 = 0.98;

/// Of the excess that a lead leaves of the check records, what a base alone leaves where what is missing is linear first of all.
const FAR_LESS: f64 = 0.5;
/// An excess below this share of the noise is none.
const NO_EXCESS: f64 = 0.1;

/// Of the mean square that the given model leaves of the check records, what a lead may leave that gains only after a refit.
const MOST_OF_CHECK: f64 = 0.5;

/// Of the root mean square that the given model leaves of the fitted records, what a lead leaves whose check records need not show it.
const CLOSES_FITTED: f64 = 0.5;

/// Of the mean square that the given model leaves, what a lead leaves at most of the fitted records or of the check records: what takes less of both is not
/// the largest part of the difference.
const GREATEST_LEFT_OF_EITHER: f64 = 0.6;

/// Of the excess over the noise that the given model leaves of the check records, what hysteresis leaves at most: it acts in all motion, where a limit
/// need not be met.
const LEFT_BY_HYSTERESIS: f64 = 0.5;

/// The same of friction, and of what friction comes as near as. Every mechanical actuator has some, also the one to which the given model was fitted: a
/// constant level takes a good half of it, whatever its law, and so does play.
const LEFT_BY_FRICTION: f64 = 0.4;

const FRICTION: &str = "coulomb_friction";

/// Of the mean square about the level of each record that the given model leaves, what a base alone leaves where nearly all that is missing is linear;
/// and of this, what a lead may leave that is the largest part of the difference all the same.
const TAKEN_BY_BASE: f64 = 0.1;
const LEFT_BESIDE_BASE: f64 = 0.5;

/// Iterations of the refit of a lead.
const LEAD_ITERATIONS: usize = 12;

impl StructureSelection<'_> {
    /// The first of the leads that stands, in the first of its forms that does, and its standing; without one what speaks against each of them.
    ///
    /// # Errors
    /// What speaks against the first form of each lead, by the name of its effect.
    pub fn standing_lead(
        &self,
        judged: &Judgement,
        given: &Fitted,
        base: &Fitted,
    ) -> Result<(Fitted, Standing), Objections> {
        let mut objections = Objections::new();
        let Some(alone) = self.base_of_its_own(judged) else { return Err(objections) };
        let mut first = None;
        let mut standing = Vec::new();
        for (lead, alternatives) in judged.leads() {
            // A base that may be anywhere has a delay of its own.
            let shows = |form: &Fitted| lead.effect == "delay" || shows_beside(form, &alone);
            let Some(forms) = self.forms_of_lead(&lead.fit) else { continue };
            let forms: Vec<Fitted> = forms.into_iter().filter(shows).collect();
            if let Some(form) = forms.iter().find(|form| self.stands(form, &alternatives, given, base)).cloned() {
                first.get_or_insert(form);
                let form_of = |fitted| Form { fitted, alternatives: alternatives.clone() };
                standing.extend(forms.into_iter().map(form_of));
                continue;
            }
            let of_first = forms.first().and_then(|form| self.objection(form, &alternatives, given, base));
            let hardly_shown = || "a free base alone explains the fit records equally well".to_owned();
            objections.insert(lead.effect, of_first.unwrap_or_else(hardly_shown));
        }
        first.map(|form| (form, Standing::Leading { forms: standing })).ok_or(objections)
    }

    /// The base that may be anywhere, refitted to the records to be fitted alone.
    pub fn base_of_its_own(&self, judged: &Judgement) -> Option<PlainFit> {
        PlainFit::search_from(judged.base.space.clone(), &judged.base.x, &self.fit, LEAD_ITERATIONS)
    }

    /// Whether a lead, with the members of its family that come as near, gains on the fitted records, leaves no check record with more, and these not with
    /// far more than a base without it does.
    pub fn stands(&self, lead: &Fitted, alternatives: &[String], given: &Fitted, base: &Fitted) -> bool {
        self.objection(lead, alternatives, given, base).is_none()
    }

    /// Why a lead does not stand; none where it does.
    pub fn objection(&self, lead: &Fitted, alternatives: &[String], given: &Fitted, base: &Fitted) -> Option<String> {
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
        if let Some(reason) = self.holds_briefly(lead).or_else(|| self.is_within_step(lead)) {
            return Some(reason);
        }
        let without = if lead.space.hypothesis.base_free { base } else { given };
        if !gains(lead, without) {
            return Some("fitted to the fit records, it hardly reduces their residual".to_owned());
        }
        self.objection_of_records(lead, alternatives, base)
            .unwrap_or_else(|| Some("a model with it diverges".to_owned()))
    }

    /// Whether a check record, or those to be fitted together, are left with more than by the given model, or check records with far more than by a
    /// base alone, or with nearly as much where that takes nearly all. The outer one is none where a motion diverges.
    #[allow(clippy::option_option)] // whether there is an objection, where that can be told
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
            // A refitted base has an effect of the given model at another strength as well.
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

    /// Whether one fit leaves far less of the check records than another, above the noise.
    fn leaves_far_less_of_check(&self, one: &PlainFit, other: &PlainFit) -> bool {
        let noise = &self.noise.mean_squares()[self.fit.len()..];
        let counts = sample_counts(other);
        let of_noise: f64 = noise.iter().zip(&counts).map(|(noise, count)| noise * count).sum();
        let [one, other] = [one, other].map(|fit| excess(&fit.mean_squares(), noise, &counts));
        other > NO_EXCESS * of_noise && one < FAR_LESS * other
    }

    /// Of the excess over the noise that one fit leaves of the check records, what another leaves, which leaves no more; nothing where that is noise.
    fn left_of_check(&self, after: &PlainFit, before: &PlainFit) -> f64 {
        let noise = self.noise.mean_squares();
        let counts = sample_counts(before);
        let excess = |fit: &PlainFit| excess(&fit.mean_squares(), &noise[self.fit.len()..], &counts);
        (excess(after).max(0.0) / excess(before).max(f64::MIN_POSITIVE)).min(1.0)
    }

    /// Whether a lead leaves some records with more than the given model does; rms of both as searches simulate them. What differs by less than these do
    /// is simulated to the last bit: the motion of a record that hardly meets the lead is nearly the same.
    pub fn leaves_more(&self, lead: &Fitted, [after, before]: [f64; 2], records: &[Trace<'_>]) -> Option<bool> {
        if (after - before).abs() > APPROXIMATION * before {
            return Some(after > before);
        }
        let exact: Vec<Trace<'_>> = records.iter().map(Trace::exact).collect();
        let left = |model: &Model| Some(PlainFit::as_it_is(model, &exact)?.mean_square().sqrt());
        Some(left(&lead.model)? > (1.0 + ROUNDING) * left(self.given)?)
    }

    /// The forms of a lead in the order in which they are preferred: beside a base of its own and beside the given one; beside a base of its own
    /// as the FMU is stepped, without and with a level that all records share; and its effect in the given model as it is.
    fn forms_of_lead(&self, lead: &PlainFit) -> Option<Vec<Fitted>> {
        let (own, [first, second]) = self.lead_on_fitted_records(lead)?;
        let stepped = PlainFit::search_from(own.space.clone().without_levels(), &own.x, &self.fit, LEAD_ITERATIONS)?;
        let in_given = self.in_given_model(&own)?;
        let unchanged = PlainFit::at_start(in_given.clone(), &self.fit)?;
        let others = [Some(stepped), self.with_common_level(&own), Some(unchanged)];
        let others: Option<Vec<Fitted>> = others.into_iter().flatten().map(|form| self.by_likelihood(form)).collect();
        Some([first, second].into_iter().chain(others?).collect())
    }

    /// A lead beside a base of its own whose measurement is off by what all records share, where the given model has no such error: a position
    /// that is held off its command is one of a base of another structure.
    #[allow(clippy::cast_precision_loss)] // a count of samples
    fn with_common_level(&self, own: &PlainFit) -> Option<PlainFit> {
        let bias = find("sensor_bias").filter(|bias| self.given.effects.active_values_of(bias.name).is_none())?;
        let left = PlainFit::as_it_is(&own.model, &self.fit)?.residuals.concat();
        let offset = left.iter().sum::<f64>() / left.len().max(1) as f64;
        let start = Model { effects: own.model.effects.with(bias, &[offset, 0.0]).ok()?, ..own.model.clone() };
        let space = Space::new(own.space.hypothesis.clone(), &start, &self.given.base, 0.0).without_levels();
        PlainFit::search_from(space.clone(), &space.start(), &self.fit, LEAD_ITERATIONS)
    }

    /// A fit of all records refitted to those to be fitted, so that check records stay unseen; and that beside its own base and beside the given
    /// one, the better one of these records first.
    pub fn lead_on_fitted_records(&self, lead: &PlainFit) -> Option<(PlainFit, [Fitted; 2])> {
        let own = PlainFit::search_from(lead.space.clone(), &lead.x, &self.fit, LEAD_ITERATIONS)?;
        let beside_given = PlainFit::search(self.in_given_model(&own)?, &self.fit, LEAD_ITERATIONS)?;
        // Twice the negative logarithm of the likelihood with a variance in each record, as the FMU is measured: without levels of the
        // records' own. A quiet record counts as much as a loud one.
        let deviance = |model: &Model| {
            let left = PlainFit::as_it_is(model, &self.fit)?.mean_squares();
            Some(left.iter().map(|square| square.max(f64::MIN_POSITIVE).ln()).sum::<f64>())
        };
        let is_given_better = deviance(&beside_given.model)? < deviance(&own.model)?;
        let (fitted, beside_given) = (self.by_likelihood(own.clone())?, self.by_likelihood(beside_given)?);
        Some((own, if is_given_better { [beside_given, fitted] } else { [fitted, beside_given] }))
    }

    /// The effect of an explanation in the given model, its numbers free.
    fn in_given_model(&self, lead: &PlainFit) -> Option<Space> {
        let hypothesis = Hypothesis { base_free: false, ..lead.space.hypothesis.clone() };
        let effect = find(wide::effect_of(lead))?;
        let values = lead.model.effects.values_of(effect.name)?;
        let start = Model { effects: self.given.effects.with(effect, values).ok()?, ..self.given.clone() };
        Some(Space::new(hypothesis, &start, &self.given.base, 0.0))
    }

    /// A form of a lead that was found on parts of these records, refitted to the whole ones.
    pub fn refitted_lead(&self, form: &Fitted) -> Option<Fitted> {
        self.by_likelihood(PlainFit::search_from(form.space.clone(), &form.x, &self.fit, LEAD_ITERATIONS)?)
    }

    /// Whether a lead leaves less than half of what the given model leaves of the check records.
    pub fn takes_most_of_check(&self, lead: &Fitted) -> bool {
        let left = |model: &Model| Some(PlainFit::as_it_is(model, &self.check)?.mean_square());
        left(&lead.model).zip(left(self.given)).is_some_and(|(after, before)| after < MOST_OF_CHECK * before)
    }

    /// As it is, with the noise of the records.
    pub fn by_likelihood(&self, fit: PlainFit) -> Option<Fitted> {
        let fitted = Fitted::at(fit.space, fit.x, &self.fit)?;
        Some(Fitted { converged: fit.converged, ..fitted })
    }
}

/// Whether fitted records show more of a lead beside a base of its own than that a base may be anywhere: what only check records show is a suspicion.
fn shows_beside(form: &Fitted, alone: &PlainFit) -> bool {
    let least = LEAST_FALL * pooled_deviation(&alone.residuals);
    !form.space.hypothesis.base_free || pooled_deviation(&form.residuals) < least
}

/// Whether fitted records show a lead at all. One that shows in check records alone is a suspicion. Beside a base of another structure a
/// likelihood may take what is left for noise that it whitens: a clear fall about the level of each record is one whatever the likelihood
/// says.
fn gains(lead: &Fitted, without: &Fitted) -> bool {
    let falls_a_little = pooled_deviation(&lead.residuals) < LEAST_FALL * pooled_deviation(&without.residuals);
    shows_clearly(lead, without) || (falls_a_little && lead.bic + REQUIRED_BIC_LEAD < without.bic)
}

/// Whether a base alone takes nearly all of a difference, about the level of each record, and a lead little of what then stays.
fn is_of_base(given: &PlainFit, base: &PlainFit, lead: &PlainFit) -> bool {
    let variance = |fit: &PlainFit| pooled_deviation(&fit.residuals).powi(2);
    variance(base) < TAKEN_BY_BASE * variance(given) && variance(lead) > LEFT_BESIDE_BASE * variance(base)
}
