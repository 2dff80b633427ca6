//! Tests of the package as a whole, as one program. Tests of one idea stand beside it in its file.
#![allow(clippy::unwrap_used, missing_docs)]

mod campaign;
mod command_line;
mod compare;
mod coverage;
mod diagnose;
mod dynamics;
mod effects;
mod estimate;
mod exchange;
mod frequency;
mod generated;
mod golden;
mod layers;
mod package;
mod records;
mod slave;
mod toy_effect;
