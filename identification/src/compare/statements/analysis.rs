//! Analysis of BACT Actuator Behavior: time here, load and overall effects in [`super::load`].

use super::{
    load,
    order_statistics::{greatest, least, spread},
    pairs::{in_load_case, unloaded_wear, worst_phase},
    parameter_values::{K, OMEGA, ZETA, with},
    section::ANALYSIS,
};
use crate::compare::{
    comparison::Comparison,
    difference::{AEROELASTIC_BAND_HZ, Difference, LIMITS},
    set::Set,
    statement::Statement,
};
use actuator_fmu::parameters::{LoadCase, Model, Stage, Surface};

pub fn statements(tables: &Comparison) -> Vec<Statement> {
    vec![
        notable_changes(tables),
        primarily_phase(tables),
        representative(tables),
        beyond_six_hertz(tables),
        Statement::unchecked(
            ANALYSIS,
            "aeroelastic-frequencies",
            "The key aeroelastic frequencies of the wing are 3 to 5 Hz.",
            "The tables describe actuators, not the wing.",
        ),
        allowed_between_three_and_five(tables),
        beyond_five_hertz(tables),
        load::load_less_than_time(tables),
        Statement::unchecked(
            ANALYSIS,
            "early-is-free-of-wear",
            "Early in the test there was little wear and no change of gain, so that load can be seen alone.",
            "Neither wear nor gain was recorded.",
        ),
        load::load_insignificant(tables),
        load::figure_thirteen(tables),
        load::little_variation(tables),
        load::constant_coefficients(tables),
        load::scheduling(tables),
    ]
}

fn notable_changes(tables: &Comparison) -> Statement {
    let of = |surface: Surface, parameter: usize| {
        let unloaded = Stage::ALL.iter().filter_map(|&stage| tables.set(surface, stage, LoadCase::Unloaded));
        spread(&unloaded.map(|set| set.model.base.values()[parameter]).collect::<Vec<_>>())
    };
    let changes: Vec<(f64, f64, f64)> =
        Surface::ALL.iter().map(|&surface| (of(surface, OMEGA), of(surface, ZETA), of(surface, K))).collect();
    let listed: Vec<String> = Surface::ALL
        .iter()
        .zip(&changes)
        .map(|(surface, (omega, zeta, _))| format!("{} ω {omega:.2}, ζ {zeta:.2}", surface.short()))
        .collect();
    Statement::judged(
        ANALYSIS,
        "notable-changes-over-time",
        "Between the stages ω and ζ differ notably (figures 8 and 9).",
        changes.iter().all(|(omega, zeta, k)| omega.min(*zeta) > *k),
        format!(
            "Greatest over least without load: {}; k at most {:.2}.",
            listed.join("; "),
            greatest(changes.iter().map(|change| change.2))
        ),
    )
}

/// Differences as fractions of the limits, with the same k in both, so that only ω, ζ and p differ: (phase, magnitude).
fn shares(tables: &Comparison, pair: &Difference) -> Option<(f64, f64)> {
    let [from, to] = pair.conditions.as_ref()?;
    let [from, to] = [from, to].map(|condition| {
        tables.find(condition).map(|set| {
            let base = with(&set.model.base, K, 1.0);
            Set { model: Model { base, ..set.model.clone() }, ..set.clone() }
        })
    });
    let band = Difference::between(&from?, &to?).data_band;
    Some((band.phase_deg.max / LIMITS.phase_deg, band.magnitude.max / LIMITS.magnitude))
}

fn primarily_phase(tables: &Comparison) -> Statement {
    let counts: Vec<(Surface, usize, usize)> = Surface::ALL
        .iter()
        .map(|&surface| {
            let pairs: Vec<(f64, f64)> =
                unloaded_wear(tables, surface).iter().filter_map(|pair| shares(tables, pair)).collect();
            (surface, pairs.iter().filter(|(phase, magnitude)| phase > magnitude).count(), pairs.len())
        })
        .collect();
    let listed: Vec<String> =
        counts.iter().map(|(surface, more, all)| format!("{} {more} of {all}", surface.short())).collect();
    Statement::judged(
        ANALYSIS,
        "variations-are-of-phase",
        "The changes of ω and ζ mainly change the phase.",
        counts.iter().all(|(_, more, all)| more == all),
        format!(
            "Measured in shares of {} and {} deg, with k made equal, the phase changes more than the magnitude in {} of the unloaded pairs: \
             so it is for the trailing edge, not for the spoilers.",
            LIMITS.magnitude,
            LIMITS.phase_deg,
            listed.join(", ")
        ),
    )
}

