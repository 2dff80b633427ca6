//! `actuator build`

use crate::output;
use std::path::{Path, PathBuf};

use crate::{files, package};
use actuator_fmu::{
    Error, Result,
    fmu::{MODEL_IDENTIFIER, Start, guid},
    parameters::{Model, SetName},
};
use serde::Serialize;

use crate::{
    ssp::system::{self, Component},
    template::{self, refused},
};

/// Package an FMU: the default one, or one for a model
#[derive(clap::Args)]
#[command(
    after_help = "Nothing is compiled: the FMU of a model is a new archive around the binary of the default FMU. That is taken from --from, else \
from the file that the environment variable ACTUATOR_FMU names, else from BactActuator.fmu beside this program, else from where a wheel \
put it (share/actuator-fmu), else from target/fmu of the checkout (`cargo run -p fmu-build` makes it).\n\n\
Examples:\n  actuator build -o BactActuator.fmu\n  actuator build --model us-late-loaded -o us-late-loaded.fmu\n  \
actuator build --model model.toml --from BactActuator.fmu\n  \
actuator build --ssp actuator.ssp --set us-late-loaded    a system (SSP 1.0) around the default FMU, this set applied\n  \
actuator build --ssp wing.ssp --model rudder.toml --model elevator.toml    a system of two actuators"
)]
pub struct Arguments {
    /// Set name (see `actuator sets`) or model file whose values become the start values; with --ssp several, each a component
    #[arg(long, num_args = 1..)]
    model: Vec<String>,
    /// Where to write the FMU [default: BactActuator.fmu, or the name of the set or model file]
    #[arg(short, long, value_name = "F.fmu")]
    output: Option<PathBuf>,
    /// Write a system for tools that speak SSP 1.0 (libcosim, Ecos) instead of an FMU: one component per --model, or the default FMU
    #[arg(long, value_name = "F.ssp", conflicts_with = "output")]
    ssp: Option<PathBuf>,
    /// The set that the system applies to the default FMU, a component of its own beside those of --model [default without --model:
    /// te-early-unloaded]
    #[arg(long, value_name = "SET", requires = "ssp", conflicts_with = "output")]
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
    let name = match arguments.model.as_slice() {
        [] => None,
        [one] => Some(one.as_str()),
        several => {
            return Err(Error::new("--model", format!("{} models", several.len()), "one for an FMU")
                .remedy("give --ssp F.ssp for a system of several, or build one after another"));
        }
    };
    let model = name.map(files::read_model).transpose()?;
    let output = arguments.output.clone().unwrap_or_else(|| default_output(name));
    files::refuse_existing(&output, arguments.force)?;
    let mut archive = template::read(arguments.from.as_deref())?;
    let start = model.as_ref().map_or_else(Start::default, Start::from_model);
    if let Some(model) = &model {
        archive = package::for_model(archive, model)?;
    }
    let bytes = archive.to_bytes().map_err(refused)?;
    files::write_new(&output, &bytes, true)?; // checked above, before the work
    let summary = Summary {
        guid: guid(&start),
        size_bytes: bytes.len(),
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
    components: Vec<ComponentSummary>,
    size_bytes: usize,
}

#[derive(Serialize)]
struct ComponentSummary {
    name: String,
    /// Set name or model file.
    model: String,
    unit: &'static str,
}

/// The set of the FMU's own start values.
const DEFAULT_SET: &str = "te-early-unloaded";

fn system(arguments: &Arguments, path: &Path) -> Result<()> {
    let models: Vec<Model> = arguments.model.iter().map(|name| files::read_model(name)).collect::<Result<_>>()?;
    let set: Option<SetName> = match (&arguments.set, models.as_slice()) {
        (Some(set), _) => Some(set.parse()?),
        (None, []) => Some(DEFAULT_SET.parse()?),
        (None, _) => None,
    };
    files::refuse_existing(path, arguments.force)?;
    let units: Vec<&str> = models.iter().map(|model| model.unit().name()).chain(set.map(|_| "deg")).collect();
    let sources = arguments.model.iter().cloned().chain(set.map(|set| set.to_string()));
    let components: Vec<Component> =
        models.into_iter().map(|model| Component::Model(Box::new(model))).chain(set.map(Component::Set)).collect();
    let bytes =
        system::archive(&template::read(arguments.from.as_deref())?, &components)?.to_bytes().map_err(refused)?;
    files::write_new(path, &bytes, arguments.force)?;
    let names = system::component_names(&components).into_iter().zip(sources).zip(units);
    let summary = SystemSummary {
        ssp: path.to_owned(),
        components: names.map(|((name, model), unit)| ComponentSummary { name, model, unit }).collect(),
        size_bytes: bytes.len(),
    };
    if arguments.json {
        return output::print_json(&summary);
    }
    let components: Vec<String> = summary
        .components
        .iter()
        .map(|ComponentSummary { name, model, unit }| format!("component `{name}` with {model}, positions in {unit}"))
        .collect();
    output::print(&format!("{} ({} bytes): {}\n", path.display(), summary.size_bytes, components.join("; ")))
}

fn default_output(model: Option<&str>) -> PathBuf {
    let stem = model.map_or(MODEL_IDENTIFIER.into(), files::stem);
    PathBuf::from(format!("{stem}.fmu"))
}
