//! What a model has to say for itself. All of it is safe code; every method is called in the phases that the standard allows,
//! with references, types, ranges and lengths checked.

use serde::{Serialize, de::DeserializeOwned};

use crate::{
    calls::{Kind, Phase},
    error::{Error, Result},
    request::Request,
    variable::{Value, Variable},
};

/// A model: constants, and a memory that can be saved.
///
/// A method that refuses must have changed nothing: the instance goes on from where it was.
///
/// Needed are [`Model::start`], [`Model::new`], [`Model::variables`], [`Model::get`], [`Model::set`] and the memory; for
/// co-simulation [`Model::step`]; for model exchange the methods from [`Model::set_time`] on, and `KINDS`. The others may stay
/// as they are: what they stand for is then refused with a word, so that the description must not declare it.
pub trait Model: Sized + Send + 'static {
    /// Values it starts with; `()` where there is one description only.
    type Start: Clone + Send + 'static;
    /// What it calls its variables.
    type Slot: Copy + Send + Sync + 'static;
    /// Everything that changes: plain data.
    type Memory: Clone + Serialize + DeserializeOwned + Send + 'static;

    /// `modelIdentifier`, also the mark of saved states.
    const IDENTIFIER: &'static str;
    /// What it can be instantiated for.
    const KINDS: &'static [Kind] = &[Kind::CoSimulation];
    /// Continuous states of a model-exchange instance.
    const STATES: usize = 0;
    /// Event indicators of a model-exchange instance.
    const INDICATORS: usize = 0;

    /// Start values of the model that the host wants; refuses a GUID that is not its own ([`Request::expect_guid`]).
    ///
    /// # Errors
    /// A GUID that belongs to another model.
    fn start(request: &Request) -> Result<Self::Start>;

    /// GUID of the model with these start values; a saved state of another one is refused.
    fn guid(start: &Self::Start) -> String;

    /// As after `fmi2Instantiate` and `fmi2Reset`.
    fn new(start: &Self::Start, kind: Kind) -> Self;

    /// What an importer sees; always the same list.
    fn variables() -> &'static [Variable<Self::Slot>];

    /// Value of a variable now.
    ///
    /// # Errors
    /// A value that does not exist now.
    fn get(&self, slot: Self::Slot, now: Phase) -> Result<Value>;

    /// Takes a checked value.
    fn set(&mut self, slot: Self::Slot, value: Value);

    /// Takes all values of one call, or none.
    ///
    /// # Errors
    /// Values that do not go together.
    fn set_all(&mut self, items: impl Iterator<Item = (Self::Slot, Value)> + Clone, _now: Phase) -> Result<()> {
        items.for_each(|(slot, value)| self.set(slot, value));
        Ok(())
    }

    /// The memory as it is.
    fn memory(&self) -> &Self::Memory;

    /// Goes on from a memory, saved in the phase `now`.
    ///
    /// # Errors
    /// A memory that does not belong to this model.
    fn restore(&mut self, memory: Self::Memory, now: Phase) -> Result<()>;

    /// Refuses a memory, read from bytes, that no sequence of calls could have produced.
    ///
    /// # Errors
    /// What is wrong with it.
    fn check(_memory: &Self::Memory, _kind: Kind, _now: Phase) -> Result<()> {
        Ok(())
    }

    /// End of initialization mode: parameters are known, the simulation starts at `time`.
    ///
    /// # Errors
    /// Parameters that do not go together.
    fn initialize(&mut self, _time: f64) -> Result<()> {
        Ok(())
    }

    /// Partial derivative of an unknown by a known.
    ///
    /// # Errors
    /// What is no unknown, or no known, in this phase.
    fn partial_derivative(
        &self,
        _unknown: &'static Variable<Self::Slot>,
        _known: &'static Variable<Self::Slot>,
        _now: Phase,
    ) -> Result<f64> {
        Err(not_offered("directional derivatives"))
    }

    // Co-simulation

    /// Moves from `time` to exactly `time + duration` [s], `duration` > 0.
    ///
    /// # Errors
    /// A motion that cannot go on.
    fn step(&mut self, _time: f64, _duration: f64) -> Result<()> {
        Err(not_offered("steps"))
    }

    /// Derivatives of inputs: variable, order, value.
    ///
    /// # Errors
    /// Another variable, order or value than it can use.
    fn set_input_derivatives(&mut self, items: &[(&'static Variable<Self::Slot>, i32, f64)]) -> Result<()> {
        if items.is_empty() { Ok(()) } else { Err(not_offered("input derivatives")) }
    }

    /// Derivative of an output.
    ///
    /// # Errors
    /// Another variable or order than it knows.
    fn output_derivative(&self, _variable: &'static Variable<Self::Slot>, _order: i32) -> Result<f64> {
        Err(not_offered("output derivatives"))
    }

    // Model exchange

    /// The host's time [s].
    fn set_time(&mut self, _time: f64) {}

    /// The continuous states now, as many as [`Model::STATES`].
    fn states(&self, _into: &mut [f64]) {}

    /// Takes finite continuous states from the host.
    fn set_states(&mut self, _states: &[f64]) {}

    /// Orders of magnitude of the states.
    fn nominals(&self, into: &mut [f64]) {
        into.fill(1.0);
    }

    /// Derivatives of the states, in their order.
    ///
    /// # Errors
    /// A motion that cannot go on.
    fn derivatives(&self, _into: &mut [f64]) -> Result<()> {
        Ok(())
    }

    /// Event indicators: the host stops where one changes its sign.
    ///
    /// # Errors
    /// A motion that cannot go on.
    fn indicators(&self, _into: &mut [f64]) -> Result<()> {
        Ok(())
    }

    /// Time stands still from here on.
    ///
    /// # Errors
    /// A motion that cannot go on.
    fn enter_events(&mut self) -> Result<()> {
        Ok(())
    }

    /// One round of event iteration.
    ///
    /// # Errors
    /// No consistent state.
    fn new_discrete_states(&mut self) -> Result<Discrete> {
        Ok(Discrete::default())
    }

    /// The host integrates from here on.
    fn enter_continuous(&mut self) {}

    /// The host has accepted a step; true asks for event mode.
    ///
    /// # Errors
    /// A motion that cannot go on.
    fn completed_step(&mut self) -> Result<bool> {
        Ok(false)
    }
}

fn not_offered(what: &str) -> Error {
    Error::new(what, "a model without", "what its description declares")
}

/// Outcome of a round of event iteration, `fmi2EventInfo`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Discrete {
    /// Another round is needed.
    pub needs_another: bool,
    /// Continuous states have jumped.
    pub states_changed: bool,
    /// When the next event is due [s], if that is known.
    pub next_event: Option<f64>,
}
