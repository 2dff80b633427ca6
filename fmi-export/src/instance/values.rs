//! Values of variables and their derivatives.

use crate::{
    calls::Call,
    error::{Error, Result},
    instance::Instance,
    model::Model,
    variable::{Value, Variable},
};

impl<M: Model> Instance<M> {
    /// Value of a variable now.
    ///
    /// # Errors
    /// Wrong reference; those of the model.
    #[inline(always)] // on the path of every call
    pub fn get(&self, reference: u32) -> Result<Value> {
        self.check(Call::Get)?;
        match self.variables.access().get(reference as usize) {
            Some(access) => self.model.get(access.slot, self.lifecycle.phase),
            None => Err(self.variables.unknown(reference)),
        }
    }

    /// As [`Instance::get`], for a Real.
    ///
    /// # Errors
    /// Those of [`Instance::get`], another type, or a value that is not finite.
    #[inline(always)] // on the path of every call
    pub fn get_real(&self, reference: u32) -> Result<f64> {
        match self.get(reference)? {
            Value::Real(value) if value.is_finite() => Ok(value),
            Value::Real(value) => Err(self.overflow(reference, value)),
            _ => Err(self.variables.wrong_type(reference, "a Real")),
        }
    }

    #[cold]
    fn overflow(&self, reference: u32, value: f64) -> Error {
        let name = self.variables.variable(reference).map_or("", |variable| &variable.name);
        let error = Error::new(format!("value of `{name}`"), value, "finite numbers");
        error.remedy("set smaller inputs or parameters").discarded()
    }

    /// As [`Instance::get`], for an Integer or Enumeration.
    ///
    /// # Errors
    /// Those of [`Instance::get`], or another type.
    pub fn get_integer(&self, reference: u32) -> Result<i32> {
        match self.get(reference)? {
            Value::Integer(value) => Ok(value),
            _ => Err(self.variables.wrong_type(reference, "an Integer or Enumeration")),
        }
    }

    /// As [`Instance::get`], for a Boolean.
    ///
    /// # Errors
    /// Those of [`Instance::get`], or another type.
    pub fn get_boolean(&self, reference: u32) -> Result<bool> {
        match self.get(reference)? {
            Value::Boolean(value) => Ok(value),
            _ => Err(self.variables.wrong_type(reference, "a Boolean")),
        }
    }

    /// Sets all variables or, if one is refused, none.
    ///
    /// # Errors
    /// Wrong reference, type, range or phase; a variable that cannot be set.
    pub fn set(&mut self, items: impl Iterator<Item = (u32, Value)>) -> Result<()> {
        self.checked.clear();
        for (reference, value) in items {
            let slot = self.settable(reference, value)?;
            self.checked.push((slot, value));
        }
        self.model.set_all(self.checked.iter().copied(), self.lifecycle.phase)
    }

    /// Sets one variable.
    ///
    /// # Errors
    /// Those of [`Instance::set`].
    #[inline(always)] // on the path of every call
    pub fn set_one(&mut self, reference: u32, value: Value) -> Result<()> {
        let slot = self.settable(reference, value)?;
        self.model.set_one(slot, value, self.lifecycle.phase)
    }

    /// The quantity of a variable, if it may be set to this value now.
    #[inline(always)] // on the path of every call
    fn settable(&self, reference: u32, value: Value) -> Result<M::Slot> {
        match self.variables.access().get(reference as usize) {
            Some(access) if access.accepts(value, self.lifecycle.phase) => Ok(access.slot),
            _ => Err(self.not_settable(reference, value)),
        }
    }

    /// The reason if it may not.
    #[cold]
    #[inline(never)]
    fn not_settable(&self, reference: u32, value: Value) -> Error {
        let refused = |variable: &Variable<M::Slot>| {
            variable.check_settable(self.lifecycle.kind, self.lifecycle.phase)?;
            if !variable.kind.accepts(value) {
                return Err(self.variables.wrong_type(reference, value.kind()));
            }
            variable.check_range(value)
        };
        let refusal = self.variables.variable(reference).and_then(refused).err();
        refusal.unwrap_or_else(|| Error::new(format!("value reference {reference}"), value.kind(), "nothing"))
    }

    /// `fmi2SetRealInputDerivatives`, all or none.
    ///
    /// # Errors
    /// Wrong phase or reference; those of the model.
    pub fn set_input_derivatives(&mut self, items: impl Iterator<Item = (u32, i32, f64)>) -> Result<()> {
        self.check(Call::SetInputDerivatives)?;
        self.input_derivatives.clear();
        for (reference, order, value) in items {
            self.input_derivatives.push((self.variables.variable(reference)?, order, value));
        }
        self.model.set_input_derivatives(&self.input_derivatives)
    }

    /// `fmi2GetRealOutputDerivatives` of one output.
    ///
    /// # Errors
    /// Wrong phase or reference; those of the model.
    pub fn output_derivative(&self, reference: u32, order: i32) -> Result<f64> {
        self.check(Call::GetOutputDerivatives)?;
        let derivative = self.model.output_derivative(self.variables.variable(reference)?, order)?;
        if derivative.is_finite() { Ok(derivative) } else { Err(self.overflow(reference, derivative)) }
    }

    /// Partial derivative of an unknown with respect to a known, as summed by `fmi2GetDirectionalDerivative`.
    ///
    /// # Errors
    /// Wrong phase or reference; those of the model.
    pub fn partial_derivative(&self, unknown: u32, known: u32) -> Result<f64> {
        self.check(Call::GetDirectionalDerivative)?;
        let of = |reference| self.variables.variable(reference);
        self.model.partial_derivative(of(unknown)?, of(known)?, self.lifecycle.phase)
    }
}
