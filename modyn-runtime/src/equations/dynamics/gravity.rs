//! Gravity torques and potential energy, from composite masses and first moments, springs and
//! gravity compensation.

use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::kinematics::first_moment::{accumulate_masses, first_moment};
use crate::mechanism::{Body, BodyTree, Mechanism};
use crate::spatial::{Vector3, Wrench};

/// Computes the joint forces that balance gravity and springs: the bias forces at zero velocity,
/// without friction, and the gradient of the [`potential_energy`].
pub fn gravity_torques<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    q: &[S],
    workspace: &mut Workspace<S>,
    tau: &mut [S],
) {
    let model = tree.mechanism();
    workspace.move_with_forces(tree, q, None);
    // Towards the leaves: the world's acceleration in each link's axes. Towards the root: first
    // moments.
    for (i, body) in model.bodies.iter().enumerate() {
        let acceleration_of =
            |p: Option<usize>| p.map_or(-model.gravity, |p| workspace.twists[p].linear);
        let a = Vector3(tree.broadcast_from_parents(i, |p| acceleration_of(p).0));
        workspace.twists[i].linear = body.to_child(&workspace.motions[i], a);
    }
    accumulate_masses(tree, workspace, |body| body.base_inertia);
    tau.fill(S::zero());
    for i in 0..model.bodies.len() {
        let composite = &workspace.composite[i];
        let a = workspace.twists[i].linear;
        let wrench =
            Wrench { moment: composite.first_moment.cross(a), force: a.scale(composite.mass) };
        for d in model.bodies[i].dofs.clone() {
            let dof = &model.dofs[d];
            let weight = wrench.components()[dof.component];
            dof.add(workspace.passive[d].map_or(weight, |passive| weight + passive), tau);
        }
    }
}

/// Returns the potential energy of the moving links under gravity and of the springs, J; zero for
/// mass at the world's origin and springs at their references.
///
/// It is computed from the description's inertias. Base inertias would add a constant: they move
/// mass onto the first joint's axis.
pub fn potential_energy<S: Scalar>(
    model: &Mechanism<S>,
    q: &[S],
    workspace: &mut Workspace<S>,
) -> S {
    workspace.move_to(model, q);
    let energy = if model.compensates_gravity() {
        let heavy = |body: &Body<S>| body.inertia.minus(&body.compensated_inertia());
        -model.gravity.dot(first_moment(model, workspace, heavy))
    } else {
        -model.gravity.dot(first_moment(model, workspace, |body| body.inertia))
    };
    model.spring_energy(q).map_or(energy, |springs| energy + springs)
}
