//! An allocator that counts the allocations of each thread.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static CALLS: Cell<usize> = const { Cell::new(0) };
    static LIVE: Cell<isize> = const { Cell::new(0) };
    static PEAK: Cell<isize> = const { Cell::new(0) };
}

/// The system's allocator, with a count of each thread's allocations.
pub struct Counting;

/// The allocations of this thread since the start of [`measure`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Allocated {
    /// The number of allocations and reallocations.
    pub calls: usize,
    /// The bytes allocated at the end, minus those at the start.
    pub kept: isize,
    /// The largest number of bytes allocated, minus those at the start.
    pub peak: isize,
}

/// Runs `action` and counts its allocations; [`Counting`] must be the global allocator.
pub fn measure<T>(action: impl FnOnce() -> T) -> (T, Allocated) {
    let (calls, live) = (CALLS.get(), LIVE.get());
    PEAK.set(live);
    let result = action();
    let allocated =
        Allocated { calls: CALLS.get() - calls, kept: LIVE.get() - live, peak: PEAK.get() - live };
    (result, allocated)
}

fn took(bytes: usize) {
    // A thread that is ending no longer counts.
    let _ = CALLS.try_with(|calls| calls.set(calls.get() + 1));
    held(bytes.cast_signed());
}

fn held(bytes: isize) {
    let _ = LIVE.try_with(|live| {
        live.set(live.get() + bytes);
        let _ = PEAK.try_with(|peak| peak.set(peak.get().max(live.get())));
    });
}

// SAFETY: every call is passed on to the system's allocator unchanged; counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        took(layout.size());
        // SAFETY: the caller keeps `alloc`'s contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        took(layout.size());
        // SAFETY: the caller keeps `alloc_zeroed`'s contract.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        held(-layout.size().cast_signed());
        // SAFETY: the caller keeps `dealloc`'s contract.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        held(-layout.size().cast_signed());
        took(size);
        // SAFETY: the caller keeps `realloc`'s contract.
        unsafe { System.realloc(pointer, layout, size) }
    }
}
