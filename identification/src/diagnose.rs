//! Where simulation and measured records disagree, what is missing in the model, and how sure that is.
//!
//! [`diagnose`] reads as the workflow does: the base is refitted, every effect of the chain is tried beside it, what wins has to
//! win on records that it was not fitted to, more effects are added one at a time and those that are not needed are taken back, and
//! what is left has to be noise. Adding an effect to noise is the worst answer of all; "none of these" is an answer.

mod adequacy;
mod candidates;
mod fitted;
mod lattice;
mod line;
pub mod location;
pub mod next_test;
mod problem;
mod rounding;
mod search;
mod space;
pub mod terms;
mod trace;
mod verdict;

use serde::{Deserialize, Serialize};

pub use adequacy::Misfit;
pub use trace::{Motion, Trace};
pub use verdict::{Finding, ParameterEstimate};

use crate::signal::record::{Record, rms};
use actuator_fmu::{
    effects::find,
    error::{Error, Result},
    parameters::{Base, Model},
};
use fitted::{Care, Fitted};
use space::{Hypothesis, SWIFT_POLE, Space};

/// Lead in BIC that an effect must have over the model without it, and a name over its rivals. 10 is very strong evidence for one
/// comparison (A. E. Raftery, Sociol. Methodol. 25, 1995); there are some twenty.
pub const MARGIN: f64 = 14.0;

/// Rivals within this of the best explanation are named beside it.
pub const RIVAL: f64 = 12.0;

/// What an effect must gain on records that it was not fitted to: twice the logarithm of the likelihood ratio.
pub const CHECK_GAIN: f64 = 12.0;

/// More effects than this are not sought: with enough of them anything can be explained.
const MOST_EFFECTS: usize = 3;

/// Best hypotheses of a round that are kept.
const BEAM: usize = 3;

/// Single effects from which pairs are sought, where the best one leads nowhere.
const WIDE_BEAM: usize = 4;

/// Share of the records' end that is held out where there is but one record and none to check.
const HELD_OUT_SHARE: f64 = 0.3;

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The gap is noise.
    NothingMissing,
    /// One effect, or several, win.
    Named,
    /// The gap closes, but rivals close it as well.
    Ambiguous,
    /// A gap stays that no effect of the chain closes.
    Unexplained,
}

/// A candidate and how it did.
#[derive(Debug, Clone, Serialize)]
pub struct Candidate {
    /// Effects, joined by ` + `; `none` for the given model.
    pub name: String,
    /// Family of the effect that was added.
    pub family: &'static str,
    /// BIC above that of the best one.
    pub delta_bic: f64,
    /// Root mean square of what it leaves of the fitted records [deg].
    pub fit_rms: f64,
    /// The same of the check records.
    pub check_rms: f64,
}

/// Values of measurement effects that are free in each record, as parameters of the FMU.
pub type OfRecord = Vec<(&'static str, f64)>;

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
    /// What the motion still explains of the rest.
    pub misfit: Misfit,
    /// Terms of the motion that carry it, where it is unexplained.
    pub carriers: Vec<terms::Carrier>,
    /// Root mean square of the noise in the check records [deg].
    pub noise_rms: f64,
    /// Values of terms that are free in each record: fitted records, then check records.
    pub of_records: Vec<OfRecord>,
    /// Start of each record [deg] and samples at its start that do not count.
    pub starts: Vec<(f64, usize)>,
    /// Residuals of the given model after a refit of the base: fitted records, then check records.
    pub residuals: Vec<Vec<f64>>,
    /// What to keep in mind.
    pub notes: Vec<String>,
}

/// Records on which a model is judged that were not used to fit it.
pub struct Division {
    /// To fit.
    pub fit: Vec<Record>,
    /// To check.
    pub check: Vec<Record>,
    /// What was held out, in words, where there was nothing to check.
    pub note: Option<String>,
}

