//! The result of a diagnosis.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{adequacy::Misfit, detectable::Detectable, predictable::Predictable, regressors::ExplainingRegressor};
use crate::inspect::noise::Noise;
use actuator_fmu::{effects::find, parameters::Model};

/// The verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The difference is noise, or does not follow the command.
    NothingMissing,
    /// One effect, or several, explain the difference.
    Named,
    /// One effect, or one family, explains the largest part of the difference on every unseen record that shows it; a difference remains.
    Leading,
    /// As `Named`, but other names explain the records as well.
    Ambiguous,
    /// A difference remains that no effect of the chain explains, or that only a check record shows.
    Unexplained,
}

/// A fitted hypothesis, and how well it fits.
#[derive(Debug, Clone, Serialize)]
pub struct Candidate {
    /// Effects, joined by ` + `; `none` for the given model.
    pub name: String,
    /// Family of the effect that was added.
    pub family: &'static str,
    /// BIC above that of the best one.
    pub delta_bic: f64,
    /// Root mean square of its residuals on the fit records \[deg\].
    pub fit_rms: f64,
    /// The same on the check records.
    pub check_rms: f64,
    /// Whether its search converged on these records; if not, its residuals are upper bounds.
    pub converged: bool,
}

/// Values of measurement effects that are free in each record, as parameters of the FMU.
pub type RecordTerms = Vec<(&'static str, f64)>;

/// The result of a diagnosis.
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// Effects that are named, in the order in which they were found.
    pub findings: Vec<Finding>,
    /// The given model.
    pub before: Model,
    /// The model with what was found.
    pub after: Model,
    /// The best explanation, named or not.
    pub best: Model,
    /// All candidates, best first.
    pub candidates: Vec<Candidate>,
    /// Models that explain the records as well; empty except for [`Verdict::Ambiguous`].
    pub rivals: Vec<Model>,
    /// The part of the residuals that the motion explains.
    pub misfit: Misfit,
    /// The part of them that it predicts on unseen samples.
    pub predictable: Predictable,
    /// Regressors that explain the residuals, where the verdict is [`Verdict::Unexplained`].
    pub carriers: Vec<ExplainingRegressor>,
    /// Noise of the check records, with its source.
    pub noise: Noise,
    /// The parts of the difference.
    pub parts: Parts,
    /// Explanations of part of the difference on unseen records, and why they are not named.
    pub leads: Vec<Lead>,
    /// Detection limits, where nothing is missing.
    pub detectable: Vec<Detectable>,
    /// Values of measurement terms, free in each record: fit records, then check records.
    pub record_terms: Vec<RecordTerms>,
    /// Start of each record \[deg\] and number of samples of its settling time, which are not evaluated.
    pub starts: Vec<(f64, usize)>,
    /// Residuals of the given model, with its base refitted where that is better: fit records, then check records.
    pub residuals: Vec<Vec<f64>>,
    /// Whether the residual of an adequate model is so slow that it may be a disturbance as well as noise; a note gives its size.
    pub leaves_slow_rest: bool,
    /// Notes for the user.
    pub notes: Vec<String>,
    /// Number of least-squares searches, each of one hypothesis from one start.
    pub searches: u64,
}

impl Diagnosis {
    /// A diagnosis made with another form of the given model, in terms of the given one.
    pub(super) fn of_given(mut self, searched: &Model, given: &Model) -> Self {
        for model in [&mut self.before, &mut self.after, &mut self.best] {
            if model == searched {
                model.clone_from(given);
            }
        }
        self
    }

    /// Withdraws the names, with the reason, and returns to the given model. A named quantiser that the model was left without stays: the measured
    /// values show it, whatever the model does.
    pub fn withdraw(&mut self, reason: &str, given: &Model, is_rounding_left_out: bool) {
        let is_kept = is_rounding_left_out && matches!(self.verdict, Verdict::Named | Verdict::Leading);
        let (kept, withdrawn): (Vec<Finding>, Vec<Finding>) =
            self.findings.drain(..).partition(|finding| is_kept && finding.name == "quantisation");
        for finding in withdrawn {
            let parameters = finding.parameters.iter().map(|parameter| (parameter.name, parameter.value)).collect();
            let lead = Lead {
                name: finding.name,
                family: finding.family,
                share: None,
                nonlinear_share: None,
                check_rms: None,
                parameters,
                only_in: None,
                why_not: reason.to_owned(),
            };
            self.leads.insert(0, lead);
        }
        self.findings = kept;
        if self.findings.is_empty() {
            self.verdict = Verdict::Unexplained;
        }
        self.after = given.clone();
        self.rivals.clear();
        self.record_terms.iter_mut().for_each(Vec::clear);
    }

    /// Removes a named quantiser from the model, with a note; returns whether there was one. For steps of about 1.5 to 8 times the noise a rounded
    /// simulation is further from a rounded measurement than one that is not rounded: they seldom round the same way.
    pub fn leave_rounding_out(&mut self) -> bool {
        let named = self.findings.iter().any(|finding| finding.name == "quantisation");
        let Some(quantiser) = find("quantisation").filter(|_| named) else { return false };
        self.after.effects = self.after.effects.without(quantiser);
        self.notes.push(
            "the positions are rounded as named, but the model does not contain it: with this noise it would increase the residual".to_owned(),
        );
        true
    }
}

/// One estimated parameter.
#[derive(Debug, Clone, Serialize)]
pub struct ParameterEstimate {
    /// Its name.
    #[serde(skip)]
    pub name: &'static str,
    /// Estimate.
    pub value: f64,
    /// Value in the given model, if that already has the effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub was: Option<f64>,
    /// Standard error; none where the records do not determine it.
    pub std_error: Option<f64>,
    /// Unit.
    pub unit: &'static str,
    /// Whether it is at a bound of its range.
    pub at_bound: bool,
    /// Estimates from each record by itself: fit records, then check records. Empty where none were made.
    pub of_records: Vec<f64>,
}

/// Parts of a difference, as shares of its variance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parts {
    /// The part that a flexible linear model of the command predicts on unseen samples.
    pub linear: f64,
    /// The rest above the noise.
    pub nonlinear: f64,
    /// Noise.
    pub noise: f64,
}

/// An explanation that is not named.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lead {
    /// Effect.
    pub name: &'static str,
    /// Its family.
    pub family: &'static str,
    /// Share of the excess that it explains on unseen records, 1 - s; none where it was not judged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// Share of the excess of the linear model that it explains, 1 - n; none where that model leaves noise alone, or it was not judged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nonlinear_share: Option<f64>,
    /// Root mean square of its residual on the check records, unseen; none where it was not judged.
    pub check_rms: Option<f64>,
    /// Its parameters.
    pub parameters: BTreeMap<&'static str, f64>,
    /// The only check record that shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub only_in: Option<String>,
    /// Why it is not named.
    pub why_not: String,
}

/// An effect that is named.
#[derive(Debug, Clone)]
pub struct Finding {
    /// Name.
    pub name: &'static str,
    /// Family.
    pub family: &'static str,
    /// Its parameters.
    pub parameters: Vec<ParameterEstimate>,
    /// BIC of the explanation without it, minus that with it.
    pub delta_bic: f64,
    /// Names that explain the records as well in its place.
    pub alternatives: Vec<String>,
}
