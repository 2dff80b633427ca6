//! Measured frequency responses.

use std::io::Write;

use nalgebra::Complex;

use super::transfer_function::phase_deg;

/// Estimation method of a response.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The report's: Hann window, blocks of 2048 samples, 75 % overlap, cross over auto spectrum.
    Report,
    /// Local polynomials over the whole record.
    #[default]
    Polynomial,
}

impl Method {
    /// As spelled in arguments.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Report => "report",
            Self::Polynomial => "polynomial",
        }
    }
}

/// The response at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrequencyPoint {
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
    /// H, of position to command.
    pub response: Complex<f64>,
    /// Fraction of the position's power that is explained by the command, in addition to the transient, 0 to 1; 0 if a single block gives
    /// none.
    pub coherence: f64,
    /// Standard error of the magnitude; infinite if unknown.
    pub magnitude_std_error: f64,
    /// Standard error of the phase \[deg\].
    pub phase_std_error_deg: f64,
    /// Whether the command has sufficient power here for meaningful numbers.
    pub excited: bool,
}

/// A response over frequency, with the notes needed to use it.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyResponse {
    /// Estimation method.
    pub method: Method,
    /// By increasing frequency.
    pub points: Vec<FrequencyPoint>,
    /// Effective number of independent blocks of the report's method; `None` for local polynomials.
    pub averages: Option<f64>,
    /// Notes: known bias, corrections that were not possible.
    pub notes: Vec<String>,
}

impl FrequencyResponse {
    /// Lowest and highest excited frequency \[Hz\].
    #[must_use]
    pub fn excited_band_hz(&self) -> Option<[f64; 2]> {
        let mut excited = self.points.iter().filter(|point| point.excited).map(|point| point.frequency_hz);
        let first = excited.next()?;
        Some([first, excited.next_back().unwrap_or(first)])
    }

    /// The points in a band \[Hz\], including its edges.
    pub fn inside(&self, band_hz: [f64; 2]) -> impl Iterator<Item = &FrequencyPoint> {
        self.points.iter().filter(move |point| (band_hz[0]..=band_hz[1]).contains(&point.frequency_hz))
    }

    /// As CSV.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_csv(&self, to: impl Write) -> std::io::Result<()> {
        let mut writer = csv::Writer::from_writer(to);
        writer.write_record([
            "frequency_hz",
            "magnitude",
            "phase_deg",
            "coherence",
            "magnitude_std_error",
            "phase_std_error_deg",
            "excited",
        ])?;
        for point in &self.points {
            let numbers = [
                point.frequency_hz,
                point.response.norm(),
                phase_deg(point.response),
                point.coherence,
                point.magnitude_std_error,
                point.phase_std_error_deg,
            ];
            let excited = if point.excited { "1" } else { "0" };
            writer.write_record(numbers.iter().map(f64::to_string).chain([excited.to_owned()]))?;
        }
        writer.flush()
    }
}

/// A response and its variance at one frequency, from one record or several.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LineEstimate {
    pub frequency_hz: f64,
    pub response: Complex<f64>,
    /// Variance of the complex response, both parts together.
    pub variance: f64,
    pub coherence: f64,
    pub excited: bool,
}

impl LineEstimate {
    /// Where the records give no information.
    pub(super) fn unknown(frequency_hz: f64) -> Self {
        Self { frequency_hz, response: Complex::default(), variance: f64::INFINITY, coherence: 0.0, excited: false }
    }

    /// With its response multiplied by a factor.
    pub(super) fn times(self, factor: Complex<f64>) -> Self {
        Self { response: self.response * factor, variance: self.variance * factor.norm_sqr(), ..self }
    }

    /// Magnitude and phase each have half of the variance.
    pub(super) fn into_point(self) -> FrequencyPoint {
        let half = (0.5 * self.variance).sqrt();
        let magnitude = self.response.norm();
        FrequencyPoint {
            frequency_hz: self.frequency_hz,
            response: self.response,
            coherence: self.coherence,
            magnitude_std_error: half,
            phase_std_error_deg: (half / magnitude.max(f64::MIN_POSITIVE)).to_degrees().min(180.0),
            excited: self.excited,
        }
    }
}
