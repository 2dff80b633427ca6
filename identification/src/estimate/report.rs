//! The report's estimation: eq. (2) to (5), minimised by quasi-Newton steps from several starts.
//!
//! ```text
//! ε² = Σ_i c_m (mag_e - mag_a)² + c_p (phs_e - phs_a)²,   c_m = 1, c_p = 10
//! ```
//!
//! at the frequencies f_i of the measured response (Welch's method: [`crate::frequency::welch`]) from 0.5 to 12 Hz. The text does not say
//! whether phases are in degrees or radians. In degrees the phase outweighs the magnitude by 3e4 and the gradient by p moves it by some
//! units from 10 000, as in table 2 (9 995 to 9 999); in radians it would not move at all. Both are offered, degrees by default. A phase
//! error is the angle of H_e conj(H_a), which never wraps.
//!
//! The method gives no standard errors. Its known weakness is stated in the report: the result depends on the start, above all on that of
//! p, along a nearly flat valley.

use nalgebra::{Complex, SVector, Vector3, Vector4};

use super::{
    output_error::RecordResidual,
    quasi_newton::{End, Rules, minimise},
    result::{Estimate, Fit, Pole, RecordFit, StartResult, residual_of},
    search::SAME_MINIMUM_SHARE,
    settings::{DelayChoice, Method, OrderChoice, PhaseUnit, Settings},
};
use crate::{
    frequency::{self, DelayedModel, FrequencyPoint, FrequencyResponse},
    signal::record::{Record, rms},
};
use actuator_fmu::{
    error::{Error, Result},
    parameters::{Base, Model, Order, Provenance},
};

/// c_m
const MAGNITUDE_WEIGHT: f64 = 1.0;
/// c_p
const PHASE_WEIGHT: f64 = 10.0;

/// The report's stopping rules.
const RULES: Rules = Rules { least_cost: 1e-4, least_change: 1e-4 };

/// Band in which the report judged a fit [Hz].
const JUDGED_HZ: [f64; 2] = [2.0, 10.0];
/// Its limit of the magnitude.
const ACCEPTED_MAGNITUDE: f64 = 0.1;
/// Its limit of the phase [deg].
const ACCEPTED_PHASE_DEG: f64 = 3.0;

/// The pole at all starts [1/s]: tables 1 and 2 leave little doubt that it was that of the report.
const START_P: f64 = 1e4;
/// Frequencies ω of the starts [rad/s], around those of the tables.
const START_OMEGA: [f64; 4] = [90.0, 130.0, 180.0, 250.0];
/// Damping ratios ζ of the starts.
const START_ZETA: [f64; 4] = [0.3, 0.5, 0.75, 1.1];
/// Two more starts: half and twice the pole, with ω and ζ of an actuator in the middle of the tables.
const OTHER_STARTS: [[f64; 3]; 2] = [[0.5 * START_P, 165.0, 0.6], [2.0 * START_P, 165.0, 0.6]];

/// Cost of a model, and its parts.
struct Cost<'a> {
    points: Vec<&'a FrequencyPoint>,
    phase_unit: PhaseUnit,
    delay_s: f64,
}

impl Cost<'_> {
    /// ε² and its gradient with respect to (k, p, ω, ζ); p is omitted for the second order.
    fn evaluate(&self, order: Order, values: [f64; 4]) -> (f64, Vector4<f64>) {
        let Ok(base) = Base::from_values(values) else { return (f64::INFINITY, Vector4::zeros()) };
        let unit = match self.phase_unit {
            PhaseUnit::Degree => 180.0 / std::f64::consts::PI,
            PhaseUnit::Radian => 1.0,
        };
        let [k, p, omega, zeta] = values;
        let (mut cost, mut gradient) = (0.0, Vector4::zeros());
        for point in &self.points {
            let s = Complex::new(0.0, std::f64::consts::TAU * point.frequency_hz);
            let model = DelayedModel { base, order, delay_s: self.delay_s }.response(point.frequency_hz);
            let magnitude = point.response.norm() - model.norm();
            let phase = unit * (point.response * model.conj()).arg();
            cost += MAGNITUDE_WEIGHT * magnitude * magnitude + PHASE_WEIGHT * phase * phase;
            // ∂ ln H with respect to each parameter: the real part changes ln |H|, the imaginary part the phase.
            let quadratic = s * s + s * (2.0 * zeta * omega) + omega * omega;
            let pole = if order == Order::Third { s / ((s + p) * p) } else { Complex::default() };
            let logarithmic = [
                Complex::from(1.0 / k),
                pole,
                Complex::from(2.0 / omega) - (s * (2.0 * zeta) + 2.0 * omega) / quadratic,
                -s * (2.0 * omega) / quadratic,
            ];
            for (gradient, by) in gradient.iter_mut().zip(logarithmic) {
                *gradient -= 2.0 * MAGNITUDE_WEIGHT * magnitude * model.norm() * by.re;
                *gradient -= 2.0 * PHASE_WEIGHT * phase * unit * by.im;
            }
        }
        (cost, gradient)
    }

    fn search(&self, order: Order, start: [f64; 4]) -> End<4> {
        match order {
            Order::Third => {
                minimise(|x: &Vector4<f64>| self.evaluate(order, [x[0], x[1], x[2], x[3]]), start.into(), RULES)
            }
            Order::Second => {
                let [k, p, omega, zeta] = start;
                let evaluate = |x: &Vector3<f64>| {
                    let (cost, gradient) = self.evaluate(order, [x[0], p, x[1], x[2]]);
                    (cost, Vector3::new(gradient[0], gradient[2], gradient[3]))
                };
                let end = minimise(evaluate, SVector::from([k, omega, zeta]), RULES);
                End {
                    x: Vector4::new(end.x[0], p, end.x[1], end.x[2]),
                    cost: end.cost,
                    iterations: end.iterations,
                    stop: end.stop,
                }
            }
        }
    }
}

