//! `actuator build`

use crate::output;
use std::path::{Path, PathBuf};

use crate::{files, package, ssp};
use actuator_fmu::{
    Error, Result,
    fmu::{MODEL_IDENTIFIER, Settings, guid},
    parameters::SetName,
};
use fmu_build::Overwrite;
use serde::Serialize;

use crate::template::{self, refused};

/// Package an FMU: the default one, or one for a model
#[derive(clap::Args)]
#[command(
    after_help = "Nothing is compiled: the FMU of a model is a new archive around the binary of the default FMU. That is taken from --from, else \
from the file that the environment variable ACTUATOR_FMU names, else from BactActuator.fmu beside this program, else from target/fmu of \
the checkout (`cargo run -p fmu-build` makes it).\n\n\
Examples:\n  actuator build -o BactActuator.fmu\n  actuator build --model us-late-loaded -o us-late-loaded.fmu\n  \
actuator build --model model.toml --from BactActuator.fmu\n  \
actuator build --ssp actuator.ssp --set us-late-loaded    a system (SSP 1.0) around the default FMU, this set applied"
)]
pub struct Arguments {
    /// Set name (see `actuator sets`) or model file whose values become the start values
    #[arg(long)]
    model: Option<String>,
    /// Where to write the FMU [default: BactActuator.fmu, or the model's name]
    #[arg(short, long, value_name = "F.fmu")]
    output: Option<PathBuf>,
    /// Write a system of one component for tools that speak SSP 1.0 (libcosim, Ecos) instead of an FMU
    #[arg(long, value_name = "F.ssp", conflicts_with_all = ["model", "output"])]
    ssp: Option<PathBuf>,
    /// The set that the system applies [default: te-early-unloaded]
    #[arg(long, value_name = "SET", requires = "ssp")]
    set: Option<String>,
    /// Take the binary from this FMU [default: ACTUATOR_FMU, beside the program, or target/fmu]
    #[arg(long, value_name = "F.fmu")]
    from: Option<PathBuf>,
    /// Overwrite the output
    #[arg(long)]
    force: bool,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Summary {
    fmu: PathBuf,
    guid: String,
    size_bytes: usize,
    entries: Vec<String>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    if let Some(path) = &arguments.ssp {
        return system(arguments, path);
    }
    let model = arguments.model.as_deref().map(files::read_model).transpose()?;
    let output = arguments.output.clone().unwrap_or_else(|| default_output(arguments.model.as_deref()));
    if output.exists() && !arguments.force {
        return Err(exists(&output));
    }
    let mut archive = template::read(arguments.from.as_deref())?;
    let start = model.as_ref().map_or_else(Settings::default, Settings::from_model);
    if let Some(model) = &model {
        archive = package::for_model(archive, model)?;
    }
    archive.write(&output, Overwrite::Allow).map_err(refused)?;
    let summary = Summary {
        guid: guid(&start),
        size_bytes: archive.to_bytes().map_err(refused)?.len(),
        entries: archive.names().map(str::to_owned).collect(),
        fmu: output,
    };
    if arguments.json {
        return output::print_json(&summary);
    }
    output::print(&format!("{} ({} bytes, GUID {})\n", summary.fmu.display(), summary.size_bytes, summary.guid))
}

#[derive(Serialize)]
struct SystemSummary {
    ssp: PathBuf,
    component: &'static str,
    set: String,
    size_bytes: usize,
}

/// The set of the FMU's own start values.
const DEFAULT_SET: &str = "te-early-unloaded";

fn system(arguments: &Arguments, path: &Path) -> Result<()> {
    let set: SetName = arguments.set.as_deref().unwrap_or(DEFAULT_SET).parse()?;
    if path.exists() && !arguments.force {
        return Err(exists(path));
    }
    let bytes = ssp::archive(&template::read(arguments.from.as_deref())?, set)?.to_bytes().map_err(refused)?;
    files::write_new(path, &bytes, arguments.force)?;
    let summary = SystemSummary {
        ssp: path.to_owned(),
        component: ssp::COMPONENT,
        set: set.to_string(),
        size_bytes: bytes.len(),
    };
    if arguments.json {
        return output::print_json(&summary);
    }
    let SystemSummary { component, set, size_bytes, .. } = &summary;
    output::print(&format!("{} ({size_bytes} bytes): component `{component}` with {set}\n", path.display()))
}

/// Before the work.
fn exists(path: &Path) -> Error {
    Error::new("output file", "an existing file", "a new name").remedy("give --force to overwrite it").at(path, None)
}

fn default_output(model: Option<&str>) -> PathBuf {
    let stem = model
        .map(Path::new)
        .and_then(Path::file_stem)
        .map_or(MODEL_IDENTIFIER.into(), |stem| stem.to_string_lossy().into_owned());
    PathBuf::from(format!("{stem}.fmu"))
}
