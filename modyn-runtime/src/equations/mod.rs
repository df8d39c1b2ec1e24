//! The equations of motion, each written once, generic over [`Scalar`](crate::Scalar).
//!
//! Run on `f64`, the equations are the interpreter. Run on the compiler's expressions, they are
//! traced and compiled. Their structure depends on the model (joint types, tree, modules), never on
//! values. Slices must have the model's sizes: the [`Interpreter`](crate::Interpreter) checks them,
//! and the compiler provides them.
//!
//! The public items of a folder's files are the folder's: a quantity in a file is exported without
//! another line.
//!
//! | file | quantity | source |
//! |---|---|---|
//! | `kinematics/links` | poses and motion of the links, Jacobians | A.1 of the paper |
//! | `kinematics/center_of_mass` | centre of mass, its Jacobian | |
//! | `kinematics/coordinates` | integration, differences, rates, random values | Murray, Li and Sastry 1994 |
//! | `dynamics/newton_euler` | the wrenches of the bodies' motion | Newton and Euler; Luh, Walker and Paul 1980 |
//! | `dynamics/external` | external wrenches on links | |
//! | `dynamics/inverse_dynamics` | joint forces, bias forces | (5a) |
//! | `dynamics/forward_dynamics` | accelerations by inter- and intra-modular recursion | (60), Table 6 |
//! | `dynamics/one_body` | inverse and forward dynamics of one body, for loops over bodies | |
//! | `dynamics/mass_matrix` | the mass matrix from composite modules | (7)-(10) |
//! | `dynamics/gravity` | gravity torques, potential energy | |
//! | `dynamics/gravity_compensation` | the forces of gravity compensation, and their derivatives | |
//! | `dynamics/kinetic_energy` | kinetic energy | |
//! | `dynamics/centroidal` | momentum about the centre of mass, its matrix | Orin, Goswami and Lee 2013 |
//! | `factorization/recursive` | a module's pivot block and the articulated inertia at its parent | (35)-(49) |
//! | `factorization/matrix` | U D U^T from the mass matrix, for mimic joints and derivatives | (16)-(45) |
//! | `factorization/solve` | solving, the inverse, the factors as full matrices | (50)-(60) |
//! | `factorization/lu` | elimination of matrices that are not symmetric | |
//! | `factorization/limb_coupling` | the entries of the inverse that couple merged limbs | (60) |
//! | `brge` | the public entry of the factorization | (35)-(57) |
//! | `derivatives` | derivatives of inverse and forward dynamics | Singh, Russell and Wensing 2022 |
//! | `derivatives/external` | the same under external wrenches | |
//! | `soft_constraints` | steps with soft contacts, joint limits and dry joint friction | Todorov 2014 |
//! | `actuation` | the joint forces of actuators, and their activations after a step | Todorov 2014 |
//! | `steps/semi_implicit` | the state after a semi-implicit Euler step, its derivatives | |
//! | `steps/implicit_midpoint` | the same of the implicit midpoint rule | Hairer, Lubich and Wanner 2006 |
//! | `steps/runge_kutta` | the state after a Runge-Kutta step | Celledoni, Marthinsen and Owren 2003 |
//! | `identification/regressor` | inverse dynamics by inertial parameters | Atkeson, An and Hollerbach 1986 |
//! | `identification/base_parameters` | the inertial parameters that joint forces depend on | Gautier 1991 |
//! | `singular` | the inertia at each joint, to find joints without inertia | Featherstone 1987 |
//! | `constraints` | closed loops and contacts | Featherstone 2008, Baumgarte 1972, Courrieu 2005 |
//! | `paper/denoc` | the DeNOC matrices, dense, link by link | (1)-(5), A.1, A.2 |
//! | `paper/decomposition` | composite and articulated modules, EBUTMs, U, D and their inverses, dense | (1)-(57) |
//!
//! Numbers in brackets, A.1, A.2 and Table 6 are from Shah, Saha and Dutt, "A new perspective
//! towards decomposition of the generalized inertia matrix of multibody systems".
//!
//! No equation branches on a value or asks whether a scalar is constant: structure comes from the
//! mechanism (joint types, `AxisRotation::Quarters`, rigid or articulated inertia, modules). A
//! comparison of the interpreter with generated code therefore finds a wrong compilation, never a
//! wrong equation. Equations are tested against reference data of other software (`tests/golden`),
//! the paper's printed numbers, physical identities, and a naive implementation in world axes that
//! shares no code with them (`tests/src/naive.rs`).
//!
//! External forces are arguments for all links of the description, with zeros where none act. The
//! compiler folds forces on links that do not move; each other force costs an addition.

pub mod actuation;
mod arguments;
pub mod brge;
pub mod constraints;
pub mod derivatives;
pub mod dynamics;
pub mod factorization;
pub mod identification;
pub mod kinematics;
pub mod paper;
pub mod singular;
pub mod soft_constraints;
pub mod steps;
mod workspace;

pub use {
    arguments::*,
    constraints::ConstraintWorkspace,
    dynamics::Forces,
    factorization::ModulePartition,
    steps::{MidpointWorkspace, RungeKuttaWorkspace, StepWorkspace},
    workspace::Workspace,
};
