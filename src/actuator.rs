//! The actuator: constants in [`Actuator`], memory in [`State`], and the step from one communication point to the next.
//!
//! With all effects neutral a step is one linear [`transition`](crate::transition). Otherwise it is divided at the breakpoints of the
//! command. Each piece is a transition where no effect acts on the motion; else it is divided into segments short enough for the
//! series to converge, and at events.
//!
//! In reading order: `signals` (inputs and outputs), `state`, `constants`, `step` (a step piece by piece), `segment` (the solution over one
//! segment), `by_map` (a command piece without a change of mode, in a search: `linear_map`, `linear_maps`, `linear_system`,
//! `cubic_spring`), `whole_step` (a step that is one such piece), `corners` (a step of a linear actuator whose command has corners),
//! `turning` (a step with play behind a linear drive), `workspace`, `integration` (derivatives, modes and event indicators for ODE
//! solvers).

mod by_map;
mod constants;
mod corners;
mod cubic_spring;
mod integration;
mod linear_map;
mod linear_maps;
mod linear_system;
mod segment;
mod signals;
mod state;
mod step;
mod turning;
mod whole_step;
mod workspace;

pub use constants::Actuator;
pub(crate) use integration::FIRST_INTEGRATED;
pub use integration::{EvaluatedInputs, Modes, StateDerivatives};
pub use signals::{Failure, Inputs, Outputs};
pub use state::State;
pub use workspace::Workspace;
