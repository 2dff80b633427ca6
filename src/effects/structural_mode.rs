//! A structural mode between drive and surface.
//!
//! ```text
//! m̈ = ω_m² (y - m) - 2 damping ω_m ṁ,   ω_m = 2π frequency,   surface = y + gain (m - y)
//! ```
//!
//! With gain 1 the surface follows the mode alone; with a small gain the mode adds a resonance.

use super::effect::{Act, Effect, Family, Parameter};
use crate::{operator::{SegmentResponse, OutputOperator, StateVariable, Segment, Signal, EventCondition}, series::{Decay, RECIPROCAL, Series, TERMS}};

pub(super) static EFFECT: Effect = Effect {
    name: "structural_mode",
    family: Family::Lag,
    summary: "a structural resonance of the surface",
    parameters: &[
        Parameter { name: "frequency", unit: "Hz", neutral: 20.0, min: 1e-3, max: 1e4, nominal: 20.0, decides: false, meaning: "frequency of the mode" },
        Parameter { name: "damping", unit: "1", neutral: 0.02, min: 0.0, max: 10.0, nominal: 0.02, decides: false, meaning: "damping ratio of the mode" },
        Parameter { name: "gain", unit: "1", neutral: 0.0, min: -10.0, max: 10.0, nominal: 0.1, decides: true, meaning: "share of the mode in the deflection" },
    ],
    act: Act::Surface(&Mode),
    memory: 2,
    constraint: None,
    plausible: &[("damping", 0.12)], // above, it is a lag
    start_values: |observed| {
        // A geometric ladder with a ratio of about 1.23, fine enough for a search to converge from the nearest one.
        let dominant = observed.residual_frequency_hz.max(1.0);
        let ladder = [3.0, 3.7, 4.6, 5.6, 6.9, 8.5, 10.5, 13.0, 16.0, 20.0, 25.0];
        let ladder = ladder.map(|frequency_hz| vec![frequency_hz, 0.03, 0.1]);
        [vec![vec![dominant, 0.015, 0.1], vec![dominant, 0.06, 0.1]], ladder.to_vec()].concat()
    },
};

struct Mode;

fn pole(parameters: &[f64]) -> f64 {
    std::f64::consts::TAU * parameters[0]
}

impl OutputOperator for Mode {
    fn start(&self, _parameters: &[f64], memory: &mut [f64], rest: f64) -> f64 {
        (memory[0], memory[1]) = (rest, 0.0);
        rest
    }

    fn value(&self, parameters: &[f64], memory: &[f64], input: f64) -> f64 {
        input + parameters[2] * (memory[0] - input)
    }

    fn pole(&self, parameters: &[f64]) -> f64 {
        let damping = parameters[1];
        pole(parameters) * if damping > 1.0 { damping + (damping * damping - 1.0).sqrt() } else { 1.0 }
    }

    fn segment_response(&self, parameters: &[f64], memory: &[f64], input: &Series, segment: Segment) -> SegmentResponse {
        let gain = parameters[2];
        let mode = mode(parameters, memory, input, segment);
        input.scaled(1.0 - gain).plus(gain, &mode).into()
    }

    fn advance(
        &self,
        parameters: &[f64],
        memory: &mut [f64],
        input: &Series,
        _output: &Series,
        segment: Segment,
        tau: f64,
    ) {
        let mode = mode(parameters, memory, input, segment);
        memory[0] = mode.at(tau);
        memory[1] = mode.slope_at(tau) / segment.length;
    }

    fn state_variable(&self, index: usize) -> StateVariable {
        if index == 0 {
            StateVariable { name: "position", unit: "deg", nominal: 1.0, meaning: "m, deflection of the mode" }
        } else {
            StateVariable { name: "rate", unit: "deg/s", nominal: 100.0, meaning: "rate of the mode" }
        }
    }

    fn memory_derivatives(&self, parameters: &[f64], memory: &[f64], input: Signal, _condition: EventCondition, into: &mut [f64]) {
        let (w, damping) = (pole(parameters), parameters[1]);
        into[0] = memory[1];
        into[1] = w * w * (input.value - memory[0]) - 2.0 * damping * w * memory[1];
    }

    fn slope(&self, parameters: &[f64], memory: &[f64], input: Signal, _condition: EventCondition) -> f64 {
        input.slope + parameters[2] * (memory[1] - input.slope)
    }
}

/// m over a segment: (n+1)(n+2) m_{n+2} = w² (y_n - m_n) - 2ζ w (n+1) m_{n+1}, w = ω_m h.
fn mode(parameters: &[f64], memory: &[f64], input: &Series, segment: Segment) -> Series {
    let w = pole(parameters) * segment.length;
    let damping = 2.0 * parameters[1] * w;
    // The response to a decay is a decay: amplitude times w² / (k² - 2ζ w k + w²).
    let decays = input.decays.map(|Decay { amplitude, exponent: k }| {
        let amplitude = if amplitude == 0.0 { 0.0 } else { amplitude * w * w / (k * k - damping * k + w * w) };
        Decay { amplitude, exponent: k }
    });
    let mut terms = [0.0; TERMS];
    terms[0] = memory[0] - decays.iter().map(|decay| decay.amplitude).sum::<f64>();
    let decay_slope = decays.iter().map(|decay| decay.amplitude * decay.exponent).sum::<f64>();
    terms[1] = memory[1] * segment.length + decay_slope;
    for n in 0..segment.terms.min(TERMS) - 2 {
        let (one, two) = (RECIPROCAL[n + 1], RECIPROCAL[n + 2]);
        terms[n + 2] = two * (w * w * one * (input.terms[n] - terms[n]) - damping * terms[n + 1]);
    }
    Series { terms, length: segment.terms, decays }
}
