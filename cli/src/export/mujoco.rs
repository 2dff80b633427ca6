//! MuJoCo: a unit mass on a slide joint, whose coordinate is the position in the model's unit, and one actuator.
//!
//! ```text
//! force = ω² (a - δ) of the actuator,  -2 ζ ω δ̇ of the joint's damping,  a' = p (k c - a) or a = k c
//! ```

use std::fmt::Write as _;

use super::target::{Source, Target};

pub(super) const EFFECTS: [&str; 5] =
    ["command_limit", "hinge_load", "coulomb_friction", "acceleration_limit", "position_limit"];

/// Maximum p h of the pole for fourth-order integration.
const FASTEST_POLE: f64 = 2.0;

pub(super) fn body(source: &mut Source) -> String {
    let step_s = Target::Mujoco.step_s().unwrap_or_default();
    let pole = source.pole(step_s, FASTEST_POLE);
    let [k, _, omega, zeta] = source.model.base.values();
    let square = omega * omega;
    let mut joint = String::new();
    let mut actuator = String::new();
    let mut gravity = 0.0;
    // Writing to a String cannot fail.
    if let (Some(stiffness), Some(bias)) = (source.parameter("hinge_load", 0), source.parameter("hinge_load", 1)) {
        let _ = write!(joint, " stiffness=\"{}\"", square * stiffness);
        gravity = square * bias; // a constant force on the unit mass
    }
    if let Some(level) = source.parameter("coulomb_friction", 0) {
        let _ = write!(joint, " frictionloss=\"{}\" solreffriction=\"{} 1\"", square * level, 4.0 * step_s);
        source.notes.push("friction and stops are soft constraints of the solver".into());
    }
    if let (Some(min), Some(max)) = (source.parameter("position_limit", 0), source.parameter("position_limit", 1)) {
        let _ = write!(joint, " range=\"{min} {max}\" solreflimit=\"{} 1\"", 4.0 * step_s);
        source.notes.push("friction and stops are soft constraints of the solver".into());
    }
    source.notes.dedup();
    if let Some(limit) = source.parameter("acceleration_limit", 0) {
        let _ = write!(actuator, " forcerange=\"-{limit} {limit}\"");
    }
    if let (Some(min), Some(max)) = (source.parameter("command_limit", 0), source.parameter("command_limit", 1)) {
        let _ = write!(actuator, " ctrlrange=\"{min} {max}\"");
    }
    if let Some(p) = pole {
        let _ = write!(actuator, " dyntype=\"filter\" dynprm=\"{}\"", 1.0 / p);
    }
    format!(
        "<mujoco model=\"{name}\">\n  <compiler autolimits=\"true\"/>\n  \
         <option timestep=\"{step_s}\" integrator=\"RK4\" gravity=\"{gravity} 0 0\"/>\n  <worldbody>\n    <body name=\"surface\">\n      \
         <joint name=\"position\" type=\"slide\" axis=\"1 0 0\" damping=\"{damping}\"{joint}/>\n      \
         <geom type=\"sphere\" size=\"0.01\" mass=\"1\" contype=\"0\" conaffinity=\"0\"/>\n    </body>\n  </worldbody>\n  <actuator>\n    \
         <general name=\"command\" joint=\"position\" gainprm=\"{gain}\" biastype=\"affine\" biasprm=\"0 -{square} 0\"{actuator}/>\n  \
         </actuator>\n</mujoco>\n",
        name = source.name,
        damping = 2.0 * zeta * omega,
        gain = square * k,
    )
}
