//! Constrained dynamics: loop joints hold two links together, contacts hold links on the world.
//!
//! | file | content |
//! |---|---|
//! | `relative_motion` | the motion of a loop constraint's second frame relative to its first |
//! | `contact` | the motion of a contact's frame relative to its target |
//! | `lanes` | the rows of merged contacts |
//! | `rows` | the Jacobian rows in units of length, and the mobility of each constraint |
//! | `factorization` | the pseudo-inverse of J M^-1 J^T, and its rank |
//! | `full_rank` | the same without exchanges, where all rows are independent |
//! | `forward_dynamics` | accelerations and constraint wrenches |
//! | `derivatives` | derivatives of forward dynamics |
//! | `derivative_terms` | the sums that constraints add their parts of the derivatives to |
//! | `path` | the joints that move a point, and the derivatives of its motion |
//! | `loop_derivatives` | the part of loop constraints in the derivatives |
//! | `impulse` | velocities after an impact, and the impulses |
//! | `inverse_dynamics` | joint forces of accelerations, and the contact wrenches that carry a floating base |
//! | `jacobian` | the Jacobian and the bias acceleration |
//! | `operational_space_inertia` | J M^-1 J^T and its pseudo-inverse |
//! | `projection` | steps of coordinates and velocities that satisfy the constraints |
//! | `residual` | displacements and velocities that violate the constraints |
//!
//! A constraint consists of rows J qd = 0. Each row is a component of the second frame's twist
//! relative to the first frame, in the first frame's axes. The time derivative of a row is J qdd +
//! dJ/dt qd. With multipliers lambda (Featherstone 2008, "Rigid Body Dynamics Algorithms", 8.2) and
//! the stabilization of Baumgarte (1972), which drives phi and J qd to zero, the equations are
//!
//! ```text
//! M qdd = tau - h + J^T lambda
//! J qdd = gamma = -dJ/dt qd - 2 alpha J qd - beta^2 phi
//! ```
//!
//! With the accelerations qdd_0 of the tree without constraints, lambda = (J M^-1 J^T)^+ (gamma - J
//! qdd_0) and qdd = qdd_0 + M^-1 J^T lambda. The factors M = U D U^T by modules, D = V Delta V^T
//! ([`brge`](super::brge)), are applied in halves: with W = U V, only W^-1 J^T, W^-1 (tau - h) and
//! one product with W^-T are computed.
//!
//! A contact is a constraint between the world and a link. The rows of an inactive contact are
//! zero. They count as dependent rows, and their multipliers are zero. No branch depends on a
//! value.
//!
//! Rotation rows are multiplied by the constraint's characteristic length l
//! ([`Model::characteristic_length`](crate::model::Model::characteristic_length)). Where rows are
//! redundant, the multipliers minimize the sum of force^2 + (moment / l)^2 over all constraints.
//! Where rows contradict each other, the accelerations minimize the sum of the squared residuals,
//! linear^2 + (l angular)^2. Neither sum depends on the orientation of the mechanism.
//!
//! The model is always a tree: the joint that was cut is a `LoopConstraint` beside it, and a foot
//! is a `Contact`. Only this folder reads both, as one list of constrained frames. Redundant rows
//! are found by pivoting over all constraints together, with selections in place of branches,
//! against the mobility of each constraint in all six directions. Contacts of merged limbs have a
//! lane for each limb; the factorization takes them out of the lanes (`lanes`), since it couples
//! all contacts.

mod adjoint;
mod arguments;
mod contact;
mod derivative_terms;
mod derivatives;
mod factorization;
mod forward_dynamics;
mod full_rank;
mod impulse;
mod inverse_dynamics;
mod jacobian;
pub(in crate::equations) mod lanes;
mod loop_derivatives;
mod operational_space_inertia;
mod path;
mod projection;
mod relative_motion;
mod residual;
mod rows;

pub use factorization::RowSystem;
pub use {
    adjoint::*, arguments::*, derivatives::*, forward_dynamics::*, impulse::*, inverse_dynamics::*,
    jacobian::*, operational_space_inertia::*, projection::*, residual::*,
};

use alloc::{vec, vec::Vec};

