//! The table of functions, with one row for each function.
//!
//! A row drives the selection, the tracer, batches, the printers, the limit of the text, the methods of the Python package and
//! the table in `docs/functions.md`.

mod arguments;
mod row;
mod selection;

use modyn_runtime::equations::dynamics::{forward_dynamics_of_bodies, inverse_dynamics_of_bodies};
use modyn_runtime::equations::kinematics::Axes;

use super::measures::Measures;
use super::shape::shapes;
use arguments::{
    CONTACTS, COSTATE, COTANGENT, DQ, DQD, DQDD, DT, DTAU, FORCES, FROM, Q, QD, QDD, SETTINGS, TAU,
    TO, UNIFORMS, V, WRENCH_COTANGENT,
};

pub use arguments::ARGUMENTS;
pub use arguments::{Argument, ArgumentKind, BatchForm};
pub(super) use arguments::{FACTORS, RHS};
pub use row::{CForm, Packing, Row, Trace};

/// Returns the estimated length of the derivatives of constrained forward dynamics.
fn constrained_derivatives(m: &Measures) -> f64 {
    1400.0 * m.depths
        + 800.0 * m.squares
        + 90.0 * m.nv.powi(3)
        + 9000.0 * m.reach
        + 5000.0 * m.row_reach
        + 120.0 * m.constraint_rows * m.entries
        + 500.0 * m.constraint_rows.powi(2) * m.nv
}

