//! Generated test points: records as from a wind-tunnel test, with known truth.
//!
//! An actuator of the tables follows an excitation of the report's kind; its position sensor adds white noise; under load, turbulence acts
//! on the hinge. Turbulence n is given as the static deflection due to the hinge load, a first-order Gauss-Markov process (the longitudinal
//! Dryden spectrum: H. L. Dryden 1938, MIL-F-8785C), and the surface responds to it as to a load,
//!
//! ```text
//! δ̈ = ω² (x + n - δ) - 2 ζ ω δ̇,   n[i+1] = φ n[i] + σ √(1 - φ²) w[i],   φ = exp(-h / τ),   w normal
//! ```
//!
//! so that the noise in a loaded record is coloured. The report's measured records are not available as data: everything generated here is
//! marked as such in its source.

use rand::{SeedableRng, rngs::ChaCha8Rng};
use rand_distr::{Distribution, StandardNormal};

use crate::{
    signal::{
        Command, Interpolation,
        excitation::Excitation,
        format::PositionUnit,
        record::{Record, rms},
    },
    simulate::simulate,
};
use actuator_fmu::{
    actuator::{Actuator, Inputs, Workspace},
    effects::Effects,
    error::Result,
    parameters::{Base, Model, Order},
    transition::Ramp,
};

/// Separates the noise from a random excitation with the same seed. Any number but zero would do.
const NOT_THE_EXCITATION: u64 = 0x9e37_79b9_7f4a_7c15;

/// One test point to be generated.
#[derive(Debug, Clone, PartialEq)]
pub struct TestPoint {
    /// The actuator.
    pub model: Model,
    /// The excitation.
    pub excitation: Excitation,
    /// Interpolation of the command between samples.
    pub interpolation: Interpolation,
    /// Standard deviation of the sensor's white noise, relative to the position's rms.
    pub noise_share: f64,
    /// Turbulence on the hinge; `None` in still air.
    pub turbulence: Option<Turbulence>,
    /// Seed of noise and turbulence.
    pub seed: u64,
}

/// Turbulence as a static deflection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turbulence {
    /// σ \[deg\].
    pub deflection_rms_deg: f64,
    /// τ \[s\].
    pub correlation_time_s: f64,
}

impl Turbulence {
    /// Deflection per dynamic pressure [deg/psf]: 0.05 deg at 190 psf, the report's highest, against commands of a degree or two.
    const DEFLECTION_PER_PRESSURE: f64 = 0.05 / 190.0;
    /// A corner at 1.6 Hz, inside the band of the excitation.
    const CORRELATION_TIME_S: f64 = 0.1;

    /// At a dynamic pressure \[psf\]; `None` in still air.
    #[must_use]
    pub fn at(dynamic_pressure_psf: f64) -> Option<Self> {
        (dynamic_pressure_psf > 0.0).then_some(Self {
            deflection_rms_deg: Self::DEFLECTION_PER_PRESSURE * dynamic_pressure_psf,
            correlation_time_s: Self::CORRELATION_TIME_S,
        })
    }
}

impl TestPoint {
    /// The record; `source` should state that it is generated.
    ///
    /// # Errors
    /// Those of the excitation.
    pub fn record(&self, source: &str) -> Result<Record> {
        let command = self.excitation.command()?;
        let mut position = simulate(&self.model, &command, self.interpolation)?.position;
        let mut random = ChaCha8Rng::seed_from_u64(self.seed ^ NOT_THE_EXCITATION);
        let noise = self.noise_share * rms(&position);
        if let Some(turbulence) = &self.turbulence {
            let moved = turbulence.deflections(&self.model.base, &command, &mut random)?;
            position.iter_mut().zip(moved).for_each(|(position, moved)| *position += moved);
        }
        for value in &mut position {
            let normal: f64 = StandardNormal.sample(&mut random);
            *value += noise * normal;
        }
        Record::new(command, position, PositionUnit::Degree, self.interpolation, source)
    }
}

impl Turbulence {
    /// Its contribution to the position at the times of a command. Loads add to the servo's target, so that this is the response of a
    /// second-order actuator with k = 1 to n.
    fn deflections(&self, base: &Base, command: &Command, random: &mut ChaCha8Rng) -> Result<Vec<f64>> {
        let compliance = Base::new(1.0, base.p(), base.omega(), base.zeta()).unwrap_or(*base);
        let actuator = Actuator::new(compliance, Order::Second, &Effects::default());
        let mut draw = || -> f64 { StandardNormal.sample(random) };
        let mut load = self.deflection_rms_deg * draw();
        let (mut state, mut workspace) = (actuator.at_rest(load), Workspace::default());
        let mut positions = vec![state.position];
        for pair in command.time.windows(2) {
            let step = pair[1] - pair[0];
            let kept = (-step / self.correlation_time_s).exp();
            let next = kept * load + self.deflection_rms_deg * (1.0 - kept * kept).sqrt() * draw();
            let inputs = Inputs::command(Ramp { value: load, slope: (next - load) / step });
            actuator.step(&mut state, &mut workspace, inputs, step)?;
            load = next;
            positions.push(state.position);
        }
        Ok(positions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::excitation::Kind;
    use actuator_fmu::parameters::table;

    fn point(noise_share: f64, turbulence: Option<Turbulence>) -> TestPoint {
        TestPoint {
            model: Model::from_set(&table()[3]),
            excitation: Excitation::new(Kind::Sweep),
            interpolation: Interpolation::Held,
            noise_share,
            turbulence,
            seed: 7,
        }
    }

    #[test]
    fn the_same_seed_makes_the_same_record_and_another_seed_another() {
        let one = point(0.02, Turbulence::at(190.0));
        let again = one.record("generated").unwrap();
        assert_eq!(one.record("generated").unwrap(), again);
        assert_ne!(TestPoint { seed: 8, ..one }.record("generated").unwrap().position(), again.position());
    }

    #[test]
    fn noise_is_white_and_of_the_stated_size_and_turbulence_is_coloured() {
        let clean = point(0.0, None).record("").unwrap();
        let correlation = |noisy: &Record| {
            let rest: Vec<f64> = noisy.position().iter().zip(clean.position()).map(|(a, b)| a - b).collect();
            let product: f64 = rest.windows(2).map(|pair| pair[0] * pair[1]).sum();
            (rms(&rest), product / rest.iter().map(|value| value * value).sum::<f64>())
        };
        // 15 001 samples: rms within 3 standard errors of 1/√(2N), correlation of neighbours within 3/√N.
        let (size, neighbours) = correlation(&point(0.02, None).record("").unwrap());
        assert!(
            (size / (0.02 * rms(clean.position())) - 1.0).abs() < 0.018 && neighbours.abs() < 0.025,
            "{size} {neighbours}"
        );
        // 750 correlation times: σ within 3/√750, ζω well above the corner, so that the surface follows.
        let (size, neighbours) = correlation(&point(0.0, Turbulence::at(190.0)).record("").unwrap());
        assert!((size / 0.05 - 1.0).abs() < 0.15 && neighbours > 0.9, "{size} {neighbours}");
        assert_eq!(Turbulence::at(0.0), None);
    }
}