/// Starts as chosen by an engineer: around the tables, all combinations of four ω and four ζ, and two other poles.
fn starts(gain: f64) -> Vec<[f64; 4]> {
    let combinations =
        START_OMEGA.into_iter().flat_map(|omega| START_ZETA.into_iter().map(move |zeta| [gain, START_P, omega, zeta]));
    combinations.chain(OTHER_STARTS.map(|[p, omega, zeta]| [gain, p, omega, zeta])).collect()
}

/// Fits records.
pub fn fit(records: &[Record], settings: &Settings) -> Result<Fit> {
    let DelayChoice::Declared(delay_s) = settings.delay else {
        return Err(Error::new(
            "--delay free",
            "with --method report",
            "a number of seconds, which the report has as 0",
        )
        .remedy("use --method likelihood"));
    };
    let order = if settings.order == OrderChoice::Second { Order::Second } else { Order::Third };
    let measured = frequency::estimate(records, frequency::Method::Report)?;
    let points: Vec<&FrequencyPoint> = measured.inside(settings.band_hz).collect();
    if points.len() < 4 {
        let found = format!("{} points in {:?} Hz", points.len(), settings.band_hz);
        return Err(Error::new("frequency response", found, "4 or more").remedy("use records with motion in this band"));
    }
    // At low frequency the response is k.
    let gain = points[0].response.norm().copysign(points[0].response.re);
    let cost = Cost { points, phase_unit: settings.phase_unit, delay_s };
    let starts = settings.starts.clone().unwrap_or_else(|| starts(gain));
    let ends: Vec<End<4>> = starts.iter().map(|start| cost.search(order, *start)).collect();
    let Some(best) = ends.iter().filter(|end| end.cost.is_finite()).min_by(|a, b| a.cost.total_cmp(&b.cost)) else {
        return Err(Error::new("search", "no start with a finite cost", "one"));
    };
    finish(records, settings, order, &measured, &cost, &starts, &ends, best)
}

