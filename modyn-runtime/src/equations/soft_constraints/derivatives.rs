//! The derivatives of the state after a step, by the implicit function theorem.
//!
//! The accelerations a of a solution (of floating bases: relative to free fall) keep
//!
//! ```text
//! ID(q, qd, a) = tau + sum of J^T w over the touching bodies + the forces of joint limits and friction
//! ```
//!
//! with inverse dynamics ID and the wrench w of the ground on a body. Its derivative by a is Newton's
//! matrix H, so the changes of a are the changes of both sides at constant a, times the inverse of H.
//! The changes of inverse dynamics are its derivatives in closed form. A wrench depends on the
//! body's pose, and on its velocity and acceleration along the rows: these enter the laws as the
//! sum of the acceleration and of the velocity times the damping of the softness, so the change by
//! the velocity is that damping times the change by the acceleration, the stiffness of the law. The
//! share of Coulomb's law adds the change by the normal's acceleration times a change by the slip.
//!
//! In the axes of a touching body let S_j be the twist of the body at unit rate of joint j, and V
//! the twist of the body in front of joint j, there or by accelerations in place of rates. Then
//! S_j is the change of the pose by q_j and of the twist by qd_j, V x S_j is the change of the
//! twist by q_j, and S_i x S_j the change of S_i by q_j if joint i is in front of joint j, with
//! the cross product of twists.
//!
//! Dampers act with the velocities after a step: b = a + y with (M + dt D) y = -dt D b0, where b0 are
//! the accelerations a in the world. The matrix M + dt D gives the changes of y.

use alloc::collections::BTreeSet;
use alloc::{vec, vec::Vec};

use super::actuated::ActuatedForces;
use super::damping::DampingMatrix;
use super::drive::{StepDrive, VaryingState};
use super::free_bodies::turning;
use super::input::{StepConstraints, StepInput};
use super::problem::{StepProblem, next_state};
use super::responses::Laws;
use super::rows::{ContactOptions, ContactRows, JointParameters, SoftModel};
use super::single_rows::stop_force;
use crate::equations::constraints::lanes::packed;
use crate::equations::derivatives::{derivatives_against_fall, mass_matrix_derivatives};
use crate::equations::dynamics::{Elimination, is_base};
use crate::equations::factorization::limb_coupling::LimbAccess;
use crate::equations::factorization::{Factorizable, factorize_matrix, inverse, solve};
use crate::equations::kinematics::coordinates::qdot_to_velocity;
use crate::equations::kinematics::kinematic_path::towards_world;
use crate::equations::kinematics::links::add_columns_of_frame;
use crate::equations::{Motion, TimeStepInput, Workspace};
use crate::joint::ElementaryJoint;
use crate::mechanism::coordinates::{CoordinateSpace, Coordinates};
use crate::mechanism::{BodyFrame, BodyTree, Dof, Mechanism};
use crate::scalar::Tangent;
use crate::spatial::{
    ArticulatedInertia, Matrix3, Pose, Quaternion, Twist, Vector3, Wrench, rotation_jacobian,
};
use crate::{ContactSurface, Scalar, StepSettings};

/// Returns whether the derivatives of a step have the closed form of [`state_derivatives`]: robots
/// without mimic joints, loops, tendons, couplings, free bodies with implicit rotation, and
/// floating joints on other links.
#[must_use]
pub fn has_closed_form<S: Scalar>(model: &Mechanism<S>, soft: &SoftModel<impl Copy>) -> bool {
    let falls = |i: usize| {
        model.bodies[i].elementary_joint != ElementaryJoint::Floating || is_base(model, i)
    };
    !model.has_mimics()
        && soft.loops.is_empty()
        && soft.tendons.is_empty()
        && soft.couplings.is_empty()
        && soft.coupled_dampers.is_empty()
        && soft.free_bodies.is_empty()
        && (0..model.bodies.len()).all(falls)
}

