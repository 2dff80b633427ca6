//! Memory over many steps, lives and loads: constant, or there is a leak.

use std::path::Path;

use crate::{
    functions::{Functions, load},
    host::{self, CO_SIMULATION, Host, MODEL_EXCHANGE},
    many::reference,
};

/// Memory of this process before and after work that should not change it \[bytes\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Growth {
    /// After a tenth of the work, when all permanent allocations have been made.
    pub before: u64,
    /// At the end.
    pub after: u64,
}

impl Growth {
    /// Increase at the end \[bytes\].
    #[must_use]
    pub fn bytes(self) -> u64 {
        self.after.saturating_sub(self.before)
    }
}

/// Memory in use by this process, if the system reports it \[bytes\]; otherwise 0.
#[must_use]
pub fn resident() -> u64 {
    const KIB: u64 = 1024;
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_ascii_whitespace().next()?.parse::<u64>().ok()).unwrap_or(0) * KIB
}

/// Repeats work, and measures after a tenth of it and at the end.
fn grown(times: u64, mut body: impl FnMut(u64)) -> Growth {
    let tenth = times.div_ceil(10);
    (0..tenth).for_each(&mut body);
    let before = resident();
    (tenth..times).for_each(&mut body);
    Growth { before, after: resident() }
}

/// Steps of one instance with a delay, play and a rate limit, with a saved state now and then.
#[must_use]
pub fn steps(host: &Host, count: u64) -> Growth {
    let effects = [("delay.time", 0.05), ("backlash.gap", 0.2), ("rate_limit.up", 60.0), ("rate_limit.down", 60.0)];
    let component = host.initialized(CO_SIMULATION, &effects.map(|(name, value)| (reference(name), value)));
    let (f, command) = (&host.functions, reference("command"));
    let mut time = 0.0;
    let growth = grown(count, |step| {
        const STEP_S: f64 = 1e-3;
        let value = 3.0 * (time * 7.0_f64).sin();
        assert_eq!((f.fmi2SetReal)(component, &raw const command, 1, &raw const value), 0);
        assert_eq!((f.fmi2DoStep)(component, time, STEP_S, 0), 0, "{}", host::last_message());
        time += STEP_S;
        if step % 100 == 0 {
            let mut state = std::ptr::null_mut();
            assert_eq!((f.fmi2GetFMUstate)(component, &raw mut state), 0);
            assert_eq!((f.fmi2SetFMUstate)(component, state), 0);
            assert_eq!((f.fmi2FreeFMUstate)(component, &raw mut state), 0);
        }
    });
    (f.fmi2FreeInstance)(component);
    growth
}

/// Lives of instances of both kinds and both models; their saved states and messages are freed with them.
#[must_use]
pub fn lives(host: &Host, count: u64) -> Growth {
    let f = &host.functions;
    grown(count, |life| {
        let kind = if life % 3 == 0 { MODEL_EXCHANGE } else { CO_SIMULATION };
        let component = host.instantiate(kind, life % 2 == 0, true);
        assert!(!component.is_null());
        assert_eq!((f.fmi2EnterInitializationMode)(component), 0);
        assert_eq!((f.fmi2ExitInitializationMode)(component), 0);
        for _ in 0..3 {
            let mut state = std::ptr::null_mut();
            assert_eq!((f.fmi2GetFMUstate)(component, &raw mut state), 0);
        }
        assert_eq!((f.fmi2SetTime)(component, f64::NAN), 3);
        if kind == CO_SIMULATION {
            assert_eq!((f.fmi2DoStep)(component, 0.0, 0.01, 0), 0);
        }
        (f.fmi2FreeInstance)(component);
    })
}

/// Loads a library, steps an instance, frees it and unloads the library.
#[must_use]
pub fn loads(path: &Path, count: u64) -> Growth {
    grown(count, |_| {
        let library = load(path).unwrap_or_else(|error| panic!("{error}"));
        let host = Host::new(Functions::of(&library).unwrap_or_else(|error| panic!("{error}")));
        let component = host.initialized(CO_SIMULATION, &[]);
        assert_eq!((host.functions.fmi2DoStep)(component, 0.0, 0.01, 0), 0);
        (host.functions.fmi2FreeInstance)(component);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Allowance for the allocator and concurrent tests.
    const ALLOWED: u64 = 8 << 20;

    #[test]
    fn memory_is_flat_over_steps_and_lives() {
        let _alone = crate::alone();
        let host = Host::new(Functions::linked());
        let (count, of) = if cfg!(miri) { (20, 20) } else { (50_000, 5_000) };
        for growth in [steps(&host, count), lives(&host, of)] {
            assert!(growth.bytes() < ALLOWED, "{growth:?}");
        }
    }
}
