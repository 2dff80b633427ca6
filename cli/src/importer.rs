//! Steps any FMU 2.0 for co-simulation through a command, as an importer does (crate `fmi-rs`).

use std::{
    collections::BTreeMap,
    fs::{create_dir_all, write},
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
};

use fmi_rs::{
    fmi2::{CS, FMU2, log::Logger, types::fmi2Status},
    model_description::fmi2::{ModelDescription, VariableType},
};

use actuator_fmu::{
    effects::Effects,
    error::{Error, Result},
    fmu::Settings,
    parameters::{Base, Model, PositionUnit},
};
use fmu_build::{Archive, Platform, archive::MODEL_DESCRIPTION};
use identification::signal::{Command, Interpolation, Response};
use tempfile::TempDir;

use crate::interruption::uninterrupted;

/// Messages of the FMU, for our own error messages.
#[derive(Default)]
struct Messages(Mutex<Vec<String>>);

impl Messages {
    fn joined(&self) -> String {
        self.0.lock().map(|messages| messages.join("; ")).unwrap_or_default()
    }
}

impl Logger for Messages {
    fn log_call(&self, _status: fmi2Status, _message: &str) {}

    fn log_message(&self, _status: fmi2Status, _category: &str, message: &str) {
        if let Ok(mut messages) = self.0.lock() {
            messages.push(message.to_owned());
        }
    }
}

/// An instance in step mode.
struct Session {
    fmu: Arc<FMU2<CS>>,
    messages: Arc<Messages>,
}

impl Session {
    fn expect(&self, what: &str, status: fmi2Status) -> Result<()> {
        if matches!(status, fmi2Status::Ok | fmi2Status::Warning) {
            return Ok(());
        }
        Err(Error::new(format!("FMU, {what}"), format!("{status:?} {}", self.messages.joined()), "fmi2OK"))
    }
}

/// Response of an FMU to a command.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// Its outputs `position` and, if present, `deflection` and `rate`.
    pub response: Response,
    /// Number of parameters of the model that the FMU has and that were set.
    pub parameters_set: usize,
}

/// Steps the FMU through the command, with the model's parameters set if the FMU has them.
///
/// # Errors
/// Not an FMU 2.0 for co-simulation with an input `command` and an output `position`; any call that it refuses.
pub fn simulate(path: &Path, model: &Model, command: &Command, interpolation: Interpolation) -> Result<Imported> {
    UnpackedFmu::open(path)?.run(Some(model), &Drive { command, interpolation, load: None, starts: &[] })
}

/// As [`simulate`], with the FMU's own start values.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_as_it_is(path: &Path, command: &Command, interpolation: Interpolation) -> Result<Response> {
    UnpackedFmu::open(path)?.respond(&Drive { command, interpolation, load: None, starts: &[] })
}

/// Unit of the output `position` of an FMU, if its description names a position unit of this program.
///
/// # Errors
/// Not an FMU 2.0.
pub fn position_unit(path: &Path) -> Result<Option<PositionUnit>> {
    let unit = UnpackedFmu::open(path)?;
    let variables = &unit.description.modelVariables;
    let position = variables.iter().find(|variable| variable.name == "position");
    Ok(position.and_then(|variable| match &variable.variableType {
        VariableType::Real { unit, .. } => unit.as_ref()?.parse().ok(),
        _ => None,
    }))
}

/// Inputs of an FMU.
#[derive(Debug, Clone, Copy)]
pub struct Drive<'a> {
    /// The command, for the input `command`.
    pub command: &'a Command,
    /// Interpolation between its samples.
    pub interpolation: Interpolation,
    /// For the input `load`, one value per sample.
    pub load: Option<&'a [f64]>,
    /// Start values other than those of the FMU.
    pub starts: &'a [(&'a str, f64)],
}

/// An unpacked FMU, to be stepped several times.
pub struct UnpackedFmu {
    folder: TempDir,
    description: ModelDescription,
    /// Subfolders of `binaries`, if any.
    platforms: Vec<String>,
    path: PathBuf,
}

