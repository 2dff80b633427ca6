//! The saved states of an instance, by handle.

use std::sync::atomic::{AtomicUsize, Ordering};

use serde::{Deserialize, Serialize};

use crate::{
    error::{Error, Result},
    lifecycle::Lifecycle,
};

/// A saved state.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Saved<Memory> {
    pub lifecycle: Lifecycle,
    pub memory: Memory,
}

/// By handle, in ascending order; there are few.
pub(crate) struct SavedStates<Memory>(Vec<(usize, Box<Saved<Memory>>)>);

/// Handles of saved states are unique in a process, so that an instance never accepts a handle of another one.
static NEXT: AtomicUsize = AtomicUsize::new(1);

impl<Memory> SavedStates<Memory> {
    pub fn new() -> Self {
        Self(Vec::new())
    }

    /// Handles increase, so that the new state comes last.
    pub fn insert(&mut self, state: Saved<Memory>) -> usize {
        let handle = NEXT.fetch_add(1, Ordering::Relaxed);
        self.0.push((handle, Box::new(state)));
        handle
    }

    /// The state with a handle.
    ///
    /// # Errors
    /// A handle that does not belong to this instance.
    #[inline]
    pub fn get(&self, handle: usize) -> Result<&Saved<Memory>> {
        // The most recent one is requested most often.
        match self.0.last() {
            Some((last, state)) if *last == handle => Ok(state),
            _ => self.place(handle).map(|place| &*self.0[place].1),
        }
    }

    /// As [`SavedStates::get`].
    ///
    /// # Errors
    /// Those of [`SavedStates::get`].
    #[inline]
    pub fn get_mut(&mut self, handle: usize) -> Result<&mut Saved<Memory>> {
        if self.0.last().is_none_or(|(last, _)| *last != handle) {
            let place = self.place(handle)?;
            return Ok(&mut self.0[place].1);
        }
        self.0.last_mut().map(|(_, state)| &mut **state).ok_or_else(|| unknown(handle))
    }

    /// Frees a state.
    ///
    /// # Errors
    /// Those of [`SavedStates::get`].
    pub fn remove(&mut self, handle: usize) -> Result<()> {
        let place = self.place(handle)?;
        self.0.remove(place);
        Ok(())
    }

    #[inline(never)]
    fn place(&self, handle: usize) -> Result<usize> {
        self.0.binary_search_by_key(&handle, |(handle, _)| *handle).map_err(|_| unknown(handle))
    }
}

#[cold]
fn unknown(handle: usize) -> Error {
    Error::new("FMU state", format!("handle {handle:#x}"), "states got from this instance and not yet freed")
}
