//! Application of Parameter Estimation Procedure.

use super::{
    estimation::{NO_MEASUREMENTS, bandwidth_hz, bases},
    order_statistics::{greatest, least, spread},
    pairs::{loaded_with_unloaded, of_load_case, worst_phase},
    parameter_values::{K, OMEGA, P, ZETA, values, with},
    section::APPLICATION,
};
use crate::{
    compare::{
        comparison::Comparison,
        difference::{Difference, LIMITS},
        set::Set,
        statement::Statement,
    },
    frequency::BAND_HZ,
};
use actuator_fmu::parameters::{Base, LoadCase, Model, Stage, Surface};

pub fn statements(tables: &Comparison) -> Vec<Statement> {
    vec![
        Statement::unchecked(
            APPLICATION,
            "stopping",
            "Iterations ended by the change of the parameters, never by the error.",
            "The tables hold results only. `actuator fit --method report` shows it on any record.",
        ),
        guesses(tables),
        loaded_like_unloaded(tables),
        resonance_varies(tables),
        missing_set(tables),
        Statement::unchecked(
            APPLICATION,
            "models-match-measurements",
            "Responses from the tables closely match the measured ones from 0.5 to 12 Hz.",
            NO_MEASUREMENTS,
        ),
        varies_less(tables, "gain-varies-less", K, "k varied much less over time and load than ω and ζ."),
        varies_less(tables, "pole-varies-less", P, "p varied much less over time and load than ω and ζ."),
        pole_is_large(tables),
        pole_is_negligible(tables),
        second_order_suffices(tables),
    ]
}

fn guesses(tables: &Comparison) -> Statement {
    let start = 10_000.0;
    let at_start = bases(tables).filter(|base| (base.p() - start).abs() <= 5.0).count();
    let doubled = greatest(tables.sets.iter().map(|set| {
        let base = with(&set.model.base, P, 2.0 * set.model.base.p());
        let moved = Set { model: Model { base, ..set.model.clone() }, ..set.clone() };
        Difference::between(set, &moved).data_band.phase_deg.max
    }));
    Statement::judged(
        APPLICATION,
        "flat-minimum",
        "Sensitivity to first guesses, most of all to that of p, points to a very flat minimum.",
        doubled < LIMITS.phase_deg,
        format!(
            "p is within 5 of a round {start} 1/s in {at_start} of 17 sets: it stayed where it was put. Doubling it moves no response by \
             more than {doubled:.2} deg."
        ),
    )
}

/// Interpretation of "similar": maximum change.
const SIMILAR: f64 = 0.25;

fn loaded_like_unloaded(tables: &Comparison) -> Statement {
    let pairs = loaded_with_unloaded(tables);
    let mut unlike = Vec::new();
    for (set, unloaded) in &pairs {
        let change =
            |parameter: usize| set.model.base.values()[parameter] / unloaded.model.base.values()[parameter] - 1.0;
        let (omega, zeta) = (change(OMEGA), change(ZETA));
        if omega.abs().max(zeta.abs()) > SIMILAR {
            unlike.push(format!("{} ω {:+.0} %, ζ {:+.0} %", set.label, 100.0 * omega, 100.0 * zeta));
        }
    }
    Statement::judged(
        APPLICATION,
        "loaded-like-unloaded",
        "First guesses were chosen so that the parameters under load were similar to those without.",
        unlike.is_empty(),
        format!(
            "{} of {} loaded sets differ by more than {:.0} %: {}.",
            unlike.len(),
            pairs.len(),
            100.0 * SIMILAR,
            unlike.join("; ")
        ),
    )
}

fn resonance_varies(tables: &Comparison) -> Statement {
    let loaded = of_load_case(tables, LoadCase::Loaded).map(|set| &set.model.base);
    let bandwidths: Vec<f64> = loaded.clone().map(bandwidth_hz).collect();
    // Resonant peak of the second-order part over its static gain: 1 / (2 ζ √(1 - ζ²)) for ζ < 1/√2, otherwise 1.
    let peaks: Vec<f64> = loaded
        .map(|base| {
            let zeta = base.zeta();
            if zeta < std::f64::consts::FRAC_1_SQRT_2 { 0.5 / (zeta * (1.0 - zeta * zeta).sqrt()) } else { 1.0 }
        })
        .collect();
    Statement::judged(
        APPLICATION,
        "bandwidth-and-peak-vary-under-load",
        "Under load, bandwidth and resonant peak can vary much at similar accuracy in the band of interest.",
        spread(&bandwidths) > 1.0 + SIMILAR && spread(&peaks) > 1.0 + SIMILAR,
        format!(
            "Table 2 spans -3 dB bandwidths of {:.1} to {:.1} Hz and peaks of {:.2} to {:.2} times k. The accuracy cannot be checked.",
            least(bandwidths.iter().copied()),
            greatest(bandwidths.iter().copied()),
            least(peaks.iter().copied()),
            greatest(peaks.iter().copied())
        ),
    )
}

