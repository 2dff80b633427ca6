//! The interface of a model, in safe code: every method is called only in the phases that the standard allows, with references,
//! types, ranges and lengths checked.

use serde::{Serialize, de::DeserializeOwned};

use crate::{
    calls::{Kind, Phase},
    error::{Error, Result},
    request::Request,
    variable::{Value, Variable},
    variables::Variables,
};

/// A model: constants and a memory that can be saved.
///
/// A method that returns an error must not have changed anything: the instance continues from its present state.
///
/// Required are [`Model::start`], [`Model::new`], [`Model::variables`], [`Model::get`], [`Model::set`] and the memory; for co-simulation
/// [`Model::step`]; for model exchange the methods from [`Model::set_time`] on, and `KINDS`. The defaults of the others refuse the call,
/// and the description must not declare the corresponding capabilities.
pub trait Model: Sized + Send + 'static {
    /// Start values; `()` if there is only one description.
    type Start: Clone + Send + 'static;
    /// Identifies a variable within the model.
    type Slot: Copy + Send + Sync + 'static;
    /// Everything that changes during a simulation: plain data.
    type Memory: Clone + Serialize + DeserializeOwned + Send + 'static;

    /// `modelIdentifier`, which also identifies serialized states.
    const IDENTIFIER: &'static str;
    /// Supported kinds of simulation.
    const KINDS: &'static [Kind] = &[Kind::CoSimulation];
    /// Number of continuous states in model exchange.
    const STATES: usize = 0;
    /// Number of event indicators in model exchange.
    const EVENT_INDICATORS: usize = 0;

    /// Start values of the model that the host requests; refuses an unknown GUID ([`Request::expect_guid`]).
    ///
    /// # Errors
    /// A GUID that belongs to another model.
    fn start(request: &Request) -> Result<Self::Start>;

    /// GUID of the model with these start values; a saved state with another one is refused.
    fn guid(start: &Self::Start) -> String;

    /// The state after `fmi2Instantiate` and `fmi2Reset`.
    fn new(start: &Self::Start, kind: Kind) -> Self;

    /// The variables, always the same list.
    fn variables() -> &'static Variables<Self::Slot>;

    /// Present value of a variable.
    ///
    /// # Errors
    /// A value that does not exist at present.
    fn get(&self, slot: Self::Slot, now: Phase) -> Result<Value>;

    /// Sets a checked value.
    fn set(&mut self, slot: Self::Slot, value: Value);

    /// Sets all values of one call, or none.
    ///
    /// # Errors
    /// Inconsistent values.
    fn set_all(&mut self, items: impl Iterator<Item = (Self::Slot, Value)> + Clone, _now: Phase) -> Result<()> {
        items.for_each(|(slot, value)| self.set(slot, value));
        Ok(())
    }

    /// As above for one value.
    ///
    /// # Errors
    /// Those of [`Model::set_all`].
    #[inline]
    fn set_one(&mut self, slot: Self::Slot, value: Value, now: Phase) -> Result<()> {
        self.set_all(std::iter::once((slot, value)), now)
    }

    /// The present memory.
    fn memory(&self) -> &Self::Memory;

    /// Restores a memory saved in the phase `now`.
    ///
    /// # Errors
    /// A memory that does not belong to this model.
    fn restore(&mut self, memory: Self::Memory, now: Phase) -> Result<()>;

    /// As above from a memory that is not moved: for models that restore without allocation.
    ///
    /// # Errors
    /// Those of [`Model::restore`].
    fn restore_from(&mut self, memory: &Self::Memory, now: Phase) -> Result<()> {
        self.restore(memory.clone(), now)
    }

    /// Refuses a deserialized memory that no sequence of calls can have produced.
    ///
    /// # Errors
    /// What is wrong with it.
    fn check(_memory: &Self::Memory, _kind: Kind, _now: Phase) -> Result<()> {
        Ok(())
    }

    /// End of initialization mode: parameters are known, the simulation starts at `time`.
    ///
    /// # Errors
    /// Inconsistent parameters.
    fn initialize(&mut self, _time: f64) -> Result<()> {
        Ok(())
    }

    /// Partial derivative of an unknown with respect to a known.
    ///
    /// # Errors
    /// A variable that is not an unknown, or not a known, in this phase.
    fn partial_derivative(
        &self,
        _unknown: &'static Variable<Self::Slot>,
        _known: &'static Variable<Self::Slot>,
        _now: Phase,
    ) -> Result<f64> {
        Err(not_offered("directional derivatives"))
    }

    // Co-simulation

    /// Advances from `time` to exactly `time + duration` \[s\], `duration` > 0.
    ///
    /// # Errors
    /// The model cannot be evaluated here. An error made by [`Error::discarded_at`] ends the step early; only then may the state have
    /// changed, to that at the time in the error.
    fn step(&mut self, _time: f64, _duration: f64) -> Result<()> {
        Err(not_offered("steps"))
    }

    /// Message for the host about the last step, which then returns `fmi2Warning`.
    fn take_warning(&mut self) -> Option<String> {
        None
    }

    /// Derivatives of inputs: variable, order, value.
    ///
    /// # Errors
    /// A variable, order or value that is not supported.
    fn set_input_derivatives(&mut self, items: &[(&'static Variable<Self::Slot>, i32, f64)]) -> Result<()> {
        if items.is_empty() { Ok(()) } else { Err(not_offered("input derivatives")) }
    }

    /// Derivative of an output.
    ///
    /// # Errors
    /// A variable or order that is not supported.
    fn output_derivative(&self, _variable: &'static Variable<Self::Slot>, _order: i32) -> Result<f64> {
        Err(not_offered("output derivatives"))
    }

    // Model exchange

    /// The host's time \[s\].
    fn set_time(&mut self, _time: f64) {}

    /// The continuous states now, as many as [`Model::STATES`].
    fn states(&self, _into: &mut [f64]) {}

    /// Sets the continuous states, which are finite.
    fn set_states(&mut self, _states: &[f64]) {}

    /// Orders of magnitude of the states.
    fn nominals(&self, into: &mut [f64]) {
        into.fill(1.0);
    }

    /// Derivatives of the states, in their order.
    ///
    /// # Errors
    /// The model cannot be evaluated here.
    fn derivatives(&self, _into: &mut [f64]) -> Result<()> {
        Ok(())
    }

    /// Event indicators: the host locates the instant at which one changes sign.
    ///
    /// # Errors
    /// The model cannot be evaluated here.
    fn event_indicators(&self, _into: &mut [f64]) -> Result<()> {
        Ok(())
    }

    /// Enters event mode.
    ///
    /// # Errors
    /// The model cannot be evaluated here.
    fn enter_event_mode(&mut self) -> Result<()> {
        Ok(())
    }

    /// One event iteration.
    ///
    /// # Errors
    /// No consistent state.
    fn new_discrete_states(&mut self) -> Result<EventUpdate> {
        Ok(EventUpdate::default())
    }

    /// Enters continuous-time mode.
    fn enter_continuous_time_mode(&mut self) {}

    /// The host has accepted a step; true requests event mode.
    ///
    /// # Errors
    /// The model cannot be evaluated here.
    fn completed_integrator_step(&mut self) -> Result<bool> {
        Ok(false)
    }
}

fn not_offered(what: &str) -> Error {
    Error::new(what, "a model without", "what its description declares")
}

/// Result of one event iteration, `fmi2EventInfo`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EventUpdate {
    /// Another iteration is needed.
    pub needs_another: bool,
    /// The continuous states changed discontinuously.
    pub states_changed: bool,
    /// Time of the next time event \[s\], if there is one.
    pub next_event: Option<f64>,
}
