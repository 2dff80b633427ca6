//! Tests of the identification as a whole, as one program. Tests of one idea are in its file.
#![allow(clippy::unwrap_used, missing_docs)]

mod coverage;
mod ends;
mod estimate;
mod excitation;
mod frequency;
mod generated;
mod inspect;
mod response;
mod robustness;
