//! The parameters of a hypothesis, and the model that a vector of them stands for.
//!
//! Parameters of one sign are searched by their logarithm, the others in units of their start value.

use std::f64::consts::{PI, TAU};

use super::{
    coordinate::{Coordinate, Target},
    coordinates,
    hypothesis::{Hypothesis, MeasurementTerm},
    plausibility::is_plausible,
};
use actuator_fmu::{
    effects::{CHAIN, Effects},
    parameters::{Base, Model},
};

/// Above it a pair of poles acts as one slow pole, for which there is p.
const GREATEST_DAMPING_RATIO: f64 = 3.0;

/// The effect that may ring by itself.
pub const STRUCTURAL_MODE: &str = "structural_mode";

/// Distance in x below which a parameter is at a bound.
const BOUND_TOLERANCE: f64 = 1e-3;

/// The search space of a hypothesis: maps vectors to models.
#[derive(Debug, Clone)]
pub struct Space {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    start: Model,
    /// The given base, centre of its range.
    given: Base,
    coordinates: Vec<Coordinate>,
    chatter_hz: f64,
    /// Whether the level of each record is free.
    has_levels: bool,
    /// Whether a structural mode may ring where a record begins.
    has_ringing: bool,
}

impl Space {
    /// Starts at the values of a model; the range of the base is around the given one.
    pub fn new(hypothesis: Hypothesis, start: &Model, given: &Base, chatter_hz: f64) -> Self {
        let coordinates = coordinates::of_hypothesis(&hypothesis, start, given, chatter_hz);
        // Terms are solved for: the simulation is without them.
        let mut start = start.clone();
        for effect in CHAIN.iter().filter(|effect| hypothesis.effects.contains(&effect.name)) {
            if MeasurementTerm::of(effect.name).is_some() {
                start.effects = start.effects.without(effect);
            }
        }
        let has_levels = hypothesis.wide;
        let is_active = start.effects.active().any(|(effect, _)| effect.name == STRUCTURAL_MODE);
        let has_ringing = hypothesis.effects.contains(&STRUCTURAL_MODE) || is_active;
        Self { hypothesis, start, given: *given, coordinates, chatter_hz, has_levels, has_ringing }
    }

    /// Without what is free in each record besides effects, as an FMU is evaluated.
    #[must_use]
    pub fn without_levels(mut self) -> Self {
        (self.has_levels, self.has_ringing) = (false, false);
        self
    }

    /// With the level of each record as free as in another space.
    #[must_use]
    pub fn with_levels_as_in(mut self, other: &Self) -> Self {
        self.has_levels = other.has_levels;
        self
    }

    /// Without bases whose poles are faster than the sampling shows: they would only be slow to simulate.
    #[must_use]
    pub fn within_sampling(mut self, interval_s: f64) -> Self {
        let [_, _, omega, zeta] = self.start.base.values();
        for coordinate in &mut self.coordinates {
            let fastest = match coordinate.target {
                Target::Base(2) => omega.max(PI / interval_s),
                Target::Base(3) => zeta.max(GREATEST_DAMPING_RATIO),
                _ => continue,
            };
            coordinate.high = coordinate.high.min(fastest.ln()).max(coordinate.low);
        }
        self
    }

    /// With k, ω and ζ of the base within a factor of those of another one. Its pole p may be anywhere, since a fit may put a pole that is not
    /// visible anywhere; so may the faster pole of an overdamped pair, whose lag is that of a pair with twice its slower pole as ω and ζ = 1.
    #[must_use]
    pub fn near(mut self, base: &Base, factor: f64) -> Self {
        let [k, p, omega, zeta] = base.values();
        let slow = if zeta > 1.0 { [k, p, omega.min(2.0 * base.pair_decay()), 1.0] } else { base.values() };
        for coordinate in &mut self.coordinates {
            if let Target::Base(place @ (0 | 2 | 3)) = coordinate.target {
                let centre = |values: [f64; 4]| values[place].abs().max(f64::MIN_POSITIVE).ln();
                let (least, greatest) = (centre(slow), centre([k, p, omega, zeta]));
                coordinate.low = coordinate.low.max(least - factor.ln()).min(coordinate.high);
                coordinate.high = coordinate.high.min(greatest + factor.ln()).max(coordinate.low);
            }
        }
        self
    }

