//! A value for one call at a time; a concurrent one is refused, not blocked.
//!
//! Most instances are used by one thread. That thread, the owner, enters by a plain write: it announces itself and checks that it is still
//! the owner. Another thread revokes the ownership and passes the heavy barrier of [`barrier`], after which the owner either has seen the
//! revocation or has been seen inside. Entering by an atomic exchange instead costs ten times as much as a linear step, thrice in a step. A
//! thread that enters [`ENTRIES_TO_OWN`] times in a row becomes the owner. Without a heavy barrier in the system there is no owner.
#![allow(unsafe_code)]

use std::{
    cell::UnsafeCell,
    mem::ManuallyDrop,
    ops::{Deref, DerefMut},
    sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering},
};

use super::{barrier, thread};

/// Number of calls that amortise the barrier of a change of ownership. Small under Miri, so that it covers many changes.
const ENTRIES_TO_OWN: u32 = if cfg!(miri) { 5 } else { 200 };

/// Maximum number of threads that may have owned a value; further ones enter by exchange. Thread numbers are multiples of it.
const RECORDS: usize = 8;
const _: () = assert!(RECORDS <= thread::ALIGNMENT, "the number of a record must fit below the number of a thread");

/// No thread.
const NONE: usize = 0;

pub(super) struct Exclusive<T> {
    /// Number of the owning thread plus that of its record.
    owner: AtomicUsize,
    /// The thread of each record is inside as owner, or about to see that it no longer is. A thread that owns or has owned the value keeps
    /// its record, so that one stopped between announcing itself and checking does not disturb a later owner.
    is_inside: [AtomicBool; RECORDS],
    /// A thread that entered by exchange is inside.
    other_is_inside: AtomicBool,
    content: UnsafeCell<T>,
    /// Threads of the records.
    threads: [AtomicUsize; RECORDS],
    /// The last thread that entered by exchange, and its number of consecutive entries.
    last: AtomicUsize,
    entries: AtomicU32,
}

// SAFETY: only a thread that is inside accesses the content, and `enter` admits one at a time, each after the previous one has left (a
// release store, seen by an acquiring load or, for the owner, by the same thread). So the content is only sent between threads.
unsafe impl<T: Send> Sync for Exclusive<T> {}

impl<T> Exclusive<T> {
    pub const fn new(content: T) -> Self {
        Self {
            owner: AtomicUsize::new(NONE),
            is_inside: [const { AtomicBool::new(false) }; RECORDS],
            other_is_inside: AtomicBool::new(false),
            content: UnsafeCell::new(content),
            threads: [const { AtomicUsize::new(NONE) }; RECORDS],
            last: AtomicUsize::new(NONE),
            entries: AtomicU32::new(0),
        }
    }

    /// Enters unless a call is active.
    pub fn enter(&self) -> Option<Inside<'_, T>> {
        self.enter_as_owner().map(Into::into).or_else(|| self.enter_by_exchange(thread::number()))
    }

    /// Enters if this thread is the owner and no call is active.
    #[inline(always)] // on the path of every call
    pub fn enter_as_owner(&self) -> Option<OwnerInside<'_, T>> {
        let owner = self.owner.load(Ordering::Acquire);
        // The lower part of a thread number is that of its record.
        let flag = self.is_inside.get(owner ^ thread::number())?;
        if flag.load(Ordering::Relaxed) {
            return None;
        }
        flag.store(true, Ordering::Relaxed);
        barrier::light();
        let inside = OwnerInside { of: self, flag };
        (self.owner.load(Ordering::Acquire) == owner).then_some(inside)
    }

    #[cold]
    fn enter_by_exchange(&self, me: usize) -> Option<Inside<'_, T>> {
        self.other_is_inside.compare_exchange(false, true, Ordering::Acquire, Ordering::Relaxed).ok()?;
        let inside = Inside { of: self, flag: &self.other_is_inside };
        if self.owner.swap(NONE, Ordering::SeqCst) != NONE {
            barrier::heavy();
        }
        if self.is_inside.iter().any(|flag| flag.load(Ordering::Acquire)) {
            return None;
        }
        if self.last.swap(me, Ordering::Relaxed) != me {
            self.entries.store(0, Ordering::Relaxed);
        }
        self.entries.fetch_add(1, Ordering::Relaxed);
        Some(inside)
    }

    /// Makes a thread that entered by exchange and is about to leave the owner.
    fn give_to(&self, thread: usize) {
        let is_its = |record: &AtomicUsize| [NONE, thread].contains(&record.load(Ordering::Relaxed));
        if let Some(index) = self.threads.iter().position(is_its) {
            self.threads[index].store(thread, Ordering::Relaxed);
            self.owner.store(thread + index, Ordering::Release);
        }
    }
}

