//! `modelDescription.xml`, rendered from the list of variables.

mod structure;

use std::borrow::Cow;

use fmi_export::Model;
use quick_xml::se::Serializer;
use serde::Serialize;
use structure::{ModelStructure, structure};

use actuator_fmu::fmu::{
    ActuatorModel, CATEGORIES, MODEL_IDENTIFIER, Start, Value, guid, start_value,
    units::{Unit as UnitDefinition, display_unit, quantity, units},
    variables::{self, Causality, ENUMERATIONS, Kind, Slot, Variability, Variable, variables},
};
use actuator_fmu::{
    effects::Effects,
    error::{Error, Result},
    parameters::{PositionUnit, SOURCE},
};

type Text = Cow<'static, str>;

#[derive(Serialize)]
#[serde(rename = "fmiModelDescription")]
struct ModelDescription {
    #[serde(rename = "@fmiVersion")]
    fmi_version: &'static str,
    #[serde(rename = "@modelName")]
    model_name: String,
    #[serde(rename = "@guid")]
    guid: String,
    #[serde(rename = "@description")]
    description: String,
    #[serde(rename = "@version")]
    version: &'static str,
    #[serde(rename = "@license")]
    license: &'static str,
    #[serde(rename = "@generationTool")]
    generation_tool: String,
    #[serde(rename = "@variableNamingConvention")]
    variable_naming_convention: &'static str,
    #[serde(rename = "@numberOfEventIndicators")]
    event_indicators: usize,
    #[serde(rename = "ModelExchange")]
    model_exchange: ModelExchange,
    #[serde(rename = "CoSimulation")]
    co_simulation: CoSimulation,
    #[serde(rename = "UnitDefinitions")]
    units: Units,
    #[serde(rename = "TypeDefinitions")]
    types: Types,
    #[serde(rename = "LogCategories")]
    log_categories: LogCategories,
    #[serde(rename = "DefaultExperiment")]
    default_experiment: DefaultExperiment,
    #[serde(rename = "ModelVariables")]
    variables: ModelVariables,
    #[serde(rename = "ModelStructure")]
    structure: ModelStructure,
}

#[derive(Serialize)]
struct ModelExchange {
    #[serde(rename = "@modelIdentifier")]
    model_identifier: &'static str,
    #[serde(rename = "@canNotUseMemoryManagementFunctions")]
    own_memory: bool,
    #[serde(rename = "@canGetAndSetFMUstate")]
    saves: bool,
    #[serde(rename = "@canSerializeFMUstate")]
    serializes: bool,
    #[serde(rename = "@providesDirectionalDerivative")]
    directional_derivatives: bool,
}

#[derive(Serialize)]
struct CoSimulation {
    #[serde(rename = "@modelIdentifier")]
    model_identifier: &'static str,
    #[serde(rename = "@canHandleVariableCommunicationStepSize")]
    variable_step: bool,
    #[serde(rename = "@canInterpolateInputs")]
    interpolates: bool,
    #[serde(rename = "@maxOutputDerivativeOrder")]
    output_derivatives: u8,
    #[serde(rename = "@canNotUseMemoryManagementFunctions")]
    own_memory: bool,
    #[serde(rename = "@canGetAndSetFMUstate")]
    saves: bool,
    #[serde(rename = "@canSerializeFMUstate")]
    serializes: bool,
    #[serde(rename = "@providesDirectionalDerivative")]
    directional_derivatives: bool,
}

#[derive(Serialize)]
struct Units {
    #[serde(rename = "Unit")]
    all: Vec<Unit>,
}

#[derive(Serialize)]
struct Unit {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "BaseUnit")]
    base: BaseUnit,
    #[serde(rename = "DisplayUnit", skip_serializing_if = "Option::is_none")]
    display: Option<DisplayUnit>,
}

#[derive(Serialize)]
struct BaseUnit {
    #[serde(rename = "@m", skip_serializing_if = "is_zero")]
    m: i32,
    #[serde(rename = "@s", skip_serializing_if = "is_zero")]
    s: i32,
    #[serde(rename = "@rad", skip_serializing_if = "is_zero")]
    rad: i32,
    #[serde(rename = "@factor", skip_serializing_if = "is_one")]
    factor: f64,
}

