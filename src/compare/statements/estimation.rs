//! Actuator Model Structure, Parameter Estimation, Application of Parameter Estimation Procedure.

use super::{
    Comparison, K, LIMITS, OMEGA, P, Statement, ZETA, greatest, least, loaded_with_unloaded, median, of_load_case,
    spread, values, with, worst_phase,
};
use crate::{
    compare::{Difference, POINTS_PER_HZ, Set},
    frequency::{BAND_HZ, phase_deg, response},
    parameters::{Base, LoadCase, Model, Order, Stage, Surface},
};

const STRUCTURE: &str = "Actuator Model Structure";
const ESTIMATION: &str = "Parameter Estimation";
const APPLICATION: &str = "Application of Parameter Estimation Procedure";
const NO_MEASUREMENTS: &str = "The report's measured responses exist as pictures only, not as data.";

pub fn statements(tables: &Comparison) -> Vec<Statement> {
    vec![
        dependent_parameters(tables),
        Statement::unchecked(
            ESTIMATION,
            "accuracy-of-fits",
            "Fits were accepted when they were within about 0.1 and 3 deg of the measurement between 2 and 10 Hz.",
            NO_MEASUREMENTS,
        ),
        bandwidth(tables),
        phase_shows_first(tables),
        information_in_phase(tables),
        Statement::unchecked(
            APPLICATION,
            "stopping",
            "Iterations ended by the change of the parameters, never by the error.",
            "The tables hold results only. `actuator fit --method report` shows it on any record.",
        ),
        guesses(tables),
        loaded_like_unloaded(tables),
        resonance_varies(tables),
        Statement::unchecked(
            APPLICATION,
            "models-match-measurements",
            "Responses from the tables closely match the measured ones from 0.5 to 12 Hz.",
            NO_MEASUREMENTS,
        ),
        missing_set(tables),
        varies_less(tables, "gain-varies-less", K, "k varied much less over time and load than ω and ζ."),
        varies_less(tables, "pole-varies-less", P, "p varied much less over time and load than ω and ζ."),
        pole_is_large(tables),
        pole_is_negligible(tables),
        second_order_suffices(tables),
    ]
}

/// Two-sided 5 % point of the correlation coefficient of 17 pairs (Student's t with 15 degrees of freedom, 2.131).
const CORRELATION_AT_5_PERCENT: f64 = 0.482;

fn dependent_parameters(tables: &Comparison) -> Statement {
    let (omega, zeta) = (values(tables, OMEGA), values(tables, ZETA));
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (omega_mean, zeta_mean) = (mean(&omega), mean(&zeta));
    let product = |a: &[f64], a_mean: f64, b: &[f64], b_mean: f64| -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - a_mean) * (b - b_mean)).sum()
    };
    let correlation = product(&omega, omega_mean, &zeta, zeta_mean)
        / (product(&omega, omega_mean, &omega, omega_mean) * product(&zeta, zeta_mean, &zeta, zeta_mean)).sqrt();
    Statement::judged(
        STRUCTURE,
        "parameters-depend-on-each-other",
        "The parameters are not independent, being coupled through the servo loop.",
        correlation.abs() > CORRELATION_AT_5_PERCENT,
        format!(
            "ω and ζ of the 17 sets correlate by {correlation:.2}; chance alone stays below {CORRELATION_AT_5_PERCENT} in 95 % of \
             cases. (The fit couples them as well.)"
        ),
    )
}

/// Where the magnitude has fallen by 3 dB from the gain at rest [Hz].
fn bandwidth_hz(base: &Base) -> f64 {
    let half_power = base.k().abs() * std::f64::consts::FRAC_1_SQRT_2;
    let mut index = 1_u32;
    loop {
        let frequency = f64::from(index) / POINTS_PER_HZ;
        // No set of the tables comes near a kilohertz.
        if frequency > 1e3 || response(base, Order::Third, frequency).norm() < half_power {
            return frequency;
        }
        index += 1;
    }
}