/// Returns the changes of the state after a step: for each variable of a [`StepDrive`] the changes of
/// the coordinates, in tangent space, of the velocities and of the activations. `problem` has the
/// joint forces and dampers of `drive`, and starts from the accelerations of the solution. The robot
/// has the closed form ([`has_closed_form`]); `layout` is the layout of its mass matrix.
///
/// The changes by several variables are computed at a time where the scalars have lanes.
pub fn state_derivatives<S: Scalar, T: Factorizable<S>>(
    mut problem: StepProblem<'_, S, T>,
    constraints: StepConstraints<'_, S, impl AsRef<[ContactSurface<S>]>>,
    layout: &T::Layout,
    drive: StepDrive<'_, S>,
) -> Vec<Vec<S>> {
    let tree = problem.tree;
    let model = tree.mechanism();
    let nv = model.nv;
    let forces = drive.changes(model, problem.input.step);
    let start = problem.first();
    let laws = problem.laws(&start, S::one());
    let mut equations = Equations::of_inverse_dynamics(&mut problem, &forces);
    equations.add_contacts(&problem, constraints, &laws);
    equations.add_joints(&problem, constraints.soft, &laws);
    let rates = StateRates::new(&mut problem, layout, &equations.mass);
    let after = After::new(model, problem.input.step, &rates.rates);
    let newton = Factors::<S, T>::new(layout, &mut equations.newton);
    let mut by_force = vec![S::zero(); nv * nv];
    inverse(layout, &newton.factors, &mut by_force);

    let (of_state, of_drive) = forces.split_at(2 * nv);
    let variables = (0..nv).map(Variable::Coordinate).chain((0..nv).map(Variable::Velocity));
    let sides = equations.by_q.into_iter().chain(equations.by_qd);
    let state = variables.zip(sides).zip(of_state).map(|((variable, change), forces)| {
        VariableChange { change, ..rates.variable(variable, &forces.dampers) }
    });
    let mut columns = in_lanes(tree, &state.collect::<Vec<_>>(), |mut variables| {
        newton.solve(&mut variables.change);
        after.change(rates.damped(variables))
    });
    let others = of_drive.iter().map(|forces| VariableChange {
        change: product(&by_force, &forces.tau),
        ..rates.variable(Variable::Drive, &forces.dampers)
    });
    columns.extend(in_lanes(tree, &others.collect::<Vec<_>>(), |variables| {
        after.change(rates.damped(variables))
    }));
    columns.iter_mut().zip(forces).for_each(|(column, forces)| column.extend(forces.act));
    columns
}

/// Computes the results of `change` for each variable, several at a time.
fn in_lanes<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    variables: &[VariableChange<S>],
    change: impl Fn(VariableChange<S>) -> Vec<S>,
) -> Vec<Vec<S>> {
    let mut columns = Vec::with_capacity(variables.len());
    for group in variables.chunks(tree.column_lanes()) {
        let packed = |part: fn(&VariableChange<S>) -> &Vec<S>| {
            let entries = 0..part(&group[0]).len();
            entries.map(|i| packed(tree, 0..group.len(), |lane| part(&group[lane])[i])).collect()
        };
        let changes = change(VariableChange {
            change: packed(|x| &x.change),
            fall: packed(|x| &x.fall),
            damped: packed(|x| &x.damped),
            displaced: packed(|x| &x.displaced),
            velocity: packed(|x| &x.velocity),
        });
        columns.extend((0..group.len()).map(|lane| match group.len() {
            1 => changes.clone(),
            _ => changes.iter().map(|&x| tree.extract_lane(x, lane)).collect(),
        }));
    }
    columns
}

/// Returns the product of a matrix by columns and a vector.
fn product<S: Scalar>(matrix: &[S], x: &[S]) -> Vec<S> {
    let mut product = vec![S::zero(); x.len()];
    for (column, &x) in matrix.chunks(x.len().max(1)).zip(x) {
        for (sum, &entry) in product.iter_mut().zip(column) {
            *sum = *sum + entry * x;
        }
    }
    product
}

/// What changes with a variable. All are joint vectors.
struct VariableChange<S> {
    /// The joint forces at constant accelerations; after solving, the accelerations of the laws
    /// relative to free fall.
    change: Vec<S>,
    /// The accelerations of free fall in the world.
    fall: Vec<S>,
    /// Minus the forces of dampers at constant accelerations.
    damped: Vec<S>,
    /// The displacement before the step.
    displaced: Vec<S>,
    /// The velocity before the step.
    velocity: Vec<S>,
}

