//! Arguments of all commands that read records.

use std::path::PathBuf;

use crate::files;
use actuator_fmu::Result;
use identification::{
    inspect::{self, ExpectedGain},
    signal::{
        Interpolation,
        format::{Columns, Format, PositionUnit, TimeUnit},
        record::Record,
    },
};

/// Records and how to read them.
#[derive(clap::Args)]
pub struct RecordArguments {
    /// CSV files with the columns `time` [s], `command` and `position`
    #[arg(required = true, value_name = "RECORD.csv")]
    records: Vec<PathBuf>,
    #[command(flatten)]
    format: FormatArguments,
}

/// How to read records.
#[derive(clap::Args, Default)]
pub struct FormatArguments {
    /// Column names if not the default ones, as in `time=t_s,command=cmd_rad,position=pos_rad`, or numbers, as in
    /// `time=1,command=2,position=3`
    #[arg(long, value_name = "ROLE=NAME|NUMBER,...")]
    columns: Option<Columns>,
    /// Unit of command, position and load: rad, deg, mm, m or 1. A model is fitted in it; beside a model in another unit of the same
    /// kind the record is converted
    #[arg(long, default_value_t)]
    unit: PositionUnit,
    /// Unit of the time column: s, ms or us [default: s, and refused where that cannot be]
    #[arg(long, value_name = "UNIT")]
    time_unit: Option<TimeUnit>,
    /// The command is held between samples, as control computers do (default)
    #[arg(long, conflicts_with = "linear")]
    hold: bool,
    /// The command moves linearly between samples
    #[arg(long)]
    linear: bool,
}

impl RecordArguments {
    /// Their paths.
    pub fn paths(&self) -> &[PathBuf] {
        &self.records
    }

    /// Reads them all.
    pub fn read(&self) -> Result<Vec<Record>> {
        self.read_like(&self.records)
    }

    /// Reads them one by one: an unreadable one does not hide the others.
    pub fn read_each(&self) -> Vec<Result<Record>> {
        self.each(&self.records).collect()
    }

    /// Reads them all, and the check records, refuses records that do not allow an estimate, and cuts them at their gaps: fit records,
    /// check records, and warnings.
    pub fn read_admitted(
        &self,
        check: &[PathBuf],
        expected: ExpectedGain,
    ) -> Result<(Vec<Record>, Vec<Record>, Vec<String>)> {
        let (records, others) = (self.read()?, self.read_like(check)?);
        let warnings = inspect::admit(&records.iter().chain(&others).collect::<Vec<&Record>>(), expected)?;
        let segments = |records: Vec<Record>| records.into_iter().flat_map(inspect::segments).collect();
        Ok((segments(records), segments(others), warnings))
    }

    fn read_like(&self, paths: &[PathBuf]) -> Result<Vec<Record>> {
        self.each(paths).collect()
    }

    fn each<'a>(&'a self, paths: &'a [PathBuf]) -> impl Iterator<Item = Result<Record>> + 'a {
        let format = self.format();
        paths.iter().map(move |path| files::read_record(path, &format))
    }

    /// How to read them.
    pub fn format(&self) -> Format {
        self.format.format()
    }
}

impl FormatArguments {
    /// As the format of the reader.
    pub fn format(&self) -> Format {
        Format {
            columns: self.columns.clone().unwrap_or_default(),
            unit: self.unit,
            interpolation: if self.linear { Interpolation::Linear } else { Interpolation::Held },
            time_unit: self.time_unit,
        }
    }
}
