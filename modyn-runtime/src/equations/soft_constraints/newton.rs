//! Newton's method for soft constraints, and the step that it solves.

use alloc::{vec, vec::Vec};

use super::law::Response;
use super::rows::{BodyState, ContactRows, JointRow, SoftParameters, body_twists};
use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::dynamics::newton_euler::{Accelerations, link_wrenches};
use crate::equations::dynamics::{against_fall, is_base};
use crate::equations::factorization::ModulePartition;
use crate::equations::kinematics::coordinates;
use crate::equations::kinematics::links::compute_body_poses;
use crate::mechanism::Mechanism;
use crate::solve::Decide;
use crate::spatial::{Matrix3, Pose, Vector3, Wrench};

/// A full step is taken if the slope at its end is at most this share of that at its start.
const FULL_STEP: f64 = 0.05;

/// The largest number of evaluations of a line search.
const MAX_SEARCH: usize = 30;

/// Where the solver ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverLimits<S> {
    /// The largest mismatch between forces and laws, N and N m.
    pub tolerance: S,
    /// The largest number of iterations.
    pub iterations: usize,
}

/// The state of a robot, its joint forces, and the time of a step.
#[derive(Clone, Copy, Debug)]
pub struct StepInput<'a, S> {
    /// The coordinates.
    pub q: &'a [S],
    /// The velocities.
    pub qd: &'a [S],
    /// The joint forces, N m or N.
    pub tau: &'a [S],
    /// The time, s.
    pub dt: S,
}

/// The state after a step, and the forces in it.
#[derive(Clone, Debug, PartialEq)]
pub struct SoftSolution<S> {
    /// The coordinates.
    pub q: Vec<S>,
    /// The velocities.
    pub qd: Vec<S>,
    /// The force of each contact along the normal and the two tangents of its plane, N.
    pub forces: Vec<[S; 3]>,
    /// The largest mismatch between forces and laws, N and N m.
    pub residual: S,
    /// The number of iterations.
    pub iterations: usize,
}

/// Returns the state after a step, by semi-implicit Euler: joint damping acts with the velocities after the step. Positions move
/// straight, rotations by the exponential map, as in MuJoCo.
pub fn soft_step<S: Decide>(
    model: &Mechanism<S>,
    partition: &ModulePartition,
    input: StepInput<'_, S>,
    parameters: &SoftParameters<S>,
    limits: SolverLimits<S>,
    workspace: &mut Workspace<S>,
) -> SoftSolution<S> {
    let mut solver = Solver::new(model, partition, input, parameters, workspace);
    let Solved { laws, residual, iterations } = solver.solve(limits);
    let accelerations = solver.with_implicit_damping(&laws);
    let qd: Vec<S> = input.qd.iter().zip(&accelerations).map(|(&v, &a)| v + input.dt * a).collect();
    let mut solution = SoftSolution {
        q: vec![S::zero(); model.nq],
        qd,
        forces: laws.contacts.iter().map(|response| response.force).collect(),
        residual,
        iterations,
    };
    let SoftSolution { q, qd, .. } = &mut solution;
    coordinates::move_straight(model, input.q, qd, input.dt, q);
    solution
}

/// The rows at an iterate: three for each contact, then one for each row of a joint.
#[derive(Clone, Default)]
struct Iterate<S> {
    /// The accelerations of the rows.
    accelerations: Vec<S>,
    /// The forces of the rows that keep the iterate in equilibrium.
    balances: Vec<S>,
}

/// The forces of the laws at an iterate, and minus their derivatives.
struct Laws<S> {
    contacts: Vec<Response<S>>,
    joints: Vec<[S; 2]>,
}

impl<S: Scalar> Laws<S> {
    /// Returns the forces of all rows.
    fn forces(&self) -> impl Iterator<Item = S> + '_ {
        let contacts = self.contacts.iter().flat_map(|response| response.force);
        contacts.chain(self.joints.iter().map(|response| response[0]))
    }

    /// Returns the products of the stiffness with the accelerations of the rows.
    fn stiffness_times(&self, accelerations: &[S]) -> Vec<S> {
        let (points, of_joints) = accelerations.split_at(3 * self.contacts.len());
        let contacts = self.contacts.iter().zip(points.chunks(3)).flat_map(|(response, point)| {
            response.stiffness.map(|row| row[0] * point[0] + row[1] * point[1] + row[2] * point[2])
        });
        let joints = self.joints.iter().zip(of_joints).map(|(response, &a)| response[1] * a);
        contacts.chain(joints).collect()
    }
}

struct Solver<'a, S> {
    model: &'a Mechanism<S>,
    partition: &'a ModulePartition,
    input: StepInput<'a, S>,
    workspace: &'a mut Workspace<S>,
    /// The wrenches of the bodies at zero joint accelerations.
    bias: Vec<Wrench<S>>,
    contacts: Vec<ContactRows<S>>,
    joints: Vec<JointRow<S>>,
    /// The joint accelerations, those of floating bases relative to free fall.
    accelerations: Vec<S>,
}

