//! Abstract, Introduction, Experimental Data.

use super::{
    order_statistics::{greatest, least},
    pairs::{beyond_limits, listed, loaded_with_unloaded, unloaded_wear, worst_phase},
    parameter_values::K,
    section::{ABSTRACT, DATA, INTRODUCTION},
};
use crate::compare::{comparison::Comparison, difference::LIMITS, set::Set, statement::Statement};
use actuator_fmu::parameters::Surface;

pub fn statements(tables: &Comparison) -> Vec<Statement> {
    vec![
        consistent(tables),
        slight_degradation(tables),
        margins(),
        duration(),
        wear_follows_use(tables),
        Statement::unchecked(
            DATA,
            "unknown-gain",
            "The position error gain was changed during the test, unrecorded.",
            "Gain changes and wear cannot be told apart from k, p, ω and ζ; what is called wear here is both.",
        ),
    ]
}

fn consistent(tables: &Comparison) -> Statement {
    let beyond = beyond_limits(&tables.wear);
    Statement::judged(
        ABSTRACT,
        "consistent-throughout",
        "The actuators behaved consistently throughout the test.",
        beyond.is_empty(),
        format!(
            "{} of {} pairs of stages differ by more than {} or {} deg between 0.5 and 12 Hz: {}.",
            beyond.len(),
            tables.wear.len(),
            LIMITS.magnitude,
            LIMITS.phase_deg,
            listed(&beyond)
        ),
    )
}

/// Change of k under load for each pair [deg/deg].
fn gain_changes(tables: &Comparison) -> Vec<(String, f64)> {
    let change = |loaded: &Set, unloaded: &Set| loaded.model.base.values()[K] - unloaded.model.base.values()[K];
    let pairs = loaded_with_unloaded(tables).into_iter();
    pairs.map(|(loaded, unloaded)| (loaded.label.clone(), change(loaded, unloaded))).collect()
}

fn slight_degradation(tables: &Comparison) -> Statement {
    let changes = gain_changes(tables);
    let (worst, loss) =
        changes.iter().fold(
            ("", 0.0_f64),
            |worst, (label, change)| {
                if *change < worst.1 { (label.as_str(), *change) } else { worst }
            },
        );
    let gained = changes.iter().filter(|(_, change)| *change > 0.0).count();
    Statement::judged(
        ABSTRACT,
        "slight-degradation-by-load",
        "Aerodynamic hinge load degraded effectiveness only slightly.",
        loss.abs() <= LIMITS.magnitude && gained == 0,
        format!(
            "Taking slight for a loss of k within {}: {worst} loses {:.3} deg/deg, and k rises under load in {gained} of {} \
             pairs, by up to {:.3}.",
            LIMITS.magnitude,
            loss.abs(),
            changes.len(),
            greatest(changes.iter().map(|(_, change)| *change))
        ),
    )
}

fn margins() -> Statement {
    let (margin_db, margin_deg, share) = (6.0, 30.0, 0.1);
    let as_factor = share * (10_f64.powf(margin_db / 20.0) - 1.0);
    let in_decibels = 10_f64.powf(share * margin_db / 20.0) - 1.0;
    let phase_deg = share * margin_deg;
    let holds = (as_factor - LIMITS.magnitude).abs() < 0.01 && phase_deg == LIMITS.phase_deg;
    Statement::judged(
        INTRODUCTION,
        "limits-are-a-tenth-of-margins",
        "0.1 and 3 deg are about a tenth of usual margins of 6 dB and 30 deg.",
        holds,
        format!(
            "A tenth of 30 deg is {phase_deg} deg; a tenth of the factor's excess over 1 is {as_factor:.4}; a tenth of the decibels would be {in_decibels:.3}."
        ),
    )
}

fn duration() -> Statement {
    let (points, minutes, weeks) = (2300.0, 5.0, 4.0);
    let hours = points * minutes / 60.0;
    let per_working_day = hours / (weeks * 5.0);
    Statement::judged(
        DATA,
        "duration-of-the-test",
        "Over 2300 test points of about 5 minutes were recorded in about 4 weeks.",
        per_working_day < 24.0,
        format!("{hours:.0} hours of records: {per_working_day:.1} on each of 20 working days."),
    )
}

fn wear_follows_use(tables: &Comparison) -> Statement {
    let by_use = [Surface::TrailingEdge, Surface::UpperSpoiler, Surface::LowerSpoiler]
        .map(|surface| worst_phase(unloaded_wear(tables, surface)));
    Statement::judged(
        DATA,
        "variation-follows-use",
        "The surfaces were used to very different degrees, trailing edge most and lower spoiler least, so that their variation over time could differ.",
        least([by_use[0] / by_use[1], by_use[1] / by_use[2]]) > 1.0,
        format!(
            "Greatest change of phase between stages without load: {:.2}, {:.2} and {:.2} deg, in the order of use.",
            by_use[0], by_use[1], by_use[2]
        ),
    )
}
