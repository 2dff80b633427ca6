//! Which call is legal when: the state machine of an FMI 2.0 co-simulation slave as a table.
//!
//! Steps are computed within `fmi2DoStep`, so that the states for pending, failed and cancelled steps do not occur. A
//! refused call changes nothing, so that there is no error state either: the instance goes on from where it was. Values
//! may be read at any time, which is more than the standard asks for and what importers do.

use crate::error::{Error, Result};

/// Where in its life the instance is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Phase {
    /// After `fmi2Instantiate` or `fmi2Reset`.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// At a communication point.
    Stepping,
    /// After `fmi2Terminate`.
    Terminated,
}

impl Phase {
    /// Name used in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Instantiated => "instantiated",
            Self::Initialization => "initialization mode",
            Self::Stepping => "step complete",
            Self::Terminated => "terminated",
        }
    }
}

const INSTANTIATED: u8 = 1;
const INITIALIZATION: u8 = 2;
const STEPPING: u8 = 4;
const TERMINATED: u8 = 8;
const ANY: u8 = 15;

/// Calls by what they do; getters of every type are one row, and so are setters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Call {
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
    /// `fmi2SetReal` and its like, for inputs and tunable parameters
    Set,
    /// the same for fixed parameters
    SetFixed,
    /// `fmi2SetRealInputDerivatives`
    SetInputDerivatives,
    /// `fmi2GetRealOutputDerivatives`
    GetOutputDerivatives,
    /// `fmi2GetDirectionalDerivative`
    GetDirectionalDerivative,
    /// `fmi2DoStep`
    DoStep,
    /// `fmi2CancelStep`
    CancelStep,
    /// `fmi2GetStatus` and its like
    GetStatus,
    /// `fmi2GetFMUstate` and its like
    State,
}

#[rustfmt::skip]
const LEGAL: [(Call, &str, u8); 15] = [
    (Call::SetupExperiment,          "fmi2SetupExperiment",          INSTANTIATED),
    (Call::EnterInitializationMode,  "fmi2EnterInitializationMode",  INSTANTIATED),
    (Call::ExitInitializationMode,   "fmi2ExitInitializationMode",   INITIALIZATION),
    (Call::Terminate,                "fmi2Terminate",                STEPPING),
    (Call::Reset,                    "fmi2Reset",                    ANY),
    (Call::Get,                      "getting values",               ANY),
    (Call::Set,                      "setting values",               INSTANTIATED | INITIALIZATION | STEPPING),
    (Call::SetFixed,                 "setting fixed parameters",     INSTANTIATED | INITIALIZATION),
    (Call::SetInputDerivatives,      "fmi2SetRealInputDerivatives",  INSTANTIATED | INITIALIZATION | STEPPING),
    (Call::GetOutputDerivatives,     "fmi2GetRealOutputDerivatives", STEPPING | TERMINATED),
    (Call::GetDirectionalDerivative, "fmi2GetDirectionalDerivative", INITIALIZATION | STEPPING | TERMINATED),
    (Call::DoStep,                   "fmi2DoStep",                   STEPPING),
    (Call::CancelStep,               "fmi2CancelStep",               0),
    (Call::GetStatus,                "fmi2GetStatus",                STEPPING | TERMINATED),
    (Call::State,                    "FMU state functions",          ANY),
];

/// Refuses a call that is not legal in this phase.
///
/// # Errors
/// The call's name, the phase, and the phases in which it is legal.
pub fn check(call: Call, phase: Phase) -> Result<()> {
    let (_, name, legal) = LEGAL[call as usize];
    let phases = [
        (Phase::Instantiated, INSTANTIATED),
        (Phase::Initialization, INITIALIZATION),
        (Phase::Stepping, STEPPING),
        (Phase::Terminated, TERMINATED),
    ];
    if phases.iter().any(|(other, bit)| *other == phase && legal & bit != 0) {
        return Ok(());
    }
    let allowed: Vec<&str> = phases.iter().filter(|(_, bit)| legal & bit != 0).map(|(phase, _)| phase.name()).collect();
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
}
