//! Input and output files of commands.

use std::{
    fs::File,
    io::{BufRead, BufReader, Read},
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use actuator_fmu::{
    error::{Error, Result},
    parameters::{Model, SetName, find},
};
use flate2::bufread::MultiGzDecoder;

use crate::interruption::uninterrupted;
use identification::{
    compare::{Condition, Set},
    inspect::{self, ExpectedGain},
    signal::{
        Command, foreign,
        format::Format,
        record::Record,
        rows::Sample,
        source::{Hashed, Source},
        stream::Stream,
    },
};

/// The model for a user's argument: a set name such as `te-early-unloaded`, or a model file. A model without a name in its file gets the
/// file's name.
///
/// # Errors
/// Neither a set name nor a readable, valid model file.
pub fn read_model(name_or_path: &str) -> Result<Model> {
    let path = Path::new(name_or_path);
    if !path.exists() {
        if name_or_path.ends_with(".toml") || name_or_path.contains(std::path::is_separator) {
            return Err(Error::new("model file", "no such file", "a model file, or the name of a set")
                .remedy("check the path; `actuator sets` lists the names")
                .at(path, None));
        }
        let name: SetName = name_or_path
            .parse()
            .map_err(|error: Error| error.remedy("give one of these names or the path of a model file"))?;
        return Ok(Model::from_set(find(name)?));
    }
    let bytes = read_bytes(path, MODEL_FILE)?;
    refuse_other_files(path, &bytes)?;
    let text = text_of(bytes, path, MODEL_FILE)?;
    let mut model = Model::parse(&text).map_err(|error| error.at(path, None))?;
    if model.identity.name.is_none() {
        model.identity.name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    }
    Ok(model)
}

const MODEL_FILE: &str = "model file";

/// Refuses other files in place of a model file: an FMU, a file that is not text, or a record.
fn refuse_other_files(path: &Path, bytes: &[u8]) -> Result<()> {
    let refuse = |found: &str, remedy: &str| {
        Err(Error::new(MODEL_FILE, found, "a model file, or the name of a set").remedy(remedy).at(path, None))
    };
    if let Some(kind) = foreign::kind_of(bytes) {
        const INSTEAD: &str =
            "give the file that an FMU was made from; `actuator simulate MODEL COMMAND --fmu F.fmu` steps an FMU";
        return refuse(kind, INSTEAD);
    }
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv")) {
        return refuse(
            "a CSV file, as records are",
            "give a model where one is asked for; `actuator fit` makes one of records",
        );
    }
    Ok(())
}

/// The given model in words: a tabulated set, or a file with its hash.
#[must_use]
pub fn describe_model(name_or_path: &str) -> String {
    match model_sha256(Path::new(name_or_path)) {
        Some(sha256) => format!("{name_or_path}, SHA-256 {sha256}"),
        None => format!("{name_or_path}, a tabulated set"),
    }
}

/// SHA-256 of a model file; `None` if it is not a file.
#[must_use]
pub fn model_sha256(path: &Path) -> Option<String> {
    let mut file = Hashed::new(File::open(path).ok()?);
    std::io::copy(&mut file.by_ref().take(LONGEST_TEXT), &mut std::io::sink()).ok()?;
    Some(file.sha256())
}

/// Maximum size of a model file or manifest in bytes: far more than any has, and quickly read if a path leads to an endless device.
const LONGEST_TEXT: u64 = 1 << 26;

/// The text of a TOML file.
///
/// # Errors
/// An unreadable file, one that is not text, one that is too long.
pub fn read_text(path: &Path, what: &str) -> Result<String> {
    text_of(read_bytes(path, what)?, path, what)
}

fn unreadable(found: String, path: &Path, what: &str) -> Error {
    Error::new(what, found, "a readable TOML file").at(path, None)
}

fn read_bytes(path: &Path, what: &str) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|file| file.take(LONGEST_TEXT + 1).read_to_end(&mut bytes));
    read.map_err(|error| unreadable(error.to_string(), path, what))?;
    if bytes.len() as u64 > LONGEST_TEXT {
        return Err(unreadable(format!("more than {} MiB", LONGEST_TEXT >> 20), path, what));
    }
    Ok(bytes)
}

fn text_of(bytes: Vec<u8>, path: &Path, what: &str) -> Result<String> {
    String::from_utf8(bytes).map_err(|error| unreadable(error.utf8_error().to_string(), path, what))
}

/// NAME and FILE of NAME=FILE.
fn named(text: &str) -> Option<(&str, &str)> {
    text.split_once('=').filter(|_| !Path::new(text).exists())
}

/// Where the model of [`read_set`] is looked for.
#[must_use]
pub fn path_of_set(text: &str) -> &Path {
    Path::new(named(text).map_or(text, |(_, file)| file))
}

