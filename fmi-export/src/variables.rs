//! The list of variables of a model, with the data for checks of each precomputed.

use std::ops::Deref;

use crate::{
    calls::{Phase, phases},
    error::{Error, Result},
    variable::{Type, Value, Variable},
};

/// The variables of a model. The value reference of a variable is its index.
#[derive(Debug)]
pub struct Variables<Slot> {
    all: Vec<Variable<Slot>>,
    access: Vec<Access<Slot>>,
}

/// Data needed for a call on a variable: a fraction of its description, in one place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Access<Slot> {
    /// Minimum and maximum, as numbers for all types.
    range: (f64, f64),
    /// Bits of the phases in which it may be set.
    settable: u8,
    kind: Primitive,
    pub slot: Slot,
}

/// Type of a value in C.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Primitive {
    Real,
    Integer,
    Boolean,
}

impl<Slot: Copy> Access<Slot> {
    fn new(variable: &Variable<Slot>) -> Self {
        let (kind, range) = match &variable.kind {
            // All finite numbers.
            Type::Real { range, .. } => (Primitive::Real, range.unwrap_or((f64::MIN, f64::MAX))),
            Type::Integer { min, max } => (Primitive::Integer, (f64::from(*min), f64::from(*max))),
            Type::Enumeration(of) => (Primitive::Integer, (1.0, of.items.len() as f64)),
            Type::Boolean => (Primitive::Boolean, (0.0, 1.0)),
        };
        Self { range, settable: variable.setting().map_or(0, phases), kind, slot: variable.slot }
    }

    /// True if the variable may be set to this value in this phase.
    #[inline]
    pub fn accepts(&self, value: Value, phase: Phase) -> bool {
        let (kind, number) = match value {
            Value::Real(value) => (Primitive::Real, value),
            Value::Integer(value) => (Primitive::Integer, f64::from(value)),
            Value::Boolean(value) => (Primitive::Boolean, f64::from(u8::from(value))),
        };
        let (low, high) = self.range;
        self.settable & phase.bit() != 0 && self.kind == kind && low <= number && number <= high
    }
}

impl<Slot: Copy> Variables<Slot> {
    /// The variables in the order of their value references.
    #[must_use]
    pub fn new(all: Vec<Variable<Slot>>) -> Self {
        let access = all.iter().map(Access::new).collect();
        Self { all, access }
    }

    #[inline]
    pub(crate) fn access(&self) -> &[Access<Slot>] {
        &self.access
    }
}

impl<Slot> Variables<Slot> {
    /// The variable with a value reference.
    pub(crate) fn variable(&self, reference: u32) -> Result<&Variable<Slot>> {
        self.all.get(reference as usize).ok_or_else(|| self.unknown(reference))
    }

    /// For a reference to a variable that does not exist.
    #[cold]
    pub(crate) fn unknown(&self, reference: u32) -> Error {
        let allowed = match self.all.len() {
            0 => "none: the model has no variables".to_owned(),
            count => format!("0 to {}", count - 1),
        };
        Error::new("value reference", reference, allowed)
    }

    /// For a reference to a variable of another type than requested.
    #[cold]
    pub(crate) fn wrong_type(&self, reference: u32, wanted: &str) -> Error {
        let found = self.variable(reference).map_or_else(
            |_| reference.to_string(),
            |variable| format!("{reference}, which is `{}`, {}", variable.name, variable.kind.name()),
        );
        Error::new("value reference", found, format!("references of {wanted}"))
    }
}

impl<Slot> Deref for Variables<Slot> {
    type Target = [Variable<Slot>];

    fn deref(&self) -> &[Variable<Slot>] {
        &self.all
    }
}

impl<'a, Slot> IntoIterator for &'a Variables<Slot> {
    type Item = &'a Variable<Slot>;
    type IntoIter = std::slice::Iter<'a, Variable<Slot>>;

    fn into_iter(self) -> Self::IntoIter {
        self.all.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calls::Kind;
    use crate::variable::{Causality, Enumeration, Variability};

    static TWO: Enumeration = Enumeration { name: "Two", description: "two items", items: &["one", "two"] };

    fn variable(causality: Causality, variability: Variability, kind: Type) -> Variable<()> {
        Variable { name: "x".into(), description: String::new(), causality, variability, kind, slot: () }
    }

    /// A call accepts exactly what the cold path, which gives the reason, does not refuse.
    #[test]
    fn a_value_is_accepted_where_nothing_about_it_is_refused() {
        use Causality::{CalculatedParameter, Input, Local, Output, Parameter};
        let real = |range| Type::Real { unit: "1", range, nominal: None };
        let kinds = [
            real(None),
            real(Some((-1.0, 2.0))),
            Type::Integer { min: i32::MIN, max: 2 },
            Type::Boolean,
            Type::Enumeration(&TWO),
        ];
        let reals = [-1.0, 0.0, 2.0, 2.0_f64.next_up(), f64::MAX, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        let integers = [i32::MIN, -1, 0, 1, 2, 3, i32::MAX];
        let values = reals.map(Value::Real).into_iter().chain(integers.map(Value::Integer));
        let values: Vec<Value> = values.chain([true, false].map(Value::Boolean)).collect();
        let moments = [Phase::Instantiated, Phase::StepComplete, Phase::ContinuousTimeMode, Phase::Terminated];
        for causality in [Input, Output, Parameter, CalculatedParameter, Local] {
            for variability in [Variability::Fixed, Variability::Tunable, Variability::Continuous] {
                for kind in &kinds {
                    let variable = variable(causality, variability, kind.clone());
                    let access = Access::new(&variable);
                    for (value, phase) in values.iter().flat_map(|value| moments.map(|phase| (*value, phase))) {
                        let settable = variable.check_settable(Kind::CoSimulation, phase).is_ok();
                        let refused = !settable || variable.check_range(value).is_err();
                        assert_eq!(access.accepts(value, phase), !refused, "{variable:?} {value:?} {phase:?}");
                    }
                }
            }
        }
    }
}
