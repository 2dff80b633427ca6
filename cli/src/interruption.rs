//! An interruption (Ctrl-C, or a request to end) leaves nothing half-written: what is being written is finished first, and temporary files go.

use std::{
    path::PathBuf,
    process::exit,
    sync::{Mutex, OnceLock, PoisonError},
};

use tempfile::TempDir;

/// Held while files are written.
static WRITING: Mutex<()> = Mutex::new(());

/// Where temporary files of this run lie.
static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// As shells have it for a program that SIGINT ended: 128 and the number of the signal.
const INTERRUPTED: i32 = 130;

/// Writes without being interrupted in between, be it one file or several that belong together.
pub fn uninterrupted<T>(write: impl FnOnce() -> T) -> T {
    let _held = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    write()
}

/// Listens to interruptions, and puts temporary files into one folder, which goes when the returned value does. A system that grants neither
/// is none the worse for it.
pub fn prepare() -> Option<TempDir> {
    let folder = tempfile::Builder::new().prefix("actuator-").tempdir().ok()?;
    let path = FOLDER.get_or_init(|| folder.path().to_owned());
    let _ = tempfile::env::override_temp_dir(path);
    let _ = ctrlc::set_handler(|| {
        let _held = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(folder) = FOLDER.get() {
            let _ = std::fs::remove_dir_all(folder);
        }
        eprintln!("actuator: interrupted");
        exit(INTERRUPTED)
    });
    Some(folder)
}
