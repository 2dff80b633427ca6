//! Model exchange: the host integrates; the instance computes derivatives and event indicators.

use crate::{
    calls::{Call, Phase},
    error::{Error, Result},
    instance::Instance,
    model::{EventUpdate, Model},
};

fn expect_length(name: &str, found: usize, allowed: usize) -> Result<()> {
    if found == allowed { Ok(()) } else { Err(Error::new(name, found, allowed)) }
}

/// Numbers that are not finite are `fmi2Discard`: a solver then tries a shorter step.
fn expect_finite(name: &str, numbers: &[f64]) -> Result<()> {
    match numbers.iter().position(|number| !number.is_finite()) {
        None => Ok(()),
        Some(index) => {
            let found = format!("{} at index {index}", numbers[index]);
            Err(Error::new(name, found, "finite numbers").discarded())
        }
    }
}

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
    /// Wrong kind of instance or phase; what the model refuses.
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

    /// `fmi2CompletedIntegratorStep`: true where it requests event mode.
    ///
    /// # Errors
    /// Wrong kind of instance or phase; what the model refuses.
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
        self.lifecycle.time = time;
        self.model.set_time(time);
        Ok(())
    }

    /// `fmi2SetContinuousStates`
    ///
    /// # Errors
    /// Wrong kind of instance or phase; another number of states; states that are not finite.
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
    /// Wrong kind of instance or phase; another number of states.
    pub fn continuous_states(&self, into: &mut [f64]) -> Result<()> {
        self.check(Call::GetContinuousStates)?;
        expect_length("nx", into.len(), M::STATES)?;
        self.model.states(into);
        Ok(())
    }

    /// `fmi2GetNominalsOfContinuousStates`
    ///
    /// # Errors
    /// Wrong kind of instance; another number of states.
    pub fn nominals(&self, into: &mut [f64]) -> Result<()> {
        self.check(Call::GetNominals)?;
        expect_length("nx", into.len(), M::STATES)?;
        self.model.nominals(into);
        Ok(())
    }

    /// `fmi2GetDerivatives`
    ///
    /// # Errors
    /// Wrong kind of instance or phase; another number of states; derivatives that are not finite.
    pub fn derivatives(&self, into: &mut [f64]) -> Result<()> {
        self.check(Call::GetDerivatives)?;
        expect_length("nx", into.len(), M::STATES)?;
        self.model.derivatives(into)?;
        expect_finite("derivatives", into)
    }

    /// `fmi2GetEventIndicators`
    ///
    /// # Errors
    /// Wrong kind of instance or phase; another number of indicators.
    pub fn event_indicators(&self, into: &mut [f64]) -> Result<()> {
        self.check(Call::GetEventIndicators)?;
        expect_length("ni", into.len(), M::EVENT_INDICATORS)?;
        self.model.event_indicators(into)?;
        expect_finite("event indicators", into)
    }
}