/// Access by the owner; ends when dropped.
pub(super) struct OwnerInside<'a, T> {
    of: &'a Exclusive<T>,
    flag: &'a AtomicBool,
}

impl<T> OwnerInside<'_, T> {
    #[inline]
    pub fn content(&mut self) -> &mut T {
        // SAFETY: no other thread is inside, and `self` is borrowed exclusively.
        unsafe { &mut *self.of.content.get() }
    }
}

impl<T> Drop for OwnerInside<'_, T> {
    #[inline]
    fn drop(&mut self) {
        self.flag.store(false, Ordering::Release);
    }
}

impl<'a, T> From<OwnerInside<'a, T>> for Inside<'a, T> {
    /// The thread stays inside.
    fn from(owner: OwnerInside<'a, T>) -> Self {
        let OwnerInside { of, flag } = *ManuallyDrop::new(owner);
        Self { of, flag }
    }
}

/// Access by any thread; ends when dropped.
pub(super) struct Inside<'a, T> {
    of: &'a Exclusive<T>,
    /// Marks this thread as inside.
    flag: &'a AtomicBool,
}

impl<T> Deref for Inside<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        // SAFETY: no other thread is inside.
        unsafe { &*self.of.content.get() }
    }
}

impl<T> DerefMut for Inside<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        // SAFETY: no other thread is inside, and `self` is borrowed exclusively.
        unsafe { &mut *self.of.content.get() }
    }
}

impl<T> Drop for Inside<'_, T> {
    fn drop(&mut self) {
        if !self.is_owner() {
            self.before_leaving();
        }
        self.flag.store(false, Ordering::Release);
    }
}

impl<T> Inside<'_, T> {
    /// The thread entered as the owner.
    fn is_owner(&self) -> bool {
        !std::ptr::eq(self.flag, &raw const self.of.other_is_inside)
    }

    /// The next calls are likely to come from this thread.
    pub fn prefer_this_thread(&self) {
        self.of.last.store(thread::number(), Ordering::Relaxed);
        self.of.entries.store(ENTRIES_TO_OWN, Ordering::Relaxed);
    }

    /// A thread that has entered by exchange often enough makes itself the owner.
    #[cold]
    fn before_leaving(&self) {
        let of = self.of;
        if of.entries.load(Ordering::Relaxed) >= ENTRIES_TO_OWN && barrier::is_available() {
            of.entries.store(0, Ordering::Relaxed);
            of.give_to(of.last.load(Ordering::Relaxed));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_entry_is_refused_until_the_first_has_left() {
        let cell = Exclusive::new(1);
        for _ in 0..3 * ENTRIES_TO_OWN {
            let inside = cell.enter().unwrap();
            assert!(cell.enter().is_none());
            std::thread::scope(|scope| assert!(scope.spawn(|| cell.enter().is_none()).join().unwrap()));
            drop(inside);
        }
        // The other threads have revoked the ownership each time; a single thread regains it.
        (0..2 * ENTRIES_TO_OWN).for_each(|_| drop(cell.enter().unwrap()));
        assert_eq!(cell.enter().unwrap().is_owner(), barrier::is_available());
    }

    #[test]
    fn threads_that_hammer_at_one_value_are_never_inside_together() {
        let cell = Exclusive::new((0_u64, 0_u64));
        let entered: u64 = std::thread::scope(|scope| {
            let hammer = || {
                (0..if cfg!(miri) { 300 } else { 200_000 })
                    .filter(|round| {
                        let Some(mut inside) = cell.enter() else { return false };
                        let (one, other) = &mut *inside;
                        assert_eq!(one, other, "{round}");
                        *one += 1;
                        std::hint::black_box(&one);
                        *other += 1;
                        true
                    })
                    .count() as u64
            };
            let threads: Vec<_> = (0..3).map(|_| scope.spawn(hammer)).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).sum()
        });
        assert_eq!(*cell.enter().unwrap(), (entered, entered));
    }
}
