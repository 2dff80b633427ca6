//! Arbitrary files: whatever a file contains, its reader returns, in memory that is a multiple of the file, with a result or with a refusal
//! that names the file, what was found and what is allowed.

mod disturbed;
mod seeds;

use std::{
    fs,
    path::{Path, PathBuf},
};

use actuator_fmu::error::{Error, Result};
use cli::{campaign::Manifest, files, importer::UnpackedFmu, package, template};
use fastrand::Rng;
use identification::signal::format::{Format, TimeUnit};
use peak_alloc::PeakAlloc;
use tempfile::TempDir;

use crate::{host::Host, watchdog};

/// A reader of the program.
pub struct Reader {
    /// Its name.
    pub name: &'static str,
    /// Name of its input files.
    file: &'static str,
    read: fn(&Path, &mut Rng) -> Result<()>,
    seeds: fn() -> Vec<Vec<u8>>,
    /// Maximum memory as a multiple of the file.
    pub most_memory: usize,
}

/// Memory allowed for every reader, however small the file \[bytes\]: buffers, and the size to which a compressed file may always unpack,
/// with the numbers in it.
pub const ALWAYS_TAKEN: usize = 256 << 20;

/// All readers.
pub const READERS: [Reader; 7] = [
    Reader { name: "record", file: "record.csv", read: record, seeds: seeds::records, most_memory: 50 },
    Reader { name: "stream", file: "record.csv", read: stream, seeds: seeds::records, most_memory: 50 },
    Reader { name: "command", file: "command.csv", read: command, seeds: seeds::commands, most_memory: 50 },
    Reader { name: "model", file: "model.toml", read: model, seeds: seeds::models, most_memory: 100 },
    Reader { name: "manifest", file: "manifest.toml", read: manifest, seeds: seeds::manifests, most_memory: 100 },
    Reader { name: "archive", file: "own.fmu", read: archive, seeds: seeds::archives, most_memory: 500 },
    Reader { name: "fmu", file: "foreign.fmu", read: fmu, seeds: seeds::archives, most_memory: 1000 },
];

fn format(rng: &mut Rng) -> Format {
    let time_unit = [None, None, Some(TimeUnit::Second), Some(TimeUnit::Millisecond)][rng.usize(..4)];
    Format { time_unit, ..Format::default() }
}

fn record(path: &Path, rng: &mut Rng) -> Result<()> {
    files::read_record(path, &format(rng)).map(drop)
}

fn stream(path: &Path, rng: &mut Rng) -> Result<()> {
    let mut stream = files::open_stream(path, &format(rng), 50)?;
    while stream.next_block()?.is_some() {}
    Ok(())
}

fn command(path: &Path, _: &mut Rng) -> Result<()> {
    files::read_command(path, &Format::default()).map(drop)
}

/// A model that is read must also be packageable: its start values and its text are generated as well.
fn model(path: &Path, _: &mut Rng) -> Result<()> {
    let model = files::read_model(&path.to_string_lossy())?;
    let _ = actuator_fmu::fmu::guid(&actuator_fmu::fmu::Start::from_model(&model));
    let again = actuator_fmu::parameters::Model::parse(&model.to_toml()?)?;
    if again.base == model.base { Ok(()) } else { Err(Error::new("model", "another one", "the one that was written")) }
}

fn manifest(path: &Path, _: &mut Rng) -> Result<()> {
    Manifest::read(path).map(drop)
}

fn archive(path: &Path, _: &mut Rng) -> Result<()> {
    let model = files::read_model("us-late-loaded")?;
    let packaged = package::for_model(template::read(Some(path))?, &model)?;
    packaged.to_bytes().map(drop).map_err(template::refused)
}

/// Unpacked and described, not loaded: its library is not checked here.
fn fmu(path: &Path, _: &mut Rng) -> Result<()> {
    UnpackedFmu::open(path).map(drop)
}

/// Results of many files.
#[derive(Debug, Default, Clone, Copy)]
pub struct Tally {
    /// Numbers of files read and refused.
    pub read: u64,
    /// See `read`.
    pub refused: u64,
    /// Maximum memory of a file beyond its allowance, and as a multiple of its size above [`ALWAYS_TAKEN`] / 16.
    pub most_memory: usize,
    /// Size of that file.
    pub of_bytes: usize,
}