use super::Workspace;
use super::dynamics::newton_euler::{free_fall, is_base};
use super::factorization::limb_coupling::{FactorLayout, Factorizable, Limb, LimbAccess};
use super::factorization::{solve_lower_factor, solve_upper_factor};
use crate::Scalar;
use crate::constraint_settings::{ConstraintSettings, ContactTarget};
use crate::mechanism::{ConstrainedFrames, Mechanism};
use crate::spatial::{Matrix3, Twist, Vector3, Wrench};
use contact::ContactFrame;
use derivative_terms::DerivativeWorkspace;
use factorization::Factorization;
use inverse_dynamics::Carried;
use lanes::RowLanes;

/// The entries of qd in which the rows of a constraint, multiplied by W^-1, are not zero by
/// structure.
#[derive(Clone, Debug)]
struct Support {
    /// The modules of these entries, ascending.
    modules: Vec<usize>,
    /// The entries, ascending.
    entries: Vec<usize>,
    /// For each entry of qd whether it is one of these.
    has: Vec<bool>,
    /// The merged limb that carries the constraint; `None` without merged limbs and on the trunk.
    limb: Option<Limb>,
}

/// Memory for the intermediate results of constrained dynamics.
#[derive(Clone, Debug)]
pub struct ConstraintWorkspace<S> {
    /// For each of the two frames: its Jacobian, a column for each entry of qd.
    columns: [Vec<Twist<S>>; 2],
    /// The number of constrained rows.
    rows: usize,
    /// For each row, constrained or free, the index of its constraint.
    owner: Vec<usize>,
    /// For each constraint, the nonzero entries of its rows.
    supports: Vec<Support>,
    /// For each contact, its frame at the present coordinates.
    frames: Vec<ContactFrame<S>>,
    /// J and W^-1 J^T: the constrained rows of all constraints, then the free rows. A row has nv
    /// entries.
    jacobian: Vec<S>,
    reduced: Vec<S>,
    /// W^-1 times a joint force.
    force: Vec<S>,
    /// For each entry of qd, the acceleration of floating bases in free fall.
    fall: Vec<S>,
    /// Zero velocities.
    rest: Vec<S>,
    /// For each constraint, the trace of J M^-1 J^T over all six directions.
    mobilities: Vec<S>,
    /// The constrained rows of the robot among the rows of merged limbs.
    lanes: RowLanes,
    /// The factorization of J M^-1 J^T, the robot's constrained rows only.
    factorization: Factorization<S>,
    /// For each constraint of the robot, its mobility.
    scales: Vec<S>,
    /// For each constrained row of the robot, its multiplier, and the part of the right-hand side
    /// that is not met.
    solution: [Vec<S>; 2],
    /// Two right-hand sides, an entry for each constrained row; `solve` replaces them by
    /// multipliers.
    right_hand_sides: [Vec<S>; 2],
    /// For each constrained row, the part of the right-hand side that is not met.
    residuals: Vec<S>,
    /// Memory for inverse dynamics.
    carried: Carried<S>,
    /// Memory for derivatives; `None` before their first call.
    derivatives: Option<DerivativeWorkspace<S>>,
    /// The factors of the mass matrix.
    factors: Vec<S>,
}