fn representative(tables: &Comparison) -> Statement {
    let worst = Surface::ALL.iter().map(|&surface| worst_phase(unloaded_wear(tables, surface))).collect::<Vec<_>>();
    let within_factor = 2.0;
    Statement::judged(
        ANALYSIS,
        "figure-10-is-representative",
        "The trailing edge without load (figure 10) represents the effect of time.",
        spread(&worst) < within_factor,
        format!(
            "It changes by up to {:.2} deg (early to late), the upper spoiler by {:.2}, the lower by {:.2}: it is the extreme case, not \
             within a factor of {within_factor} of the others.",
            worst[0], worst[1], worst[2]
        ),
    )
}

/// Frequency at which a phase limit is first exceeded by any of the pairs [Hz].
fn first_passed<'a>(pairs: impl IntoIterator<Item = &'a Difference>) -> f64 {
    least(pairs.into_iter().filter_map(|pair| pair.data_band.phase_deg.first_passed_hz))
}

fn beyond_six_hertz(tables: &Comparison) -> Statement {
    let (said, about) = (6.0, 0.5);
    let first: Vec<f64> = Surface::ALL.iter().map(|&surface| first_passed(unloaded_wear(tables, surface))).collect();
    let loaded = first_passed(tables.wear.iter().filter(|pair| in_load_case(pair, LoadCase::Loaded)));
    let text =
        |first: f64| if first.is_finite() { format!("from {first:.2} Hz") } else { "nowhere up to 12 Hz".into() };
    let earliest = least(first.iter().copied());
    let early = if earliest < said {
        format!(" The first is {:.2} Hz below what is said.", said - earliest)
    } else {
        String::new()
    };
    Statement::judged(
        ANALYSIS,
        "significant-beyond-6-hz",
        "Differences of phase over time become significant beyond 6 Hz.",
        earliest > said - about,
        format!(
            "Without load 3 deg is exceeded {} by the trailing edge, {} by the upper spoiler, {} by the lower; under load {}.{early}",
            text(first[0]),
            text(first[1]),
            text(first[2]),
            text(loaded)
        ),
    )
}

fn allowed_between_three_and_five(tables: &Comparison) -> Statement {
    let pairs: Vec<&Difference> = tables.wear.iter().chain(&tables.load).collect();
    let phase = greatest(pairs.iter().map(|pair| pair.aeroelastic_band.phase_deg.max));
    let magnitude = greatest(pairs.iter().map(|pair| pair.aeroelastic_band.magnitude.max));
    Statement::judged(
        ANALYSIS,
        "allowed-between-3-and-5-hz",
        "Between 3 and 5 Hz the differences are generally within what is allowed.",
        pairs.iter().all(|pair| pair.aeroelastic_band.within_limits),
        format!(
            "All {} pairs of stages and of load cases are, with at most {magnitude:.3} and {phase:.2} deg between {} and {} Hz.",
            pairs.len(),
            AEROELASTIC_BAND_HZ[0],
            AEROELASTIC_BAND_HZ[1]
        ),
    )
}

fn beyond_five_hertz(tables: &Comparison) -> Statement {
    let passing: Vec<f64> = tables.wear.iter().filter_map(|pair| pair.data_band.phase_deg.first_passed_hz).collect();
    Statement::judged(
        ANALYSIS,
        "could-matter-beyond-5-hz",
        "Changes over time could matter to a control law that depends on the phase beyond 5 Hz.",
        passing.iter().any(|first| *first > AEROELASTIC_BAND_HZ[1]),
        format!(
            "{} of {} pairs of stages exceed 3 deg, the first at {:.2} Hz.",
            passing.len(),
            tables.wear.len(),
            least(passing.iter().copied())
        ),
    )
}
