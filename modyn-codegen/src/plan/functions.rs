//! The table of functions: all that the compiler knows about each, in one row.
//!
//! The row drives the selection, the tracer, batches, the printers, the command line's comparison and the table in
//! `docs/functions.md`.

use modyn_runtime::equations::kinematics::Axes;

use super::Tracing;
use super::packing::Packing;
use super::shape::{Shape, Sizes, shapes};
use crate::diagnostics::suggest;
use crate::graph::Graph;
use crate::trace::Tracer;

/// What the compiler knows about a function.
#[derive(Clone, Copy)]
pub struct Row {
    /// The arguments.
    pub arguments: &'static [Argument],
    /// The layout of the result.
    pub result: fn(&Sizes) -> Shape,
    /// How its graphs are traced.
    pub trace: Trace,
    /// The lines of its documentation.
    pub docs: &'static str,
    /// Whether a robot has it unless others are chosen.
    pub default: bool,
    /// Whether only robots with closed loops or contacts have it.
    pub of_constraints: bool,
    /// Whether only robots without closed loops have it.
    pub without_loops: bool,
    /// Whether run-time parameters of the robot (gravity, inertia of links) can matter to it.
    pub depends_on_parameters: bool,
    /// Whether it is called so often that it is compiled for several instruction sets.
    pub hot: bool,
    /// How it is packed into vectors.
    pub packing: Packing,
    /// The function that it computes for many states at a time.
    pub batch_of: Option<Function>,
}

