//! `SystemStructure.ssd`: SSP 1.0, SystemStructureDescription. Components with their inputs and outputs, some with a parameter set; no
//! connector of the system itself, since libcosim and Ecos look for the other end of every connection among components.

use serde::Serialize;

use super::values::GENERATION_TOOL;
use crate::xml;
use actuator_fmu::{
    error::Result,
    fmu::{
        MODEL_IDENTIFIER,
        units::{Unit as UnitDefinition, units},
        variables::{Causality, Kind, Variable, variables},
    },
    parameters::PositionUnit,
};

/// Name of the component of the default FMU, with which fmpy requires parameter names to begin.
pub(super) const COMPONENT: &str = "actuator";

const DESCRIPTION: &str = "http://ssp-standard.org/SSP1/SystemStructureDescription";
const COMMON: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";
/// libcosim takes its algorithm and its step from an annotation of this type, unless a step is given.
const LIBCOSIM: &str = "com.opensimulationplatform";
const LIBCOSIM_NAMESPACE: &str = "http://opensimulationplatform.com/SSP/OSPAnnotations";
/// Step and end of the FMU's default experiment: one second at the report's 200 samples per second.
const STEP_S: f64 = 0.005;
const STOP_TIME_S: f64 = 1.0;

#[derive(Serialize)]
#[serde(rename = "ssd:SystemStructureDescription")]
struct Document {
    #[serde(rename = "@xmlns:ssd")]
    namespace: &'static str,
    #[serde(rename = "@xmlns:ssc")]
    common: &'static str,
    #[serde(rename = "@xmlns:osp")]
    libcosim: &'static str, // not where it is used: libcosim takes an attribute of `osp:Algorithm` for an algorithm
    #[serde(rename = "@version")]
    version: &'static str, // Ecos accepts only 1.0
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@generationTool")]
    generation_tool: &'static str,
    #[serde(rename = "ssd:System")]
    system: System,
    #[serde(rename = "ssd:Units")]
    units: Units,
    #[serde(rename = "ssd:DefaultExperiment")]
    experiment: Experiment,
}

#[derive(Serialize)]
struct System {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@description")]
    description: String,
    #[serde(rename = "ssd:Elements")]
    elements: Elements,
}

#[derive(Serialize)]
struct Elements {
    #[serde(rename = "ssd:Component")]
    all: Vec<Component>,
}

#[derive(Serialize)]
struct Component {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@description")]
    description: String,
    #[serde(rename = "@type")]
    kind: &'static str,
    #[serde(rename = "@source")]
    source: String,
    #[serde(rename = "@implementation")]
    implementation: &'static str,
    #[serde(rename = "ssd:Connectors")]
    connectors: Connectors,
    #[serde(rename = "ssd:ParameterBindings", skip_serializing_if = "Option::is_none")]
    bindings: Option<Bindings>,
}

#[derive(Serialize)]
struct Connectors {
    #[serde(rename = "ssd:Connector")]
    all: Vec<Connector>,
}

#[derive(Serialize)]
struct Connector {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@kind")]
    kind: &'static str,
    #[serde(rename = "@description")]
    description: &'static str,
    #[serde(rename = "$value")]
    of: Type,
}

#[derive(Serialize)]
enum Type {
    #[serde(rename = "ssc:Real")]
    Real {
        #[serde(rename = "@unit")]
        unit: &'static str,
    },
    #[serde(rename = "ssc:Boolean")]
    Boolean {},
}

#[derive(Serialize)]
struct Bindings {
    #[serde(rename = "ssd:ParameterBinding")]
    one: Binding,
}

#[derive(Serialize)]
struct Binding {
    #[serde(rename = "@type")]
    kind: &'static str,
    #[serde(rename = "@source")]
    source: String,
}

#[derive(Serialize)]
struct Units {
    #[serde(rename = "ssc:Unit")]
    all: Vec<Unit>,
}

#[derive(Serialize)]
struct Unit {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "ssc:BaseUnit")]
    base: BaseUnit,
}

#[derive(Serialize)]
struct BaseUnit {
    #[serde(rename = "@m")]
    m: i32,
    #[serde(rename = "@s")]
    s: i32,
    #[serde(rename = "@rad")]
    rad: i32,
    #[serde(rename = "@factor")]
    factor: f64,
}

