//! Objects as numbers.

use alloc::vec::Vec;

use crate::Scalar;
use crate::spatial::{Momentum, Pose, Twist, Vector3, Wrench};

/// An object that consists of a number of scalars.
pub(super) trait Components<S>: Sized {
    /// The number of scalars.
    const COUNT: usize;

    /// Returns the object with these scalars.
    fn read(numbers: &[S]) -> Self;

    /// Writes the scalars.
    fn write(&self, numbers: &mut [S]);
}

/// Two vectors of three components.
macro_rules! pairs {
    ($($type:ident $first:ident $second:ident;)*) => {
        $(impl<S: Scalar> Components<S> for $type<S> {
            const COUNT: usize = 6;

            fn read(n: &[S]) -> Self {
                Self { $first: Vector3([n[0], n[1], n[2]]), $second: Vector3([n[3], n[4], n[5]]) }
            }

            fn write(&self, numbers: &mut [S]) {
                numbers.copy_from_slice(&self.components());
            }
        })*
    };
}

pairs! {
    Twist linear angular;
    Momentum linear angular;
    Wrench force moment;
}

impl<S: Scalar> Components<S> for Vector3<S> {
    const COUNT: usize = 3;

    fn read(n: &[S]) -> Self {
        Self([n[0], n[1], n[2]])
    }

    fn write(&self, numbers: &mut [S]) {
        numbers.copy_from_slice(&self.0);
    }
}

impl<S: Scalar> Components<S> for Pose<S> {
    const COUNT: usize = 12;

    fn read(n: &[S]) -> Self {
        let three = |i: usize| [n[i], n[i + 1], n[i + 2]];
        Self { rotation: [three(0), three(3), three(6)], translation: three(9) }
    }

    fn write(&self, numbers: &mut [S]) {
        let (rotation, translation) = numbers.split_at_mut(9);
        rotation.copy_from_slice(self.rotation.as_flattened());
        translation.copy_from_slice(&self.translation);
    }
}

/// Returns the objects with these scalars, one after the other.
pub(super) fn read<S, X: Components<S>>(numbers: &[S]) -> Vec<X> {
    numbers.chunks(X::COUNT).map(X::read).collect()
}

/// Writes the scalars of objects, one after the other.
pub(super) fn write<S, X: Components<S>>(objects: &[X], numbers: &mut [S]) {
    for (object, numbers) in objects.iter().zip(numbers.chunks_mut(X::COUNT)) {
        object.write(numbers);
    }
}
