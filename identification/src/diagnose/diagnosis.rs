//! The result of a diagnosis.

use serde::{Deserialize, Serialize};

use super::{adequacy::Misfit, regressors::ExplainingRegressor};
use actuator_fmu::parameters::Model;

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The gap is noise.
    NothingMissing,
    /// One effect, or several, are identified.
    Named,
    /// The gap closes, but rivals close it as well.
    Ambiguous,
    /// A gap stays that no effect of the chain closes.
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
    /// Regressors that explain the residuals, where the verdict is [`Verdict::Unexplained`].
    pub carriers: Vec<ExplainingRegressor>,
    /// Root mean square of the noise in the check records [deg].
    pub noise_rms: f64,
    /// Values of measurement terms, free in each record: fitted records, then check records.
    pub record_terms: Vec<RecordTerms>,
    /// Start of each record [deg] and samples of settling, which are not evaluated.
    pub starts: Vec<(f64, usize)>,
    /// Residuals of the given model after a refit of the base: fitted records, then check records.
    pub residuals: Vec<Vec<f64>>,
    /// What to keep in mind.
    pub notes: Vec<String>,
}

/// One estimated parameter.
#[derive(Debug, Clone, Serialize)]
pub struct ParameterEstimate {
    /// Its name.
    #[serde(skip)]
    pub name: &'static str,
    /// Estimate.
    pub value: f64,
    /// Standard error; none where the records do not determine it.
    pub std_error: Option<f64>,
    /// Unit.
    pub unit: &'static str,
    /// Whether it lies on a bound of its range.
    pub at_bound: bool,
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
