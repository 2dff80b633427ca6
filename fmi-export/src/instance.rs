//! One instance of a model, in safe code: phases, variables, steps, saved states. Arguments of the host are checked here before they
//! reach the model. A refused call changes nothing.

use std::{
    cell::OnceCell,
    sync::atomic::{AtomicUsize, Ordering},
};

use serde::{Deserialize, Serialize};

use crate::{
    calls::{self, Call, Kind, Phase},
    error::{Error, Result},
    log::{Log, Status},
    model::Model,
    serialization,
    variable::{Value, Variable, variable, wrong_type},
};

/// Phase and times of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Lifecycle {
    pub kind: Kind,
    pub phase: Phase,
    pub start_time: f64,
    pub time: f64,
    pub stop_time: Option<f64>,
}

impl Lifecycle {
    fn new(kind: Kind) -> Self {
        Self { kind, phase: Phase::Instantiated, start_time: 0.0, time: 0.0, stop_time: None }
    }

    /// Why this step is refused.
    #[cold]
    fn illegal_step(&self, current: f64, duration: f64, is_here: bool) -> Error {
        if !(duration > 0.0 && duration < f64::INFINITY) {
            return Error::new("communicationStepSize", format!("{duration} s"), "finite numbers above 0");
        }
        if !is_here {
            let allowed = format!("{} s, where the last step ended", self.time);
            return Error::new("currentCommunicationPoint", format!("{current} s"), allowed);
        }
        let stop = self.stop_time.unwrap_or(f64::INFINITY);
        Error::new("end of the step", format!("{} s", current + duration), format!("up to the stop time of {stop} s"))
    }

    fn check(&self, kind: Kind) -> Result<()> {
        let times = [self.start_time, self.time, self.stop_time.unwrap_or(0.0)];
        if let Some(time) = times.iter().find(|time| !time.is_finite()) {
            return Err(Error::new("FMU state", time, "finite numbers"));
        }
        if self.kind != kind || !Phase::of(kind).contains(&self.phase) {
            let found = format!("a state of an instance for {}", self.kind.name());
            return Err(Error::new("FMU state", found, format!("one of an instance for {}", kind.name())));
        }
        Ok(())
    }
}

/// A saved state.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Saved<Memory> {
    lifecycle: Lifecycle,
    memory: Memory,
}

/// One instance.
pub struct Instance<M: Model> {
    variables: &'static [Variable<M::Slot>],
    /// Start values, restored by `fmi2Reset`.
    start: M::Start,
    /// Worked out when a state is serialized.
    guid: OnceCell<String>,
    pub(crate) lifecycle: Lifecycle,
    pub(crate) model: M,
    /// By handle, in ascending order; few.
    saved: Vec<(usize, Box<Saved<M::Memory>>)>,
    /// Room for as many numbers as there are states or event indicators.
    pub(crate) numbers: Vec<f64>,
    /// Room for the checked values of one call.
    checked: Vec<(M::Slot, Value)>,
    /// Room for the input derivatives of one call.
    input_derivatives: Vec<(&'static Variable<M::Slot>, i32, f64)>,
    pub(crate) log: Log,
}

/// Handles of saved states are unique in a process, so that an instance never accepts a handle of another one.
static NEXT_STATE: AtomicUsize = AtomicUsize::new(1);

/// Relative to the step: two times that differ by less (or by rounding of the time) are the same communication point, since masters
/// accumulate their steps with different rounding.
const COMMUNICATION_POINT_TOLERANCE: f64 = 1e-6;

/// Up to so many input derivatives of one call are set without allocation.
const TYPICAL_INPUTS: usize = 16;

/// Relative to the step: however coarse the rounding of a large time is, no step starts twice from one communication point.
const LARGEST_TOLERANCE: f64 = 0.25;

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
            saved: Vec::new(),
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
    pub(crate) fn check(&self, call: Call) -> Result<()> {
        calls::check(call, self.lifecycle.kind, self.lifecycle.phase)
    }

