//! `actuator sets`

use std::fmt::Write as _;

use actuator_fmu::{
    Result,
    parameters::{Base, NO_DATA, SOURCE, table},
};
use serde::Serialize;

/// List the 17 identified parameter sets
#[derive(clap::Args)]
#[command(after_help = "Example:\n  actuator sets --json")]
pub struct Arguments {
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

pub fn run(arguments: &Arguments) -> Result<()> {
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
        return super::print_json(&sets);
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
    super::print(&text)
}
