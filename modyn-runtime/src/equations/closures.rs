//! Closed loops: forward dynamics under the forces that hold the ends of cut joints together.
//!
//! What a closure holds of the second frame's motion against the first, in the first one's axes, is
//! J qd = 0, whose rate is J qdd + dJ/dt qd. With Lagrange's multipliers lambda (Featherstone 2008,
//! "Rigid Body Dynamics Algorithms", 8.2) and Baumgarte's (1972) pull back to phi = 0 and J qd = 0,
//!
//! ```text
//! I qdd = tau - h + J^T lambda
//! J qdd = gamma = -dJ/dt qd - 2 alpha J qd - beta^2 phi
//! ```
//!
//! With qdd_0 the accelerations of the tree, (J I^-1 J^T) lambda = gamma - J qdd_0 and
//! qdd = qdd_0 + I^-1 J^T lambda. Everything that I^-1 stands before is solved for by modules,
//! through U D U^T ([`brge`]).
//!
//! J I^-1 J^T is split as L Delta L^T in the rows' order, so nothing branches on a value. A row that
//! those before it already imply leaves a pivot of nothing but rounding; below a tolerance, against
//! the sum of the diagonal over all rows of its kind (rotations or displacements), a row is taken
//! for redundant: its multiplier is zero, its entries of L are too, and the rest is the solution
//! without it. So accelerations are those of any choice of independent rows, while forces that the
//! rows share, which no rigid body can tell apart, are all given to the first.

use alloc::{vec, vec::Vec};

use super::Workspace;
use super::brge::{self, UduLayout};
use super::dynamics::inverse_dynamics;
use super::kinematics::kinematic_path::{self, Own};
use super::kinematics::links::{Seen, add_columns};
use crate::Scalar;
use crate::mechanism::{BodyFrame, HeldFrames, HeldRow, Mechanism};
use crate::results::ClosureSettings;
use crate::spatial::{Matrix3, Twist, Vector3, Wrench};

/// Memory for closures.
#[derive(Clone, Debug)]
pub struct ClosureWorkspace<S> {
    /// By end: the Jacobian of its frame in its own axes, a column an entry of qd.
    columns: [Vec<Twist<S>>; 2],
    /// By row: whether it holds a rotation.
    angular: Vec<bool>,
    /// J and I^-1 J^T: for each row, as many numbers as qd has.
    jacobian: Vec<S>,
    solved: Vec<S>,
    /// J I^-1 J^T, then L below the diagonal: row k has k + 1 entries from k (k + 1) / 2 on.
    triangle: Vec<S>,
    /// Reciprocals of Delta; zero for a redundant row.
    reciprocals: Vec<S>,
    /// Two right-hand sides, then the multipliers.
    lambda: [Vec<S>; 2],
    factors: Vec<S>,
}

impl<S: Scalar> ClosureWorkspace<S> {
    /// Room for a model whose inertia matrix is factorized in this layout.
    #[must_use]
    pub fn new(model: &Mechanism<S>, layout: &UduLayout) -> Self {
        let rows = model.closures.iter().flat_map(|closure| &closure.rows);
        let angular: Vec<bool> = rows.map(|row| row.angular).collect();
        let rows = angular.len();
        let numbers = |count| vec![S::zero(); count];
        Self {
            columns: [vec![Twist::zero(); model.nv], vec![Twist::zero(); model.nv]],
            angular,
            jacobian: numbers(rows * model.nv),
            solved: numbers(rows * model.nv),
            triangle: numbers(rows * (rows + 1) / 2),
            reciprocals: numbers(rows),
            lambda: [numbers(rows), numbers(rows)],
            factors: numbers(layout.size()),
        }
    }

    /// Adds I^-1 J^T lambda.
    fn answer(&self, side: usize, sum: &mut [S]) {
        for (&lambda, row) in self.lambda[side].iter().zip(self.solved.chunks(sum.len().max(1))) {
            for (sum, &x) in sum.iter_mut().zip(row) {
                *sum = *sum + x * lambda;
            }
        }
    }
}

