//! The parameters of a hypothesis that are searched, with their scales and ranges.
//!
//! The base is free in k, ω and ζ; p stays as given, since a pole near the excitation is a lag, which is an effect; a given slow pole may become
//! faster.

use super::{
    coordinate::{Coordinate, Scale, Target},
    hypothesis::{Hypothesis, MeasurementTerm},
    plausibility::most_plausible,
};
use actuator_fmu::{
    effects::Effects,
    parameters::{Base, Model, Order},
};

/// Factor up and down from its start value within which a parameter is searched; start values are closer to each other.
const SEARCH_FACTOR: f64 = 150.0;

/// The same for frequencies, whose minima lie close together.
const FREQUENCY_SEARCH_FACTOR: f64 = 3.0;

/// A pole below this multiple of ω is slow: its lag is visible. A fit without a missing effect may have put it there: the search may reduce this lag
/// but not add to it, since additional lag is an effect.
const SLOW_POLE_RATIO: f64 = 20.0;
/// A pole at this multiple of ω has no visible lag.
const FAST_POLE_RATIO: f64 = 1000.0;

/// Factors within which k, ω and ζ of a wide base are searched: a gain further off is a unit or another channel.
const WIDE_FACTORS: [f64; 3] = [3.0, 15.0, 10.0];
/// Damping ratio down to which a wide base is searched from any given one: with less it would be a structural mode.
const ORDINARY_DAMPING_RATIO: f64 = 0.25;
/// Factor within which a pole that is free beside a given base is searched, but at least from the second number, as a multiple of ω, to where its lag
/// is not visible: a fit without a missing effect may have put it anywhere.
const POLE_FACTOR: f64 = 2.5;
const SLOWEST_FREE_POLE_RATIO: f64 = 1.5;
/// Slowest pole of a wide base, as a multiple of ω.
const SLOWEST_POLE_RATIO: f64 = 0.05;

/// Coordinates of a search from a model; the range of the base is around the given one.
pub fn of_hypothesis(hypothesis: &Hypothesis, start: &Model, given: &Base, chatter_hz: f64) -> Vec<Coordinate> {
    let base = if hypothesis.base_free { of_base(hypothesis, start, given) } else { Vec::new() };
    let chatter = hypothesis.effects.contains(&"chatter").then(|| of_chatter(chatter_hz));
    base.into_iter().chain(of_effects(hypothesis, start)).chain(chatter).collect()
}

fn of_base(hypothesis: &Hypothesis, start: &Model, given: &Base) -> Vec<Coordinate> {
    let [k, p, omega, zeta] = given.values();
    let logarithm = |place: usize, value: f64, low: f64, high: f64| Coordinate {
        target: Target::Base(place),
        scale: Scale::Logarithm(value.signum()),
        low,
        high,
    };
    // Half or twice the given value is another actuator; further away an overdamped base would imitate other effects.
    let reach = if hypothesis.wide { WIDE_FACTORS } else { [2.0; 3] }.map(f64::ln);
    let shared = [(0, k), (2, omega), (3, zeta.max(1e-3))].into_iter().zip(reach).map(|((place, value), reach)| {
        let centre = value.abs().ln();
        let low = centre - reach;
        // The slow pole of a far overdamped pair may be p, with a pair of ordinary damping beyond it.
        let low = if hypothesis.wide && place == 3 { low.min(ORDINARY_DAMPING_RATIO.ln()) } else { low };
        logarithm(place, value, low, centre + reach)
    });
    let mut coordinates: Vec<Coordinate> = shared.collect();
    if hypothesis.wide && start.order == Order::Third {
        let low = SLOWEST_POLE_RATIO * start.base.omega().min(omega);
        coordinates.push(logarithm(1, p, low.ln(), (FAST_POLE_RATIO * omega).ln()));
    } else if hypothesis.pole_free && start.order == Order::Third {
        let low = (given.p() / POLE_FACTOR).min(SLOWEST_FREE_POLE_RATIO * omega);
        let high = (given.p() * POLE_FACTOR).max(FAST_POLE_RATIO * omega);
        coordinates.push(logarithm(1, p, low.ln(), high.ln()));
    } else if has_slow_pole(start) {
        let high = (FAST_POLE_RATIO * omega).ln();
        coordinates.push(logarithm(1, p, p.ln(), high.max(p.ln())));
    }
    coordinates
}

fn of_effects(hypothesis: &Hypothesis, start: &Model) -> Vec<Coordinate> {
    let active: Vec<&'static str> = start.effects.active().map(|(effect, _)| effect.name).collect();
    let values = start.effects.values();
    let mut coordinates = Vec::new();
    for (index, (effect, parameter)) in Effects::parameters().enumerate() {
        let given = hypothesis.base_free && !hypothesis.given_held && active.contains(&effect.name);
        let searched = hypothesis.effects.contains(&effect.name) || given;
        if !searched || MeasurementTerm::of(effect.name).is_some() || effect.name == "quantisation" {
            continue;
        }
        // A steady load beside a bias of the sensor, or beside a level in each record, is a second level: it stays as it is.
        let has_other_level = hypothesis.wide || hypothesis.effects.contains(&"sensor_bias");
        if (effect.name, parameter.name) == ("hinge_load", "bias") && has_other_level {
            continue;
        }
        let value = values[index];
        let (scale, low, high) = if parameter.min >= 0.0 {
            let centre = value.max(f64::MIN_POSITIVE).ln();
            let reach = if parameter.unit == "Hz" { FREQUENCY_SEARCH_FACTOR } else { SEARCH_FACTOR }.ln();
            // Far enough beyond the plausible values that a search is seen to leave them.
            const PLAUSIBLE_MARGIN: f64 = 1.5;
            let most = most_plausible(effect, parameter.name).map_or(parameter.max, |most| PLAUSIBLE_MARGIN * most);
            let ends = [parameter.min.ln(), most.ln()];
            (Scale::Logarithm(1.0), (centre - reach).max(ends[0]), (centre + reach).min(ends[1]))
        } else {
            // A start value near zero must not keep the search there.
            const LEAST_SIZE: f64 = 0.01;
            let size = if value == 0.0 { parameter.nominal } else { value.abs().max(LEAST_SIZE * parameter.nominal) };
            let ends = [parameter.min / size, parameter.max / size];
            let reach = SEARCH_FACTOR * (parameter.nominal / size).max(1.0);
            (Scale::Linear(size), ends[0].max(-reach), ends[1].min(reach))
        };
        coordinates.push(Coordinate { target: Target::Effect(index), scale, low, high });
    }
    coordinates
}

/// Its frequency in cycles per minute; the start value is accurate to a part of one.
fn of_chatter(chatter_hz: f64) -> Coordinate {
    const SCALE: f64 = 1.0 / 60.0;
    const REACH: f64 = 30.0;
    let centre = chatter_hz / SCALE;
    Coordinate {
        target: Target::Chatter,
        scale: Scale::Linear(SCALE),
        low: (centre - REACH).max(0.0),
        high: centre + REACH,
    }
}

/// Whether the pole of a model is slow, with a visible lag.
fn has_slow_pole(model: &Model) -> bool {
    let [_, p, omega, _] = model.base.values();
    model.order == Order::Third && p < SLOW_POLE_RATIO * omega
}
