//! Free play between drive and surface: worn bearings and linkages.
//!
//! ```text
//!        y │    ╱╱
//!          │  ╱ ╱
//!   ───────┼╱─╱──── δ       total width: gap
//!        ╱ ╱
//! ```
//!
//! Play operator: y moves only when pushed, |δ - y| <= gap / 2 (Krasnosel'skii and Pokrovskii 1989). Describing function with
//! g = gap / (2A): gain and lag that depend on the amplitude alone (Gelb and Vander Velde 1968, section 2.3).

use super::{Act, Effect, Family, Parameter, UNLIMITED};
use crate::{operator::{Answer, OutputOperator, Remembered, Segment, Signal, Watch}, series::{Range, Series}};

pub(super) static EFFECT: Effect = Effect {
    name: "backlash",
    family: Family::Play,
    summary: "free play between drive and surface",
    parameters: &[Parameter { name: "gap", unit: "deg", neutral: 0.0, min: 0.0, max: UNLIMITED, nominal: 0.1, decides: true, meaning: "total free play" }],
    act: Act::Surface(&Backlash),
    memory: 1,
    constraint: None,
    plausible: &[],
    guess: |observed| [2.0, 4.0, 8.0].map(|share| vec![share * observed.residual_rms]).to_vec(),
};

struct Backlash;

/// Share of the positions below which a distance from the contact is rounding.
const CONTACT: f64 = 1e-14;

impl OutputOperator for Backlash {
    fn start(&self, _parameters: &[f64], memory: &mut [f64], rest: f64) -> f64 {
        memory[0] = rest;
        rest
    }

    fn value(&self, parameters: &[f64], memory: &[f64], input: f64) -> f64 {
        let half = 0.5 * parameters[0];
        memory[0].clamp(input - half, input + half)
    }

    fn answer(&self, parameters: &[f64], memory: &[f64], input: &Series, segment: Segment) -> Answer {
        let half = 0.5 * parameters[0];
        let position = input.start();
        let behind = position - self.value(parameters, memory, position);
        let start = input.slope_at_start();
        // Rates are compared over the segment, where they have the size of positions. Contact is taken for contact a little
        // inside the tolerance with which it is waited for.
        let contact = half - 0.5 * segment.tolerance;
        let (push, onwards) = if start > 0.0 && behind >= contact {
            (half, Range::above(0.0))
        } else if start < 0.0 && behind <= -contact {
            (-half, Range::below(0.0))
        } else {
            let surface = position - behind;
            let free = Range { low: surface - half, high: surface + half };
            let touches = input.leaves(free, segment.tolerance);
            return Answer { output: Series::polynomial(&[surface]), until: touches.map(|(tau, _)| tau) };
        };
        let turns = input.derivative_leaves(onwards, segment.tolerance);
        Answer { output: input.shifted(-push), until: turns.map(|(tau, _)| tau) }
    }

    fn advance(
        &self,
        _parameters: &[f64],
        memory: &mut [f64],
        _input: &Series,
        output: &Series,
        _segment: Segment,
        tau: f64,
    ) {
        memory[0] = output.at(tau);
    }

    fn remembered(&self, _index: usize) -> Remembered {
        Remembered { name: "surface", unit: "deg", nominal: 1.0, meaning: "position of the surface behind the play" }
    }

    /// Pushed, until the drive turns; else free, until the drive has crossed the play.
    fn watch(&self, parameters: &[f64], memory: &mut [f64], input: Signal) -> Watch {
        let half = 0.5 * parameters[0];
        let surface = self.value(parameters, memory, input.value);
        memory[0] = surface;
        let behind = input.value - surface;
        // A solver stops where the contact is, but for some roundings.
        let contact = half - CONTACT * (half + input.value.abs());
        if behind >= contact && input.slope > 0.0 {
            Watch::Slope(Range::above(0.0))
        } else if behind <= -contact && input.slope < 0.0 {
            Watch::Slope(Range::below(0.0))
        } else {
            Watch::Input(Range { low: surface - half, high: surface + half })
        }
    }

    fn rates(&self, parameters: &[f64], memory: &[f64], input: Signal, watch: Watch, into: &mut [f64]) {
        into[0] = self.slope(parameters, memory, input, watch);
    }

    fn slope(&self, _parameters: &[f64], _memory: &[f64], input: Signal, watch: Watch) -> f64 {
        if matches!(watch, Watch::Slope(_)) { input.slope } else { 0.0 }
    }
}