/// Divides records where none were given to check: the last one of several is held out, or the end of a single one.
///
/// # Errors
/// A single record too short to be divided.
pub fn divide(mut fit: Vec<Record>, check: Vec<Record>) -> Result<Division> {
    if !check.is_empty() {
        return Ok(Division { fit, check, note: None });
    }
    if fit.len() > 1 {
        let held: Vec<Record> = fit.pop().into_iter().collect();
        let note = format!("no check record was given; {} was held out as one", held[0].source().display());
        return Ok(Division { fit, check: held, note: Some(note) });
    }
    let Some(record) = fit.first() else { return Err(Error::new("records", "none", "one or more")) };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
    // a count of samples
    let cut = ((1.0 - HELD_OUT_SHARE) * record.len() as f64) as usize;
    let note = format!(
        "no check record was given; the last {:.0} % of {} were held out",
        100.0 * HELD_OUT_SHARE,
        record.source().display()
    );
    Ok(Division { check: vec![record.part(cut..record.len())?], fit: vec![record.part(0..cut)?], note: Some(note) })
}

/// Finds what is missing in a model.
///
/// # Errors
/// No records, records in different units, a model that cannot move through them.
pub fn diagnose(given: &Model, fit: &[Record], check: &[Record]) -> Result<Diagnosis> {
    let Some(first) = fit.first() else { return Err(Error::new("records", "none", "one or more")) };
    if let Some(other) = fit.iter().chain(check).find(|record| record.unit() != first.unit()) {
        let found = format!("{} and {}", first.unit(), other.unit());
        return Err(Error::new("units of the records", found, "one unit").at(other.source(), None));
    }
    let diagnosis = Study::of(given, fit, check)?;
    if diagnosis.verdict != Verdict::Unexplained {
        return Ok(diagnosis);
    }
    // A fit that does not know of an effect hides part of it in a lag.
    let Some(swift) = without_near_pole(given, fit) else { return Ok(diagnosis) };
    let second = Study::of(&swift, fit, check)?;
    if !matches!(second.verdict, Verdict::Named | Verdict::Ambiguous) {
        return Ok(diagnosis);
    }
    let mut notes = second.notes;
    notes.push(format!(
        "the given p of {:.0} 1/s was taken for a part of what is missing; the base is without it, its k, omega and zeta fitted anew",
        given.base.p()
    ));
    Ok(Diagnosis { before: given.clone(), notes, ..second })
}

struct Study<'a> {
    given: &'a Model,
    fit: Vec<Trace<'a>>,
    check: Vec<Trace<'a>>,
}

/// What the search came to.
struct Outcome {
    given: Fitted,
    /// The given model, or that with its base refitted where that is better.
    base: Fitted,
    /// Best first.
    candidates: Vec<Fitted>,
    /// None where the given model needs none.
    explanation: Option<Fitted>,
    /// What the explanation leaves.
    misfit: Misfit,
    /// The explanation is named although it leaves a smaller gap.
    forgiven: bool,
}

impl<'a> Study<'a> {
    /// The whole workflow.
    fn of(given: &'a Model, fit: &'a [Record], check: &'a [Record]) -> Result<Diagnosis> {
        let traces = |records: &'a [Record]| records.iter().map(|record| Trace::new(record, &given.base)).collect();
        let mut study = Study { given, fit: traces(fit), check: traces(check) };
        study.expect_rounding();
        let diagnosis = study.run()?;
        // The noise ahead of the rounding shows once the rest is explained.
        if study.expect_rounding_of(&diagnosis.best) { study.run() } else { Ok(diagnosis) }
    }
}