impl<S: Scalar> ConstraintWorkspace<S> {
    /// Returns memory for `tree`, whose mass matrix is factorized with `limbs`.
    #[must_use]
    pub fn new<T: Factorizable<S>>(tree: &T, limbs: &T::Layout) -> Self {
        let model = tree.mechanism();
        let layout = limbs.layout();
        let constraints = || model.constraints.iter();
        let rows = constraints().map(|constraint| constraint.rows.len()).sum();
        let free: usize = constraints().map(|constraint| constraint.free.len()).sum();
        let moving: Vec<Vec<bool>> = constraints().map(|c| moving_entries(model, c)).collect();
        let moves = |moving: &Vec<bool>| moving.iter().filter(|&&moves| moves).count();
        let supports: Vec<Support> =
            moving.iter().map(|moving| Support::new(limbs, moving)).collect();
        let of_limbs = supports.iter().map(|support| support.limb.map_or(1, Limb::count));
        let lanes = RowLanes::new(tree, of_limbs);
        let of_constraints = lanes.constraints().iter();
        let blocks = of_constraints.map(|&(c, _)| {
            let constraint = &model.constraints[c];
            let rows = constraint.rows.len();
            // Every row of a compliant contact is independent.
            (rows, if constraint.contact { rows } else { moves(&moving[c]) })
        });
        let owner = |rows: fn(&ConstrainedFrames<S>) -> usize| {
            constraints().enumerate().flat_map(move |(i, c)| core::iter::repeat_n(i, rows(c)))
        };
        let numbers = |count| vec![S::zero(); count];
        Self {
            columns: [vec![Twist::zero(); model.nv], vec![Twist::zero(); model.nv]],
            rows,
            owner: owner(|c| c.rows.len()).chain(owner(|c| c.free.len())).collect(),
            frames: Vec::with_capacity(model.contacts()),
            jacobian: numbers((rows + free) * model.nv),
            reduced: numbers((rows + free) * model.nv),
            force: numbers(model.nv),
            fall: numbers(model.nv),
            rest: numbers(model.nv),
            mobilities: numbers(model.constraints.len()),
            factorization: Factorization::new(blocks),
            supports,
            scales: numbers(lanes.constraints().len()),
            solution: [numbers(lanes.count()), numbers(lanes.count())],
            lanes,
            right_hand_sides: [numbers(rows), numbers(rows)],
            residuals: numbers(rows),
            carried: Carried::new(model, rows),
            derivatives: None,
            factors: numbers(layout.size()),
        }
    }

    /// Makes the multipliers where rows may be dependent these numbers, which are computed
    /// elsewhere. They are the results of [`RowSystem::solve`] for the system that
    /// [`system_apart`](Self::system_apart) returns.
    pub fn set_apart(&mut self, given: Vec<S>) {
        self.factorization.set_apart(given);
    }

    /// Returns the equations of the multipliers that were [set apart](Self::set_apart), and a
    /// number that is not negative only if these do not count, since all rows are independent.
    /// `None` if some rows are dependent in all states.
    pub fn system_apart(&mut self) -> Option<(RowSystem<S>, S)> {
        self.factorization.system_apart()
    }

    /// Factorizes J M^-1 J^T of the current rows, lets `complete` change the right-hand sides, and
    /// sets the sides of inactive contacts to zero.
    fn factorize<T: Factorizable<S>, C: AsRef<[ContactTarget<S>]>>(
        &mut self,
        tree: &T,
        limbs: &T::Layout,
        ConstraintInput { active, settings }: ConstraintInput<'_, S, C>,
        complete: impl FnOnce(&mut Self),
    ) {
        self.fill(tree, limbs, ConstraintInput { active, settings });
        self.factorize_filled(tree, settings);
        complete(self);
        let loops = tree.mechanism().constraints.len() - active.len();
        for side in &mut self.right_hand_sides {
            for (b, &constraint) in side.iter_mut().zip(&self.owner) {
                if let Some(contact) = constraint.checked_sub(loops) {
                    *b = *b * active[contact];
                }
            }
        }
    }

    /// Computes J M^-1 J^T of the current rows.
    fn fill<T: Factorizable<S>, C: AsRef<[ContactTarget<S>]>>(
        &mut self,
        tree: &T,
        limbs: &T::Layout,
        ConstraintInput { active, settings }: ConstraintInput<'_, S, C>,
    ) {
        rows::mobilities(tree, limbs, active, settings.targets.as_ref(), self);
    }

    fn factorize_filled<T: Factorizable<S>, C>(
        &mut self,
        tree: &T,
        settings: &ConstraintSettings<S, C>,
    ) {
        for (scale, &(constraint, lane)) in self.scales.iter_mut().zip(self.lanes.constraints()) {
            *scale = tree.extract_lane(self.mobilities[constraint], lane);
        }
        let tolerance = settings.tolerance;
        let rounding = settings.rounding;
        self.factorization.factorize(&self.scales, tolerance, rounding);
    }

    /// The factor of a constrained row's units: the characteristic length of a rotation, else 1.
    fn row_length(&self, model: &Mechanism<S>, row: usize) -> S {
        let constraint = self.owner[row];
        let first = self.owner.iter().position(|&c| c == constraint).unwrap_or(row);
        let constraint = &model.constraints[constraint];
        if constraint.rows[row - first].angular { constraint.length } else { S::one() }
    }

