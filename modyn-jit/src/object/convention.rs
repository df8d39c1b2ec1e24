//! The calling conventions of C, and the registers that belong to the caller by them.

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
