//! Outcome of a search for the structure: an adequate explanation, one that leads on unseen records, or none.
//!
//! Near the given base by likelihood ([`super::search`]); where that is not adequate, beside a free base ([`super::wide`]), judged on unseen records
//! ([`super::leave_one_out`]).

use std::collections::BTreeMap;

use super::{
    adequacy::Misfit,
    check_only::{CLEARLY_MORE, MORE_THAN_NOISE, contradicted},
    diagnosis::Lead,
    fitted::Fitted,
    hypothesis::Hypothesis,
    judgement::Judgement,
    leading_lag::is_delay_or_base,
    leading_oscillation::CHATTER,
    predictable::{ADEQUATE_SHARE, Predictable},
    selection::{Extent, StructureSelection},
    stages,
};
use crate::{inspect::deviation, sorting::sort_by_number};

/// Objections to leads that do not hold, by the names of their effects.
pub type Objections = BTreeMap<&'static str, String>;

/// Predictable share of a residual by plain output error, on unseen samples, above which a fit by likelihood is not adequate either.
pub const PROMISING_SHARE: f64 = 3.0 * ADEQUATE_SHARE;

/// Rms of an explanation over that of the given model, on the check records, at most: otherwise it explains next to nothing.
pub const CLOSES_NOTHING: f64 = 0.95;

/// BIC difference from which on a single effect is tried whatever the check records say, and the residual of the worse of two explanations is not
/// noise.
pub const FAR_BETTER_BIC: f64 = 200.0;

/// Whether an explanation is adequate, or leads.
#[derive(Debug, Clone)]
pub enum Standing {
    /// Its residual is noise.
    Adequate,
    /// It explains the largest part of the difference on every unseen record that shows it, and a difference remains.
    Leading {
        /// Beside several bases, in order of preference; after them the forms of the members of its family that lead as well.
        forms: Vec<Form>,
    },
    /// A difference remains that nothing explains.
    Inadequate,
}

/// A lead beside one base.
#[derive(Debug, Clone)]
pub struct Form {
    /// Fitted to the fit records.
    pub fitted: Fitted,
    /// Tied members of its family.
    pub alternatives: Vec<String>,
    /// Whether it explains nearly all that a free base and a linear model leave on unseen records.
    pub is_nearly_all: bool,
}

impl From<Fitted> for Form {
    /// Without alternatives, and nothing known of the rest.
    fn from(fitted: Fitted) -> Self {
        Self { fitted, alternatives: Vec::new(), is_nearly_all: false }
    }
}

/// The outcome of the search.
#[derive(Clone)]
pub struct Outcome {
    /// The given model.
    pub given: Fitted,
    /// The given model, or the same with its base refitted where that is better.
    pub base: Fitted,
    /// All fitted hypotheses, best first.
    pub candidates: Vec<Fitted>,
    /// The selected hypothesis; none where the given model needs no effect.
    pub explanation: Option<Fitted>,
    /// Whether it is adequate, or leads.
    pub standing: Standing,
    /// Misfit of the explanation.
    pub misfit: Misfit,
    /// The part of the explanation's residual that the motion predicts.
    pub predictable: Predictable,
    /// The judgement on unseen records, where no adequate explanation was found near the given base.
    pub judgement: Option<Judgement>,
    /// Effects that only check records show.
    pub suspicions: Vec<Lead>,
    /// Leads that the records show besides the effects that are judged: a common level, a line, stops at which positions stand.
    pub shown: Vec<Lead>,
    /// A note on the explanation.
    pub note: Option<String>,
    /// Objections to leads that do not hold.
    pub objections: Objections,
    /// Whether the search reached its time limit.
    pub was_cut: bool,
}

impl Outcome {
    /// Whether a difference remains that nothing explains.
    pub fn is_unexplained(&self) -> bool {
        self.explanation.is_none() && matches!(self.standing, Standing::Inadequate)
    }

    /// The explanation, or the base where there is none.
    pub fn last(&self) -> &Fitted {
        self.explanation.as_ref().unwrap_or(&self.base)
    }

    /// Whether the residual of an adequate explanation, on any fit record, is far larger than that on its stretch.
    pub fn is_adequate_and_leaves_more_than(&self, of_stretches: &[Vec<f64>]) -> bool {
        /// Ratio of the deviations, at least.
        const FAR_MORE: f64 = 1.5;
        let mut each = self.last().residuals.iter().zip(of_stretches);
        matches!(self.standing, Standing::Adequate)
            && each.any(|(whole, stretch)| deviation(whole) > FAR_MORE * deviation(stretch))
    }

    /// Whether a delay or a shifted base leads as one of its family.
    pub fn is_delay_or_base(&self) -> bool {
        self.explanation.as_ref().is_some_and(|fitted| is_lag(fitted, &self.standing))
    }
}

