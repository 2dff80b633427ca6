//! `modelDescription.xml`, from the variables that the wing implements.

use fmi_export::{
    Kind, Model, Phase, Value,
    description::{Capabilities, Dependencies, Describe, Header, Unit, xml},
};

use crate::interface::{BactWing, GUID, Slot};

const FOOT: f64 = 0.3048;
const POUND_FORCE: f64 = 4.448_221_615_260_5;

const fn unit(name: &'static str, kg_m_s_rad: [i32; 4], factor: f64) -> Unit {
    Unit { name, kg_m_s_rad, factor, display: None }
}

const UNITS: [Unit; 7] = [
    unit("deg", [0, 0, 0, 1], std::f64::consts::PI / 180.0),
    unit("ft", [0, 1, 0, 0], FOOT),
    unit("ft/s", [0, 1, -1, 0], FOOT),
    unit("lbf", [1, 1, -2, 0], POUND_FORCE),
    unit("psf", [1, -1, -2, 0], POUND_FORCE / (FOOT * FOOT)),
    unit("s", [0, 0, 1, 0], 1.0),
    unit("1", [0; 4], 1.0),
];

struct Wing;

impl Describe<BactWing> for Wing {
    fn start(&self, slot: Slot) -> Option<Value> {
        match slot {
            Slot::Pitch | Slot::Plunge | Slot::Command => None,
            _ => BactWing::new(&(), Kind::CoSimulation).get(slot, Phase::Instantiated).ok(),
        }
    }

    /// Outputs are those at the end of the last step.
    fn dependencies(&self, _output: Slot) -> Dependencies<'_, Slot> {
        Dependencies::none()
    }

    fn initial_dependencies(&self, output: Slot) -> Dependencies<'_, Slot> {
        Dependencies::On(Box::new(move |known| match output {
            Slot::Pitch => known == Slot::InitialPitch,
            Slot::Plunge => known == Slot::InitialPlunge,
            _ => !matches!(known, Slot::Input(_) | Slot::Pitch | Slot::Plunge | Slot::Command),
        }))
    }
}

/// The file.
#[must_use]
pub fn description() -> String {
    let header = Header {
        name: BactWing::IDENTIFIER,
        guid: GUID,
        description: "The BACT wing on its pitch-and-plunge mount in quasi-steady flow, with the published control law",
        version: env!("CARGO_PKG_VERSION"),
        license: env!("CARGO_PKG_LICENSE"),
        generation_tool: concat!("bact-wing ", env!("CARGO_PKG_VERSION")),
        has_structured_names: false,
        capabilities: Capabilities {
            interpolates_inputs: true,
            output_derivative_order: 1,
            directional_derivatives: false,
        },
        units: &UNITS,
        enumerations: &[],
        experiment: None,
    };
    xml(&header, &Wing)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_committed_description_is_rendered_from_the_code() {
        let now = super::description();
        let remedy =
            "cargo run -p bact-wing --example describe > examples/flutter-suppression/wing/modelDescription.xml";
        assert!(include_str!("../modelDescription.xml") == now, "refresh it: {remedy}\n{now}");
    }
}
