//! Results as charts and pages. Nothing here computes a result.

pub mod campaign;
pub mod comparison;
pub mod diagnosis;
pub mod documentation;
pub mod fit;
pub mod head;
pub mod icon;
pub mod inspection;
pub mod page;
pub mod plot;
pub mod spectra;