impl UnpackedFmu {
    /// Unpacks it into a separate folder: names that lead out of it, links and archives that unpack to far more than their size are refused
    /// before anything is written.
    ///
    /// # Errors
    /// Not an FMU 2.0.
    pub fn open(path: &Path) -> Result<Self> {
        let refuse = |error: String| refuse(path, error);
        let archive = Archive::read(path).map_err(|error| match error {
            fmu_build::Error::Read { cause, .. } => {
                refuse(cause.to_string()).remedy("check that it exists and that you may read it")
            }
            other => refuse(other.to_string()),
        })?;
        // An interrupted run would otherwise recreate the folder after its removal.
        let folder = uninterrupted(|| unpack(&archive)).map_err(refuse)?;
        let entries = archive.entries().filter_map(|(name, _)| name.strip_prefix("binaries/")?.split_once('/'));
        let mut platforms: Vec<String> = entries.map(|(platform, _)| platform.to_owned()).collect();
        platforms.dedup();
        let description = ModelDescription::from_path(&folder.path().join(MODEL_DESCRIPTION))
            .map_err(|error| refuse(format!("{MODEL_DESCRIPTION}: {error}")))?;
        Ok(Self { folder, description, platforms, path: path.to_owned() })
    }

    /// The identifier that names its library, if there is one for this computer.
    fn checked_identifier<'a>(&self, identifier: &'a str) -> Result<&'a str> {
        let is_word = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
        if identifier.is_empty() || !identifier.chars().all(is_word) {
            // It becomes the name of a file.
            return Err(refuse(&self.path, format!("modelIdentifier `{identifier}`, which is no name of C")));
        }
        // Importers on Macs use two folders.
        let Some(own) = Platform::host().ok().filter(|own| *own != Platform::Darwin64) else { return Ok(identifier) };
        let entry = own.entry(identifier);
        if self.folder.path().join(&entry).is_file() {
            return Ok(identifier);
        }
        let has = if self.platforms.is_empty() { "none".to_owned() } else { self.platforms.join(", ") };
        Err(refuse(&self.path, format!("no {entry}; binaries of this FMU: {has}")))
    }

    /// Steps a new instance.
    ///
    /// # Errors
    /// As [`simulate`].
    pub fn respond(&self, drive: &Drive<'_>) -> Result<Response> {
        self.run(None, drive).map(|imported| imported.response)
    }

    fn run(&self, model: Option<&Model>, drive: &Drive<'_>) -> Result<Imported> {
        let Drive { command, interpolation, load, starts } = *drive;
        let refuse = |error: String| refuse(&self.path, error);
        if interpolation == Interpolation::Linear {
            return Err(Error::new("command of an FMU", "linear between samples", "held between samples").remedy(
                "sample the command more finely; the importer (crate fmi-rs 0.3) cannot set input derivatives",
            ));
        }
        let description = &self.description;
        let Some(interface) = &description.coSimulation else {
            return Err(refuse("no co-simulation interface".into()));
        };
        let reference = |name: &str| {
            description
                .modelVariables
                .iter()
                .find(|variable| variable.name == name)
                .map(|variable| variable.valueReference)
        };
        let input = reference("command").ok_or_else(|| refuse("no variable `command`".into()))?;
        let position = reference("position").ok_or_else(|| refuse("no variable `position`".into()))?;
        let outputs: Vec<u32> =
            [Some(position), reference("deflection"), reference("rate")].into_iter().flatten().collect();

        let messages = Arc::new(Messages::default());
        let fmu = FMU2::<CS>::new(
            self.folder.path(),
            self.checked_identifier(&interface.modelIdentifier)?,
            "actuator",
            &description.guid,
            false,
            false,
            false,
            messages.clone(),
            !interface.canNotUseMemoryManagementFunctions,
        )
        .map_err(|error| refuse(format!("{error} {}", messages.joined()).trim_end().to_owned()))?;
        let session = Session { fmu, messages };
        let fmu = &session.fmu;
        let start = command.time[0];
        session.expect("setupExperiment", fmu.setupExperiment(None, start, None))?;
        let parameters_set = model.map_or(Ok(0), |model| set_parameters(&session, description, model))?;
        for (name, value) in starts {
            let reference = reference(name).ok_or_else(|| refuse(format!("no variable `{name}`")))?;
            session.expect(&format!("set `{name}`"), fmu.setReal(&[reference], &[*value]))?;
        }
        let loads = load.and_then(|load| Some((reference("load")?, load)));
        session.expect("enterInitializationMode", fmu.enterInitializationMode())?;
        session.expect("set `command`", fmu.setReal(&[input], &[command.command[0]]))?;
        session.expect("exitInitializationMode", fmu.exitInitializationMode())?;

        let mut columns = vec![Vec::with_capacity(command.time.len()); outputs.len()];
        let mut values = vec![0.0; outputs.len()];
        let mut read = || -> Result<()> {
            session.expect("get outputs", fmu.getReal(&outputs, &mut values))?;
            columns.iter_mut().zip(&values).for_each(|(column, value)| column.push(*value));
            Ok(())
        };
        read()?;
        for (index, step) in command.steps(interpolation).enumerate() {
            session.expect("set `command`", fmu.setReal(&[input], &[step.command.value]))?;
            if let Some((reference, load)) = &loads {
                session.expect("set `load`", fmu.setReal(&[*reference], &[load[index]]))?;
            }
            session.expect("doStep", fmu.doStep(step.start, step.duration, 1))?;
            read()?;
        }
        session.expect("terminate", fmu.terminate())?;
        let mut columns = columns.into_iter();
        let mut next = |present: bool| if present { columns.next().unwrap_or_default() } else { Vec::new() };
        let response = Response {
            position: next(true),
            deflection: next(reference("deflection").is_some()),
            rate: next(reference("rate").is_some()),
        };
        Ok(Imported { response, parameters_set })
    }
}