fn bases(tables: &Comparison) -> impl Iterator<Item = &Base> + Clone {
    tables.sets.iter().map(|set| &set.model.base)
}

fn bandwidth(tables: &Comparison) -> Statement {
    let ratios: Vec<f64> = bases(tables).map(|base| bandwidth_hz(base) / BAND_HZ[1]).collect();
    let middle = median(ratios.iter().copied());
    let trailing_edge = tables
        .sets
        .iter()
        .zip(&ratios)
        .filter(|(set, _)| set.condition.as_ref().is_some_and(|condition| condition.is_of(Surface::TrailingEdge)));
    Statement::judged(
        ESTIMATION,
        "bandwidth-about-twice",
        "The bandwidth was about twice the highest excitation frequency.",
        (1.5..=2.5).contains(&middle),
        format!(
            "-3 dB is reached at {:.1} to {:.1} times 12 Hz, in the median {middle:.1}; for the trailing edge alone {:.1}.",
            least(ratios.iter().copied()),
            greatest(ratios.iter().copied()),
            median(trailing_edge.map(|(_, ratio)| *ratio))
        ),
    )
}

fn phase_shows_first(tables: &Comparison) -> Statement {
    let a_decade_below = bases(tables).map(|base| {
        let response = response(base, Order::Second, 0.1 * base.omega() / std::f64::consts::TAU);
        (phase_deg(response).abs(), (response.norm() - base.k()).abs())
    });
    let phase = least(a_decade_below.clone().map(|(phase, _)| phase));
    let magnitude = greatest(a_decade_below.map(|(_, magnitude)| magnitude));
    Statement::judged(
        ESTIMATION,
        "phase-shows-a-decade-lower",
        "Dynamics show in the phase about a decade lower in frequency than in the magnitude.",
        phase > LIMITS.phase_deg && magnitude < LIMITS.magnitude,
        format!(
            "At a tenth of ω the phase has turned by at least {phase:.1} deg, while the magnitude has moved by at most {magnitude:.4}."
        ),
    )
}

/// ∂ ln H / ∂ ln θ, whose real part is the relative change of magnitude and whose imaginary part is the change of phase [rad],
/// squared and summed over the data's band: (phase, magnitude). By central differences; 1e-5 leaves ten digits.
fn information(base: &Base, parameter: usize) -> (f64, f64) {
    const STEP: f64 = 1e-5;
    let value = base.values()[parameter];
    let (more, less) = (with(base, parameter, value * (1.0 + STEP)), with(base, parameter, value * (1.0 - STEP)));
    let [first, last] = BAND_HZ.map(|end| (end * POINTS_PER_HZ) as u32);
    (first..=last).fold((0.0, 0.0), |(phase, magnitude), index| {
        let frequency = f64::from(index) / POINTS_PER_HZ;
        let quotient = response(&more, Order::Third, frequency) / response(&less, Order::Third, frequency);
        let change = quotient.ln() / (2.0 * STEP);
        (phase + change.im * change.im, magnitude + change.re * change.re)
    })
}

fn information_in_phase(tables: &Comparison) -> Statement {
    let least_ratio = |parameter| {
        least(bases(tables).map(|base| {
            let (phase, magnitude) = information(base, parameter);
            phase / magnitude
        }))
    };
    let (omega, zeta) = (least_ratio(OMEGA), least_ratio(ZETA));
    Statement::judged(
        ESTIMATION,
        "more-information-in-phase",
        "The available data hold more information in phase than in magnitude.",
        omega > 1.0 && zeta > 1.0,
        format!(
            "With noise in proportion to the response, phase tells at least {omega:.1} times as much of ω and {zeta:.1} times as much of ζ \
             as magnitude (squared sensitivities, 0.5 to 12 Hz, least of the 17 sets). Of k it tells nothing."
        ),
    )
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

/// What "similar" is taken for: a change of at most so much.
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
    // Resonant peak of the second-order part over its gain at rest: 1 / (2 ζ √(1 - ζ²)) for ζ < 1/√2, else 1.
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
