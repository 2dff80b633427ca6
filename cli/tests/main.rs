//! Tests of the program and its library as a whole, as one program. Tests of one idea are in its file.
#![allow(clippy::unwrap_used, missing_docs)]

mod campaign;
mod command_line;
mod compare;
mod diagnose;
mod exchange;
#[allow(dead_code)] // kinds of noise used only in tests of estimates
#[path = "../../identification/tests/generated.rs"]
mod generated;
mod golden;
mod package;
mod records;