#[derive(Serialize)]
struct DisplayUnit {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@factor")]
    factor: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // the signature serde asks for
fn is_zero(number: &i32) -> bool {
    *number == 0
}

#[allow(clippy::float_cmp)] // only the exact value is left out
fn is_one(number: &f64) -> bool {
    *number == 1.0
}

#[derive(Serialize)]
struct Types {
    #[serde(rename = "SimpleType")]
    all: Vec<SimpleType>,
}

#[derive(Serialize)]
struct SimpleType {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@description")]
    description: &'static str,
    #[serde(rename = "Enumeration")]
    enumeration: Items,
}

#[derive(Serialize)]
struct Items {
    #[serde(rename = "Item")]
    all: Vec<Item>,
}

#[derive(Serialize)]
struct Item {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@value")]
    value: usize,
}

#[derive(Serialize)]
struct LogCategories {
    #[serde(rename = "Category")]
    all: Vec<Category>,
}

#[derive(Serialize)]
struct Category {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@description")]
    description: &'static str,
}

#[derive(Serialize)]
struct DefaultExperiment {
    #[serde(rename = "@startTime")]
    start: f64,
    #[serde(rename = "@stopTime")]
    stop: f64,
    #[serde(rename = "@stepSize")]
    step: f64,
}

#[derive(Serialize)]
struct ModelVariables {
    #[serde(rename = "ScalarVariable")]
    all: Vec<ScalarVariable>,
}

#[derive(Serialize)]
struct ScalarVariable {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@valueReference")]
    reference: usize,
    #[serde(rename = "@description")]
    description: String,
    #[serde(rename = "@causality")]
    causality: &'static str,
    #[serde(rename = "@variability")]
    variability: &'static str,
    #[serde(rename = "@initial", skip_serializing_if = "Option::is_none")]
    initial: Option<&'static str>,
    #[serde(rename = "$value")]
    kind: Type,
}

#[derive(Serialize)]
enum Type {
    Real(Attributes),
    Integer(Attributes),
    Boolean(Attributes),
    Enumeration(Attributes),
}

#[derive(Serialize, Default)]
struct Attributes {
    #[serde(rename = "@declaredType", skip_serializing_if = "Option::is_none")]
    declared_type: Option<&'static str>,
    #[serde(rename = "@quantity", skip_serializing_if = "Option::is_none")]
    quantity: Option<&'static str>,
    #[serde(rename = "@unit", skip_serializing_if = "Option::is_none")]
    unit: Option<&'static str>,
    #[serde(rename = "@displayUnit", skip_serializing_if = "Option::is_none")]
    display_unit: Option<&'static str>,
    #[serde(rename = "@min", skip_serializing_if = "Option::is_none")]
    min: Option<Text>,
    #[serde(rename = "@max", skip_serializing_if = "Option::is_none")]
    max: Option<Text>,
    #[serde(rename = "@nominal", skip_serializing_if = "Option::is_none")]
    nominal: Option<f64>,
    #[serde(rename = "@start", skip_serializing_if = "Option::is_none")]
    start: Option<Text>,
    #[serde(rename = "@derivative", skip_serializing_if = "Option::is_none")]
    derivative: Option<usize>,
}

/// The XML of the model with these start values.
///
/// # Errors
/// None in practice; the XML writer's own.
pub fn xml(start: &Start) -> Result<String> {
    let description = ModelDescription {
        fmi_version: "2.0",
        model_name: one_line(start.identity.name.as_deref().unwrap_or(MODEL_IDENTIFIER)),
        guid: guid(start),
        description: one_line(&summary(start)),
        version: env!("CARGO_PKG_VERSION"),
        license: env!("CARGO_PKG_LICENSE"),
        generation_tool: format!("actuator-fmu {}", env!("CARGO_PKG_VERSION")),
        variable_naming_convention: "structured",
        event_indicators: <ActuatorModel as Model>::EVENT_INDICATORS,
        model_exchange: ModelExchange {
            model_identifier: MODEL_IDENTIFIER,
            own_memory: true,
            saves: true,
            serializes: true,
            directional_derivatives: true,
        },
        co_simulation: CoSimulation {
            model_identifier: MODEL_IDENTIFIER,
            variable_step: true,
            interpolates: true,
            output_derivatives: 1,
            own_memory: true,
            saves: true,
            serializes: true,
            directional_derivatives: true,
        },
        units: Units { all: units(start.identity.unit).iter().map(unit).collect() },
        types: Types { all: ENUMERATIONS.iter().map(simple_type).collect() },
        log_categories: LogCategories {
            all: CATEGORIES.iter().map(|(name, description)| Category { name, description }).collect(),
        },
        // One second at the report's 200 samples per second.
        default_experiment: DefaultExperiment { start: 0.0, stop: 1.0, step: 0.005 },
        variables: ModelVariables {
            all: variables()
                .iter()
                .enumerate()
                .map(|(reference, variable)| scalar_variable(reference, variable, start))
                .collect(),
        },
        structure: structure(),
    };
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let mut serializer = Serializer::new(&mut text);
    serializer.indent(' ', 2);
    description
        .serialize(serializer)
        .map_err(|error| Error::new("modelDescription.xml", error.to_string(), "values that XML can hold"))?;
    text.push('\n');
    Ok(text)
}

/// What the FMU is a model of, in a sentence: the description of its model file, else what follows from its values.
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

fn unit(unit: &UnitDefinition) -> Unit {
    let base = BaseUnit { m: unit.m, s: unit.s, rad: unit.rad, factor: unit.factor };
    Unit { name: unit.name, base, display: unit.display.map(|(name, factor)| DisplayUnit { name, factor }) }
}

fn simple_type(of: &variables::Enumeration) -> SimpleType {
    let items = of.items.iter().zip(1..).map(|(name, value)| Item { name, value }).collect();
    SimpleType { name: of.name, description: of.description, enumeration: Items { all: items } }
}

fn scalar_variable(reference: usize, variable: &Variable, start: &Start) -> ScalarVariable {
    let position = start.identity.unit;
    let start = start_value(variable.slot, &start.settings).map(|value| match value {
        Value::Real(value) => Text::from(value.to_string()),
        Value::Integer(value) => Text::from(value.to_string()),
        Value::Boolean(value) => Text::from(value.to_string()),
    });
    let derivative = match variable.slot {
        Slot::Slope(of) => variables().iter().position(|other| other.slot == Slot::State(of)).map(|index| index + 1),
        _ => None,
    };
    let attributes = Attributes { start, derivative, ..Attributes::default() };
    let kind = match &variable.kind {
        Kind::Real { unit, range, nominal } => Type::Real(Attributes {
            quantity: quantity(position.derived(unit)),
            unit: Some(position.derived(unit)),
            display_unit: display_unit(position).filter(|_| *unit == PositionUnit::default().name()),
            min: range.map(|(min, _)| min.to_string().into()),
            max: range.map(|(_, max)| max.to_string().into()),
            nominal: nominal.map(|nominal| nominal * position.typical().powi(PositionUnit::power(unit))),
            ..attributes
        }),
        Kind::Integer { min, max } => Type::Integer(Attributes {
            min: Some(min.to_string().into()),
            max: Some(max.to_string().into()),
            ..attributes
        }),
        Kind::Boolean => Type::Boolean(attributes),
        Kind::Enumeration(of) => Type::Enumeration(Attributes { declared_type: Some(of.name), ..attributes }),
    };
    let (causality, initial) = match variable.causality {
        Causality::Input => ("input", None),
        Causality::Output => ("output", Some("calculated")),
        Causality::Parameter => ("parameter", Some("exact")),
        Causality::CalculatedParameter => ("calculatedParameter", Some("calculated")),
        Causality::Local => ("local", Some("calculated")),
    };
    let variability = match variable.variability {
        Variability::Continuous => "continuous",
        Variability::Discrete => "discrete",
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
    };
    ScalarVariable {
        name: variable.name.clone(),
        reference,
        description: variable.description.clone(),
        causality,
        variability,
        initial,
        kind,
    }
}
