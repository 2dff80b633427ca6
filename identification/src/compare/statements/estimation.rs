//! Actuator Model Structure, Parameter Estimation.

use super::{
    order_statistics::{greatest, least, median},
    parameter_values::{OMEGA, ZETA, values, with},
    section::{ESTIMATION, STRUCTURE},
};
use crate::{
    compare::{
        comparison::Comparison,
        difference::{LIMITS, POINTS_PER_HZ},
        statement::Statement,
    },
    frequency::{BAND_HZ, phase_deg, response},
};
use actuator_fmu::parameters::{Base, Order, Surface};

pub(super) const NO_MEASUREMENTS: &str = "The report's measured responses exist as pictures only, not as data.";

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

/// Frequency at which the magnitude is 3 dB below the static gain [Hz].
pub(super) fn bandwidth_hz(base: &Base) -> f64 {
    let half_power = base.k().abs() * std::f64::consts::FRAC_1_SQRT_2;
    let mut index = 1_u32;
    loop {
        let frequency = f64::from(index) / POINTS_PER_HZ;
        // No set of the tables reaches a kilohertz.
        if frequency > 1e3 || response(base, Order::Third, frequency).norm() < half_power {
            return frequency;
        }
        index += 1;
    }
}

pub(super) fn bases(tables: &Comparison) -> impl Iterator<Item = &Base> + Clone {
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

/// Squared ∂ ln H / ∂ ln θ summed over the data's band: (phase, magnitude). The real part is the relative change of magnitude, the
/// imaginary part the change of phase [rad]. Central differences; a step of 1e-5 leaves ten digits.
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
