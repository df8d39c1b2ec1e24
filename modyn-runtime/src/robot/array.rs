//! Arrays whose length depends on the robot.

/// A fixed number of entries: `[T; N]`, where N cannot be named in generic code.
pub trait Array<T>: Copy + AsRef<[T]> + AsMut<[T]> {
    /// The number of entries.
    const LEN: usize;

    /// Returns the array whose entry i is `f(i)`.
    fn from_fn(f: impl FnMut(usize) -> T) -> Self;
}

impl<T: Copy, const N: usize> Array<T> for [T; N] {
    const LEN: usize = N;

    fn from_fn(f: impl FnMut(usize) -> T) -> Self {
        core::array::from_fn(f)
    }
}
