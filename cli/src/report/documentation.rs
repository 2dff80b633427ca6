//! `documentation/index.html` of the default FMU: equations, sets, selection, limits, source. [`model`] is the page of the FMU of a model.

pub mod model;

use std::fmt::Write as _;

use actuator_fmu::{
    effects::CHAIN,
    fmu::{
        MODEL_IDENTIFIER, Start, guid,
        variables::{Causality, Kind, Variability, variables},
    },
    parameters::{Base, Order, PositionUnit, SOURCE, table},
};

const STYLE: &str = "
:root { color-scheme: light dark; --line: #cbd2d9; --soft: #f1f4f7 }
@media (prefers-color-scheme: dark) { :root { --line: #46515c; --soft: #1f262d } }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 64rem; margin: 0 auto; padding: 1.5rem }
.scroll { overflow-x: auto }
table { border-collapse: collapse; margin: 1rem 0; font-variant-numeric: tabular-nums }
td code { white-space: nowrap }
th, td { border-bottom: 1px solid var(--line); padding: .25rem .6rem; text-align: left; vertical-align: top }
td.number { text-align: right }
code, pre { font-family: ui-monospace, monospace; font-size: .92em; background: var(--soft); border-radius: 4px }
code { padding: .05em .3em } pre { padding: .75rem 1rem; overflow-x: auto }
.equation { margin: 1rem 2rem; font-family: Georgia, serif; font-size: 1.1rem }
h2 { margin-top: 2rem }";

/// The page of the default FMU.
#[must_use]
pub fn html() -> String {
    let mut page = head(MODEL_IDENTIFIER);
    page.push_str(&introduction());
    page.push_str(&sets());
    page.push_str(SELECTING);
    page.push_str(&effects());
    page.push_str(EXCHANGE);
    page.push_str(&variable_table(PositionUnit::Degree));
    let _ = writeln!(page, "{LIMITS}{REFUSALS}</ul>"); // writing to a String cannot fail
    page.push_str(REFERENCES);
    let _ = write!(
        page,
        "<h2>Source</h2>\n<p>M. R. Waszak and J. Fung: Parameter Estimation of Actuators for Benchmark Active Control Technology \
         (BACT) Wind Tunnel Model With Analysis of Wear and Aerodynamic Loading Effects. {SOURCE}, July 1998.</p>\n\
         <p>Version {}, GUID <code>{}</code>.</p>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION"),
        guid(&Start::default())
    );
    page
}

/// Everything before the first paragraph.
fn head(title: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>{STYLE}\n</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
    )
}

/// Text escaped for HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn introduction() -> String {
    format!(
        "<p>FMI 2.0 unit, for co-simulation and for model exchange, of the trailing-edge, upper-spoiler and lower-spoiler actuators of the BACT wind-tunnel \
         model, as identified in {SOURCE} over three stages of wear and two load cases.</p>\n\
         <h2>Equations</h2>\n{}",
        equations("of the report", Order::Third)
    )
}

/// The linear part and its solution. `of` states the origin of the numbers in the equations, `default` which one is used.
fn equations(of: &str, default: Order) -> String {
    let if_default = |order: Order| if order == default { ", the default" } else { "" };
    let (third, second) = (if_default(Order::Third), if_default(Order::Second));
    format!(
        "<p>Third order, eq. (1) {of} (<code>order = third</code>{third}):</p>\n\
         <p class=\"equation\"><i>δ</i>(s) / <i>δ</i><sub>c</sub>(s) = <i>k p ω</i>² / [(s + <i>p</i>)(s² + 2<i>ζω</i>s + <i>ω</i>²)]</p>\n\
         <p>Second order, eq. (6) (<code>order = second</code>{second}):</p>\n\
         <p class=\"equation\"><i>δ</i>(s) / <i>δ</i><sub>c</sub>(s) = <i>k ω</i>² / (s² + 2<i>ζω</i>s + <i>ω</i>²)</p>\n\
         <p>In time, with pole state <i>x</i> (eq. (6): <i>x</i> = <i>k c</i>) and command <i>c</i>:</p>\n\
         <p class=\"equation\"><i>ẋ</i> = <i>p</i> (<i>k c</i> − <i>x</i>), &nbsp; <i>δ̈</i> = <i>ω</i>² (<i>x</i> − <i>δ</i>) − 2<i>ζω</i> <i>δ̇</i></p>\n\
         <p>Without effects, the solution over a communication step is exact for a command that is held, or that moves linearly \
         (<code>fmi2SetRealInputDerivatives</code>), at any step size: no solver, no tolerance. A derivative once set holds \
         until the command or its derivative is set again; setting only the command means that it is held.</p>\n"
    )
}