fn varies_less(tables: &Comparison, name: &'static str, parameter: usize, claim: &'static str) -> Statement {
    let of = |parameter| spread(&values(tables, parameter));
    let (own, omega, zeta) = (of(parameter), of(OMEGA), of(ZETA));
    let symbol = Base::PARAMETERS[parameter].name;
    let more = if parameter == P {
        let unloaded: Vec<f64> = of_load_case(tables, LoadCase::Unloaded).map(|set| set.model.base.p()).collect();
        format!(
            " In table 1 it never moves (factor {}); in table 2 it goes from {} to {:.2e} 1/s, which no response shows.",
            spread(&unloaded),
            least(values(tables, P)),
            greatest(values(tables, P))
        )
    } else {
        String::new()
    };
    Statement::judged(
        APPLICATION,
        name,
        claim,
        own < omega.min(zeta),
        format!(
            "Greatest over least of the 17 values: {symbol} {own:.prec$}, ω {omega:.2}, ζ {zeta:.2}.{more}",
            prec = if own < 100.0 { 2 } else { 0 }
        ),
    )
}

fn pole_is_large(tables: &Comparison) -> Statement {
    let smallest = least(values(tables, P));
    let times = smallest / (std::f64::consts::TAU * BAND_HZ[1]);
    Statement::judged(
        APPLICATION,
        "pole-remained-large",
        "p remained very large throughout, with and without load.",
        times > 10.0,
        format!(
            "The smallest p is {smallest} 1/s, {times:.0} times the highest frequency of the data. Such a p cannot be told from a larger \
             one by these data: read it as a lower bound."
        ),
    )
}

fn pole_is_negligible(tables: &Comparison) -> Statement {
    let phase = worst_phase(&tables.order);
    let magnitude = greatest(tables.order.iter().map(|pair| pair.data_band.magnitude.max));
    Statement::judged(
        APPLICATION,
        "pole-is-negligible",
        "p / (s + p) is almost 1 in the range of interest and contributes negligibly.",
        tables.order.iter().all(|pair| pair.data_band.within_limits),
        format!("It takes away at most {magnitude:.5} deg/deg and turns the phase by at most {phase:.3} deg."),
    )
}

fn second_order_suffices(tables: &Comparison) -> Statement {
    let figure_7 = tables
        .set(Surface::LowerSpoiler, Stage::Early, LoadCase::Unloaded)
        .and_then(|set| tables.order.iter().find(|pair| pair.from == set.label))
        .map(|pair| pair.data_band);
    let worst = tables.order.iter().max_by(|a, b| a.data_band.phase_deg.max.total_cmp(&b.data_band.phase_deg.max));
    let (Some(shown), Some(worst)) = (figure_7, worst) else {
        return Statement::unchecked(APPLICATION, "second-order-suffices", SECOND_ORDER, "The sets are not there.");
    };
    Statement::judged(
        APPLICATION,
        "second-order-suffices",
        SECOND_ORDER,
        tables.order.iter().all(|pair| pair.data_band.within_limits),
        format!(
            "Lower spoiler early, unloaded: {:.3} deg and {:.0e} deg/deg at most. Worst: {} with {:.3} deg.",
            shown.phase_deg.max, shown.magnitude.max, worst.from, worst.data_band.phase_deg.max
        ),
    )
}

const SECOND_ORDER: &str =
    "A second-order transfer function does as well (figure 7: very small errors of magnitude and phase).";

fn missing_set(tables: &Comparison) -> Statement {
    let missing = tables.set(Surface::LowerSpoiler, Stage::Late, LoadCase::Loaded).is_none();
    Statement::judged(
        APPLICATION,
        "no-data-for-lower-spoiler-late",
        "There are no data for the lower spoiler late in the test under load.",
        missing && tables.sets.len() == 17,
        format!(
            "Tables 1 and 2 hold {} sets; figure A10 has two parts where the others have three.",
            tables.sets.len()
        ),
    )
}