/// As [`read_model`], with label and condition: a set name, a file with such a name, or NAME=FILE, where NAME may contain other words
/// (`rudder-new-unloaded`).
///
/// # Errors
/// As [`read_model`]; a NAME that is not a condition.
pub fn read_set(text: &str) -> Result<Set> {
    let file = named(text).map_or(text, |(_, file)| file);
    let name = named(text).map(|(name, _)| name.parse::<Condition>()).transpose()?;
    let stem = Path::new(file).file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let label = name.as_ref().map_or_else(|| file.to_owned(), ToString::to_string);
    let condition = name.or_else(|| stem.and_then(|stem| stem.parse().ok()));
    Ok(Set { condition, ..Set::of_model(label, read_model(file)?) })
}

/// Reads a record.
///
/// # Errors
/// An unreadable file; an invalid record ([`Record::from_csv`]).
pub fn read_record(path: &Path, format: &Format) -> Result<Record> {
    Record::from_csv(open(path, "record", Arc::default())?, path, format)
}

/// Opens a record that may exceed memory, to be read in blocks of this many samples.
///
/// # Errors
/// An unreadable file; a column that is not in its header.
pub fn open_stream(path: &Path, format: &Format, block: usize) -> Result<Stream> {
    open_counted(path, format, block, Arc::default())
}

/// As [`open_stream`]; `read` counts the bytes of the file that were read.
///
/// # Errors
/// As [`open_stream`].
pub fn open_counted(path: &Path, format: &Format, block: usize, read: Arc<AtomicU64>) -> Result<Stream> {
    Stream::new(open(path, "record", read)?, path, format, block)
}

/// Number of samples at the beginning of a long record that are inspected.
const JUDGED_SAMPLES: usize = 100_000;

/// As [`inspect::admit`], from the beginning of a record that may exceed memory.
///
/// # Errors
/// A beginning that does not allow an estimate of the response.
pub fn admit_beginning(path: &Path, format: &Format) -> Result<Vec<String>> {
    let mut stream = open_stream(path, format, JUDGED_SAMPLES)?;
    let Some(block) = stream.next_block()? else { return Ok(Vec::new()) };
    let column = |of: fn(&Sample) -> f64| block.iter().map(of).collect::<Vec<f64>>();
    let command = Command { time: column(|sample| sample.time), command: column(|sample| sample.command) };
    let position = column(|sample| sample.position);
    // A beginning at rest gives no information.
    let Ok(beginning) = Record::new(command, position, format.unit, format.interpolation, path) else {
        return Ok(Vec::new());
    };
    inspect::admit(&[&beginning], ExpectedGain::Any)
}

/// Reads a command.
///
/// # Errors
/// An unreadable file; an invalid command ([`Command::from_csv`]).
pub fn read_command(path: &Path, format: &Format) -> Result<Command> {
    Command::from_csv(open(path, "command file", Arc::default())?, path, format)
}

/// Buffer size [bytes].
const BUFFER_BYTES: usize = 1 << 16;

/// First bytes of a gzip file (RFC 1952).
const GZIP: &[u8] = b"\x1f\x8b";

/// Maximum ratio of unpacked to packed size of a record above [`ALWAYS_UNPACKED`]: numbers shrink to a third; a thousandth is the maximum
/// of the format.
const MOST_UNPACKED_RATIO: u64 = 100;

/// Unpacked size that is always accepted [bytes].
const ALWAYS_UNPACKED: u64 = 1 << 24;

/// A file, and the number of its bytes read so far.
struct Counting {
    file: File,
    read: Arc<AtomicU64>,
}

impl Read for Counting {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.file.read(buffer)?;
        self.read.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

/// The text of a gzip file, with the hash of the file.
struct Decompressed {
    decoder: MultiGzDecoder<BufReader<Hashed<Counting>>>,
    /// Remaining allowance of unpacked bytes.
    left: u64,
}

impl Read for Decompressed {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.decoder.read(buffer)?;
        let left = self.left.checked_sub(count as u64).ok_or_else(|| {
            std::io::Error::other(format!(
                "a compressed file that unpacks to more than {MOST_UNPACKED_RATIO} times its size"
            ))
        })?;
        self.left = left;
        Ok(count)
    }
}

impl Source for Decompressed {
    fn sha256(&self) -> String {
        self.decoder.get_ref().sha256()
    }

    fn size(&self) -> Option<u64> {
        None
    }
}

fn open(path: &Path, what: &str, read: Arc<AtomicU64>) -> Result<Box<dyn Source>> {
    let refuse = |found: String| Error::new(what, found, "a readable CSV file").remedy("check the path").at(path, None);
    if path.is_dir() {
        return Err(refuse("a folder".into()));
    }
    let file = File::open(path).map_err(|error| {
        let is_set = path.to_str().is_some_and(|name| name.parse::<SetName>().is_ok());
        let refused = refuse(error.to_string());
        if is_set {
            refused.remedy("that is the name of a set: `--help` says where a model is asked for")
        } else {
            refused
        }
    })?;
    let size = file.metadata().ok().filter(|metadata| metadata.is_file()).map(|metadata| metadata.len());
    let mut reader = BufReader::with_capacity(BUFFER_BYTES, Hashed::new(Counting { file, read }).of_size(size));
    let beginning = reader.fill_buf().map_err(|error| refuse(error.to_string()))?;
    if beginning.starts_with(GZIP) {
        let left = size.unwrap_or(0).saturating_mul(MOST_UNPACKED_RATIO).max(ALWAYS_UNPACKED);
        return Ok(Box::new(Decompressed { decoder: MultiGzDecoder::new(reader), left }));
    }
    Ok(Box::new(reader))
}

