//! A record: command and measured position over time.
//!
//! CSV with a header. Sampling may be uneven; between samples the command is held or linear, which only the user knows: at 200 samples/s a
//! held command lags a linear one by half a step, 2.5 ms, which is 10.8 deg at 12 Hz.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use sha2::{Digest, Sha256};

pub use super::rows::FEWEST_SAMPLES;
use super::{
    Command, Interpolation, Response, Step,
    format::{Format, PositionUnit},
    rows::Rows,
    sampling::{Sampling, sampling},
    source::Source,
    write_csv,
};
use crate::spikes::bridge;
use actuator_fmu::error::{Error, Result};

/// Command and measured position over time, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    time: Vec<f64>,
    command: Vec<f64>,
    position: Vec<f64>,
    load: Option<Vec<f64>>,
    /// Start time within the record of which it is a stretch [s].
    offset_s: f64,
    /// Whether each position was measured; `None` if all were.
    is_measured: Option<Vec<bool>>,
    /// Time of a sensor slip, whose height is known only roughly [s].
    slip_s: Option<f64>,
    unit: PositionUnit,
    interpolation: Interpolation,
    time_unit_declared: bool,
    understood: Vec<String>,
    source: PathBuf,
    sha256: String,
}

/// Number of rows after which memory is reserved for the expected total: growth by doubling copies, and takes three times as much.
const ROWS_OF_A_GUESS: usize = 1000;

impl Record {
    /// Reads CSV; `path` is the name in errors.
    ///
    /// # Errors
    /// An unreadable file, a missing column, a value that is not a finite number, time that does not increase, fewer than
    /// [`FEWEST_SAMPLES`] rows, a command that never moves; each with file, line and remedy.
    pub fn from_csv(text: Box<dyn Source>, path: &Path, format: &Format) -> Result<Self> {
        let mut rows = Rows::new(text, path, format)?;
        let (mut time, mut command, mut position) = (Vec::new(), Vec::new(), Vec::new());
        let mut load = rows.has_load().then(Vec::new);
        while let Some(sample) = rows.next_sample()? {
            if time.len() == ROWS_OF_A_GUESS {
                let rest = rows.expected().saturating_sub(ROWS_OF_A_GUESS);
                [&mut time, &mut command, &mut position]
                    .into_iter()
                    .chain(&mut load)
                    .for_each(|column| column.reserve(rest));
            }
            time.push(sample.time);
            command.push(sample.command);
            position.push(sample.position);
            if let (Some(load), Some(value)) = (&mut load, sample.load) {
                load.push(value);
            }
        }
        Ok(Self {
            time,
            command,
            position,
            load,
            offset_s: 0.0,
            is_measured: None,
            slip_s: None,
            unit: format.unit,
            interpolation: format.interpolation,
            time_unit_declared: format.time_unit.is_some(),
            understood: rows.understood(),
            source: path.to_owned(),
            sha256: rows.sha256().to_owned(),
        })
    }

