//! Welch's method with the report's settings: spectra averaged over blocks of 2048 samples that overlap by 75 %, under a Hann window, and their
//! ratio H1 = S_cy / S_cc, c the command and y the position.
//!
//! It has known errors. A block in which a sweep passes through many frequencies leaks between bins, and the last block of a record ends
//! before the sweep does: 25 s at 200 samples/s give six blocks, equivalent to 3.4 independent ones (the coherence is then biased by 1 /
//! 3.4 = 0.29), and nothing above 11.1 Hz of a sweep to 12 Hz. Local polynomials ([`super::polynomial`]) have none of this.
//!
//! Samples are pushed one at a time: memory is one block, however long the record.

use std::sync::Arc;

use nalgebra::Complex;
use rustfft::Fft;

use super::{
    excited_lines::EXCITED_SHARE,
    measured::{FrequencyResponse, LineEstimate, Method},
    reference_model,
};
use crate::{
    fourier,
    signal::{Interpolation, record::Record, sampling::Sampling, stream::Stream},
};
use actuator_fmu::{
    error::{Error, Result},
    parameters::BAND_HZ,
};

/// Samples in a block ("2K data blocks").
pub const BLOCK: usize = 2048;

/// Samples from block to block: 75 % overlap.
pub const HOP: usize = BLOCK / 4;

/// Relative tolerance for equal intervals of two records: times are written with few digits.
const SAME_INTERVAL: f64 = 1e-3;

/// Averaged spectra of a command and a position.
pub struct Welch {
    fft: Arc<dyn Fft<f64>>,
    window: Vec<f64>,
    /// Command and position of the last block, as one complex number each.
    recent: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
    command_power: Vec<f64>,
    position_power: Vec<f64>,
    cross: Vec<Complex<f64>>,
    blocks: usize,
    averages: f64,
    since_last: usize,
    grid: Option<(f64, Interpolation)>,
}

impl Default for Welch {
    fn default() -> Self {
        let bins = BLOCK / 2 + 1;
        #[allow(clippy::cast_precision_loss)]
        let angle = |index: usize| std::f64::consts::TAU * index as f64 / BLOCK as f64;
        Self {
            fft: fourier::forward(BLOCK),
            window: (0..BLOCK).map(|index| 0.5 - 0.5 * angle(index).cos()).collect(),
            recent: Vec::with_capacity(BLOCK),
            scratch: vec![Complex::default(); BLOCK],
            command_power: vec![0.0; bins],
            position_power: vec![0.0; bins],
            cross: vec![Complex::default(); bins],
            blocks: 0,
            averages: 0.0,
            since_last: 0,
            grid: None,
        }
    }
}

impl Welch {
    /// Adds a sample to the current record.
    pub fn push(&mut self, command: f64, position: f64) {
        if self.recent.len() == BLOCK {
            self.recent.drain(..HOP);
        }
        self.recent.push(Complex::new(command, position));
        if self.recent.len() == BLOCK {
            self.take_block();
        }
    }

    /// Ends the current record; the next sample starts another one.
    ///
    /// # Errors
    /// A record shorter than a block; a different interval or interpolation than before.
    pub fn end_record(&mut self, interval_s: f64, interpolation: Interpolation) -> Result<()> {
        let blocks = std::mem::take(&mut self.since_last);
        self.recent.clear();
        if blocks == 0 {
            return Err(Error::new("samples of a record", "less than a block", format!("{BLOCK} or more"))
                .remedy("use --method polynomial"));
        }
        self.averages += independent(blocks);
        let same = |(interval, kind): (f64, Interpolation)| {
            (interval / interval_s - 1.0).abs() < SAME_INTERVAL && kind == interpolation
        };
        match self.grid {
            Some(grid) if !same(grid) => Err(Error::new(
                "records",
                format!("intervals of {} s and {interval_s} s, or held and linear commands", grid.0),
                "one interval and one kind of command",
            )
            .remedy("use --method polynomial")),
            Some(_) => Ok(()),
            None => {
                self.grid = Some((interval_s, interpolation));
                Ok(())
            }
        }
    }

    /// Adds a whole record.
    ///
    /// # Errors
    /// As [`Welch::end_record`]; uneven sampling.
    pub fn add(&mut self, record: &Record) -> Result<()> {
        let at = |error: Error| error.at(record.source(), None);
        let Sampling::Even(interval) = record.sampling() else {
            return Err(at(
                Error::new("sampling", "uneven", "even, for spectra of blocks").remedy("use --method polynomial")
            ));
        };
        record.command().iter().zip(record.position()).for_each(|(command, position)| self.push(*command, *position));
        self.end_record(interval, record.interpolation()).map_err(at)
    }

    /// Adds a whole file, block by block: memory does not grow with its length.
    ///
    /// # Errors
    /// As [`Welch::add`], and those of an invalid record file.
    pub fn add_stream(&mut self, stream: &mut Stream) -> Result<()> {
        while let Some(block) = stream.next_block()? {
            block.iter().for_each(|sample| self.push(sample.command, sample.position));
        }
        let at = |error: Error| error.at(stream.source(), None);
        match stream.sampling() {
            Sampling::Even(interval) => self.end_record(interval, stream.interpolation()).map_err(at),
            Sampling::Uneven(_) => Err(at(uneven())),
        }
    }

