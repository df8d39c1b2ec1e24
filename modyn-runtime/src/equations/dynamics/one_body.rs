//! The recursions of one body, for code that runs them in loops over the bodies.
//!
//! A recursion is a list of [`Sweep`]s. In each sweep a body receives numbers and sends as many.
//! The mechanism has two bodies: the parent, which only receives and sends, and the body with its
//! joint. A floating base has no parent.

use alloc::vec::Vec;

use super::forward_dynamics::{accelerate, add_free_fall, eliminate_module};
use super::inverse_dynamics::joint_torque;
use super::newton_euler::{Accelerations, is_base, link_wrench};
use crate::Scalar;
use crate::equations::factorization::ModuleBlock;
use crate::equations::{State, Workspace};
use crate::mechanism::Mechanism;
use crate::spatial::{ArticulatedInertia, Field, Matrix3, RigidInertia, Twist, Vector3, Wrench};

/// A pass over all bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sweep {
    /// Parents before children: each body receives the numbers that its parent sends.
    Outward,
    /// Children before parents: each body receives the sum of its own numbers and those that its
    /// children send.
    Inward,
}

/// A recursion: its sweeps, and the equations of one body.
#[derive(Clone, Copy, Debug)]
pub struct BodyRecursion<S> {
    /// The sweeps, with the number of numbers that a body receives in each.
    pub sweeps: &'static [(Sweep, usize)],
    /// The equations of one body.
    pub body: BodyEquations<S>,
    /// Returns the numbers that the world sends in each sweep; nothing in inward sweeps.
    pub world: fn(&Mechanism<S>) -> Vec<Vec<S>>,
}

/// The equations of one body. The arguments: the parent and the body, the body's entries of the
/// joint vectors (`q` first), and the numbers that it receives in each sweep.
pub type BodyEquations<S> = fn(&Mechanism<S>, [&[S]; 3], &[&[S]]) -> BodyResults<S>;

/// The results of the equations of one body.
#[derive(Clone, Debug)]
pub struct BodyResults<S> {
    /// For each sweep, the body's own numbers, with which the sum of an inward sweep begins. They
    /// are known in the sweep before. Empty in outward sweeps.
    pub own: Vec<Vec<S>>,
    /// The numbers that the body sends in each sweep.
    pub sent: Vec<Vec<S>>,
    /// The body's entries of the result.
    pub result: Vec<S>,
}

/// The indices of the parent and of the body.
const PARENT: usize = 0;
const BODY: usize = 1;

/// The number of numbers of a motion: angular velocity and acceleration, acceleration of the
/// origin, gradient.
const MOTION: usize = 18;
/// The number of numbers of a wrench, and of a twist.
const SPATIAL: usize = 6;
/// The number of numbers of an articulated inertia.
const INERTIA: usize = 21;

/// Returns forward dynamics of one body: motions, articulated inertias with wrenches, then
/// accelerations. The joint vectors are `q`, `qd` and `tau`; the result is `qdd`.
#[must_use]
pub fn forward_dynamics_of_bodies<S: Scalar>() -> BodyRecursion<S> {
    BodyRecursion {
        sweeps: &[
            (Sweep::Outward, MOTION),
            (Sweep::Inward, SPATIAL + INERTIA),
            (Sweep::Outward, SPATIAL),
        ],
        body: |model, [q, qd, tau], received| {
            let workspace = &mut Workspace::new(model);
            let block = block(model);
            workspace.reserve(block.dofs.len() * block.dofs.len(), 0, 0);
            workspace.load_joint_forces(model, BODY, q, Some(qd));
            let motion =
                move_body(model, State { q, qd }, Accelerations::FreeFall, received[0], workspace);
            let inertia = model.bodies[BODY].base_inertia.articulated();
            let own_load = load(&workspace.wrenches[BODY], &inertia);

            let (wrench, inertia) = received[1].split_at(SPATIAL);
            workspace.wrenches[BODY] = Wrench::from_components(array(wrench));
            workspace.articulated[BODY] = Some(inertia_from(inertia));
            workspace.composite[BODY] = RigidInertia::zero();
            eliminate_module(model, &block, qd, tau, workspace);
            let nothing = RigidInertia::zero().articulated();
            let inertia = workspace.articulated[PARENT].unwrap_or(nothing);
            let at_parent = load(&workspace.wrenches[PARENT], &inertia);

            workspace.twists[PARENT] = Twist::from_components(array(received[2]));
            let mut qdd = alloc::vec![S::zero(); model.nv];
            accelerate(model, &block, workspace, &mut qdd);
            if is_base(model, BODY) {
                add_free_fall(model, BODY, qd, workspace, &mut qdd);
            }
            let twist = workspace.twists[BODY].components().to_vec();
            BodyResults {
                own: alloc::vec![Vec::new(), own_load, Vec::new()],
                sent: alloc::vec![motion, at_parent, twist],
                result: qdd,
            }
        },
        world: |model| {
            alloc::vec![world_motion(model), Vec::new(), alloc::vec![S::zero(); SPATIAL]]
        },
    }
}