    /// Expresses the Jacobian's rows of contacts in other axes: world axes, rotated to the
    /// axes that are the columns of the contact's matrix.
    fn rotate_contact_rows(&mut self, model: &Mechanism<S>, axes: impl Fn(usize) -> Matrix3<S>) {
        let n = model.nv.max(1);
        let mut next = 0;
        let mut frames = self.frames.iter().enumerate();
        for constraint in &model.constraints {
            let count = constraint.rows.len();
            if let Some((contact, frame)) = constraint.contact.then(|| frames.next()).flatten() {
                let rotation = frame.root_to(&axes(contact));
                for first in (next..next + count).step_by(3) {
                    let rotate = |three: &mut [S], stride: usize, k: usize| {
                        let column = Vector3([0, 1, 2].map(|i| three[i * stride + k]));
                        let rotated = rotation.mul_vector(column);
                        (0..3).for_each(|i| three[i * stride + k] = rotated[i]);
                    };
                    let rows = &mut self.jacobian[first * n..(first + 3) * n];
                    (0..n).for_each(|k| rotate(rows, n, k));
                    for side in &mut self.right_hand_sides {
                        rotate(&mut side[first..first + 3], 1, 0);
                    }
                }
            }
            next += count;
        }
    }

    /// Replaces right-hand side `side` by its multipliers.
    fn solve<T: Factorizable<S>>(&mut self, tree: &T, side: usize) {
        let Self { factorization, right_hand_sides, residuals, solution, lanes, .. } = self;
        let [multipliers, missed] = solution;
        lanes.unpack(tree, &right_hand_sides[side], multipliers);
        factorization.solve(multipliers, missed);
        lanes.pack(tree, multipliers, &mut right_hand_sides[side]);
        lanes.pack(tree, missed, residuals);
    }

    /// Sets `force` to W^-1 times this joint force.
    fn set_force<L: FactorLayout<S>>(&mut self, limbs: &L, force: &[S]) {
        self.force.copy_from_slice(force);
        solve_upper_factor(limbs, &self.factors, &mut self.force);
    }

    /// Sets `fall` to the acceleration of floating bases in free fall. Expects the bases' angular
    /// velocities.
    fn set_fall(&mut self, model: &Mechanism<S>, qd: &[S], workspace: &Workspace<S>) {
        self.fall.fill(S::zero());
        for i in (0..model.bodies.len()).filter(|&i| is_base(model, i)) {
            // The base's numbers are contiguous, the linear ones first.
            let first = model.dofs_of(i)[0].v;
            self.fall[first..first + 3].copy_from_slice(&free_fall(model, i, qd, workspace).0);
        }
    }

    /// Subtracts J M^-1 f of the joint force f, and for loop constraints the accelerations by free
    /// fall, from the first right-hand side. Expects W^-1 J^T. (The accelerations of contacts are
    /// relative to free fall.)
    fn subtract_accelerations<L: FactorLayout<S>>(&mut self, model: &Mechanism<S>, limbs: &L) {
        let Self { right_hand_sides: [b, _], jacobian, reduced, supports, owner, .. } = self;
        let reciprocals = &self.factors[limbs.layout().reciprocals()];
        let n = self.force.len().max(1);
        for (k, (b, &c)) in b.iter_mut().zip(&*owner).enumerate() {
            let row = &reduced[k * n..][..n];
            let rates = &jacobian[k * n..][..n];
            let entries = || supports[c].entries.iter();
            *b = entries().fold(*b, |b, &k| b - row[k] * (self.force[k] * reciprocals[k]));
            if !model.constraints[c].contact {
                *b = entries().fold(*b, |b, &k| b - rates[k] * self.fall[k]);
            }
        }
    }

    /// Computes the joints' response M^-1 (f + J^T lambda) to the joint force f and the multipliers
    /// lambda of right-hand side `side`.
    fn respond<L: FactorLayout<S>>(&self, limbs: &L, side: usize, response: &mut [S]) {
        response.copy_from_slice(&self.force);
        let layout = limbs.layout();
        let n = response.len().max(1);
        let mut first = 0;
        for owned in self.owner[..self.rows].chunk_by(|a, b| a == b) {
            let rows = first..first + owned.len();
            first = rows.end;
            let support = &self.supports[owned[0]];
            for &k in &support.entries {
                let shares = rows
                    .clone()
                    .map(|row| self.reduced[row * n + k] * self.right_hand_sides[side][row]);
                let Some(share) = shares.reduce(|sum, x| sum + x) else { continue };
                // All limbs move the trunk.
                let limb = support.limb.filter(|_| limbs.limb_of_dof(k).is_none());
                let share = limb.map_or(share, |limb| limbs.sum_limbs(share, limb.count()));
                response[k] = response[k] + share;
            }
        }
        self.scale(limbs, response);
        solve_lower_factor(layout, &self.factors, response);
    }

