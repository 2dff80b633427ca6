//! `actuator render` (for developers): the generated files of `modelDescription/`, from the code.

use crate::output;
use std::path::PathBuf;

use crate::{
    description,
    files::write_new,
    references,
    report::{documentation, icon},
};
use actuator_fmu::{Result, fmu::Start};

/// Refresh modelDescription/ from the code (for developers)
#[derive(clap::Args)]
#[command(after_help = "Example:\n  actuator render modelDescription")]
pub struct Arguments {
    /// The folder
    folder: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let folder = &arguments.folder;
    write_new(&folder.join("modelDescription.xml"), description::xml(&Start::default()).as_bytes(), true)?;
    write_new(&folder.join("model.png"), &icon::png()?, true)?;
    write_new(&folder.join("documentation/index.html"), documentation::html().as_bytes(), true)?;
    for (name, bytes) in references::files()? {
        write_new(&folder.join(name), &bytes, true)?;
    }
    output::print(&format!(
        "rendered modelDescription.xml, model.png, documentation/ and extra/ into {}\n",
        folder.display()
    ))
}
