//! Arrays whose length belongs to a robot.

/// A fixed number of scalars: `[T; N]`, where N cannot be named.
pub trait Array<T>: Copy + AsRef<[T]> + AsMut<[T]> {
    /// How many.
    const LEN: usize;

    /// Entry i is `f(i)`.
    fn from_fn(f: impl FnMut(usize) -> T) -> Self;
}

impl<T: Copy, const N: usize> Array<T> for [T; N] {
    const LEN: usize = N;

    fn from_fn(f: impl FnMut(usize) -> T) -> Self {
        core::array::from_fn(f)
    }
}
