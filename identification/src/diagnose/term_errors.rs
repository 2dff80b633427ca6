//! Standard errors of measurement terms, whose factors are free in every record and solved for exactly. A parameter of the model is a sum s of
//! factors b of all records, or near the solution approximately one. With the whitened columns C of the terms and J of the sensitivities to θ in each
//! record r:
//!
//! ```text
//! s = Σ_r w_rᵀ b_r,    b_r = (CᵀC)⁻¹ Cᵀ (y - δ(θ))
//! var s = Σ_r w_rᵀ (CᵀC)⁻¹ w_r + gᵀ cov(θ) g,    g = Σ_r Jᵀ C (CᵀC)⁻¹ w_r
//! ```

use nalgebra::{DMatrix, DVector};

use super::{
    fitted::Fitted, hypothesis::MeasurementTerm, jacobian::SimulationCache, output_error::OutputError, trace::Trace,
};
use crate::linear_least_squares::dot;

/// A parameter of a measurement term, and the weights of its factors in each record.
struct Sum {
    effect: &'static str,
    parameter: &'static str,
    /// Of the two factors of the term.
    weights: Vec<[f64; 2]>,
    /// Place of the first factor.
    place: usize,
}

/// Standard error of a parameter of a measurement term.
pub struct TermError {
    /// The effect.
    pub effect: &'static str,
    /// Its parameter.
    pub parameter: &'static str,
    /// Standard error [its unit].
    pub std_error: f64,
}

