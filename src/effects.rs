//! THE SIGNAL CHAIN: the nonlinear and additional dynamics that a linear servo lacks, in the order in which the signal passes them.
//!
//! Every effect is exactly the identity at its neutral parameters. The variables of the FMU, the keys of model files, the listing of
//! `actuator effects` and the laws under test are derived from the ordered list below. A new effect is one file in `effects/` and one word
//! in the list; the order of the list is physics.
//!
//! In reading order: `effect` (description of an effect), the list, [`CHAIN`] and its counts (`chain`), [`Effects`] (checked values).

/// The ordered list: passes the names of all effects, from command to measurement, to a macro.
macro_rules! with_all_effects {
    ($macro:ident) => {
        $macro![
            delay,
            command_limit,
            command_rate_limit,
            command_dead_zone,
            command_backlash,
            asymmetric_gain,
            gain_drift,
            dead_zone,
            amplitude_gain,
            hinge_load,
            coulomb_friction,
            acceleration_limit,
            rate_limit,
            position_limit,
            backlash,
            structural_mode,
            sensor_lag,
            sensor_bias,
            chatter,
            quantisation,
        ];
    };
}

/// Declares the file of each effect.
macro_rules! declare_modules {
    ($($name:ident),+ $(,)?) => { $(mod $name;)+ };
}

with_all_effects!(declare_modules);

mod chain;
mod effect;
mod values;

pub use chain::{CHAIN, COMMAND_EFFECTS, EVENT_EFFECTS, INTEGRATED, MEMORY, OUTPUT_EFFECTS, PARAMETERS, find};
pub use effect::{Act, Constraint, Effect, Family, Observed, Parameter, SMALLEST_LIMIT, UNLIMITED};
pub use values::Effects;
