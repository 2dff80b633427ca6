//! Values to pictures and pages. Nothing here computes a result; it shows those of others.

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
