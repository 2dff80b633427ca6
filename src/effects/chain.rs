//! All effects in signal order, and the sizes derived from the list.

use super::effect::{Act, Effect};

/// Lists the effects of these files.
macro_rules! list_effects {
    ($($name:ident),+ $(,)?) => {
        /// All effects, from the command to the measurement.
        pub static CHAIN: &[&Effect] = &[$(&super::$name::EFFECT),+];
    };
}

with_all_effects!(list_effects);

/// Number of entries in the memory of all effects.
pub const MEMORY: usize = {
    let (mut sum, mut index) = (0, 0);
    while index < CHAIN.len() {
        sum += CHAIN[index].memory;
        index += 1;
    }
    sum
};

/// Number of memory entries that are continuous states for ODE solvers: those of the output effects, which come last.
pub const INTEGRATED: usize = {
    let (mut sum, mut index) = (0, 0);
    while index < CHAIN.len() {
        if CHAIN[index].act.is_integrated() {
            sum += CHAIN[index].memory;
        }
        index += 1;
    }
    sum
};

/// Number of parameters of all effects.
pub const PARAMETERS: usize = {
    let (mut sum, mut index) = (0, 0);
    while index < CHAIN.len() {
        sum += CHAIN[index].parameters.len();
        index += 1;
    }
    sum
};

/// Number of effects on the command behind the delay.
pub const COMMAND_EFFECTS: usize = {
    let (mut sum, mut index) = (0, 0);
    while index < CHAIN.len() {
        sum += matches!(CHAIN[index].act, Act::Command(_)) as usize;
        index += 1;
    }
    sum
};

/// Number of effects on the motion behind the drive or, with dynamics, on its measurement.
pub const OUTPUT_EFFECTS: usize = {
    let (mut sum, mut index) = (0, 0);
    while index < CHAIN.len() {
        sum += CHAIN[index].act.is_integrated() as usize;
        index += 1;
    }
    sum
};

/// Number of effects that may have event conditions.
pub const EVENT_EFFECTS: usize = {
    let (mut sum, mut index) = (0, 0);
    while index < CHAIN.len() {
        sum += CHAIN[index].act.has_events() as usize;
        index += 1;
    }
    sum
};

/// The effect with this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Effect> {
    CHAIN.iter().copied().find(|effect| effect.name == name)
}
