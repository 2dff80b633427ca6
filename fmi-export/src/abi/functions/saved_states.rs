//! Saved states (section 2.1.8 of the standard).

use libc::{c_char, c_int};

use crate::{
    abi::{
        Component, Instances, SavedState,
        arrays::{Input, Output, Place},
    },
    error::{Error, Result},
    instance::Instance,
    model::Model,
};

#[inline]
fn handle(state: SavedState) -> Option<usize> {
    (!state.is_null()).then_some(state as usize)
}

#[inline]
fn given(state: SavedState) -> Result<usize> {
    handle(state).ok_or_else(none_given)
}

#[cold]
fn none_given() -> Error {
    Error::new("FMUstate", "NULL", "a saved state")
}

pub fn fmi2GetFMUstate<M: Model>(all: &Instances<M>, component: Component, state: *mut SavedState) -> c_int {
    all.guarded_as_owner(component, "fmi2GetFMUstate", |instance| save(instance, state))
        .unwrap_or_else(|| all.guarded(component, "fmi2GetFMUstate", |instance| save(instance, state)))
}

#[inline(always)] // on the path of hosts that repeat steps
fn save<M: Model>(instance: &mut Instance<M>, state: *mut SavedState) -> Result<()> {
    let state = Place::new("FMUstate", state)?;
    state.write(instance.save(handle(state.read()))? as SavedState);
    Ok(())
}

pub fn fmi2SetFMUstate<M: Model>(all: &Instances<M>, component: Component, state: SavedState) -> c_int {
    all.guarded_as_owner(component, "fmi2SetFMUstate", |instance| instance.restore(given(state)?))
        .unwrap_or_else(|| all.guarded(component, "fmi2SetFMUstate", |instance| instance.restore(given(state)?)))
}

pub fn fmi2FreeFMUstate<M: Model>(all: &Instances<M>, component: Component, state: *mut SavedState) -> c_int {
    all.guarded(component, "fmi2FreeFMUstate", |instance| {
        // The standard: freeing NULL, or a pointer to NULL, has no effect.
        if state.is_null() {
            return Ok(());
        }
        let state = Place::new("FMUstate", state)?;
        if let Some(handle) = handle(state.read()) {
            instance.free(handle)?;
            state.write(std::ptr::null_mut());
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
        let size = Place::new("size", size)?;
        size.write(instance.serialize(given(state)?)?.len());
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
        Output::new("serializedState", bytes.cast::<u8>(), size)?.write_all(&written);
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
        let state = Place::new("FMUstate", state)?;
        let bytes: Vec<u8> = Input::new("serializedState", bytes.cast::<u8>(), size)?.iter().collect();
        state.write(instance.deserialize(&bytes, handle(state.read()))? as SavedState);
        Ok(())
    })
}
