//! C99: a state and a function that steps it under a held command, with all effects.
//!
//! Without effects in the loop a step is exact: with u = k c and B = ω² (x - u) / (p² - 2 ζ ω p + ω²),
//!
//! ```text
//! x = u + (x0 - u) exp(-p t),   δ = u + B exp(-p t) + e(t),   ë + 2 ζ ω ė + ω² e = 0
//! ```
//!
//! With such effects it uses steps of ten microseconds: velocities first, then positions (semi-implicit Euler), with friction limited to
//! what stops the drive. The error is about ω h/2, a thousandth for 200 rad/s.

use std::fmt::Write as _;

use super::target::{Source, Target};
use actuator_fmu::parameters::Order;

pub(super) const EFFECTS: [&str; 20] = [
    "delay",
    "command_limit",
    "command_rate_limit",
    "command_dead_zone",
    "command_backlash",
    "asymmetric_gain",
    "gain_drift",
    "dead_zone",
    "amplitude_gain",
    "hinge_load",
    "coulomb_friction",
    "acceleration_limit",
    "rate_limit",
    "position_limit",
    "backlash",
    "structural_mode",
    "sensor_lag",
    "sensor_bias",
    "chatter",
    "quantisation",
];

/// Effects that are functions of the command or the position at one instant, or keep a held command constant: a step stays exact.
const INSTANT: [&str; 7] = [
    "command_limit",
    "command_dead_zone",
    "command_backlash",
    "asymmetric_gain",
    "sensor_bias",
    "chatter",
    "quantisation",
];

pub(super) fn body(source: &mut Source) -> String {
    let is_exact = source.model.effects.active().all(|(effect, _)| INSTANT.contains(&effect.name));
    let step_s = Target::C.step_s().unwrap_or_default();
    let [k, p, omega, zeta] = source.model.base.values();
    let name = source.name.clone();
    let mut text = format!(
        "#include <math.h>\n\nstatic const double k = {k:?}, p = {p:?}, omega = {omega:?}, zeta = {zeta:?}, pi = 3.14159265358979323846;\n\n"
    );
    let delay_steps = source.parameter("delay", 0).map(|time| (time / step_s).round().max(1.0));
    let ring = delay_steps.map_or(String::new(), |steps| format!("    double late[{steps}];\n    int next;\n"));
    // Writing to a String cannot fail.
    let _ = write!(
        text,
        "typedef struct {{\n    double time, x, position, rate;     /* pole state, drive */\n    double limited, behind_play;        /* command side */\n    \
         double surface, mode, mode_rate, sensed; /* output side */\n{ring}}} {name}_state;\n\n\
         /* At rest at a position; the command before the first step is the one that holds it there. */\n\
         static void {name}_reset({name}_state *s, double position) {{\n    s->time = s->rate = s->mode_rate = 0.0;\n    \
         s->x = s->position = s->surface = s->mode = s->sensed = position;\n    s->limited = s->behind_play = position / k;\n{}}}\n\n",
        delay_steps.map_or(String::new(), |steps| {
            format!("    for (s->next = 0; s->next < {steps}; s->next++) s->late[s->next] = position / k;\n    s->next = 0;\n")
        })
    );
    text += "static double play(double held, double value, double gap) {\n    return fmin(fmax(held, value - 0.5 * gap), value + 0.5 * gap);\n}\n\n\
             static double beyond(double value, double half_width) {\n    \
             return value > half_width ? value - half_width : value < -half_width ? value + half_width : 0.0;\n}\n\n";
    let _ = write!(
        text,
        "static double command_side({name}_state *s, double c, double h) {{\n{}",
        command_side(source, delay_steps)
    );
    text += "    (void)s, (void)h, (void)beyond, (void)play, (void)pi;\n    return c;\n}\n\n";
    let _ = write!(text, "static double measured({name}_state *s, double h) {{\n{}", output_side(source));
    text += "    (void)s, (void)h;\n    return y;\n}\n\n";
    text += &if is_exact { exact(source) } else { stepped(source, step_s) };
    text
}

