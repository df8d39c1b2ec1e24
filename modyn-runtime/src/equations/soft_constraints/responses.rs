//! The responses of all rows to accelerations.

use alloc::vec::Vec;

use super::law::Response;
use crate::Scalar;

/// The forces of the laws at accelerations, and minus their derivatives.
pub(super) struct Laws<S> {
    /// The response of each contact.
    pub contacts: Vec<Response<S>>,
    /// The force and the stiffness of each row of a joint.
    pub joints: Vec<[S; 2]>,
}

impl<S: Scalar> Laws<S> {
    /// Returns the forces of all rows.
    pub fn forces(&self) -> impl Iterator<Item = S> + '_ {
        let contacts = self.contacts.iter().flat_map(|response| response.force);
        contacts.chain(self.joints.iter().map(|response| response[0]))
    }

    /// Returns the products of the stiffness with the accelerations of the rows.
    pub fn stiffness_times(&self, accelerations: &[S]) -> Vec<S> {
        let (points, of_joints) = accelerations.split_at(3 * self.contacts.len());
        let contacts = self.contacts.iter().zip(points.chunks(3)).flat_map(|(response, point)| {
            response.stiffness.map(|row| row[0] * point[0] + row[1] * point[1] + row[2] * point[2])
        });
        let joints = self.joints.iter().zip(of_joints).map(|(response, &a)| response[1] * a);
        contacts.chain(joints).collect()
    }
}

/// The effect of the rows on the accelerations.
#[derive(Clone, Copy)]
pub(super) enum Effect<'a, S> {
    /// Forces, and the stiffness of these laws as added inertia.
    Stiff(&'a Laws<S>),
    /// Forces. The damping of joints acts with the velocities after the step.
    Forces,
}