/// How the graphs of a function are traced.
#[derive(Clone, Copy)]
pub enum Trace {
    /// One graph.
    One(fn(&Tracer<'_>, &Tracing<'_>) -> Graph),
    /// A graph for a link, of a tracer that has this link alone; some links share one.
    ByLink(fn(&Tracer<'_>) -> Graph),
    /// The poses of all links.
    Poses,
}

/// An argument.
#[derive(Clone, Copy)]
pub struct Argument {
    /// Its name.
    pub name: &'static str,
    /// Its layout.
    pub shape: fn(&Sizes) -> Shape,
}

const fn argument(name: &'static str, shape: fn(&Sizes) -> Shape) -> Argument {
    Argument { name, shape }
}

const Q: Argument = argument("q", shapes::coordinates);
const QD: Argument = argument("qd", shapes::velocities);
const QDD: Argument = argument("qdd", shapes::velocities);
const TAU: Argument = argument("tau", shapes::velocities);
const V: Argument = argument("v", shapes::velocities);
const FROM: Argument = argument("from", shapes::coordinates);
const TO: Argument = argument("to", shapes::coordinates);
const FORCES: Argument = argument("forces", shapes::wrenches);
const SETTINGS: Argument = argument("settings", shapes::settings);
const CONTACTS: Argument = argument("contacts", shapes::contacts);
const UNIFORMS: Argument = argument("uniforms", shapes::velocities);

impl Row {
    const fn new(
        arguments: &'static [Argument],
        result: fn(&Sizes) -> Shape,
        trace: Trace,
        docs: &'static str,
    ) -> Self {
        Self {
            arguments,
            result,
            trace,
            docs,
            default: false,
            of_constraints: false,
            without_loops: false,
            depends_on_parameters: true,
            hot: false,
            packing: Packing::Never,
            batch_of: None,
        }
    }

    /// A function of one graph.
    const fn one(
        arguments: &'static [Argument],
        result: fn(&Sizes) -> Shape,
        docs: &'static str,
        trace: fn(&Tracer<'_>, &Tracing<'_>) -> Graph,
    ) -> Self {
        Self::new(arguments, result, Trace::One(trace), docs)
    }

    /// A function of a link.
    const fn by_link(
        arguments: &'static [Argument],
        result: fn(&Sizes) -> Shape,
        docs: &'static str,
        trace: fn(&Tracer<'_>) -> Graph,
    ) -> Self {
        Self::new(arguments, result, Trace::ByLink(trace), docs)
    }

    /// A function of many states at a time.
    const fn many(one: Self, function: Function) -> Self {
        Self {
            default: false,
            packing: Packing::Never,
            hot: false,
            batch_of: Some(function),
            ..one
        }
    }

    const fn by_default(self) -> Self {
        Self { default: true, ..self }
    }

    const fn of_constraints(self) -> Self {
        Self { of_constraints: true, ..self }
    }

    const fn without_loops(self) -> Self {
        Self { without_loops: true, ..self }
    }

    const fn without_parameters(self) -> Self {
        Self { depends_on_parameters: false, ..self }
    }

    const fn hot(self) -> Self {
        Self { hot: true, ..self }
    }

    const fn packed(self, packing: Packing) -> Self {
        Self { packing, ..self }
    }
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
            /// All, in the order in which generated code has them.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// Its name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            /// Its row of the table.
            #[must_use]
            pub const fn row(self) -> Row {
                match self {
                    $(Self::$variant => rows::$variant,)*
                }
            }
        }

        /// The rows, by function.
        #[allow(non_upper_case_globals)]
        mod rows {
            use super::*;

            $(pub(super) const $variant: Row = $row;)*
        }
    };
}

functions! {
    /// Accelerations under torques.
    ForwardDynamics "forward_dynamics" = Row::one(
        &[Q, QD, TAU],
        shapes::velocities,
        "Joint accelerations (rad/s^2 or m/s^2) at coordinates `q` and velocities `qd` under the joint\n\
         torques or forces `tau` (N m or N), gravity included: block reverse Gaussian elimination of the\n\
         generalized inertia matrix by inter- and intra-modular recursion.",
        |t, s| t.forward_dynamics(s.elimination),
    )
        .by_default()
        .packed(Packing::ByModules)
        .hot();
    /// Torques of accelerations.
    InverseDynamics "inverse_dynamics" = Row::one(
        &[Q, QD, QDD],
        shapes::velocities,
        "Joint torques or forces (N m or N) of the accelerations `qdd` at coordinates `q` and velocities\n\
         `qd`, gravity included: recursive Newton-Euler.",
        |t, _| t.inverse_dynamics(),
    )
        .by_default()
        .packed(Packing::Limbs)
        .hot();
    /// Coriolis, centrifugal and gravity torques.
    BiasForces "bias_forces" = Row::one(
        &[Q, QD],
        shapes::velocities,
        "Coriolis, centrifugal and gravity torques: inverse dynamics without acceleration.",
        |t, _| t.bias_forces(),
    )
        .by_default()
        .packed(Packing::Limbs)
        .hot();
    /// Torques at rest.
    GravityTorques "gravity_torques" = Row::one(
        &[Q],
        shapes::velocities,
        "Joint torques that hold the robot still at `q`.",
        |t, _| t.gravity_torques(),
    )
        .by_default()
        .packed(Packing::Limbs);
    /// The generalized inertia matrix.
    MassMatrix "mass_matrix" = Row::one(
        &[Q],
        shapes::square,
        "The generalized inertia matrix at `q`, an array of columns: by composite modules.",
        |t, _| t.mass_matrix(),
    )
        .by_default()
        .packed(Packing::OnRootPath)
        .hot();
    /// The generalized inertia matrix as U D U^T by modules.
    Brge "brge" = Row::one(
        &[Q],
        shapes::factors,
        "The generalized inertia matrix at `q` as U D U^T by kinematic modules: block reverse\n\
         Gaussian elimination.",
        |t, s| t.brge(s.layout),
    )
        .by_default();
    /// Kinetic energy.
    KineticEnergy "kinetic_energy" = Row::one(
        &[Q, QD],
        shapes::scalar,
        "Kinetic energy of the moving links (and rotors), J.",
        |t, _| t.kinetic_energy(),
    )
        .by_default();
    /// Potential energy.
    PotentialEnergy "potential_energy" = Row::one(
        &[Q],
        shapes::scalar,
        "Potential energy of the moving links under gravity, J; zero at the world's origin.",
        |t, _| t.potential_energy(),
    )
        .by_default();
    /// Forward dynamics with wrenches on links, in the links' axes.
    ForwardDynamicsExternal "forward_dynamics_external" = Row::one(
        &[Q, QD, TAU, FORCES],
        shapes::velocities,
        "Forward dynamics with a wrench on each link (in the order of `LINK_NAMES`) at the link's\n\
         origin in its own axes.",
        |_, s| s.all_links.forward_dynamics_external(s.elimination, Axes::Link),
    );
    /// Forward dynamics with wrenches on links, in the world's axes.
    ForwardDynamicsExternalWorld "forward_dynamics_external_world" = Row::one(
        &[Q, QD, TAU, FORCES],
        shapes::velocities,
        "Forward dynamics with a wrench on each link (in the order of `LINK_NAMES`) at the link's\n\
         origin in the world's axes.",
        |_, s| s.all_links.forward_dynamics_external(s.elimination, Axes::World),
    );
    /// Inverse dynamics with wrenches on links, in the links' axes.
    InverseDynamicsExternal "inverse_dynamics_external" = Row::one(
        &[Q, QD, QDD, FORCES],
        shapes::velocities,
        "Inverse dynamics with a wrench on each link (in the order of `LINK_NAMES`) at the link's\n\
         origin in its own axes.",
        |_, s| s.all_links.inverse_dynamics_external(Axes::Link),
    );
    /// Inverse dynamics with wrenches on links, in the world's axes.
    InverseDynamicsExternalWorld "inverse_dynamics_external_world" = Row::one(
        &[Q, QD, QDD, FORCES],
        shapes::velocities,
        "Inverse dynamics with a wrench on each link (in the order of `LINK_NAMES`) at the link's\n\
         origin in the world's axes.",
        |_, s| s.all_links.inverse_dynamics_external(Axes::World),
    );
    /// Derivatives of inverse dynamics.
    InverseDynamicsDerivatives "inverse_dynamics_derivatives" = Row::one(
        &[Q, QD, QDD],
        shapes::inverse_derivatives,
        "The derivatives of the inverse dynamics by `q` (in tangent space) and `qd`, each an array of\n\
         columns; the one by `qdd` is the mass matrix.",
        |t, _| t.inverse_dynamics_derivatives(),
    )
        .packed(Packing::Derivatives)
        .hot();
    /// Derivatives of forward dynamics.
    ForwardDynamicsDerivatives "forward_dynamics_derivatives" = Row::one(
        &[Q, QD, TAU],
        shapes::forward_derivatives,
        "The derivatives of the forward dynamics by `q` (in tangent space), `qd` and `tau`, each an\n\
         array of columns, with the accelerations.",
        |t, s| t.forward_dynamics_derivatives(s.for_derivatives),
    )
        .packed(Packing::Derivatives)
        .hot();
    /// Forward dynamics with the loops closed and contacts held.
    ConstrainedForwardDynamics "constrained_forward_dynamics" = Row::one(
        &[Q, QD, TAU, CONTACTS, SETTINGS],
        shapes::constrained,
        "Joint accelerations under the joint torques or forces `tau` with the loops closed and the active\n\
         contacts held; for each loop constraint (in the order of `LOOP_CONSTRAINT_NAMES`) the wrench on its\n\
         second link and the part of its acceleration that could not be met, at the second frame's origin\n\
         in the first frame's axes; then for each contact (in the order of `CONTACT_NAMES`) the same at the\n\
         frame's origin in world axes; and the number of independent constraint rows. Redundant constraints\n\
         share their forces.",
        |t, s| t.constrained_forward_dynamics(s.layout),
    )
        .by_default()
        .of_constraints();
    /// How well the constraints are met.
    ConstraintResidual "constraint_residual" = Row::one(
        &[Q, QD, SETTINGS],
        shapes::constraint_residual,
        "How far the second frame of each loop constraint is displaced from the first, and its relative\n\
         velocity, in the first frame's axes, without the free directions; then the same of the frame of\n\
         each contact, active or not, relative to its target, in world axes. Rotations are given by their\n\
         axes times the sines of their angles.",
        |t, s| t.constraint_residual(s.layout),
    )
        .by_default()
        .of_constraints()
        .without_parameters();
    /// The step that meets them.
    ProjectConstraints "project_constraints" = Row::one(
        &[Q, QD, CONTACTS, SETTINGS],
        shapes::constraint_projection,
        "The smallest step (in the metric of the mass matrix) that, to first order, closes the loops at\n\
         `q` and puts the active contacts on their targets, the smallest change of `qd` that keeps them\n\
         there, and the number of independent constraint rows. Stabilization does not matter.",
        |t, s| t.project_constraints(s.layout),
    )
        .by_default()
        .of_constraints();
    /// Derivatives of forward dynamics on contacts.
    ConstrainedForwardDynamicsDerivatives "constrained_forward_dynamics_derivatives" = Row::one(
        &[Q, QD, TAU, CONTACTS, SETTINGS],
        shapes::constrained_derivatives,
        "The accelerations and the wrenches of `constrained_forward_dynamics` and their derivatives by `q` (in\n\
         tangent space), `qd` and `tau`, each an array of columns; those of wrenches for each constraint, in\n\
         world axes. Where rows are redundant, the derivatives of the wrenches are the smallest that the\n\
         derivatives of the equations allow. For robots with contacts and without loops.",
        |t, s| t.constrained_forward_dynamics_derivatives(s.layout),
    )
        .of_constraints()
        .without_loops();
    /// The velocities after an impact.
    ContactImpulse "contact_impulse" = Row::one(
        &[Q, QD, CONTACTS, SETTINGS],
        shapes::contact_impulse,
        "The velocities after an impact that closes the loops and puts the active contacts at rest relative to\n\
         their targets at once, with the impulse of each constraint and the number of independent constraint\n\
         rows. Along its normal, a contact leaves with its share `restitution` of the speed that it arrived\n\
         with. Stabilization does not matter.",
        |t, s| t.contact_impulse(s.layout),
    )
        .of_constraints();
    /// Torques and contact wrenches of accelerations.
    ConstrainedInverseDynamics "constrained_inverse_dynamics" = Row::one(
        &[Q, QD, QDD, CONTACTS, SETTINGS],
        shapes::constrained_torques,
        "The joint torques or forces of the accelerations `qdd`, and the wrenches of the active contacts that\n\
         carry the floating bases: of all that do, those with the smallest sum of\n\
         (force^2 + (moment / l)^2) / weight. The torques of a base are the force on it that no contact can\n\
         carry. Loop constraints carry nothing. The rank is that of the contacts' columns of the bases.",
        |t, s| t.constrained_inverse_dynamics(s.layout),
    )
        .of_constraints();
    /// The Jacobian of the constraints.
    ConstraintJacobian "constraint_jacobian" = Row::one(
        &[Q],
        shapes::constraint_jacobian,
        "The Jacobian of the constraints, for each constraint an array of columns: of a loop constraint the\n\
         constrained part of the twist of its second frame relative to its first, in the first frame's axes;\n\
         of a contact, active or not, that of its frame in world axes.",
        |t, s| t.constraint_jacobian(s.layout),
    )
        .of_constraints()
        .without_parameters();
    /// The time derivative of the Jacobian of the constraints, times the velocities.
    ConstraintBiasAcceleration "constraint_bias_acceleration" = Row::one(
        &[Q, QD],
        shapes::constraint_twists,
        "The time derivative of `constraint_jacobian`, times `qd`: for each constraint the acceleration of\n\
         its frames without joint accelerations, in the same axes.",
        |t, _| t.constraint_bias_acceleration(),
    )
        .of_constraints()
        .without_parameters();
    /// The operational-space inertia of the constraints.
    OperationalInertia "operational_inertia" = Row::one(
        &[Q, CONTACTS, SETTINGS],
        shapes::operational_inertia,
        "The operational-space inertia of the constraints and its inverse J I^-1 J^T, arrays of columns with a\n\
         row for each constraint row: of each constraint the constrained rotations, then displacements, of a\n\
         contact in world axes. Those of inactive contacts are zero; compliance is part of the inverse.",
        |t, s| t.operational_inertia(s.layout),
    )
        .of_constraints();
    /// The regressor of inverse dynamics.
    Regressor "regressor" = Row::one(
        &[Q, QD, QDD],
        shapes::regressor,
        "The regressor Y of the inverse dynamics, an array of columns: tau = Y pi (rotors and friction\n\
         apart), where pi holds ten numbers a moving link: mass, mass times centre of mass x, y, z, and\n\
         Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the link's origin in its own axes (`PARAMETERS`).",
        |t, _| t.regressor(),
    );
    /// The centre of mass.
    CenterOfMass "center_of_mass" = Row::one(
        &[Q],
        shapes::point,
        "The centre of mass of the moving links in the world, m.",
        |t, _| t.center_of_mass(),
    )
        .by_default();
    /// The derivative of the centre of mass.
    CenterOfMassJacobian "center_of_mass_jacobian" = Row::one(
        &[Q],
        shapes::vectors3,
        "The derivative of the centre of mass, an array of columns: its velocity is this times `qd`.",
        |t, _| t.center_of_mass_jacobian(),
    );
    /// The centroidal momentum matrix.
    CentroidalMomentumMatrix "centroidal_momentum_matrix" = Row::one(
        &[Q],
        shapes::momenta,
        "The centroidal momentum matrix, an array of columns: this times `qd` is the momentum about the\n\
         centre of mass, in world axes.",
        |t, _| t.centroidal_momentum_matrix(),
    );
    /// The momentum about the centre of mass.
    CentroidalMomentum "centroidal_momentum" = Row::one(
        &[Q, QD],
        shapes::momentum,
        "The momentum of the moving links about their centre of mass, in world axes.",
        |t, _| t.centroidal_momentum(),
    );
    /// Poses of all links.
    LinkPoses "link_poses" = Row::new(
        &[Q],
        shapes::poses,
        Trace::Poses,
        "The poses in the world of all links of the description, fixed ones too, in the order of\n\
         `LINK_NAMES`.",
    )
        .by_default()
        .without_parameters();
    /// The pose of a link.
    LinkPose "link_pose" = Row::by_link(
        &[Q],
        shapes::pose,
        "The pose of a link in the world; computes its chain alone.",
        |t| t.link_pose(0),
    )
        .by_default()
        .without_parameters();
    /// The velocity of a link, in world axes.
    LinkVelocity "link_velocity" = Row::by_link(
        &[Q, QD],
        shapes::twist,
        "The velocity of a link's origin (m/s) and its angular velocity (rad/s), in world axes;\n\
         computes its chain alone.",
        |t| t.link_velocity(0, Axes::World),
    )
        .without_parameters();
    /// The velocity of a link, in its own axes.
    LocalLinkVelocity "local_link_velocity" = Row::by_link(
        &[Q, QD],
        shapes::twist,
        "The velocity of a link's origin (m/s) and its angular velocity (rad/s), in its own axes;\n\
         computes its chain alone.",
        |t| t.link_velocity(0, Axes::Link),
    )
        .without_parameters();
    /// The acceleration of a link, in world axes.
    LinkAcceleration "link_acceleration" = Row::by_link(
        &[Q, QD, QDD],
        shapes::twist,
        "The (classical) acceleration of a link's origin (m/s^2), gravity left out, and its angular\n\
         acceleration (rad/s^2), in world axes; computes its chain alone.",
        |t| t.link_acceleration(0, Axes::World),
    )
        .without_parameters();
    /// The acceleration of a link, in its own axes.
    LocalLinkAcceleration "local_link_acceleration" = Row::by_link(
        &[Q, QD, QDD],
        shapes::twist,
        "The (classical) acceleration of a link's origin (m/s^2), gravity left out, and its angular\n\
         acceleration (rad/s^2), in its own axes; computes its chain alone.",
        |t| t.link_acceleration(0, Axes::Link),
    )
        .without_parameters();
    /// The Jacobian of a link, in world axes.
    Jacobian "jacobian" = Row::by_link(
        &[Q],
        shapes::twists,
        "The Jacobian of a link, an array of columns: this times `qd` is its velocity at its origin, in\n\
         world axes; computes its chain alone.",
        |t| t.jacobian(0, Axes::World),
    )
        .by_default()
        .without_parameters();
    /// The Jacobian of a link, in its own axes.
    LocalJacobian "local_jacobian" = Row::by_link(
        &[Q],
        shapes::twists,
        "The Jacobian of a link, an array of columns: this times `qd` is its velocity at its origin, in\n\
         its own axes; computes its chain alone.",
        |t| t.jacobian(0, Axes::Link),
    )
        .without_parameters();
    /// The time derivative of the Jacobian times the velocities.
    JacobianRate "jacobian_rate" = Row::by_link(
        &[Q, QD],
        shapes::twist,
        "The time derivative of `jacobian`, times `qd`: the link's (classical) acceleration without\n\
         joint accelerations, in world axes; computes its chain alone.",
        |t| t.jacobian_rate(0, Axes::World),
    )
        .without_parameters();
    /// The time derivative of the local Jacobian times the velocities.
    LocalJacobianRate "local_jacobian_rate" = Row::by_link(
        &[Q, QD],
        shapes::twist,
        "The time derivative of `local_jacobian`, times `qd`: the rates of the components of the link's\n\
         velocity in its own axes; computes its chain alone.",
        |t| t.jacobian_rate(0, Axes::Link),
    )
        .without_parameters();
    /// Coordinates behind a displacement.
    Integrate "integrate" = Row::one(
        &[Q, V],
        shapes::coordinates,
        "The coordinates behind a displacement `v` (a velocity times a time) from `q`.",
        |t, _| t.integrate(),
    )
        .by_default()
        .without_parameters();
    /// The displacement between coordinates.
    Difference "difference" = Row::one(
        &[FROM, TO],
        shapes::velocities,
        "The displacement that leads from one to the other, by `integrate`: the shortest rotations;\n\
         angles of single joints are not wrapped.",
        |t, _| t.difference(),
    )
        .by_default()
        .without_parameters();
    /// Rates of the coordinates.
    CoordinateRates "coordinate_rates" = Row::one(
        &[Q, QD],
        shapes::coordinates,
        "The rates of the coordinates: dq/dt.",
        |t, _| t.coordinate_rates(),
    )
        .by_default()
        .without_parameters();
    /// Quaternions brought to unit length.
    Normalize "normalize" = Row::one(
        &[Q],
        shapes::coordinates,
        "The same coordinates, quaternions brought to unit length.",
        |t, _| t.normalize(),
    )
        .by_default()
        .without_parameters();
    /// Coordinates within the limits.
    Random "random" = Row::one(
        &[UNIFORMS],
        shapes::coordinates,
        "Coordinates within the joints' limits from numbers in [0, 1), evenly spread: angles without\n\
         limits in [-pi, pi), displacements without limits in [-1, 1), rotations of any direction.",
        |t, _| t.random(),
    )
        .by_default()
        .without_parameters();
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
}

/// The number of functions that are there by default.
const DEFAULTS: usize = {
    let (mut count, mut i) = (0, 0);
    while i < Function::ALL.len() {
        count += Function::ALL[i].row().default as usize;
        i += 1;
    }
    count
};

/// The functions that are there by default.
const DEFAULT: [Function; DEFAULTS] = {
    let (mut default, mut count, mut i) = ([Function::ForwardDynamics; DEFAULTS], 0, 0);
    while i < Function::ALL.len() {
        if Function::ALL[i].row().default {
            default[count] = Function::ALL[i];
            count += 1;
        }
        i += 1;
    }
    default
};

impl Function {
    /// The functions that a robot has unless others are chosen; a robot without constraints has none about them.
    pub const DEFAULT: &[Self] = &DEFAULT;