/// Returns the changes of the state after a step, as [`state_derivatives`] does, for any robot: by one
/// step of Newton's method from the solution, on numbers with derivatives. `input` starts from the
/// accelerations of the solution.
pub fn state_derivatives_by_newton<S: Scalar>(
    model: &Mechanism<S>,
    elimination: &Elimination,
    input: StepInput<'_, S>,
    constraints: StepConstraints<'_, S, impl AsRef<[ContactSurface<S>]>>,
    drive: StepDrive<'_, S>,
) -> Vec<Vec<S>> {
    let StepConstraints { soft, settings } = constraints;
    let nv = model.nv;
    let varying = &model.map(Tangent::constant);
    let constants =
        |x: &[S]| -> Vec<Tangent<S>> { x.iter().copied().map(Tangent::constant).collect() };
    let surface = |surface: &ContactSurface<S>| {
        ContactSurface::from_numbers(surface.numbers().map(Tangent::constant))
    };
    let surfaces: Vec<_> = settings.surfaces.as_ref().iter().map(surface).collect();
    let settings = &StepSettings::from_numbers(settings.numbers().map(Tangent::constant), surfaces);
    let soft = &soft.map(Tangent::constant);
    let warm_start = &constants(input.warm_start);
    let dt = Tangent::constant(input.step.dt);
    let mut workspace = Workspace::new(varying);
    let mut column = |variable: usize| {
        let state = drive.state(model, input.step, variable);
        let forces = drive.forces(varying, &state, dt, variable);
        let VaryingState { q, qd } = &state;
        let step = TimeStepInput { q, qd, tau: &forces.tau, dt };
        let input = StepInput { step, warm_start };
        let constraints = StepConstraints { soft, settings };
        let problem = StepProblem::new(varying, elimination, input, constraints, &mut workspace);
        let motion = problem.damped_by(&forces.dampers).refined();
        let [q, qd] = next_state(varying, soft, step, [&motion.qdd, &motion.damped]);
        let [at, rates] = [|x: &Tangent<S>| x.x, |x: &Tangent<S>| x.dx]
            .map(|part| q.iter().map(part).collect::<Vec<S>>());
        let mut change = vec![S::zero(); nv];
        qdot_to_velocity(model, &at, &rates, &mut change);
        change.extend(qd.iter().chain(&forces.act).map(|x| x.dx));
        change
    };
    (0..2 * nv + drive.variables()).map(&mut column).collect()
}

/// A variable of a step.
#[derive(Clone, Copy)]
enum Variable {
    /// The displacement along this entry of qd.
    Coordinate(usize),
    /// This entry of qd.
    Velocity(usize),
    /// A variable of the joint forces.
    Drive,
}

/// The linear equations of the changes of the accelerations.
struct Equations<S> {
    /// The mass matrix, by columns.
    mass: Vec<S>,
    /// Newton's matrix, by columns.
    newton: Vec<S>,
    /// The right-hand sides for the coordinates.
    by_q: Vec<Vec<S>>,
    /// The right-hand sides for the velocities.
    by_qd: Vec<Vec<S>>,
}

impl<S: Scalar> Equations<S> {
    /// Returns the equations without the constraint rows, given the changes of the joint
    /// forces. Uses the workspace of the problem.
    fn of_inverse_dynamics<T: BodyTree<S>>(
        problem: &mut StepProblem<'_, S, T>,
        forces: &[ActuatedForces<S>],
    ) -> Self {
        let model = problem.tree.mechanism();
        let nv = model.nv;
        let [mut by_q, mut by_qd, mut mass] = [0; 3].map(|_| vec![S::zero(); nv * nv]);
        let TimeStepInput { q, qd, .. } = problem.input.step;
        let motion = Motion { q, qd, qdd: &problem.accelerations };
        derivatives_against_fall(
            problem.tree,
            motion,
            problem.workspace,
            &mut by_q,
            &mut by_qd,
            &mut mass,
        );
        let sides = |columns: &[S], forces: &[ActuatedForces<S>]| {
            let columns = columns.chunks(nv.max(1)).zip(forces);
            let side = |(column, forces): (&[S], &ActuatedForces<S>)| {
                forces.tau.iter().zip(column).map(|(&tau, &entry)| tau - entry).collect()
            };
            columns.map(side).collect()
        };
        let (first, second) = forces.split_at(nv);
        Self { newton: mass.clone(), mass, by_q: sides(&by_q, first), by_qd: sides(&by_qd, second) }
    }

