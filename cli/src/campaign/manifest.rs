//! The manifest: the records, and the conditions under which they were taken.
//!
//! ```toml
//! [campaign]                     # optional, as is everything in it
//! name = "BACT 1995"
//! method = "likelihood"          # or "report"
//! order = "auto"                 # or 2, 3
//! delay_s = 0.0                  # known delay between command and actuator, or "free"
//! unit = "deg"                   # these three for all records that do not say otherwise
//! time_unit = "s"                # or ms, us
//! hold = true                    # the command is held between samples; false: it moves linearly
//! columns = { command = "cmd" }  # what is not named keeps its default name
//! truth = "truth.toml"           # of generated campaigns
//!
//! [[record]]
//! file = "te-early.csv"          # relative to the manifest
//! surface = "trailing_edge"      # or any word
//! stage = "early"                # or any word
//! load_case = "unloaded"         # or "loaded"
//! mach = 0.0                     # optional
//! dynamic_pressure_psf = 0.0     # optional
//! ```

use std::{
    collections::HashMap,
    ops::Range,
    path::{Path, PathBuf},
};

use serde::Deserialize;
use toml::Spanned;

use actuator_fmu::{
    error::{Error, Result},
    parameters::{LoadCase, read_toml},
};
use identification::{
    compare::Condition,
    estimate::{DelayChoice, Method, OrderChoice, Settings},
    signal::{
        Interpolation,
        format::{Columns, Format, PositionUnit, TimeUnit},
    },
};

/// A campaign as its manifest describes it, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Manifest {
    /// Its name; the manifest's file name by default.
    pub name: String,
    /// Fit settings.
    pub settings: Settings,
    /// Known parameters, if the campaign is generated.
    pub truth: Option<PathBuf>,
    /// At least one.
    pub records: Vec<Entry>,
    /// The text of the manifest.
    pub text: String,
}

/// One record of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Unique; used for the names of its results.
    pub name: String,
    /// Path.
    pub file: PathBuf,
    /// First line of its entry in the manifest.
    pub line: usize,
    /// Test condition.
    pub condition: Condition,
    /// Mach number \[1\].
    pub mach: Option<f64>,
    /// Dynamic pressure \[psf\].
    pub dynamic_pressure_psf: Option<f64>,
    /// Format of the file.
    pub format: Format,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    campaign: Head,
    record: Vec<Spanned<Row>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct Head {
    name: Option<String>,
    method: Option<Spanned<String>>,
    order: Option<Spanned<Word>>,
    delay_s: Option<Spanned<Word>>,
    truth: Option<PathBuf>,
    unit: Option<Spanned<String>>,
    hold: Option<bool>,
    time_unit: Option<Spanned<String>>,
    columns: Option<Names>,
}

/// A number or a word.
#[derive(Deserialize)]
#[serde(untagged)]
enum Word {
    Whole(i64),
    Number(f64),
    Text(String),
}

/// The format settings of a record, or of the campaign for all records.
struct Reading {
    unit: Option<Spanned<String>>,
    hold: Option<bool>,
    time_unit: Option<Spanned<String>>,
    columns: Option<Names>,
}

#[derive(Deserialize, Clone)]
#[serde(deny_unknown_fields)]
struct Names {
    time: Option<String>,
    command: Option<String>,
    position: Option<String>,
    load: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    file: PathBuf,
    name: Option<Spanned<String>>,
    surface: Spanned<String>,
    stage: Spanned<String>,
    load_case: Spanned<String>,
    mach: Option<Spanned<f64>>,
    dynamic_pressure_psf: Option<Spanned<f64>>,
    unit: Option<Spanned<String>>,
    hold: Option<bool>,
    time_unit: Option<Spanned<String>>,
    columns: Option<Names>,
}

const ALLOWED: &str = "[campaign] with name, method, order, delay_s, truth; [[record]] with file, name, surface, stage, load_case, mach, \
dynamic_pressure_psf; unit, time_unit, hold, columns in both";