/// Returns inverse dynamics of one body: motions, then wrenches. The joint vectors are `q`, `qd`
/// and `qdd`; the result is `tau`.
#[must_use]
pub fn inverse_dynamics_of_bodies<S: Scalar>() -> BodyRecursion<S> {
    BodyRecursion {
        sweeps: &[(Sweep::Outward, MOTION), (Sweep::Inward, SPATIAL)],
        body: |model, [q, qd, qdd], received| {
            let workspace = &mut Workspace::new(model);
            let accelerations = Accelerations::Given(qdd);
            let motion = move_body(model, State { q, qd }, accelerations, received[0], workspace);

            let own_wrench = workspace.wrenches[BODY].components().to_vec();

            workspace.wrenches[BODY] = Wrench::from_components(array(received[1]));
            let mut tau = alloc::vec![S::zero(); model.nv];
            workspace.load_joint_forces(model, BODY, q, Some(qd));
            joint_torque(model, BODY, qd, Some(qdd), workspace, &mut tau);
            let at_parent = workspace.wrenches[PARENT].components().to_vec();
            BodyResults {
                own: alloc::vec![Vec::new(), own_wrench],
                sent: alloc::vec![motion, at_parent],
                result: tau,
            }
        },
        world: |model| alloc::vec![world_motion(model), Vec::new()],
    }
}

/// Computes the body's motion and wrench from the parent's motion. Returns the body's motion.
fn move_body<S: Scalar>(
    model: &Mechanism<S>,
    State { q, qd }: State<'_, S>,
    accelerations: Accelerations<'_, S>,
    parent: &[S],
    workspace: &mut Workspace<S>,
) -> Vec<S> {
    let vector = |k: usize| Vector3([parent[k], parent[k + 1], parent[k + 2]]);
    workspace.fields[PARENT] = Field {
        omega: vector(0),
        alpha: vector(3),
        a: vector(6),
        gradient: Matrix3([vector(9).0, vector(12).0, vector(15).0]),
        ..Field::zero()
    };
    workspace.motions[BODY] = model.bodies[BODY].motion(q);
    link_wrench(model, BODY, qd, accelerations, workspace);
    motion_numbers(&workspace.fields[BODY])
}

/// Returns the motion of the world, which is accelerated upwards in place of gravity.
fn world_motion<S: Scalar>(model: &Mechanism<S>) -> Vec<S> {
    motion_numbers(&Field { a: -model.gravity, ..Field::zero() })
}

fn motion_numbers<S: Scalar>(field: &Field<S>) -> Vec<S> {
    let [x, y, z] = field.gradient.0;
    [field.omega.0, field.alpha.0, field.a.0, x, y, z].concat()
}

/// Returns the module that has the body alone.
fn block<S: Scalar>(model: &Mechanism<S>) -> ModuleBlock {
    let dofs = model.bodies[BODY].dofs.clone();
    ModuleBlock { bodies: BODY..BODY + 1, dofs, pivot: 0, has_children: true }
}

/// Returns the numbers of a wrench, then the upper triangle of an articulated inertia by rows.
fn load<S: Scalar>(wrench: &Wrench<S>, inertia: &ArticulatedInertia<S>) -> Vec<S> {
    let indices = (0..6).flat_map(|row| (row..6).map(move |column| (row, column)));
    let entries = indices.map(|(row, column)| inertia.entry(row, column));
    wrench.components().into_iter().chain(entries).collect()
}

fn inertia_from<S: Scalar>(numbers: &[S]) -> ArticulatedInertia<S> {
    // Rows of the upper triangle have 6, 5, ... entries.
    ArticulatedInertia::from_fn(|row, column| {
        let first = row.min(column);
        let second = row.max(column);
        numbers[first * (13 - first) / 2 + second - first]
    })
}

fn array<S: Scalar, const N: usize>(numbers: &[S]) -> [S; N] {
    core::array::from_fn(|i| numbers[i])
}
