//! An interruption (Ctrl-C, or a request to end) leaves nothing half-written: what is being written is finished first, and temporary files go.

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

/// Where temporary files of this run lie.
static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// The run is being ended.
static IS_ENDING: AtomicBool = AtomicBool::new(false);

/// As shells have it for a program that SIGINT ended: 128 and the number of the signal.
const INTERRUPTED: i32 = 130;

/// Writes without being interrupted in between, be it one file or several that belong together. Must not be nested.
pub fn uninterrupted<T>(write: impl FnOnce() -> T) -> T {
    let _held = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    write()
}

/// Listens to interruptions, and puts temporary files into one folder, which goes when the returned value does. A system that grants neither
/// is none the worse for it.
pub fn prepare() -> Option<TempDir> {
    let _ = ctrlc::set_handler(end);
    uninterrupted(|| {
        let folder = tempfile::Builder::new().prefix("actuator-").tempdir().ok()?;
        let path = FOLDER.get_or_init(|| folder.path().to_owned());
        let _ = tempfile::env::override_temp_dir(path);
        Some(folder)
    })
}

/// Waits for the end of a run that is being ended: work that fails then, fails for want of the files that went.
pub fn wait_if_ending() {
    while IS_ENDING.load(Ordering::SeqCst) {
        thread::park();
    }
}

/// Attempts to remove the temporary folder, into which the work that is interrupted may still write.
const ATTEMPTS: u32 = 20;
/// The time between two of them.
const PAUSE: Duration = Duration::from_millis(5);

/// Runs in a thread of its own, while the work goes on.
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
