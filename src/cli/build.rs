//! `actuator build`

use std::path::{Path, PathBuf};

use actuator_fmu::{
    Error, Result, files,
    fmu::{MODEL_IDENTIFIER, Settings, guid},
    package,
};
use fmu_build::{Archive, Overwrite};
use serde::Serialize;

use super::template::{default_fmu, failed};

/// Package an FMU: the default one, or one for a model
#[derive(clap::Args)]
#[command(
    after_help = "In a source checkout the binary is compiled if it is not up to date; elsewhere it is taken from \
the default FMU beside this program. A model needs no compiler: it is a new archive around the same binary.\n\n\
Examples:\n  actuator build -o BactActuator.fmu\n  actuator build --model us-late-loaded -o us-late-loaded.fmu\n  \
actuator build --model model.toml --from BactActuator.fmu"
)]
pub struct Arguments {
    /// Set name (see `actuator sets`) or model file whose values become the start values
    #[arg(long)]
    model: Option<String>,
    /// Where to write the FMU [default: BactActuator.fmu, or the model's name]
    #[arg(short, long, value_name = "F.fmu")]
    output: Option<PathBuf>,
    /// Take the binary from this FMU
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
    let model = arguments.model.as_deref().map(files::read_model).transpose()?;
    let output = arguments.output.clone().unwrap_or_else(|| default_output(arguments.model.as_deref()));
    if output.exists() && !arguments.force {
        return Err(Error::new("output file", "an existing file", "a new name")
            .remedy("give --force to overwrite it")
            .at(output, None));
    }
    let template = match &arguments.from {
        Some(path) => path.clone(),
        None => default_fmu()?,
    };
    let mut archive = Archive::read(&template).map_err(failed)?;
    let start = model.as_ref().map_or_else(Settings::default, Settings::from_model);
    if let Some(model) = &model {
        archive = package::for_model(archive, model)?;
    }
    archive.write(&output, Overwrite::Allow).map_err(failed)?;
    let summary = Summary {
        guid: guid(&start),
        size_bytes: archive.to_bytes().map_err(failed)?.len(),
        entries: archive.names().map(str::to_owned).collect(),
        fmu: output,
    };
    if arguments.json {
        return super::print_json(&summary);
    }
    super::print(&format!("{} ({} bytes, GUID {})\n", summary.fmu.display(), summary.size_bytes, summary.guid))
}

fn default_output(model: Option<&str>) -> PathBuf {
    let stem = model
        .map(Path::new)
        .and_then(Path::file_stem)
        .map_or(MODEL_IDENTIFIER.into(), |stem| stem.to_string_lossy().into_owned());
    PathBuf::from(format!("{stem}.fmu"))
}
