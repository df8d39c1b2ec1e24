//! The calling conventions of C, the registers that belong to the caller by them, and the places in
//! the frame of an entry.

use crate::call::MAX_GIVEN;

/// A calling convention of C.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Convention {
    /// System V's, on Linux, macOS and the BSDs.
    SystemV,
    /// Microsoft's.
    Windows,
}

/// The registers that Windows gives back to the caller: rdi, rsi, then xmm6 to xmm15, below rbp.
pub(super) const KEPT_GENERAL: i32 = 16;
pub(super) const KEPT_VECTORS: std::ops::Range<u8> = 6..16;
pub(super) const KEPT: i32 = KEPT_GENERAL + 16 * 10;

/// The place of the pointer to the results in the frame of an entry, after the table of pointers.
pub(super) const RESULTS: i32 = 8 * MAX_GIVEN as i32;
/// The place of the poses of bodies, or of the numbers of a program with loops.
pub(super) const BODIES: i32 = (RESULTS + 8 + 15) / 16 * 16;
