//! Addresses modulo 4,096 of a stack frame and of memory.

use std::hint::black_box;

const PAGE: usize = 4096;

/// The number of placements.
pub const PLACEMENTS: usize = 20;

/// The step between places in bytes; the places of all placements cover a page.
const STEP: usize = 192;

/// Where a call has its frame, its results and its arguments.
#[derive(Clone, Copy)]
pub struct Placement {
    /// The stack pointer is lower by this number of padding frames.
    pub depth: usize,
    /// The address of the results modulo 4,096.
    pub results: usize,
    /// The address of the arguments modulo 4,096.
    pub arguments: usize,
}

impl Placement {
    /// Returns a placement by its number. The frame moves down by `k` steps, results and arguments move up by 6 and 8 times
    /// as many: the distances from the frame, 7 and 9 steps times `k` modulo 20, are different for all placements.
    pub fn new(k: usize) -> Self {
        let place = |steps: usize| steps * k % PLACEMENTS * STEP;
        Self { depth: k, results: place(6), arguments: place(8) }
    }
}

/// Runs `f` below this number of frames of about [`STEP`] bytes.
#[inline(never)]
pub fn deeper(frames: usize, f: &mut dyn FnMut()) {
    let padding = black_box([0_u8; STEP - 48]);
    if frames == 0 {
        f();
    } else {
        deeper(frames - 1, f);
    }
    black_box(&padding);
}

/// Returns a number of elements among whose addresses modulo 4,096 there is one near to any wanted one, in little memory.
pub const fn candidates<T>() -> usize {
    // A page of numbers has an address at each multiple of 8; of long elements, 64 do if their length is no large power of 2.
    if size_of::<T>() < PAGE { PAGE / 8 } else { PAGE / 64 }
}

/// Returns the index of the element whose address modulo 4,096 is nearest to the wanted one, among the first
/// [`candidates`].
pub fn at<T>(memory: &[T], wanted: usize) -> usize {
    let distance = |element: &T| {
        let off = (std::ptr::from_ref(element).addr() % PAGE).abs_diff(wanted);
        off.min(PAGE - off)
    };
    let elements = memory.iter().take(candidates::<T>()).enumerate();
    elements.min_by_key(|(_, element)| distance(element)).map_or(0, |(index, _)| index)
}
