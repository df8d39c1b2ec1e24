//! The equations of motion, each written once, generic over [`Scalar`](crate::Scalar).
//!
//! Run on `f64` they are the interpreter; run on the compiler's expressions they are what gets
//! compiled. They take their structure from the model (joint types, the tree, the modules), never
//! from values. Slices must have the model's sizes, which the [`Interpreter`](crate::Interpreter)
//! checks and the compiler provides.
//!
//! | file | quantity | source |
//! |---|---|---|
//! | `kinematics` | poses and motion of the links, Jacobians | A.1 of the paper |
//! | `center_of_mass` | centre of mass, its Jacobian | |
//! | `centroidal` | momentum about the centre of mass, its matrix | Orin, Goswami and Lee 2013 |
//! | `newton_euler` | wrenches of the links' motion | Newton and Euler; Luh, Walker and Paul 1980 |
//! | `external` | wrenches on links from outside | |
//! | `inverse_dynamics` | joint torques, bias forces | (5a) |
//! | `gravity` | gravity torques, potential energy | |
//! | `mass_matrix` | the GIM from composite modules | (7)-(10) |
//! | `elimination` | a module's block pivot and what it leaves to its parent | (35)-(49) |
//! | `brge` | U D U^T, inverse, solve | (35)-(57) |
//! | `limbs` | what the inverse has between equal limbs that are computed as one | (60) |
//! | `forward_dynamics` | accelerations by inter- and intra-modular recursion | (60), Table 6 |
//! | `kinetic_energy` | kinetic energy | |
//! | `regressor` | inverse dynamics as linear in the inertias | Atkeson, An and Hollerbach 1986 |
//! | `coordinates` | steps, differences, rates and random values of the coordinates | Murray, Li and Sastry 1994 |
//! | `singular` | the inertia that each joint feels, to find joints without any | Featherstone 1987 |
//! | `constraints` | forward dynamics of closed loops, their wrenches, rank and residuals; projection | Featherstone 2008, Baumgarte 1972, Courrieu 2005 |
//! | `derivatives` | derivatives of inverse and forward dynamics | Singh, Russell and Wensing 2022 |
//! | `denoc` | the DeNOC matrices, dense, link by link | (1)-(5), A.1, A.2 |
//! | `decomposition` | composite and articulated modules, EBUTMs, U, D and their inverses, dense | (1)-(57) |

pub mod brge;
pub mod center_of_mass;
pub mod centroidal;
mod chain;
pub mod constraints;
pub mod coordinates;
pub mod decomposition;
pub mod denoc;
mod dense;
pub mod derivatives;
mod elimination;
pub mod external;
pub mod forward_dynamics;
pub mod gravity;
pub mod inverse_dynamics;
pub mod kinematics;
pub mod kinetic_energy;
pub mod limbs;
pub mod mass_matrix;
mod newton_euler;
pub mod partition;
pub mod regressor;
pub mod singular;
mod workspace;

pub use {
    constraints::ConstraintWorkspace, decomposition::Decomposition, dense::Dense, external::Forces,
    partition::Partition, workspace::Workspace,
};