    /// Adds the wrenches of the ground.
    fn add_contacts<T: BodyTree<S>>(
        &mut self,
        problem: &StepProblem<'_, S, T>,
        constraints: StepConstraints<'_, S, impl AsRef<[ContactSurface<S>]>>,
        laws: &Laws<S>,
    ) {
        let nv = problem.tree.mechanism().nv;
        let shapes = constraints.soft.contacts.iter();
        let touching: BTreeSet<usize> = shapes.map(|contact| contact.body).collect();
        for body in touching {
            let motion = TouchingMotion::new(problem, body);
            let ground = motion.wrench(problem, constraints, laws);
            let GroundWrench { wrench, by_pose, stiffness, damping, .. } = &ground;
            for (k, joint) in motion.joints.iter().enumerate() {
                let turned = |front| cross(front, joint.twist);
                let mut moved = Wrench::zero();
                for PoseChange { direction, change } in by_pose {
                    let share = joint.displacement.angular.dot(direction.angular)
                        + joint.displacement.linear.dot(direction.linear);
                    moved += change.scale(share);
                }
                let moved = moved
                    - damping.times(&turned(joint.velocity_in_front))
                    - ground.by_slip(turned(joint.velocity_in_front))
                    - stiffness.times(&turned(joint.acceleration_in_front));
                let stiff = stiffness.times(&joint.twist);
                let damped = damping.times(&joint.twist);
                let slipping = ground.by_slip(joint.twist);
                for (i, row) in motion.joints.iter().enumerate() {
                    let mut change = power(row.twist, moved);
                    if row.body < joint.body {
                        change = change + power(turned(row.twist), *wrench);
                    }
                    let add = |sum: &mut S, change: S| *sum = *sum + change;
                    add(&mut self.by_q[joint.v][row.v], change);
                    add(&mut self.by_qd[joint.v][row.v], -power(row.twist, slipping));
                    if i > k {
                        continue;
                    }
                    let by_acceleration = power(row.twist, stiff);
                    let by_velocity = -power(row.twist, damped);
                    add(&mut self.newton[joint.v * nv + row.v], by_acceleration);
                    add(&mut self.by_qd[joint.v][row.v], by_velocity);
                    if i < k {
                        add(&mut self.newton[row.v * nv + joint.v], by_acceleration);
                        add(&mut self.by_qd[row.v][joint.v], by_velocity);
                    }
                }
            }
        }
    }

    /// Adds the forces of joint limits and dry friction.
    fn add_joints<T: BodyTree<S>>(
        &mut self,
        problem: &StepProblem<'_, S, T>,
        soft: &SoftModel<S>,
        laws: &Laws<S>,
    ) {
        let nv = problem.tree.mechanism().nv;
        let TimeStepInput { q, qd, dt, .. } = problem.input.step;
        for (row, &[_, stiffness]) in problem.single_rows.iter().zip(&laws.single_rows) {
            for entry in &row.entries {
                let sum = &mut self.newton[entry.dof * nv + entry.dof];
                *sum = *sum + entry.factor * stiffness * entry.factor;
            }
        }
        for (dof, parameters) in soft.joints.iter().enumerate() {
            let Some(JointParameters { coordinate, stops }) = parameters else { continue };
            let stops = stops.map(Tangent::constant);
            let force = |length: Tangent<S>, rate: Tangent<S>| {
                let acceleration = Tangent::constant(problem.accelerations[dof]);
                stop_force(&stops, [length, rate, acceleration], Tangent::constant(dt)).dx
            };
            let [length, rate] = [q[*coordinate], qd[dof]];
            let varies = |x: S| Tangent { x, dx: S::one() };
            let [by_q, by_qd] = [
                force(varies(length), Tangent::constant(rate)),
                force(Tangent::constant(length), varies(rate)),
            ];
            self.by_q[dof][dof] = self.by_q[dof][dof] + by_q;
            self.by_qd[dof][dof] = self.by_qd[dof][dof] + by_qd;
        }
    }
}

/// A joint that moves a touching body, in the body's axes.
struct PathJoint<S> {
    /// The entry of qd.
    v: usize,
    /// The joint's body.
    body: usize,
    /// The twist of the touching body's origin at unit rate.
    displacement: Twist<S>,
    /// The twist of the touching body at unit rate.
    twist: Twist<S>,
    /// The velocity of the body in front of the joint.
    velocity_in_front: Twist<S>,
    /// The same by accelerations in place of rates.
    acceleration_in_front: Twist<S>,
}