impl Study<'_> {
    fn run(&self) -> Result<Diagnosis> {
        let stuck = || Error::new("model", "a motion without end through these records", "a stable actuator");
        let outcome = self.explain().ok_or_else(stuck)?;
        let best = outcome.explanation.as_ref().unwrap_or(&outcome.given);
        let (checked, reference) = best.on(&self.check).zip(outcome.base.on(&self.check)).ok_or_else(stuck)?;
        self.in_words(&outcome, best, &checked, &reference)
    }

    /// The search: base, single effects, more of them, wider where that leads nowhere.
    fn explain(&self) -> Option<Outcome> {
        let given = self.fit(Hypothesis::default(), self.given)?;
        let free = self.fit(Hypothesis { base_free: true, ..Hypothesis::default() }, self.given)?;
        let base = if free.bic < given.bic { &free } else { &given };
        let first = self.one_more(base);
        let mut candidates: Vec<Fitted> = vec![given.clone(), free.clone()];
        candidates.extend(first.iter().cloned());
        let earned = self.earning(&first, base);
        let mut explanation = earned.and_then(|single| self.grow(single, &mut candidates));
        if explanation.is_none() && (self.gains(&free, &given) || self.mends(&free, &given)?) {
            explanation = Some(free.clone());
        }
        let current = explanation.as_ref().unwrap_or(base);
        if !self.misfit(current)?.is_noise() || current.space.is_base_at_bound(&current.x) {
            explanation = self.search_wider(base, current, &mut candidates).or(explanation);
        }
        candidates.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let mut misfit = self.misfit(explanation.as_ref().unwrap_or(&given))?;
        let mut forgiven = false;
        if !misfit.is_noise()
            && let Some(limit) = self.limit_that_shows(base, &candidates)
        {
            misfit = self.misfit(limit)?;
            explanation = Some(limit.clone());
            forgiven = true;
        }
        let base = base.clone();
        Some(Outcome { given, base, candidates, explanation, misfit, forgiven })
    }

    /// The verdict and all that goes with it. `best` is the explanation, or the given model; `checked` the same and `reference` the base on
    /// the check records.
    fn in_words(&self, outcome: &Outcome, best: &Fitted, checked: &Fitted, reference: &Fitted) -> Result<Diagnosis> {
        let Outcome { given, base, candidates, explanation, misfit, forgiven } = outcome;
        let is_rival = |other: &&Fitted| is_rival(other, best, given) && self.is_as_good_on_check(other, best);
        let rivals: Vec<Fitted> = match explanation {
            Some(_) => candidates.iter().filter(is_rival).cloned().collect(),
            None => Vec::new(),
        };
        let mut verdict = match (explanation, misfit.is_noise() || *forgiven) {
            (None, true) => Verdict::NothingMissing,
            (_, false) => Verdict::Unexplained,
            (Some(_), true) if rivals.is_empty() => Verdict::Named,
            (Some(_), true) => Verdict::Ambiguous,
        };
        let named = matches!(verdict, Verdict::Named | Verdict::Ambiguous);
        let noise_rms = adequacy::noise_rms(checked, &self.check);
        let mut findings =
            if named { verdict::findings(best, given, &rivals, candidates, &self.fit) } else { Vec::new() };
        let mut after = if named { best.model.clone() } else { self.given.clone() };
        if let Some(step) = self.quantisation(noise_rms)
            && verdict != Verdict::Unexplained
        {
            findings.push(verdict::quantisation(step, &self.fit));
            if let Some(quantisation) = find("quantisation") {
                after.effects = after.effects.with(quantisation, &[step])?;
            }
            verdict = if verdict == Verdict::NothingMissing { Verdict::Named } else { verdict };
        }
        if !findings.is_empty() {
            verdict::set_errors(&mut after, best, &findings, &self.fit);
        }
        let mut notes = Vec::new();
        if *forgiven {
            notes.push("a smaller gap stays that no effect of the chain explains".to_owned());
        }
        notes.extend(steady_rate(&after));
        let of_records = if named {
            of_records(best).into_iter().chain(of_records(checked)).collect()
        } else {
            vec![Vec::new(); self.fit.len() + self.check.len()]
        };
        let is_ambiguous = verdict == Verdict::Ambiguous;
        Ok(Diagnosis {
            verdict,
            findings,
            before: self.given.clone(),
            after,
            best: best.model.clone(),
            candidates: self.table(candidates),
            rivals: rivals.into_iter().filter(|_| is_ambiguous).map(|rival| rival.model).collect(),
            misfit: *misfit,
            carriers: if verdict == Verdict::Unexplained { adequacy::carriers(best, &self.fit) } else { Vec::new() },
            noise_rms,
            of_records,
            starts: self.fit.iter().chain(&self.check).map(|trace| (trace.start, trace.settling)).collect(),
            residuals: base.residuals.iter().chain(&reference.residuals).cloned().collect(),
            notes,
        })
    }

    fn fit(&self, hypothesis: Hypothesis, start: &Model) -> Option<Fitted> {
        Fitted::search(Space::new(hypothesis, start, &self.given.base, 0.0), &self.fit, Care::Fine)
    }

    fn table(&self, candidates: &[Fitted]) -> Vec<Candidate> {
        let best = candidates.first().map_or(0.0, |best| best.bic);
        let row = |fitted: &Fitted| Candidate {
            name: verdict::name(fitted),
            family: verdict::family_of(fitted),
            delta_bic: fitted.bic - best,
            fit_rms: fitted.rms(),
            check_rms: fitted.on(&self.check).map_or(f64::NAN, |checked| checked.rms()),
        };
        let mut rows: Vec<Candidate> = candidates.iter().map(row).collect();
        let mut seen = std::collections::BTreeSet::new();
        rows.retain(|row| seen.insert(row.name.clone()));
        rows
    }
}