#[allow(clippy::too_many_arguments)] // all results of a search
fn finish(
    records: &[Record],
    settings: &Settings,
    order: Order,
    measured: &FrequencyResponse,
    cost: &Cost<'_>,
    starts: &[[f64; 4]],
    ends: &[End<4>],
    best: &End<4>,
) -> Result<Fit> {
    let values: [f64; 4] = best.x.into();
    let base = Base::from_values(values)?;
    let near =
        |end: &End<4>| [0, 2, 3].iter().all(|place| (end.x[*place] / best.x[*place] - 1.0).abs() < SAME_MINIMUM_SHARE);
    let results: Vec<StartResult> = starts
        .iter()
        .zip(ends)
        .map(|(start, end)| StartResult {
            start: *start,
            end: end.x.into(),
            cost: end.cost,
            iterations: end.iterations,
            ending: end.stop.sentence().to_owned(),
            converged: end.stop.is_convergence(),
            at_best: near(end),
        })
        .collect();
    let delayed = DelayedModel { base, order, delay_s: cost.delay_s };
    let residuals: Vec<RecordResidual> = records.iter().map(|record| residual_of(&delayed, record)).collect();
    let each: Vec<RecordFit> = records
        .iter()
        .zip(&residuals)
        .map(|(record, record_residual)| RecordFit::new(record, record_residual))
        .collect();
    let residual: Vec<f64> = residuals.into_iter().flat_map(|record_residual| record_residual.residual).collect();
    let unit = match settings.phase_unit {
        PhaseUnit::Degree => "degrees",
        PhaseUnit::Radian => "radians",
    };
    let mut model = Model::new(base, order);
    model.provenance = Provenance {
        records: each.iter().map(|record| record.source.clone()).collect(),
        hashes: each.iter().map(|record| record.sha256.clone()).collect(),
        method: Some(format!(
            "weighted errors of magnitude and phase in {unit}, NASA/TM-1998-208452 eq. (4); p is not identifiable"
        )),
        date: None,
    };
    let mut notes = measured.notes.clone();
    notes.push(judgement(cost, &delayed, best.cost));
    notes.push("the method provides no standard errors; --method likelihood does".to_owned());
    let estimate = |index: usize| {
        let parameter = Base::PARAMETERS[index];
        Estimate {
            name: parameter.name,
            unit: if index == 0 { records[0].unit().of_gain() } else { parameter.unit },
            value: values[index],
            std_error: None,
            interval_95: None,
            at_bound: false,
        }
    };
    let not_identifiable = match order {
        Order::Third => vec![format!(
            "p: {:.0} 1/s is where the search stopped, not an estimate; --method likelihood gives a bound",
            base.p()
        )],
        Order::Second => Vec::new(),
    };
    let innovation_rms = rms(&residual);
    Ok(Fit {
        model,
        method: Method::Report,
        estimates: [0, 2, 3].map(estimate).to_vec(),
        correlations: Vec::new(),
        covariance: None,
        pole: Pole::Untold,
        delay_s: cost.delay_s,
        ending: best.stop.sentence().to_owned(),
        converged: best.stop.is_convergence(),
        at_bound: Vec::new(),
        not_identifiable,
        starts: results,
        unit: records[0].unit().name(),
        residual_rms: innovation_rms,
        innovation_rms,
        noise_order: None,
        #[allow(clippy::cast_precision_loss)] // counts of samples
        effective_samples: residual.len() as f64,
        records: each,
        evidence: Vec::new(),
        notes,
    })
}

/// The report's criteria applied to the fit.
fn judgement(cost: &Cost<'_>, model: &DelayedModel, least: f64) -> String {
    let (mut magnitude, mut phase) = (0.0_f64, 0.0_f64);
    for point in cost.points.iter().filter(|point| (JUDGED_HZ[0]..=JUDGED_HZ[1]).contains(&point.frequency_hz)) {
        let modelled = model.response(point.frequency_hz);
        magnitude = magnitude.max((point.response.norm() - modelled.norm()).abs());
        phase = phase.max((point.response * modelled.conj()).arg().to_degrees().abs());
    }
    let verdict =
        if magnitude < ACCEPTED_MAGNITUDE && phase < ACCEPTED_PHASE_DEG { "acceptable" } else { "not acceptable" };
    format!(
        "weighted error {least:.3e} over {} frequencies; within {:.0} to {:.0} Hz the model is off by up to {magnitude:.3} and \
         {phase:.2} deg, {verdict} by the report's limits of {ACCEPTED_MAGNITUDE} and {ACCEPTED_PHASE_DEG} deg",
        cost.points.len(),
        JUDGED_HZ[0],
        JUDGED_HZ[1]
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use actuator_fmu::parameters::table;

    #[test]
    fn the_gradient_is_that_of_the_cost() {
        let truth = table()[0].base;
        let points: Vec<FrequencyPoint> = (1_u8..=24)
            .map(|half| FrequencyPoint {
                frequency_hz: 0.5 * f64::from(half),
                response: frequency::response(&truth, Order::Third, 0.5 * f64::from(half)),
                coherence: 1.0,
                magnitude_std_error: 0.0,
                phase_std_error_deg: 0.0,
                excited: true,
            })
            .collect();
        for phase_unit in [PhaseUnit::Degree, PhaseUnit::Radian] {
            let cost = Cost { points: points.iter().collect(), phase_unit, delay_s: 0.0 };
            let here = [1.1, 300.0, 140.0, 0.7];
            let (_, gradient) = cost.evaluate(Order::Third, here);
            for place in 0..4 {
                let step = 1e-5 * here[place];
                let at = |side: f64| {
                    let mut moved = here;
                    moved[place] += side * step;
                    cost.evaluate(Order::Third, moved).0
                };
                let numerical = (at(1.0) - at(-1.0)) / (2.0 * step);
                // Central differences: 1e-10 of the cost's curvature, and 1e-16 of the cost itself over the step.
                let rounding = 1e-15 * cost.evaluate(Order::Third, here).0 / step;
                let error = (gradient[place] - numerical).abs();
                assert!(error < 1e-6 * gradient[place].abs() + rounding, "{place}: {} {numerical}", gradient[place]);
            }
        }
    }
}
