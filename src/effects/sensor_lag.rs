//! First-order lag of the measurement: a filter, a potentiometer with its wiring.
//!
//! ```text
//! time ṡ = y - s
//! ```

use super::effect::{Act, Effect, Family, Parameter};
use crate::{operator::{SegmentResponse, FAST_POLE_RATIO, OutputOperator, StateVariable, Segment, Signal, EventCondition}, series::{Decay, RECIPROCAL, Series, TERMS}};

pub(super) static EFFECT: Effect = Effect {
    name: "sensor_lag",
    family: Family::Lag,
    summary: "the measurement lags",
    parameters: &[Parameter { name: "time", unit: "s", neutral: 0.0, min: 0.0, max: 100.0, nominal: 0.005, decides: true, meaning: "time constant of the measurement" }],
    act: Act::Sensor(&Lag),
    memory: 1,
    constraint: None,
    plausible: &[],
    start_values: |observed| [0.5, 2.0, 5.0].map(|share| vec![share * observed.sample_time_s]).to_vec(),
};

struct Lag;

/// Minimum relative difference of the rates of two decays: closer ones are separated by it. The relative error is of the same size, in a
/// response that is itself small.
const MIN_SEPARATION: f64 = 1e-9;

impl OutputOperator for Lag {
    fn start(&self, _parameters: &[f64], memory: &mut [f64], rest: f64) -> f64 {
        memory[0] = rest;
        rest
    }

    fn value(&self, _parameters: &[f64], memory: &[f64], _input: f64) -> f64 {
        memory[0]
    }

    fn fast_pole(&self, parameters: &[f64]) -> f64 {
        1.0 / parameters[0]
    }

    fn segment_response(&self, parameters: &[f64], memory: &[f64], input: &Series, segment: Segment) -> SegmentResponse {
        let k = segment.length / parameters[0];
        let mut decays = input.decays.map(|Decay { amplitude, exponent }| {
            let difference = k - exponent;
            let difference = if difference.abs() < MIN_SEPARATION * k { MIN_SEPARATION * k } else { difference };
            Decay { amplitude: if amplitude == 0.0 { 0.0 } else { amplitude * k / difference }, exponent }
        });
        let free = memory[0] - decays.iter().map(|decay| decay.amplitude).sum::<f64>();
        let mut terms = [0.0; TERMS];
        if 1.0 / parameters[0] > FAST_POLE_RATIO * segment.largest_pole {
            // Steady-state response of the lag, from the highest order down: s = y - ṡ / k; and its own decay from its present value.
            let mut above = 0.0;
            let mut n = input.length as f64;
            for index in (0..input.length).rev() {
                above = input.terms[index] - n / k * above;
                terms[index] = above;
                n -= 1.0;
            }
            decays[1] = Decay { amplitude: free - terms[0], exponent: k };
        } else {
            terms[0] = free;
            for n in 0..segment.terms - 1 {
                terms[n + 1] = k * RECIPROCAL[n + 1] * (input.terms[n] - terms[n]);
            }
        }
        Series { terms, length: segment.terms.max(input.length), decays }.into()
    }

    fn advance(&self, _parameters: &[f64], memory: &mut [f64], _input: &Series, output: &Series, _segment: Segment, tau: f64) {
        memory[0] = output.at(tau);
    }

    fn state_variable(&self, _index: usize) -> StateVariable {
        StateVariable { name: "reading", unit: "deg", nominal: 1.0, meaning: "what the sensor has settled to" }
    }

    fn memory_derivatives(&self, parameters: &[f64], memory: &[f64], input: Signal, condition: EventCondition, into: &mut [f64]) {
        into[0] = self.slope(parameters, memory, input, condition);
    }

    fn slope(&self, parameters: &[f64], memory: &[f64], input: Signal, _condition: EventCondition) -> f64 {
        (input.value - memory[0]) / parameters[0]
    }
}