/// Whether another explanation is as good, and not the same one with more in it.
fn is_rival(other: &Fitted, best: &Fitted, given: &Fitted) -> bool {
    let (here, there) = (&best.space.hypothesis, &other.space.hypothesis);
    let contains = |all: &[&str], some: &[&str]| some.iter().all(|effect| all.contains(effect));
    let same = here.effects.len() == there.effects.len() && contains(&here.effects, &there.effects);
    let richer = contains(&there.effects, &here.effects) && (there.base_free || !here.effects.is_empty());
    !same && !richer && other.bic < best.bic + RIVAL && other.bic < given.bic
}

/// Where the given pole is a lag that shows: the best model without that lag.
fn without_near_pole(given: &Model, fit: &[Record]) -> Option<Model> {
    // Half and twice of these hold all that actuators have.
    const DAMPING_RATIOS: [f64; 2] = [0.3, 0.7];
    let [k, _, omega, _] = given.base.values();
    if !space::has_near_pole(given) {
        return None;
    }
    let refitted = DAMPING_RATIOS.iter().filter_map(|zeta| {
        let start = Model { base: Base::from_values([k, SWIFT_POLE * omega, omega, *zeta]).ok()?, ..given.clone() };
        let traces: Vec<Trace<'_>> = fit.iter().map(|record| Trace::new(record, &start.base)).collect();
        let free = Hypothesis { base_free: true, ..Hypothesis::default() };
        Fitted::search(Space::new(free, &start, &start.base, 0.0), &traces, Care::Fine)
    });
    refitted.min_by(|a, b| a.bic.total_cmp(&b.bic)).map(|best| best.model)
}

/// What a limit of acceleration means for the rate: the drive is then as strong as the damping, value = 2ζω rate.
fn steady_rate(model: &Model) -> Option<String> {
    let (_, values) = model.effects.active().find(|(effect, _)| effect.name == "acceleration_limit")?;
    let rate = values[0] / (2.0 * model.base.zeta() * model.base.omega());
    Some(format!("the limit of acceleration allows no steady rate above value / (2 zeta omega) = {rate:.1} deg/s"))
}

/// Values of the terms in each record.
fn of_records(fitted: &Fitted) -> Vec<OfRecord> {
    let each = fitted.factors.iter().map(|factors| {
        let mut values = OfRecord::new();
        for (index, term) in fitted.space.terms().enumerate() {
            let [one, other] = [factors[2 * index], factors[2 * index + 1]];
            match term {
                space::Term::Bias => values.extend([("sensor_bias.offset", one), ("sensor_bias.drift", other)]),
                space::Term::Chatter => {
                    values.extend([("chatter.amplitude", one.hypot(other)), ("chatter.phase", other.atan2(one))]);
                }
            }
        }
        values
    });
    each.collect()
}

/// Root mean square of several columns together.
#[must_use]
pub fn pooled_rms(columns: &[Vec<f64>]) -> f64 {
    rms(&columns.iter().flatten().copied().collect::<Vec<f64>>())
}
