//! Modelica: equations, with the effects that can be expressed as equations.

use std::fmt::Write as _;

use super::target::Source;
use actuator_fmu::parameters::Order;

pub(super) const EFFECTS: [&str; 13] = [
    "delay",
    "command_limit",
    "command_dead_zone",
    "asymmetric_gain",
    "gain_drift",
    "dead_zone",
    "amplitude_gain",
    "hinge_load",
    "acceleration_limit",
    "structural_mode",
    "sensor_lag",
    "sensor_bias",
    "chatter",
];

pub(super) fn body(source: &mut Source) -> String {
    let get = |effect: &str, index: usize| source.parameter(effect, index);
    let [k, p, omega, zeta] = source.model.base.values();
    // Each stage of the command side is a variable of its own.
    let mut stages: Vec<(&str, String)> = Vec::new();
    let mut command = "command";
    if let Some(time) = get("delay", 0) {
        stages.push(("delayed", format!("delay({command}, {time:?})")));
        command = "delayed";
    }
    if let (Some(min), Some(max)) = (get("command_limit", 0), get("command_limit", 1)) {
        stages.push(("limited", format!("min(max({command}, {}), {})", signed(min), signed(max))));
        command = "limited";
    }
    if let Some(width) = get("command_dead_zone", 0) {
        stages.push(("beyond_dead_zone", beyond(command, width)));
        command = "beyond_dead_zone";
    }
    if let Some(ratio) = get("asymmetric_gain", 0) {
        stages.push(("asymmetric", format!("if {command} < 0 then {ratio:?} * {command} else {command}")));
        command = "asymmetric";
    }
    if let Some(rate) = get("gain_drift", 0) {
        stages.push(("drifted", format!("{command} * (1 + {} * time)", signed(rate))));
        command = "drifted";
    }
    let mut variables: String = stages.iter().map(|(name, _)| format!("  Real {name};\n")).collect();
    let mut equations: String = stages.iter().map(|(name, right)| format!("  {name} = {right};\n")).collect();
    // Writing to a String cannot fail.
    if source.model.order == Order::Third {
        let _ = writeln!(variables, "  Real x(start = 0, fixed = true) \"pole state\";");
        let _ = writeln!(equations, "  der(x) = p * (k * {command} - x);");
    } else {
        let _ = writeln!(variables, "  Real x \"scaled command\";");
        let _ = writeln!(equations, "  x = k * {command};");
    }
    let mut drive = "error".to_owned();
    let _ = writeln!(variables, "  Real error \"servo error\";");
    let _ = writeln!(equations, "  error = x - drive;");
    if let Some(width) = get("dead_zone", 0) {
        let _ = writeln!(variables, "  Real corrected \"servo error beyond its dead zone\";");
        let _ = writeln!(equations, "  corrected = {};", beyond("error", width));
        drive = "corrected".into();
    }
    drive = format!("omega^2 * {drive}");
    if let Some(limit) = get("acceleration_limit", 0) {
        drive = format!("min(max({drive}, -{limit:?}), {limit:?})");
    }
    drive += " - 2 * zeta * omega * rate";
    if let Some(cubic) = get("amplitude_gain", 0) {
        let _ = write!(drive, " - omega^2 * {} * drive^3", signed(cubic));
    }
    if let (Some(stiffness), Some(bias)) = (get("hinge_load", 0), get("hinge_load", 1)) {
        let _ = write!(drive, " + omega^2 * ({} - {} * drive)", signed(bias), signed(stiffness));
    }
    let _ = writeln!(equations, "  der(drive) = rate;\n  der(rate) = {drive};");
    let mut output = "drive".to_owned();
    if let (Some(frequency), Some(damping), Some(gain)) =
        (get("structural_mode", 0), get("structural_mode", 1), get("structural_mode", 2))
    {
        let turn = std::f64::consts::TAU * frequency;
        let _ = writeln!(
            variables,
            "  Real mode(start = 0, fixed = true);\n  Real mode_rate(start = 0, fixed = true);\n  Real deflection;"
        );
        let _ = writeln!(
            equations,
            "  der(mode) = mode_rate;\n  der(mode_rate) = {:?} * (drive - mode) - {:?} * mode_rate;\n  \
             deflection = drive + {} * (mode - drive);",
            turn * turn,
            2.0 * damping * turn,
            signed(gain)
        );
        output = "deflection".into();
    }
    if let Some(time) = get("sensor_lag", 0) {
        let _ = writeln!(variables, "  Real sensed(start = 0, fixed = true);");
        let _ = writeln!(equations, "  {time:?} * der(sensed) = {output} - sensed;");
        output = "sensed".into();
    }
    if let (Some(offset), Some(drift)) = (get("sensor_bias", 0), get("sensor_bias", 1)) {
        let _ = write!(output, " + {} + {} * time", signed(offset), signed(drift));
    }
    if let (Some(amplitude), Some(frequency), Some(phase)) = (get("chatter", 0), get("chatter", 1), get("chatter", 2)) {
        let turn = std::f64::consts::TAU * frequency;
        let _ = write!(output, " + {} * sin({turn:?} * time + {})", signed(amplitude), signed(phase));
    }
    let pole = if source.model.order == Order::Third {
        format!("  parameter Real p = {p:?} \"1/s\";\n")
    } else {
        String::new()
    };
    format!(
        "model {name}\n  input Real command(start = 0);\n  output Real position;\n  parameter Real k = {k:?};\n{pole}  \
         parameter Real omega = {omega:?} \"rad/s\";\n  parameter Real zeta = {zeta:?};\n  Real drive(start = 0, fixed = true);\n  \
         Real rate(start = 0, fixed = true);\n{variables}equation\n{equations}  position = {output};\nend {name};\n",
        name = source.name
    )
}

fn beyond(name: &str, half_width: f64) -> String {
    format!(
        "if {name} > {half_width:?} then {name} - {half_width:?} elseif {name} < -{half_width:?} then {name} + {half_width:?} else 0"
    )
}

/// A number as a factor or a term.
fn signed(value: f64) -> String {
    if value < 0.0 { format!("({value:?})") } else { format!("{value:?}") }
}
