//! Commands that excite an actuator for identification.
//!
//! The report's are linear sine sweeps and random sequences, 25 or 75 s at 200 samples/s in 0.5-12 Hz. Odd random-phase multisines show
//! distortion on the omitted lines; steps and triangles of two amplitudes show amplitude dependence.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rand_distr::{Distribution, StandardNormal};
use rustfft::num_complex::Complex;

use super::Command;
use crate::fourier;
use actuator_fmu::{
    error::{Error, Result},
    parameters::BAND_HZ,
};

/// Kind of excitation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A sine whose frequency rises linearly through the band.
    Sweep,
    /// Gaussian noise with a flat spectrum in the band and nothing outside.
    Random,
    /// Sines of equal amplitude at the odd multiples of a base frequency in the band, with random phases; two periods.
    Multisine,
    /// Steps up and down, large and a quarter of it, held for 1.5 s on average.
    Steps,
    /// Triangles, large and a quarter of it, at the lower edge of the band.
    Triangles,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Sweep, Self::Random, Self::Multisine, Self::Steps, Self::Triangles];

    /// As spelled in arguments.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sweep => "sweep",
            Self::Random => "random",
            Self::Multisine => "multisine",
            Self::Steps => "steps",
            Self::Triangles => "triangles",
        }
    }
}

/// An excitation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excitation {
    /// Kind.
    pub kind: Kind,
    /// Length \[s\], including rest at both ends.
    pub duration_s: f64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Lowest and highest frequency \[Hz\].
    pub band_hz: [f64; 2],
    /// Peak value, in the unit of the command.
    pub amplitude: f64,
    /// Rest at both ends \[s\].
    pub quiet_s: f64,
    /// Seed of everything random.
    pub seed: u64,
}

impl Excitation {
    /// The report's long test points \[s\].
    pub const LONG_S: f64 = 75.0;
    /// The report's short test points \[s\].
    pub const SHORT_S: f64 = 25.0;
    /// The report's samples per second.
    pub const RATE_HZ: f64 = 200.0;
    /// Small amplitudes of steps and triangles, relative to the large ones: 4 to 1 separates play from friction.
    pub const SMALL: f64 = 0.25;

    /// As in the report: 75 s at 200 samples/s, 0.5-12 Hz, 1 deg.
    #[must_use]
    pub fn new(kind: Kind) -> Self {
        Self {
            kind,
            duration_s: Self::LONG_S,
            rate_hz: Self::RATE_HZ,
            band_hz: BAND_HZ,
            amplitude: 1.0,
            quiet_s: 0.0,
            seed: 1,
        }
    }

    /// The command.
    ///
    /// # Errors
    /// Values for which no command can be generated: fewer than 100 samples, a band that is empty or beyond half the sampling rate, an
    /// amplitude of zero.
    #[allow(clippy::cast_precision_loss)] // counts of samples
    pub fn command(&self) -> Result<Command> {
        let (count, quiet) = self.checked_counts()?;
        let moving = count - 2 * quiet;
        let mut values = match self.kind {
            Kind::Sweep => self.sweep(moving),
            Kind::Random => self.random(moving),
            Kind::Multisine => self.multisine(moving)?,
            Kind::Steps => self.steps(moving),
            Kind::Triangles => self.triangles(moving),
        };
        let peak = values.iter().fold(0.0_f64, |peak, value| peak.max(value.abs()));
        // Steps, triangles and sweeps have their amplitude by construction; the others are scaled here.
        let scale = match self.kind {
            Kind::Random | Kind::Multisine if peak > 0.0 => self.amplitude / peak,
            _ => 1.0,
        };
        values.iter_mut().for_each(|value| *value *= scale);
        let mut command = vec![0.0; quiet];
        command.append(&mut values);
        command.resize(count, 0.0);
        Ok(Command { time: (0..count).map(|index| index as f64 / self.rate_hz).collect(), command })
    }

