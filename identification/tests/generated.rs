//! Records with known truth, for tests.

use actuator_fmu::parameters::{Base, Model, Order};
use identification::{
    signal::{
        Interpolation,
        excitation::{Excitation, Kind},
        format::PositionUnit,
        record::{Record, rms},
    },
    simulate::simulate,
};
use rand::{SeedableRng, rngs::ChaCha8Rng};
use rand_distr::{Distribution, StandardNormal};

/// A record of a third-order actuator.
pub struct Generated {
    pub base: Base,
    pub kind: Kind,
    pub duration_s: f64,
    pub interpolation: Interpolation,
    /// Root mean square of the noise as a share of the position's.
    pub noise: f64,
    /// Colour of the noise.
    pub colour: Colour,
    pub seed: u64,
    /// Of the noise.
    pub noise_seed: u64,
}

impl Generated {
    pub fn new(base: Base) -> Self {
        Self {
            base,
            kind: Kind::Sweep,
            duration_s: 75.0,
            interpolation: Interpolation::Held,
            noise: 0.0,
            colour: Colour::White,
            seed: 1,
            noise_seed: 1,
        }
    }

    pub fn record(&self) -> Record {
        let excitation = Excitation { duration_s: self.duration_s, seed: self.seed, ..Excitation::new(self.kind) };
        let command = excitation.command().unwrap();
        let model = Model::new(self.base, Order::Third);
        let mut position = simulate(&model, &command, self.interpolation).unwrap().position;
        let size = self.noise * rms(&position);
        let mut random = ChaCha8Rng::seed_from_u64(self.noise_seed);
        let [a1, a2] = self.colour.coefficients();
        let mut white = || -> f64 { StandardNormal.sample(&mut random) };
        // Started ten seconds before the record, so that it is stationary; then scaled to size.
        let (mut noise, mut before) = (Vec::with_capacity(position.len()), [0.0, 0.0]);
        for index in 0..position.len() + 2000 {
            let now = a1 * before[0] + a2 * before[1] + white();
            before = [now, before[0]];
            if index >= 2000 {
                noise.push(now);
            }
        }
        let scale = size / self.colour.rms();
        position.iter_mut().zip(&noise).for_each(|(value, noise)| *value += scale * noise);
        Record::new(command, position, PositionUnit::Degree, self.interpolation, "generated").unwrap()
    }
}

/// Colour of noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Colour {
    /// None.
    White,
    /// First order: this correlation from sample to sample.
    First(f64),
    /// A resonance in the band, at 4 Hz with a damping ratio of 0.05: a wing that shakes in turbulence.
    Resonance,
}

impl Colour {
    /// a1, a2 of n = a1 n[-1] + a2 n[-2] + white, at 200 samples/s.
    fn coefficients(self) -> [f64; 2] {
        match self {
            Self::White => [0.0, 0.0],
            Self::First(correlation) => [correlation, 0.0],
            Self::Resonance => {
                let omega_h = std::f64::consts::TAU * 4.0 / 200.0;
                let radius = (-0.05 * omega_h).exp();
                [2.0 * radius * omega_h.cos(), -radius * radius]
            }
        }
    }

    /// Root mean square for white noise of one: √((1 - a2) / ((1 + a2) ((1 - a2)² - a1²))).
    fn rms(self) -> f64 {
        let [a1, a2] = self.coefficients();
        ((1.0 - a2) / ((1.0 + a2) * ((1.0 - a2) * (1.0 - a2) - a1 * a1))).sqrt()
    }
}
