//! Legal calls: the state machines of FMI 2.0 for co-simulation (section 4.2.4) and for model exchange (section 3.2.3), as one table.
//!
//! Steps are computed within `fmi2DoStep`, so that the states for pending, failed and cancelled steps do not occur. A refused call changes
//! nothing, so that there is no error state either: the instance continues from its present state. Values may be read in every state, which
//! is more than the standard requires and what importers do.

use crate::error::{Error, Result};

/// The kind of simulation of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Kind {
    /// The host integrates.
    ModelExchange,
    /// The instance integrates.
    CoSimulation,
}

impl Kind {
    /// Its name in messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ModelExchange => "model exchange",
            Self::CoSimulation => "co-simulation",
        }
    }
}

/// The state of an instance in the state machine of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Phase {
    /// After `fmi2Instantiate` or `fmi2Reset`.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// Co-simulation: at a communication point.
    StepComplete,
    /// Model exchange: event mode, in which time is constant.
    EventMode,
    /// Model exchange: continuous-time mode, in which the host integrates.
    ContinuousTimeMode,
    /// After `fmi2Terminate`.
    Terminated,
}

impl Phase {
    /// Name used in messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Instantiated => "instantiated",
            Self::Initialization => "initialization mode",
            Self::StepComplete => "step complete",
            Self::EventMode => "event mode",
            Self::ContinuousTimeMode => "continuous-time mode",
            Self::Terminated => "terminated",
        }
    }

    /// True once the initial values are fixed.
    #[must_use]
    pub fn is_initialized(self) -> bool {
        !matches!(self, Self::Instantiated | Self::Initialization)
    }

    #[inline]
    pub(crate) const fn bit(self) -> u8 {
        1 << self as u8
    }

    /// The phases of one kind of instance, in their order.
    pub(crate) fn of(kind: Kind) -> &'static [Self] {
        use Phase::{ContinuousTimeMode, EventMode, Initialization, Instantiated, StepComplete, Terminated};
        match kind {
            Kind::CoSimulation => &[Instantiated, Initialization, StepComplete, Terminated],
            Kind::ModelExchange => &[Instantiated, Initialization, EventMode, ContinuousTimeMode, Terminated],
        }
    }
}

const INSTANTIATED: u8 = Phase::Instantiated.bit();
const INITIALIZATION: u8 = Phase::Initialization.bit();
const STEPPING: u8 = Phase::StepComplete.bit();
const EVENTS: u8 = Phase::EventMode.bit();
const CONTINUOUS: u8 = Phase::ContinuousTimeMode.bit();
const TERMINATED: u8 = Phase::Terminated.bit();
const ANY: u8 = 63;
const SOLVING: u8 = EVENTS | CONTINUOUS;

/// Kinds of calls; getters of all types are one row, and so are setters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Call {
    /// `fmi2SetupExperiment`
    SetupExperiment,
    /// `fmi2EnterInitializationMode`
    EnterInitializationMode,
    /// `fmi2ExitInitializationMode`
    ExitInitializationMode,
    /// `fmi2Terminate`
    Terminate,
    /// `fmi2Reset`
    Reset,
    /// `fmi2GetReal` and its like
    Get,
    /// `fmi2SetReal` and its like, for inputs. The standard allows discrete ones in event mode only; hosts (fmpy) set them with the others,
    /// so that they are accepted and take effect at the next event.
    SetInput,
    /// As above for tunable parameters
    Set,
    /// As above for fixed parameters
    SetFixed,
    /// `fmi2GetDirectionalDerivative`
    GetDirectionalDerivative,
    /// `fmi2GetFMUstate` and its like
    State,
    /// `fmi2SetRealInputDerivatives`
    SetInputDerivatives,
    /// `fmi2GetRealOutputDerivatives`
    GetOutputDerivatives,
    /// `fmi2DoStep`
    DoStep,
    /// `fmi2CancelStep`
    CancelStep,
    /// `fmi2GetStatus` and its like
    GetStatus,
    /// `fmi2EnterEventMode`
    EnterEventMode,
    /// `fmi2NewDiscreteStates`
    NewDiscreteStates,
    /// `fmi2EnterContinuousTimeMode`
    EnterContinuousTimeMode,
    /// `fmi2CompletedIntegratorStep`
    CompletedIntegratorStep,
    /// `fmi2SetTime`
    SetTime,
    /// `fmi2SetContinuousStates`
    SetContinuousStates,
    /// `fmi2GetDerivatives`
    GetDerivatives,
    /// `fmi2GetEventIndicators`
    GetEventIndicators,
    /// `fmi2GetContinuousStates`
    GetContinuousStates,
    /// `fmi2GetNominalsOfContinuousStates`
    GetNominals,
}

