//! Tests of the actuator and its FMU as a whole, as one program. Tests of one idea are in its file.
#![allow(clippy::unwrap_used, missing_docs)]

mod allocation;
mod behaviour;
mod dynamics;
mod effects;
mod layers;
mod overflow;
mod slave;
mod standard;
mod toy_effect;