fn sets() -> String {
    let mut rows = String::new();
    for (set, number) in table().iter().zip(1..) {
        let [k, p, omega, zeta] = set.base.values();
        let p = if p > 1e6 { format!("{p:e}") } else { p.to_string() };
        let _ = writeln!(
            rows,
            "<tr><td class=\"number\">{number}</td><td><code>{}</code></td><td>{}</td><td>{}</td><td>{}</td>\
             <td class=\"number\">{k:.4}</td><td class=\"number\">{p}</td><td class=\"number\">{omega:.2}</td>\
             <td class=\"number\">{zeta:.4}</td><td class=\"number\">{}, {}</td></tr>",
            set.name,
            set.name.surface.name(),
            set.name.stage.name(),
            set.name.load_case.name(),
            set.table,
            set.row,
        );
    }
    let heads: Vec<String> =
        Base::PARAMETERS.iter().map(|parameter| format!("<th>{} [{}]</th>", parameter.name, parameter.unit)).collect();
    format!(
        "<h2>Parameter sets</h2>\n<div class=\"scroll\"><table>\n<tr><th>set_number</th><th>name</th><th>surface</th><th>stage</th>\
         <th>load_case</th>{}<th>table, row</th></tr>\n{rows}</table></div>\n\
         <p>The report has no data for the lower spoiler late in the test under load: leaving initialization mode with that \
         combination is an error.</p>\n",
        heads.concat()
    )
}

const SELECTING: &str = "<h2>Selecting a set</h2>
<p>Set, before or in initialization mode, one of</p>
<ul>
<li><code>surface</code>, <code>stage</code>, <code>load_case</code>: enumerations, items counted from 1;</li>
<li><code>set_number</code>: 1 to 17 as in the table above (it overrides the three), for importers that do not show enumerations;</li>
<li><code>source = custom</code> and <code>custom.k</code>, <code>custom.p</code>, <code>custom.omega</code>, <code>custom.zeta</code>: own values, which may also be changed between steps.</li>
</ul>
<p><code>active.*</code> shows the values in use. With fmpy, for the upper spoiler late in the test under load:</p>
<pre>from fmpy import simulate_fmu
result = simulate_fmu('BactActuator.fmu', stop_time=0.2, output_interval=0.005,
                      start_values={'surface': 2, 'stage': 3, 'load_case': 2, 'command': 1.0})</pre>
";

/// The chain, with the equation of motion as changed by its loop effects.
fn effects() -> String {
    format!("{EFFECTS}{}{FAILURES}", effect_table(PositionUnit::Degree))
}

/// Parameters of all effects, with positions in `unit`.
fn effect_table(unit: PositionUnit) -> String {
    let mut rows = String::new();
    for effect in CHAIN {
        let names: Vec<String> = effect
            .parameters
            .iter()
            .map(|parameter| {
                format!("<code>{}.{}</code> [{}]", effect.name, parameter.name, unit.derived(parameter.unit))
            })
            .collect();
        let _ = writeln!(
            rows,
            "<tr><td>{}</td><td>{}</td><td>{}</td></tr>",
            names.join("<br>"),
            effect.act.place(),
            effect.summary
        );
    }
    format!(
        "<div class=\"scroll\"><table>\n<tr><th>parameters</th><th>place</th><th>what it does</th></tr>\n{rows}</table></div>\n"
    )
}

const EFFECTS: &str = "<h2>Effects</h2>
<p>What the report leaves out, in the order in which the signal meets it. At its neutral (start) value an effect is exactly
nothing. All parameters may be changed between steps. Effects of the loop stand in</p>
<p class=\"equation\"><i>δ̈</i> = sat(<i>ω</i>² dz(<i>x</i> − <i>δ</i>)) − 2<i>ζω</i> <i>δ̇</i> − <i>ω</i>² cubic <i>δ</i>³
+ <i>ω</i>² (load + bias − stiffness <i>δ</i>) − <i>ω</i>² level sgn <i>δ̇</i></p>
<p>with <i>δ̇</i> held inside the rate limits and <i>δ</i> inside the stops. Between two events (a limit reached, a reversal, a sticking)
the motion is a series that is exact to rounding; events are located inside the step, so that results do not depend on the
communication step.</p>
";