fn is_lag(fitted: &Fitted, standing: &Standing) -> bool {
    let Standing::Leading { forms } = standing else { return false };
    forms.first().is_some_and(|form| is_delay_or_base(fitted, &form.alternatives))
}

impl StructureSelection<'_> {
    /// Base, single effects and forward selection near the given base; where that is not adequate, single effects beside a free base, pairs, and
    /// finally what leads on unseen records.
    pub fn select(&self) -> Option<Outcome> {
        self.work.begin(stages::BASE);
        let given = self.fit(Hypothesis::default(), self.given)?;
        let changed = self.changed(&given);
        let free = self.shifted(&changed)?;
        let base = if free.bic < given.bic { &free } else { &given };
        self.work.begin(stages::SINGLES);
        let first = self.with_one_more_effect(base);
        let mut candidates: Vec<Fitted> = vec![given.clone(), free.clone()];
        candidates.extend(changed.iter().chain(&first).cloned());
        self.work.begin(stages::FORWARD);
        let significant = self.first_significant(&first, base);
        let mut explanation = match self.extent {
            Extent::All => self.select_from_singles(&first, significant, base, &mut candidates),
            Extent::Singles => significant.map(|single| self.refined(single)),
        };
        if explanation.is_none() && (self.is_significant(&free, &given) || self.base_shift_suffices(&free, &given)?) {
            explanation = Some(free.clone());
        }
        explanation = explanation.map(|found| self.lag_beside_given_base(found, &mut candidates));
        explanation = explanation.map(|found| self.base_instead_of_lag(found, &mut candidates));
        explanation = explanation.map(|found| self.base_instead_of_stiffness(found, &mut candidates));
        explanation = self.named_by_changes(explanation, &changed, &given);
        let mut judgement = None;
        let mut suspicions = Vec::new();
        let mut shown = Vec::new();
        let mut objections = Objections::new();
        let mut standing = Standing::Adequate;
        let mut is_inadequate = !self.is_adequate(explanation.as_ref(), base);
        let lag = explanation.as_ref().filter(|_| is_inadequate);
        if let Some(lag) = lag.and_then(|found| self.lag_instead_of_base(found, base, &candidates)) {
            explanation = Some(lag);
            is_inadequate = false;
        }
        if is_inadequate {
            standing = Standing::Inadequate;
            let near = explanation.as_ref().unwrap_or(base);
            suspicions = self.suspicions(near, CLEARLY_MORE);
        }
        if is_inadequate && self.is_over() {
            explanation = None;
        } else if is_inadequate {
            self.work.begin(stages::WIDE);
            let judged = self.judge_wide()?;
            let single = self
                .adequate_shift(&judged, explanation.as_ref(), base, &mut candidates)
                .or_else(|| self.adequate_far_from_given(&judged, base, &mut candidates));
            shown.extend(self.common_level(base));
            let mode = if single.is_some() { None } else { self.leading_mode(&first, &judged, &given, base) };
            let mut of_sensor = || {
                self.drifting_bias(&given, base, &first).or_else(|| {
                    let oscillation = self.oscillation(&judged, base)?;
                    oscillation.map_err(|lesser| shown.push(lesser)).ok()
                })
            };
            let is_told = single.is_some() || mode.is_some();
            let added = if is_told { None } else { of_sensor() };
            // Nothing leads instead of an oscillation; instead of a bias only an effect that explains far more.
            let may_lead = !is_told && added.as_ref().is_none_or(|added| added.space.hypothesis.effects != [CHATTER]);
            let lead = may_lead
                .then(|| {
                    self.standing_lead(&judged, &given, base, &suspicions).map_err(|against| objections = against).ok()
                })
                .flatten();
            let rather = |bias: &Fitted| lead.as_ref().is_some_and(|(lead, _)| self.is_rather_lead(lead, bias));
            let added = added.filter(|added| !rather(added));
            // A lag instead of an effect that explains a small part is tried first; where it does not hold, the effect leads.
            let mut leads = Vec::new();
            if !is_told && added.is_none() {
                let lag = match &lead {
                    Some((lead, _)) => self.lag_instead_of(lead, &judged),
                    None => self.leading_lag(&judged),
                };
                leads.extend(lag.map(|(lag, alternatives)| {
                    let forms = vec![Form { alternatives, ..lag.clone().into() }];
                    (lag, Standing::Leading { forms })
                }));
                leads.extend(lead);
            }
            let found = single.or_else(|| {
                if mode.is_some() {
                    return None;
                }
                let current = explanation.as_ref().unwrap_or(base);
                let hopeless =
                    judged.is_linear() || !leads.is_empty() || self.is_over() || self.extent == Extent::Singles;
                if hopeless {
                    return None;
                }
                self.work.begin(stages::PAIRS);
                self.adequate_pair(base, current, &mut candidates)
            });
            if let Some(found) = found {
                standing = Standing::Adequate;
                explanation = Some(found);
            } else if let Some(form) = mode.or(added) {
                standing = Standing::Leading { forms: vec![form.clone().into()] };
                explanation = Some(form);
            } else if let Some(first) = leads.first().map(|(form, _)| form.clone()) {
                let beside = explanation.as_ref().unwrap_or(base);
                let holds = |form: &Fitted| self.is_consistent(form, base, beside, &suspicions);
                if let Some((form, leading)) = leads.into_iter().find(|(form, _)| holds(form)) {
                    explanation = Some(form);
                    standing = leading;
                } else {
                    objections.extend(first.space.hypothesis.effects.last().map(|effect| (*effect, contradicted())));
                    explanation = None;
                }
            } else {
                explanation = None;
            }
            if explanation.is_none()
                && !self.is_over()
                && let Some(form) = self.leading_combination(&judged, base, &candidates)
            {
                explanation = Some(form.fitted.clone());
                standing = Standing::Leading { forms: vec![form] };
            }
            suspicions = match &explanation {
                // A lag is linear: what check records show beside it may be a limit that they alone reach.
                Some(form) if is_lag(form, &standing) => self.suspicions(form, CLEARLY_MORE),
                Some(_) => Vec::new(),
                None => self.or_beside_own_bases(suspicions, &judged),
            };
            judgement = Some(judged);
        }
        if matches!(standing, Standing::Adequate) {
            explanation = explanation.map(|found| self.load_instead_of_bias(found, &candidates));
            explanation = explanation.map(|found| self.without_unmet_effects(found));
            explanation = explanation.map(|found| self.base_instead_of_effects(found, &mut candidates));
            explanation = explanation.map(|found| self.base_instead_of_trifle_beside_steps(found, base));
            explanation = explanation.map(|found| self.likeliest_of_lags(found, base, &mut candidates));
            explanation = explanation.map(|found| self.simpler_that_leaves_no_more(found, base, &candidates));
            explanation = explanation.filter(|found| !self.is_trifling_shift(found, &given));
            let is_none = |found: &Fitted| {
                self.is_of_uneven_steps(found)
                    || self.has_slow_line(found)
                    || self.leaves_uneven_slow_rest(found, &given)
            };
            if explanation.as_ref().is_some_and(is_none) {
                standing = Standing::Inadequate;
                explanation = None;
            }
            // No function of the motion distinguishes from noise what the motion reaches now and then.
            suspicions = self.suspicions(explanation.as_ref().unwrap_or(base), MORE_THAN_NOISE);
            let hum = explanation.as_ref().and_then(|found| self.hum_of_command(found));
            if !suspicions.is_empty() || hum.is_some() {
                standing = Standing::Inadequate;
                explanation = None;
            }
            shown.extend(hum);
        }
        self.work.begin(stages::CONCLUSION);
        sort_by_number(&mut candidates, |one| one.bic);
        let last = explanation.as_ref().unwrap_or(base);
        let (misfit, predictable) = (self.misfit(last)?, self.predictable(last)?);
        let base = base.clone();
        Some(self.with_stop(Outcome {
            given,
            base,
            candidates,
            explanation,
            standing,
            misfit,
            predictable,
            judgement,
            suspicions,
            shown,
            note: None,
            objections,
            was_cut: self.is_over(),
        }))
    }

    /// Forward selection from the significant single effect, or from one that is far better on the fit records: where two effects act, the base
    /// beside one of them is biased and predicts nothing on the check records.
    fn select_from_singles(
        &self,
        first: &[Fitted],
        significant: Option<Fitted>,
        base: &Fitted,
        candidates: &mut Vec<Fitted>,
    ) -> Option<Fitted> {
        let other = significant.as_ref().unwrap_or(base);
        let better = first.first().filter(|single| single.bic + FAR_BETTER_BIC < other.bic);
        let found = better.and_then(|single| self.select_forward(single.clone(), candidates));
        match found {
            Some(found) if self.is_adequate(Some(&found), base) && self.is_significant(&found, base) => Some(found),
            _ => significant.and_then(|single| self.select_forward(single, candidates)),
        }
    }

    /// A pair or triple that is adequate.
    fn adequate_pair(&self, base: &Fitted, current: &Fitted, candidates: &mut Vec<Fitted>) -> Option<Fitted> {
        let found = self.search_pairs(base, current, candidates)?;
        self.is_adequate(Some(&found), base).then_some(found)
    }
}
