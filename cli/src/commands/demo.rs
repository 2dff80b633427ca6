//! `actuator demo`

use crate::output;
use std::path::{Path, PathBuf};

use crate::{files, invocation::Invocation, report::diagnosis::files::NAMES};
use actuator_fmu::{
    Result,
    effects::{Effects, find},
    parameters::{Model, Order},
};
use identification::{
    digits::with_unit,
    estimate::{self, Settings},
    generated::TestPoint,
    signal::{
        Interpolation,
        excitation::{Excitation, Kind},
        record::Record,
    },
};

use super::{diagnose, records::FormatArguments};

/// A complete example on generated data: an actuator with hidden play, its records, a fit, a diagnosis, the reduced difference
#[derive(clap::Args)]
#[command(after_help = "Example:\n  actuator demo -o demo   # then open demo/diagnosis/report.html")]
pub struct Arguments {
    /// Folder for records, models and report
    #[arg(short, long, value_name = "DIR", default_value = "actuator-demo")]
    output: PathBuf,
    /// Overwrite files in DIR
    #[arg(long)]
    force: bool,
}

/// The trailing edge, early in the test, unloaded.
const SET: &str = "te-early-unloaded";

/// Hidden play [deg].
const GAP_DEG: f64 = 0.12;

/// Sensor noise, as a fraction of the motion.
const NOISE_SHARE: f64 = 0.01;

/// Seed of excitations and noise.
const SEED: u64 = 208_452;

/// The records: name, excitation and amplitude [deg].
const RECORDS: [(&str, Kind, f64); 3] =
    [("sweep.csv", Kind::Sweep, 4.0), ("random.csv", Kind::Random, 2.0), ("multisine.csv", Kind::Multisine, 3.0)];

pub fn run(arguments: &Arguments, invocation: &Invocation) -> Result<()> {
    let folder = &arguments.output;
    files::refuse_file(folder)?;
    let of_diagnosis = NAMES.map(|name| format!("diagnosis/{name}"));
    let mut written = ["fitted.toml".to_owned()].into_iter().chain(of_diagnosis);
    written.try_for_each(|name| files::refuse_existing(&folder.join(name), arguments.force))?;
    let mut hidden = files::read_model(SET)?;
    if let Some(backlash) = find("backlash") {
        hidden.effects = Effects::default().with(backlash, &[GAP_DEG])?;
    }
    output::print(&format!(
        "1. Three records of {SET} with {GAP_DEG} deg of undisclosed play and {} % of noise (seed {SEED}).\n",
        100.0 * NOISE_SHARE
    ))?;
    let mut written = Vec::new();
    for (index, (name, kind, amplitude)) in RECORDS.into_iter().enumerate() {
        let record = record(&hidden, kind, amplitude, SEED + index as u64, name)?;
        let mut csv = Vec::new();
        // Writing to memory cannot fail.
        let _ = record.write_csv(&mut csv);
        written.push((name.to_owned(), csv));
    }
    files::write_folder(folder, &written, arguments.force)?;
    let path = |name: &str| folder.join(name);
    let format = FormatArguments::default();
    let fitted = [path(RECORDS[0].0), path(RECORDS[1].0)];
    let records =
        fitted.iter().map(|path| files::read_record(path, &format.format())).collect::<Result<Vec<Record>>>()?;
    let settings = Settings { order: estimate::OrderChoice::Second, ..Settings::default() };
    let fit = estimate::fit(&records, &settings)?;
    files::write_new(&path("fitted.toml"), fit.model.to_toml()?.as_bytes(), arguments.force)?;
    let values: Vec<String> = fit
        .estimates
        .iter()
        .map(|estimate| format!("{} {}", estimate.name, with_unit(estimate.value, 4, estimate.unit)))
        .collect();
    output::print(&format!(
        "2. actuator fit: {}; residual {:.4} deg rms, model without play.\n3. actuator diagnose:\n",
        values.join(", "),
        fit.residual_rms
    ))?;
    let arguments = diagnose::Arguments {
        model: text(&path("fitted.toml")),
        fit: fitted.to_vec(),
        reference: Vec::new(),
        time_limit: None,
        check: vec![path(RECORDS[2].0)],
        format,
        output: path("diagnosis"),
        from: None,
        name: None,
        date: None,
        force: arguments.force,
        json: false,
        exit_code: false,
    };
    diagnose::run(&arguments, invocation).map(|_| ())
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

/// One record of the hidden actuator.
fn record(hidden: &Model, kind: Kind, amplitude: f64, seed: u64, name: &str) -> Result<Record> {
    let excitation = Excitation { amplitude, seed, duration_s: Excitation::SHORT_S, ..Excitation::new(kind) };
    let model = Model { order: Order::Third, ..hidden.clone() };
    let point = TestPoint {
        model,
        excitation,
        interpolation: Interpolation::Held,
        noise_share: NOISE_SHARE,
        turbulence: None,
        seed,
    };
    point.record(name)
}