/// The accelerations under the torques `tau` and what closures hold, and the `forces` that hold it:
/// for each closure that on the second link, at the second frame's origin in the first one's axes;
/// the first link feels the opposite.
pub fn constrained_forward_dynamics<S: Scalar>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    (q, qd, tau): (&[S], &[S], &[S]),
    settings: &ClosureSettings<S>,
    (workspace, room): (&mut Workspace<S>, &mut ClosureWorkspace<S>),
    (qdd, forces): (&mut [S], &mut [Wrench<S>]),
) {
    let n = model.nv;
    inverse_dynamics(model, (q, qd, None), None, workspace, qdd);
    for (qdd, &tau) in qdd.iter_mut().zip(tau) {
        *qdd = tau - *qdd;
    }
    brge::factorize(model, layout, q, workspace, &mut room.factors);
    brge::solve(layout, &room.factors, qdd);

    let two_alpha = settings.alpha + settings.alpha;
    let beta_squared = settings.beta * settings.beta;
    constraints(model, (q, qd), workspace, room, |row, found| {
        let pull = two_alpha * row.of(found.velocity) + beta_squared * row.of(found.displacement);
        [-row.of(found.rate) - pull, S::zero()]
    });
    split(layout, n, settings.tolerance, room);
    for (lambda, row) in room.lambda[0].iter_mut().zip(room.jacobian.chunks(n.max(1))) {
        *lambda = dot(row, qdd).map_or(*lambda, |felt| *lambda - felt);
    }
    solve(room, 0);
    room.answer(0, qdd);
    let mut lambda = room.lambda[0].iter();
    for (force, closure) in forces.iter_mut().zip(&model.closures) {
        let Twist { angular, linear } = along(closure, lambda.by_ref().copied());
        *force = Wrench { moment: angular, force: linear };
    }
}

/// How far each closure's frames are from where they are held, and how fast they part: of the second
/// frame against the first, in the first one's axes, without what is free. A rotation is given by
/// its axis times the sine of its angle.
pub fn closure_errors<S: Scalar>(
    model: &Mechanism<S>,
    (q, qd): (&[S], &[S]),
    workspace: &mut Workspace<S>,
    (displacements, velocities): (&mut [Twist<S>], &mut [Twist<S>]),
) {
    let errors = displacements.iter_mut().zip(velocities);
    for (closure, (displacement, velocity)) in model.closures.iter().zip(errors) {
        let seen = closure.ends.map(|end| seen(model, end, common(model, closure), q, |_, _| {}));
        let found = parting(model, closure, &Between::new(&seen), (q, qd), workspace);
        let held = |twist| along(closure, closure.rows.iter().map(|row| row.of(twist)));
        (*displacement, *velocity) = (held(found.displacement), held(found.velocity));
    }
}

/// The step that, to first order, closes the loops at `q`, and the change of `qd` that keeps them
/// closed: the smallest in the metric of the inertia matrix, I^-1 J^T (J I^-1 J^T)^-1 times what
/// they are apart.
pub fn closing_step<S: Scalar>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    (q, qd): (&[S], &[S]),
    settings: &ClosureSettings<S>,
    (workspace, room): (&mut Workspace<S>, &mut ClosureWorkspace<S>),
    (dq, dqd): (&mut [S], &mut [S]),
) {
    brge::factorize(model, layout, q, workspace, &mut room.factors);
    constraints(model, (q, qd), workspace, room, |row, found| {
        [-row.of(found.displacement), -row.of(found.velocity)]
    });
    split(layout, model.nv, settings.tolerance, room);
    for (k, step) in [dq, dqd].into_iter().enumerate() {
        step.fill(S::zero());
        solve(room, k);
        room.answer(k, step);
    }
}

/// J; what each row is to be goes in the place of lambda.
fn constraints<S: Scalar>(
    model: &Mechanism<S>,
    (q, qd): (&[S], &[S]),
    workspace: &mut Workspace<S>,
    room: &mut ClosureWorkspace<S>,
    target: impl Fn(&HeldRow<S>, &Parting<S>) -> [S; 2],
) {
    let mut rows = room.jacobian.chunks_mut(model.nv.max(1)).enumerate();
    for closure in &model.closures {
        let above = common(model, closure);
        let reach = |end, columns: &mut [Twist<S>]| {
            columns.fill(Twist::zero());
            seen(model, end, above, q, |i, seen| {
                add_columns(model, i, &seen.axes, seen.point, columns);
            })
        };
        let ([a, b], [first, second]) = (closure.ends, &mut room.columns);
        let between = Between::new(&[reach(a, first), reach(b, second)]);
        let found = parting(model, closure, &between, (q, qd), workspace);
        let columns = || first.iter().zip(&*second).map(|(&a, &b)| between.motion(a, b));
        for (row, (k, entries)) in closure.rows.iter().zip(&mut rows) {
            for (entry, column) in entries.iter_mut().zip(columns()) {
                *entry = row.of(column);
            }
            [room.lambda[0][k], room.lambda[1][k]] = target(row, &found);
        }
    }
}