/// Errors of a record, with keys of the manifest in place of the options of commands that read single records.
pub(super) fn in_its_words(text: &str) -> String {
    let mut text = text.replace("--hold or --linear", "hold = true or false");
    for unit in TimeUnit::ALL.map(TimeUnit::name) {
        text = text.replace(&format!("--time-unit {unit}"), &format!("time_unit = \"{unit}\""));
    }
    while let Some((before, rest)) = text.split_once("--columns ") {
        let length = rest.find([' ', ')', ';']).unwrap_or(rest.len());
        let names = rest[..length].trim_end_matches(',');
        let pairs: Vec<String> = names.split(',').map(|pair| pair.replacen('=', " = \"", 1) + "\"").collect();
        text = format!("{before}columns = {{ {} }}{}", pairs.join(", "), &rest[names.len()..]);
    }
    text
}

impl Manifest {
    /// The conditions of the records, in order of occurrence.
    #[must_use]
    pub fn conditions(&self) -> Vec<&Condition> {
        self.records.iter().map(|entry| &entry.condition).fold(Vec::new(), |mut conditions, condition| {
            if !conditions.contains(&condition) {
                conditions.push(condition);
            }
            conditions
        })
    }

    /// Reads a manifest.
    ///
    /// # Errors
    /// An unreadable file, a missing or unknown key, a value that is not allowed, no record, two records with one name; each with its line.
    pub fn read(path: &Path) -> Result<Self> {
        let text = crate::files::read_text(path, "manifest")?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let stem = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        Parser { text: &text, path }.manifest(folder, stem)
    }
}

struct Parser<'a> {
    text: &'a str,
    path: &'a Path,
}

impl Parser<'_> {
    fn line(&self, place: &Range<usize>) -> usize {
        1 + self.text.bytes().take(place.start).filter(|byte| *byte == b'\n').count()
    }

    fn at(&self, place: &Range<usize>) -> impl Fn(Error) -> Error {
        let line = self.line(place);
        move |error| error.at(self.path, Some(line))
    }

    fn manifest(&self, folder: &Path, stem: String) -> Result<Manifest> {
        let file: File = read_toml(self.text, "manifest", ALLOWED).map_err(|error| error.at(self.path, None))?;
        let head = &file.campaign;
        if file.record.is_empty() {
            return Err(Error::new("records", "none", "one [[record]] or more").at(self.path, None));
        }
        let common = self.format(&head.reading(), &Format::default())?;
        let mut records: Vec<Entry> = Vec::with_capacity(file.record.len());
        let mut lines: HashMap<String, usize> = HashMap::new();
        for row in &file.record {
            let entry = self.entry(row, folder, &common)?;
            if let Some(before) = lines.insert(entry.name.clone(), entry.line) {
                return Err(Error::new(
                    "name of a record",
                    format!("`{}`, as in line {before}", entry.name),
                    "different names",
                )
                .remedy("give one of them a `name`")
                .at(self.path, Some(entry.line)));
            }
            records.push(entry);
        }
        let name = head.name.clone().unwrap_or(stem);
        let truth = head.truth.as_ref().map(|truth| folder.join(truth));
        Ok(Manifest { name, settings: self.settings(head)?, truth, records, text: self.text.to_owned() })
    }

    fn settings(&self, head: &Head) -> Result<Settings> {
        let mut settings = Settings::default();
        if let Some(method) = &head.method {
            settings.method = match method.get_ref().as_str() {
                "likelihood" => Method::Likelihood,
                "report" => Method::Report,
                other => {
                    return Err(self.at(&method.span())(Error::new(
                        "method",
                        format!("`{other}`"),
                        "likelihood or report",
                    )));
                }
            };
        }
        if let Some(order) = &head.order {
            settings.order = match order.get_ref() {
                Word::Whole(2) => OrderChoice::Second,
                Word::Whole(3) => OrderChoice::Third,
                Word::Text(text) if text == "auto" => OrderChoice::Auto,
                other => return Err(self.at(&order.span())(Error::new("order", other.text(), "2, 3 or \"auto\""))),
            };
        }
        if let Some(delay) = &head.delay_s {
            let refuse =
                |found: String| self.at(&delay.span())(Error::new("delay_s", found, "seconds from 0 on, or \"free\""));
            settings.delay = match delay.get_ref() {
                Word::Text(text) if text == "free" => DelayChoice::Free,
                Word::Whole(0) => DelayChoice::Declared(0.0),
                Word::Number(seconds) if *seconds >= 0.0 && seconds.is_finite() => DelayChoice::Declared(*seconds),
                other => return Err(refuse(other.text())),
            };
        }
        Ok(settings)
    }

    fn entry(&self, row: &Spanned<Row>, folder: &Path, common: &Format) -> Result<Entry> {
        let line = self.line(&row.span());
        let row = row.get_ref();
        let load_case = LoadCase::ALL.iter().find(|load_case| load_case.name() == row.load_case.get_ref());
        let load_case = load_case.ok_or_else(|| {
            let error = Error::new("load_case", format!("`{}`", row.load_case.get_ref()), "unloaded or loaded");
            self.at(&row.load_case.span())(error)
        })?;
        let place = row.surface.span();
        let condition =
            Condition::new(row.surface.get_ref(), row.stage.get_ref(), *load_case).map_err(self.at(&place))?;
        let not_negative = |what: &str, value: &Option<Spanned<f64>>| match value {
            Some(value) if !(value.get_ref().is_finite() && *value.get_ref() >= 0.0) => {
                Err(self.at(&value.span())(Error::new(what, value.get_ref().to_string(), "a finite number from 0 on")))
            }
            _ => Ok(value.as_ref().map(|value| *value.get_ref())),
        };
        let name = match &row.name {
            Some(name) => name.get_ref().clone(),
            None => {
                let file = row.file.with_extension("");
                let own = if file.is_absolute() { file.file_name().map_or(file.as_path(), Path::new) } else { &file };
                own.to_string_lossy().replace(['/', '\\'], "_")
            }
        };
        let allowed = |letter: char| letter.is_alphanumeric() || "-_.+ ".contains(letter);
        if name.is_empty() || name.starts_with('.') || !name.chars().all(allowed) {
            return Err(Error::new("name of a record", format!("`{name}`"), "letters, digits, spaces and - _ . +")
                .remedy("give it a `name`")
                .at(self.path, Some(line)));
        }
        Ok(Entry {
            name,
            file: folder.join(&row.file),
            line,
            condition,
            mach: not_negative("mach", &row.mach)?,
            dynamic_pressure_psf: not_negative("dynamic_pressure_psf", &row.dynamic_pressure_psf)?,
            format: self.format(&row.reading(), common)?,
        })
    }

    fn format(&self, own: &Reading, common: &Format) -> Result<Format> {
        let mut format = common.clone();
        if let Some(unit) = &own.unit {
            format.unit = unit.get_ref().parse::<PositionUnit>().map_err(self.at(&unit.span()))?;
        }
        if let Some(unit) = &own.time_unit {
            format.time_unit = Some(unit.get_ref().parse::<TimeUnit>().map_err(self.at(&unit.span()))?);
        }
        if let Some(hold) = own.hold {
            format.interpolation = if hold { Interpolation::Held } else { Interpolation::Linear };
        }
        if let Some(names) = &own.columns {
            let set = |to: &mut String, name: &Option<String>| {
                if let Some(name) = name {
                    to.clone_from(name);
                }
            };
            let Columns { time, command, position, load } = &mut format.columns;
            set(time, &names.time);
            set(command, &names.command);
            set(position, &names.position);
            if names.load.is_some() {
                load.clone_from(&names.load);
            }
        }
        Ok(format)
    }
}

