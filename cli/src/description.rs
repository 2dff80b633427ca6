//! `modelDescription.xml` of the actuator, from its list of variables.

mod structure;

use fmi_export::{
    Value,
    description::{self, Capabilities, Dependencies, Describe, Header, Unit, UnitUse},
};

use actuator_fmu::{
    effects::Effects,
    fmu::{
        ActuatorModel, MODEL_IDENTIFIER, Start, guid, start_value,
        units::{display_unit, quantity, units},
        variables::{ENUMERATIONS, Slot},
    },
    parameters::{PositionUnit, SOURCE},
};

/// The actuator with these start values.
struct Actuator<'a>(&'a Start);

impl Describe<ActuatorModel> for Actuator<'_> {
    fn start(&self, slot: Slot) -> Option<Value> {
        start_value(slot, &self.0.settings)
    }

    fn unit(&self, name: &'static str) -> UnitUse {
        let position = self.0.identity.unit;
        let derived = position.derived(name);
        UnitUse {
            name: derived,
            quantity: quantity(derived),
            display: display_unit(position).filter(|_| name == PositionUnit::default().name()),
            nominal: position.typical().powi(PositionUnit::power(name)),
        }
    }

    fn state_of(&self, derivative: Slot) -> Option<Slot> {
        if let Slot::Slope(state) = derivative { Some(Slot::State(state)) } else { None }
    }

    fn dependencies(&self, unknown: Slot) -> Dependencies<'_, Slot> {
        Dependencies::On(Box::new(move |known| structure::depends(unknown, known)))
    }

    fn initial_dependencies(&self, unknown: Slot) -> Dependencies<'_, Slot> {
        match unknown {
            // Any effect may act on the forces at the start, and any parameter may select it.
            Slot::Slope(_) => Dependencies::All,
            _ => Dependencies::On(Box::new(move |known| structure::depends_initially(unknown, known))),
        }
    }
}

/// The XML of the model with these start values.
#[must_use]
pub fn xml(start: &Start) -> String {
    let units: Vec<Unit> = units(start.identity.unit)
        .iter()
        .map(|unit| Unit {
            name: unit.name,
            kg_m_s_rad: [0, unit.m, unit.s, unit.rad],
            factor: unit.factor,
            display: unit.display,
        })
        .collect();
    let header = Header {
        name: &one_line(start.identity.name.as_deref().unwrap_or(MODEL_IDENTIFIER)),
        guid: &guid(start),
        description: &one_line(&summary(start)),
        version: env!("CARGO_PKG_VERSION"),
        license: env!("CARGO_PKG_LICENSE"),
        generation_tool: &format!("actuator-fmu {}", env!("CARGO_PKG_VERSION")),
        has_structured_names: true,
        capabilities: Capabilities {
            interpolates_inputs: true,
            output_derivative_order: 1,
            directional_derivatives: true,
        },
        units: &units,
        enumerations: &ENUMERATIONS,
        // One second at the report's 200 samples per second.
        experiment: Some([0.0, 1.0, 0.005]),
    };
    description::xml(&header, &Actuator(start))
}

/// Description of the FMU in a sentence: that of its model file, otherwise generated from its values.
#[must_use]
pub fn summary(start: &Start) -> String {
    if let Some(description) = &start.identity.description {
        return description.clone();
    }
    if !start.settings.is_custom() {
        return format!("Trailing-edge and spoiler actuators of the BACT wind-tunnel model, as identified in {SOURCE}");
    }
    let effects: Vec<&str> = Effects::with_values(&start.settings.effects)
        .map(|effects| effects.active().map(|(effect, _)| effect.name).collect())
        .unwrap_or_default();
    let with = if effects.is_empty() { String::new() } else { format!(", with {}", effects.join(", ")) };
    format!(
        "Identified actuator of {} order, positions in {}{with}",
        start.settings.order().name(),
        start.identity.unit
    )
}

/// Attributes of XML hold one line.
fn one_line(text: &str) -> String {
    text.split(|letter: char| letter.is_whitespace() || letter.is_control())
        .filter(|word| !word.is_empty())
        .collect::<Vec<&str>>()
        .join(" ")
}