/// The motion of a touching body, in its axes. Twists and wrenches are at the place of the contact if
/// the body has one alone, where its wrench is a force, else at the body's origin.
struct TouchingMotion<S> {
    body: usize,
    /// The place of the only contact.
    place: Option<Vector3<S>>,
    /// The joints that move the body, from the world to the body.
    joints: Vec<PathJoint<S>>,
}

/// The wrench of the ground on a body, and its changes.
struct GroundWrench<S> {
    wrench: Wrench<S>,
    /// The changes with the pose of the body.
    by_pose: Vec<PoseChange<S>>,
    /// Minus the change with the acceleration.
    stiffness: ArticulatedInertia<S>,
    /// Minus the change with the velocity, without the change by `slips`.
    damping: ArticulatedInertia<S>,
    /// [`ContactRows::change_by_slip`] of each contact.
    slips: Vec<[Wrench<S>; 2]>,
}

impl<S: Scalar> GroundWrench<S> {
    /// Returns minus the change with a velocity by the slip of the contacts.
    fn by_slip(&self, twist: Twist<S>) -> Wrench<S> {
        self.slips.iter().fold(Wrench::zero(), |sum, &[change, closing]| {
            sum + change.scale(power(twist, closing))
        })
    }
}

/// The change of a wrench with a displacement of the body along a direction. The twist of the body
/// and its acceleration are constant in the body's axes.
struct PoseChange<S> {
    /// A unit displacement at the body's origin.
    direction: Twist<S>,
    change: Wrench<S>,
}

impl<S: Scalar> TouchingMotion<S> {
    /// Returns the motion of a body.
    fn new<T: BodyTree<S>>(problem: &StepProblem<'_, S, T>, body: usize) -> Self {
        let model = problem.tree.mechanism();
        let TimeStepInput { q, qd, .. } = problem.input.step;
        let mut contacts = problem.contacts.iter().filter(|contact| contact.body == body);
        let first = contacts.next().map(|contact| contact.place);
        let place = first.filter(|_| contacts.next().is_none());
        let translation = place.unwrap_or_else(Vector3::zero);
        let pose = Pose { translation: translation.0, ..Pose::identity() };
        let mut columns = vec![Twist::zero(); model.nv];
        add_columns_of_frame(model, BodyFrame { body: Some(body), pose }, q, &mut columns);
        let mut path: Vec<usize> = towards_world(model, Some(body)).collect();
        path.reverse();
        let mut joints: Vec<PathJoint<S>> = Vec::new();
        // The velocities and accelerations by the joints up to the body before.
        let mut in_front = [Twist::zero(); 2];
        for i in path {
            let [velocity_in_front, acceleration_in_front] = in_front;
            for &Dof { v, body, .. } in model.dofs_of(i) {
                let twist = columns[v];
                let linear =
                    place.map_or(twist.linear, |place| twist.linear - twist.angular.cross(place));
                for (sum, rates) in in_front.iter_mut().zip([qd, &problem.accelerations]) {
                    *sum = *sum + twist.scale(rates[v]);
                }
                joints.push(PathJoint {
                    v,
                    body,
                    displacement: Twist { linear, ..twist },
                    twist,
                    velocity_in_front,
                    acceleration_in_front,
                });
            }
        }
        Self { body, place, joints }
    }

