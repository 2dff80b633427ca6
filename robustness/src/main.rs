//! The program `robustness`: long runs of the tests that `./test` runs for seconds.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    time::{Duration, Instant},
};

use clap::{Parser, Subcommand};
use libloading::Library;
use peak_alloc::PeakAlloc;
use robustness::{
    calls::{self, Tally},
    functions::{self, Functions},
    host::Host,
    many, memory,
    readers::{self, READERS},
    watchdog,
};

#[global_allocator]
static ALLOCATED: PeakAlloc = PeakAlloc;

/// Random calls, files and lives, from a seed
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    run: Run,
    /// Where random numbers begin
    #[arg(long, default_value_t = 208_452, global = true)]
    seed: u64,
    /// Number of the first life or file, to repeat one that failed
    #[arg(long, default_value_t = 0, global = true)]
    from: u64,
    /// A packaged library (binaries/linux64/BactActuator.so of an unpacked FMU); else the functions linked here
    #[arg(long, global = true)]
    library: Option<PathBuf>,
}

#[derive(Subcommand)]
enum Run {
    /// Sequences of C functions of the FMU, in lives of some hundred calls each
    Calls {
        /// Number of calls
        #[arg(long, default_value_t = 10_000_000)]
        calls: u64,
    },
    /// Files for all readers of the program
    Files {
        /// Number of files for each reader
        #[arg(long, default_value_t = 1_000_000)]
        files: u64,
        /// Only this one: record, stream, command, model, manifest, archive, fmu, location
        #[arg(long)]
        reader: Option<String>,
    },
    /// Instances that live at once, on several threads
    Instances {
        /// Their number
        #[arg(long, default_value_t = 10_000)]
        instances: u64,
        /// Number of threads
        #[arg(long, default_value_t = 4)]
        threads: u64,
    },
    /// Memory over many steps and lives and, of a packaged library, loads
    Memory {
        /// Number of steps of one instance
        #[arg(long, default_value_t = 10_000_000)]
        steps: u64,
        /// Number of instances, one after another
        #[arg(long, default_value_t = 100_000)]
        lives: u64,
        /// Number of loads
        #[arg(long, default_value_t = 1000)]
        loads: u64,
    },
}

fn main() -> ExitCode {
    let Arguments { run, seed, from, library } = Arguments::parse();
    watchdog::start();
    let since = Instant::now();
    let loaded = library.as_deref().map(|path| functions::load(path).unwrap_or_else(|error| panic!("{error}")));
    let host = Host::new(loaded.as_ref().map_or_else(Functions::linked, of));
    let failed = match run {
        Run::Calls { calls } => many_calls(&host, calls, seed, from),
        Run::Files { files, reader } => many_files(&host, files, seed, from, reader.as_deref()),
        Run::Instances { instances, threads } => {
            const STEPS: u64 = 20;
            many::agree(&host, instances, threads, STEPS);
            println!("{instances} instances on {threads} threads, {STEPS} steps of each: as alone");
            0
        }
        Run::Memory { steps, lives, loads } => {
            println!("{steps} steps: {:?}", memory::steps(&host, steps));
            println!("{lives} lives: {:?}", memory::lives(&host, lives));
            if let Some(path) = library.as_deref() {
                many_loads(path, loads);
            }
            0
        }
    };
    println!("{:.0} s", since.elapsed().as_secs_f64());
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn of(library: &Library) -> Functions {
    Functions::of(library).unwrap_or_else(|error| panic!("{error}"))
}

fn many_loads(path: &Path, loads: u64) {
    println!("{loads} loads: {:?}", memory::loads(path, loads));
}

/// Threshold for reporting a slow call.
const NOTED: Duration = Duration::from_secs(5);

/// Lives between two lines of progress.
const REPORTED_LIVES: u64 = 1000;

/// Returns the number of failed lives; details are on standard error.
fn many_calls(host: &Host, calls: u64, seed: u64, from: u64) -> u64 {
    std::panic::set_hook(Box::new(|panic| eprintln!("{panic}")));
    let (mut tally, mut failed, mut life) = (Tally::default(), 0, from);
    while tally.calls() < calls {
        match std::panic::catch_unwind(|| calls::life(host, seed, life)) {
            Ok(lived) => {
                if lived.slowest.0 > NOTED {
                    eprintln!("life {life}: {:?}", lived.slowest);
                }
                tally = tally.and(lived);
            }
            Err(_) => {
                failed += 1;
                eprintln!("life {life} failed: --seed {seed} --from {life} --calls 1");
            }
        }
        life += 1;
        if life % REPORTED_LIVES == 0 {
            println!("{life} lives: {} calls, {failed} failed, slowest {:?}", tally.calls(), tally.slowest);
        }
    }
    println!("{tally:#?}\n{failed} of {} lives failed", life - from);
    failed
}

/// Returns the number of failed readers; details are on standard error.
fn many_files(host: &Host, count: u64, seed: u64, from: u64, only: Option<&str>) -> u64 {
    std::panic::set_hook(Box::new(|panic| eprintln!("{panic}")));
    let wanted = |name: &str| only.is_none_or(|only| only == name);
    let mut failed = 0;
    for reader in READERS.iter().filter(|reader| wanted(reader.name)) {
        let files = || readers::files(reader, &ALLOCATED, seed, from..from + count);
        match std::panic::catch_unwind(files) {
            Ok(tally) => println!("{}: {tally:?}", reader.name),
            Err(_) => failed += 1,
        }
    }
    if wanted("location") {
        println!("location: {} refused", readers::locations(host, seed, from..from + count));
    }
    failed
}
