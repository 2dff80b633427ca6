//! `modelDescription.xml`, from the list of variables that a model implements: the description and the behaviour of an instance cannot
//! differ.
//!
//! [`Describe`] adds what the list does not contain: start values, units, dependencies. [`xml`] writes the file.

mod xml;

use xml::Document;

use crate::{
    calls::Kind,
    log::CATEGORIES,
    model::Model,
    variable::{Causality, Enumeration, Type, Value, Variability, Variable},
};

/// The file as a whole.
#[derive(Debug, Clone)]
pub struct Header<'a> {
    /// `modelName`
    pub name: &'a str,
    /// `guid`, which [`Model::start`] expects.
    pub guid: &'a str,
    /// Description of the model, in a sentence.
    pub description: &'a str,
    /// Version of the model.
    pub version: &'a str,
    /// Its licence.
    pub license: &'a str,
    /// Generating tool.
    pub generation_tool: &'a str,
    /// Names of variables are structured by dots, and derivatives are `der(name)`.
    pub has_structured_names: bool,
    /// Optional capabilities that the model implements.
    pub capabilities: Capabilities,
    /// Every unit of the variables, once.
    pub units: &'a [Unit],
    /// Every enumeration of the variables, once.
    pub enumerations: &'a [Enumeration],
    /// Default experiment of a host: start, stop and step \[s\].
    pub experiment: Option<[f64; 3]>,
}

/// Optional capabilities of a model.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// [`Model::set_input_derivatives`]
    pub interpolates_inputs: bool,
    /// Highest order of [`Model::output_derivative`].
    pub output_derivative_order: u8,
    /// [`Model::partial_derivative`]
    pub directional_derivatives: bool,
}

/// Definition of a unit: value in SI base units = factor × value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Name used by the variables.
    pub name: &'static str,
    /// Exponents of kilogram, metre, second and radian.
    pub kg_m_s_rad: [i32; 4],
    /// Factor.
    pub factor: f64,
    /// Another unit to display values in, with displayed value = factor × value.
    pub display: Option<(&'static str, f64)>,
}

/// Form of a unit of the list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitUse {
    /// Its name, which [`Header::units`] defines.
    pub name: &'static str,
    /// The quantity, by which some tools convert.
    pub quantity: Option<&'static str>,
    /// The unit in which values are displayed.
    pub display: Option<&'static str>,
    /// Factor on nominal values.
    pub nominal: f64,
}

/// Dependencies of an unknown.
pub enum Dependencies<'a, Slot> {
    /// All variables.
    All,
    /// The variables for which this is true.
    On(Box<dyn Fn(Slot) -> bool + 'a>),
}

impl<Slot> Dependencies<'_, Slot> {
    /// None.
    #[must_use]
    pub fn none() -> Self {
        Self::On(Box::new(|_| false))
    }
}

/// Data that the list of variables does not contain.
pub trait Describe<M: Model> {
    /// Start value, of inputs and parameters.
    fn start(&self, slot: M::Slot) -> Option<Value>;

    /// Form of a unit of the list.
    fn unit(&self, name: &'static str) -> UnitUse {
        UnitUse { name, quantity: None, display: None, nominal: 1.0 }
    }

    /// The state of which this is the derivative.
    fn state_of(&self, _derivative: M::Slot) -> Option<M::Slot> {
        None
    }

    /// Dependencies of an output or a derivative.
    fn dependencies(&self, unknown: M::Slot) -> Dependencies<'_, M::Slot>;

    /// Dependencies of an output, a state, a derivative or a calculated parameter in initialization mode.
    fn initial_dependencies(&self, unknown: M::Slot) -> Dependencies<'_, M::Slot>;
}

