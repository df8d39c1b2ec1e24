//! The generalized inertia matrix (GIM), (7)-(10).

use super::Workspace;
use crate::Scalar;
use crate::model::prepare::Prepared;

/// The GIM by columns into `columns` (n times n, column by column), both triangles.
///
/// Composite inertias by (8); element (i, j) is the part that joint j feels of the wrench that a
/// unit acceleration of joint i needs on its composite, (10). With modules of one link that is
/// the composite-rigid-body algorithm (Walker and Orin 1982); larger modules are the same sums
/// in blocks.
pub fn mass_matrix<S: Scalar>(
    model: &Prepared<S>,
    q: &[S],
    workspace: &mut Workspace<S>,
    columns: &mut [S],
) {
    let n = model.bodies.len();
    workspace.move_to(model, q);
    columns.fill(S::zero());
    for (composite, body) in workspace.composite.iter_mut().zip(&model.bodies) {
        *composite = body.minimal;
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let motion = &workspace.motions[i];
        let mut wrench = motion.unit_wrench(&workspace.composite[i]);
        columns[i * n + i] = motion.project(&wrench);
        let mut at = i;
        while let Some(parent) = model.bodies[at].parent {
            wrench = model.bodies[at].wrench_to_parent(&workspace.motions[at], wrench);
            let felt = workspace.motions[parent].project(&wrench);
            (columns[i * n + parent], columns[parent * n + i]) = (felt, felt);
            at = parent;
        }
        if let Some(parent) = body.parent {
            let carried = body.rigid_to_parent(motion, &workspace.composite[i]);
            workspace.composite[parent] = workspace.composite[parent] + carried;
        }
    }
}
