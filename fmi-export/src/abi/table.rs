//! Instances by handle: a handle is looked up and never dereferenced, so that a freed or invalid one is refused, and the look-up takes no
//! lock. A handle is the slot of an instance combined with the number of instances that the slot has had.

use std::sync::{
    Arc, Mutex, OnceLock, PoisonError,
    atomic::{AtomicUsize, Ordering},
};

use super::exclusive::{Exclusive, Inside, OwnerInside};

/// Bits of a handle for the slot in its block; the bits above are those of the block and the count of instances.
const PLACE_BITS: u32 = if usize::BITS == 64 { 27 } else { 16 };
const BLOCK_BITS: u32 = PLACE_BITS.ilog2() + 1;
const HANDLE_BITS: u32 = PLACE_BITS + BLOCK_BITS;

/// Slots come in blocks that are never moved or freed, each twice as large as the previous one.
const FIRST_BLOCK: usize = 16;
const BLOCKS: usize = PLACE_BITS as usize - FIRST_BLOCK.ilog2() as usize;

/// Location of a slot.
#[derive(Clone, Copy)]
struct Address {
    block: usize,
    place: usize,
}

impl Address {
    fn of_index(index: usize) -> Self {
        let block = (index / FIRST_BLOCK + 1).ilog2() as usize;
        Self { block, place: index - FIRST_BLOCK * ((1 << block) - 1) }
    }

    fn index(self) -> usize {
        FIRST_BLOCK * ((1 << self.block) - 1) + self.place
    }

    fn of_handle(handle: usize) -> Self {
        Self { block: (handle >> PLACE_BITS) & ((1 << BLOCK_BITS) - 1), place: handle & ((1 << PLACE_BITS) - 1) }
    }

    /// The handle after this many instances in the slot. The count starts at 1, since handle 0 would be NULL.
    fn handle(self, departed: usize) -> usize {
        (departed.wrapping_add(1) << HANDLE_BITS) | (self.block << PLACE_BITS) | self.place
    }
}

/// One slot, on separate cache lines: threads with different instances write to different lines.
#[repr(align(128))]
struct Place<T, S> {
    /// The handle of its instance, 0 if there is none; any other handle is freed or invalid.
    handle: AtomicUsize,
    /// Number of former instances.
    departed: AtomicUsize,
    instance: Exclusive<Option<Box<T>>>,
    /// Accessed only by the active call.
    shared: Mutex<Option<Arc<S>>>,
}

impl<T, S> Place<T, S> {
    const fn new() -> Self {
        Self {
            handle: AtomicUsize::new(0),
            departed: AtomicUsize::new(0),
            instance: Exclusive::new(None),
            shared: Mutex::new(None),
        }
    }

    /// True if the handle is that of the present instance.
    #[inline]
    fn has(&self, handle: usize) -> bool {
        self.handle.load(Ordering::Relaxed) == handle
    }

    /// Shared data, unless the instance of this handle has been freed.
    #[cold]
    fn shared(&self, handle: usize) -> Option<Arc<S>> {
        let shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        shared.as_ref().filter(|_| self.has(handle)).map(Arc::clone)
    }
}

type Block<T, S> = Box<[Place<T, S>]>;

/// All instances of a model: `T` is used by one call at a time, `S` by any number.
pub(super) struct Table<T, S> {
    /// Block 0: its slots are inside the table, without a further look-up.
    first: [Place<T, S>; FIRST_BLOCK],
    /// The other blocks, from 1 on.
    blocks: [OnceLock<Block<T, S>>; BLOCKS],
    free: Mutex<Free>,
}

/// Free slots.
struct Free {
    /// Slots of freed instances.
    places: Vec<usize>,
    /// Slots from here on have never been used.
    untouched: usize,
}

/// Why there is no instance.
pub(super) enum Absent<S> {
    /// The handle is invalid.
    Unknown,
    /// Another call is active.
    Busy(Arc<S>),
    /// It was lost in an earlier call and has not been freed yet.
    Lost(Arc<S>),
}

impl<T, S> Table<T, S> {
    pub const fn new() -> Self {
        Self {
            first: [const { Place::new() }; FIRST_BLOCK],
            blocks: [const { OnceLock::new() }; BLOCKS],
            free: Mutex::new(Free { places: Vec::new(), untouched: 0 }),
        }
    }

    /// The slot of a handle; `None` if the block has not been allocated.
    fn place(&self, at: Address) -> Option<&Place<T, S>> {
        if at.block == 0 {
            return self.first.get(at.place);
        }
        self.blocks.get(at.block - 1)?.get()?.get(at.place)
    }

    /// Puts an instance into a free slot; `None` if all are taken.
    pub fn insert(&self, instance: Box<T>, shared: Arc<S>) -> Option<usize> {
        let index = {
            let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
            free.places.pop().or_else(|| {
                let index = free.untouched;
                (index < 1 << PLACE_BITS).then(|| free.untouched += 1).map(|()| index)
            })?
        };
        let at = Address::of_index(index);
        if at.block > 0 {
            let block = self.blocks.get(at.block - 1)?;
            block.get_or_init(|| (0..FIRST_BLOCK << at.block).map(|_| Place::new()).collect());
        }
        let place = self.place(at)?;
        // A call with a stale handle may be inside briefly, until it detects that it is stale.
        let mut inside = entered_when_left(place);
        *place.shared.lock().unwrap_or_else(PoisonError::into_inner) = Some(shared);
        *inside = Some(instance);
        inside.prefer_this_thread();
        let handle = at.handle(place.departed.load(Ordering::Relaxed));
        place.handle.store(handle, Ordering::Relaxed);
        Some(handle)
    }

