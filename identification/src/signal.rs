//! Signals over time, from and to CSV: commands, records ([`record`], their files [`mod@format`]), records that exceed memory ([`stream`]) and
//! excitations ([`excitation`]).

mod command_file;
pub mod dialect;
pub mod excitation;
pub mod foreign;
pub mod format;
mod header;
pub(crate) mod play;
pub mod record;
mod row_batches;
pub mod rows;
pub mod sampling;
pub mod source;
mod stated_units;
pub mod stream;
pub mod time_stamp;
pub mod utf16;

use std::io::Write;

use actuator_fmu::transition::Ramp;

/// A command over time; the interpolation between samples is specified separately.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Command {
    /// Increasing \[s\].
    pub time: Vec<f64>,
    /// One value per time \[deg\].
    pub command: Vec<f64>,
}

/// Interpolation of a command between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// Held: as from a control computer.
    #[default]
    Held,
    /// Linear.
    Linear,
}

/// One step from sample to sample: the command during it, and its duration \[s\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Time at its start \[s\].
    pub start: f64,
    /// Duration \[s\].
    pub duration: f64,
    /// Command from its start.
    pub command: Ramp,
}

impl Command {
    /// The steps from each sample to the next.
    pub fn steps(&self, interpolation: Interpolation) -> impl Iterator<Item = Step> {
        steps(&self.time, &self.command, interpolation)
    }
}

fn steps(time: &[f64], command: &[f64], interpolation: Interpolation) -> impl Iterator<Item = Step> {
    let samples = time.iter().zip(command);
    samples.clone().zip(samples.skip(1)).map(move |((start, value), (end, next))| {
        let duration = end - start;
        let slope = match interpolation {
            Interpolation::Held => 0.0,
            Interpolation::Linear => (next - value) / duration,
        };
        Step { start: *start, duration, command: Ramp { value: *value, slope } }
    })
}

/// Sampled values delayed by some samples; before the first sample they had its value.
pub fn delayed(values: &[f64], samples: usize) -> impl Iterator<Item = f64> {
    let before = values.first().into_iter().flat_map(move |first| std::iter::repeat_n(*first, samples));
    before.chain(values.iter().copied()).take(values.len())
}

/// The response to a command, at its times. Quantities that a model does not output are empty.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Response {
    /// Measured surface position \[deg\].
    pub position: Vec<f64>,
    /// Surface deflection \[deg\].
    pub deflection: Vec<f64>,
    /// Rate [deg/s].
    pub rate: Vec<f64>,
}

/// Time, command and response as CSV, with the shortest digits that read back to the same numbers.
///
/// # Errors
/// Those of the writer.
pub fn write_csv(to: impl Write, command: &Command, response: &Response) -> std::io::Result<()> {
    let columns = [
        ("time", &command.time),
        ("command", &command.command),
        ("position", &response.position),
        ("deflection", &response.deflection),
        ("rate", &response.rate),
    ];
    let present = || columns.iter().filter(|(_, values)| !values.is_empty());
    let mut writer = csv::Writer::from_writer(to);
    writer.write_record(present().map(|(name, _)| name))?;
    for row in 0..command.time.len() {
        writer.write_record(present().map(|(_, values)| values[row].to_string()))?;
    }
    writer.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delayed_signal_begins_with_its_first_value() {
        let later = |samples| delayed(&[3.0, 1.0, 4.0], samples).collect::<Vec<f64>>();
        assert_eq!([later(0), later(1), later(9)], [[3.0, 1.0, 4.0], [3.0, 3.0, 1.0], [3.0, 3.0, 3.0]]);
        assert_eq!(delayed(&[], 2).count(), 0);
    }
}
