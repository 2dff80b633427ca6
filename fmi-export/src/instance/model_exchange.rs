//! Model exchange: the host integrates; the instance computes derivatives and event indicators.

use crate::{
    calls::{Call, Phase},
    error::{Error, Result},
    instance::Instance,
    lifecycle::Lifecycle,
    model::{EventUpdate, Model},
};

fn expect_length(name: &str, found: usize, allowed: usize) -> Result<()> {
    if found == allowed { Ok(()) } else { Err(Error::new(name, found, allowed)) }
}

/// Non-finite numbers give `fmi2Discard`: a solver then tries a shorter step.
fn expect_finite(name: &str, numbers: &[f64]) -> Result<()> {
    match numbers.iter().position(|number| !number.is_finite()) {
        None => Ok(()),
        Some(index) => {
            let found = format!("{} at index {index}", numbers[index]);
            Err(Error::new(name, found, "finite numbers").discarded())
        }
    }
}

/// Relative, absolute at 0 s: how far a time may lie outside the experiment, as wide as hosts compare times.
const TIME_TOLERANCE: f64 = 1e-9;

/// Relative to the experiment: solvers evaluate beyond the stop time and interpolate back to it, by up to one of their steps (fmpy
/// limits them to a fiftieth).
const OVERSHOOT: f64 = 0.021;

impl<M: Model> Instance<M> {
    /// `fmi2EnterEventMode`
    ///
    /// # Errors
    /// Wrong kind of instance or phase.
    pub fn enter_event_mode(&mut self) -> Result<()> {
        self.check(Call::EnterEventMode)?;
        if self.lifecycle.phase != Phase::EventMode {
            self.model.enter_event_mode()?;
            self.enter(Phase::EventMode);
        }
        Ok(())
    }

    /// `fmi2NewDiscreteStates`
    ///
    /// # Errors
    /// Wrong kind of instance or phase; those of the model.
    pub fn new_discrete_states(&mut self) -> Result<EventUpdate> {
        self.check(Call::NewDiscreteStates)?;
        self.model.new_discrete_states()
    }

    /// `fmi2EnterContinuousTimeMode`
    ///
    /// # Errors
    /// Wrong kind of instance or phase.
    pub fn enter_continuous_time_mode(&mut self) -> Result<()> {
        self.check(Call::EnterContinuousTimeMode)?;
        self.model.enter_continuous_time_mode();
        self.enter(Phase::ContinuousTimeMode);
        Ok(())
    }

    /// `fmi2CompletedIntegratorStep`: true if it requests event mode.
    ///
    /// # Errors
    /// Wrong kind of instance or phase; those of the model.
    pub fn completed_integrator_step(&mut self) -> Result<bool> {
        self.check(Call::CompletedIntegratorStep)?;
        self.model.completed_integrator_step()
    }

    /// `fmi2SetTime`
    ///
    /// # Errors
    /// Wrong kind of instance or phase; a time that is not finite.
    pub fn set_time(&mut self, time: f64) -> Result<()> {
        self.check(Call::SetTime)?;
        if !time.is_finite() {
            return Err(Error::new("time", time, "finite numbers"));
        }
        let stop_time = self.lifecycle.stop();
        let Lifecycle { start_time, phase, .. } = self.lifecycle;
        let tolerance = TIME_TOLERANCE * (1.0 + time.abs());
        let overshoot = |stop: f64| match phase {
            Phase::ContinuousTimeMode => OVERSHOOT * (stop - start_time),
            _ => 0.0,
        };
        if time < start_time - tolerance || stop_time.is_some_and(|stop| time > stop + overshoot(stop) + tolerance) {
            let to = stop_time.map_or_else(|| "on".to_owned(), |stop| format!("to the stop time of {stop} s"));
            let allowed = format!("from the start time of {start_time} s {to}");
            return Err(Error::new("time", format!("{time} s"), allowed));
        }
        self.lifecycle.time = time;
        self.model.set_time(time);
        Ok(())
    }

    /// `fmi2SetContinuousStates`
    ///
    /// # Errors
    /// Wrong kind of instance or phase; a wrong number of states; states that are not finite.
    pub fn set_continuous_states(&mut self, states: &[f64]) -> Result<()> {
        self.check(Call::SetContinuousStates)?;
        expect_length("nx", states.len(), M::STATES)?;
        expect_finite("continuous states", states)?;
        self.model.set_states(states);
        Ok(())
    }

    /// `fmi2GetContinuousStates`
    ///
    /// # Errors
    /// Wrong kind of instance or phase; a wrong number of states.
    pub fn continuous_states(&self, into: &mut [f64]) -> Result<()> {
        self.check(Call::GetContinuousStates)?;
        expect_length("nx", into.len(), M::STATES)?;
        self.model.states(into);
        Ok(())
    }

    /// `fmi2GetNominalsOfContinuousStates`
    ///
    /// # Errors
    /// Wrong kind of instance; a wrong number of states.
    pub fn nominals(&self, into: &mut [f64]) -> Result<()> {
        self.check(Call::GetNominals)?;
        expect_length("nx", into.len(), M::STATES)?;
        self.model.nominals(into);
        Ok(())
    }

    /// `fmi2GetDerivatives`
    ///
    /// # Errors
    /// Wrong kind of instance or phase; a wrong number of states; derivatives that are not finite.
    pub fn derivatives(&self, into: &mut [f64]) -> Result<()> {
        self.check(Call::GetDerivatives)?;
        expect_length("nx", into.len(), M::STATES)?;
        self.model.derivatives(into)?;
        expect_finite("derivatives", into)
    }

    /// `fmi2GetEventIndicators`
    ///
    /// # Errors
    /// Wrong kind of instance or phase; a wrong number of indicators.
    pub fn event_indicators(&self, into: &mut [f64]) -> Result<()> {
        self.check(Call::GetEventIndicators)?;
        expect_length("ni", into.len(), M::EVENT_INDICATORS)?;
        self.model.event_indicators(into)?;
        expect_finite("event indicators", into)
    }
}
