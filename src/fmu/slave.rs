//! The co-simulation slave, in safe code: its life, its steps, its saved states. Its variables are in `access`.
//!
//! A refused call changes nothing. Between communication points an input is held at the value it was set to; if its
//! derivative was set it moves linearly from that value, and goes on so until the input or its derivative is set
//! again. Setting only the value means: held from here.

use std::{
    collections::BTreeMap,
    sync::atomic::{AtomicUsize, Ordering},
};

use super::{
    calls::{self, Call, Phase},
    guid::guid,
    log::{Log, Status},
    memory::{LastStep, Memory},
    settings::Settings,
    snapshot,
};
use crate::{
    actuator::{Actuator, Failure, State, Workspace},
    error::{Error, Result},
};

/// One instance.
pub struct Slave {
    /// Start values of this model; what `fmi2Reset` goes back to.
    start: Settings,
    guid: String,
    pub(super) memory: Memory,
    actuator: Option<Actuator>,
    workspace: Workspace,
    saved: BTreeMap<usize, Memory>,
    pub(super) log: Log,
}

/// Handles of saved states are used once in a process, so that one instance never takes another's for its own.
static NEXT_STATE: AtomicUsize = AtomicUsize::new(1);

/// Two times that differ by less than this share of the step, or of the time itself, are the same communication point:
/// masters add up their steps in their own way.
const SAME_TIME: f64 = 1e-6;

impl Slave {
    /// An instance of the model with these start values.
    #[must_use]
    pub fn new(start: Settings, logging_on: bool) -> Self {
        Self {
            guid: guid(&start),
            memory: Memory::new(&start),
            start,
            actuator: None,
            workspace: Workspace::default(),
            saved: BTreeMap::new(),
            log: Log::new(logging_on),
        }
    }

    pub(super) fn check(&self, call: Call) -> Result<()> {
        calls::check(call, self.memory.phase)
    }

    fn enter(&mut self, phase: Phase) {
        self.memory.phase = phase;
        self.log.add(Status::Ok, format!("at {} s: {}", self.memory.time, phase.name()));
    }

    /// `fmi2SetupExperiment`
    ///
    /// # Errors
    /// Wrong phase, times that are not finite, a stop before the start.
    pub fn setup_experiment(&mut self, start_time: f64, stop_time: Option<f64>) -> Result<()> {
        self.check(Call::SetupExperiment)?;
        if !start_time.is_finite() {
            return Err(Error::new("startTime", start_time.to_string(), "a finite number"));
        }
        if let Some(stop) = stop_time.filter(|stop| stop.is_nan() || *stop < start_time) {
            return Err(Error::new("stopTime", stop.to_string(), format!("startTime = {start_time} or later")));
        }
        (self.memory.start_time, self.memory.time) = (start_time, start_time);
        self.memory.stop_time = stop_time.filter(|stop| stop.is_finite());
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
    /// Wrong phase; a selection for which the report has no data; parameters of an effect that do not go together; a start
    /// beyond a stop.
    pub fn exit_initialization_mode(&mut self) -> Result<()> {
        self.check(Call::ExitInitializationMode)?;
        let actuator = self.memory.settings.actuator()?;
        let initial = self.memory.settings.initial_position;
        let (min, max) = actuator.stops();
        if !(min..=max).contains(&initial) {
            let allowed = format!("{min} to {max} deg, the position_limit");
            return Err(Error::new("initial_position", format!("{initial} deg"), allowed));
        }
        self.memory.state = Some(actuator.at_rest(initial));
        self.workspace.forget();
        self.actuator = Some(actuator);
        self.enter(Phase::Stepping);
        Ok(())
    }

    /// Goes on with other parameters.
    pub(super) fn change(&mut self, settings: Settings) -> Result<()> {
        let actuator = settings.actuator()?;
        if let (Some(before), Some(state)) = (&self.actuator, &mut self.memory.state) {
            actuator.adopt(state, before, self.memory.command.value());
        }
        self.memory.settings = settings;
        self.actuator = Some(actuator);
        self.workspace.forget();
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
        self.memory = Memory::new(&self.start);
        self.actuator = None;
        Ok(())
    }

    /// The actuator in use and its state.
    pub(super) fn moving(&self) -> Result<(&Actuator, &State)> {
        self.actuator
            .as_ref()
            .zip(self.memory.state.as_ref())
            .ok_or_else(|| Error::new("instance", "no parameters in use", "an initialized instance"))
    }

    /// `fmi2DoStep`: lands exactly on `current + duration`.
    ///
    /// # Errors
    /// Wrong phase, a step that is not positive and finite, another communication point than the one reached, a step past
    /// the stop time, a motion beyond the range of numbers.
    pub fn do_step(&mut self, current: f64, duration: f64) -> Result<()> {
        self.check(Call::DoStep)?;
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(Error::new("communicationStepSize", format!("{duration} s"), "finite numbers above 0"));
        }
        let memory = &mut self.memory;
        let tolerance = SAME_TIME * duration + 1e3 * f64::EPSILON * memory.time.abs();
        if (current - memory.time).abs() > tolerance || current.is_nan() {
            let allowed = format!("{} s, where the last step ended", memory.time);
            return Err(Error::new("currentCommunicationPoint", format!("{current} s"), allowed));
        }
        let end = current + duration;
        if let Some(stop) = memory.stop_time.filter(|stop| end > stop + tolerance) {
            return Err(Error::new("end of the step", format!("{end} s"), format!("up to the stop time of {stop} s")));
        }
        let (Some(actuator), Some(before)) = (&self.actuator, memory.state.as_ref()) else {
            return self.moving().map(|_| ());
        };
        let inputs = memory.inputs();
        if ![inputs.command.at(duration), inputs.load.at(duration)].iter().all(|value| value.is_finite()) {
            return Err(Error::new("inputs at the end of this step", format!("{inputs:?}"), "finite numbers"));
        }
        let mut state = before.clone();
        state.time = current - memory.start_time;
        actuator.step(&mut state, &mut self.workspace, inputs, duration)?;
        let before = memory.state.replace(state).filter(|_| !actuator.is_linear() || inputs.failure != Failure::None);
        memory.command.advance(duration);
        memory.load.advance(duration);
        memory.time = end;
        memory.last_step = Some(LastStep { duration, inputs, before });
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
        Ok(self.memory.time)
    }

