//! JSBSim: a `<system>` of filters between the properties `actuator/command` and `actuator/position`.
//!
//! Its filters are discretised by Tustin's rule at the frame of the simulation, with a deviation of (ω h)² / 12 for the frame h. Limits
//! inside the loop cannot be expressed by linear filters.

use std::fmt::Write as _;

use super::target::{Source, Target};

pub(super) const EFFECTS: [&str; 8] = [
    "delay",
    "command_limit",
    "command_rate_limit",
    "command_dead_zone",
    "command_backlash",
    "backlash",
    "sensor_lag",
    "sensor_bias",
];

/// Maximum p h of the pole: above it the pole rings under Tustin's rule.
const FASTEST_POLE: f64 = 1.0;

pub(super) fn body(source: &mut Source) -> String {
    let step_s = Target::Jsbsim.step_s().unwrap_or_default();
    let pole = source.pole(step_s, FASTEST_POLE);
    let name = &source.name;
    let [k, _, omega, zeta] = source.model.base.values();
    let mut components: Vec<(&str, &str, String)> = Vec::new();
    if let Some(time) = source.parameter("delay", 0) {
        components.push(("actuator", "delayed", format!("<delay>{time}</delay>")));
    }
    if let (Some(min), Some(max)) = (source.parameter("command_limit", 0), source.parameter("command_limit", 1)) {
        let limits = format!("<gain>1</gain><clipto><min>{min}</min><max>{max}</max></clipto>");
        components.push(("pure_gain", "limited", limits));
    }
    if let (Some(up), Some(down)) =
        (source.parameter("command_rate_limit", 0), source.parameter("command_rate_limit", 1))
    {
        let limits =
            format!("<rate_limit sense=\"incr\">{up}</rate_limit><rate_limit sense=\"decr\">{down}</rate_limit>");
        components.push(("actuator", "rate_limited", limits));
    }
    if let Some(half_width) = source.parameter("command_dead_zone", 0) {
        components.push(("deadband", "beyond_dead_zone", format!("<width>{}</width>", 2.0 * half_width)));
    }
    if let Some(gap) = source.parameter("command_backlash", 0) {
        components.push(("actuator", "behind_play", format!("<hysteresis_width>{gap}</hysteresis_width>")));
    }
    components.push(("pure_gain", "scaled", format!("<gain>{k}</gain>")));
    if let Some(p) = pole {
        components.push(("lag_filter", "lagged", format!("<c1>{p}</c1>")));
    }
    let square = omega * omega;
    let damping = 2.0 * zeta * omega;
    components.push((
        "second_order_filter",
        "drive",
        format!("<c1>0</c1><c2>0</c2><c3>{square}</c3><c4>1</c4><c5>{damping}</c5><c6>{square}</c6>"),
    ));
    if let Some(gap) = source.parameter("backlash", 0) {
        components.push(("actuator", "surface", format!("<hysteresis_width>{gap}</hysteresis_width>")));
    }
    if let Some(time) = source.parameter("sensor_lag", 0) {
        components.push(("sensor", "sensed", format!("<lag>{}</lag>", 1.0 / time)));
    }
    if let (Some(offset), Some(drift)) = (source.parameter("sensor_bias", 0), source.parameter("sensor_bias", 1)) {
        components.push(("sensor", "biased", format!("<bias>{offset}</bias><drift_rate>{drift}</drift_rate>")));
    }
    let last = components.len() - 1;
    let mut input = "actuator/command".to_owned();
    let (mut properties, mut chain) =
        ("  <property value=\"0\">actuator/command</property>\n".to_owned(), String::new());
    for (index, (kind, label, content)) in components.iter().enumerate() {
        let output = if index == last { "actuator/position".to_owned() } else { format!("actuator/{label}") };
        // Writing to a String cannot fail.
        let _ = writeln!(properties, "  <property value=\"0\">{output}</property>");
        let _ = writeln!(
            chain,
            "    <{kind} name=\"{name}_{label}\"><input>{input}</input>{content}<output>{output}</output></{kind}>"
        );
        input = output;
    }
    format!(
        "<!-- Frame: {step_s} s. Input: actuator/command, output: actuator/position. -->\n<system name=\"{name}\">\n{properties}  \
         <channel name=\"{name}\">\n{chain}  </channel>\n</system>\n"
    )
}