impl Fitted {
    /// Standard errors of the parameters that [`Fitted`] derives from measurement terms, without those that the records do not determine.
    /// `covariance` is that of θ.
    pub fn term_errors(&self, covariance: Option<&DMatrix<f64>>, traces: &[Trace<'_>]) -> Vec<TermError> {
        let sums = self.sums(traces);
        if sums.is_empty() {
            return Vec::new();
        }
        let cache = SimulationCache::default();
        let problem = OutputError::new(&self.space, traces, &self.noise, &cache);
        let Some(simulated) = problem.simulated(&self.x) else { return Vec::new() };
        let jacobian = problem.jacobian(&self.x, &simulated);
        let columns: Vec<Columns> = (0..traces.len())
            .map(|record| Columns {
                terms: problem.whitened_columns(&self.x, record),
                sensitivities: (0..self.x.len())
                    .map(|place| problem.whitened_sensitivity(&jacobian, record, place))
                    .collect(),
            })
            .collect();
        let of = |sum: &Sum| {
            let variance = variance(sum, &columns, covariance)?;
            let std_error = variance.sqrt();
            std_error.is_finite().then_some(TermError { effect: sum.effect, parameter: sum.parameter, std_error })
        };
        sums.iter().filter_map(of).collect()
    }

    /// The parameters of the model that are such sums.
    #[allow(clippy::cast_precision_loss)] // counts of samples
    fn sums(&self, traces: &[Trace<'_>]) -> Vec<Sum> {
        let counts: Vec<f64> = traces.iter().map(|trace| trace.evaluated_samples() as f64).collect();
        let all: f64 = counts.iter().sum();
        let shares = || counts.iter().map(|count| count / all);
        let mut sums = Vec::new();
        for (index, term) in self.space.terms().enumerate() {
            let place = 2 * index;
            match term {
                MeasurementTerm::Level => {}
                MeasurementTerm::Bias => {
                    let effect = "sensor_bias";
                    let offset = shares().map(|share| [share, 0.0]).collect();
                    sums.push(Sum { effect, parameter: "offset", weights: offset, place });
                    let drift = shares().map(|share| [0.0, share]).collect();
                    sums.push(Sum { effect, parameter: "drift", weights: drift, place });
                }
                // The root mean square of the amplitudes of the records, and the phase in the first.
                MeasurementTerm::Chatter => {
                    let effect = "chatter";
                    let parts = self.factors.iter().map(|factors| [factors[place], factors[place + 1]]);
                    let square: f64 = parts
                        .clone()
                        .zip(shares())
                        .map(|([one, other], share)| share * (one * one + other * other))
                        .sum();
                    let amplitude = square.sqrt();
                    let weights = parts.clone().zip(shares());
                    let weights = weights.map(|(both, share)| both.map(|one| share * one / amplitude)).collect();
                    sums.push(Sum { effect, parameter: "amplitude", weights, place });
                    let mut weights: Vec<[f64; 2]> = parts
                        .map(|[sine, cosine]| {
                            let square = sine * sine + cosine * cosine;
                            [-cosine / square, sine / square]
                        })
                        .collect();
                    weights.iter_mut().skip(1).for_each(|weights| *weights = [0.0; 2]);
                    sums.push(Sum { effect, parameter: "phase", weights, place });
                }
            }
        }
        sums
    }
}

/// Whitened columns of a record.
struct Columns {
    terms: Vec<Vec<f64>>,
    sensitivities: Vec<Vec<f64>>,
}

fn variance(sum: &Sum, columns: &[Columns], covariance: Option<&DMatrix<f64>>) -> Option<f64> {
    let mut variance = 0.0;
    let mut gradient = DVector::zeros(covariance.map_or(0, DMatrix::nrows));
    for (Columns { terms, sensitivities }, weights) in columns.iter().zip(&sum.weights) {
        let normal = DMatrix::from_fn(terms.len(), terms.len(), |row, column| dot(&terms[row], &terms[column]));
        let mut of_factors = DVector::zeros(terms.len());
        of_factors.fixed_rows_mut::<2>(sum.place).copy_from_slice(weights);
        let dual = normal.cholesky()?.solve(&of_factors);
        variance += dual.dot(&of_factors);
        for (place, sensitivity) in sensitivities.iter().enumerate().take(gradient.len()) {
            let each = terms.iter().zip(dual.iter()).map(|(term, factor)| factor * dot(term, sensitivity));
            gradient[place] += each.sum::<f64>();
        }
    }
    // Nothing depends on a parameter without a finite variance.
    let of_motion = covariance.map_or(0.0, |covariance| {
        let finite = covariance.map(|value| if value.is_finite() { value } else { 0.0 });
        gradient.dot(&(finite * &gradient))
    });
    Some(variance + of_motion)
}

#[cfg(test)]
mod tests {
    use crate::diagnose::{
        fitted::Fitted,
        hypothesis::Hypothesis,
        space::{ParameterIndex, Space},
        three_records::{measured_as, three_records},
        trace::Trace,
    };
    use actuator_fmu::{
        effects::Effects,
        parameters::{Model, table},
    };
    use std::f64::consts::{PI, TAU};

    /// Three records of one length in white noise σ, with a bias and an oscillation of amplitude A and unknown frequency. In closed form the error of
    /// an offset beside a drift is 2σ/√N, of the drift σ√12/(T√N), of an amplitude σ√2/√N, of the frequency σ√6/(πTA√N), and of the phase at the
    /// start of the first record, whose noise is σ₁, √(6σ₁² + 6σ²)/(A√N).
    #[test]
    fn errors_of_a_bias_and_of_an_oscillation_are_those_of_lines_and_sines_in_white_noise() {
        let given = Model::from_set(&table()[0]);
        let records: Vec<_> = three_records(&given, 3.0)
            .iter()
            .map(|record| measured_as(record, |t, position| position + 0.2 + 0.01 * t + 0.1 * (TAU * 7.3 * t).sin()))
            .collect();
        let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &given.base)).collect();
        let of = |base_free: bool| {
            let hypothesis = Hypothesis { effects: vec!["sensor_bias", "chatter"], base_free, ..Hypothesis::default() };
            let fitted = Fitted::at_start(Space::new(hypothesis, &given, &given.base, 7.3), &traces).unwrap();
            let errors = fitted.term_errors(fitted.covariance(&traces).as_ref(), &traces);
            let names = ["offset", "drift", "amplitude", "phase"];
            assert_eq!(errors.iter().map(|error| error.parameter).collect::<Vec<_>>(), names);
            (fitted, errors.iter().map(|error| error.std_error).collect::<Vec<_>>())
        };
        let (fitted, errors) = of(false);
        let samples: f64 =
            traces.iter().map(|trace| f64::from(u32::try_from(trace.evaluated_samples()).unwrap())).sum();
        let duration = records[0].duration_s();
        let each = fitted.rms() / samples.sqrt();
        // All records determine the frequency, quiet ones more: here 1/σ² is the mean of theirs.
        let squares = fitted.noise.iter().map(|noise| (noise.innovation_rms / fitted.rms()).powi(2));
        let of_frequency = 3.0 / squares.clone().map(f64::recip).sum::<f64>();
        let phase = (6.0 * (squares.clone().next().unwrap() + of_frequency)).sqrt() / 0.1;
        let by_hand = [2.0, 12.0_f64.sqrt() / duration, 2.0_f64.sqrt(), phase].map(|factor| factor * each);
        for (error, by_hand) in errors.iter().zip(by_hand) {
            assert!((error / by_hand - 1.0).abs() < 0.15, "{errors:?} {by_hand:?}");
        }
        let frequency = ParameterIndex::Effect(Effects::index("chatter", "frequency").unwrap());
        let frequency = fitted.std_error(fitted.covariance(&traces).as_ref(), frequency).unwrap();
        let by_hand = (6.0 * of_frequency).sqrt() / (PI * duration * 0.1) * each;
        assert!((frequency / by_hand - 1.0).abs() < 0.15, "{frequency} {by_hand}");
        // With a free base all errors are larger, but little.
        for (free, fixed) in of(true).1.iter().zip(&errors) {
            assert!(*free > *fixed && *free < 1.5 * fixed, "{free} {fixed}");
        }
    }
}