    /// The given base.
    pub fn given(&self) -> &Base {
        &self.given
    }

    /// The start of a search.
    pub fn start(&self) -> Vec<f64> {
        let base = self.start.base.values();
        let value = |coordinate: &Coordinate| match coordinate.target {
            Target::Base(place) => base[place],
            Target::Effect(index) => self.start.effects.values()[index],
            Target::Chatter => self.chatter_hz,
        };
        self.coordinates
            .iter()
            .map(|coordinate| coordinate.number(value(coordinate)).clamp(coordinate.low, coordinate.high))
            .collect()
    }

    /// The same space with a search that starts at a vector; none where that is no valid model.
    pub fn starting_at(mut self, x: &[f64]) -> Option<Self> {
        self.start = self.model(x)?;
        Some(self)
    }

    /// The elements of a vector.
    pub fn coordinates(&self) -> &[Coordinate] {
        &self.coordinates
    }

    /// Place of a parameter in a vector.
    pub fn place(&self, target: Target) -> Option<usize> {
        self.coordinates.iter().position(|coordinate| coordinate.target == target)
    }

    /// Lower and upper bound of each element.
    pub fn bounds(&self) -> Vec<[f64; 2]> {
        self.coordinates.iter().map(|coordinate| [coordinate.low, coordinate.high]).collect()
    }

    /// Whether a parameter of the base is at a bound of its range. A wide base may be faster and more damped than its records show: these bounds do
    /// not limit what is plausible.
    pub fn is_base_at_bound(&self, x: &[f64]) -> bool {
        self.coordinates.iter().zip(x).any(|(coordinate, x)| {
            let is_bound_above = !self.hypothesis.wide || coordinate.target == Target::Base(0);
            let above = if is_bound_above { coordinate.high - x } else { f64::INFINITY };
            matches!(coordinate.target, Target::Base(0 | 2 | 3)) && (x - coordinate.low).min(above) < BOUND_TOLERANCE
        })
    }

    /// Whether a parameter of an added effect is at a bound of its range.
    pub fn effect_at_bound(&self, x: &[f64]) -> bool {
        let added = |index: usize| {
            Effects::parameters().nth(index).is_some_and(|(effect, _)| self.hypothesis.effects.contains(&effect.name))
        };
        self.coordinates.iter().zip(x).any(|(coordinate, x)| {
            matches!(coordinate.target, Target::Effect(index) if added(index))
                && (x - coordinate.low).min(coordinate.high - x) < BOUND_TOLERANCE
        })
    }

    /// Whether the parameters of all searched effects are plausible.
    pub fn is_plausible(&self, model: &Model) -> bool {
        let mut searched = CHAIN.iter().filter(|effect| self.hypothesis.effects.contains(&effect.name));
        searched.all(|effect| is_plausible(effect, &model.effects))
    }

    /// Whether a steady load is free, and no other level is.
    pub fn frees_steady_load(&self) -> bool {
        !self.has_levels
            && Effects::index("hinge_load", "bias").is_ok_and(|bias| self.place(Target::Effect(bias)).is_some())
    }

    /// Whether an element of the vector changes the motion, and not only the measurement.
    pub fn changes_motion(&self, place: usize) -> bool {
        self.coordinates[place].target != Target::Chatter
    }

    /// The model of a vector, without terms; none outside its ranges.
    pub fn model(&self, x: &[f64]) -> Option<Model> {
        let mut base = self.start.base.values();
        let mut effects = self.start.effects.values().to_vec();
        for (coordinate, x) in self.coordinates.iter().zip(x) {
            match coordinate.target {
                Target::Base(place) => base[place] = coordinate.value(*x),
                Target::Effect(index) => effects[index] = coordinate.value(*x),
                Target::Chatter => {}
            }
        }
        let mut model = self.start.clone();
        model.base = Base::from_values(base).ok()?;
        model.effects = Effects::with_values(&effects).ok()?;
        Some(model)
    }

