//! Effects missing in the models of a campaign: in sentences, as a list that gives doubts the same weight as names, as a table and as a
//! chart.

use crate::{
    campaign::{
        Campaign, ConditionOutcome, Missing,
        differences::{Differences, folder_of},
    },
    report::{
        diagnosis,
        page::{Cell, Page, Tone},
        plot::{Axis, Panel, Plot, Row, Rows, Style},
    },
};
use identification::{
    diagnose::Verdict,
    digits::{significant, with_unit},
};

/// Outcome of the diagnosis of one condition.
enum Answer<'a> {
    /// A verdict.
    Given(&'a Missing),
    /// The records, their fit or the diagnosis were refused.
    Refused(&'a str),
}

impl Answer<'_> {
    fn tone(&self) -> Tone {
        match self {
            Self::Given(missing) => diagnosis::tone(missing.verdict),
            Self::Refused(_) => Tone::Bad,
        }
    }

    /// In a word or two. A leading effect explains a part.
    fn words(&self) -> &'static str {
        match self {
            Self::Given(missing) if missing.verdict == Verdict::Leading => "partly explained",
            Self::Given(missing) => diagnosis::words(missing.verdict),
            Self::Refused(_) => "refused",
        }
    }

    /// The named effect, or why there is none.
    fn what(&self) -> String {
        match self {
            Self::Given(missing) => effects(missing),
            Self::Refused(reason) => (*reason).to_owned(),
        }
    }
}

/// A condition, its verdict, and its differences if known.
type Answered<'a> = (&'a ConditionOutcome, Answer<'a>, Option<&'a Differences>);

fn answer(outcome: &ConditionOutcome) -> Option<Answer<'_>> {
    let refusal = outcome.failure.as_deref().or(outcome.missing_failure.as_deref());
    outcome.missing.as_ref().map(Answer::Given).or_else(|| refusal.map(Answer::Refused))
}

/// Effects with their strengths and with other names that explain the records as well.
fn effects(missing: &Missing) -> String {
    let named = missing.effects.iter().map(|effect| {
        let parameters = effect.parameters.iter();
        let spoken = diagnosis::effect(
            &effect.name,
            parameters.map(|parameter| (diagnosis::plain(&parameter.name), parameter.value, parameter.unit.as_str())),
        );
        let others = effect.alternatives.join(", ");
        if others.is_empty() { spoken } else { format!("{spoken} or {others}") }
    });
    named.collect::<Vec<String>>().join(" and ")
}

/// Missing effects: one sentence for the models without any, one for each of the others.
pub fn sentences(campaign: &Campaign) -> Vec<(String, String)> {
    let of = |outcome: &ConditionOutcome| match (&outcome.missing, &outcome.missing_failure) {
        (Some(missing), _) if missing.verdict != Verdict::NothingMissing => {
            let named = effects(missing);
            let what = if named.is_empty() { String::new() } else { format!(": {named}") };
            Some(format!("{}{what}", diagnosis::words(missing.verdict)))
        }
        (None, Some(failure)) => Some(format!("not diagnosed: {failure}")),
        _ => None,
    };
    let each = campaign.conditions.iter().filter_map(|outcome| Some((outcome.condition.to_string(), of(outcome)?)));
    let is_complete = |missing: &Missing| missing.verdict == Verdict::NothingMissing;
    let diagnosed = campaign.conditions.iter().filter_map(|outcome| outcome.missing.as_ref());
    let (complete, all) =
        diagnosed.fold((0, 0), |(complete, all), missing| (complete + usize::from(is_complete(missing)), all + 1));
    let first = (all > 0).then(|| ("nothing missing".to_owned(), format!("{complete} of {all} conditions")));
    first.into_iter().chain(each).collect()
}

/// Number of conditions per verdict, in a sentence, and the overall state.
pub fn summary(campaign: &Campaign) -> (Tone, String, String) {
    let answers: Vec<Answer<'_>> = campaign.conditions.iter().filter_map(answer).collect();
    let refused = campaign.records.iter().filter(|record| record.result.is_none()).count();
    let of_records = match refused {
        0 => format!("all {} records were analysed", campaign.records.len()),
        1 => format!("1 of {} records was refused", campaign.records.len()),
        _ => format!("{refused} of {} records were refused", campaign.records.len()),
    };
    let is_diagnosed =
        campaign.conditions.iter().any(|outcome| outcome.missing.is_some() || outcome.missing_failure.is_some());
    if !is_diagnosed {
        let fitted = campaign.conditions.iter().filter(|outcome| outcome.result.is_some()).count();
        let sentence = format!(
            "{fitted} of {} conditions have a model, not diagnosed for missing effects; {of_records}.",
            campaign.conditions.len()
        );
        let tone = if refused > 0 { Tone::Bad } else { Tone::Open };
        return (tone, "not diagnosed".into(), sentence);
    }
    const ORDER: [&str; 6] = ["nothing missing", "named", "ambiguous", "partly explained", "unexplained", "refused"];
    let count = |words: &str| answers.iter().filter(|answer| answer.words() == words).count();
    let each = ORDER.iter().filter(|words| count(words) > 0).map(|words| format!("{} {words}", count(words)));
    let sentence =
        format!("of {} conditions, {}; {of_records}.", answers.len(), each.collect::<Vec<String>>().join(", "));
    let doubtful = answers.iter().filter(|answer| answer.tone() != Tone::Good).count();
    let gravest = match doubtful {
        _ if refused > 0 || answers.iter().any(|answer| answer.tone() == Tone::Bad) => Tone::Bad,
        0 => Tone::Good,
        _ => Tone::Open,
    };
    let words = match doubtful {
        0 => "all answered".to_owned(),
        1 => "1 open answer".to_owned(),
        _ => format!("{doubtful} open answers"),
    };
    (gravest, words, sentence)
}