    pub(crate) fn enter(&mut self, phase: Phase) {
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
        self.lifecycle.stop_time = stop_time.filter(|stop| stop.is_finite());
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
    /// Wrong phase; what the model refuses.
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

    /// Value of a variable now.
    ///
    /// # Errors
    /// Wrong reference; what the model refuses.
    #[inline]
    pub fn get(&self, reference: u32) -> Result<Value> {
        self.check(Call::Get)?;
        self.model.get(variable(self.variables, reference)?.slot, self.lifecycle.phase)
    }

    /// As [`Instance::get`], of a Real.
    ///
    /// # Errors
    /// Those of [`Instance::get`], another type, or a value that is not finite.
    #[inline]
    pub fn get_real(&self, reference: u32) -> Result<f64> {
        match self.get(reference)? {
            Value::Real(value) if value.is_finite() => Ok(value),
            Value::Real(value) => Err(self.overflow(reference, value)),
            _ => Err(wrong_type(self.variables, reference, "a Real")),
        }
    }

    #[cold]
    fn overflow(&self, reference: u32, value: f64) -> Error {
        let name = variable(self.variables, reference).map_or("", |variable| &variable.name);
        let error = Error::new(format!("value of `{name}`"), value, "finite numbers");
        error.remedy("set smaller inputs or parameters").discarded()
    }

    /// As [`Instance::get`], of an Integer or Enumeration.
    ///
    /// # Errors
    /// Those of [`Instance::get`], or another type.
    pub fn get_integer(&self, reference: u32) -> Result<i32> {
        match self.get(reference)? {
            Value::Integer(value) => Ok(value),
            _ => Err(wrong_type(self.variables, reference, "an Integer or Enumeration")),
        }
    }

    /// As [`Instance::get`], of a Boolean.
    ///
    /// # Errors
    /// Those of [`Instance::get`], or another type.
    pub fn get_boolean(&self, reference: u32) -> Result<bool> {
        match self.get(reference)? {
            Value::Boolean(value) => Ok(value),
            _ => Err(wrong_type(self.variables, reference, "a Boolean")),
        }
    }

    /// Sets variables, all of them or, if one is refused, none.
    ///
    /// # Errors
    /// Wrong reference, type, range or phase; a variable that cannot be set.
    #[inline]
    pub fn set(&mut self, items: impl Iterator<Item = (u32, Value)>) -> Result<()> {
        self.checked.clear();
        for (reference, value) in items {
            let slot = self.settable(reference, value)?;
            self.checked.push((slot, value));
        }
        self.model.set_all(self.checked.iter().copied(), self.lifecycle.phase)
    }

    /// The quantity of a variable that may be set to this value now.
    #[inline]
    fn settable(&self, reference: u32, value: Value) -> Result<M::Slot> {
        let variable = variable(self.variables, reference)?;
        if let Err(error) = variable.setting().and_then(|call| self.check(call)) {
            return Err(error.remedy(format!("value of `{}` not set", variable.name)));
        }
        if !variable.kind.accepts(value) {
            return Err(wrong_type(self.variables, reference, value.kind()));
        }
        variable.check_range(value)?;
        Ok(variable.slot)
    }

    /// `fmi2SetRealInputDerivatives`, all of them or none.
    ///
    /// # Errors
    /// Wrong phase or reference; what the model refuses.
    pub fn set_input_derivatives(&mut self, items: impl Iterator<Item = (u32, i32, f64)>) -> Result<()> {
        self.check(Call::SetInputDerivatives)?;
        self.input_derivatives.clear();
        for (reference, order, value) in items {
            self.input_derivatives.push((variable(self.variables, reference)?, order, value));
        }
        self.model.set_input_derivatives(&self.input_derivatives)
    }

    /// `fmi2GetRealOutputDerivatives` of one output.
    ///
    /// # Errors
    /// Wrong phase or reference; what the model refuses.
    pub fn output_derivative(&self, reference: u32, order: i32) -> Result<f64> {
        self.check(Call::GetOutputDerivatives)?;
        let derivative = self.model.output_derivative(variable(self.variables, reference)?, order)?;
        if derivative.is_finite() { Ok(derivative) } else { Err(self.overflow(reference, derivative)) }
    }

    /// Partial derivative of an unknown by a known, as `fmi2GetDirectionalDerivative` sums them.
    ///
    /// # Errors
    /// Wrong phase or reference; what the model refuses.
    pub fn partial_derivative(&self, unknown: u32, known: u32) -> Result<f64> {
        self.check(Call::GetDirectionalDerivative)?;
        let of = |reference| variable(self.variables, reference);
        self.model.partial_derivative(of(unknown)?, of(known)?, self.lifecycle.phase)
    }

    /// `fmi2DoStep`: ends exactly at `current + duration`.
    ///
    /// # Errors
    /// Wrong phase, a step that is not positive and finite, another communication point than the one reached, a step past
    /// the stop time; what the model refuses.
    #[inline]
    pub fn do_step(&mut self, current: f64, duration: f64) -> Result<()> {
        self.check(Call::DoStep)?;
        let lifecycle = &mut self.lifecycle;
        let rounding = 1e3 * f64::EPSILON * lifecycle.time.abs();
        let (usual, largest) = (COMMUNICATION_POINT_TOLERANCE * duration + rounding, LARGEST_TOLERANCE * duration);
        let tolerance = if usual < largest { usual } else { largest };
        let end = current + duration;
        let is_here = (current - lifecycle.time).abs() <= tolerance;
        let is_before_stop = lifecycle.stop_time.is_none_or(|stop| end <= stop + tolerance);
        if !(duration > 0.0 && duration < f64::INFINITY && is_here && is_before_stop) {
            return Err(lifecycle.illegal_step(current, duration, is_here));
        }
        if let Err(error) = self.model.step(current, duration) {
            lifecycle.time = error.reached().unwrap_or(lifecycle.time);
            return Err(error);
        }
        lifecycle.time = end;
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

    /// Time of the last communication point [s], for `fmi2GetRealStatus`.
    ///
    /// # Errors
    /// Wrong phase.
    pub fn last_successful_time(&self) -> Result<f64> {
        self.check(Call::GetStatus)?;
        Ok(self.lifecycle.time)
    }

    /// `fmi2GetFMUstate`: saves the state, into `existing` if that is a saved state, and returns its handle.
    ///
    /// # Errors
    /// A handle that is not one of this instance's.
    pub fn save(&mut self, existing: Option<usize>) -> Result<usize> {
        self.check(Call::State)?;
        let Some(handle) = existing else {
            return Ok(self.store(Saved { lifecycle: self.lifecycle, memory: self.model.memory().clone() }));
        };
        let place = self.place(handle)?;
        let (_, saved) = &mut self.saved[place];
        saved.lifecycle = self.lifecycle;
        saved.memory.clone_from(self.model.memory());
        Ok(handle)
    }

    /// Handles grow, so that the new state comes last.
    fn store(&mut self, state: Saved<M::Memory>) -> usize {
        let handle = NEXT_STATE.fetch_add(1, Ordering::Relaxed);
        self.saved.push((handle, Box::new(state)));
        handle
    }

    #[inline]
    fn place(&self, handle: usize) -> Result<usize> {
        // The most recent one is asked for most.
        match self.saved.last() {
            Some((last, _)) if *last == handle => Ok(self.saved.len() - 1),
            _ => self.saved.binary_search_by_key(&handle, |(handle, _)| *handle).map_err(|_| unknown_state(handle)),
        }
    }

    fn saved(&self, handle: usize) -> Result<&Saved<M::Memory>> {
        self.place(handle).map(|place| &*self.saved[place].1)
    }

    /// `fmi2SetFMUstate`
    ///
    /// # Errors
    /// A handle that is not one of this instance's.
    pub fn restore(&mut self, handle: usize) -> Result<()> {
        self.check(Call::State)?;
        let place = self.place(handle)?;
        let Saved { lifecycle, memory } = &*self.saved[place].1;
        self.model.restore_from(memory, lifecycle.phase)?;
        self.lifecycle = *lifecycle;
        Ok(())
    }

    /// `fmi2FreeFMUstate`
    ///
    /// # Errors
    /// A handle that is not one of this instance's.
    pub fn free(&mut self, handle: usize) -> Result<()> {
        let place = self.place(handle)?;
        self.saved.remove(place);
        Ok(())
    }

    fn guid(&self) -> &str {
        self.guid.get_or_init(|| M::guid(&self.start))
    }

    /// `fmi2SerializeFMUstate`
    ///
    /// # Errors
    /// A handle that is not one of this instance's.
    pub fn serialize(&self, handle: usize) -> Result<Vec<u8>> {
        serialization::to_bytes(self.saved(handle)?, M::IDENTIFIER, self.guid())
    }

    /// `fmi2DeSerializeFMUstate`: returns the handle of a new saved state, or of `existing` overwritten.
    ///
    /// # Errors
    /// Bytes that are corrupt or belong to another model.
    pub fn deserialize(&mut self, bytes: &[u8], existing: Option<usize>) -> Result<usize> {
        self.check(Call::State)?;
        let state: Saved<M::Memory> = serialization::from_bytes(bytes, M::IDENTIFIER, self.guid())?;
        state.lifecycle.check(self.lifecycle.kind)?;
        M::check(&state.memory, state.lifecycle.kind, state.lifecycle.phase)?;
        match existing {
            None => Ok(self.store(state)),
            Some(handle) => {
                let place = self.place(handle)?;
                *self.saved[place].1 = state;
                Ok(handle)
            }
        }
    }
}

#[cold]
fn unknown_state(handle: usize) -> Error {
    Error::new("FMU state", format!("handle {handle:#x}"), "states got from this instance and not yet freed")
}