/// The effect of the rows on the recursion.
#[derive(Clone, Copy)]
enum Effect<'a, S> {
    /// Forces, and the stiffness of these laws as added inertia.
    Stiff(&'a Laws<S>),
    /// Forces. The damping of joints acts with the velocities after the step.
    Forces,
}

impl<'a, S: Decide> Solver<'a, S> {
    fn new(
        model: &'a Mechanism<S>,
        partition: &'a ModulePartition,
        input: StepInput<'a, S>,
        parameters: &SoftParameters<S>,
        workspace: &'a mut Workspace<S>,
    ) -> Self {
        let StepInput { q, qd, dt, .. } = input;
        workspace.reserve(partition.pivots, 0, 0);
        workspace.move_with_forces(model, q, Some(qd));
        link_wrenches(model, qd, Accelerations::FreeFall, workspace);
        let bias = workspace.wrenches.clone();
        let mut poses = vec![Pose::identity(); model.bodies.len()];
        compute_body_poses(model, workspace, &mut poses);
        body_twists(model, qd, workspace);
        let mut falls = vec![false; model.bodies.len()];
        for (i, body) in model.bodies.iter().enumerate() {
            falls[i] = body.parent.map_or_else(|| is_base(model, i), |parent| falls[parent]);
        }
        let frames = model.constraints.iter().filter(|constraint| constraint.contact);
        let contacts = frames.zip(&parameters.contacts).filter_map(|(constraint, contact)| {
            let frame = &constraint.ends[1];
            let body = frame.body?;
            let state = BodyState {
                pose: poses[body],
                velocity: workspace.twists[body],
                fall: match falls[body] {
                    true => Matrix3(poses[body].rotation).transposed().mul_vector(model.gravity),
                    false => Vector3::zero(),
                },
            };
            ContactRows::new(frame, &state, parameters, contact, dt)
        });
        let contacts = contacts.collect();
        let mut joints = Vec::new();
        for (dof, joint) in parameters.joints.iter().enumerate() {
            if let Some(joint) = joint {
                JointRow::add(dof, joint, (q, qd), dt, &mut joints);
            }
        }
        let accelerations = vec![S::zero(); model.nv];
        Self { model, partition, input, workspace, bias, contacts, joints, accelerations }
    }

    /// Iterates until the mismatch of forces is within the limits.
    fn solve(&mut self, limits: SolverLimits<S>) -> Solved<S> {
        let rows = 3 * self.contacts.len() + self.joints.len();
        let mut iterate =
            Iterate { accelerations: vec![S::zero(); rows], balances: vec![S::zero(); rows] };
        let mut laws = self.laws(&iterate.accelerations);
        let mut iterations = 0;
        loop {
            iterations += 1;
            let next = self.full_step(&iterate, &laws);
            let next_laws = self.laws(&next.accelerations);
            let residual = mismatch(&next, &next_laws);
            let is_solved = (limits.tolerance - residual).is_known_nonnegative();
            if is_solved || iterations >= limits.iterations {
                return Solved { laws: next_laws, residual, iterations };
            }
            (iterate, laws) = if iterations == 1 {
                (next, next_laws)
            } else {
                self.search(&iterate, &laws, next, next_laws)
            };
        }
    }

    /// Returns the laws at accelerations of the rows.
    fn laws(&self, accelerations: &[S]) -> Laws<S> {
        let (points, of_joints) = accelerations.split_at(3 * self.contacts.len());
        let contacts = self.contacts.iter().zip(points.chunks(3));
        let joints = self.joints.iter().zip(of_joints);
        Laws {
            contacts: contacts.map(|(c, a)| c.law.response([a[0], a[1], a[2]])).collect(),
            joints: joints.map(|(row, &a)| row.response(a)).collect(),
        }
    }

    /// Returns the minimum of the quadratic model of the function at an iterate with these laws.
    fn full_step(&mut self, iterate: &Iterate<S>, laws: &Laws<S>) -> Iterate<S> {
        let shares = laws.stiffness_times(&iterate.accelerations);
        let applied: Vec<S> =
            laws.forces().zip(shares).map(|(force, share)| force + share).collect();
        self.accelerate(&applied, Effect::Stiff(laws));
        let contacts = self
            .contacts
            .iter()
            .flat_map(|contact| contact.acceleration(&self.workspace.twists[contact.body]));
        let joints = self.joints.iter().map(|row| row.sign * self.accelerations[row.dof]);
        let accelerations: Vec<S> = contacts.chain(joints).collect();
        let shares = laws.stiffness_times(&accelerations);
        let balances = applied.iter().zip(shares).map(|(&force, share)| force - share).collect();
        Iterate { accelerations, balances }
    }

