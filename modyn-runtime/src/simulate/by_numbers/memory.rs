//! The memory of a step: arrays for small robots, vectors for others.

use alloc::{vec, vec::Vec};

use crate::simulate::impulses::StepMemory;
use crate::solve::Decide;

/// The memory of a step on plain numbers.
pub(super) trait NumbersMemory<T>: StepMemory<T> {
    /// Numbers for each velocity, for each row of the contacts.
    type Responses: AsMut<[Self::Velocities]> + AsRef<[Self::Velocities]>;

    /// Returns zeros.
    fn velocities(&self) -> Self::Velocities;
    /// Returns zeros.
    fn responses(&self) -> Self::Responses;
}

/// The memory of a robot with at most as many rows of contacts, velocities, and both together.
pub(super) struct Arrays<F, const ROWS: usize, const VELOCITIES: usize, const BOTH: usize> {
    pub inverse: F,
    pub velocities: usize,
}

impl<T: Decide, F: Fn(&mut [T]), const ROWS: usize, const VELOCITIES: usize, const BOTH: usize>
    StepMemory<T> for Arrays<F, ROWS, VELOCITIES, BOTH>
{
    type ContactRow = [T; ROWS];
    type ContactMatrix = [[T; ROWS]; ROWS];
    type GroundRow = [T; BOTH];
    type GroundMatrix = [[T; BOTH]; BOTH];
    type Velocities = [T; VELOCITIES];
    type Inverse = [[T; VELOCITIES]; VELOCITIES];

    fn contact_row(&self) -> [T; ROWS] {
        [T::zero(); ROWS]
    }

    fn contact_matrix(&self) -> [[T; ROWS]; ROWS] {
        [[T::zero(); ROWS]; ROWS]
    }

    fn ground_row(&self) -> [T; BOTH] {
        [T::zero(); BOTH]
    }

    fn ground_matrix(&self) -> [[T; BOTH]; BOTH] {
        [[T::zero(); BOTH]; BOTH]
    }

    fn inverse(&self) -> [[T; VELOCITIES]; VELOCITIES] {
        let n = self.velocities;
        let mut numbers = vec![T::zero(); n * n];
        (self.inverse)(&mut numbers);
        let mut columns = [[T::zero(); VELOCITIES]; VELOCITIES];
        for (column, own) in columns.iter_mut().zip(numbers.chunks_exact(n.max(1))) {
            column[..n].copy_from_slice(own);
        }
        columns
    }
}

impl<T: Decide, F: Fn(&mut [T]), const ROWS: usize, const VELOCITIES: usize, const BOTH: usize>
    NumbersMemory<T> for Arrays<F, ROWS, VELOCITIES, BOTH>
{
    type Responses = [[T; VELOCITIES]; ROWS];

    fn velocities(&self) -> [T; VELOCITIES] {
        [T::zero(); VELOCITIES]
    }

    fn responses(&self) -> [[T; VELOCITIES]; ROWS] {
        [[T::zero(); VELOCITIES]; ROWS]
    }
}

/// The memory of a robot of any size.
pub(super) struct Vectors<F> {
    pub inverse: F,
    pub contacts: usize,
    pub velocities: usize,
}

impl<T: Decide, F: Fn(&mut [T])> StepMemory<T> for Vectors<F> {
    type ContactRow = Vec<T>;
    type ContactMatrix = Vec<Vec<T>>;
    type GroundRow = Vec<T>;
    type GroundMatrix = Vec<Vec<T>>;
    type Velocities = Vec<T>;
    type Inverse = Vec<Vec<T>>;

    fn contact_row(&self) -> Vec<T> {
        vec![T::zero(); 3 * self.contacts]
    }

    fn contact_matrix(&self) -> Vec<Vec<T>> {
        vec![self.contact_row(); 3 * self.contacts]
    }

    fn ground_row(&self) -> Vec<T> {
        vec![T::zero(); 3 * self.contacts + self.velocities]
    }

    fn ground_matrix(&self) -> Vec<Vec<T>> {
        let row = self.ground_row();
        vec![row.clone(); row.len()]
    }

    fn inverse(&self) -> Vec<Vec<T>> {
        let n = self.velocities;
        let mut numbers = vec![T::zero(); n * n];
        (self.inverse)(&mut numbers);
        numbers.chunks(n.max(1)).map(<[T]>::to_vec).collect()
    }
}

impl<T: Decide, F: Fn(&mut [T])> NumbersMemory<T> for Vectors<F> {
    type Responses = Vec<Vec<T>>;

    fn velocities(&self) -> Vec<T> {
        vec![T::zero(); self.velocities]
    }

    fn responses(&self) -> Vec<Vec<T>> {
        vec![self.velocities(); 3 * self.contacts]
    }
}
