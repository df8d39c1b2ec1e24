//! The memory of the recursions, allocated once and used by every call.

use alloc::{vec, vec::Vec};

use crate::Scalar;
use crate::joint::JointTransform;
use crate::mechanism::{BodyTree, Mechanism};
use crate::spatial::{
    AccelerationPerturbation, ArticulatedInertia, Field, Matrix3, RigidInertia, Twist, Vector3,
    VelocityMoments, Wrench,
};

/// The memory of the recursions: an entry for each body or degree of freedom, and pivot blocks,
/// whose size is quadratic in the length of a module.
#[derive(Clone, Debug)]
pub struct Workspace<S> {
    pub(super) motions: Vec<JointTransform<S>>,
    /// The bodies of a link's kinematic path, from the world to the link.
    pub(super) kinematic_path: Vec<usize>,
    /// The position of one point, as seen from each body.
    pub(super) points: Vec<Vector3<S>>,
    pub(super) fields: Vec<Field<S>>,
    pub(super) twists: Vec<Twist<S>>,
    pub(super) wrenches: Vec<Wrench<S>>,
    /// For each composite, the sum of x f^T over the external forces f at the points x.
    pub(super) force_moments: Vec<Matrix3<S>>,
    /// The axes of each body in the world, as columns.
    pub(super) axes: Vec<Matrix3<S>>,
    pub(super) composite: Vec<RigidInertia<S>>,
    /// The velocity moments of the composites relative to their bodies' frames.
    pub(super) velocities: Vec<VelocityMoments<S>>,
    /// Twice the velocity of each body's origin relative to its parent's origin, in the parent's
    /// axes.
    pub(super) relative_velocities: Vec<Vector3<S>>,
    /// For each degree of freedom, the change of the accelerations of its body and the body's
    /// descendants.
    pub(super) perturbations: Vec<AccelerationPerturbation<S>>,
    /// For each body, the articulated inertia of its eliminated child modules; `None` without child
    /// modules.
    pub(super) articulated: Vec<Option<ArticulatedInertia<S>>>,
    /// For each body, the inertia that soft constraints add to it; `None` if there is none.
    pub(super) added_inertia: Vec<Option<ArticulatedInertia<S>>>,
    /// For each degree of freedom, the inertia that soft constraints of the joint add to it; `None`
    /// if there is none.
    pub(super) added_armature: Vec<Option<S>>,
    /// For each component and degree of freedom: the wrench at its module's first body (Psi),
    /// reduced by the pivot's factor V (`columns`), and divided by the pivot (`scaled_psi`).
    pub(super) columns: [Vec<S>; 6],
    pub(super) scaled_psi: [Vec<S>; 6],
    /// For each degree of freedom, the reciprocal of its scalar pivot within the block.
    pub(super) reciprocals: Vec<S>,
    pub(super) torques: Vec<S>,
    /// For each degree of freedom, the joint force that springs, gravity compensation and the
    /// velocity of armature need; `None` without these.
    pub(super) passive: Vec<Option<S>>,
    /// Each module's pivot block, then its unit triangular factor.
    pub(super) pivots: Vec<S>,
    /// The mass matrix by columns and its packed factors, for equations that need them.
    pub(super) matrix: Vec<S>,
    pub(super) factors: Vec<S>,
    /// The generalized forces of external wrenches, and their derivatives by columns.
    pub(super) external: Vec<S>,
}

impl<S: Scalar> Workspace<S> {
    /// Returns the memory for a mechanism.
    #[must_use]
    pub fn new<T: BodyTree<S>>(tree: &T) -> Self {
        let model = tree.mechanism();
        let zero = S::zero();
        let bodies = model.bodies.len();
        let dofs = model.dofs.len();
        Self {
            motions: vec![JointTransform::Prismatic(zero); bodies],
            kinematic_path: Vec::with_capacity(bodies),
            axes: vec![Matrix3::zero(); bodies],
            points: vec![Vector3::zero(); bodies],
            fields: vec![Field::zero(); bodies],
            twists: vec![Twist::zero(); bodies],
            wrenches: vec![Wrench::zero(); bodies],
            force_moments: vec![Matrix3::zero(); bodies],
            composite: vec![RigidInertia::zero(); bodies],
            velocities: vec![VelocityMoments::zero(); bodies],
            relative_velocities: vec![Vector3::zero(); bodies],
            perturbations: vec![AccelerationPerturbation::zero(); dofs],
            articulated: vec![None; bodies],
            added_inertia: vec![None; bodies],
            added_armature: vec![None; dofs],
            columns: core::array::from_fn(|_| vec![zero; dofs]),
            scaled_psi: core::array::from_fn(|_| vec![zero; dofs]),
            reciprocals: vec![zero; dofs],
            torques: vec![zero; dofs],
            passive: vec![None; dofs],
            pivots: Vec::new(),
            matrix: Vec::new(),
            factors: Vec::new(),
            external: Vec::new(),
        }
    }

    /// Makes room for this many entries. Allocates only if there is less room.
    pub(super) fn reserve(&mut self, pivots: usize, matrix: usize, factors: usize) {
        for (numbers, size) in
            [(&mut self.pivots, pivots), (&mut self.matrix, matrix), (&mut self.factors, factors)]
        {
            if numbers.len() < size {
                numbers.resize(size, S::zero());
            }
        }
    }

    /// Computes the joint transforms at `q`.
    pub(super) fn move_to(&mut self, model: &Mechanism<S>, q: &[S]) {
        for (motion, body) in self.motions.iter_mut().zip(&model.bodies) {
            *motion = body.motion(q);
        }
    }
}