    fn take_block(&mut self) {
        for (scratch, (sample, weight)) in self.scratch.iter_mut().zip(self.recent.iter().zip(&self.window)) {
            *scratch = sample * weight;
        }
        self.fft.process(&mut self.scratch);
        for bin in 0..=BLOCK / 2 {
            // Two real signals in one transform: the even part is the command's, the odd part j times the position's.
            let (here, mirrored) = (self.scratch[bin], self.scratch[(BLOCK - bin) % BLOCK].conj());
            let command = (here + mirrored) * 0.5;
            let position = (here - mirrored) * Complex::new(0.0, -0.5);
            self.command_power[bin] += command.norm_sqr();
            self.position_power[bin] += position.norm_sqr();
            self.cross[bin] += position * command.conj();
        }
        self.blocks += 1;
        self.since_last += 1;
    }

    /// The response, with the command's reconstruction divided out.
    ///
    /// # Errors
    /// No record was ended.
    #[allow(clippy::cast_precision_loss)] // counts of bins and blocks
    pub fn finish(&self) -> Result<FrequencyResponse> {
        let Some((interval, interpolation)) = self.grid else {
            return Err(Error::new("records", "none", "one or more"));
        };
        let averages = self.averages;
        let greatest = self.command_power.iter().skip(1).copied().fold(0.0, f64::max);
        let mut raw: Vec<LineEstimate> = (1..=BLOCK / 2)
            .filter(|&bin| self.command_power[bin] > 0.0)
            .map(|bin| {
                let (command, position, cross) = (self.command_power[bin], self.position_power[bin], self.cross[bin]);
                let response = cross / command;
                let coherence = (cross.norm_sqr() / (command * position).max(f64::MIN_POSITIVE)).min(1.0);
                // Bendat and Piersol: var|H| / |H|² = (1 - γ²) / (2 γ² n), and the same for the phase.
                let variance = response.norm_sqr() * (1.0 - coherence) / (coherence.max(f64::MIN_POSITIVE) * averages);
                let excited = command > EXCITED_SHARE * greatest;
                LineEstimate {
                    frequency_hz: bin as f64 / (BLOCK as f64 * interval),
                    response,
                    variance,
                    coherence,
                    excited,
                }
            })
            .collect();
        let highest = raw.iter().rev().find(|point| point.excited).map_or(0.0, |point| point.frequency_hz);
        // Always the report's band: missing parts of it in a record are part of the method's error.
        raw.retain(|point| point.frequency_hz <= highest.max(BAND_HZ[1]));
        // One block has a coherence of one, for any noise.
        let single = self.blocks == 1;
        let mut notes = vec![if single {
            "report's recipe: a single block gives no noise estimate: standard errors are unknown (null in JSON, inf in CSV) and the \
             coherence is given as 0; use --method polynomial, or a record of 2560 samples or more"
                .into()
        } else {
            format!(
                "report's recipe: {} blocks, equivalent to {averages:.1} independent ones; coherence is biased by up to {:.2}, the response \
             by leakage, most at the edges of the band",
                self.blocks,
                1.0 / averages
            )
        }];
        let grid = Some((interval, interpolation));
        let model = reference_model::fit(&raw, grid);
        if model.is_none() {
            notes.push(reference_model::UNCORRECTED_IMAGES.into());
        }
        for point in &mut raw {
            *point = point.times(reference_model::correction(model.as_ref(), grid, point.frequency_hz));
            if single {
                *point = LineEstimate { variance: f64::INFINITY, coherence: 0.0, ..*point };
            }
        }
        Ok(FrequencyResponse {
            method: Method::Report,
            points: raw.into_iter().map(LineEstimate::into_point).collect(),
            averages: Some(averages),
            notes,
        })
    }
}

fn uneven() -> Error {
    Error::new("sampling", "uneven", "even, for spectra of blocks").remedy("use --method polynomial")
}

/// Equivalent number of independent blocks for this many overlapping ones: K / (1 + 2 Σ (1 - m/K) ρ(m)²), with the correlation ρ of two
/// Hann windows 1, 2 and 3 quarters of a block apart (P. D. Welch, IEEE Trans. AU-15, 1967).
#[allow(clippy::cast_precision_loss)]
fn independent(blocks: usize) -> f64 {
    // ρ(m) = Σ w[n] w[n + m BLOCK/4] / Σ w[n]², for the Hann window in closed form.
    const CORRELATION: [f64; 3] = [0.659_154_943, 0.166_666_667, 0.007_511_724];
    let count = blocks as f64;
    let sum: f64 = CORRELATION
        .iter()
        .zip(1_u8..)
        .map(|(correlation, apart)| (1.0 - f64::from(apart) / count).max(0.0) * correlation * correlation)
        .sum();
    count / (1.0 + 2.0 * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_overlapping_blocks_are_worth_three_and_a_half() {
        assert!((independent(6) - 3.4).abs() < 0.05, "{}", independent(6));
        assert!((independent(1) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_window_has_the_stated_correlations() {
        let welch = Welch::default();
        let w = |index: usize| welch.window.get(index).copied().unwrap_or(0.0);
        let product = |apart: usize| (0..BLOCK).map(|index| w(index) * w(index + apart)).sum::<f64>();
        for (quarters, expected) in [(1, 0.659_154_943), (2, 1.0 / 6.0), (3, 0.007_511_724)] {
            assert!((product(quarters * HOP) / product(0) - expected).abs() < 1e-6, "{quarters}");
        }
    }
}
