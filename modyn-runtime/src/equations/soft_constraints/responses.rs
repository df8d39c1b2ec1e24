//! The responses of all rows to accelerations.

use alloc::vec::Vec;

use super::damping::DampingMatrix;
use super::law::Response;
use crate::Scalar;

/// The forces of the laws at accelerations, and minus their derivatives.
pub(super) struct Laws<S> {
    /// The response of each contact.
    pub contacts: Vec<Response<S>>,
    /// The force and the stiffness of each row of a joint, a tendon or a coupling, then of a loop.
    pub single_rows: Vec<[S; 2]>,
}

impl<S: Scalar> Laws<S> {
    /// Returns the forces of all rows.
    pub fn forces(&self) -> impl Iterator<Item = S> + '_ {
        let contacts = self.contacts.iter().flat_map(|response| response.force.iter().copied());
        contacts.chain(self.single_rows.iter().map(|response| response[0]))
    }

    /// Returns the products of the stiffness with the accelerations of the rows.
    pub fn stiffness_times(&self, accelerations: &[S]) -> Vec<S> {
        let mut shares = Vec::with_capacity(accelerations.len());
        let mut rest = accelerations;
        for response in &self.contacts {
            let (point, others) = rest.split_at(response.force.len());
            rest = others;
            shares.extend(response.stiffness.iter().map(|row| {
                let products = row.iter().zip(point).map(|(&entry, &a)| entry * a);
                products.reduce(|a, b| a + b).unwrap_or_else(S::zero)
            }));
        }
        shares.extend(self.single_rows.iter().zip(rest).map(|(response, &a)| response[1] * a));
        shares
    }
}

/// The effect of the rows on the accelerations.
#[derive(Clone, Copy)]
pub(super) enum Effect<'a, S> {
    /// Forces, and the stiffness of these laws as added inertia.
    Stiff(&'a Laws<S>),
    /// Forces, and dampers that act with the velocities after the step.
    Forces(&'a ImplicitDampers<S>),
}

/// Dampers that act with the velocities after a step.
pub(super) struct ImplicitDampers<S> {
    /// The damping times the time of the step, which adds to the mass matrix.
    pub armature: DampingMatrix<S>,
    /// The joint forces by free fall and by the rotation of the axes of the velocities, each with its
    /// entry of qd.
    pub forces: Vec<(usize, S)>,
}