    /// Frequency of the chatter [Hz].
    pub fn chatter_hz(&self, x: &[f64]) -> f64 {
        let place = self.place(Target::Chatter);
        place.map_or(self.chatter_hz, |place| self.coordinates[place].value(x[place]))
    }

    /// Measurement terms.
    pub fn terms(&self) -> impl Iterator<Item = MeasurementTerm> + '_ {
        let level = self.has_levels.then_some(MeasurementTerm::Level);
        self.hypothesis.effects.iter().filter_map(|effect| MeasurementTerm::of(effect)).chain(level)
    }

    /// Whether nothing but a level is free in a record.
    pub fn frees_only_levels(&self, in_motion: bool) -> bool {
        !(self.has_ringing && in_motion) && self.terms().all(|term| term == MeasurementTerm::Level)
    }

    /// Columns of the terms at times since the start of a record; for one that begins in motion also the free decay of a structural mode:
    ///
    /// ```text
    /// e^(-ζωt) cos(ω√(1-ζ²) t),  e^(-ζωt) sin(ω√(1-ζ²) t)
    /// ```
    pub fn columns(&self, x: &[f64], time: &[f64], in_motion: bool) -> Vec<Vec<f64>> {
        let of = |function: &dyn Fn(f64) -> f64| time.iter().map(|t| function(t - time[0])).collect::<Vec<f64>>();
        let mut columns = Vec::new();
        for term in self.terms() {
            match term {
                MeasurementTerm::Level => columns.push(of(&|_| 1.0)),
                MeasurementTerm::Bias => columns.extend([of(&|_| 1.0), of(&|t| t)]),
                MeasurementTerm::Chatter => {
                    let omega = TAU * self.chatter_hz(x);
                    columns.extend([of(&|t| (omega * t).sin()), of(&|t| (omega * t).cos())]);
                }
            }
        }
        let mode = self.model(x).filter(|_| self.has_ringing && in_motion);
        let mode = mode.and_then(|model| model.effects.active_values_of(STRUCTURAL_MODE).map(<[f64]>::to_vec));
        if let Some(&[frequency_hz, damping_ratio, _]) = mode.as_deref() {
            let decay = damping_ratio * TAU * frequency_hz;
            let omega = TAU * frequency_hz * (1.0 - damping_ratio * damping_ratio).max(0.0).sqrt();
            columns.extend([
                of(&|t| (-decay * t).exp() * (omega * t).cos()),
                of(&|t| (-decay * t).exp() * (omega * t).sin()),
            ]);
        }
        columns
    }

    /// Number of estimated parameters, those of single records counted once.
    pub fn parameters(&self) -> usize {
        self.coordinates.len() + self.terms().map(MeasurementTerm::parameters).sum::<usize>()
    }

    /// Place of a base parameter or effect parameter in the vector, and d value / dx there.
    pub fn slope(&self, x: &[f64], name: ParameterIndex) -> Option<(usize, f64)> {
        let target = match name {
            ParameterIndex::Base(place) => Target::Base(place),
            ParameterIndex::Effect(index) if Effects::index("chatter", "frequency") == Ok(index) => Target::Chatter,
            ParameterIndex::Effect(index) => Target::Effect(index),
        };
        let place = self.place(target)?;
        Some((place, self.coordinates[place].slope(x[place]).abs()))
    }
}

/// A parameter.
#[derive(Debug, Clone, Copy)]
pub enum ParameterIndex {
    /// Place in [`actuator_fmu::parameters::Base::PARAMETERS`].
    Base(usize),
    /// Place in [`Effects::parameters`].
    Effect(usize),
}

#[cfg(test)]
mod tests {
    use super::*;
    use actuator_fmu::{effects::find, parameters::table};