    /// `fmi2GetFMUstate`: saves the state, into `existing` if that is a saved state, and returns its handle.
    ///
    /// # Errors
    /// A handle that is not one of this instance's.
    pub fn save(&mut self, existing: Option<usize>) -> Result<usize> {
        self.check(Call::State)?;
        self.store(self.memory.clone(), existing)
    }

    fn store(&mut self, memory: Memory, existing: Option<usize>) -> Result<usize> {
        let handle = match existing {
            Some(handle) => self.saved(handle).map(|_| handle)?,
            None => NEXT_STATE.fetch_add(1, Ordering::Relaxed),
        };
        self.saved.insert(handle, memory);
        Ok(handle)
    }

    fn saved(&self, handle: usize) -> Result<&Memory> {
        self.saved.get(&handle).ok_or_else(|| {
            Error::new("FMU state", format!("handle {handle:#x}"), "states got from this instance and not yet freed")
        })
    }

    /// `fmi2SetFMUstate`
    ///
    /// # Errors
    /// A handle that is not one of this instance's.
    pub fn restore(&mut self, handle: usize) -> Result<()> {
        self.check(Call::State)?;
        let memory = self.saved(handle)?.clone();
        // The actuator follows from the settings: masters that repeat steps restore the same ones again and again.
        let known = self.actuator.is_some() && memory.settings == self.memory.settings;
        if !memory.is_initialized() {
            self.actuator = None;
        } else if !known {
            self.actuator = Some(memory.settings.actuator()?);
            self.workspace.forget();
        }
        self.memory = memory;
        Ok(())
    }

    /// `fmi2FreeFMUstate`
    ///
    /// # Errors
    /// A handle that is not one of this instance's.
    pub fn free(&mut self, handle: usize) -> Result<()> {
        self.saved(handle)?;
        self.saved.remove(&handle);
        Ok(())
    }

    /// `fmi2SerializeFMUstate`
    ///
    /// # Errors
    /// A handle that is not one of this instance's.
    pub fn serialize(&self, handle: usize) -> Result<Vec<u8>> {
        snapshot::to_bytes(self.saved(handle)?, &self.guid)
    }

    /// `fmi2DeSerializeFMUstate`: returns the handle of a new saved state, or of `existing` overwritten.
    ///
    /// # Errors
    /// Bytes that are corrupt or belong to another model.
    pub fn deserialize(&mut self, bytes: &[u8], existing: Option<usize>) -> Result<usize> {
        self.check(Call::State)?;
        let memory: Memory = snapshot::from_bytes(bytes, &self.guid)?;
        memory.check()?;
        self.store(memory, existing)
    }
}