fn command_side(source: &Source, delay_steps: Option<f64>) -> String {
    let mut lines = String::new();
    let get = |effect: &str, index: usize| source.parameter(effect, index);
    // Writing to a String cannot fail.
    if let Some(steps) = delay_steps {
        let _ = writeln!(
            lines,
            "    double delayed = s->late[s->next];\n    s->late[s->next] = c;\n    s->next = (s->next + 1) % {steps};\n    c = delayed;"
        );
    }
    if let (Some(min), Some(max)) = (get("command_limit", 0), get("command_limit", 1)) {
        let _ = writeln!(lines, "    c = fmin(fmax(c, {min:?}), {max:?});");
    }
    if let (Some(up), Some(down)) = (get("command_rate_limit", 0), get("command_rate_limit", 1)) {
        let _ = writeln!(
            lines,
            "    s->limited = fmin(fmax(c, s->limited - {down:?} * h), s->limited + {up:?} * h);\n    c = s->limited;"
        );
    }
    if let Some(half_width) = get("command_dead_zone", 0) {
        let _ = writeln!(lines, "    c = beyond(c, {half_width:?});");
    }
    if let Some(gap) = get("command_backlash", 0) {
        let _ = writeln!(lines, "    c = s->behind_play = play(s->behind_play, c, {gap:?});");
    }
    if let Some(ratio) = get("asymmetric_gain", 0) {
        let _ = writeln!(lines, "    if (c < 0.0) c *= {ratio:?};");
    }
    if let Some(rate) = get("gain_drift", 0) {
        let _ = writeln!(lines, "    c *= 1.0 + {rate:?} * s->time;");
    }
    lines
}

fn output_side(source: &Source) -> String {
    let mut lines = "    double y = s->position;\n".to_owned();
    let get = |effect: &str, index: usize| source.parameter(effect, index);
    // Writing to a String cannot fail.
    if let Some(gap) = get("backlash", 0) {
        let _ = writeln!(lines, "    y = s->surface = play(s->surface, y, {gap:?});");
    }
    if let (Some(frequency), Some(damping), Some(gain)) =
        (get("structural_mode", 0), get("structural_mode", 1), get("structural_mode", 2))
    {
        let _ = writeln!(
            lines,
            "    const double turn = 2.0 * pi * {frequency:?};\n    \
             s->mode_rate += h * (turn * turn * (y - s->mode) - 2.0 * {damping:?} * turn * s->mode_rate);\n    \
             s->mode += h * s->mode_rate;\n    y += {gain:?} * (s->mode - y);"
        );
    }
    if let Some(time) = get("sensor_lag", 0) {
        let _ = writeln!(lines, "    s->sensed += (y - s->sensed) * -expm1(-h / {time:?});\n    y = s->sensed;");
    }
    if let (Some(offset), Some(drift)) = (get("sensor_bias", 0), get("sensor_bias", 1)) {
        let _ = writeln!(lines, "    y += {offset:?} + {drift:?} * s->time;");
    }
    if let (Some(amplitude), Some(frequency), Some(phase)) = (get("chatter", 0), get("chatter", 1), get("chatter", 2)) {
        let _ = writeln!(lines, "    y += {amplitude:?} * sin(2.0 * pi * {frequency:?} * s->time + {phase:?});");
    }
    if let Some(step) = get("quantisation", 0) {
        let _ = writeln!(lines, "    y = {step:?} * round(y / {step:?});");
    }
    lines
}

