//! An interruption (Ctrl-C, or a termination request) leaves no incomplete files: pending writes are finished first, and temporary files
//! are removed.

use std::{
    fs::remove_dir_all,
    path::PathBuf,
    process::exit,
    sync::{
        Mutex, OnceLock, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::Duration,
};

use tempfile::TempDir;

use crate::{output, progress};

/// Held while files are written.
static WRITING: Mutex<()> = Mutex::new(());

/// Folder of this run's temporary files.
static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// The run is being terminated.
static IS_ENDING: AtomicBool = AtomicBool::new(false);

/// Exit code by shell convention for a program terminated by SIGINT: 128 plus the signal number.
const INTERRUPTED: i32 = 130;

/// Writes one file, or several that belong together, without interruption in between. Must not be nested.
pub fn uninterrupted<T>(write: impl FnOnce() -> T) -> T {
    let _held = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    write()
}

/// Listens for interruptions, and puts temporary files into one folder, which is removed when the returned value is dropped. If the system
/// supports neither, the program runs without them.
pub fn prepare() -> Option<TempDir> {
    let _ = ctrlc::set_handler(end);
    uninterrupted(|| {
        let folder = tempfile::Builder::new().prefix("actuator-").tempdir().ok()?;
        let path = FOLDER.get_or_init(|| folder.path().to_owned());
        let _ = tempfile::env::override_temp_dir(path);
        Some(folder)
    })
}

/// Waits for the end of a run that is being terminated: failures of work from then on are due to removed files.
pub fn wait_if_ending() {
    while IS_ENDING.load(Ordering::SeqCst) {
        thread::park();
    }
}

/// Attempts to remove the temporary folder, to which interrupted work may still write.
const ATTEMPTS: u32 = 20;
/// The time between two attempts.
const PAUSE: Duration = Duration::from_millis(5);

/// Runs in a separate thread, while the work continues.
fn end() {
    uninterrupted(|| {
        IS_ENDING.store(true, Ordering::SeqCst);
        if let Some(folder) = FOLDER.get() {
            for _ in 0..ATTEMPTS {
                if remove_dir_all(folder).is_ok() || !folder.exists() {
                    break;
                }
                thread::sleep(PAUSE);
            }
        }
        progress::end();
        output::remark("actuator: interrupted");
        exit(INTERRUPTED)
    });
}
