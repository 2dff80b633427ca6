//! Free play between drive and surface: worn bearings and linkages.
//!
//! ```text
//!        y │    ╱╱
//!          │  ╱ ╱
//!   ───────┼╱─╱──── δ       total width: gap
//!        ╱ ╱
//! ```
//!
//! Play operator: y moves only in contact, |δ - y| <= gap / 2 (Krasnosel'skii and Pokrovskii 1989). Describing function with
//! g = gap / (2A): gain and lag that depend on the amplitude alone (Gelb and Vander Velde 1968, section 2.3).

use super::effect::{Act, Effect, Family, Parameter, UNLIMITED};
use crate::{operator::{SegmentResponse, OutputOperator, StateVariable, Segment, Signal, EventCondition}, series::{Range, Series}};

pub(super) static EFFECT: Effect = Effect {
    name: "backlash",
    family: Family::Play,
    summary: "free play between drive and surface",
    parameters: &[Parameter { name: "gap", unit: "deg", neutral: 0.0, min: 0.0, max: UNLIMITED, nominal: 0.1, decides: true, meaning: "total free play" }],
    act: Act::Surface(&Backlash),
    memory: 1,
    constraint: None,
    plausible: &[],
    start_values: |observed| [2.0, 4.0, 8.0].map(|share| vec![share * observed.residual_rms]).to_vec(),
};

struct Backlash;

/// Relative tolerance of a contact, in positions: about 50 roundings.
const CONTACT_TOLERANCE: f64 = 1e-14;

impl OutputOperator for Backlash {
    fn start(&self, _parameters: &[f64], memory: &mut [f64], rest: f64) -> f64 {
        memory[0] = rest;
        rest
    }

    fn value(&self, parameters: &[f64], memory: &[f64], input: f64) -> f64 {
        let half = 0.5 * parameters[0];
        Range { low: input - half, high: input + half }.nearest(memory[0])
    }

    fn segment_response(&self, parameters: &[f64], memory: &[f64], input: &Series, segment: Segment) -> SegmentResponse {
        let half = 0.5 * parameters[0];
        let position = input.start();
        let behind = position - self.value(parameters, memory, position);
        let start = input.slope_at_start();
        // Rates are differences of positions over the segment. The tolerance of a contact is half of that of its event time.
        let contact = half - 0.5 * segment.tolerance;
        let (contact_offset, rates) = if start > 0.0 && behind >= contact {
            (half, Range::above(0.0))
        } else if start < 0.0 && behind <= -contact {
            (-half, Range::below(0.0))
        } else {
            let surface = position - behind;
            let free = Range { low: surface - half, high: surface + half };
            let contact = input.leaves(free, segment.tolerance, segment.until);
            return SegmentResponse { output: Series::polynomial(&[surface]), valid_until: contact.map(|(tau, _)| tau) };
        };
        let reversal = input.derivative_leaves(rates, segment.tolerance, segment.until);
        SegmentResponse { output: input.shifted(-contact_offset), valid_until: reversal.map(|(tau, _)| tau) }
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

    fn is_rate_independent(&self) -> bool {
        true
    }

    fn follow(&self, parameters: &[f64], memory: &mut [f64], input: f64) {
        memory[0] = self.value(parameters, memory, input);
    }

    fn state_variable(&self, _index: usize) -> StateVariable {
        StateVariable { name: "surface", unit: "deg", nominal: 1.0, meaning: "position of the surface behind the play" }
    }

    fn has_events(&self) -> bool {
        true
    }

    /// In contact until the drive reverses, otherwise free until the play is crossed.
    fn event_condition(&self, parameters: &[f64], memory: &mut [f64], input: Signal) -> EventCondition {
        let half = 0.5 * parameters[0];
        let surface = self.value(parameters, memory, input.value);
        memory[0] = surface;
        let behind = input.value - surface;
        // A solver stops within some roundings of the contact.
        let contact = half - CONTACT_TOLERANCE * (half + input.value.abs());
        if behind >= contact && input.slope > 0.0 {
            EventCondition::Slope(Range::above(0.0))
        } else if behind <= -contact && input.slope < 0.0 {
            EventCondition::Slope(Range::below(0.0))
        } else {
            EventCondition::Input(Range { low: surface - half, high: surface + half })
        }
    }

    fn memory_derivatives(&self, parameters: &[f64], memory: &[f64], input: Signal, condition: EventCondition, into: &mut [f64]) {
        into[0] = self.slope(parameters, memory, input, condition);
    }

    fn slope(&self, _parameters: &[f64], _memory: &[f64], input: Signal, condition: EventCondition) -> f64 {
        if matches!(condition, EventCondition::Slope(_)) { input.slope } else { 0.0 }
    }
}