    /// Returns the wrench of the ground by these laws, and its changes.
    fn wrench<T: BodyTree<S>>(
        &self,
        problem: &StepProblem<'_, S, T>,
        constraints: StepConstraints<'_, S, impl AsRef<[ContactSurface<S>]>>,
        laws: &Laws<S>,
    ) -> GroundWrench<S> {
        let StepConstraints { soft, settings } = constraints;
        let mut wrench = Wrench::zero();
        let [mut stiffness, mut damping] = [0; 2].map(|_| ArticulatedInertia::<S>::zero());
        let mut slips = Vec::new();
        let rows = (problem.contacts.iter().zip(&laws.contacts))
            .filter(|(contact, _)| contact.body == self.body);
        for (contact, response) in rows.clone() {
            let at_place = contact.inertia_at_place(response);
            let inertia = match self.place {
                Some(_) => at_place,
                None => at_place.shifted(contact.place),
            };
            wrench += self.moved(contact.place, contact.wrench_at_place(&response.force));
            stiffness = stiffness + inertia;
            damping = damping + inertia.scaled(contact.damping);
            let change = contact.change_by_slip(response);
            slips.push(change.map(|wrench| self.moved(contact.place, wrench)));
        }

        let constant = Tangent::constant;
        let options = ContactOptions {
            cone: soft.cone,
            ratio: constant(settings.impratio),
            coulomb: constant(settings.coulomb),
            dt: constant(problem.input.step.dt),
        };
        let contacts = (soft.contacts.iter().zip(settings.surfaces.as_ref()))
            .filter(|(contact, _)| contact.body == self.body);
        let shapes: Vec<_> = contacts
            .map(|(parameters, surface)| {
                let surface = ContactSurface::from_numbers(surface.numbers().map(constant));
                (parameters.map(constant), surface)
            })
            .collect();
        let change = |direction: Twist<S>| {
            let state = problem.states[self.body].displaced(direction);
            let mut change = Wrench::zero();
            let moved = shapes.iter().flat_map(|(parameters, surface)| {
                ContactRows::of_shape(parameters, &state, surface, options)
            });
            for (contact, moved) in rows.clone().map(|(contact, _)| contact).zip(moved) {
                let origin = Twist::from_components(
                    problem.acceleration_of(self.body).components().map(constant),
                );
                let accelerations: Vec<Tangent<S>> = moved.acceleration(&origin).collect();
                let Wrench { moment, force } =
                    moved.wrench_at_place(&moved.law.response(&accelerations).force);
                let by_force = Wrench { moment: rate(moment), force: rate(force) };
                change += self.moved(contact.place, by_force);
                let now = Vector3(force.0.map(|x| x.x));
                change.moment += rate(moved.place).cross(now);
            }
            PoseChange { direction, change }
        };
        let zero = Vector3::zero();
        let units = || (0..3).map(Vector3::unit);
        let turns = units().map(|angular| Twist { angular, linear: zero });
        // A contact alone depends on displacements along its normal.
        let mut normals = rows.clone().map(|(contact, _)| contact.normal());
        let moves: Vec<Vector3<S>> = match (self.place, normals.next()) {
            (Some(_), Some(normal)) => vec![normal],
            _ => units().collect(),
        };
        GroundWrench {
            wrench,
            by_pose: turns
                .chain(moves.into_iter().map(|linear| Twist { angular: zero, linear }))
                .map(change)
                .collect(),
            stiffness,
            damping,
            slips,
        }
    }

    /// Returns a wrench at the place of a contact as a wrench at the point of all twists.
    fn moved(&self, place: Vector3<S>, wrench: Wrench<S>) -> Wrench<S> {
        match self.place {
            Some(_) => wrench,
            None => Wrench { moment: wrench.moment + place.cross(wrench.force), ..wrench },
        }
    }
}

/// Returns the rates of a vector's components.
fn rate<S: Scalar>(vector: Vector3<Tangent<S>>) -> Vector3<S> {
    Vector3(vector.0.map(|x| x.dx))
}

/// Returns the power of a wrench at a twist.
fn power<S: Scalar>(twist: Twist<S>, wrench: Wrench<S>) -> S {
    twist.angular.dot(wrench.moment) + twist.linear.dot(wrench.force)
}

/// Returns the cross product of two twists.
fn cross<S: Scalar>(a: Twist<S>, b: Twist<S>) -> Twist<S> {
    Twist {
        angular: a.angular.cross(b.angular),
        linear: a.angular.cross(b.linear) + a.linear.cross(b.angular),
    }
}

/// The factors of a matrix.
struct Factors<'a, S: Scalar, T: Factorizable<S>> {
    layout: &'a T::Layout,
    factors: Vec<S>,
}

impl<'a, S: Scalar, T: Factorizable<S>> Factors<'a, S, T> {
    /// Factorizes a matrix by columns, which is overwritten.
    fn new(layout: &'a T::Layout, matrix: &mut [S]) -> Self {
        let mut pivots = vec![S::zero(); layout.layout().pivots()];
        let mut factors = vec![S::zero(); layout.layout().size()];
        factorize_matrix(layout, matrix, &mut pivots, &mut factors);
        Self { layout, factors }
    }

    fn solve(&self, x: &mut [S]) {
        solve(self.layout, &self.factors, x);
    }
}