impl<S: Scalar> HeldRow<S> {
    /// What of a twist it holds.
    fn of(&self, twist: Twist<S>) -> S {
        self.direction.dot(if self.angular { twist.angular } else { twist.linear })
    }
}

/// The sum of a closure's directions, times these numbers.
fn along<S: Scalar>(closure: &HeldFrames<S>, numbers: impl Iterator<Item = S>) -> Twist<S> {
    let mut sum = Twist::zero();
    // The numbers may go on: the rows come first.
    for (row, number) in closure.rows.iter().zip(numbers) {
        let part = if row.angular { &mut sum.angular } else { &mut sum.linear };
        *part += row.direction.scale(number);
    }
    sum
}

/// The body that carries both ends of a closure, or the world: its motion parts nothing.
fn common<S>(model: &Mechanism<S>, closure: &HeldFrames<S>) -> Option<usize> {
    let [mut a, mut b] = closure.ends.each_ref().map(|end| end.body);
    while a != b {
        // Parents come before their children, and the world before all.
        let later = if a > b { &mut a } else { &mut b };
        *later = later.and_then(|i| model.bodies[i].parent);
    }
    a
}

/// The bodies from a frame to the one `above`, that one left out.
fn between<S>(
    model: &Mechanism<S>,
    end: BodyFrame<S>,
    above: Option<usize>,
) -> impl Iterator<Item = usize> {
    kinematic_path::towards_world(model, end.body).take_while(move |&i| Some(i) != above)
}

/// A frame seen from the body `above`; `visit` meets it seen from each body on the way.
fn seen<S: Scalar>(
    model: &Mechanism<S>,
    end: BodyFrame<S>,
    above: Option<usize>,
    q: &[S],
    mut visit: impl FnMut(usize, &Seen<S>),
) -> Seen<S> {
    between(model, end, above).fold(Seen::fixed(&end.pose), |seen, i| {
        visit(i, &seen);
        seen.towards_world(&model.bodies[i], q)
    })
}

/// Where the second frame stands against the first, in the first one's axes.
struct Between<S> {
    /// Its axes, as columns.
    turn: Matrix3<S>,
    /// Its origin.
    point: Vector3<S>,
}

impl<S: Scalar> Between<S> {
    fn new([first, second]: &[Seen<S>; 2]) -> Self {
        Self {
            turn: first.axes.times(&second.axes.transposed()),
            point: first.axes.mul_vector(second.point - first.point),
        }
    }

    /// A velocity of the second frame in the first one's axes.
    fn turned(&self, second: Twist<S>) -> Twist<S> {
        let Twist { angular, linear } = second;
        Twist { angular: self.turn.mul_vector(angular), linear: self.turn.mul_vector(linear) }
    }

    /// The velocity of the second frame as it is seen from the first, from those of both in their
    /// own axes.
    fn motion(&self, first: Twist<S>, second: Twist<S>) -> Twist<S> {
        let second = self.turned(second);
        Twist {
            angular: second.angular - first.angular,
            linear: second.linear - first.linear - first.angular.cross(self.point),
        }
    }

    /// How far the frames are turned against each other, or their hinge.
    fn rotation(&self, hinge: Option<Vector3<S>>) -> Vector3<S> {
        if let Some(hinge) = hinge {
            return hinge.cross(self.turn.mul_vector(hinge));
        }
        let Matrix3([[_, xy, xz], [yx, _, yz], [zx, zy, _]]) = self.turn;
        Vector3([zy - yz, xz - zx, yx - xy]).scale(S::from_f64(0.5))
    }
}

/// How the second frame moves as it is seen from the first.
struct Parting<S> {
    displacement: Twist<S>,
    velocity: Twist<S>,
    /// The rate of the velocity's numbers while qd does not change.
    rate: Twist<S>,
}

