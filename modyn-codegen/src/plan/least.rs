//! The least operations of a function, which are known before it is traced: a function that is far
//! too long is refused at once.
//!
//! An operation on constants is none. So entries of matrices count only if they vary: if they
//! differ at two configurations.

use modyn_runtime::Interpreter;
use modyn_runtime::equations::kinematics::coordinates;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::Model;
use modyn_runtime::quantities::Function;
use modyn_runtime::spatial::Twist;

use super::context::PlanContext;
use super::fused::FusedFunction;
use super::limit::{MAX_NODES, MAX_OPERATIONS, RESULTS};

/// The number of constraints whose rows are counted. Rows of as many points in contact with the
/// ground, if they depend on one another, take ten times as many operations as all functions may
/// have.
const COUNTED_CONSTRAINTS: usize = 120;

/// The largest number of equal entries in the factors of a mass matrix. Parallel joints have equal
/// entries.
const EQUAL_ENTRIES: usize = 4;

/// The relative difference of two values that vary. A smaller one may be rounding.
const VARIES: f64 = 1e-6;

impl PlanContext<'_> {
    /// Returns a number of operations that a function takes at least, without tracing it: some for
    /// its results, for the factors of the mass matrix if the function has a dense solution or
    /// result, one for each ancestor of a link, and some for the elimination of constraint rows. A
    /// step with a solver takes at least the operations of forward dynamics.
    /// `usize::MAX` if its graph on scalars alone has too many nodes.
    pub(super) fn least_operations(&self, function: Function) -> usize {
        let row = function.row();
        let sizes = &self.sizes;
        let numbers = (row.result)(sizes).len();
        let programs = if row.by_link { self.frames.program_count() } else { 1 };
        let one = function.batched().unwrap_or(function);
        let is_dense = numbers >= sizes.nv * sizes.nv
            || row.of_constraints
            || matches!(one, Function::StepImplicitMidpoint);
        // The factors of a chain of n joints have n^2 / 2 entries, and take n^3 / 3 operations.
        let factors = if is_dense { self.for_derivatives.size() * sizes.nv / 64 } else { 0 };
        let paths = if row.by_link { self.ancestors_of_links() } else { 0 };
        let least = numbers.saturating_mul(programs) / RESULTS + factors + paths;
        if solves_for_columns(one) && self.least_of_columns() > MAX_NODES {
            return usize::MAX;
        }
        let further = match one {
            Function::Brge => self.least_of_factors(),
            _ if row.has_solver => self.forward_dynamics.graph.count().total(),
            _ if eliminates_rows(one) => self.least_of_rows(),
            _ => 0,
        };
        least.saturating_add(further)
    }

    /// Returns a number of operations that a fused function takes at least, without tracing it.
    pub(super) fn least_operations_fused(&self, fused: &FusedFunction) -> usize {
        let of_table = fused.members.iter().filter_map(|member| member.function.of_table());
        let members = of_table.filter(|function| !function.row().by_link);
        members.map(|function| self.least_operations(function)).sum()
    }

    /// Returns the sum of the numbers of ancestors of all links with a program of their own.
    fn ancestors_of_links(&self) -> usize {
        let mut depths: Vec<usize> = Vec::new();
        for link in self.model.moving_links() {
            // Parents come before their children.
            depths.push(link.parent.map_or(0, |parent| depths[parent] + 1));
        }
        let depth = |link: usize| self.model.links()[link].moving_link.map_or(0, |i| depths[i]);
        self.frames.links_with_own_program().map(depth).sum()
    }

    /// Returns the least operations of the derivatives of accelerations by q and qd: two solutions
    /// with the factors of the mass matrix for each joint, whose right-hand sides have an entry for
    /// each ancestor. Each takes two operations for each entry of the factors from the root to the
    /// joint, once towards the root and once back.
    fn least_of_columns(&self) -> usize {
        let n = self.sizes.nv;
        if n * n * n <= MAX_NODES / 8 {
            return 0;
        }
        8 * self.coupled_ancestors().map(|ancestors| ancestors.pow(2)).sum::<usize>()
    }

    /// Returns the least operations of the factors of the mass matrix: one for each entry. Entries
    /// may be equal to a few others.
    fn least_of_factors(&self) -> usize {
        if self.layout.size() / EQUAL_ENTRIES <= MAX_OPERATIONS {
            return 0;
        }
        self.coupled_ancestors().sum::<usize>() / EQUAL_ENTRIES
    }

    /// Returns, for each joint, the number of ancestors with an entry of the mass matrix that
    /// varies.
    fn coupled_ancestors(&self) -> impl Iterator<Item = usize> {
        let n = self.sizes.nv;
        let matrices = self.at_two_configurations(self.model, |robot, q| {
            let mut columns = vec![0.0; n * n];
            robot.mass_matrix(q, &mut columns).ok().map(|()| columns)
        });
        matrices.into_iter().flat_map(move |[first, second]| {
            (0..n).map(move |joint| {
                let scale = |i: usize| (first[i * (n + 1)] * first[joint * (n + 1)]).abs().sqrt();
                let entry = |i: usize| joint * n + i;
                let varies =
                    |i: &usize| (first[entry(*i)] - second[entry(*i)]).abs() > VARIES * scale(*i);
                (0..joint).filter(varies).count()
            })
        })
    }

    /// Returns the least operations of the elimination of m constraint rows that depend on one
    /// joint, m^3 / 3: the matrix of such rows has no zeros.
    fn least_of_rows(&self) -> usize {
        let n = self.sizes.nv;
        if self.sizes.constraint_rows.pow(3) / 3 <= MAX_OPERATIONS {
            return 0;
        }
        let Some(model) = self.with_fewer_constraints() else { return 0 };
        let constraints = model.constraints();
        let jacobians = self.at_two_configurations(&model, |robot, q| {
            let mut columns = vec![Twist::zero(); constraints * n];
            robot.constraint_jacobian(q, &mut columns).ok().map(|()| columns)
        });
        let Some([first, second]) = jacobians else { return 0 };
        let rows_of = |joint: usize| {
            let places = (joint..constraints * n).step_by(n);
            let entries: Vec<[f64; 2]> = places
                .map(|at| [&first[at], &second[at]].map(Twist::components))
                .flat_map(|[one, other]| one.into_iter().zip(other))
                .map(|(one, other)| [one, other])
                .collect();
            let scale = entries.as_flattened().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            entries.iter().filter(|[one, other]| (one - other).abs() > VARIES * scale).count()
        };
        (0..n).map(rows_of).max().unwrap_or(0).pow(3) / 3
    }

    /// Returns the robot with some of the constraints on the limb that has the most; `None` if it
    /// has none there.
    fn with_fewer_constraints(&self) -> Option<Model> {
        let model = self.model;
        let mut limbs: Vec<usize> = Vec::new();
        for (link, record) in model.moving_links().iter().enumerate() {
            limbs.push(record.parent.map_or(link, |parent| limbs[parent]));
        }
        let limb_of = |link: usize| model.links()[link].moving_link.map(|i| limbs[i]);
        let contacts = model.contacts();
        let loops = model.loop_constraints();
        let limbs_of_contacts = contacts.iter().map(|contact| limb_of(contact.end.link));
        let limbs_of_loops = loops.iter().map(|closed| limb_of(closed.ends[1].link));
        let mut counts = vec![0_usize; model.moving_links().len()];
        limbs_of_contacts.chain(limbs_of_loops).flatten().for_each(|limb| counts[limb] += 1);
        let (most, _) = counts.iter().enumerate().max_by_key(|(_, count)| **count)?;
        let on_limb = |link: usize| limb_of(link) == Some(most);
        let contacts_on_limb = contacts.iter().filter(|contact| on_limb(contact.end.link));
        let some_contacts: Vec<_> = contacts_on_limb.take(COUNTED_CONSTRAINTS).cloned().collect();
        let left = COUNTED_CONSTRAINTS - some_contacts.len();
        let loops_on_limb = loops.iter().filter(|closed| on_limb(closed.ends[1].link));
        let some_loops = loops_on_limb.take(left).cloned().collect();
        let fewer = model.clone().with_loop_constraints(some_loops).ok()?;
        fewer.with_contacts(some_contacts).ok()
    }

    /// Returns the values of a function of the coordinates at two configurations; `None` if there
    /// is none.
    fn at_two_configurations<T>(
        &self,
        model: &Model,
        value: impl Fn(&mut Interpreter<f64>, &[f64]) -> Option<T>,
    ) -> Option<[T; 2]> {
        let mechanism = Mechanism::new(model);
        let mut robot = Interpreter::new(model.clone());
        let mut number = 0.0_f64;
        let mut uniform = || {
            // Multiples of the golden ratio are evenly distributed.
            number = (number + 0.618_033_988_749_894_9).fract();
            number
        };
        let mut at_next = || {
            let mut q = vec![0.0; model.nq()];
            coordinates::random(&mechanism, &mut uniform, &mut q);
            value(&mut robot, &q)
        };
        Some([at_next()?, at_next()?])
    }
}

/// Returns whether a function solves for the derivatives of all accelerations by q and qd, in
/// straight-line code.
const fn solves_for_columns(function: Function) -> bool {
    matches!(
        function,
        Function::ForwardDynamicsDerivatives
            | Function::ForwardDynamicsHessian
            | Function::StepSemiImplicitDerivatives
            | Function::StepSemiImplicitHessian
            | Function::Knot
    )
}

/// Returns whether a function eliminates the rows of all constraints.
const fn eliminates_rows(function: Function) -> bool {
    matches!(
        function,
        Function::ConstrainedForwardDynamics
            | Function::ConstrainedForwardDynamicsDerivatives
            | Function::ConstrainedKnot
            | Function::ConstrainedForwardDynamicsHessian
            | Function::ProjectConstraints
            | Function::ImpactDynamics
            | Function::OperationalSpaceInertia
    )
}