    fn given(values: [f64; 4]) -> Model {
        Model { base: Base::from_values(values).unwrap(), ..Model::from_set(&table()[0]) }
    }

    #[test]
    fn near_an_overdamped_pair_is_one_as_late_whose_faster_pole_does_not_show() {
        let near = |values: [f64; 4]| {
            let given = given(values);
            let free = Hypothesis { base_free: true, wide: true, ..Hypothesis::default() };
            Space::new(free, &given, &given.base, 0.0).near(&given.base, 2.0)
        };
        let reaches = |space: &Space, base: [f64; 4]| {
            let x = space.coordinates.iter().map(|coordinate| match coordinate.target {
                Target::Base(place) => coordinate.number(base[place]),
                _ => 0.0,
            });
            x.zip(space.bounds()).all(|(x, [low, high])| low <= x && x <= high)
        };
        // Poles at 100 and 10 000 1/s, and a pair of the same lag 2ζ/ω.
        let overdamped = near([1.0, 500.0, 1000.0, 5.05]);
        assert!(reaches(&overdamped, [1.0, 500.0, 138.0, 0.7]) && reaches(&overdamped, [1.0, 500.0, 1500.0, 8.0]));
        assert!(!reaches(&overdamped, [1.0, 500.0, 60.0, 0.7]));
        let damped = near([1.0, 500.0, 1000.0, 0.9]);
        assert!(reaches(&damped, [1.0, 500.0, 600.0, 0.5]) && !reaches(&damped, [1.0, 500.0, 400.0, 0.9]));
    }

    #[test]
    fn a_pair_of_ordinary_damping_is_within_reach_of_an_overdamped_one_whose_slow_pole_is_p() {
        let within = |zeta: f64, base: [f64; 4]| {
            let given = given([1.0, 500.0, 100.0, zeta]);
            let free = Hypothesis { base_free: true, wide: true, ..Hypothesis::default() };
            let start = Model { base: Base::from_values(base).unwrap(), ..given.clone() };
            let space = Space::new(free, &start, &given.base, 0.0);
            !space.is_base_at_bound(&space.start())
        };
        assert!(within(3.6, [1.0, 28.0, 100.0, 0.3]) && within(0.7, [1.0, 28.0, 100.0, 0.1]));
        assert!(!within(3.6, [1.0, 28.0, 100.0, 0.2]) && !within(0.7, [1.0, 28.0, 100.0, 0.06]));
    }

    #[test]
    fn a_steady_load_is_the_only_level_or_none() {
        let given = given([1.0, 100.0, 50.0, 0.7]);
        let frees_load = |effects: Vec<&'static str>, wide: bool| {
            let hypothesis = Hypothesis { effects, base_free: true, wide, ..Hypothesis::default() };
            Space::new(hypothesis, &given, &given.base, 0.0).frees_steady_load()
        };
        assert!(frees_load(vec!["hinge_load"], false));
        assert!(!frees_load(vec!["hinge_load"], true) && !frees_load(vec!["sensor_bias", "hinge_load"], false));
    }

    #[test]
    fn a_mode_that_is_damped_is_not_plausible_wherever_a_search_ends() {
        let given = given([1.0, 100.0, 50.0, 0.7]);
        let mode = find(STRUCTURAL_MODE).unwrap();
        let is_plausible = |searched: bool, damping: f64| {
            let effects = given.effects.with(mode, &[20.0, damping, 0.1]).unwrap();
            let effects_searched = if searched { vec![STRUCTURAL_MODE] } else { Vec::new() };
            let hypothesis = Hypothesis { effects: effects_searched, base_free: true, ..Hypothesis::default() };
            let model = Model { effects, ..given.clone() };
            Space::new(hypothesis, &model, &given.base, 0.0).is_plausible(&model)
        };
        assert!(is_plausible(true, 0.1) && !is_plausible(true, 0.15));
        // The effects of the given model are not judged.
        assert!(is_plausible(false, 0.15));
    }
}
