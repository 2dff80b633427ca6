//! One instance of a model, in safe code: phases and steps here, variables in `values`, saved states in `states`, model exchange in
//! `model_exchange`. Arguments of the host are checked before they reach the model. A refused call changes nothing.

mod model_exchange;
mod states;
mod values;

use std::cell::OnceCell;

use crate::{
    calls::{self, Call, Kind, Phase},
    error::{Error, Result},
    lifecycle::{Lifecycle, NO_STOP},
    log::{Log, Status},
    model::Model,
    saved_states::SavedStates,
    variable::{Value, Variable},
    variables::Variables,
};

/// One instance.
pub struct Instance<M: Model> {
    variables: &'static Variables<M::Slot>,
    /// Start values, restored by `fmi2Reset`.
    start: M::Start,
    /// Computed when a state is serialized.
    guid: OnceCell<String>,
    lifecycle: Lifecycle,
    model: M,
    saved: SavedStates<M::Memory>,
    /// Buffer for as many numbers as there are states or event indicators.
    pub(crate) numbers: Vec<f64>,
    /// Buffer for the checked values of one call.
    checked: Vec<(M::Slot, Value)>,
    /// Buffer for the input derivatives of one call.
    input_derivatives: Vec<(&'static Variable<M::Slot>, i32, f64)>,
    pub(crate) log: Log,
}

/// Maximum number of input derivatives of one call that are set without allocation.
const TYPICAL_INPUTS: usize = 16;

impl<M: Model> Instance<M> {
    /// For co-simulation, of the model with these start values.
    #[must_use]
    pub fn new(start: M::Start, logging_on: bool) -> Self {
        Self::of_kind(Kind::CoSimulation, start, logging_on)
    }

    /// For this kind of simulation.
    #[must_use]
    pub fn of_kind(kind: Kind, start: M::Start, logging_on: bool) -> Self {
        Self {
            variables: M::variables(),
            guid: OnceCell::new(),
            lifecycle: Lifecycle::new(kind),
            model: M::new(&start, kind),
            start,
            saved: SavedStates::new(),
            numbers: match kind {
                Kind::ModelExchange => vec![0.0; M::STATES.max(M::EVENT_INDICATORS)],
                Kind::CoSimulation => Vec::new(),
            },
            checked: Vec::with_capacity(M::variables().len()),
            input_derivatives: Vec::with_capacity(match kind {
                Kind::ModelExchange => 0,
                Kind::CoSimulation => TYPICAL_INPUTS,
            }),
            log: Log::new(logging_on),
        }
    }

    /// Its model.
    #[must_use]
    pub fn model(&self) -> &M {
        &self.model
    }

    #[inline]
    fn check(&self, call: Call) -> Result<()> {
        calls::check(call, self.lifecycle.kind, self.lifecycle.phase)
    }

    fn enter(&mut self, phase: Phase) {
        self.lifecycle.phase = phase;
        self.log.add(Status::Ok, || format!("at {} s: {}", self.lifecycle.time, phase.name()));
    }

    /// `fmi2SetupExperiment`
    ///
    /// # Errors
    /// Wrong phase, times that are not finite, a stop before the start.
    pub fn setup_experiment(&mut self, start_time: f64, stop_time: Option<f64>) -> Result<()> {
        self.check(Call::SetupExperiment)?;
        if !start_time.is_finite() {
            return Err(Error::new("startTime", start_time, "a finite number"));
        }
        if let Some(stop) = stop_time.filter(|stop| stop.is_nan() || *stop < start_time) {
            return Err(Error::new("stopTime", stop, format!("startTime = {start_time} or later")));
        }
        (self.lifecycle.start_time, self.lifecycle.time) = (start_time, start_time);
        self.lifecycle.stop_time = stop_time.filter(|stop| stop.is_finite()).unwrap_or(NO_STOP);
        Ok(())
    }

    /// `fmi2EnterInitializationMode`
    ///
    /// # Errors
    /// Wrong phase.
    pub fn enter_initialization_mode(&mut self) -> Result<()> {
        self.check(Call::EnterInitializationMode)?;
        self.enter(Phase::Initialization);
        Ok(())
    }

    /// `fmi2ExitInitializationMode`
    ///
    /// # Errors
    /// Wrong phase; those of the model.
    pub fn exit_initialization_mode(&mut self) -> Result<()> {
        self.check(Call::ExitInitializationMode)?;
        self.model.initialize(self.lifecycle.start_time)?;
        self.enter(match self.lifecycle.kind {
            Kind::CoSimulation => Phase::StepComplete,
            Kind::ModelExchange => Phase::EventMode,
        });
        Ok(())
    }

    /// `fmi2Terminate`
    ///
    /// # Errors
    /// Wrong phase.
    pub fn terminate(&mut self) -> Result<()> {
        self.check(Call::Terminate)?;
        self.enter(Phase::Terminated);
        Ok(())
    }

    /// `fmi2Reset`: as after instantiation. Saved states stay valid.
    ///
    /// # Errors
    /// None at present.
    pub fn reset(&mut self) -> Result<()> {
        self.check(Call::Reset)?;
        self.lifecycle = Lifecycle::new(self.lifecycle.kind);
        self.model = M::new(&self.start, self.lifecycle.kind);
        Ok(())
    }

    /// `fmi2DoStep`: ends exactly at `current + duration`.
    ///
    /// # Errors
    /// Wrong phase, a step that is not positive and finite, a communication point other than the one reached, a step past the stop time;
    /// those of the model.
    #[inline(always)] // on the path of every call
    pub fn do_step(&mut self, current: f64, duration: f64) -> Result<()> {
        self.check(Call::DoStep)?;
        let end = self.lifecycle.end_of_step(current, duration)?;
        if let Err(error) = self.model.step(current, duration) {
            self.lifecycle.time = error.reached().unwrap_or(self.lifecycle.time);
            return Err(error);
        }
        self.lifecycle.time = end;
        if let Some(warning) = self.model.take_warning() {
            self.log.warn(|| format!("fmi2DoStep: {warning}"));
        }
        Ok(())
    }

    /// `fmi2CancelStep`
    ///
    /// # Errors
    /// Always: no step is ever pending.
    pub fn cancel_step(&self) -> Result<()> {
        self.check(Call::CancelStep)
    }

    /// Time of the last communication point \[s\], for `fmi2GetRealStatus`.
    ///
    /// # Errors
    /// Wrong phase.
    pub fn last_successful_time(&self) -> Result<f64> {
        self.check(Call::GetStatus)?;
        Ok(self.lifecycle.time)
    }
}
