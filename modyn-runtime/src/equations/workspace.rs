//! The memory of the recursions, one entry a body: allocated once, used by every call.

use alloc::{vec, vec::Vec};

use crate::Scalar;
use crate::joint::JointTransform;
use crate::mechanism::{BodyTree, Mechanism};
use crate::spatial::{
    AccelerationPerturbation, ArticulatedInertia, Field, Matrix3, RigidInertia, Twist, Vector3,
    VelocityMoments, Wrench,
};

/// Memory of the recursions, one entry a body or degree of freedom; linear in their number, but
/// for the pivot blocks, which are quadratic in the length of a module.
#[derive(Clone, Debug)]
pub struct Workspace<S> {
    pub(super) motions: Vec<JointTransform<S>>,
    /// A link's bodies, from the world to it.
    pub(super) kinematic_path: Vec<usize>,
    /// A point, seen from each body.
    pub(super) points: Vec<Vector3<S>>,
    pub(super) fields: Vec<Field<S>>,
    pub(super) twists: Vec<Twist<S>>,
    pub(super) wrenches: Vec<Wrench<S>>,
    /// Of the bodies, as columns, seen from the world.
    pub(super) axes: Vec<Matrix3<S>>,
    pub(super) composite: Vec<RigidInertia<S>>,
    /// The moments of the composites' velocities against their bodies' frames.
    pub(super) velocities: Vec<VelocityMoments<S>>,
    /// Twice the velocity of each body's origin over its parent's, in the parent's axes.
    pub(super) levers: Vec<Vector3<S>>,
    /// For each degree of freedom: how it changes the accelerations of the bodies after it.
    pub(super) perturbations: Vec<AccelerationPerturbation<S>>,
    /// By body: the articulated inertia of the eliminated modules that hang on it; `None` where none does.
    pub(super) articulated: Vec<Option<ArticulatedInertia<S>>>,
    /// By component, for each degree of freedom: the wrench at its module's first body (Psi),
    /// reduced by the pivot's factor; and that over the pivot.
    pub(super) columns: [Vec<S>; 6],
    pub(super) gains: [Vec<S>; 6],
    /// For each degree of freedom: reciprocal of its scalar pivot within the block.
    pub(super) reciprocals: Vec<S>,
    pub(super) torques: Vec<S>,
    /// Each module's block, then its unit triangular factor.
    pub(super) pivots: Vec<S>,
    /// A mass matrix by columns and its packed factors, where it is needed as such.
    pub(super) matrix: Vec<S>,
    pub(super) factors: Vec<S>,
}

impl<S: Scalar> Workspace<S> {
    /// Room for a model.
    #[must_use]
    pub fn new<T: BodyTree<S>>(tree: &T) -> Self {
        let model = tree.mechanism();
        let zero = S::zero();
        let (bodies, dofs) = (model.bodies.len(), model.dofs.len());
        Self {
            motions: vec![JointTransform::Prismatic(zero); bodies],
            kinematic_path: Vec::with_capacity(bodies),
            axes: vec![Matrix3::zero(); bodies],
            points: vec![Vector3::zero(); bodies],
            fields: vec![Field::zero(); bodies],
            twists: vec![Twist::zero(); bodies],
            wrenches: vec![Wrench::zero(); bodies],
            composite: vec![RigidInertia::zero(); bodies],
            velocities: vec![VelocityMoments::zero(); bodies],
            levers: vec![Vector3::zero(); bodies],
            perturbations: vec![AccelerationPerturbation::zero(); dofs],
            articulated: vec![None; bodies],
            columns: core::array::from_fn(|_| vec![zero; dofs]),
            gains: core::array::from_fn(|_| vec![zero; dofs]),
            reciprocals: vec![zero; dofs],
            torques: vec![zero; dofs],
            pivots: Vec::new(),
            matrix: Vec::new(),
            factors: Vec::new(),
        }
    }

    /// Room for that many numbers; allocates where there is none yet.
    pub(super) fn reserve(&mut self, pivots: usize, matrix: usize, factors: usize) {
        for (numbers, size) in
            [(&mut self.pivots, pivots), (&mut self.matrix, matrix), (&mut self.factors, factors)]
        {
            if numbers.len() < size {
                numbers.resize(size, S::zero());
            }
        }
    }

    /// The joints at `q`.
    pub(super) fn move_to(&mut self, model: &Mechanism<S>, q: &[S]) {
        for (motion, body) in self.motions.iter_mut().zip(&model.bodies) {
            *motion = body.motion(q);
        }
    }
}