/// The file.
pub fn xml<M: Model<Slot: PartialEq>>(header: &Header, model: &impl Describe<M>) -> String {
    let mut document = Document::new();
    let attributes = [
        ("fmiVersion", some("2.0")),
        ("modelName", some(header.name)),
        ("guid", some(header.guid)),
        ("description", some(header.description)),
        ("version", some(header.version)),
        ("license", some(header.license)),
        ("generationTool", some(header.generation_tool)),
        ("variableNamingConvention", some(if header.has_structured_names { "structured" } else { "flat" })),
        ("numberOfEventIndicators", exchanges::<M>().then(|| M::EVENT_INDICATORS.to_string())),
    ];
    document.element("fmiModelDescription", &attributes, |document| {
        kinds::<M>(document, header.capabilities);
        document.element("UnitDefinitions", &[], |document| header.units.iter().for_each(|of| unit(document, of)));
        if !header.enumerations.is_empty() {
            document.element("TypeDefinitions", &[], |document| {
                header.enumerations.iter().for_each(|of| enumeration(document, of));
            });
        }
        document.element("LogCategories", &[], |document| {
            for (name, description) in CATEGORIES {
                document.empty("Category", &[("name", some(name)), ("description", some(description))]);
            }
        });
        if let Some([start, stop, step]) = header.experiment {
            let attributes = [("startTime", some(start)), ("stopTime", some(stop)), ("stepSize", some(step))];
            document.empty("DefaultExperiment", &attributes);
        }
        document.element("ModelVariables", &[], |document| {
            M::variables().iter().enumerate().for_each(|(at, of)| variable::<M>(document, at, of, model));
        });
        document.element("ModelStructure", &[], |document| structure::<M>(document, model));
    });
    document.finish()
}

fn some(value: impl ToString) -> Option<String> {
    Some(value.to_string())
}

fn exchanges<M: Model>() -> bool {
    M::KINDS.contains(&Kind::ModelExchange)
}

fn kinds<M: Model>(document: &mut Document, capabilities: Capabilities) {
    let yes = || some(true);
    let yes_if = |is_capable: bool| is_capable.then(|| true.to_string());
    let common = [
        ("canNotUseMemoryManagementFunctions", yes()),
        ("canGetAndSetFMUstate", yes()),
        ("canSerializeFMUstate", yes()),
        ("providesDirectionalDerivative", yes_if(capabilities.directional_derivatives)),
    ];
    let identifier = [("modelIdentifier", some(M::IDENTIFIER))];
    if exchanges::<M>() {
        document.empty("ModelExchange", &[&identifier[..], &common].concat());
    }
    if M::KINDS.contains(&Kind::CoSimulation) {
        let order = capabilities.output_derivative_order;
        let own = [
            ("canHandleVariableCommunicationStepSize", yes()),
            ("canInterpolateInputs", yes_if(capabilities.interpolates_inputs)),
            ("maxOutputDerivativeOrder", (order > 0).then(|| order.to_string())),
        ];
        document.empty("CoSimulation", &[&identifier[..], &own, &common].concat());
    }
}

#[allow(clippy::float_cmp)] // only the exact value is omitted
fn unit(document: &mut Document, unit: &Unit) {
    let exponents = ["kg", "m", "s", "rad"].into_iter().zip(unit.kg_m_s_rad);
    let mut base: Vec<_> =
        exponents.map(|(name, exponent)| (name, (exponent != 0).then(|| exponent.to_string()))).collect();
    base.push(("factor", (unit.factor != 1.0).then(|| unit.factor.to_string())));
    document.element("Unit", &[("name", some(unit.name))], |document| {
        document.empty("BaseUnit", &base);
        if let Some((name, factor)) = unit.display {
            document.empty("DisplayUnit", &[("name", some(name)), ("factor", some(factor))]);
        }
    });
}

fn enumeration(document: &mut Document, of: &Enumeration) {
    let attributes = [("name", some(of.name)), ("description", some(of.description))];
    document.element("SimpleType", &attributes, |document| {
        document.element("Enumeration", &[], |document| {
            for (name, value) in of.items.iter().zip(1..) {
                document.empty("Item", &[("name", some(name)), ("value", some(value))]);
            }
        });
    });
}

/// Index of a variable, counted from 1.
fn index<M: Model<Slot: PartialEq>>(slot: M::Slot) -> Option<String> {
    M::variables().iter().position(|other| other.slot == slot).map(|index| (index + 1).to_string())
}