/// The accelerations that move the state, of floating joints in the world: the accelerations of the
/// laws, changed by the dampers that act with the velocities after the step.
struct StateRates<'a, S: Scalar, T: Factorizable<S>> {
    rates: Vec<S>,
    dt: S,
    /// The robot's floating bases.
    bases: Vec<FallingBase<S>>,
    /// `None` without dampers.
    dampers: Option<Dampers<'a, S, T>>,
}

/// A floating base.
struct FallingBase<S> {
    /// Its first entry of qd.
    v: usize,
    /// Gravity in its axes.
    gravity: Vector3<S>,
}

/// The dampers that act with the velocities after the step.
struct Dampers<'a, S: Scalar, T: Factorizable<S>> {
    /// The dampers times the time of the step.
    armature: DampingMatrix<S>,
    factors: Factors<'a, S, T>,
    /// The derivatives of M y by the coordinates at constant y, by columns; y is the acceleration by
    /// the dampers.
    force_by_q: Vec<S>,
}

impl<'a, S: Scalar, T: Factorizable<S>> StateRates<'a, S, T> {
    /// Returns the accelerations of the solution. `mass` is the mass matrix. Uses the workspace of the
    /// problem.
    fn new(problem: &mut StepProblem<'_, S, T>, layout: &'a T::Layout, mass: &[S]) -> Self {
        let model = problem.tree.mechanism();
        let TimeStepInput { qd, dt, .. } = problem.input.step;
        let bodies = (0..model.bodies.len()).filter(|&body| is_base(model, body));
        let bases = bodies.map(|body| FallingBase {
            v: model.dofs_of(body)[0].v,
            gravity: problem.states[body].fall,
        });
        let turning = turning(model, qd);
        let falls = problem.fall.iter().zip(turning).map(|(&fall, turning)| fall + turning);
        let mut rates: Vec<S> =
            problem.accelerations.iter().zip(falls).map(|(&rate, fall)| rate + fall).collect();
        let dampers = (!problem.damping.is_zero()).then(|| {
            let armature = problem.damping.scaled(dt);
            let mut matrix = mass.to_vec();
            for ([row, column], entry) in armature.entries() {
                let sum = &mut matrix[column * model.nv + row];
                *sum = *sum + entry;
            }
            let factors = Factors::new(layout, &mut matrix);
            let mut damped: Vec<S> = armature.times(&rates).iter().map(|&force| -force).collect();
            factors.solve(&mut damped);
            let mut force_by_q = vec![S::zero(); model.nv * model.nv];
            mass_matrix_derivatives(model, &damped, problem.workspace, &mut force_by_q);
            rates.iter_mut().zip(damped).for_each(|(rate, damped)| *rate = *rate + damped);
            Dampers { armature, factors, force_by_q }
        });
        Self { rates, dt, bases: bases.collect(), dampers }
    }

    /// Returns what changes with a variable, but for the accelerations of the laws. `drive` is the
    /// change of the dampers.
    fn variable(&self, variable: Variable, drive: &DampingMatrix<S>) -> VariableChange<S> {
        let nv = self.rates.len();
        let zeros = || vec![S::zero(); nv];
        let [mut fall, mut damped, mut displaced, mut velocity] = [0; 4].map(|_| zeros());
        match variable {
            Variable::Coordinate(dof) => {
                displaced[dof] = S::one();
                for FallingBase { v, gravity } in &self.bases {
                    // The angular entries of a floating base follow the linear ones.
                    let axis = dof.checked_sub(v + 3).filter(|axis| *axis < 3);
                    let Some(axis) = axis else { continue };
                    fall[*v..v + 3].copy_from_slice(&gravity.cross(Vector3::unit(axis)).0);
                }
            }
            Variable::Velocity(dof) => velocity[dof] = S::one(),
            Variable::Drive => {}
        }
        if let Some(Dampers { force_by_q, .. }) = &self.dampers {
            damped = drive.scaled(self.dt).times(&self.rates);
            if let Variable::Coordinate(dof) = variable {
                let by_q = &force_by_q[dof * nv..];
                damped.iter_mut().zip(by_q).for_each(|(sum, &by_q)| *sum = *sum + by_q);
            }
        }
        VariableChange { change: zeros(), fall, damped, displaced, velocity }
    }

