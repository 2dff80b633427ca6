//! Records with known truth, for tests.

use actuator_fmu::{
    parameters::{Base, Model, Order},
    signal::{
        Interpolation,
        excitation::{Excitation, Kind},
        record::{Record, Unit, rms},
    },
    simulate::simulate,
};
use rand::{SeedableRng, rngs::ChaCha8Rng};
use rand_distr::{Distribution, StandardNormal};

pub const DATA: &str = "";

/// A record of a third-order actuator.
pub struct Generated {
    pub base: Base,
    pub kind: Kind,
    pub duration_s: f64,
    pub interpolation: Interpolation,
    /// Root mean square of the noise as a share of the position's.
    pub noise: f64,
    /// Correlation of the noise from sample to sample.
    pub colour: f64,
    pub seed: u64,
}

impl Generated {
    pub fn new(base: Base) -> Self {
        Self {
            base,
            kind: Kind::Sweep,
            duration_s: 75.0,
            interpolation: Interpolation::Held,
            noise: 0.0,
            colour: 0.0,
            seed: 1,
        }
    }

    pub fn record(&self) -> Record {
        let excitation = Excitation { duration_s: self.duration_s, seed: self.seed, ..Excitation::new(self.kind) };
        let command = excitation.command().unwrap();
        let model = Model::new(self.base, Order::Third);
        let mut position = simulate(&model, &command, self.interpolation).unwrap().position;
        let size = self.noise * rms(&position);
        let mut random = ChaCha8Rng::seed_from_u64(self.seed + 1000);
        let mut noise = 0.0;
        for value in &mut position {
            let white: f64 = StandardNormal.sample(&mut random);
            noise = self.colour * noise + (1.0 - self.colour * self.colour).sqrt() * white;
            *value += size * noise;
        }
        Record::new(command, position, Unit::Degree, self.interpolation, "generated").unwrap()
    }
}