    /// A record from values, for generated ones; `source` states their origin.
    ///
    /// # Errors
    /// As [`Record::from_csv`], and columns with different lengths.
    pub fn new(
        command: Command,
        position: Vec<f64>,
        unit: PositionUnit,
        interpolation: Interpolation,
        source: impl Into<PathBuf>,
    ) -> Result<Self> {
        let source = source.into();
        let Command { time, command } = command;
        let refuse =
            |thing: &str, found: String, allowed: &str| Err(Error::new(thing, found, allowed).at(&source, None));
        if command.len() != time.len() || position.len() != time.len() {
            let lengths = format!("{}, {} and {}", time.len(), command.len(), position.len());
            return refuse("lengths of time, command and position", lengths, "one length");
        }
        if time.len() < FEWEST_SAMPLES {
            return refuse("samples", time.len().to_string(), "100 or more");
        }
        if let Some(value) = time.iter().chain(&command).chain(&position).find(|value| !value.is_finite()) {
            return refuse("value", value.to_string(), "finite numbers");
        }
        if time.windows(2).any(|pair| pair[1] <= pair[0]) {
            return refuse("time", "going back or standing".into(), "times that increase");
        }
        if command.iter().all(|value| *value == command[0]) {
            return refuse("command", format!("{} in every sample", command[0]), "a command that moves");
        }
        let mut hash = Sha256::new();
        for column in [&time, &command, &position] {
            column.iter().for_each(|value| hash.update(value.to_le_bytes()));
        }
        let sha256 = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self {
            time,
            command,
            position,
            load: None,
            offset_s: 0.0,
            is_measured: None,
            slip_s: None,
            unit,
            interpolation,
            time_unit_declared: false,
            understood: Vec::new(),
            source,
            sha256,
        })
    }

    /// Increasing times \[s\].
    #[must_use]
    pub fn time(&self) -> &[f64] {
        &self.time
    }

    /// Command, in [`Record::unit`].
    #[must_use]
    pub fn command(&self) -> &[f64] {
        &self.command
    }

    /// Measured position, in [`Record::unit`].
    #[must_use]
    pub fn position(&self) -> &[f64] {
        &self.position
    }

    /// External load, where recorded.
    #[must_use]
    pub fn load(&self) -> Option<&[f64]> {
        self.load.as_deref()
    }

    /// The same record with a different load, or without one.
    #[must_use]
    pub(crate) fn with_load(self, load: Option<Vec<f64>>) -> Self {
        Self { load, ..self }
    }

    /// Whether a position was measured, or inserted for a dropped row.
    #[must_use]
    pub fn is_measured(&self, sample: usize) -> bool {
        self.is_measured.as_ref().is_none_or(|measured| measured[sample])
    }

    /// The measured positions.
    #[must_use]
    pub fn measured_positions(&self) -> Vec<f64> {
        let measured = self.position.iter().enumerate().filter(|(sample, _)| self.is_measured(*sample));
        measured.map(|(_, position)| *position).collect()
    }

    /// With inserted rows: all of its samples and whether the position of each was measured.
    #[must_use]
    pub(crate) fn with_rows_put_in(
        self,
        time: Vec<f64>,
        command: Vec<f64>,
        position: Vec<f64>,
        load: Option<Vec<f64>>,
        is_measured: Vec<bool>,
    ) -> Self {
        Self { time, command, position, load, is_measured: Some(is_measured), ..self }
    }

    /// With some positions marked as not measured and interpolated linearly, and a change of level of this height from this sample on removed.
    #[must_use]
    pub(crate) fn without(mut self, samples: &[usize], level: Option<(usize, f64)>) -> Self {
        if !samples.is_empty() {
            let count = self.len();
            let is_measured = self.is_measured.get_or_insert_with(|| vec![true; count]);
            samples.iter().for_each(|sample| is_measured[*sample] = false);
            bridge(&mut self.position, samples);
        }
        if let Some((from, height)) = level {
            self.position[from..].iter_mut().for_each(|position| *position -= height);
            self.slip_s = Some(self.time[from]);
        }
        self
    }

    /// Time of a sensor slip, if any: its height was removed as accurately as known without a model [s].
    pub(crate) fn slip_s(&self) -> Option<f64> {
        self.slip_s
    }

    /// Unit of command, position and load.
    #[must_use]
    pub fn unit(&self) -> PositionUnit {
        self.unit
    }

    /// Interpolation of the command between samples.
    #[must_use]
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// The same record with a different interpolation of the command.
    #[must_use]
    pub fn with_interpolation(self, interpolation: Interpolation) -> Self {
        Self { interpolation, ..self }
    }

    /// Whether the unit of its times was stated, as opposed to assumed seconds.
    #[must_use]
    pub fn time_unit_declared(&self) -> bool {
        self.time_unit_declared
    }

    /// Deviations of its file from plain CSV, in words.
    #[must_use]
    pub fn understood(&self) -> &[String] {
        &self.understood
    }

    /// The file from which it was read, or its generator.
    #[must_use]
    pub fn source(&self) -> &Path {
        &self.source
    }

    /// SHA-256 of the file, in hexadecimal digits; of the values if there is no file.
    #[must_use]
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Number of samples.
    #[must_use]
    #[allow(clippy::len_without_is_empty)] // a record is never empty
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// From the first sample to the last \[s\].
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.time[self.len() - 1] - self.time[0]
    }

    /// Whether its sampling is even, with the (mean) interval.
    #[must_use]
    pub fn sampling(&self) -> Sampling {
        sampling(&self.time)
    }

    /// The command alone.
    #[must_use]
    pub fn to_command(&self) -> Command {
        Command { time: self.time.clone(), command: self.command.clone() }
    }

    /// The steps from each sample to the next.
    pub fn steps(&self) -> impl Iterator<Item = Step> {
        super::steps(&self.time, &self.command, self.interpolation)
    }

    /// Some of its samples as a separate record.
    ///
    /// # Errors
    /// Too few samples, or a command that does not move in them.
    pub fn part(&self, samples: std::ops::Range<usize>) -> Result<Self> {
        let of = |values: &[f64]| values[samples.clone()].to_vec();
        let command = Command { time: of(&self.time), command: of(&self.command) };
        let mut part = Self::new(command, of(&self.position), self.unit, self.interpolation, &self.source)?;
        part.load = self.load.as_deref().map(of);
        part.is_measured = self.is_measured.as_ref().map(|measured| measured[samples].to_vec());
        part.slip_s = self.slip_s;
        Ok(part)
    }

    /// Some of its samples, with their start time within the record: quantities that depend on the time since its start remain continuous.
    ///
    /// # Errors
    /// As [`Record::part`].
    pub fn stretch(&self, samples: std::ops::Range<usize>) -> Result<Self> {
        let offset_s = self.offset_s + self.time[samples.start] - self.time[0];
        Ok(Self { offset_s, ..self.part(samples)? })
    }

    /// Start time within the record of which it is a stretch \[s\].
    #[must_use]
    pub fn offset_s(&self) -> f64 {
        self.offset_s
    }

    /// The same record with this start time.
    #[must_use]
    pub fn with_offset_s(self, offset_s: f64) -> Self {
        Self { offset_s, ..self }
    }

    /// The same record with the sensor slip of another record at the same times.
    pub(crate) fn slipped_as(self, other: &Self) -> Self {
        Self { slip_s: other.slip_s, ..self }
    }

    /// The same record with different values of the command, one for each sample.
    pub(crate) fn with_command(self, command: Vec<f64>) -> Self {
        Self { command, ..self }
    }

    /// The same record with a different name.
    #[must_use]
    pub fn named(mut self, source: impl Into<PathBuf>) -> Self {
        self.source = source.into();
        self
    }

    /// The same record in another unit of the same kind. Its SHA-256 remains that of its file.
    ///
    /// # Errors
    /// A unit of another kind.
    pub fn in_unit(self, unit: PositionUnit) -> Result<Self> {
        let own = self.unit;
        let source = self.source.clone();
        let converted = |values: Vec<f64>| -> Result<Vec<f64>> {
            values
                .into_iter()
                .map(|value| own.convert(value, unit))
                .collect::<Result<_>>()
                .map_err(|error| error.at(&source, None))
        };
        Ok(Self {
            command: converted(self.command)?,
            position: converted(self.position)?,
            load: self.load.map(converted).transpose()?,
            unit,
            ..self
        })
    }

    /// Time, command and position as CSV.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_csv(&self, to: impl Write) -> std::io::Result<()> {
        write_csv(to, &self.to_command(), &Response { position: self.position.clone(), ..Response::default() })
    }
}

/// Root of the mean square.
#[must_use]
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Values minus their mean.
#[must_use]
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn without_mean(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|value| value - mean).collect()
}
