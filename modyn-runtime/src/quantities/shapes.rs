//! The layouts of arguments and results, by name.

use alloc::{vec, vec::Vec};

use super::shape::{Record, Shape, Sizes};
use crate::model::PARAMETERS_PER_LINK;

/// A field of a record: its name and layout.
type Field = (&'static str, Shape);

pub fn scalar(_: &Sizes) -> Shape {
    Shape::Scalar
}

pub fn coordinates(s: &Sizes) -> Shape {
    Shape::vector(s.nq)
}

pub fn velocities(s: &Sizes) -> Shape {
    Shape::vector(s.nv)
}

pub fn square(s: &Sizes) -> Shape {
    Shape::matrix(s.nv, s.nv)
}

pub fn regressor(s: &Sizes) -> Shape {
    Shape::matrix(PARAMETERS_PER_LINK * s.moving, s.nv)
}

pub fn point(_: &Sizes) -> Shape {
    Shape::vector(3)
}

pub fn vectors3(s: &Sizes) -> Shape {
    Shape::vector3().columns(s.nv)
}

pub fn pose(_: &Sizes) -> Shape {
    Shape::pose()
}

pub fn poses(s: &Sizes) -> Shape {
    Shape::pose().array(s.links)
}

pub fn twist(_: &Sizes) -> Shape {
    Shape::twist()
}

pub fn twists(s: &Sizes) -> Shape {
    Shape::twist().columns(s.nv)
}

pub fn momentum(_: &Sizes) -> Shape {
    Shape::momentum()
}

pub fn inertia(_: &Sizes) -> Shape {
    Shape::momentum().columns(6)
}

pub fn momenta(s: &Sizes) -> Shape {
    Shape::momentum().columns(s.nv)
}

pub fn factors(s: &Sizes) -> Shape {
    Shape::Record(Record::Factorization, vec![("factors", Shape::vector(s.factors))])
}

pub fn inverse_derivatives(s: &Sizes) -> Shape {
    named_fields(
        "InverseDynamicsDerivatives",
        vec![("dtau_dq", square(s)), ("dtau_dqd", square(s))],
    )
}

pub fn forward_derivatives(s: &Sizes) -> Shape {
    let matrices = ["dqdd_dq", "dqdd_dqd", "dqdd_dtau"].map(|name| (name, square(s)));
    named_fields(
        "ForwardDynamicsDerivatives",
        [vec![("qdd", velocities(s))], matrices.into()].concat(),
    )
}

pub fn generalized_forces(s: &Sizes) -> Shape {
    named_fields("GeneralizedForces", vec![("tau", velocities(s)), ("dtau_dq", square(s))])
}

pub fn centroidal_derivatives(s: &Sizes) -> Shape {
    let fields = vec![
        ("momentum", momentum(s)),
        ("rate", momentum(s)),
        ("dmomentum_dq", momenta(s)),
        ("drate_dq", momenta(s)),
        ("drate_dqd", momenta(s)),
    ];
    named_fields("CentroidalMomentumDerivatives", fields)
}

pub fn integrate_derivatives(s: &Sizes) -> Shape {
    named_fields("IntegrateDerivatives", vec![("dq_dq", square(s)), ("dq_dv", square(s))])
}

pub fn difference_derivatives(s: &Sizes) -> Shape {
    named_fields("DifferenceDerivatives", vec![("dv_dfrom", square(s)), ("dv_dto", square(s))])
}

pub fn inverse_vjp(s: &Sizes) -> Shape {
    vectors("InverseDynamicsVjp", &["tau", "grad_q", "grad_qd", "grad_qdd"], s)
}

pub fn inverse_jvp(s: &Sizes) -> Shape {
    vectors("InverseDynamicsJvp", &["tau", "tangent_tau"], s)
}

pub fn forward_vjp(s: &Sizes) -> Shape {
    vectors("ForwardDynamicsVjp", &["qdd", "grad_q", "grad_qd", "grad_tau"], s)
}

pub fn forward_jvp(s: &Sizes) -> Shape {
    vectors("ForwardDynamicsJvp", &["qdd", "tangent_qdd"], s)
}

pub fn inverse_hessian(s: &Sizes) -> Shape {
    let matrices = ["hess_q_q", "hess_q_qd", "hess_qd_qd", "hess_q_qdd"];
    hessian("InverseDynamicsHessian", &["tau", "grad_q", "grad_qd", "grad_qdd"], &matrices, s)
}

pub fn forward_hessian(s: &Sizes) -> Shape {
    let matrices = ["hess_q_q", "hess_q_qd", "hess_qd_qd", "hess_q_tau"];
    hessian("ForwardDynamicsHessian", &["qdd", "grad_q", "grad_qd", "grad_tau"], &matrices, s)
}

pub fn step(s: &Sizes) -> Shape {
    Shape::Record(
        Record::ResultsByField("Step"),
        vec![("q", coordinates(s)), ("qd", velocities(s))],
    )
}

pub fn step_derivatives(s: &Sizes) -> Shape {
    let matrices = [("a", Shape::matrix(2 * s.nv, 2 * s.nv)), ("b", Shape::matrix(s.nv, 2 * s.nv))];
    let state = [("q", coordinates(s)), ("qd", velocities(s))];
    Shape::Record(Record::ResultsByField("StepDerivatives"), [state, matrices].concat())
}

pub fn knot(s: &Sizes) -> Shape {
    named_fields("Knot", [&[("qd", velocities(s))], &knot_matrices(s)[..]].concat())
}

/// The derivatives of a knot, by rows: of the velocities, then of the coordinates of each
/// quaternion.
fn knot_matrices(s: &Sizes) -> Vec<Field> {
    let of_velocities =
        ["dqd_dq", "dqd_dqd", "dqd_dtau"].map(|name| (name, velocities(s).rows(s.nv)));
    let block = || Shape::vector(6).rows(6).array(s.quaternions);
    let of_coordinates = ["dq_dq", "dq_dv"].map(|name| (name, block()));
    [&of_velocities[..], &of_coordinates].concat()
}

pub fn step_hessian(s: &Sizes) -> Shape {
    let fields = vec![
        ("q", coordinates(s)),
        ("qd", velocities(s)),
        ("grad_x", state(s)),
        ("grad_tau", velocities(s)),
        ("hess_x_x", Shape::matrix(2 * s.nv, 2 * s.nv)),
        ("hess_x_tau", Shape::matrix(s.nv, 2 * s.nv)),
        ("hess_tau_tau", square(s)),
    ];
    Shape::Record(Record::ResultsByField("StepHessian"), fields)
}

pub fn constrained(s: &Sizes) -> Shape {
    let fields = vec![
        ("qdd", velocities(s)),
        ("wrenches", constraint_wrenches(s)),
        ("residuals", constraint_twists(s)),
        ("rank", Shape::Scalar),
    ];
    named_fields("ConstrainedForwardDynamics", fields)
}

pub fn constraint_residual(s: &Sizes) -> Shape {
    let fields = ["displacements", "velocities"].map(|name| (name, constraint_twists(s)));
    named_fields("ConstraintResidual", fields.into())
}

pub fn constrained_derivatives(s: &Sizes) -> Shape {
    let matrices = ["dqdd_dq", "dqdd_dqd", "dqdd_dtau"].map(|name| (name, square(s)));
    let first = [("qdd", velocities(s)), ("wrenches", constraint_wrenches(s))];
    let rank = [("rank", Shape::Scalar)];
    let fields = [&first[..], &matrices, &changes_of_wrenches(s), &rank].concat();
    named_fields("ConstrainedForwardDynamicsDerivatives", fields)
}

pub fn constrained_knot(s: &Sizes) -> Shape {
    let first = [("qd", velocities(s)), ("wrenches", constraint_wrenches(s))];
    let rank = [("rank", Shape::Scalar)];
    let fields = [&first[..], &knot_matrices(s), &changes_of_wrenches(s), &rank].concat();
    named_fields("ConstrainedKnot", fields)
}

/// The derivatives of the wrenches of constraints.
fn changes_of_wrenches(s: &Sizes) -> [Field; 3] {
    ["dwrenches_dq", "dwrenches_dqd", "dwrenches_dtau"]
        .map(|name| (name, Shape::wrench().columns(s.nv).array(s.constraints)))
}

pub fn constrained_hessian(s: &Sizes) -> Shape {
    let first = [("qdd", velocities(s)), ("wrenches", constraint_wrenches(s))];
    let vectors = ["grad_q", "grad_qd", "grad_tau"].map(|name| (name, velocities(s)));
    let matrices =
        ["hess_q_q", "hess_q_qd", "hess_qd_qd", "hess_q_tau"].map(|name| (name, square(s)));
    let fields = [&first[..], &vectors, &matrices, &[("rank", Shape::Scalar)]].concat();
    named_fields("ConstrainedForwardDynamicsHessian", fields)
}

pub fn impact_dynamics(s: &Sizes) -> Shape {
    let impulses = constraint_wrenches(s);
    let fields = vec![("qd", velocities(s)), ("impulses", impulses), ("rank", Shape::Scalar)];
    named_fields("ImpactDynamics", fields)
}

/// Returns the record of a step with a solver: the state after it and how the solver ended, and
/// `further` fields between them.
fn solved(name: &'static str, state: &[Field], further: &[Field]) -> Shape {
    let solver = [("residual", Shape::Scalar), ("iterations", Shape::Scalar)];
    Shape::Record(Record::ResultsByField(name), [state, further, &solver].concat())
}

fn solved_state(s: &Sizes) -> Vec<Field> {
    let motion = [("q", coordinates(s)), ("qd", velocities(s)), ("qdd", velocities(s))];
    [&motion[..], &[("forces", point_vectors(s))]].concat()
}

fn solved_actuated_state(s: &Sizes) -> Vec<Field> {
    let motion = [("q", coordinates(s)), ("qd", velocities(s)), ("act", activations(s))];
    [&motion[..], &[("qdd", velocities(s)), ("forces", point_vectors(s))]].concat()
}

pub fn step_solution(s: &Sizes) -> Shape {
    solved("StepSolution", &solved_state(s), &[])
}

pub fn linearized_step(s: &Sizes) -> Shape {
    let matrices = [("a", Shape::matrix(2 * s.nv, 2 * s.nv)), ("b", Shape::matrix(s.nv, 2 * s.nv))];
    solved("LinearizedStep", &solved_state(s), &matrices)
}

pub fn step_vjp(s: &Sizes) -> Shape {
    solved("StepVjp", &solved_state(s), &[("grad_x", state(s)), ("grad_tau", velocities(s))])
}

pub fn step_jvp(s: &Sizes) -> Shape {
    solved("StepJvp", &solved_state(s), &[("tangent_x", state(s))])
}

pub fn actuated_step(s: &Sizes) -> Shape {
    solved("ActuatedStep", &solved_actuated_state(s), &[])
}

pub fn linearized_actuated_step(s: &Sizes) -> Shape {
    let states = 2 * s.nv + s.activations;
    let matrices = [("a", Shape::matrix(states, states)), ("b", Shape::matrix(s.controls, states))];
    solved("LinearizedActuatedStep", &solved_actuated_state(s), &matrices)
}

pub fn actuated_step_vjp(s: &Sizes) -> Shape {
    let gradients = [("grad_x", actuated_state(s)), ("grad_ctrl", controls(s))];
    solved("ActuatedStepVjp", &solved_actuated_state(s), &gradients)
}

pub fn actuated_step_jvp(s: &Sizes) -> Shape {
    solved("ActuatedStepJvp", &solved_actuated_state(s), &[("tangent_x", actuated_state(s))])
}

pub fn touching_points(s: &Sizes) -> Shape {
    let gaps = Shape::vector(s.touching_points);
    let vectors = ["positions", "velocities"].map(|name| (name, point_vectors(s)));
    named_fields("TouchingPoints", [&[("gaps", gaps)][..], &vectors].concat())
}

pub fn actuator_forces(s: &Sizes) -> Shape {
    let fields = vec![("tau", velocities(s)), ("act", activations(s))];
    Shape::Record(Record::ResultsByField("ActuatorForces"), fields)
}

pub fn constrained_torques(s: &Sizes) -> Shape {
    let wrenches = constraint_wrenches(s);
    let fields = vec![("tau", velocities(s)), ("wrenches", wrenches), ("rank", Shape::Scalar)];
    named_fields("ConstrainedInverseDynamics", fields)
}

pub fn constraint_jacobian(s: &Sizes) -> Shape {
    twists(s).array(s.constraints)
}

pub fn constraint_twists(s: &Sizes) -> Shape {
    Shape::twist().array(s.constraints)
}

pub fn operational_space_inertia(s: &Sizes) -> Shape {
    let matrix = || Shape::matrix(s.constraint_rows, s.constraint_rows);
    let fields = vec![("delassus", matrix()), ("inertia", matrix()), ("rank", Shape::Scalar)];
    named_fields("OperationalSpaceInertia", fields)
}

pub fn constraint_projection(s: &Sizes) -> Shape {
    let fields =
        vec![("step_q", velocities(s)), ("step_qd", velocities(s)), ("rank", Shape::Scalar)];
    named_fields("ConstraintProjection", fields)
}

pub fn state(s: &Sizes) -> Shape {
    Shape::vector(2 * s.nv)
}

/// The state and the activations.
pub fn actuated_state(s: &Sizes) -> Shape {
    Shape::vector(2 * s.nv + s.activations)
}

pub fn wrenches(s: &Sizes) -> Shape {
    Shape::wrench().array(s.links)
}

pub fn constraint_wrenches(s: &Sizes) -> Shape {
    Shape::wrench().array(s.constraints)
}

pub fn contact_vectors(s: &Sizes) -> Shape {
    Shape::vector3().array(s.contacts)
}

pub fn point_vectors(s: &Sizes) -> Shape {
    Shape::vector3().array(s.touching_points)
}

pub fn controls(s: &Sizes) -> Shape {
    Shape::vector(s.controls)
}

pub fn activations(s: &Sizes) -> Shape {
    Shape::vector(s.activations)
}

pub fn active_contacts(s: &Sizes) -> Shape {
    Shape::Record(Record::Contacts, vec![("", Shape::vector(s.contacts))])
}

pub fn settings(s: &Sizes) -> Shape {
    let scalars = |names: &[&'static str]| -> Vec<(&'static str, Shape)> {
        names.iter().map(|&name| (name, Shape::Scalar)).collect()
    };
    let target_fields = [
        vec![("pose", Shape::pose()), ("velocity", Shape::twist())],
        scalars(&["tangential", "alpha", "beta", "compliance", "restitution", "weight"]),
    ];
    let target = Shape::Record(Record::OfScalar("ContactTarget"), target_fields.concat());
    let mut fields = scalars(&["alpha", "beta", "tolerance", "rounding"]);
    fields.push(("targets", target.array(s.contacts)));
    named_fields("ConstraintSettings", fields)
}

pub fn step_settings(s: &Sizes) -> Shape {
    let surface_fields = vec![
        ("plane", Shape::pose()),
        ("radius", Shape::Scalar),
        ("friction", Shape::Scalar),
        ("torsional_friction", Shape::Scalar),
        ("rolling_friction", Shape::Scalar),
        ("margin", Shape::Scalar),
        ("solref", Shape::vector(2)),
        ("solimp", Shape::vector(4)),
    ];
    let surface = Shape::Record(Record::OfScalar("ContactSurface"), surface_fields);
    let fields = vec![
        ("tolerance", Shape::Scalar),
        ("impratio", Shape::Scalar),
        ("coulomb", Shape::Scalar),
        ("surfaces", surface.array(s.touching_shapes)),
    ];
    named_fields("StepSettings", fields)
}

fn named_fields(name: &'static str, fields: Vec<(&'static str, Shape)>) -> Shape {
    Shape::Record(Record::ResultsByType(name), fields)
}

/// Returns the layout of joint vectors.
fn vectors(name: &'static str, fields: &[&'static str], s: &Sizes) -> Shape {
    named_fields(name, fields.iter().map(|&field| (field, velocities(s))).collect())
}

/// Returns the layout of joint vectors, then square matrices.
fn hessian(
    name: &'static str,
    vectors: &[&'static str],
    matrices: &[&'static str],
    s: &Sizes,
) -> Shape {
    let vectors = vectors.iter().map(|&field| (field, velocities(s)));
    named_fields(name, vectors.chain(matrices.iter().map(|&field| (field, square(s)))).collect())
}