    /// Replaces the changes of the accelerations of the laws, relative to free fall, by the changes of
    /// the accelerations that move the state.
    fn damped(&self, mut variable: VariableChange<S>) -> VariableChange<S> {
        let VariableChange { change, fall, damped, .. } = &mut variable;
        change.iter_mut().zip(fall).for_each(|(change, &mut fall)| *change = *change + fall);
        let Some(Dampers { armature, factors, .. }) = &self.dampers else { return variable };
        let forces = armature.times(change).into_iter().zip(&*damped);
        let mut by_dampers: Vec<S> = forces.map(|(force, &damped)| -(force + damped)).collect();
        factors.solve(&mut by_dampers);
        change.iter_mut().zip(by_dampers).for_each(|(sum, change)| *sum = *sum + change);
        variable
    }
}

/// The effect of the accelerations on the state after a step, for each group of coordinates.
struct After<'a, S> {
    dt: S,
    groups: Vec<AfterGroup<'a, S>>,
}

struct AfterGroup<'a, S> {
    block: &'a Coordinates<S>,
    /// The linear velocity after the step, in the axes before it; zero for rotations and numbers.
    linear: Vector3<S>,
    /// The same in the axes after the step.
    linear_after: Vector3<S>,
    /// From the axes before the step to the axes after it.
    back: Matrix3<S>,
    /// The derivative of the rotation by the angular velocity.
    rotation: Matrix3<S>,
}

impl<'a, S: Scalar> After<'a, S> {
    /// Returns the effect at the accelerations `rates`, of floating joints in the world.
    fn new(model: &'a Mechanism<S>, input: TimeStepInput<'_, S>, rates: &[S]) -> Self {
        let TimeStepInput { qd, dt, .. } = input;
        let velocity =
            |first: usize| Vector3([0, 1, 2].map(|k| qd[first + k] + dt * rates[first + k]));
        let groups = model.coordinates.iter().map(|block| {
            let [linear, angular] = match block.space {
                CoordinateSpace::Line { .. } => [Vector3::zero(); 2],
                CoordinateSpace::Rotation => [Vector3::zero(), velocity(block.v)],
                CoordinateSpace::Pose => [velocity(block.v), velocity(block.v + 3)],
            };
            let turn = angular.scale(dt);
            let back = Quaternion::exp(turn).conjugate().matrix();
            let rotation = rotation_jacobian(turn);
            AfterGroup {
                block,
                linear,
                linear_after: back.mul_vector(linear),
                back,
                rotation: Matrix3::from_columns(|k| rotation.column(k).scale(dt)),
            }
        });
        Self { dt, groups: groups.collect() }
    }

    /// Returns the changes of the coordinates after the step, then of the velocities, given the
    /// changes of the accelerations that move the state.
    fn change(&self, variable: VariableChange<S>) -> Vec<S> {
        let VariableChange { change: rates, displaced, velocity, .. } = variable;
        let nv = rates.len();
        let displaced = |v: usize| displaced[v];
        let velocity = |v: usize| velocity[v] + self.dt * rates[v];
        let three =
            |entry: &dyn Fn(usize) -> S, first: usize| Vector3([0, 1, 2].map(|k| entry(first + k)));
        let mut change = vec![S::zero(); 2 * nv];
        for AfterGroup { block, linear, linear_after, back, rotation } in &self.groups {
            let v = block.v;
            let mut write = |first: usize, x: Vector3<S>| {
                change[first..first + 3].copy_from_slice(&x.0);
            };
            match block.space {
                CoordinateSpace::Line { .. } => {
                    change[v] = displaced(v) + self.dt * velocity(v);
                    change[nv + v] = velocity(v);
                }
                CoordinateSpace::Rotation => {
                    let angular = three(&velocity, v);
                    let turned = rotation.mul_vector(angular);
                    write(v, back.mul_vector(three(&displaced, v)) + turned);
                    write(nv + v, angular);
                }
                CoordinateSpace::Pose => {
                    let angular = three(&velocity, v + 3);
                    let along = three(&velocity, v);
                    let turn = three(&displaced, v + 3);
                    let turned = rotation.mul_vector(angular);
                    let along_after = back.mul_vector(along);
                    let moved = three(&displaced, v) + turn.cross(*linear).scale(self.dt);
                    write(v, back.mul_vector(moved) + along_after.scale(self.dt));
                    write(v + 3, back.mul_vector(turn) + turned);
                    write(nv + v, along_after + linear_after.cross(turned));
                    write(nv + v + 3, angular);
                }
            }
        }
        change
    }
}
