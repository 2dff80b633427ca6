//! The result of a diagnosis.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{adequacy::Misfit, detectable::Detectable, predictable::Predictable, regressors::ExplainingRegressor};
use crate::inspect::noise::Noise;
use actuator_fmu::{effects::find, parameters::Model};

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The gap is noise.
    NothingMissing,
    /// One effect, or several, are identified.
    Named,
    /// One effect, or one family, takes the largest part of the gap on every unseen record that shows it; a gap stays.
    Leading,
    /// The gap closes, but rivals close it as well.
    Ambiguous,
    /// A gap stays that no effect of the chain closes, or that shows in a check record alone.
    Unexplained,
}

/// A hypothesis that was fitted, and how well it fits.
#[derive(Debug, Clone, Serialize)]
pub struct Candidate {
    /// Effects, joined by ` + `; `none` for the given model.
    pub name: String,
    /// Family of the effect that was added.
    pub family: &'static str,
    /// BIC above that of the best one.
    pub delta_bic: f64,
    /// Root mean square of its residuals on the fitted records [deg].
    pub fit_rms: f64,
    /// The same of the check records.
    pub check_rms: f64,
    /// Whether its search came to an end on these records; else the numbers are bounds of what it could reach.
    pub converged: bool,
}

/// Values of measurement effects that are free in each record, as parameters of the FMU.
pub type RecordTerms = Vec<(&'static str, f64)>;

/// What was found.
pub struct Diagnosis {
    /// The answer.
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
    /// Models that explain the records as well; empty but for [`Verdict::Ambiguous`].
    pub rivals: Vec<Model>,
    /// What the motion still explains of the residuals.
    pub misfit: Misfit,
    /// What it predicts of them on unseen samples.
    pub predictable: Predictable,
    /// Regressors that explain the residuals, where the verdict is [`Verdict::Unexplained`].
    pub carriers: Vec<ExplainingRegressor>,
    /// Noise of the check records, and how it is known.
    pub noise: Noise,
    /// What the gap of the given model is made of.
    pub parts: Parts,
    /// Explanations that take part of the gap on unseen records, and why they are not named.
    pub leads: Vec<Lead>,
    /// What would have been seen, where nothing is missing.
    pub detectable: Vec<Detectable>,
    /// Values of measurement terms, free in each record: fitted records, then check records.
    pub record_terms: Vec<RecordTerms>,
    /// Start of each record [deg] and samples of settling, which are not evaluated.
    pub starts: Vec<(f64, usize)>,
    /// Residuals of the given model after a refit of the base: fitted records, then check records.
    pub residuals: Vec<Vec<f64>>,
    /// What an adequate model leaves changes so slowly that it may be a disturbance as well as noise; a note says by how much.
    pub leaves_slow_rest: bool,
    /// What to keep in mind.
    pub notes: Vec<String>,
    /// Searches by least squares, each of one hypothesis from one start.
    pub searches: u64,
}

impl Diagnosis {
    /// A diagnosis that searched with another form of the given model: what it is in the given one.
    pub(super) fn of_given(mut self, searched: &Model, given: &Model) -> Self {
        for model in [&mut self.before, &mut self.after, &mut self.best] {
            if model == searched {
                model.clone_from(given);
            }
        }
        self
    }

    /// Takes names back, with the reason, and leaves the given model. A name of rounding that the model was left without stays: the values of the
    /// measurement show it, whatever the model does.
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

    /// Takes a named quantiser out of the model, and says so; whether there was one. Between about 1.5 and 8 times the noise a simulation that
    /// rounds is further from a measurement that rounds than one that does not: they seldom round the same way.
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
    /// In the given model, where that has the effect already.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub was: Option<f64>,
    /// Standard error; none where the records do not determine it.
    pub std_error: Option<f64>,
    /// Unit.
    pub unit: &'static str,
    /// Whether it lies on a bound of its range.
    pub at_bound: bool,
    /// The same fitted to each record by itself: fitted records, then check records. Empty where that was not asked.
    pub of_records: Vec<f64>,
}

/// What a difference is made of, as shares of its variance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parts {
    /// What a flexible linear model of the command predicts on samples that it was not fitted to.
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
    /// Share of the excess over the noise that it takes on unseen records; none where it was not judged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// Share that it takes of what the flexible linear model leaves above the noise; none where that is noise, or where it was not judged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nonlinear_share: Option<f64>,
    /// Root mean square that it leaves on unseen check records; none where it was not judged.
    pub check_rms: Option<f64>,
    /// Its strengths.
    pub parameters: BTreeMap<&'static str, f64>,
    /// The check record in which alone it shows.
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
    /// BIC above that of the explanation without it.
    pub delta_bic: f64,
    /// Names that would explain the records as well in its place.
    pub alternatives: Vec<String>,
}
