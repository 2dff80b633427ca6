//! `actuator sets`

use crate::output;
use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
};

use crate::{files, ssp};
use actuator_fmu::{
    Result,
    parameters::{Base, NO_DATA, SOURCE, table},
};
use serde::Serialize;

/// List the 17 identified parameter sets, or write them as files for tools that speak SSP
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  actuator sets --json\n  \
actuator sets --ssv sets                      one .ssv per set, for libcosim and Ecos\n  \
actuator sets --ssv sets --prefix actuator    the same for fmpy, which wants the component's name before each parameter\n\n\
A ready system with one of them applied: actuator build --ssp")]
pub struct Arguments {
    /// Write one parameter set file (SSP 1.0) per set into this folder
    #[arg(long, value_name = "DIR")]
    ssv: Option<PathBuf>,
    /// Put this and a dot before the names in the files
    #[arg(long, value_name = "COMPONENT", requires = "ssv")]
    prefix: Option<String>,
    /// Overwrite files in DIR
    #[arg(long, requires = "ssv")]
    force: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Set {
    set_number: usize,
    name: String,
    surface: &'static str,
    stage: &'static str,
    load_case: &'static str,
    k: Quantity,
    p: Quantity,
    omega: Quantity,
    zeta: Quantity,
    source: String,
}

#[derive(Serialize)]
struct Quantity {
    value: f64,
    unit: &'static str,
}

#[derive(Serialize)]
struct Written {
    folder: PathBuf,
    files: Vec<String>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    if let Some(folder) = &arguments.ssv {
        return write(arguments, folder);
    }
    if arguments.json {
        let sets: Vec<Set> = table()
            .iter()
            .zip(1..)
            .map(|(set, set_number)| {
                let quantity =
                    |index: usize| Quantity { value: set.base.values()[index], unit: Base::PARAMETERS[index].unit };
                Set {
                    set_number,
                    name: set.name.to_string(),
                    surface: set.name.surface.name(),
                    stage: set.name.stage.name(),
                    load_case: set.name.load_case.name(),
                    k: quantity(0),
                    p: quantity(1),
                    omega: quantity(2),
                    zeta: quantity(3),
                    source: set.source(),
                }
            })
            .collect();
        return output::print_json(&sets);
    }
    let mut text = format!("{:>2}  {:<19} {:>9} {:>9} {:>8} {:>7}  {SOURCE}\n", "", "set", "k", "p", "omega", "zeta");
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{:>2}  {:<19} {:>9} {:>9} {:>8} {:>7}", "", "", "deg/deg", "1/s", "rad/s", "1");
    for (set, number) in table().iter().zip(1..) {
        let [k, p, omega, zeta] = set.base.values();
        let p = if p > 1e6 { format!("{p:e}") } else { p.to_string() };
        let _ = writeln!(
            text,
            "{number:>2}  {:<19} {k:>9.4} {p:>9} {omega:>8.2} {zeta:>7.4}  table {}, row {}",
            set.name.to_string(),
            set.table,
            set.row
        );
    }
    let _ = writeln!(text, "    ls-late-loaded: {NO_DATA}");
    output::print(&text)
}

fn write(arguments: &Arguments, folder: &Path) -> Result<()> {
    let sets = ssp::parameter_set_files(arguments.prefix.as_deref())?;
    files::write_folder(folder, &sets, arguments.force)?;
    if arguments.json {
        let files = sets.into_iter().map(|(name, _)| name).collect();
        return output::print_json(&Written { folder: folder.to_owned(), files });
    }
    output::print(&format!("{} parameter sets in {}\n", sets.len(), folder.display()))
}
