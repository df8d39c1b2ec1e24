//! The joint-space mass matrix, equations (7)-(10) of the paper.

use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::{BodyTree, RootwardAccumulator};
use crate::spatial::Wrench;

/// Computes the mass matrix, nv x nv, into `columns`, column by column. Both triangles are filled.
///
/// Composite inertias follow (8). Entry (i, j) is the component along joint j of the wrench that a
/// unit acceleration of joint i needs on its composite, (10). With modules of one link this is the
/// composite-rigid-body algorithm (Walker and Orin 1982). Larger modules are the same sums in
/// blocks. (Derivatives compute the mass matrix in their own sweep: `derivatives::projection`.)
pub fn mass_matrix<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    q: &[S],
    workspace: &mut Workspace<S>,
    columns: &mut [S],
) {
    let model = tree.mechanism();
    let n = model.nv;
    workspace.move_to(model, q);
    columns.fill(S::zero());
    for (composite, body) in workspace.composite.iter_mut().zip(&model.bodies) {
        *composite = body.base_inertia;
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        for (d, dof) in body.dofs.clone().zip(model.dofs_of(i)) {
            let mut add = |row: usize, column: usize, entry: S| {
                let entry_of = &mut columns[column * n + row];
                *entry_of = *entry_of + entry;
            };
            let mut wrench = workspace.composite[i].column(dof.component);
            let mut inertia = wrench.components()[dof.component];
            if let Some(armature) = dof.armature {
                inertia = inertia + armature;
            }
            add(dof.v, dof.v, dof.scale(dof.scale(inertia)));
            let mut at = i;
            let mut path = RootwardAccumulator::new(tree);
            let mut others = body.dofs.start..d;
            loop {
                for other in model.dofs[others].iter() {
                    let force = other.scale(dof.scale(wrench.components()[other.component]));
                    // If mimic joints map both to one entry of qd, the entry counts twice.
                    add(other.v, dof.v, force);
                    add(dof.v, other.v, force);
                }
                let Some(parent) = model.bodies[at].parent else { break };
                let body = &model.bodies[at];
                let at_parent = body.wrench_to_parent(&workspace.motions[at], wrench);
                wrench =
                    Wrench::from_components(path.accumulate(at, parent, at_parent.components()));
                at = parent;
                others = model.bodies[at].dofs.clone();
            }
        }
        let inertia = workspace.composite[i];
        tree.rigid_to_parents(i, &workspace.motions[i], &inertia, |parent, at_parent| {
            workspace.composite[parent] = workspace.composite[parent] + at_parent;
        });
    }
}
