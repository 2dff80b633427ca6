//! Load, and load and time together.

use super::{
    order_statistics::greatest,
    pairs::{at_stage, beyond_limits, listed, of_surface, unloaded_wear, worst_phase},
    parameter_values::{K, OMEGA, ZETA, with},
    section::ANALYSIS,
};
use crate::compare::{comparison::Comparison, difference::Difference, set::Set, statement::Statement};
use actuator_fmu::parameters::{Model, Order, Stage, Surface};

/// Load early in the test, unaffected by wear, and wear without load, unaffected by load: phase [deg].
fn load_and_time(tables: &Comparison) -> [(f64, f64); 3] {
    [Surface::TrailingEdge, Surface::UpperSpoiler, Surface::LowerSpoiler].map(|surface| {
        let early = |pair: &&Difference| of_surface(pair, surface) && at_stage(pair, Stage::Early);
        (worst_phase(tables.load.iter().filter(early)), worst_phase(unloaded_wear(tables, surface)))
    })
}

pub fn load_less_than_time(tables: &Comparison) -> Statement {
    let [te, us, ls] = load_and_time(tables);
    let (load, wear) = (worst_phase(&tables.load), worst_phase(&tables.wear));
    Statement::judged(
        ANALYSIS,
        "load-less-than-time",
        "Hinge load has less effect than time.",
        [te, us, ls].iter().all(|(load, time)| load < time),
        format!(
            "Load early in the test against time without load, phase: trailing edge {:.2} against {:.2} deg, upper spoiler {:.2} against \
             {:.2}, lower spoiler {:.2} against {:.2}: true of the trailing edge only. Over all pairs load does up to {load:.1}, time up \
             to {wear:.1} deg.",
            te.0, te.1, us.0, us.1, ls.0, ls.1
        ),
    )
}

pub fn load_insignificant(tables: &Comparison) -> Statement {
    let beyond = beyond_limits(&tables.load);
    Statement::judged(
        ANALYSIS,
        "load-has-no-significant-impact",
        "Load had no significant impact on any actuator between 0.5 and 12 Hz.",
        beyond.is_empty(),
        format!("{} of {} pairs exceed a limit: {}.", beyond.len(), tables.load.len(), listed(&beyond)),
    )
}

pub fn figure_thirteen(tables: &Comparison) -> Statement {
    let shown = tables.load.iter().find(|pair| of_surface(pair, Surface::TrailingEdge) && at_stage(pair, Stage::Early));
    let claim = "The trailing edge early in the test hardly changes under load (figure 13).";
    match shown {
        None => Statement::unchecked(ANALYSIS, "figure-13", claim, "The sets are not there."),
        Some(pair) => Statement::judged(
            ANALYSIS,
            "figure-13",
            claim,
            pair.data_band.within_limits,
            format!("{:.2} deg and {:.3} at most.", pair.data_band.phase_deg.max, pair.data_band.magnitude.max),
        ),
    }
}

pub fn little_variation(tables: &Comparison) -> Statement {
    let (wear, load) = (beyond_limits(&tables.wear).len(), beyond_limits(&tables.load).len());
    let all = tables.wear.iter().chain(&tables.load);
    let worst = all.max_by(|a, b| a.data_band.phase_deg.max.total_cmp(&b.data_band.phase_deg.max));
    let worst = worst.map_or_else(String::new, |pair| {
        format!(" Worst: {} to {}, {:.1} deg.", pair.from, pair.to, pair.data_band.phase_deg.max)
    });
    Statement::judged(
        ANALYSIS,
        "varied-little",
        "As a whole, the responses varied little over time and under load.",
        wear + load == 0,
        format!(
            "{wear} of {} pairs of stages and {load} of {} pairs of load cases exceed 0.1 or 3 deg between 0.5 and 12 Hz.{worst}",
            tables.wear.len(),
            tables.load.len()
        ),
    )
}

/// Every set of a surface against one second-order model, the geometric mean of the surface's sets.
fn against_mean(tables: &Comparison, surface: Surface) -> Vec<Difference> {
    let sets: Vec<&Set> = tables
        .sets
        .iter()
        .filter(|set| set.condition.as_ref().is_some_and(|condition| condition.is_of(surface)))
        .collect();
    let Some(first) = sets.first() else { return Vec::new() };
    let base = [K, OMEGA, ZETA].iter().fold(first.model.base, |base, &parameter| {
        let logarithms = sets.iter().map(|set| set.model.base.values()[parameter].ln());
        with(&base, parameter, (logarithms.sum::<f64>() / sets.len() as f64).exp())
    });
    let mean = Set::new(format!("{} mean", surface.short()), Model::new(base, Order::Second));
    sets.iter().map(|set| Difference::between(&mean, set)).collect()
}

pub fn constant_coefficients(tables: &Comparison) -> Statement {
    let differences: Vec<Difference> = Surface::ALL.iter().flat_map(|&surface| against_mean(tables, surface)).collect();
    let beyond: Vec<String> = differences
        .iter()
        .filter(|difference| !difference.data_band.within_limits)
        .map(|difference| format!("{} {:.1} deg", difference.to, difference.data_band.phase_deg.max))
        .collect();
    let between = greatest(differences.iter().map(|difference| difference.aeroelastic_band.phase_deg.max));
    Statement::judged(
        ANALYSIS,
        "constant-second-order-models-do",
        "The actuators can be modelled by second-order transfer functions with constant coefficients.",
        beyond.is_empty(),
        format!(
            "With one such model for each surface (geometric mean of its sets) {} of 17 sets exceed 0.1 or 3 deg up to 12 Hz: {}. Between 3 and \
             5 Hz all stay within {between:.1} deg.",
            beyond.len(),
            beyond.join(", ")
        ),
    )
}

pub fn scheduling(tables: &Comparison) -> Statement {
    let early: Vec<&Difference> = tables
        .load
        .iter()
        .filter(|pair| at_stage(pair, Stage::Early))
        .filter(|pair| !pair.data_band.within_limits)
        .collect();
    Statement::judged(
        ANALYSIS,
        "no-scheduling-with-load",
        "Coefficients need not follow hinge load, though perhaps wear if small changes of phase matter.",
        early.is_empty(),
        format!(
            "Where load stands alone, early in the test, it exceeds a limit for {}; upper spoiler late {:.1} deg.",
            listed(&early),
            worst_phase(
                tables
                    .load
                    .iter()
                    .filter(|pair| { of_surface(pair, Surface::UpperSpoiler) && at_stage(pair, Stage::Late) })
            )
        ),
    )
}
