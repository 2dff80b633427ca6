//! A number of the running thread, unique among running threads: the address of a thread-local object.
#![allow(unsafe_code)]

/// Thread numbers are multiples of this.
pub(super) const ALIGNMENT: usize = 8;

/// On Linux the thread pointer, i.e. the address of the thread control block, aligned at least for pointers: one instruction.
#[cfg(all(target_os = "linux", target_arch = "x86_64", not(miri)))]
#[inline(always)]
pub(super) fn number() -> usize {
    let own: usize;
    // SAFETY: the first word of the control block is its own address, in every System V ABI for x86-64; nothing else is read.
    unsafe { std::arch::asm!("mov {}, fs:[0]", out(reg) own, options(nostack, pure, readonly, preserves_flags)) };
    own
}

/// On Linux the thread pointer: one instruction.
#[cfg(all(target_os = "linux", target_arch = "aarch64", not(miri)))]
#[inline(always)]
pub(super) fn number() -> usize {
    let own: usize;
    // SAFETY: reads a register of the thread.
    unsafe { std::arch::asm!("mrs {}, tpidr_el0", out(reg) own, options(nostack, nomem, pure, preserves_flags)) };
    own
}

/// The address of a thread-local variable that is neither initialised at run time nor dropped, so that no destructor outlives the library.
#[cfg(any(miri, not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))))]
#[inline]
pub(super) fn number() -> usize {
    #[repr(align(8))]
    struct Place {
        _byte: u8,
    }
    const _: () = assert!(align_of::<Place>() == ALIGNMENT);
    thread_local!(static PLACE: Place = const { Place { _byte: 0 } });
    PLACE.with(|place| std::ptr::from_ref(place) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_has_its_number_and_no_other_running_thread_has_it() {
        let mine = number();
        assert!(mine != 0 && mine == number() && mine.is_multiple_of(ALIGNMENT));
        std::thread::scope(|scope| assert_ne!(scope.spawn(number).join().unwrap(), mine));
    }
}
