//! The decoupled natural orthogonal complement (DeNOC) matrices at link level, dense, for study:
//! (1)-(5), A.1 and A.2. `decomposition` has the matrices at module level.

use super::Dense;
use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::{Body, Mechanism};
use crate::spatial::{Matrix3, Twist, Vector3, Wrench};

/// The matrices M, N_l and N_d at link level: the mass matrix is N_d^T N_l^T M N_l N_d, (5a),
/// without the rotors' inertia.
///
/// Rows are ordered by body, angular before linear. The bodies are the links, each in its own
/// frame, and the massless bodies inside a universal or planar joint, before the joint's link. The
/// columns of N_d are the entries of qd. For larger modules, N_l and N_d of (4) have the same
/// product; see [`Decomposition`](super::Decomposition).
#[derive(Clone, Debug, PartialEq)]
pub struct DeNoc<S> {
    /// The 6n x 6n mass matrix of the n uncoupled bodies, (1)-(2).
    pub mass: Dense<S>,
    /// The 6n x 6n matrix of twist propagations, (A.12).
    pub propagation: Dense<S>,
    /// The 6n x nv matrix of joint-motion propagations, (A.5).
    pub joints: Dense<S>,
}

impl<S: Scalar> DeNoc<S> {
    /// Returns the mass matrix by (5a), N^T M N with N = N_l N_d. This is slow; it is meant for
    /// study.
    #[must_use]
    pub fn mass_matrix(&self) -> Dense<S> {
        let n = self.propagation.times(&self.joints);
        n.transposed().times(&self.mass.times(&n))
    }
}

/// Returns the DeNOC matrices at `q`.
#[must_use]
pub fn denoc<S: Scalar>(model: &Mechanism<S>, q: &[S], workspace: &mut Workspace<S>) -> DeNoc<S> {
    workspace.move_to(model, q);
    let n = model.bodies.len();
    let mut mass = Dense::zero(6 * n, 6 * n);
    let mut propagation = Dense::zero(6 * n, 6 * n);
    let mut joints = Dense::zero(6 * n, model.nv);
    for (i, body) in model.bodies.iter().enumerate() {
        let motion = &workspace.motions[i];
        let inertia = body.inertia.articulated();
        for dof in model.dofs_of(i) {
            let column = unit(dof.component).scale(dof.scale(S::one()));
            joints.set_column(6 * i, dof.v, to_link(body, column));
        }
        for k in 0..6 {
            propagation.set_column(6 * i, 6 * i + k, unit(k));
            let wrench = wrench_to_link(body, inertia.times(&from_link(body, unit(k))));
            for (row, entry) in wrench.components().into_iter().enumerate() {
                mass.set(6 * i + row, 6 * i + k, entry);
            }
        }
        // A row of blocks is the parent's row, propagated: A_ij = A_ip A_pj.
        if let Some(parent) = body.parent {
            for column in 0..6 * (parent + 1) {
                let at = |row: usize| propagation.entries[(6 * parent + row) * 6 * n + column];
                let twist = Twist::from_components(core::array::from_fn(at));
                let at_body = from_link(&model.bodies[parent], twist);
                let from_parent = to_link(body, body.twist_to_child(motion, at_body));
                propagation.set_column(6 * i, column, from_parent);
            }
        }
    }
    DeNoc { mass, propagation, joints }
}

/// Returns the unit twist in component `k`.
fn unit<S: Scalar>(k: usize) -> Twist<S> {
    Twist::from_components(core::array::from_fn(|i| if i == k { S::one() } else { S::zero() }))
}

/// Returns a body's twist at the origin and in the axes of the model's link frame.
fn to_link<S: Scalar>(body: &Body<S>, t: Twist<S>) -> Twist<S> {
    let back = Matrix3(body.link.rotation).transposed();
    let linear = t.linear + t.angular.cross(Vector3(body.link.translation));
    Twist { angular: back.mul_vector(t.angular), linear: back.mul_vector(linear) }
}

/// Returns a twist of the model's link frame at the origin and in the axes of the body's frame.
fn from_link<S: Scalar>(body: &Body<S>, t: Twist<S>) -> Twist<S> {
    let rotation = Matrix3(body.link.rotation);
    let angular = rotation.mul_vector(t.angular);
    let shift = angular.cross(Vector3(body.link.translation));
    Twist { angular, linear: rotation.mul_vector(t.linear) - shift }
}

/// Returns a body's wrench at the origin and in the axes of the model's link frame.
fn wrench_to_link<S: Scalar>(body: &Body<S>, w: Wrench<S>) -> Wrench<S> {
    let back = Matrix3(body.link.rotation).transposed();
    let moment = w.moment - Vector3(body.link.translation).cross(w.force);
    Wrench { moment: back.mul_vector(moment), force: back.mul_vector(w.force) }
}