    /// Total number of samples, and number at rest at each end.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked before
    fn checked_counts(&self) -> Result<(usize, usize)> {
        let positive = |name: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                return Ok(());
            }
            Err(Error::new(name, value.to_string(), "a finite number above 0"))
        };
        positive("duration", self.duration_s)?;
        positive("rate", self.rate_hz)?;
        positive("amplitude", self.amplitude)?;
        positive("lower edge of the band", self.band_hz[0])?;
        if !(self.band_hz[1] > self.band_hz[0] && self.band_hz[1] < 0.5 * self.rate_hz) {
            let allowed = format!("above {} Hz and below half the rate, {} Hz", self.band_hz[0], 0.5 * self.rate_hz);
            return Err(Error::new("upper edge of the band", format!("{} Hz", self.band_hz[1]), allowed));
        }
        let count = (self.duration_s * self.rate_hz).round();
        let quiet = (self.quiet_s.max(0.0) * self.rate_hz).round();
        let (least, most) = (super::record::FEWEST_SAMPLES, 1_000_000_000_usize);
        #[allow(clippy::cast_precision_loss)]
        if !(count - 2.0 * quiet >= least as f64 && count <= most as f64) {
            let found = format!("{count}, of them {} at rest", 2.0 * quiet);
            return Err(Error::new("samples", found, format!("{least} that move, {most} in all"))
                .remedy("change duration, rate or quiet ends"));
        }
        Ok((count as usize, quiet as usize))
    }

    /// A sin(2π (f1 t + (f2 - f1) t² / 2T)), T its duration.
    #[allow(clippy::cast_precision_loss)]
    fn sweep(&self, count: usize) -> Vec<f64> {
        let [low, high] = self.band_hz;
        let duration = count as f64 / self.rate_hz;
        let angle = |t: f64| TAU * (low * t + (high - low) * t * t / (2.0 * duration));
        (0..count).map(|index| self.amplitude * angle(index as f64 / self.rate_hz).sin()).collect()
    }

    /// A part of noise generated over twice the time, so that it is not periodic.
    #[allow(clippy::cast_precision_loss)]
    fn random(&self, count: usize) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let length = 2 * count;
        let step = self.rate_hz / length as f64;
        let lines = (0..=length / 2).map(|line| {
            let inside = (self.band_hz[0]..=self.band_hz[1]).contains(&(line as f64 * step));
            let (re, im): (f64, f64) = (StandardNormal.sample(&mut random), StandardNormal.sample(&mut random));
            if inside { Complex::new(re, im) } else { Complex::default() }
        });
        let mut values = synthesise(lines.collect(), length);
        values.truncate(count);
        values
    }

    /// Two periods, or one if two are shorter than five cycles of the lowest frequency.
    #[allow(clippy::cast_precision_loss)]
    fn multisine(&self, count: usize) -> Result<Vec<f64>> {
        const CYCLES: f64 = 5.0;
        let half = count.div_ceil(2);
        let period = if half as f64 / self.rate_hz * self.band_hz[0] >= CYCLES { half } else { count };
        let step = self.rate_hz / period as f64;
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let lines: Vec<Complex<f64>> = (0..=period / 2)
            .map(|line| {
                let inside = line % 2 == 1 && (self.band_hz[0]..=self.band_hz[1]).contains(&(line as f64 * step));
                let angle = TAU * random.random::<f64>();
                if inside { Complex::from_polar(1.0, angle) } else { Complex::default() }
            })
            .collect();
        if lines.iter().all(|line| line.norm_sqr() == 0.0) {
            return Err(Error::new(
                "band",
                format!("{:?} Hz", self.band_hz),
                "one that holds an odd multiple of 1/period",
            )
            .remedy("lengthen the record or widen the band"));
        }
        let values = synthesise(lines, period);
        Ok(values.iter().cycle().take(count).copied().collect())
    }

    /// Up, back, down, back, alternately large and small, each held for 1 to 2 s.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a few hundred samples
    fn steps(&self, count: usize) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let levels = [1.0, 0.0, -1.0, 0.0, Self::SMALL, 0.0, -Self::SMALL, 0.0];
        let mut values = vec![0.0; (0.5 * self.rate_hz) as usize];
        for level in levels.iter().cycle() {
            if values.len() >= count {
                break;
            }
            let hold = ((1.0 + random.random::<f64>()) * self.rate_hz).ceil() as usize;
            values.extend(std::iter::repeat_n(level * self.amplitude, hold));
        }
        values.truncate(count);
        values
    }

    /// Alternately large and small triangles, one period each.
    #[allow(clippy::cast_precision_loss)]
    fn triangles(&self, count: usize) -> Vec<f64> {
        let wave = |index: usize| {
            let periods = index as f64 / self.rate_hz * self.band_hz[0];
            let size = if periods.floor() % 2.0 == 0.0 { 1.0 } else { Self::SMALL };
            // From 0 up to 1, down to -1, back to 0.
            let place = (periods + 0.25).fract();
            size * self.amplitude * (1.0 - 4.0 * (place - 0.5).abs())
        };
        (0..count).map(wave).collect()
    }
}

/// The real signal with these lines from 0 to half the sampling rate.
fn synthesise(lines: Vec<Complex<f64>>, length: usize) -> Vec<f64> {
    let mut spectrum = lines;
    spectrum.resize(length, Complex::default());
    fourier::inverse(length).process(&mut spectrum);
    spectrum.iter().map(|value| value.re).collect()
}