    /// Multiplies a joint vector by Delta^-1.
    fn scale<L: FactorLayout<S>>(&self, limbs: &L, x: &mut [S]) {
        for (x, &reciprocal) in x.iter_mut().zip(&self.factors[limbs.layout().reciprocals()]) {
            *x = *x * reciprocal;
        }
    }

    /// Calls `each` for each constraint with its index and the sum of its rows' directions times
    /// these components, which has one entry for each constrained row. The sum is in the first
    /// frame's axes for a loop constraint, in world axes for a contact.
    fn by_constraint(
        &self,
        model: &Mechanism<S>,
        components: &[S],
        mut each: impl FnMut(usize, &ConstrainedFrames<S>, Twist<S>),
    ) {
        let mut components = components.iter().copied();
        let mut frames = self.frames.iter();
        for (c, constraint) in model.constraints.iter().enumerate() {
            let sum = constraint.along_rows(components.by_ref());
            let frame = constraint.contact.then(|| frames.next()).flatten();
            each(c, constraint, frame.map_or(sum, |frame| frame.twist_to_world(sum)));
        }
    }

    /// Computes the wrenches of the multipliers of right-hand side `side`; in the axes of
    /// [`by_constraint`](Self::by_constraint).
    fn wrenches(&self, model: &Mechanism<S>, side: usize, wrenches: &mut [Wrench<S>]) {
        self.wrenches_of(model, &self.right_hand_sides[side], wrenches);
    }

    /// Computes the wrenches of these multipliers, as [`wrenches`](Self::wrenches) does.
    fn wrenches_of(&self, model: &Mechanism<S>, multipliers: &[S], wrenches: &mut [Wrench<S>]) {
        self.by_constraint(model, multipliers, |c, constraint, sum| {
            let moment = sum.angular.scale(constraint.length);
            wrenches[c] = Wrench { moment, force: sum.linear };
        });
    }

    /// Computes the residuals of the last solution; in the axes of
    /// [`by_constraint`](Self::by_constraint).
    fn missed(&self, model: &Mechanism<S>, residuals: &mut [Twist<S>]) {
        self.by_constraint(model, &self.residuals, |c, constraint, sum| {
            residuals[c] = Twist { angular: sum.angular.scale(constraint.length.recip()), ..sum };
        });
    }
}

impl Support {
    /// Returns the support of rows that these entries of qd move.
    fn new<S: Scalar, L: FactorLayout<S>>(limbs: &L, moving: &[bool]) -> Self {
        let layout = limbs.layout();
        let mut has = moving.to_vec();
        let mut modules = Vec::new();
        for (m, block) in layout.blocks().iter().enumerate().rev() {
            if has[block.dofs.clone()].contains(&true) {
                modules.insert(0, m);
                has[block.dofs.clone()].fill(true);
                layout.rows(m).for_each(|(dof, _)| has[dof] = true);
            }
        }
        let entries: Vec<usize> = (0..has.len()).filter(|&k| has[k]).collect();
        let limb = entries.iter().find_map(|&k| limbs.limb_of_dof(k));
        Self { modules, entries, has, limb }
    }
}

/// Returns for each entry of qd whether it moves the two frames of a constraint relative to each
/// other. The rank of the constraint's rows is at most the number of these entries, without
/// compliance.
fn moving_entries<S>(model: &Mechanism<S>, constraint: &ConstrainedFrames<S>) -> Vec<bool> {
    let ancestor = relative_motion::common_ancestor(model, constraint);
    let mut moving = vec![false; model.nv];
    for end in &constraint.ends {
        let mut body = end.body;
        while let Some(i) = body.filter(|_| body != ancestor) {
            for dof in &model.dofs[model.bodies[i].dofs.clone()] {
                moving[dof.v] = true;
            }
            body = model.bodies[i].parent;
        }
    }
    moving
}