#[rustfmt::skip]
const LEGAL: [(Call, &str, u8); 26] = [
    (Call::SetupExperiment,          "fmi2SetupExperiment",          INSTANTIATED),
    (Call::EnterInitializationMode,  "fmi2EnterInitializationMode",  INSTANTIATED),
    (Call::ExitInitializationMode,   "fmi2ExitInitializationMode",   INITIALIZATION),
    (Call::Terminate,                "fmi2Terminate",                STEPPING | SOLVING),
    (Call::Reset,                    "fmi2Reset",                    ANY),
    (Call::Get,                      "getting values",               ANY),
    (Call::SetInput,                 "setting values",               INSTANTIATED | INITIALIZATION | STEPPING | SOLVING),
    (Call::Set,                      "setting values",               INSTANTIATED | INITIALIZATION | STEPPING | EVENTS),
    (Call::SetFixed,                 "setting fixed parameters",     INSTANTIATED | INITIALIZATION),
    (Call::GetDirectionalDerivative, "fmi2GetDirectionalDerivative", INITIALIZATION | STEPPING | SOLVING | TERMINATED),
    (Call::State,                    "FMU state functions",          ANY),
    (Call::SetInputDerivatives,      "fmi2SetRealInputDerivatives",  INSTANTIATED | INITIALIZATION | STEPPING),
    (Call::GetOutputDerivatives,     "fmi2GetRealOutputDerivatives", STEPPING | TERMINATED),
    (Call::DoStep,                   "fmi2DoStep",                   STEPPING),
    (Call::CancelStep,               "fmi2CancelStep",               0),
    (Call::GetStatus,                "fmi2GetStatus",                STEPPING | TERMINATED),
    (Call::EnterEventMode,           "fmi2EnterEventMode",           SOLVING),
    (Call::NewDiscreteStates,        "fmi2NewDiscreteStates",        EVENTS),
    (Call::EnterContinuousTimeMode,  "fmi2EnterContinuousTimeMode",  EVENTS),
    (Call::CompletedIntegratorStep,  "fmi2CompletedIntegratorStep",  CONTINUOUS),
    (Call::SetTime,                  "fmi2SetTime",                  SOLVING),
    (Call::SetContinuousStates,      "fmi2SetContinuousStates",      CONTINUOUS),
    (Call::GetDerivatives,           "fmi2GetDerivatives",           INITIALIZATION | SOLVING | TERMINATED),
    (Call::GetEventIndicators,       "fmi2GetEventIndicators",       INITIALIZATION | SOLVING | TERMINATED),
    (Call::GetContinuousStates,      "fmi2GetContinuousStates",      INITIALIZATION | SOLVING | TERMINATED),
    (Call::GetNominals,              "fmi2GetNominalsOfContinuousStates", ANY),
];

impl Call {
    /// The kind of instance for which this call is defined, if there is only one.
    #[inline]
    fn only_for(self) -> Option<Kind> {
        match self {
            Self::SetInputDerivatives
            | Self::GetOutputDerivatives
            | Self::DoStep
            | Self::CancelStep
            | Self::GetStatus => Some(Kind::CoSimulation),
            Self::EnterEventMode
            | Self::NewDiscreteStates
            | Self::EnterContinuousTimeMode
            | Self::CompletedIntegratorStep
            | Self::SetTime
            | Self::SetContinuousStates
            | Self::GetDerivatives
            | Self::GetEventIndicators
            | Self::GetContinuousStates
            | Self::GetNominals => Some(Kind::ModelExchange),
            _ => None,
        }
    }
}

/// Bits of the phases in which a call is legal.
pub(crate) fn phases(call: Call) -> u8 {
    LEGAL[call as usize].2
}

/// Refuses a call that is not legal for this kind of instance, or not in this phase.
///
/// # Errors
/// The call's name, the phase, and the phases in which it is legal.
#[inline]
pub(crate) fn check(call: Call, kind: Kind, phase: Phase) -> Result<()> {
    let (_, _, legal) = LEGAL[call as usize];
    // Some phases exist for one kind of instance only.
    let implies_kind = legal == STEPPING || legal & !SOLVING == 0;
    if (legal == ANY || legal & phase.bit() != 0) && (implies_kind || call.only_for().is_none_or(|only| only == kind)) {
        return Ok(());
    }
    refuse(call, kind, phase)
}

#[cold]
fn refuse(call: Call, kind: Kind, phase: Phase) -> Result<()> {
    let (_, name, legal) = LEGAL[call as usize];
    if let Some(only) = call.only_for().filter(|only| *only != kind) {
        let found = format!("an instance for {}", kind.name());
        return Err(Error::new(format!("call of {name}"), found, format!("instances for {}", only.name())));
    }
    let phases = Phase::of(kind).iter();
    let allowed: Vec<&str> = phases.filter(|phase| legal & phase.bit() != 0).map(|phase| phase.name()).collect();
    let allowed = if allowed.is_empty() {
        "in no state, since no step is ever pending".to_owned()
    } else {
        format!("in the states {}", allowed.join(", "))
    };
    Err(Error::new(format!("call of {name}"), format!("the state `{}`", phase.name()), allowed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_calls() {
        for (index, (call, ..)) in LEGAL.iter().enumerate() {
            assert_eq!(*call as usize, index);
        }
    }

    #[test]
    fn calls_of_the_other_kind_are_refused_with_its_name() {
        let refusal = check(Call::DoStep, Kind::ModelExchange, Phase::EventMode).unwrap_err().to_string();
        assert!(refusal.contains("fmi2DoStep") && refusal.contains("instances for co-simulation"), "{refusal}");
        assert!(check(Call::SetTime, Kind::CoSimulation, Phase::StepComplete).is_err());
        assert!(check(Call::SetTime, Kind::ModelExchange, Phase::ContinuousTimeMode).is_ok());
    }
}