fn variable<M: Model<Slot: PartialEq>>(
    document: &mut Document,
    reference: usize,
    variable: &Variable<M::Slot>,
    model: &impl Describe<M>,
) {
    let start = model.start(variable.slot).map(|value| match value {
        Value::Real(value) => value.to_string(),
        Value::Integer(value) => value.to_string(),
        Value::Boolean(value) => value.to_string(),
    });
    let derivative = model.state_of(variable.slot).and_then(index::<M>);
    let (name, mut attributes) = match &variable.kind {
        Type::Real { unit, range, nominal } => {
            let unit = model.unit(unit);
            let attributes = vec![
                ("quantity", unit.quantity.map(str::to_owned)),
                ("unit", some(unit.name)),
                ("displayUnit", unit.display.map(str::to_owned)),
                ("min", range.map(|(min, _)| min.to_string())),
                ("max", range.map(|(_, max)| max.to_string())),
                ("nominal", nominal.map(|nominal| (nominal * unit.nominal).to_string())),
            ];
            ("Real", attributes)
        }
        Type::Integer { min, max } => ("Integer", vec![("min", some(min)), ("max", some(max))]),
        Type::Boolean => ("Boolean", Vec::new()),
        Type::Enumeration(of) => ("Enumeration", vec![("declaredType", some(of.name))]),
    };
    attributes.extend([("start", start), ("derivative", derivative)]);
    let (causality, initial) = match variable.causality {
        Causality::Input => ("input", None),
        Causality::Output => ("output", some("calculated")),
        Causality::Parameter => ("parameter", some("exact")),
        Causality::CalculatedParameter => ("calculatedParameter", some("calculated")),
        Causality::Local => ("local", some("calculated")),
    };
    let variability = match variable.variability {
        Variability::Continuous => "continuous",
        Variability::Discrete => "discrete",
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
    };
    let described = [
        ("name", some(&variable.name)),
        ("valueReference", some(reference)),
        ("description", some(&variable.description)),
        ("causality", some(causality)),
        ("variability", some(variability)),
        ("initial", initial),
    ];
    document.element("ScalarVariable", &described, |document| document.empty(name, &attributes));
}

fn structure<M: Model<Slot: PartialEq>>(document: &mut Document, model: &impl Describe<M>) {
    let unknowns = |document: &mut Document,
                    name: &str,
                    wanted: &dyn Fn(&Variable<M::Slot>) -> bool,
                    depends: &dyn Fn(M::Slot) -> Option<String>| {
        let all = || M::variables().iter().zip(1..).filter(|(variable, _)| wanted(variable));
        if all().next().is_some() {
            document.element(name, &[], |document| {
                for (variable, index) in all() {
                    let attributes = [("index", some(index)), ("dependencies", depends(variable.slot))];
                    document.empty("Unknown", &attributes);
                }
            });
        }
    };
    let is_output = |variable: &Variable<M::Slot>| variable.causality == Causality::Output;
    let later = |slot| indices::<M>(&model.dependencies(slot));
    unknowns(document, "Outputs", &is_output, &later);
    unknowns(document, "Derivatives", &|variable| model.state_of(variable.slot).is_some(), &later);
    let is_unknown = |variable: &Variable<M::Slot>| {
        is_output(variable) || matches!(variable.causality, Causality::CalculatedParameter | Causality::Local)
    };
    unknowns(document, "InitialUnknowns", &is_unknown, &|slot| indices::<M>(&model.initial_dependencies(slot)));
}

/// Omitted if it is everything.
fn indices<M: Model>(dependencies: &Dependencies<M::Slot>) -> Option<String> {
    let Dependencies::On(is_one) = dependencies else { return None };
    let all = M::variables().iter().zip(1..).filter(|(variable, _)| is_one(variable.slot));
    let numbers: Vec<String> = all.map(|(_, index): (_, usize)| index.to_string()).collect();
    Some(numbers.join(" "))
}
