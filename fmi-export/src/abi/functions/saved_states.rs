//! Saved states (section 2.1.8 of the standard).

use libc::{c_char, c_int};

use crate::{
    abi::{
        Component, Instances, SavedState,
        arrays::{array, array_mut, place},
    },
    error::{Error, Result},
    model::Model,
};

fn handle(state: SavedState) -> Option<usize> {
    (!state.is_null()).then_some(state as usize)
}

fn given(state: SavedState) -> Result<usize> {
    handle(state).ok_or_else(|| Error::new("FMUstate", "NULL", "a saved state"))
}

pub fn fmi2GetFMUstate<M: Model>(all: &Instances<M>, component: Component, state: *mut SavedState) -> c_int {
    all.guarded(component, "fmi2GetFMUstate", |instance| {
        let state = place("FMUstate", state)?;
        *state = instance.save(handle(*state))? as SavedState;
        Ok(())
    })
}

pub fn fmi2SetFMUstate<M: Model>(all: &Instances<M>, component: Component, state: SavedState) -> c_int {
    all.guarded(component, "fmi2SetFMUstate", |instance| instance.restore(given(state)?))
}

pub fn fmi2FreeFMUstate<M: Model>(all: &Instances<M>, component: Component, state: *mut SavedState) -> c_int {
    all.guarded(component, "fmi2FreeFMUstate", |instance| {
        // The standard: freeing NULL, or what a NULL pointer would point to, does nothing.
        if state.is_null() {
            return Ok(());
        }
        let state = place("FMUstate", state)?;
        if let Some(handle) = handle(*state) {
            instance.free(handle)?;
            *state = std::ptr::null_mut();
        }
        Ok(())
    })
}

pub fn fmi2SerializedFMUstateSize<M: Model>(
    all: &Instances<M>,
    component: Component,
    state: SavedState,
    size: *mut usize,
) -> c_int {
    all.guarded(component, "fmi2SerializedFMUstateSize", |instance| {
        *place("size", size)? = instance.serialize(given(state)?)?.len();
        Ok(())
    })
}

pub fn fmi2SerializeFMUstate<M: Model>(
    all: &Instances<M>,
    component: Component,
    state: SavedState,
    bytes: *mut c_char,
    size: usize,
) -> c_int {
    all.guarded(component, "fmi2SerializeFMUstate", |instance| {
        let written = instance.serialize(given(state)?)?;
        if size < written.len() {
            return Err(Error::new("size", size, format!("{} or more", written.len())));
        }
        array_mut("serializedState", bytes.cast::<u8>(), size)?[..written.len()].copy_from_slice(&written);
        Ok(())
    })
}

pub fn fmi2DeSerializeFMUstate<M: Model>(
    all: &Instances<M>,
    component: Component,
    bytes: *const c_char,
    size: usize,
    state: *mut SavedState,
) -> c_int {
    all.guarded(component, "fmi2DeSerializeFMUstate", |instance| {
        let state = place("FMUstate", state)?;
        let bytes = array("serializedState", bytes.cast::<u8>(), size)?;
        *state = instance.deserialize(bytes, handle(*state))? as SavedState;
        Ok(())
    })
}
