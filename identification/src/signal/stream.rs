//! A record in blocks, for files that exceed memory: read once, with constant memory.

use std::path::{Path, PathBuf};

use super::{
    Interpolation,
    format::Format,
    rows::{Rows, Sample},
    sampling::{EVEN_SHARE, Sampling, sampling},
    source::Source,
};
use actuator_fmu::error::Result;

/// Reads a record file in blocks of samples.
pub struct Stream {
    rows: Rows,
    path: PathBuf,
    interpolation: Interpolation,
    block: Vec<Sample>,
    length: usize,
    times: Times,
}

/// Statistics of the times of all blocks.
#[derive(Default)]
struct Times {
    first: Option<f64>,
    last: f64,
    count: usize,
    /// Minimum and maximum interval of a block [s].
    intervals: Option<[f64; 2]>,
    uneven: bool,
}

impl Stream {
    /// Default number of samples in a block.
    pub const BLOCK: usize = 4096;

    /// Reads `text`, named `path` in errors; blocks have `length` samples, the last one the remainder.
    ///
    /// # Errors
    /// An unreadable file; a column that is not in its header.
    pub fn new(text: Box<dyn Source>, path: &Path, format: &Format, length: usize) -> Result<Self> {
        Ok(Self {
            rows: Rows::new(text, path, format)?,
            path: path.to_owned(),
            interpolation: format.interpolation,
            block: Vec::with_capacity(length),
            length: length.max(2),
            times: Times::default(),
        })
    }

    /// The next block; `None` at the end.
    ///
    /// # Errors
    /// As for [`Record::from_csv`](super::record::Record::from_csv); those that concern the file as a whole (too few samples, a command
    /// that never moves) with its last block.
    pub fn next_block(&mut self) -> Result<Option<&[Sample]>> {
        self.block.clear();
        while self.block.len() < self.length {
            match self.rows.next_sample()? {
                Some(sample) => self.block.push(sample),
                None => break,
            }
        }
        self.times.take(&self.block);
        Ok(if self.block.is_empty() { None } else { Some(&self.block) })
    }

    /// Sampling of the blocks read so far: even if each block is and all have one interval.
    #[must_use]
    pub fn sampling(&self) -> Sampling {
        self.times.sampling()
    }

    /// Interpolation of the command between samples.
    #[must_use]
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// The file.
    #[must_use]
    pub fn source(&self) -> &Path {
        &self.path
    }

    /// SHA-256 of the file, after the last block.
    #[must_use]
    pub fn sha256(&self) -> &str {
        self.rows.sha256()
    }
}

impl Times {
    fn take(&mut self, block: &[Sample]) {
        let (Some(first), Some(last)) = (block.first(), block.last()) else { return };
        // With the last sample of the previous block, so that a gap between them is detected.
        let before = self.first.map(|_| self.last);
        let times: Vec<f64> = before.into_iter().chain(block.iter().map(|sample| sample.time)).collect();
        self.first.get_or_insert(first.time);
        self.last = last.time;
        self.count += block.len();
        if times.len() < 2 {
            return;
        }
        match sampling(&times) {
            Sampling::Uneven(_) => self.uneven = true,
            Sampling::Even(interval) => {
                let [least, greatest] = self.intervals.unwrap_or([interval; 2]);
                self.intervals = Some([least.min(interval), greatest.max(interval)]);
            }
        }
    }

    #[allow(clippy::cast_precision_loss)] // counts of samples
    fn sampling(&self) -> Sampling {
        let mean = (self.last - self.first.unwrap_or(0.0)) / self.count.saturating_sub(1).max(1) as f64;
        match self.intervals {
            Some([least, greatest]) if !self.uneven && greatest - least < EVEN_SHARE * mean => Sampling::Even(mean),
            _ => Sampling::Uneven(mean),
        }
    }
}