    /// Fast path, nearly always taken: the instance of a handle, for one call, if this thread owns its slot and that is in the first block.
    #[inline(always)] // on the path of every call
    pub fn enter_as_owner(&self, handle: usize) -> Option<OwnerEntered<'_, T>> {
        // A slot of block 0 has its own number below the count of its instances.
        let place = self.first.get(handle & ((1 << HANDLE_BITS) - 1))?;
        let mut inside = place.instance.enter_as_owner()?;
        (place.has(handle) && inside.content().is_some()).then_some(OwnerEntered(inside))
    }

    /// The instance of a handle, for one call.
    pub fn enter(&self, handle: usize) -> Result<Entered<'_, T>, Absent<S>> {
        let at = Address::of_handle(handle);
        let place = self.place(at).filter(|place| place.has(handle) && handle != 0).ok_or(Absent::Unknown)?;
        match place.instance.enter() {
            Some(inside) if place.has(handle) && inside.is_some() => Ok(Entered(inside)),
            Some(inside) => {
                drop(inside);
                // It may have been freed, and its slot reused, since the look-up.
                Err(place.shared(handle).map_or(Absent::Unknown, Absent::Lost))
            }
            None => Err(place.shared(handle).map_or(Absent::Unknown, Absent::Busy)),
        }
    }

    /// Removes an instance after the active call, if there is one; its handle is never valid again. `None` if it has been lost.
    pub fn remove(&self, handle: usize) -> Option<Box<T>> {
        let at = Address::of_handle(handle);
        let place = self.place(at).filter(|place| place.has(handle) && handle != 0)?;
        let mut inside = entered_when_left(place);
        if !place.has(handle) {
            return None;
        }
        *place.shared.lock().unwrap_or_else(PoisonError::into_inner) = None;
        let instance = inside.take();
        place.handle.store(0, Ordering::Relaxed);
        place.departed.fetch_add(1, Ordering::Relaxed);
        drop(inside);
        self.free.lock().unwrap_or_else(PoisonError::into_inner).places.push(at.index());
        instance
    }
}

fn entered_when_left<T, S>(place: &Place<T, S>) -> Inside<'_, Option<Box<T>>> {
    loop {
        match place.instance.enter() {
            Some(inside) => return inside,
            None => std::thread::yield_now(),
        }
    }
}

/// An instance during one call of the owner of its slot.
pub(super) struct OwnerEntered<'a, T>(OwnerInside<'a, Option<Box<T>>>);

impl<'a, T> OwnerEntered<'a, T> {
    /// The instance found by `Table::enter_as_owner`.
    #[inline]
    pub fn get(&mut self) -> Option<&mut T> {
        self.0.content().as_deref_mut()
    }
}

impl<'a, T> From<OwnerEntered<'a, T>> for Entered<'a, T> {
    fn from(owner: OwnerEntered<'a, T>) -> Self {
        Self(owner.0.into())
    }
}

/// An instance during one call.
pub(super) struct Entered<'a, T>(Inside<'a, Option<Box<T>>>);

impl<T> Entered<'_, T> {
    /// The instance found by `Table::enter`.
    pub fn get(&mut self) -> Option<&mut T> {
        self.0.as_deref_mut()
    }

    /// Removes the instance for good; its handle remains known as that of a lost instance.
    pub fn lose(&mut self) -> Option<Box<T>> {
        self.0.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_handle_ends_with_its_instance_and_its_place_goes_to_the_next() {
        let table: Table<u32, ()> = Table::new();
        let handles: Vec<usize> = (0..100).map(|value| table.insert(Box::new(value), Arc::new(())).unwrap()).collect();
        for (handle, value) in handles.iter().zip(0..) {
            assert!(*handle != 0 && *table.enter(*handle).ok().unwrap().get().unwrap() == value);
        }
        assert_eq!(*table.remove(handles[17]).unwrap(), 17);
        assert!(table.remove(handles[17]).is_none());
        let next = table.insert(Box::new(1000), Arc::new(())).unwrap();
        assert!(next != handles[17] && matches!(table.enter(handles[17]), Err(Absent::Unknown)));
        assert_eq!(*table.enter(next).ok().unwrap().get().unwrap(), 1000);
        for invented in [0, 1, 12345, usize::MAX, next ^ (1 << (HANDLE_BITS + 1))] {
            assert!(matches!(table.enter(invented), Err(Absent::Unknown)), "{invented:#x}");
        }
    }

    #[test]
    fn a_lost_instance_is_known_until_it_is_freed() {
        let table: Table<u32, u32> = Table::new();
        let handle = table.insert(Box::new(1), Arc::new(2)).unwrap();
        assert_eq!(*table.enter(handle).ok().unwrap().lose().unwrap(), 1);
        for _ in 0..2 {
            assert!(matches!(table.enter(handle), Err(Absent::Lost(shared)) if *shared == 2));
        }
        assert!(table.remove(handle).is_none());
        assert!(matches!(table.enter(handle), Err(Absent::Unknown)));
        assert_ne!(table.insert(Box::new(3), Arc::new(4)).unwrap(), handle);
    }

    #[test]
    fn an_instance_in_use_is_busy_and_is_freed_after_that() {
        let table: Table<u32, u32> = Table::new();
        let handle = table.insert(Box::new(1), Arc::new(2)).unwrap();
        let inside = table.enter(handle).ok().unwrap();
        assert!(matches!(table.enter(handle), Err(Absent::Busy(shared)) if *shared == 2));
        std::thread::scope(|scope| {
            let removed = scope.spawn(|| table.remove(handle).is_some());
            std::thread::sleep(std::time::Duration::from_millis(20));
            assert!(!removed.is_finished());
            drop(inside);
            assert!(removed.join().unwrap());
        });
    }
}