/// Writes files into a folder, all or none, each atomically, after checking that none exists when `force` is false.
///
/// # Errors
/// An existing file when `force` is false, and then nothing is written; those of the file system.
pub fn write_folder(folder: &Path, files: &[(String, Vec<u8>)], force: bool) -> Result<()> {
    refuse_file(folder)?;
    if let Some((name, _)) = files.iter().find(|(name, _)| !force && folder.join(name).exists()) {
        return Err(Error::new("output file", "an existing file", "a new or empty folder")
            .remedy("give --force to overwrite, or another folder")
            .at(folder.join(name), None));
    }
    let paths: Vec<_> = files.iter().map(|(name, bytes)| (folder.join(name), bytes.as_slice())).collect();
    write_together(&paths, force)
}

/// Writes files that belong together, all or none, each atomically.
///
/// # Errors
/// An existing file when `force` is false; those of the file system.
pub fn write_together(files: &[(PathBuf, &[u8])], force: bool) -> Result<()> {
    let overwrite = if force { fmu_build::Overwrite::Allow } else { fmu_build::Overwrite::Refuse };
    uninterrupted(|| fmu_build::write_all(files, overwrite).map_err(unwritable))
}

/// Writes a file atomically, so that it is never incomplete.
///
/// # Errors
/// An existing file when `force` is false; those of the file system.
pub fn write_new(path: &Path, bytes: &[u8], force: bool) -> Result<()> {
    uninterrupted(|| write(path, bytes, force))
}

/// The name of a set, or of a model file without its extension.
pub fn stem(model: &str) -> String {
    Path::new(model).file_stem().map_or_else(|| model.to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// Checks before the work that an output file can be written.
///
/// # Errors
/// A folder; a file when `force` is false.
pub fn refuse_existing(path: &Path, force: bool) -> Result<()> {
    if path.is_dir() {
        return Err(Error::new("output file", "a folder", "the name of a file").at(path, None));
    }
    if path.exists() && !force {
        return Err(Error::new("output file", "an existing file", "a new name")
            .remedy("give --force to overwrite it")
            .at(path, None));
    }
    Ok(())
}

/// Checks before the work that a results folder can be created: neither it nor a parent is a file.
///
/// # Errors
/// A file in place of a folder.
pub fn refuse_file(folder: &Path) -> Result<()> {
    match folder.ancestors().find(|path| path.exists()) {
        Some(path) if !path.is_dir() => {
            Err(Error::new("output folder", "a file", "a folder").remedy("give another name").at(path, None))
        }
        _ => Ok(()),
    }
}

fn write(path: &Path, bytes: &[u8], force: bool) -> Result<()> {
    refuse_existing(path, force)?;
    let overwrite = if force { fmu_build::Overwrite::Allow } else { fmu_build::Overwrite::Refuse };
    fmu_build::write(path, bytes, overwrite).map_err(unwritable)
}

#[allow(clippy::needless_pass_by_value)] // signature required by map_err
fn unwritable(error: fmu_build::Error) -> Error {
    let refusal = Error::new("output file", error.to_string(), "a place that can be written to");
    match error {
        fmu_build::Error::Exists { .. } => refusal.remedy("give --force to overwrite a file"),
        _ => refusal.remedy("free the disk, or write elsewhere; what was there before is as it was"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_existing_file_is_kept_unless_forced() {
        let path = std::env::temp_dir().join(format!("actuator-files-{}", std::process::id()));
        write_new(&path, b"one", false).unwrap();
        assert!(write_new(&path, b"two", false).unwrap_err().to_string().contains("--force"));
        assert_eq!(std::fs::read(&path).unwrap(), b"one");
        write_new(&path, b"two", true).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn a_path_that_leads_nowhere_is_no_misspelt_set_name() {
        for path in ["nofile.toml", "models/nofile"] {
            let message = read_model(path).unwrap_err().to_string();
            assert!(message.starts_with(&format!("{path}: model file: found no such file; allowed: ")), "{message}");
        }
        assert!(read_model("nofile").unwrap_err().to_string().contains("us-late-loaded"));
    }

    #[test]
    fn the_combination_without_data_is_refused_with_the_reason_and_the_names() {
        let message = read_model("ls-late-loaded").unwrap_err().to_string();
        assert!(message.contains("no data") && message.contains("ls-late-unloaded"), "{message}");
    }
}
