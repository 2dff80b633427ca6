//! One life: a few instances, their saved states, and the calls made on them.

use std::{
    ffi::{c_int, c_void},
    ptr::{null, null_mut},
    time::Instant,
};

use fastrand::Rng;
use fmi_export::abi::{Component, SavedState};

use super::{
    arguments::{number, one_in, pick},
    states::serialized,
    tally::Tally,
};
use crate::{
    functions::{Functions, invented},
    host::{self, CO_SIMULATION, Host, MODEL_EXCHANGE},
};

const MOST_INSTANCES: usize = 5;
const MOST_STATES: usize = 12;
pub(super) const OK: c_int = 0;
pub(super) const DISCARD: c_int = 2;
const ERROR: c_int = 3;
const FATAL: c_int = 4;

/// An instance of the life.
#[derive(Clone, Copy)]
pub(super) struct Known {
    pub component: Component,
    pub kind: c_int,
    /// Refusals must have messages, unless its logging has been changed.
    says_all: bool,
    /// Time in model exchange [s].
    pub time: f64,
}

pub(super) struct Life<'a> {
    pub host: &'a Host,
    pub f: &'a Functions,
    pub rng: Rng,
    pub instances: Vec<Known>,
    /// Handles of freed instances.
    stale: Vec<Component>,
    pub states: Vec<SavedState>,
    pub bytes: Vec<Vec<u8>>,
    pub tally: Tally,
}

impl<'a> Life<'a> {
    /// Before the first instance.
    pub fn new(host: &'a Host, rng: Rng) -> Self {
        Self {
            host,
            f: &host.functions,
            rng,
            instances: Vec::new(),
            stale: Vec::new(),
            states: Vec::new(),
            bytes: Vec::new(),
            tally: Tally::default(),
        }
    }

    /// Makes a call and checks the outcome.
    pub fn call(&mut self, name: &'static str, component: Component, body: impl FnOnce(&Functions) -> c_int) -> c_int {
        let known = self.instances.iter().position(|known| known.component == component);
        let before = if one_in(&mut self.rng, 8) { serialized(self.f, component) } else { None };
        host::take_messages();
        let since = Instant::now();
        let status = body(self.f);
        let duration = since.elapsed();
        self.tally.slowest = self.tally.slowest.max((duration, name));
        assert!((OK..=ERROR).contains(&status), "{name}: status {status}, {}", host::last_message());
        self.count(name, status);
        let is_refused = status > 1 && name != "fmi2DoStep" || status == ERROR;
        if let Some(known) = known {
            let known = &mut self.instances[known];
            known.says_all &= name != "fmi2SetDebugLogging";
            if is_refused && known.says_all && !cfg!(miri) {
                assert!(host::take_messages() > 0, "{name}: refused without a word");
            }
        }
        if let Some(before) = before.filter(|_| is_refused)
            && let Some(after) = serialized(self.f, component)
        {
            assert!(before == after, "{name}: refused, and the state is another: {}", host::last_message());
            self.tally.compared += 1;
        }
        status
    }

    pub fn count(&mut self, name: &'static str, status: c_int) {
        assert!(status != FATAL, "{name}: {}", host::last_message());
        self.tally.statuses[usize::try_from(status).expect("a status")] += 1;
        let [calls, successes] = self.tally.functions.entry(name).or_default();
        *calls += 1;
        *successes += u64::from(status <= 1);
    }

    /// An instance of the life, or an invalid handle.
    pub fn any_component(&mut self) -> Component {
        if self.instances.is_empty() || one_in(&mut self.rng, 12) {
            return self.wrong_handle();
        }
        self.instances[self.rng.usize(..self.instances.len())].component
    }

    fn wrong_handle(&mut self) -> *mut c_void {
        let any = self.rng.usize(..);
        match self.rng.u8(..4) {
            0 => null_mut(),
            1 => invented(any),
            2 if !self.stale.is_empty() => pick(&mut self.rng, &self.stale),
            _ => {
                // One bit off a valid one.
                let near = self.instances.first().map_or(1, |known| known.component as usize);
                let wrong = invented(near ^ (1 << self.rng.u32(..usize::BITS)));
                if self.instances.iter().any(|known| known.component == wrong) { null_mut() } else { wrong }
            }
        }
    }

    /// A saved state of the life, including freed ones and those of other instances, or an invalid handle.
    pub fn any_state(&mut self) -> SavedState {
        if self.states.is_empty() || one_in(&mut self.rng, 6) {
            let wrong = self.rng.usize(..64);
            return pick(&mut self.rng, &[null_mut(), invented(wrong), invented(usize::MAX)]);
        }
        pick(&mut self.rng, &self.states)
    }

    pub fn keep_state(&mut self, state: SavedState) {
        if self.states.len() == MOST_STATES {
            self.states.remove(0);
        }
        self.states.push(state);
    }

    pub fn instantiate(&mut self) {
        if self.instances.len() == MOST_INSTANCES {
            self.free_one();
        }
        let kind = pick(&mut self.rng, &[MODEL_EXCHANGE, CO_SIMULATION, CO_SIMULATION]);
        let logs = !one_in(&mut self.rng, 4);
        let component = self.host.instantiate(kind, one_in(&mut self.rng, 3), logs);
        assert!(!component.is_null(), "{}", host::last_message());
        self.count("fmi2Instantiate", OK);
        self.instances.push(Known { component, kind, says_all: logs, time: 0.0 });
    }

    /// With invalid arguments, so that there is no instance; if they are valid by chance, it is freed.
    pub fn instantiate_wrongly(&mut self) {
        let texts = [c"a".as_ptr(), c"".as_ptr(), c"\xff%n%s{}".as_ptr(), c"{0-0-0-0-0}".as_ptr(), null()];
        let uris =
            [c"file:///".as_ptr(), c"file:///dev".as_ptr(), c"file://%00".as_ptr(), c"\xff\xfe".as_ptr(), null()];
        let (rng, kind) = (&mut self.rng, super::arguments::whole);
        let (name, kind, guid, uri) = (pick(rng, &texts), kind(rng), pick(rng, &texts), pick(rng, &uris));
        let component = self.host.instantiate_with(name, kind, guid, uri, true);
        self.count("fmi2Instantiate", if component.is_null() { ERROR } else { OK });
        self.free(component);
    }

    pub fn free_one(&mut self) {
        let known = self.instances[self.rng.usize(..self.instances.len())];
        self.free_known(known.component);
    }

    pub fn free_known(&mut self, component: Component) {
        self.instances.retain(|known| known.component != component);
        self.free(component);
        self.free(component); // twice is once
        self.stale.push(component);
    }

    pub fn free(&mut self, component: Component) {
        (self.f.fmi2FreeInstance)(component);
        self.count("fmi2FreeInstance", OK);
    }

    /// A host whose logger frees an instance while an error is being logged.
    pub fn free_in_logger(&mut self) {
        let known = self.instances.swap_remove(self.rng.usize(..self.instances.len()));
        host::free_in_logger(self.f, known.component);
        let other = self.any_component();
        let component = if one_in(&mut self.rng, 2) { other } else { known.component };
        let status = (self.f.fmi2SetTime)(component, f64::NAN);
        self.count("fmi2SetTime", status);
        self.free(known.component); // if nothing was logged
        host::free_nothing_in_logger();
        self.stale.push(known.component);
    }

    /// This many random numbers.
    pub fn numbers(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| number(&mut self.rng)).collect()
    }
}