    /// Computes the joint accelerations, relative to free fall, under these forces of the rows, and the accelerations of the bodies.
    fn accelerate(&mut self, forces: &[S], effect: Effect<'_, S>) {
        let Self { model, workspace, contacts, joints, .. } = self;
        workspace.wrenches.copy_from_slice(&self.bias);
        let mut tau = self.input.tau.to_vec();
        let (points, of_joints) = forces.split_at(3 * contacts.len());
        for (contact, force) in contacts.iter().zip(points.chunks(3)) {
            let wrench = &mut workspace.wrenches[contact.body];
            *wrench = *wrench - contact.wrench([force[0], force[1], force[2]]);
        }
        for (row, &force) in joints.iter().zip(of_joints) {
            tau[row.dof] = tau[row.dof] + row.sign * force;
        }
        match effect {
            Effect::Stiff(laws) => {
                for (contact, response) in contacts.iter().zip(&laws.contacts) {
                    let inertia = contact.inertia(response);
                    let sum = &mut workspace.added_inertia[contact.body];
                    *sum = Some(sum.map_or(inertia, |sum| sum + inertia));
                }
                for (row, &[_, stiffness]) in joints.iter().zip(&laws.joints) {
                    let sum = &mut workspace.added_armature[row.dof];
                    *sum = Some(sum.map_or(stiffness, |sum| sum + stiffness));
                }
            }
            Effect::Forces => {
                for (added, dof) in workspace.added_armature.iter_mut().zip(&model.dofs) {
                    *added = dof.damping.map(|damping| damping * self.input.dt);
                }
            }
        }
        let forces = (self.input.qd, &*tau);
        against_fall(*model, self.partition, forces, workspace, &mut self.accelerations);
        body_twists(model, &self.accelerations, workspace);
        workspace.added_inertia.fill(None);
        workspace.added_armature.fill(None);
    }

    /// Returns the minimum of the function between an iterate and the full step from it, and the laws there. The function is convex, so
    /// its slope rises from a negative number.
    fn search(
        &self,
        start: &Iterate<S>,
        start_laws: &Laws<S>,
        end: Iterate<S>,
        end_laws: Laws<S>,
    ) -> (Iterate<S>, Laws<S>) {
        let along: Vec<S> = end
            .accelerations
            .iter()
            .zip(&start.accelerations)
            .map(|(&end, &start)| end - start)
            .collect();
        let slope = |iterate: &Iterate<S>, laws: &Laws<S>| {
            let terms = iterate.balances.iter().zip(laws.forces()).zip(&along);
            terms
                .fold(S::zero(), |sum, ((&balance, force), &along)| sum + (balance - force) * along)
        };
        let first = slope(start, start_laws);
        let mut high = Bracket { at: S::one(), slope: slope(&end, &end_laws) };
        let least = first.abs() * S::from_f64(FULL_STEP);
        if (least - high.slope).is_known_nonnegative() {
            return (end, end_laws);
        }
        let mut low = Bracket { at: S::zero(), slope: first };
        let mut best = (end.clone(), end_laws);
        for _ in 0..MAX_SEARCH {
            // The Illinois form of regula falsi: the slope at an end that stays is halved.
            let at = low.at - low.slope * (high.at - low.at) / (high.slope - low.slope);
            let between = |a: &[S], b: &[S]| {
                a.iter().zip(b).map(|(&a, &b)| a + at * (b - a)).collect::<Vec<S>>()
            };
            let iterate = Iterate {
                accelerations: between(&start.accelerations, &end.accelerations),
                balances: between(&start.balances, &end.balances),
            };
            let laws = self.laws(&iterate.accelerations);
            let here = slope(&iterate, &laws);
            best = (iterate, laws);
            if (least - here.abs()).is_known_nonnegative() {
                break;
            }
            let half = S::from_f64(0.5);
            if here.is_known_nonnegative() {
                high = Bracket { at, slope: here };
                low.slope = low.slope * half;
            } else {
                low = Bracket { at, slope: here };
                high.slope = high.slope * half;
            }
        }
        best
    }

    /// Returns the accelerations under the forces of the laws, with the damping of the joints at the velocities after the step. Linear
    /// accelerations of floating bases are classical ones, in the base's axes.
    fn with_implicit_damping(&mut self, laws: &Laws<S>) -> Vec<S> {
        if self.model.dofs.iter().any(|dof| dof.damping.is_some()) {
            let forces: Vec<S> = laws.forces().collect();
            self.accelerate(&forces, Effect::Forces);
        }
        let mut accelerations = self.accelerations.clone();
        for i in (0..self.model.bodies.len()).filter(|&i| is_base(self.model, i)) {
            let body = &self.model.bodies[i];
            let gravity = body.to_child(&self.workspace.motions[i], self.model.gravity);
            for (dof, fall) in self.model.dofs_of(i).iter().zip(gravity.0) {
                dof.add(fall, &mut accelerations);
            }
        }
        accelerations
    }
}

/// An end of an interval of a line search.
struct Bracket<S> {
    at: S,
    slope: S,
}

/// The end of the iterations.
struct Solved<S> {
    laws: Laws<S>,
    residual: S,
    iterations: usize,
}

/// Returns the largest difference between a force that keeps an iterate in equilibrium and the force of its law; NaN if one is.
fn mismatch<S: Scalar>(iterate: &Iterate<S>, laws: &Laws<S>) -> S {
    let differences = iterate.balances.iter().zip(laws.forces());
    differences.fold(S::zero(), |most, (&balance, force)| {
        let difference = (balance - force).abs();
        // A difference that is NaN is not below the largest one, and remains.
        (most - difference).select_nonnegative(most, difference)
    })
}
