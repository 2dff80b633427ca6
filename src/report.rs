//! Values to pictures and pages. Nothing here computes a result; it shows those of others.

pub mod documentation;
pub mod icon;
pub mod plot;
