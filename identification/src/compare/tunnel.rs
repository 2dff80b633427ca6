//! The wind tunnel's state for each set: captions of figures A8 to A10 of NASA/TM-1998-208452.

use serde::Serialize;

use actuator_fmu::parameters::{LoadCase, SetName, Stage, Surface};

/// Mach number and dynamic pressure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tunnel {
    /// Mach number \[1\].
    pub mach: f64,
    /// Dynamic pressure \[psf\].
    pub dynamic_pressure_psf: f64,
}

/// Loaded sets, in the order of table 2.
pub const LOADED: [(Surface, Stage, Tunnel); 8] = [
    (Surface::TrailingEdge, Stage::Early, Tunnel { mach: 0.86, dynamic_pressure_psf: 115.0 }),
    (Surface::TrailingEdge, Stage::Middle, Tunnel { mach: 0.91, dynamic_pressure_psf: 190.0 }),
    (Surface::TrailingEdge, Stage::Late, Tunnel { mach: 0.71, dynamic_pressure_psf: 105.0 }),
    (Surface::UpperSpoiler, Stage::Early, Tunnel { mach: 0.65, dynamic_pressure_psf: 74.0 }),
    (Surface::UpperSpoiler, Stage::Middle, Tunnel { mach: 0.63, dynamic_pressure_psf: 154.0 }),
    (Surface::UpperSpoiler, Stage::Late, Tunnel { mach: 0.80, dynamic_pressure_psf: 140.0 }),
    (Surface::LowerSpoiler, Stage::Early, Tunnel { mach: 0.65, dynamic_pressure_psf: 74.0 }),
    (Surface::LowerSpoiler, Stage::Middle, Tunnel { mach: 0.90, dynamic_pressure_psf: 188.0 }),
];

/// State of the tunnel for a set: wind off without load. The set without data has none.
#[must_use]
pub fn tunnel(name: SetName) -> Option<Tunnel> {
    match name.load_case {
        LoadCase::Unloaded => Some(Tunnel { mach: 0.0, dynamic_pressure_psf: 0.0 }),
        LoadCase::Loaded => LOADED
            .iter()
            .find(|(surface, stage, _)| (*surface, *stage) == (name.surface, name.stage))
            .map(|(_, _, tunnel)| *tunnel),
    }
}