#[derive(Serialize)]
struct Experiment {
    #[serde(rename = "@startTime")]
    start: f64,
    #[serde(rename = "@stopTime")]
    stop: f64,
    #[serde(rename = "ssd:Annotations")]
    annotations: Annotations,
}

#[derive(Serialize)]
struct Annotations {
    #[serde(rename = "ssc:Annotation")]
    one: Annotation,
}

#[derive(Serialize)]
struct Annotation {
    #[serde(rename = "@type")]
    kind: &'static str,
    #[serde(rename = "osp:Algorithm")]
    algorithm: Algorithm,
}

#[derive(Serialize)]
struct Algorithm {
    #[serde(rename = "osp:FixedStepAlgorithm")]
    fixed_step: FixedStep,
}

#[derive(Serialize)]
struct FixedStep {
    #[serde(rename = "@baseStepSize")]
    step: f64,
}

/// A component in the description of the system.
pub(super) struct Part<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its description.
    pub description: &'a str,
    /// Unit of its positions.
    pub unit: PositionUnit,
    /// Path of its FMU inside the archive.
    pub fmu: String,
    /// Path of the parameter set applied to it, if any.
    pub set: Option<String>,
}

/// The description of a system of these components.
pub(super) fn description(summary: String, parts: &[Part<'_>]) -> Result<String> {
    let components: Vec<Component> = parts.iter().map(component).collect();
    let document = Document {
        namespace: DESCRIPTION,
        common: COMMON,
        libcosim: LIBCOSIM_NAMESPACE,
        version: "1.0",
        name: MODEL_IDENTIFIER,
        generation_tool: GENERATION_TOOL,
        units: Units { all: used_units(parts, &components) },
        system: System { name: "system", description: summary, elements: Elements { all: components } },
        experiment: Experiment {
            start: 0.0,
            stop: STOP_TIME_S,
            annotations: Annotations {
                one: Annotation { kind: LIBCOSIM, algorithm: Algorithm { fixed_step: FixedStep { step: STEP_S } } },
            },
        },
    };
    xml::document("SystemStructure.ssd", &document)
}

fn component(part: &Part<'_>) -> Component {
    let binding =
        |set: &String| Bindings { one: Binding { kind: "application/x-ssp-parameter-set", source: set.clone() } };
    Component {
        name: part.name.to_owned(),
        description: part.description.to_owned(),
        kind: "application/x-fmu-sharedlibrary",
        source: part.fmu.clone(),
        implementation: "CoSimulation",
        connectors: Connectors {
            all: variables().iter().filter_map(|variable| connector(variable, part.unit)).collect(),
        },
        bindings: part.set.as_ref().map(binding),
    }
}

/// Definitions of the units of all connectors, each once.
fn used_units(parts: &[Part<'_>], components: &[Component]) -> Vec<Unit> {
    let connectors = || components.iter().flat_map(|component| &component.connectors.all);
    let is_used =
        |name: &str| connectors().any(|connector| matches!(connector.of, Type::Real { unit } if unit == name));
    let mut used: Vec<UnitDefinition> = Vec::new();
    for unit in parts.iter().flat_map(|part| units(part.unit)) {
        if is_used(unit.name) && !used.iter().any(|other| other.name == unit.name) {
            used.push(unit);
        }
    }
    let base = |unit: &UnitDefinition| BaseUnit { m: unit.m, s: unit.s, rad: unit.rad, factor: unit.factor };
    used.iter().map(|unit| Unit { name: unit.name, base: base(unit) }).collect()
}

/// Inputs and outputs other than enumerations, at which libcosim stops.
fn connector(variable: &'static Variable, position: PositionUnit) -> Option<Connector> {
    let kind = match variable.causality {
        Causality::Input => "input",
        Causality::Output => "output",
        _ => return None,
    };
    let of = match variable.kind {
        Kind::Real { unit, .. } => Type::Real { unit: position.derived(unit) },
        Kind::Boolean => Type::Boolean {},
        _ => return None,
    };
    Some(Connector { name: &variable.name, kind, description: &variable.description, of })
}
