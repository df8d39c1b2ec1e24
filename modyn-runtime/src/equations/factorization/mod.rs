//! The factorization U D U^T of the mass matrix by modules: block reverse Gaussian elimination.
//! (`lu`: of matrices that are not symmetric.)
//!
//! The module-level elimination (`recursive`) serves `brge`, with the user's modules, and forward
//! dynamics. `brge` keeps each pivot block as V Delta V^T instead of its inverse, so `solve` has no
//! explicit inverse.

pub(super) mod blocks;
mod layout;
pub(super) mod limb_coupling;
mod lu;
mod matrix;
pub(super) mod partition;
pub(super) mod recursive;
mod solve;

pub(super) use lu::{factor_ul, solve_ul};
pub(super) use recursive::factorize_tree;
pub(super) use solve::{solve_lower_factor, solve_upper_factor, solve_upper_within};

pub use {
    layout::UduLayout,
    limb_coupling::{FactorLayout, Factorizable, MergedUduLayout, cross_limb},
    matrix::factorize_matrix,
    partition::{ModuleBlock, ModulePartition},
    solve::{
        condition_number, diagonal, diagonal_inverse, inverse, log_determinant, solve,
        solve_column, upper, upper_inverse,
    },
};
