//! Saving, restoring and serializing the state.

use crate::{calls::Call, error::Result, instance::Instance, model::Model, saved_states::Saved, serialization};

impl<M: Model> Instance<M> {
    /// `fmi2GetFMUstate`: saves the state, into `existing` if that is a saved state, and returns its handle.
    ///
    /// # Errors
    /// A handle that does not belong to this instance.
    #[inline(always)] // on the path of every call
    pub fn save(&mut self, existing: Option<usize>) -> Result<usize> {
        self.check(Call::State)?;
        let Some(handle) = existing else { return Ok(self.save_anew()) };
        let saved = self.saved.get_mut(handle)?;
        saved.lifecycle = self.lifecycle;
        saved.memory.clone_from(self.model.memory());
        Ok(handle)
    }

    #[inline(never)]
    fn save_anew(&mut self) -> usize {
        self.saved.insert(Saved { lifecycle: self.lifecycle, memory: self.model.memory().clone() })
    }

    /// `fmi2SetFMUstate`
    ///
    /// # Errors
    /// A handle that does not belong to this instance.
    #[inline(always)] // on the path of every call
    pub fn restore(&mut self, handle: usize) -> Result<()> {
        self.check(Call::State)?;
        let Saved { lifecycle, memory } = self.saved.get(handle)?;
        self.model.restore_from(memory, lifecycle.phase)?;
        self.lifecycle = *lifecycle;
        Ok(())
    }

    /// `fmi2FreeFMUstate`
    ///
    /// # Errors
    /// A handle that does not belong to this instance.
    pub fn free(&mut self, handle: usize) -> Result<()> {
        self.saved.remove(handle)
    }

    fn guid(&self) -> &str {
        self.guid.get_or_init(|| M::guid(&self.start))
    }

    /// `fmi2SerializeFMUstate`
    ///
    /// # Errors
    /// A handle that does not belong to this instance.
    pub fn serialize(&self, handle: usize) -> Result<Vec<u8>> {
        serialization::to_bytes(self.saved.get(handle)?, M::IDENTIFIER, self.guid())
    }

    /// `fmi2DeSerializeFMUstate`: returns the handle of a new saved state, or of `existing` overwritten.
    ///
    /// # Errors
    /// Bytes that are corrupt or belong to another model.
    pub fn deserialize(&mut self, bytes: &[u8], existing: Option<usize>) -> Result<usize> {
        self.check(Call::State)?;
        let state: Saved<M::Memory> = serialization::from_bytes(bytes, M::IDENTIFIER, self.guid())?;
        state.lifecycle.check(self.lifecycle.kind)?;
        M::check(&state.memory, state.lifecycle.kind, state.lifecycle.phase)?;
        match existing {
            None => Ok(self.saved.insert(state)),
            Some(handle) => {
                *self.saved.get_mut(handle)? = state;
                Ok(handle)
            }
        }
    }
}