impl Head {
    fn reading(&self) -> Reading {
        Reading {
            unit: self.unit.clone(),
            hold: self.hold,
            time_unit: self.time_unit.clone(),
            columns: self.columns.clone(),
        }
    }
}

impl Row {
    fn reading(&self) -> Reading {
        Reading {
            unit: self.unit.clone(),
            hold: self.hold,
            time_unit: self.time_unit.clone(),
            columns: self.columns.clone(),
        }
    }
}

impl Word {
    fn text(&self) -> String {
        match self {
            Self::Whole(value) => value.to_string(),
            Self::Number(value) => value.to_string(),
            Self::Text(value) => format!("`{value}`"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::in_its_words;

    #[test]
    fn options_become_keys() {
        for (said, expected) in [
            (
                "give --time-unit ms, or --time-unit s if it is",
                "give time_unit = \"ms\", or time_unit = \"s\" if it is",
            ),
            ("with --columns load=NAME, or by its number", "with columns = { load = \"NAME\" }, or by its number"),
            ("numbers: --columns time=1,command=2", "numbers: columns = { time = \"1\", command = \"2\" }"),
            (
                "exchanged (--columns command=...,position=...) or",
                "exchanged (columns = { command = \"...\", position = \"...\" }) or",
            ),
            ("nothing of the kind", "nothing of the kind"),
        ] {
            assert_eq!(in_its_words(said), expected);
        }
    }
}