/// The verdicts as a part of the page. `differences` are those of the conditions, in their order.
pub fn section(page: Page, campaign: &Campaign, differences: &[Option<Differences>]) -> Page {
    let known = differences.iter().map(Option::as_ref).chain(std::iter::repeat(None));
    let conditions = campaign.conditions.iter().zip(known);
    let answers: Vec<Answered<'_>> =
        conditions.filter_map(|(outcome, differences)| Some((outcome, answer(outcome)?, differences))).collect();
    if answers.is_empty() {
        return page;
    }
    let spoken = answers.iter().filter(|(outcome, ..)| {
        // A condition without a model is listed as refused.
        let is_complete = |missing: &Missing| missing.verdict == Verdict::NothingMissing;
        outcome.failure.is_none() && !outcome.missing.as_ref().is_some_and(is_complete)
    });
    let spoken: Vec<_> = spoken
        .map(|(outcome, answer, differences)| {
            let sentence = differences.map_or_else(|| answer.what(), |found| found.sentence.clone());
            (answer.tone(), answer.words().to_owned(), outcome.condition.to_string(), sentence, String::new())
        })
        .collect();
    let mut page = page.heading("What the models miss");
    if !spoken.is_empty() {
        page = page.verdicts(&spoken);
    }
    let row = |(outcome, answer, differences): &Answered<'_>| {
        let rms =
            |side: usize| differences.map_or_else(|| "-".into(), |found| with_unit(found.rms()[side], 3, &found.unit));
        let noise = differences.map_or_else(|| "-".into(), |found| with_unit(found.noise_rms(), 3, &found.unit));
        vec![
            Cell::text(outcome.condition.to_string()),
            Cell::toned(answer.words(), answer.tone()),
            Cell::links(links(outcome, differences.is_some())),
            Cell::number(rms(0)),
            Cell::number(rms(1)),
            Cell::number(noise),
            Cell::long(answer.what()),
        ]
    };
    let heads = ["condition", "verdict", "files", "difference before", "after", "noise", "what"];
    let rows: Vec<Vec<Cell>> = answers.iter().map(row).collect();
    page = page.table(&heads, &rows).remark(
        "Rms of measured minus simulated position on the held-out record, the last of each condition by name. The first file of a condition \
         is the page of its diagnosis.",
    );
    match picture(&answers) {
        Some(plot) => page.plots([&plot]),
        None => page,
    }
}

/// The files of a condition: those of its diagnosis, and its fitted model.
fn links(outcome: &ConditionOutcome, is_diagnosed: bool) -> Vec<(String, String)> {
    let folder = folder_of(outcome);
    let of_diagnosis =
        [("page", "report.html"), ("JSON", "diagnosis.json"), ("model", "model.toml"), ("FMU", "model.fmu")];
    let of_diagnosis = of_diagnosis.map(|(text, file)| (text.to_owned(), format!("{folder}/{file}")));
    let of_diagnosis = of_diagnosis.into_iter().filter(|_| is_diagnosed);
    let fitted =
        outcome.result.is_some().then(|| ("fitted model".to_owned(), format!("models/{}.toml", outcome.condition)));
    of_diagnosis.chain(fitted).collect()
}

/// Differences before and after as multiples of the noise, a row for each condition.
fn picture(answers: &[Answered<'_>]) -> Option<Plot> {
    let rows: Vec<Row> = answers
        .iter()
        .filter_map(|(outcome, _, differences)| {
            let found = differences.filter(|found| found.noise_rms() > 0.0)?;
            let [before, after] = found.rms().map(|rms| rms / found.noise_rms());
            let text = format!("{} to {}", significant(before, 3), significant(after, 3));
            Some(Row { name: outcome.condition.to_string(), text, values: vec![Some(before), Some(after)] })
        })
        .collect();
    let greatest = rows.iter().flat_map(|row| &row.values).flatten().copied().fold(1.2, f64::max);
    let series = vec![(Style::colour(1), "before".to_owned()), (Style::colour(0), "after".to_owned())];
    let panel = Panel::of_rows(Rows { series, rows: rows.clone(), limit: Some((1.0, "noise".into())) });
    let axis = Axis::around("rms of the difference over that of the noise", [0.0, greatest]);
    (!rows.is_empty()).then(|| Plot::new("Differences before and after", axis).panel(panel))
}
