//! The joint forces of springs, gravity compensation and moving armature, in the workspace.

use super::gravity_compensation::compensation_forces;
use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::{BodyTree, Mechanism};

impl<S: Scalar> Workspace<S> {
    /// Computes the joint transforms at `q`, and the joint forces of springs, gravity compensation,
    /// and armature at the rates `qd` (zero without these).
    pub(in crate::equations) fn move_with_forces<T: BodyTree<S>>(
        &mut self,
        tree: &T,
        q: &[S],
        qd: Option<&[S]>,
    ) {
        let model = tree.mechanism();
        self.move_to(model, q);
        self.passive.fill(None);
        (0..model.bodies.len()).for_each(|i| self.load_joint_forces(model, i, q, qd));
        compensation_forces(tree, self);
    }

    /// Computes the forces of the spring and of the armature of body `i`'s joint.
    pub(in crate::equations) fn load_joint_forces(
        &mut self,
        model: &Mechanism<S>,
        i: usize,
        q: &[S],
        qd: Option<&[S]>,
    ) {
        let springs = model.spring_forces(i, q);
        let armature = qd.and_then(|qd| model.armature_forces(i, qd));
        let of_springs = springs.iter().flat_map(|forces| forces.iter());
        let forces =
            of_springs.zip(0..).chain(armature.iter().flat_map(|forces| &forces.0).zip(0..));
        let first = model.bodies[i].dofs.start;
        for (&force, k) in forces {
            let passive = &mut self.passive[first + k];
            *passive = Some(passive.map_or(force, |passive| passive + force));
        }
    }
}
