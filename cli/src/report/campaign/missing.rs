//! What the models of a campaign miss, in sentences.

use crate::{
    campaign::{Campaign, ConditionOutcome, Missing},
    report::{
        diagnosis,
        page::{Cell, Page},
    },
};
use identification::diagnose::Verdict;

/// What the models miss: one sentence for those that miss nothing, one for each of the others.
pub fn sentences(campaign: &Campaign) -> Vec<(String, String)> {
    let of = |outcome: &ConditionOutcome| match (&outcome.missing, &outcome.missing_failure) {
        (Some(missing), _) if missing.verdict != Verdict::NothingMissing => {
            let named: Vec<String> = missing
                .effects
                .iter()
                .map(|effect| {
                    let parameters = effect.parameters.iter();
                    let spoken = diagnosis::effect(
                        &effect.name,
                        parameters.map(|parameter| (parameter.name.as_str(), parameter.value, parameter.unit.as_str())),
                    );
                    let others = effect.alternatives.join(", ");
                    if others.is_empty() { spoken } else { format!("{spoken} or {others}") }
                })
                .collect();
            let what = if named.is_empty() { String::new() } else { format!(": {}", named.join(" and ")) };
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

/// The same as a part of the page; nothing where nothing was diagnosed.
pub fn section(page: Page, campaign: &Campaign) -> Page {
    let rows: Vec<Vec<Cell>> = sentences(campaign)
        .into_iter()
        .map(|(condition, sentence)| vec![Cell::text(condition), Cell::long(sentence)])
        .collect();
    if rows.is_empty() {
        return page;
    }
    page.heading("What the models miss").table(&["condition", "what"], &rows).remark(
        "The last record of each condition was held out. `actuator diagnose` on its records and its model writes the whole page.",
    )
}
