//! Memory that holds machine code, and the calls of it.
//!
//! Pages are written first and made executable then; they are never writable and executable at the
//! same time. Memory comes from `memmap2`.
//!
//! Unsafe code: instructions that bring new code to the caches of aarch64, which change no memory;
//! and a call of a function that `generate` has made. The call is sound because
//! - the bytes at the entry are a complete function for System V's calling convention on x86-64,
//!   and for C's on aarch64: it restores the registers that belong to its caller (rbx, rbp, rsp,
//!   r14, r15; x29, x30, sp and the lower halves of v8 to v15) and returns; the pages live as long
//!   as the value that calls;
//! - the processor has the instructions: the instruction set that the code is made for is one that
//!   `InstructionSet::detect` has found;
//! - it reads numbers `0..length` of each array of arguments and writes numbers `0..length` of the
//!   results, which [`Code::call`] has checked: the slices are as long, or longer. Further it
//!   touches its own stack frame alone, whose pages it touches one after the other, so that a stack
//!   that is too short ends at its guard page. The function that its guards call is in the same
//!   pages, is made from the same program, and gets the same pointers;
//! - arguments are shared slices and the results are an exclusive one, so it writes no number that
//!   it reads.
#![allow(unsafe_code)]

use std::io;

use memmap2::{Mmap, MmapMut};

use crate::generate::MAX_ARRAYS;
use crate::real::Real;

#[cfg(target_arch = "x86_64")]
type Function<S> = extern "sysv64" fn(*const *const S, *mut S);
#[cfg(not(target_arch = "x86_64"))]
type Function<S> = extern "C" fn(*const *const S, *mut S);

/// Pages of machine code.
pub(crate) struct Pages(Mmap);

impl Pages {
    /// Copies code into its own pages, and makes these executable.
    ///
    /// # Errors
    ///
    /// If the system forbids executable memory, or has no memory left.
    pub fn new(code: &[u8]) -> io::Result<Self> {
        let mut pages = MmapMut::map_anon(code.len().max(1))?;
        pages[..code.len()].copy_from_slice(code);
        let pages = pages.make_exec()?;
        #[cfg(target_arch = "aarch64")]
        synchronize(&pages);
        Ok(Self(pages))
    }

    /// Returns the address of the code at this offset.
    #[cfg(all(test, any(feature = "object", target_arch = "aarch64")))]
    pub fn address(&self, offset: usize) -> *const u8 {
        &raw const self.0[offset]
    }
}

/// Makes the processor fetch the instructions that were written: they leave the data cache as far
/// as the point from which instructions are fetched, and older ones leave the instruction cache
/// (Arm Architecture Reference Manual, B2.4.4).
#[cfg(target_arch = "aarch64")]
fn synchronize(code: &[u8]) {
    use std::arch::asm;
    let types: u64;
    // SAFETY: it reads a register that user programs can read.
    unsafe { asm!("mrs {}, ctr_el0", out(reg) types, options(nomem, nostack, preserves_flags)) };
    // The logarithms of the lines' lengths in words of four bytes.
    let [data, instructions] = [types >> 16 & 15, types & 15].map(|length| 4_usize << length);
    let range = code.as_ptr_range();
    let lines = |length: usize| {
        let first = range.start as usize & !(length - 1);
        (first..range.end as usize).step_by(length)
    };
    for line in lines(data) {
        // SAFETY: the line has readable memory, and its contents do not change.
        unsafe { asm!("dc cvau, {}", in(reg) line, options(nostack, preserves_flags)) };
    }
    // SAFETY: barriers and caches change no contents.
    unsafe { asm!("dsb ish", options(nostack, preserves_flags)) };
    for line in lines(instructions) {
        // SAFETY: as above.
        unsafe { asm!("ic ivau, {}", in(reg) line, options(nostack, preserves_flags)) };
    }
    // SAFETY: as above.
    unsafe { asm!("dsb ish", "isb", options(nostack, preserves_flags)) };
}

/// A function in pages of machine code.
#[derive(Clone, Debug)]
pub(crate) struct Code {
    /// The entry point.
    pub entry: usize,
    /// The smallest length of each array of arguments.
    pub arguments: Vec<usize>,
    /// The number of results.
    pub results: usize,
}

impl Code {
    /// Calls the function, which was generated for numbers of this type at `entry` of these pages.
    ///
    /// # Panics
    ///
    /// If arrays are missing or too short.
    pub fn call<S: Real>(&self, pages: &Pages, arguments: &[&[S]], results: &mut [S]) {
        assert!(self.entry < pages.0.len() && arguments.len() == self.arguments.len());
        assert!(results.len() >= self.results);
        let mut pointers = [std::ptr::null(); MAX_ARRAYS];
        for ((pointer, argument), &length) in
            pointers.iter_mut().zip(arguments).zip(&self.arguments)
        {
            assert!(argument.len() >= length);
            *pointer = argument.as_ptr();
        }
        // SAFETY: see the header.
        let function = unsafe {
            std::mem::transmute::<*const u8, Function<S>>(pages.0.as_ptr().add(self.entry))
        };
        function(pointers.as_ptr(), results.as_mut_ptr());
    }
}
