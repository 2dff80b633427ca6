//! The files that a diagnosis leaves in its folder.

use actuator_fmu::error::{Error, Result};
use identification::signal::{Response, write_csv};

use crate::{output::to_json, workflow::account::Account};

/// Their names; the last one only where there is a test to record next.
pub const NAMES: [&str; 5] = ["diagnosis.json", "report.html", "model.toml", "model.fmu", "next_test.csv"];

/// Their names and contents.
///
/// # Errors
/// A model or a command that cannot be written.
pub fn files(account: &Account) -> Result<Vec<(String, Vec<u8>)>> {
    let contents = [
        format!("{}\n", to_json(&account.json())?).into_bytes(),
        account.html().into_bytes(),
        account.diagnosis.after.to_toml()?.into_bytes(),
        account.fmu.clone(),
    ];
    let mut files: Vec<(String, Vec<u8>)> = NAMES.iter().map(|name| (*name).to_owned()).zip(contents).collect();
    if let Some(test) = &account.next_test {
        let name = NAMES[4];
        let mut csv = Vec::new();
        write_csv(&mut csv, &test.command, &Response::default())
            .map_err(|error| Error::new(name, error.to_string(), "a command"))?;
        files.push((name.to_owned(), csv));
    }
    Ok(files)
}