/// Passes files with these numbers to a reader, each drawn from its number and the seed.
///
/// # Panics
/// If a reader violates its contract; the file is left as `failed` in the temporary folder of the system.
pub fn files(reader: &Reader, allocated: &PeakAlloc, seed: u64, numbers: std::ops::Range<u64>) -> Tally {
    let folder = TempDir::new().expect("a temporary folder");
    let path: PathBuf = folder.path().join(reader.file);
    let seeds = (reader.seeds)();
    let mut tally = Tally::default();
    for number in numbers {
        watchdog::begin(number);
        let mut rng = Rng::with_seed(seed.wrapping_mul(1 << 32).wrapping_add(number));
        let bytes = disturbed::file(&mut rng, &seeds);
        fs::write(&path, &bytes).expect("a file");
        allocated.reset_peak_usage();
        let before = allocated.current_usage();
        let outcome = std::panic::catch_unwind(|| (reader.read)(&path, &mut rng.clone()));
        let taken = allocated.peak_usage().saturating_sub(before);
        let problem = problem(reader, &bytes, taken, outcome.as_ref().ok());
        if let Some(problem) = problem {
            let kept = std::env::temp_dir().join(format!("failed-{}-{number}", reader.name));
            fs::write(&kept, &bytes).expect("a file");
            panic!("{}, file {number} of seed {seed}, kept as {}: {problem}", reader.name, kept.display());
        }
        match outcome {
            Ok(Ok(())) => tally.read += 1,
            _ => tally.refused += 1,
        }
        if taken > tally.most_memory {
            (tally.most_memory, tally.of_bytes) = (taken, bytes.len());
        }
    }
    tally
}

/// Maximum length of a message: repeating the file is of no use.
const LONGEST_MESSAGE: usize = 20_000;

fn problem(reader: &Reader, bytes: &[u8], taken: usize, outcome: Option<&Result<()>>) -> Option<String> {
    if taken > ALWAYS_TAKEN + reader.most_memory * bytes.len() {
        return Some(format!("{taken} bytes of memory for a file of {}", bytes.len()));
    }
    match outcome {
        None => Some("a panic".into()),
        Some(Ok(())) => None,
        Some(Err(error)) => {
            let message = error.to_string();
            let has_place = message.contains(reader.file) || reader.name == "archive";
            let is_whole = message.contains("found ") && message.contains("allowed: ");
            (!has_place || !is_whole || message.len() > LONGEST_MESSAGE).then(|| {
                format!("a message of {} bytes: {}", message.len(), message.chars().take(500).collect::<String>())
            })
        }
    }
}

/// Passes this many resource locations to the C function that reads one, with the GUID of a model that is in none; returns their number.
pub fn locations(host: &Host, seed: u64, numbers: std::ops::Range<u64>) -> u64 {
    let mut rng = Rng::with_seed(seed);
    let count = numbers.end - numbers.start;
    for number in numbers {
        watchdog::begin(number);
        let uri = std::ffi::CString::new(disturbed::location(&mut rng)).unwrap_or_default();
        let component = host.instantiate_with(c"a".as_ptr(), 1, c"{another}".as_ptr(), uri.as_ptr(), true);
        assert!(component.is_null(), "{uri:?}");
        assert!(cfg!(miri) || crate::host::take_messages() == 1, "{uri:?} is refused without a word");
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functions::Functions;

    #[global_allocator]
    static ALLOCATED: PeakAlloc = PeakAlloc;

    #[test]
    fn no_file_breaks_its_reader() {
        for reader in &READERS {
            let tally = files(reader, &ALLOCATED, 208_452, 0..if cfg!(miri) { 3 } else { 500 });
            // Otherwise nothing would be tested.
            assert!(cfg!(miri) || tally.read > 20 && tally.refused > 200, "{}: {tally:?}", reader.name);
        }
    }

    #[test]
    fn no_resource_location_breaks_its_reader() {
        locations(&Host::new(Functions::linked()), 208_452, 0..if cfg!(miri) { 10 } else { 3000 });
    }
}