/// One exact step of any length.
fn exact(source: &Source) -> String {
    let pole = if source.model.order == Order::Third {
        "    const double decay = exp(-p * h), b = square * (s->x - u) / (p * p - 2.0 * zeta * omega * p + square);\n"
    } else {
        "    const double decay = 0.0, b = 0.0;\n"
    };
    format!(
        "/* The measured position after a step of any duration [s], through which the command is held. Exact. */\n\
         static double {name}_step({name}_state *s, double command, double h) {{\n    \
         const double u = k * command_side(s, command, h), square = omega * omega;\n{pole}    \
         const double e = s->position - u - b, v = s->rate + p * b, d = zeta * omega, q = 1.0 - zeta * zeta;\n    \
         double cosine, sine; /* the second over its frequency */\n    \
         if (q > 1e-9) {{\n        cosine = cos(omega * sqrt(q) * h);\n        sine = sin(omega * sqrt(q) * h) / (omega * sqrt(q));\n    \
         }} else if (q < -1e-9) {{\n        cosine = cosh(omega * sqrt(-q) * h);\n        sine = sinh(omega * sqrt(-q) * h) / (omega * sqrt(-q));\n    \
         }} else {{\n        cosine = 1.0;\n        sine = h;\n    }}\n    const double fade = exp(-d * h);\n    \
         s->x = u + (s->x - u) * decay;\n    s->position = u + b * decay + fade * (e * cosine + (v + d * e) * sine);\n    \
         s->rate = -p * b * decay + fade * (v * cosine - (d * v + square * e) * sine);\n    s->time += h;\n    return measured(s, h);\n}}\n",
        name = source.name
    )
}

/// Many small steps.
fn stepped(source: &Source, step_s: f64) -> String {
    let get = |effect: &str, index: usize| source.parameter(effect, index);
    let pole = if source.model.order == Order::Third { "s->x += (u - s->x) * -expm1(-p * h);" } else { "s->x = u;" };
    let mut drive = "        double a = s->x - s->position;\n".to_owned();
    // Writing to a String cannot fail.
    if let Some(half_width) = get("dead_zone", 0) {
        let _ = writeln!(drive, "        a = beyond(a, {half_width:?});");
    }
    drive += "        a *= square;\n";
    if let Some(limit) = get("acceleration_limit", 0) {
        let _ = writeln!(drive, "        a = fmin(fmax(a, -{limit:?}), {limit:?});");
    }
    drive += "        a -= 2.0 * zeta * omega * s->rate;\n";
    if let Some(cubic) = get("amplitude_gain", 0) {
        let _ = writeln!(drive, "        a -= square * {cubic:?} * s->position * s->position * s->position;");
    }
    if let (Some(stiffness), Some(bias)) = (get("hinge_load", 0), get("hinge_load", 1)) {
        let _ = writeln!(drive, "        a += square * ({bias:?} - {stiffness:?} * s->position);");
    }
    drive += "        s->rate += h * a;\n";
    if let Some(level) = get("coulomb_friction", 0) {
        let _ = writeln!(drive, "        s->rate = beyond(s->rate, h * square * {level:?});");
    }
    if let (Some(up), Some(down)) = (get("rate_limit", 0), get("rate_limit", 1)) {
        let _ = writeln!(drive, "        s->rate = fmin(fmax(s->rate, -{down:?}), {up:?});");
    }
    drive += "        s->position += h * s->rate;\n";
    if let (Some(min), Some(max)) = (get("position_limit", 0), get("position_limit", 1)) {
        let _ = writeln!(
            drive,
            "        if (s->position <= {min:?} || s->position >= {max:?}) {{\n            \
             s->position = fmin(fmax(s->position, {min:?}), {max:?});\n            s->rate = 0.0;\n        }}"
        );
    }
    format!(
        "/* The measured position after a duration [s], through which the command is held, in steps of {step_s:e} s or a little less. */\n\
         static double {name}_step({name}_state *s, double command, double duration) {{\n    \
         const double square = omega * omega;\n    const int steps = (int)ceil(duration / {step_s:?} - 1e-6);\n    \
         const double h = duration / steps;\n    double y = 0.0;\n    for (int step = 0; step < steps; step++) {{\n        \
         const double u = k * command_side(s, command, h);\n        {pole}\n{drive}        s->time += h;\n        \
         y = measured(s, h);\n    }}\n    return y;\n}}\n",
        name = source.name
    )
}