fn parting<S: Scalar>(
    model: &Mechanism<S>,
    closure: &HeldFrames<S>,
    stands: &Between<S>,
    motion: (&[S], &[S]),
    workspace: &mut Workspace<S>,
) -> Parting<S> {
    let above = common(model, closure);
    let [first, second] = closure.ends.map(|end| {
        workspace.kinematic_path.clear();
        workspace.kinematic_path.extend(between(model, end, above));
        let bodies = workspace.kinematic_path.iter().rev();
        bodies.fold(Own::at_rest(), |own, &i| own.carried_to(model, i, motion)).at(&end.pose)
    });
    let velocity = stands.motion(first.velocity, second.velocity);
    // The second frame's numbers are in axes that turn against the first frame's, and the first
    // frame's velocity at the second one's origin changes as that moves.
    let (omega, turned) = (first.velocity.angular, stands.turned(second.velocity));
    let turning = Twist {
        angular: velocity.angular.cross(turned.angular),
        linear: velocity.angular.cross(turned.linear) - omega.cross(velocity.linear),
    };
    Parting {
        displacement: Twist { angular: stands.rotation(closure.hinge), linear: stands.point },
        velocity,
        rate: stands.motion(first.rate, second.rate) + turning,
    }
}

/// I^-1 J^T, and J I^-1 J^T as L Delta L^T.
fn split<S: Scalar>(layout: &UduLayout, n: usize, tolerance: S, room: &mut ClosureWorkspace<S>) {
    let ClosureWorkspace { angular, jacobian, solved, triangle, reciprocals, factors, .. } = room;
    solved.copy_from_slice(jacobian);
    for row in solved.chunks_mut(n.max(1)) {
        brge::solve(layout, factors, row);
    }
    for (k, held) in jacobian.chunks(n.max(1)).enumerate() {
        for (entry, solved) in
            triangle[start(k)..=start(k) + k].iter_mut().zip(solved.chunks(n.max(1)))
        {
            *entry = dot(held, solved).unwrap_or(S::zero());
        }
    }
    let least = [false, true].map(|kind| {
        let of_kind = (0..angular.len()).filter(|&k| angular[k] == kind);
        of_kind.map(|k| triangle[start(k) + k]).fold(S::zero(), |sum, x| sum + x) * tolerance
    });
    for k in 0..angular.len() {
        let (before, own) = triangle.split_at_mut(start(k));
        for l in 0..k {
            let taken = dot(&own[..l], &before[start(l)..][..l]);
            own[l] = taken.map_or(own[l], |taken| own[l] - taken);
        }
        let mut pivot = own[k];
        for (entry, &reciprocal) in own[..k].iter_mut().zip(&*reciprocals) {
            let scaled = *entry * reciprocal;
            pivot = pivot - *entry * scaled;
            *entry = scaled;
        }
        let redundant = least[usize::from(angular[k])] - pivot;
        let reciprocal = redundant.select_nonnegative(S::one(), pivot).recip();
        reciprocals[k] = redundant.select_nonnegative(S::zero(), reciprocal);
    }
}

/// Where row `k` of the triangle starts.
fn start(k: usize) -> usize {
    k * (k + 1) / 2
}

/// lambda := (L Delta L^T)^-1 lambda.
fn solve<S: Scalar>(room: &mut ClosureWorkspace<S>, side: usize) {
    let ClosureWorkspace { triangle, reciprocals, lambda, .. } = room;
    let lambda = &mut lambda[side];
    for k in 0..lambda.len() {
        let (before, own) = lambda.split_at_mut(k);
        let taken = dot(before, &triangle[start(k)..][..k]);
        own[0] = taken.map_or(own[0], |taken| own[0] - taken);
    }
    for (lambda, &reciprocal) in lambda.iter_mut().zip(&*reciprocals) {
        *lambda = *lambda * reciprocal;
    }
    for k in (0..lambda.len()).rev() {
        let (before, own) = lambda.split_at_mut(k);
        for (lambda, &entry) in before.iter_mut().zip(&triangle[start(k)..]) {
            *lambda = *lambda - entry * own[0];
        }
    }
}

fn dot<S: Scalar>(a: &[S], b: &[S]) -> Option<S> {
    a.iter().zip(b).map(|(&a, &b)| a * b).reduce(|sum, x| sum + x)
}
