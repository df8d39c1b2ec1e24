//! Block reverse Gaussian elimination (BRGE) of the mass matrix: M = U D U^T by modules, equations
//! (35)-(57) of the paper.
//!
//! All factors are packed: entries that couple two branches are zero and are not stored
//! ([`UduLayout`]). The factors come from the recursion over the tree. In a robot with mimic joints
//! they come from the mass matrix.

use super::Workspace;
use super::dynamics::mass_matrix;
use super::factorization::factorize_tree;
use crate::Scalar;
use crate::mechanism::BodyTree;

pub use super::factorization::{
    UduLayout, condition_number, diagonal, diagonal_inverse, factorize_matrix, inverse,
    log_determinant, solve, solve_column, upper, upper_inverse,
};

/// Fills `factors` with the U D U^T factorization of the mass matrix at `q`: D, the factors of its
/// blocks, and U, stored as `layout` says. Limbs of `tree` may be merged; their parents must be on
/// one path to the root.
pub fn factorize<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    layout: &UduLayout,
    q: &[S],
    workspace: &mut Workspace<S>,
    factors: &mut [S],
) {
    let model = tree.mechanism();
    if model.has_mimics() {
        workspace.reserve(layout.pivots(), model.nv * model.nv, 0);
        let mut matrix = core::mem::take(&mut workspace.matrix);
        mass_matrix(tree, q, workspace, &mut matrix);
        factorize_matrix(layout, &mut matrix, &mut workspace.pivots, factors);
        workspace.matrix = matrix;
    } else {
        factorize_tree(tree, layout, q, workspace, factors);
    }
}