const FAILURES: &str = "<p><code>load</code> is an external hinge load, as the static deflection that it causes.
<code>failure</code> injects <code>passive</code> (the drive is off: the surface floats, with its damping and loads),
<code>stuck</code>, or <code>hardover_positive</code> and <code>hardover_negative</code> (the servo is driven to the stop of
<code>position_limit</code>, through the limits of rate and acceleration: set them first). Set back to <code>none</code>, the
actuator recovers from where it is.</p>
";

fn variable_table(position: PositionUnit) -> String {
    let mut rows = String::new();
    for variable in variables() {
        let causality = match variable.causality {
            Causality::Input => "input",
            Causality::Output => "output",
            Causality::Parameter if variable.variability == Variability::Tunable => "parameter, tunable",
            Causality::Parameter => "parameter, fixed",
            Causality::CalculatedParameter => "calculated",
            Causality::Local => "local",
        };
        let kind = match &variable.kind {
            Kind::Real { unit, .. } => position.derived(unit).to_owned(),
            Kind::Integer { min, max } => format!("Integer {min} to {max}"),
            Kind::Boolean => "Boolean".into(),
            Kind::Enumeration(of) => of.items.join(", "),
        };
        let _ = writeln!(
            rows,
            "<tr><td><code>{}</code></td><td>{causality}</td><td>{kind}</td><td>{}</td></tr>",
            variable.name, variable.description
        );
    }
    format!(
        "<h2>Variables</h2>\n<div class=\"scroll\"><table>\n<tr><th>name</th><th>causality</th><th>unit or items</th><th>meaning</th></tr>\n{rows}</table></div>\n"
    )
}

const EXCHANGE: &str = "<h2>Model exchange</h2>
<p>The same equations for a solver of the host's. Continuous states: <code>drive.target</code> (the pole state <i>x</i>),
<code>drive.position</code>, <code>drive.rate</code>, and what the effects behind the drive remember. Poles of up to 3 × 10⁸ 1/s ask for an
implicit solver.</p>
<ul>
<li>What switches has a mode: the side of the dead zone or of the limit of acceleration, moving, sticking, sliding at a limit of the
rate, resting on a stop, free or pushed play. Modes change at events only; between them the equations are smooth.</li>
<li>An event indicator is positive while the mode holds and becomes negative where it ends. In a mode that slides or sticks it is
the condition for leaving it: the force on a stop, for instance. Those of effects that do not act are 1. After each
accepted step the unit asks for event mode if an indicator is negative without having crossed zero.</li>
<li>The command may move, and may jump at events. Between accepted steps the command side takes it for straight: exact for steps and
ramps whose corners are input events; for a smooth command and steps <i>h</i> the delay errs by <i>h</i>² <i>c̈</i> / 8 (8 × 10⁻⁵ of the amplitude at 4 Hz and 1 ms), and the
play and the rate limit of the command by as much at a turn. Jumps and corners come out of the delay as time events. The load is taken as it is.</li>
<li>Quantisation has no indicators: nothing depends on the rounded measurement, and a solver would stop at every step of it.
Chatter and drifts are functions of time.</li>
<li><code>failure</code>, if set while the host integrates, comes into force at the next event. Tunable parameters are set in event mode.</li>
<li>Directional derivatives are given for co-simulation only.</li>
</ul>
<p>Some importers (fmpy 0.3) set the inputs only where a solver's step ends: a moving command then comes late by up to a step, steps of
the command do not. With steps of the command, fmpy's CVode at a relative tolerance of 10⁻¹⁰ stays within 10⁻⁷ of the exact co-simulation.</p>
";

const REFERENCES: &str = "<h2>Parameter sets and reference responses</h2>
<p>The folder <code>extra/org.fmi-standard.fmi-ls-ref</code> holds the sets as files (SSP) and the response to expect of each
(FMI-LS-REF): <a href=\"fmi-ls-ref.txt\">fmi-ls-ref.txt</a>.</p>
";

const LIMITS: &str = "<h2>Limits</h2>
<ul>
<li>The report's data span 0.5 to 12 Hz. Within that band eq. (1) and (6) are what was fitted; beyond it they extrapolate.</li>
<li>The pole <i>p</i> of 6 898 to 2.97 × 10⁸ 1/s lies far above that band and was hardly identifiable: its value means \"fast\".</li>
<li>The loaded sets gather Mach numbers of 0.63 to 0.91 and dynamic pressures of 74 to 190 psf.</li>
";

const REFUSALS: &str = "<li>Values out of their range, NaN, wrong value references and calls in the wrong state are refused with <code>fmi2Error</code> and a
log message; they change nothing, so that the instance can go on.</li>
";
