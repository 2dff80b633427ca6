//! `documentation/index.html` of the FMU of a model: its parameters, effects, units and provenance.

use std::fmt::Write as _;

use super::{EXCHANGE, REFUSALS, effect_table, equations, escaped, head, variable_table};
use crate::description::summary;
use actuator_fmu::{
    effects::Effects,
    fmu::{MODEL_IDENTIFIER, Start, guid},
    parameters::{Base, Model, Order, Provenance},
};
use identification::digits::significant;

/// The page of a model.
#[must_use]
pub fn html(model: &Model) -> String {
    let start = Start::from_model(model);
    let name = escaped(model.identity.name.as_deref().unwrap_or(MODEL_IDENTIFIER));
    let unit = model.unit();
    let mut page = head(&name);
    // Writing to a String cannot fail.
    let _ = write!(
        page,
        "<p>{}</p>\n<p>FMI 2.0 unit, for co-simulation and for model exchange. Command, position and load are in <b>{unit}</b>, \
         rates in {}.</p>\n",
        escaped(&summary(&start)),
        unit.of_rate()
    );
    page.push_str(&numbers(model));
    page.push_str(&provenance(&model.provenance));
    page.push_str("<h2>Equations</h2>\n");
    page.push_str(&equations("of the source below", model.order));
    page.push_str(&usage(model));
    page.push_str("<h2>All effects</h2>\n<p>At its neutral value an effect is exactly nothing.</p>\n");
    page.push_str(&effect_table(unit));
    page.push_str(EXCHANGE);
    page.push_str(&variable_table(unit));
    let _ = write!(
        page,
        "<h2>Limits</h2>\n<ul>\n<li>The model holds where the records it was identified from excited the actuator, in frequency and \
         amplitude; beyond that it extrapolates.</li>\n{REFUSALS}</ul>\n\
         <h2>Source</h2>\n<p>Equations: eq. (1) and (6) of M. R. Waszak and J. Fung, NASA/TM-1998-208452. The variables <code>surface</code>, \
         <code>stage</code>, <code>load_case</code> and <code>set_number</code> select that report's actuators and have no effect while \
         <code>source</code> is <code>custom</code>, as it is at the start.</p>\n\
         <p>actuator-fmu {}, GUID <code>{}</code>. <code>resources/model.toml</code> is the model file.</p>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION"),
        guid(&start)
    );
    page
}

/// Its base and its active effects.
fn numbers(model: &Model) -> String {
    let unit = model.unit();
    let mut rows = String::new();
    let mut row = |name: &str, value: f64, error: Option<f64>, unit: &str, meaning: &str| {
        let error = error.map_or_else(String::new, |error| significant(error, 3));
        let _ = writeln!(
            rows,
            "<tr><td><code>{name}</code></td><td class=\"number\">{value}</td><td class=\"number\">{error}</td><td>{unit}</td><td>{meaning}</td></tr>"
        );
    };
    for ((parameter, value), error) in Base::PARAMETERS.iter().zip(model.base.values()).zip(model.std_errors) {
        if parameter.name != "p" || model.order == Order::Third {
            row(parameter.name, value, error, unit.derived(parameter.unit), parameter.meaning);
        }
    }
    let values = model.effects.values().iter().zip(&model.effect_std_errors);
    for ((effect, parameter), (value, error)) in Effects::parameters().zip(values) {
        if model.effects.active().any(|(active, _)| active.name == effect.name) {
            let name = format!("{}.{}", effect.name, parameter.name);
            row(&name, *value, *error, unit.derived(parameter.unit), parameter.meaning);
        }
    }
    format!(
        "<h2>Numbers</h2>\n<p>Order of the transfer function: {}.</p>\n<div class=\"scroll\"><table>\n<tr><th>parameter</th><th>value</th>\
         <th>standard error</th><th>unit</th><th>meaning</th></tr>\n{rows}</table></div>\n",
        model.order.name()
    )
}

fn provenance(provenance: &Provenance) -> String {
    let Provenance { records, hashes, method, date } = provenance;
    let mut text = String::from("<h2>Provenance</h2>\n");
    if let Some(method) = method {
        let _ = writeln!(text, "<p>Method: {}.</p>", escaped(method));
    }
    if let Some(date) = date {
        let _ = writeln!(text, "<p>Date: {}.</p>", escaped(date));
    }
    if records.is_empty() {
        text.push_str("<p>The model file names no records.</p>\n");
        return text;
    }
    text.push_str("<ul>\n");
    for (index, record) in records.iter().enumerate() {
        let hash =
            hashes.get(index).map_or_else(String::new, |hash| format!(" (SHA-256 <code>{}</code>)", escaped(hash)));
        let _ = writeln!(text, "<li>{}{hash}</li>", escaped(record));
    }
    text.push_str("</ul>\n");
    text
}

fn usage(model: &Model) -> String {
    format!(
        "<h2>Use</h2>\n<p>The start values are the numbers above: nothing has to be set. <code>custom.*</code> and the parameters of the \
         effects may be changed between steps. With fmpy, a step of {} {}:</p>\n\
         <pre>from fmpy import simulate_fmu\nresult = simulate_fmu('model.fmu', stop_time=0.2, output_interval=0.005, start_values={{'command': {}}})</pre>\n",
        model.unit().typical(),
        model.unit(),
        model.unit().typical()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use actuator_fmu::parameters::{Identity, PositionUnit};

    #[test]
    fn the_page_of_a_model_is_about_that_model() {
        let base = Base::new(1.25, 1e4, 77.0, 0.61).unwrap();
        let identity = Identity {
            name: Some("Rudder <A>".into()),
            description: Some("Servo of the rudder rig & its horn".into()),
            unit: PositionUnit::Millimetre,
        };
        let records =
            Provenance { records: vec!["sweep.csv".into()], hashes: vec!["ab12".into()], ..Provenance::default() };
        let page = html(&Model { identity, provenance: records, ..Model::new(base, Order::Second) });
        for words in
            ["<h1>Rudder &lt;A&gt;</h1>", "Servo of the rudder rig &amp; its horn", "mm/mm", "77", "sweep.csv", "ab12"]
        {
            assert!(page.contains(words), "{words}");
        }
        for words in ["BACT", "te-early-unloaded", "[deg]", "<code>p</code>"] {
            assert!(!page.contains(words), "{words}");
        }
    }
}