    /// The function that this one computes for many states at a time.
    #[must_use]
    pub const fn batched(self) -> Option<Self> {
        self.row().batch_of
    }

    /// Whether it is about constraints, so that only robots with closed loops or contacts have it.
    #[must_use]
    pub const fn is_of_constraints(self) -> bool {
        self.row().of_constraints
    }

    /// Whether a robot with so many constraints, of which so many are contacts, can have it.
    #[must_use]
    pub const fn fits(self, constraints: usize, contacts: usize) -> bool {
        let row = self.row();
        (constraints > 0 || !row.of_constraints) && (constraints == contacts || !row.without_loops)
    }

    /// Whether run-time parameters (gravity, inertias, payloads) can matter to it.
    #[must_use]
    pub const fn depends_on_parameters(self) -> bool {
        self.row().depends_on_parameters
    }

    /// The Rust functions that it becomes, by name, each with the number of its arguments (those of the robot's run-time
    /// parameters aside).
    pub(crate) fn signatures(self) -> Vec<(String, usize)> {
        let row = self.row();
        let inputs = row.arguments.len() + usize::from(matches!(row.trace, Trace::ByLink(_)));
        let Some(one) = row.batch_of else { return vec![(self.name().into(), inputs)] };
        // Over slices for each coordinate, each result is an argument; over slices of states they are one.
        let outputs = match (row.result)(&Sizes::default()) {
            Shape::Record(_, fields) => fields.len(),
            Shape::Scalar | Shape::Array(..) => 1,
        };
        let name = one.name();
        vec![(format!("{name}_batch"), inputs + outputs), (format!("{name}_each"), inputs + 1)]
    }

    /// The function of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|function| function.name() == name)
    }

    /// A message that there is no function of this name: with the one that was probably meant, else with all
    /// names, as the macro and the command line have them.
    #[must_use]
    pub fn unknown(name: &str) -> String {
        let names = || ["default", "all"].into_iter().chain(Self::ALL.iter().map(|one| one.name()));
        match suggest(name, names()) {
            Some(meant) => format!("there is no function `{name}`; did you mean `{meant}`?"),
            None => {
                let names: Vec<&str> = names().collect();
                format!("there is no function `{name}`; there are: {}", names.join(", "))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Function;

    #[test]
    fn a_function_is_suggested() {
        let said = Function::unknown("mas_matrix");
        assert_eq!(said, "there is no function `mas_matrix`; did you mean `mass_matrix`?");
        assert!(Function::unknown("foo").contains("there are: default, all, forward_dynamics, "));
    }
}