/// The files of an archive, in a separate temporary folder.
fn unpack(archive: &Archive) -> std::result::Result<TempDir, String> {
    let folder = tempfile::tempdir().map_err(|error| format!("no temporary folder: {error}"))?;
    for (name, bytes) in archive.entries() {
        let file = folder.path().join(name);
        let written = file.parent().map_or(Ok(()), create_dir_all).and_then(|()| write(&file, bytes));
        written.map_err(|error| format!("`{name}` cannot be unpacked: {error}"))?;
    }
    Ok(folder)
}

fn refuse(path: &Path, error: String) -> Error {
    Error::new("FMU", error, "an FMI 2.0 co-simulation unit").at(path, None)
}

/// Sets `source`, `order`, `custom.*` and the parameters of effects if the FMU has them; returns how many it has.
fn set_parameters(session: &Session, description: &ModelDescription, model: &Model) -> Result<usize> {
    let settings = Settings::from_model(model);
    let custom = Base::PARAMETERS.iter().map(|parameter| format!("custom.{}", parameter.name)).zip(settings.custom);
    let effects = Effects::parameters().map(|(effect, parameter)| format!("{}.{}", effect.name, parameter.name));
    let reals: BTreeMap<String, f64> = custom.chain(effects.zip(settings.effects)).collect();
    let mut count = 0;
    for variable in &description.modelVariables {
        let references = [variable.valueReference];
        let status = match (&variable.variableType, variable.name.as_str()) {
            (VariableType::Enumeration { .. }, "source") => session.fmu.setInteger(&references, &[settings.source]),
            (VariableType::Enumeration { .. }, "order") => session.fmu.setInteger(&references, &[settings.order]),
            (VariableType::Real { .. }, name) => match reals.get(name) {
                Some(value) => session.fmu.setReal(&references, &[*value]),
                None => continue,
            },
            _ => continue,
        };
        session.expect(&format!("set `{}`", variable.name), status)?;
        count += 1;
    }
    Ok(count)
}
