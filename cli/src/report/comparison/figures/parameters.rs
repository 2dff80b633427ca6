//! Bars of one parameter: over the stages of the test, and without and with load.

use crate::report::plot::{Axis, Panel, Plot, Style};
use actuator_fmu::parameters::{LoadCase, Stage, Surface};
use identification::compare::{Comparison, Set};

/// The bars of one surface: label, stage and load case.
pub type Groups = Vec<(&'static str, Stage, LoadCase)>;

pub fn by_stage() -> Groups {
    Stage::ALL.iter().map(|&stage| (stage.name(), stage, LoadCase::Unloaded)).collect()
}

pub fn by_load() -> Groups {
    LoadCase::ALL.iter().map(|&load_case| (load_case.name(), Stage::Early, load_case)).collect()
}

/// One group of bars for each surface; `None` for fewer than two bars, which show no difference.
pub fn bars(comparison: &Comparison, parameter: usize, groups: &Groups) -> Option<Plot> {
    let find = |stage, load_case| -> Vec<Option<&Set>> {
        Surface::ALL.iter().map(|&surface| comparison.set(surface, stage, load_case)).collect()
    };
    let value = |set: Option<&Set>| set.map(|set| set.model.base.values()[parameter]);
    let error =
        |set: Option<&Set>| set.and_then(|set| set.model.std_errors[parameter]).map(|error| TWO_SIDED_95 * error);
    let series: Vec<_> = groups
        .iter()
        .map(|(label, stage, load_case)| {
            let sets = find(*stage, *load_case);
            let values: Vec<Option<f64>> = sets.iter().map(|set| value(*set)).collect();
            (*label, values, sets.iter().map(|set| error(*set)).collect::<Vec<_>>())
        })
        .collect();
    let greatest = series.iter().flat_map(|(_, values, _)| values).flatten().copied().fold(0.0, f64::max);
    let known = series.iter().flat_map(|(_, values, _)| values).flatten().count();
    if known < 2 || greatest == 0.0 {
        return None;
    }
    let gain = format!("k, {}", comparison.gain_unit());
    let [title, label] = [
        ["Gain k", gain.as_str()],
        ["First-order pole p", "p, 1/s"],
        ["Frequency ω", "frequency ω, rad/s"],
        ["Damping ratio ζ", "damping ratio ζ"],
    ][parameter];
    let mut panel = Panel::new(Axis::around(label, [0.0, 1.08 * greatest])).height(220.0);
    let uncertain = series.iter().any(|(_, _, errors)| errors.iter().any(Option::is_some));
    for ((label, values, errors), colour) in series.into_iter().zip(0..) {
        panel = panel.bars_with_errors(Style::colour(colour), label, values, errors);
    }
    let note = if uncertain { "Whiskers: 95 % intervals." } else { "" };
    let names = ["trailing edge", "upper spoiler", "lower spoiler"];
    Some(Plot::new(title, Axis::categories("", &names)).note(note).panel(panel))
}

/// Half width of a 95 % interval of the normal distribution in standard errors.
const TWO_SIDED_95: f64 = 1.96;