macro_rules! functions {
    ($($(#[$docs:meta])* $variant:ident $name:literal = $row:expr;)*) => {
        /// A function of generated robots.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum Function {
            $($(#[$docs])* $variant,)*
        }

        impl Function {
            /// All functions, in the order of generated code.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// Returns the function's name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            /// Returns the function's row of the table.
            #[must_use]
            pub const fn row(self) -> Row {
                match self {
                    $(Self::$variant => rows::$variant,)*
                }
            }
        }

        /// The rows of the functions.
        #[allow(non_upper_case_globals)]
        mod rows {
            use super::*;

            $(pub(super) const $variant: Row = $row;)*
        }
    };
}

functions! {
    /// Joint accelerations under joint forces.
    ForwardDynamics "forward_dynamics" = Row::one(
        &[Q, QD, TAU],
        shapes::velocities,
        "Returns the joint accelerations (rad/s^2 or m/s^2) at the coordinates `q` and velocities `qd` under the\n\
         joint forces `tau` (N m or N), gravity included. The method is block reverse Gaussian elimination of the\n\
         mass matrix by inter- and intra-modular recursion.",
        |t, s| t.forward_dynamics(&s.elimination),
        |m| 14_000.0 * m.carried + 600.0 * m.links,
    )
        .result_named("qdd")
        .by_default()
        .packed(Packing::ByModules)
        .recursion(forward_dynamics_of_bodies)
        .hot();
    /// Joint forces of joint accelerations.
    InverseDynamics "inverse_dynamics" = Row::one(
        &[Q, QD, QDD],
        shapes::velocities,
        "Returns the joint forces (N m or N) of the accelerations `qdd` at the coordinates `q` and velocities\n\
         `qd`, gravity included, by the recursive Newton-Euler algorithm.",
        |t, _| t.inverse_dynamics(),
        |m| 8000.0 * m.carried + 600.0 * m.links,
    )
        .result_named("tau")
        .by_default()
        .packed(Packing::Limbs)
        .recursion(inverse_dynamics_of_bodies)
        .hot();
    /// Coriolis, centrifugal and gravity forces.
    BiasForces "bias_forces" = Row::one(
        &[Q, QD],
        shapes::velocities,
        "Returns the bias forces (N m or N): inverse dynamics at zero acceleration. They are the Coriolis,\n\
         centrifugal and gravity forces, with damping and friction if these are enabled.",
        |t, _| t.bias_forces(),
        |m| 8000.0 * m.carried + 600.0 * m.links,
    )
        .by_default()
        .packed(Packing::Limbs)
        .hot();
    /// Joint forces that balance gravity.
    GravityTorques "gravity_torques" = Row::one(
        &[Q],
        shapes::velocities,
        "Returns the joint forces (N m or N) that balance gravity at `q` and zero velocity.",
        |t, _| t.gravity_torques(),
        |m| 900.0 * m.links,
    )
        .by_default()
        .packed(Packing::Limbs);
    /// The mass matrix.
    MassMatrix "mass_matrix" = Row::one(
        &[Q],
        shapes::square,
        "Returns the mass matrix at `q`, nv x nv, an array of columns.",
        |t, _| t.mass_matrix(),
        |m| 1400.0 * m.depths + 10.0 * m.entries,
    )
        .by_default()
        .packed(Packing::OnRootPath)
        .hot();
    /// The Coriolis matrix.
    CoriolisMatrix "coriolis_matrix" = Row::one(
        &[Q, QD],
        shapes::square,
        "Returns the Coriolis matrix C, nv x nv, an array of columns. C `qd` are the Coriolis and centrifugal forces,\n\
         without gravity, damping and friction, and dM/dt - 2 C is skew with the mass matrix M.",
        |t, _| t.coriolis_matrix(),
        |m| 3000.0 * (m.depths + m.carried) + 60.0 * m.entries,
    );
    /// The factorization U D U^T of the mass matrix by modules.
    Brge "brge" = Row::one(
        &[Q],
        shapes::factors,
        "Returns the factorization U D U^T of the mass matrix at `q` by kinematic modules, by block reverse\n\
         Gaussian elimination.",
        |t, s| t.brge(&s.layout),
        |m| 1000.0 * m.depths + 130.0 * m.squares + 40.0 * m.entries + 25.0 * m.pivots,
    )
        .by_default()
        .not_exported();
    /// Kinetic energy.
    KineticEnergy "kinetic_energy" = Row::one(
        &[Q, QD],
        shapes::scalar,
        "Returns the kinetic energy of the moving links and the rotors, J.",
        |t, _| t.kinetic_energy(),
        |m| 1800.0 * m.carried + 100.0 * m.links,
    )
        .by_default();
    /// Potential energy.
    PotentialEnergy "potential_energy" = Row::one(
        &[Q],
        shapes::scalar,
        "Returns the potential energy of the moving links under gravity, J; zero for mass at the world's origin.",
        |t, _| t.potential_energy(),
        |m| 500.0 * m.links,
    )
        .by_default();
    /// Forward dynamics with external wrenches in the links' axes.
    ForwardDynamicsExternal "forward_dynamics_external" = Row::one(
        &[Q, QD, TAU, FORCES],
        shapes::velocities,
        "Returns the joint accelerations under `tau` and a wrench on each link (in the order of `LINK_NAMES`),\n\
         at the link's origin in the link's own axes.",
        |_, s| s.all_links.forward_dynamics_external(&s.elimination, Axes::Link),
        |m| 14_000.0 * m.carried + 1500.0 * m.frames,
    )
        .result_named("qdd");
    /// Forward dynamics with external wrenches in world axes.
    ForwardDynamicsExternalWorld "forward_dynamics_external_world" = Row::one(
        &[Q, QD, TAU, FORCES],
        shapes::velocities,
        "Returns the joint accelerations under `tau` and a wrench on each link (in the order of `LINK_NAMES`),\n\
         at the link's origin in world axes.",
        |_, s| s.all_links.forward_dynamics_external(&s.elimination, Axes::World),
        |m| 14_000.0 * m.carried + 1500.0 * m.frames,
    )
        .result_named("qdd");
    /// Inverse dynamics with external wrenches in the links' axes.
    InverseDynamicsExternal "inverse_dynamics_external" = Row::one(
        &[Q, QD, QDD, FORCES],
        shapes::velocities,
        "Returns the joint forces of `qdd` under a wrench on each link (in the order of `LINK_NAMES`), at the\n\
         link's origin in the link's own axes.",
        |_, s| s.all_links.inverse_dynamics_external(Axes::Link),
        |m| 6000.0 * m.carried + 1500.0 * m.frames,
    )
        .result_named("tau");
    /// Inverse dynamics with external wrenches in world axes.
    InverseDynamicsExternalWorld "inverse_dynamics_external_world" = Row::one(
        &[Q, QD, QDD, FORCES],
        shapes::velocities,
        "Returns the joint forces of `qdd` under a wrench on each link (in the order of `LINK_NAMES`), at the\n\
         link's origin in world axes.",
        |_, s| s.all_links.inverse_dynamics_external(Axes::World),
        |m| 6000.0 * m.carried + 1500.0 * m.frames,
    )
        .result_named("tau");
    /// Generalized forces of external wrenches in the links' axes.
    GeneralizedForces "generalized_forces" = Row::one(
        &[Q, FORCES],
        shapes::generalized_forces,
        "Returns the generalized forces J^T f of a wrench on each link (in the order of `LINK_NAMES`), at the link's\n\
         origin in the link's own axes, and their derivative with respect to `q` (in tangent space), an array of\n\
         columns. The wrenches rotate with their links.",
        |_, s| s.all_links.generalized_forces(Axes::Link),
        |m| 900.0 * m.depths + 60.0 * m.entries + 1500.0 * m.frames,
    )
        .without_parameters();
    /// Generalized forces of external wrenches in world axes.
    GeneralizedForcesWorld "generalized_forces_world" = Row::one(
        &[Q, FORCES],
        shapes::generalized_forces,
        "Returns the generalized forces J^T f of a wrench on each link (in the order of `LINK_NAMES`), at the link's\n\
         origin in world axes, and their derivative with respect to `q` (in tangent space), an array of columns. The\n\
         wrenches keep their directions.",
        |_, s| s.all_links.generalized_forces(Axes::World),
        |m| 1500.0 * m.depths + 2000.0 * m.links + 60.0 * m.entries + 1500.0 * m.frames,
    )
        .without_parameters();
    /// Derivatives of inverse dynamics.
    InverseDynamicsDerivatives "inverse_dynamics_derivatives" = Row::one(
        &[Q, QD, QDD],
        shapes::inverse_derivatives,
        "Returns the derivatives of inverse dynamics with respect to `q` (in tangent space) and `qd`, each an\n\
         array of columns. The derivative with respect to `qdd` is the mass matrix.",
        |t, _| t.inverse_dynamics_derivatives(),
        |m| 5000.0 * (m.depths + m.carried) + 100.0 * m.entries,
    )
        .result_named("derivatives")
        .packed(Packing::Derivatives)
        .hot();
    /// Derivatives of forward dynamics.
    ForwardDynamicsDerivatives "forward_dynamics_derivatives" = Row::one(
        &[Q, QD, TAU],
        shapes::forward_derivatives,
        "Returns the joint accelerations, and the derivatives of forward dynamics with respect to `q` (in tangent\n\
         space), `qd` and `tau`, each an array of columns.",
        |t, s| t.forward_dynamics_derivatives(&s.for_derivatives),
        |m| 5000.0 * m.depths + 600.0 * m.squares + 100.0 * m.entries,
    )
        .result_named("derivatives")
        .packed(Packing::Derivatives)
        .hot();
    /// Products of a vector and the derivatives of inverse dynamics.
    InverseDynamicsVjp "inverse_dynamics_vjp" = Row::one(
        &[Q, QD, QDD, COTANGENT],
        shapes::inverse_vjp,
        "Returns the joint forces tau of `qdd`, and the products of `cotangent` with their derivatives: the gradients\n\
         of `cotangent`^T tau with respect to `q` (in tangent space), `qd` and `qdd`.",
        |t, _| t.inverse_dynamics_vjp(),
        |m| 24_000.0 * m.carried + 1800.0 * m.links,
    );
    /// Products of the derivatives of inverse dynamics and a vector.
    InverseDynamicsJvp "inverse_dynamics_jvp" = Row::one(
        &[Q, QD, QDD, DQ, DQD, DQDD],
        shapes::inverse_jvp,
        "Returns the joint forces tau of `qdd`, and their change under the changes `dq` (in tangent space), `dqd` and\n\
         `dqdd`.",
        |t, _| t.inverse_dynamics_jvp(),
        |m| 24_000.0 * m.carried + 1800.0 * m.links,
    );
    /// Products of a vector and the derivatives of forward dynamics.
    ForwardDynamicsVjp "forward_dynamics_vjp" = Row::one(
        &[Q, QD, TAU, COTANGENT],
        shapes::forward_vjp,
        "Returns the accelerations qdd, and the products of `cotangent` with their derivatives: the gradients of\n\
         `cotangent`^T qdd with respect to `q` (in tangent space), `qd` and `tau`.",
        |t, s| t.forward_dynamics_vjp(&s.forward_dynamics.graph),
        |m| 40_000.0 * m.carried + 3000.0 * m.links,
    );
    /// Products of the derivatives of forward dynamics and a vector.
    ForwardDynamicsJvp "forward_dynamics_jvp" = Row::one(
        &[Q, QD, TAU, DQ, DQD, DTAU],
        shapes::forward_jvp,
        "Returns the accelerations qdd, and their change under the changes `dq` (in tangent space), `dqd` and `dtau`.",
        |t, s| t.forward_dynamics_jvp(&s.forward_dynamics.graph),
        |m| 40_000.0 * m.carried + 3000.0 * m.links,
    );
    /// The contracted Hessian of inverse dynamics.
    InverseDynamicsHessian "inverse_dynamics_hessian" = Row::one(
        &[Q, QD, QDD, COTANGENT],
        shapes::inverse_hessian,
        "Returns the joint forces tau of `qdd`, and the gradients and the Hessian of `cotangent`^T tau with respect to\n\
         `q` (in tangent space), `qd` and `qdd`. The blocks of the Hessian are arrays of columns; the blocks of `qd` and\n\
         `qdd` and of `qdd` and `qdd` are zero.",
        |t, _| t.inverse_dynamics_hessian(),
        |m| 18_000.0 * m.depths + 150.0 * m.entries,
    )
        .packed(Packing::Columns);
    /// The contracted Hessian of forward dynamics.
    ForwardDynamicsHessian "forward_dynamics_hessian" = Row::one(
        &[Q, QD, TAU, COTANGENT],
        shapes::forward_hessian,
        "Returns the accelerations qdd, and the gradients and the Hessian of `cotangent`^T qdd with respect to `q` (in\n\
         tangent space), `qd` and `tau`. The blocks of the Hessian are arrays of columns; the blocks of `qd` and `tau`\n\
         and of `tau` and `tau` are zero.",
        |t, s| t.forward_dynamics_hessian(&s.for_derivatives),
        |m| 18_000.0 * m.depths + 1800.0 * m.squares + 150.0 * m.entries,
    )
        .packed(Packing::Columns);
    /// The state after a semi-implicit Euler step.
    StepSemiImplicit "step_semi_implicit" = Row::step(
        "Returns the state after the time `dt` (s) under the joint forces `tau`, by the semi-implicit Euler method: the\n\
         new velocities are `qd` + `dt` qdd, and move the coordinates.",
        |t, s| t.step_semi_implicit(&s.elimination),
        |m| 14_000.0 * m.carried + 800.0 * m.links,
    );
    /// Derivatives of a semi-implicit Euler step.
    StepSemiImplicitDerivatives "step_semi_implicit_derivatives" = Row::one(
        &[Q, QD, TAU, DT],
        shapes::step_derivatives,
        "Returns the state after the time `dt` (s) by the semi-implicit Euler method, and its derivatives: `a` with\n\
         respect to the state before and `b` with respect to `tau`, arrays of columns. A state has the entries of q\n\
         (in tangent space), then those of qd.",
        |t, s| t.step_semi_implicit_derivatives(&s.for_derivatives),
        |m| 5000.0 * m.depths + 600.0 * m.squares + 350.0 * m.entries,
    );
    /// The contracted Hessian of a semi-implicit Euler step.
    StepSemiImplicitHessian "step_semi_implicit_hessian" = Row::one(
        &[Q, QD, TAU, DT, COSTATE],
        shapes::step_hessian,
        "Returns the state after the time `dt` (s) by the semi-implicit Euler method, and the gradients and the Hessian of\n\
         `costate`^T state: `dx` and `dtau` with respect to the state before and `tau`, and `dx_dx`, `dx_dtau` and\n\
         `dtau_dtau`, arrays of columns. A state has the entries of q (in tangent space), then those of qd. Displacements\n\
         of the state after the step are in tangent space, too.",
        |t, s| t.step_semi_implicit_hessian(&s.for_derivatives),
        |m| 18_000.0 * m.depths + 1800.0 * m.squares + 500.0 * m.entries,
    )
        .packed(Packing::Columns);
    /// The state after a Runge-Kutta step.
    StepRk4 "step_rk4" = Row::step(
        "Returns the state after the time `dt` (s) under the constant joint forces `tau`, by a Runge-Kutta method of\n\
         fourth order. Rotations follow exponential maps, so quaternions keep length 1.",
        |t, s| t.step_rk4(&s.elimination),
        |m| 56_000.0 * m.carried + 3200.0 * m.links,
    );
    /// Derivatives of a Runge-Kutta step.
    StepRk4Derivatives "step_rk4_derivatives" = Row::one(
        &[Q, QD, TAU, DT],
        shapes::step_derivatives,
        "Returns the state of `step_rk4`, and its derivatives: `a` with respect to the state before and `b` with respect\n\
         to `tau`, arrays of columns. A state has the entries of q (in tangent space), then those of qd.",
        |t, s| t.step_rk4_derivatives(&s.for_derivatives),
        |m| {
            // Four times the derivatives of forward dynamics, and products of matrices, which a floating base makes dense.
            20_000.0 * m.depths
                + 8400.0 * m.squares
                + 1400.0 * m.entries
                + 1250.0 * m.bases * m.entries * m.nv
        },
    );
    /// The state after a step of the implicit midpoint rule.
    StepImplicitMidpoint "step_implicit_midpoint" = Row::step(
        "Returns the state after the time `dt` (s) under the constant joint forces `tau`, by the implicit midpoint rule: of\n\
         second order, symmetric, and stable under stiff damping. Three iterations of simplified Newton solve its\n\
         equations. Rotations follow exponential maps, so quaternions keep length 1.",
        |t, _| t.step_implicit_midpoint(),
        |m| 5000.0 * (m.depths + m.carried) + 40_000.0 * m.carried + 600.0 * m.squares + 100.0 * m.entries,
    );
    /// Derivatives of a step of the implicit midpoint rule.
    StepImplicitMidpointDerivatives "step_implicit_midpoint_derivatives" = Row::one(
        &[Q, QD, TAU, DT],
        shapes::step_derivatives,
        "Returns the state of `step_implicit_midpoint`, and the derivatives of the implicit midpoint rule: `a` with respect\n\
         to the state before and `b` with respect to `tau`, arrays of columns. A state has the entries of q (in tangent\n\
         space), then those of qd.",
        |t, _| t.step_implicit_midpoint_derivatives(),
        |m| 10_000.0 * (m.depths + m.carried) + 40_000.0 * m.carried + 1200.0 * m.squares + 400.0 * m.entries,
    );
    /// Forward dynamics with the loops closed and the active contacts held.
    ConstrainedForwardDynamics "constrained_forward_dynamics" = Row::one(
        &[Q, QD, TAU, CONTACTS, SETTINGS],
        shapes::constrained,
        "Returns the joint accelerations under the joint forces `tau` with the loops closed and the active\n\
         contacts held. Also returns the wrench on each constraint's link and the unmet part of the constraint's\n\
         acceleration, and the number of independent constraint rows. Loop constraints come first, in the order\n\
         of `LOOP_CONSTRAINT_NAMES`, at the second frame's origin in the first frame's axes. Contacts follow, in\n\
         the order of `CONTACT_NAMES`, at the frame's origin in world axes. Redundant rows get the multipliers of\n\
         smallest norm.",
        |t, s| t.constrained_forward_dynamics(&s.for_derivatives),
        |m| {
            1200.0 * m.depths
                + 70.0 * m.squares
                + 30.0 * m.entries
                + 850.0 * m.reach
                + 2200.0 * m.row_reach
                + 15.0 * m.constraint_rows.powi(2) * m.nv
                + 60.0 * m.constraint_rows.powi(3)
        },
    )
        .by_default()
        .of_constraints()
        .packed(Packing::Contacts);
    /// Displacements and velocities that violate the constraints.
    ConstraintResidual "constraint_residual" = Row::one(
        &[Q, QD, SETTINGS],
        shapes::constraint_residual,
        "Returns the displacement and the velocity of each loop constraint's second frame relative to its first,\n\
         in the first frame's axes; then of each contact's frame, active or not, relative to its target, in world\n\
         axes. Components along free directions are zero. A rotation is its axis times the sine of its angle.",
        |t, s| t.constraint_residual(&s.layout),
        |m| 400.0 * m.reach + 300.0 * m.row_reach,
    )
        .by_default()
        .of_constraints()
        .without_parameters();
    /// The steps that satisfy the constraints.
    ProjectConstraints "project_constraints" = Row::one(
        &[Q, QD, CONTACTS, SETTINGS],
        shapes::constraint_projection,
        "Returns the smallest step (in the metric of the mass matrix) that closes the loops at `q` and moves the\n\
         active contacts to their targets to first order, the smallest change of `qd` that keeps them there, and\n\
         the number of independent constraint rows. The settings `alpha` and `beta` have no effect.",
        |t, s| t.project_constraints(&s.for_derivatives),
        |m| {
            140.0 * m.squares
                + 850.0 * m.reach
                + 1800.0 * m.row_reach
                + 35.0 * m.constraint_rows.powi(2) * m.nv
                + 50.0 * m.constraint_rows.powi(3)
        },
    )
        .by_default()
        .of_constraints()
        .packed(Packing::Contacts);
    /// Derivatives of forward dynamics with contacts.
    ConstrainedForwardDynamicsDerivatives "constrained_forward_dynamics_derivatives" = Row::one(
        &[Q, QD, TAU, CONTACTS, SETTINGS],
        shapes::constrained_derivatives,
        "Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and their derivatives with\n\
         respect to `q` (in tangent space), `qd` and `tau`, each an array of columns. The derivatives of wrenches\n\
         are arrays for each constraint, in the axes of the wrenches. The rank is assumed constant; redundant\n\
         rows get the derivatives of smallest norm.",
        |t, s| t.constrained_forward_dynamics_derivatives(&s.layout),
        constrained_derivatives,
    )
        .of_constraints()
        .packed(Packing::ConstrainedColumns);
    /// The contracted Hessian of forward dynamics with constraints.
    ConstrainedForwardDynamicsHessian "constrained_forward_dynamics_hessian" = Row::one(
        &[Q, QD, TAU, COTANGENT, WRENCH_COTANGENT, CONTACTS, SETTINGS],
        shapes::constrained_hessian,
        "Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and the gradients and the\n\
         Hessian of their sum with the weights `cotangent` and `wrench_cotangent` (of the components of the wrenches)\n\
         with respect to `q` (in tangent space), `qd` and `tau`. The blocks of the Hessian are arrays of columns; the\n\
         blocks of `qd` and `tau` and of `tau` and `tau` are zero. The rank is assumed constant. Weights of wrenches\n\
         need independent rows, or compliance.",
        |t, s| t.constrained_forward_dynamics_hessian(&s.layout),
        |m| constrained_derivatives(m) + 18_000.0 * m.depths + 300.0 * m.entries,
    )
        .of_constraints();
    /// The velocities after an impact.
    ContactImpulse "contact_impulse" = Row::one(
        &[Q, QD, CONTACTS, SETTINGS],
        shapes::contact_impulse,
        "Returns the velocities after an impact that closes the loops and stops the active contacts relative to\n\
         their targets at the same instant, the impulse of each constraint, and the number of independent\n\
         constraint rows. Along its normal, a contact leaves with `restitution` times the speed before the\n\
         impact. The settings `alpha` and `beta` have no effect.",
        |t, s| t.contact_impulse(&s.for_derivatives),
        |m| {
            140.0 * m.squares
                + 850.0 * m.reach
                + 1800.0 * m.row_reach
                + 35.0 * m.constraint_rows.powi(2) * m.nv
                + 50.0 * m.constraint_rows.powi(3)
        },
    )
        .of_constraints()
        .packed(Packing::Contacts);
    /// Joint forces and contact wrenches of accelerations.
    ConstrainedInverseDynamics "constrained_inverse_dynamics" = Row::one(
        &[Q, QD, QDD, CONTACTS, SETTINGS],
        shapes::constrained_torques,
        "Returns the joint forces of the accelerations `qdd`, the wrenches of the active contacts that carry the\n\
         floating bases, and the rank of the contacts' columns of the bases. The wrenches have the smallest sum\n\
         of (force^2 + (moment / l)^2) / weight with the characteristic length l of each contact. The joint\n\
         forces of a base are the wrench on it that no contact can carry. The wrenches of loop constraints are\n\
         zero.",
        |t, s| t.constrained_inverse_dynamics(&s.layout),
        |m| {
            3300.0 * m.carried
                + 57_000.0 * m.bases.powi(2)
                + 300.0 * m.reach
                + 150.0 * m.row_reach
        },
    )
        .of_constraints();
    /// The Jacobian of the constraints.
    ConstraintJacobian "constraint_jacobian" = Row::one(
        &[Q],
        shapes::constraint_jacobian,
        "Returns the Jacobian of each constraint, an array of columns. The product with `qd` is, for a loop\n\
         constraint, the constrained part of the twist of its second frame relative to its first, in the first\n\
         frame's axes; for a contact, active or not, the constrained part of its frame's twist in world axes.",
        |t, s| t.constraint_jacobian(&s.layout),
        |m| 1200.0 * m.reach + 45.0 * m.row_reach,
    )
        .of_constraints()
        .without_parameters();
    /// The bias acceleration of the constraints.
    ConstraintBiasAcceleration "constraint_bias_acceleration" = Row::one(
        &[Q, QD],
        shapes::constraint_twists,
        "Returns the bias acceleration of each constraint: the time derivative of `constraint_jacobian` times\n\
         `qd`, in the same axes.",
        |t, _| t.constraint_bias_acceleration(),
        |m| 800.0 * m.reach + 50.0 * m.row_reach,
    )
        .of_constraints()
        .without_parameters();
    /// The operational-space inertia of the constraints.
    OperationalInertia "operational_inertia" = Row::one(
        &[Q, CONTACTS, SETTINGS],
        shapes::operational_inertia,
        "Returns the operational-space inertia of the constraints, its inverse J M^-1 J^T with the mass matrix M,\n\
         and the number of independent constraint rows. Both matrices are arrays of columns; each constraint has\n\
         its constrained rotations, then its constrained displacements, of a contact in world axes. The entries\n\
         of inactive contacts are zero. The inverse contains the compliance.",
        |t, s| t.operational_inertia(&s.layout),
        |m| {
            140.0 * m.squares
                + 950.0 * m.reach
                + 1200.0 * m.row_reach
                + 55.0 * m.constraint_rows.powi(2) * m.nv
                + 170.0 * m.constraint_rows.powi(3)
        },
    )
        .of_constraints()
        .packed(Packing::ConstrainedColumns);
    /// The regressor of inverse dynamics.
    Regressor "regressor" = Row::one(
        &[Q, QD, QDD],
        shapes::regressor,
        "Returns the regressor Y of inverse dynamics, an array of columns: tau = Y pi, without rotors and\n\
         friction. pi has ten entries for each moving link: mass, mass times centre of mass x, y, z, and\n\
         Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the link's origin in the link's own axes (`PARAMETERS`).",
        |t, _| t.regressor(),
        |m| 2200.0 * m.depths + 120.0 * m.squares + 60.0 * m.entries,
    );
    /// The centre of mass.
    CenterOfMass "center_of_mass" = Row::one(
        &[Q],
        shapes::point,
        "Returns the centre of mass of the moving links in world axes, m.",
        |t, _| t.center_of_mass(),
        |m| 600.0 * m.links,
    )
        .result_named("position")
        .by_default();
    /// The Jacobian of the centre of mass.
    CenterOfMassJacobian "center_of_mass_jacobian" = Row::one(
        &[Q],
        shapes::vectors3,
        "Returns the Jacobian of the centre of mass, an array of columns. Its product with `qd` is the velocity\n\
         of the centre of mass in world axes.",
        |t, _| t.center_of_mass_jacobian(),
        |m| 1200.0 * m.links,
    )
        .result_named("jacobian");
    /// The centroidal momentum matrix.
    CentroidalMomentumMatrix "centroidal_momentum_matrix" = Row::one(
        &[Q],
        shapes::momenta,
        "Returns the centroidal momentum matrix, an array of columns. Its product with `qd` is the momentum about\n\
         the centre of mass, in world axes. Rotors have energy, but no momentum: their axes are not described.",
        |t, _| t.centroidal_momentum_matrix(),
        |m| 4000.0 * m.links,
    )
        .result_named("momentum_matrix");
    /// The momentum about the centre of mass.
    CentroidalMomentum "centroidal_momentum" = Row::one(
        &[Q, QD],
        shapes::momentum,
        "Returns the momentum of the moving links about their centre of mass, in world axes. Rotors have energy, but no\n\
         momentum: their axes are not described.",
        |t, _| t.centroidal_momentum(),
        |m| 3200.0 * m.links,
    )
        .result_named("momentum");
    /// The time derivative of the momentum about the centre of mass.
    CentroidalMomentumRate "centroidal_momentum_rate" = Row::one(
        &[Q, QD, QDD],
        shapes::momentum,
        "Returns the time derivative of the centroidal momentum in world axes: the moment (N m) and the force (N) about the\n\
         centre of mass of gravity and of all forces from outside. At `qdd` = 0 it is the bias A' qd, with the centroidal\n\
         momentum matrix A.",
        |t, _| t.centroidal_momentum_rate(),
        |m| 6400.0 * m.links,
    )
        .result_named("momentum_rate");
    /// The momentum about the centre of mass, its time derivative, and the derivatives of both.
    CentroidalMomentumDerivatives "centroidal_momentum_derivatives" = Row::one(
        &[Q, QD, QDD],
        shapes::centroidal_derivatives,
        "Returns the momentum of the moving links about their centre of mass, its time derivative at `qdd` (the rate), and the\n\
         derivatives of both with respect to `q` (in tangent space) and `qd`, arrays of columns, in world axes. The derivatives\n\
         of the momentum with respect to `qd`, and of the rate with respect to `qdd`, are the centroidal momentum matrix.",
        |t, _| t.centroidal_momentum_derivatives(),
        |m| 24_000.0 * m.links,
    )
        .result_named("derivatives");
    /// Poses of all links.
    LinkPoses "link_poses" = Row::new(
        &[Q],
        shapes::poses,
        "Returns the poses in the world of all links of the description, fixed links included, in the order of\n\
         `LINK_NAMES`.",
        Trace::Poses,
        |m| 1500.0 * (m.links + m.frames - m.rows) + 250.0 * m.rows,
    )
        .by_default()
        .without_parameters();
    /// The pose of a link.
    LinkPose "link_pose" = Row::by_link(
        &[Q],
        shapes::pose,
        "Returns the pose of a link in the world. Computes the link's kinematic path only.",
        |t| t.link_pose(0),
        |m| m.of_links(1400.0, 600.0),
    )
        .result_named("pose")
        .in_bundles(|t| t.link_pose_from_world(0))
        .by_default()
        .without_parameters();
    /// The velocity of a link, in world axes.
    LinkVelocity "link_velocity" = Row::by_link(
        &[Q, QD],
        shapes::twist,
        "Returns the velocity of a link's origin (m/s) and its angular velocity (rad/s), in world axes.\n\
         Computes the link's kinematic path only.",
        |t| t.link_velocity(0, Axes::World),
        |m| m.of_links(1300.0, 300.0),
    )
        .result_named("velocity")
        .without_parameters();
    /// The velocity of a link, in its own axes.
    LocalLinkVelocity "local_link_velocity" = Row::by_link(
        &[Q, QD],
        shapes::twist,
        "Returns the velocity of a link's origin (m/s) and its angular velocity (rad/s), in the link's own axes.\n\
         Computes the link's kinematic path only.",
        |t| t.link_velocity(0, Axes::Link),
        |m| m.of_links(1300.0, 300.0),
    )
        .result_named("velocity")
        .without_parameters();
    /// The acceleration of a link, in world axes.
    LinkAcceleration "link_acceleration" = Row::by_link(
        &[Q, QD, QDD],
        shapes::twist,
        "Returns the classical acceleration of a link's origin (m/s^2) and its angular acceleration (rad/s^2), in\n\
         world axes. Gravity is not included. Computes the link's kinematic path only.",
        |t| t.link_acceleration(0, Axes::World),
        |m| m.of_links(2100.0, 300.0),
    )
        .result_named("acceleration")
        .in_bundles(|t| t.link_acceleration_from_world(0))
        .without_parameters();
    /// The acceleration of a link, in its own axes.
    LocalLinkAcceleration "local_link_acceleration" = Row::by_link(
        &[Q, QD, QDD],
        shapes::twist,
        "Returns the classical acceleration of a link's origin (m/s^2) and its angular acceleration (rad/s^2), in\n\
         the link's own axes. Gravity is not included. Computes the link's kinematic path only.",
        |t| t.link_acceleration(0, Axes::Link),
        |m| m.of_links(2100.0, 300.0),
    )
        .result_named("acceleration")
        .without_parameters();
    /// The Jacobian of a link, in world axes.
    Jacobian "jacobian" = Row::by_link(
        &[Q],
        shapes::twists,
        "Returns the Jacobian of a link, an array of columns. Its product with `qd` is the velocity of the link\n\
         at its origin, in world axes. Computes the link's kinematic path only.",
        |t| t.jacobian(0, Axes::World),
        |m| m.of_links(1600.0, 150.0 * m.nv),
    )
        .by_default()
        .without_parameters();
    /// The Jacobian of a link, in its own axes.
    LocalJacobian "local_jacobian" = Row::by_link(
        &[Q],
        shapes::twists,
        "Returns the Jacobian of a link, an array of columns. Its product with `qd` is the velocity of the link\n\
         at its origin, in the link's own axes. Computes the link's kinematic path only.",
        |t| t.jacobian(0, Axes::Link),
        |m| m.of_links(1600.0, 150.0 * m.nv),
    )
        .result_named("jacobian")
        .without_parameters();
    /// The time derivative of the Jacobian of a link, in world axes.
    JacobianTimeDerivative "jacobian_time_derivative" = Row::by_link(
        &[Q, QD],
        shapes::twists,
        "Returns the time derivative of `jacobian`, an array of columns. Its product with `qd` is `bias_acceleration`.\n\
         Computes the link's kinematic path only.",
        |t| t.jacobian_time_derivative(0, Axes::World),
        |m| m.of_links(4500.0, 150.0 * m.nv),
    )
        .without_parameters();
    /// The time derivative of the Jacobian of a link, in its own axes.
    LocalJacobianTimeDerivative "local_jacobian_time_derivative" = Row::by_link(
        &[Q, QD],
        shapes::twists,
        "Returns the time derivative of `local_jacobian`, an array of columns. Its product with `qd` is\n\
         `local_bias_acceleration`. Computes the link's kinematic path only.",
        |t| t.jacobian_time_derivative(0, Axes::Link),
        |m| m.of_links(4500.0, 150.0 * m.nv),
    )
        .without_parameters();
    /// The bias acceleration of a link, in world axes.
    BiasAcceleration "bias_acceleration" = Row::by_link(
        &[Q, QD],
        shapes::twist,
        "Returns the bias acceleration of a link in world axes: the time derivative of `jacobian` times `qd`, which\n\
         is the link's acceleration at zero joint accelerations. Computes the link's kinematic path only.",
        |t| t.bias_acceleration(0, Axes::World),
        |m| m.of_links(1900.0, 300.0),
    )
        .result_named("acceleration")
        .in_bundles(|t| t.bias_acceleration_from_world(0))
        .without_parameters();
    /// The bias acceleration of a link, in its own axes.
    LocalBiasAcceleration "local_bias_acceleration" = Row::by_link(
        &[Q, QD],
        shapes::twist,
        "Returns the bias acceleration of a link in its own axes: the time derivative of `local_jacobian` times\n\
         `qd`. Computes the link's kinematic path only.",
        |t| t.bias_acceleration(0, Axes::Link),
        |m| m.of_links(1900.0, 300.0),
    )
        .result_named("acceleration")
        .without_parameters();
    /// Coordinates after a displacement.
    Integrate "integrate" = Row::one(
        &[Q, V],
        shapes::coordinates,
        "Returns the coordinates after the displacement `v` (a velocity times a time) from `q`.",
        |t, _| t.integrate(),
        |m| 100.0 * m.links,
    )
        .result_named("q_next")
        .by_default()
        .without_parameters();
    /// The displacement between coordinates.
    Difference "difference" = Row::one(
        &[FROM, TO],
        shapes::velocities,
        "Returns the displacement `v` with which `integrate` leads from `from` to `to`. Rotations are the shortest\n\
         ones; joint angles are not wrapped.",
        |t, _| t.difference(),
        |m| 100.0 * m.links,
    )
        .result_named("displacement")
        .by_default()
        .without_parameters();
    /// Derivatives of coordinates after a displacement.
    IntegrateDerivatives "integrate_derivatives" = Row::one(
        &[Q, V],
        shapes::integrate_derivatives,
        "Returns the derivatives of `integrate` with respect to `q` and `v`, each an array of columns in tangent\n\
         space: displacements of `q` and of the result are in the axes at each of them.",
        |t, _| t.integrate_derivatives(),
        |m| 100.0 * m.links + 30.0 * m.nv.powi(2),
    )
        .without_parameters();
    /// Derivatives of the displacement between coordinates.
    DifferenceDerivatives "difference_derivatives" = Row::one(
        &[FROM, TO],
        shapes::difference_derivatives,
        "Returns the derivatives of `difference` with respect to `from` and `to`, each an array of columns in\n\
         tangent space: displacements are in the axes at `from` and at `to`.",
        |t, _| t.difference_derivatives(),
        |m| 100.0 * m.links + 30.0 * m.nv.powi(2),
    )
        .without_parameters();
    /// The rates of the coordinates.
    VelocityToQdot "velocity_to_qdot" = Row::one(
        &[Q, QD],
        shapes::coordinates,
        "Returns dq/dt, the rates of the coordinates `q` at the velocities `qd`.",
        |t, _| t.velocity_to_qdot(),
        |m| 100.0 * m.links,
    )
        .result_named("qdot")
        .by_default()
        .without_parameters();
    /// Coordinates with quaternions of length 1.
    Normalize "normalize" = Row::one(
        &[Q],
        shapes::coordinates,
        "Returns the coordinates with quaternions scaled to length 1.",
        |t, _| t.normalize(),
        |m| 100.0 * m.links,
    )
        .result_named("unit_q")
        .by_default()
        .without_parameters();
    /// Random coordinates within the limits.
    Random "random" = Row::one(
        &[UNIFORMS],
        shapes::coordinates,
        "Returns coordinates within the joint limits, from random numbers uniformly distributed in [0, 1). Angles\n\
         without limits are in [-pi, pi), displacements without limits in [-1, 1) m, rotations uniform over SO(3).",
        |t, _| t.random(),
        |m| 200.0 * m.links,
    )
        .of_random_numbers()
        .by_default()
        .without_parameters()
        .not_exported();
    /// `forward_dynamics` of many states at a time.
    ForwardDynamicsBatch "forward_dynamics_batch" =
        Row::many(ForwardDynamics, Function::ForwardDynamics);
    /// `inverse_dynamics` of many states at a time.
    InverseDynamicsBatch "inverse_dynamics_batch" =
        Row::many(InverseDynamics, Function::InverseDynamics);
    /// `bias_forces` of many states at a time.
    BiasForcesBatch "bias_forces_batch" =
        Row::many(BiasForces, Function::BiasForces);
    /// `gravity_torques` of many states at a time.
    GravityTorquesBatch "gravity_torques_batch" =
        Row::many(GravityTorques, Function::GravityTorques);
    /// `mass_matrix` of many states at a time.
    MassMatrixBatch "mass_matrix_batch" =
        Row::many(MassMatrix, Function::MassMatrix);
    /// `kinetic_energy` of many states at a time.
    KineticEnergyBatch "kinetic_energy_batch" =
        Row::many(KineticEnergy, Function::KineticEnergy);
    /// `potential_energy` of many states at a time.
    PotentialEnergyBatch "potential_energy_batch" =
        Row::many(PotentialEnergy, Function::PotentialEnergy);
    /// `brge` of many states at a time.
    BrgeBatch "brge_batch" =
        Row::many(Brge, Function::Brge);
    /// `inverse_dynamics_derivatives` of many states at a time.
    InverseDynamicsDerivativesBatch "inverse_dynamics_derivatives_batch" =
        Row::many(InverseDynamicsDerivatives, Function::InverseDynamicsDerivatives);
    /// `forward_dynamics_derivatives` of many states at a time.
    ForwardDynamicsDerivativesBatch "forward_dynamics_derivatives_batch" =
        Row::many(ForwardDynamicsDerivatives, Function::ForwardDynamicsDerivatives);
    /// `inverse_dynamics_hessian` of many states at a time.
    InverseDynamicsHessianBatch "inverse_dynamics_hessian_batch" =
        Row::many(InverseDynamicsHessian, Function::InverseDynamicsHessian);
    /// `forward_dynamics_hessian` of many states at a time.
    ForwardDynamicsHessianBatch "forward_dynamics_hessian_batch" =
        Row::many(ForwardDynamicsHessian, Function::ForwardDynamicsHessian);
    /// `constrained_forward_dynamics` of many states at a time.
    ConstrainedForwardDynamicsBatch "constrained_forward_dynamics_batch" =
        Row::many(ConstrainedForwardDynamics, Function::ConstrainedForwardDynamics);
    /// `constrained_forward_dynamics_derivatives` of many states at a time.
    ConstrainedForwardDynamicsDerivativesBatch "constrained_forward_dynamics_derivatives_batch" =
        Row::many(
            ConstrainedForwardDynamicsDerivatives,
            Function::ConstrainedForwardDynamicsDerivatives,
        );
    /// `contact_impulse` of many states at a time.
    ContactImpulseBatch "contact_impulse_batch" =
        Row::many(ContactImpulse, Function::ContactImpulse);
    /// `constrained_inverse_dynamics` of many states at a time.
    ConstrainedInverseDynamicsBatch "constrained_inverse_dynamics_batch" =
        Row::many(ConstrainedInverseDynamics, Function::ConstrainedInverseDynamics);
    /// `constraint_residual` of many states at a time.
    ConstraintResidualBatch "constraint_residual_batch" =
        Row::many(ConstraintResidual, Function::ConstraintResidual);
    /// `project_constraints` of many states at a time.
    ProjectConstraintsBatch "project_constraints_batch" =
        Row::many(ProjectConstraints, Function::ProjectConstraints);
    /// `constraint_jacobian` of many states at a time.
    ConstraintJacobianBatch "constraint_jacobian_batch" =
        Row::many(ConstraintJacobian, Function::ConstraintJacobian);
    /// `constraint_bias_acceleration` of many states at a time.
    ConstraintBiasAccelerationBatch "constraint_bias_acceleration_batch" =
        Row::many(ConstraintBiasAcceleration, Function::ConstraintBiasAcceleration);
    /// `operational_inertia` of many states at a time.
    OperationalInertiaBatch "operational_inertia_batch" =
        Row::many(OperationalInertia, Function::OperationalInertia);
}
