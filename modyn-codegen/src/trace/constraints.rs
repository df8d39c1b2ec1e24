//! The graphs of loop constraints and contacts.
//!
//! Settings have the order of `ConstraintSettings::from_numbers`, then of
//! `ContactTarget::from_numbers` for each contact. A twist or a wrench is three linear, then three
//! angular components. The set of active contacts is a number for each contact, 1 if it is active,
//! else 0.

use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::constraints::{
    ColumnMap, ConstrainedOutputs, ConstraintInput, ConstraintWorkspaces, ImpulseOutputs,
    OperationalSpaceInertiaOutputs, ProjectionOutputs, RowSystem,
};
use modyn_runtime::equations::factorization::{Factorizable, MergedUduLayout};
use modyn_runtime::equations::{ConstraintWorkspace, ForwardInput, State, Workspace, constraints};
use modyn_runtime::mechanism::{Mechanism, MergedMechanism};
use modyn_runtime::spatial::{Twist, Vector3, Wrench};
use modyn_runtime::{ConstraintSettings, ContactTarget, Scalar};

use super::limbs::ContactPacking;
use super::{LimbPacking, Tracer};
use crate::graph::dense::{ProductForm, ProductTarget, RowForm, row_results};
use crate::graph::{Expr, Graph};

/// The equations of dependent rows that are solved apart from a graph.
struct ApartRows<'a> {
    /// The first input that is one of their results.
    first: usize,
    /// The number of right-hand sides.
    sides: usize,
    /// For each constraint the number of its rows, which tracing finds.
    blocks: &'a mut Option<Vec<usize>>,
}

impl ApartRows<'_> {
    /// Makes the results inputs.
    fn given(self, memory: &mut ConstraintWorkspace<Expr>, rows: usize) -> Self {
        let results = row_results(rows, self.sides);
        memory.set_apart((self.first..self.first + results).map(Expr::input).collect());
        self
    }

    /// Returns the operands of the equations.
    fn operands(self, memory: &mut ConstraintWorkspace<Expr>) -> Vec<Expr> {
        let Some((system, margin)) = memory.system_apart() else { return Vec::new() };
        let RowSystem { blocks, matrix, sides, scales, tolerances } = system;
        *self.blocks = Some(blocks);
        [&matrix[..], &sides, &scales, &tolerances, &[margin]].concat()
    }
}

impl Tracer<'_> {
    /// Returns the graph of the accelerations, a wrench and a residual for each constraint, and the
    /// rank. Inputs: `q`, `qd`, `tau`, active contacts and settings. The mass matrix is factorized
    /// with `layout`.
    #[must_use]
    pub fn constrained_forward_dynamics(&self, layout: &UduLayout) -> Graph {
        self.solution(layout, Unknowns::Accelerations)
    }

    /// Returns the graph that `trace` makes, with the equations of dependent rows apart if this
    /// tracer leaves them to loops and some state has independent rows.
    fn around_rows(&self, sides: usize, trace: impl Fn(Option<ApartRows<'_>>) -> Graph) -> Graph {
        let Some(first) = self.loops.rows else { return trace(None) };
        let mut blocks = None;
        let mut graph = trace(Some(ApartRows { first, sides, blocks: &mut blocks }));
        let Some(blocks) = blocks else { return trace(None) };
        graph.dense.rows = Some(RowForm { blocks, sides });
        graph
    }

    /// Returns the number of constrained rows of the robot.
    pub(super) fn rows(&self) -> usize {
        self.model.constraints.iter().map(|constraint| constraint.rows.len()).sum()
    }

    /// Returns the contacts of merged limbs, and the mechanism of the merged limbs with them.
    fn merged_contacts(
        &self,
        limbs: &LimbPacking,
        gravity: Vector3<Expr>,
    ) -> (ContactPacking, MergedMechanism<Expr>) {
        let contacts = limbs.contacts(self.model);
        let merged = contacts.add_to(limbs.merged(self.model, gravity), limbs, self.model);
        (contacts, merged)
    }

    /// Traces the equations of `unknowns`, with the contacts of merged limbs merged. Results are
    /// joint vectors, then six numbers for each constraint, then the rank.
    fn solution(&self, layout: &UduLayout, unknowns: Unknowns) -> Graph {
        self.around_rows(unknowns.sides(), |apart| self.traced_solution(layout, unknowns, apart))
    }

    fn traced_solution(
        &self,
        layout: &UduLayout,
        unknowns: Unknowns,
        apart: Option<ApartRows<'_>>,
    ) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let contacts = self.model.contacts();
        let forces = if unknowns == Unknowns::Accelerations { nv } else { 0 };
        let groups = [nq, nv, forces, contacts, settings_count(self.model)];
        self.trace_groups(groups, |model, [q, qd, tau, active, settings]| {
            let apart = apart.map(|apart| (apart, self.rows()));
            let Some(limbs) = self.limbs else {
                let count = model.constraints.len();
                let inputs = [q, qd, tau, active, settings];
                return unknowns.solve(model, layout, inputs, nv, count, apart).concat();
            };
            let (contacts, merged) = self.merged_contacts(limbs, model.gravity);
            let partition = limbs.partition(layout.partition());
            let layout = &MergedUduLayout::by_modules(&merged, partition);
            let inputs = [
                limbs.coordinates(&q),
                limbs.vector(&qd),
                if forces == 0 { Vec::new() } else { limbs.vector(&tau) },
                contacts.numbers(&active, 1),
                merged_settings(&contacts, &settings),
            ];
            let n = merged.nv();
            let count = contacts.count();
            let [vectors, sixes, rest] = unknowns.solve(&merged, layout, inputs, n, count, apart);
            let vectors = vectors.chunks(n.max(1)).flat_map(|x| limbs.unpack_vector(x, nv));
            let sixes = sixes.chunks((6 * count).max(1)).flat_map(|x| contacts.unpack(x, 6));
            vectors.chain(sixes).chain(rest).collect()
        })
    }

    /// Returns the graph of the step, the change of the velocities and the rank. Inputs: `q`, `qd`,
    /// active contacts and settings.
    #[must_use]
    pub fn project_constraints(&self, layout: &UduLayout) -> Graph {
        self.solution(layout, Unknowns::Steps)
    }
}

impl Tracer<'_> {
    /// Returns the graph of the velocities after an impact, an impulse for each constraint and the
    /// rank. Inputs: `q`, `qd`, active contacts and settings.
    #[must_use]
    pub fn impact_dynamics(&self, layout: &UduLayout) -> Graph {
        self.solution(layout, Unknowns::Velocities)
    }

    /// Returns the graph of the accelerations, the wrenches, the derivatives of the accelerations
    /// with respect to q, qd and tau, the derivatives of the wrenches, and the rank. Inputs: `q`,
    /// `qd`, `tau`, active contacts and settings.
    #[must_use]
    pub fn constrained_forward_dynamics_derivatives(&self, layout: &UduLayout) -> Graph {
        self.around_rows(1 + self.rows(), |apart| match self.loops.products {
            true => self.derivatives_by_products(layout, apart),
            false => self.whole_derivatives(layout, apart),
        })
    }

    fn whole_derivatives(&self, layout: &UduLayout, apart: Option<ApartRows<'_>>) -> Graph {
        self.with_derivatives(layout, apart, |(tree, layout), state, settings, memory, outputs| {
            let solve = constraints::constrained_forward_dynamics_derivatives;
            (solve(tree, layout, state, settings, memory, outputs), Vec::new())
        })
    }

    /// Leaves the derivatives with respect to q and qd to products.
    fn derivatives_by_products(&self, layout: &UduLayout, apart: Option<ApartRows<'_>>) -> Graph {
        let mut products = None;
        let mut graph = self.with_derivatives(
            layout,
            apart,
            |(tree, layout), state, settings, memory, outputs| {
                let ColumnMap { map, columns, rank } =
                    ColumnMap::new(tree, layout, state, settings, memory, outputs);
                let n = self.model.nv;
                let count = self.model.constraints.len();
                let height = n + 6 * count;
                // Some rows are zero, such as the rows of moments of points.
                let is_zero =
                    |row: usize| map.iter().skip(row).step_by(height).all(|x| x.is_constant_zero());
                let rows: Vec<usize> = (0..height).filter(|&row| !is_zero(row)).collect();
                let targets = [0, 1].map(|matrix| {
                    let place = |row: usize| match row.checked_sub(n) {
                        None => (height + matrix * n * n + row, n),
                        Some(k) => {
                            let wrenches = height + 3 * n * n + matrix * 6 * n * count;
                            (wrenches + k / 6 * 6 * n + k % 6, 6)
                        }
                    };
                    ProductTarget::of_rows(rows.iter().map(|&row| place(row)))
                });
                let terms = map.len() / height;
                let results = height * (1 + 3 * n) + 1;
                let targets = targets.to_vec();
                products = Some(ProductForm { rows: rows.len(), terms, results, targets });
                let of_column =
                    |column: &[Expr]| rows.iter().map(|&row| column[row]).collect::<Vec<_>>();
                let map = map.chunks(height).flat_map(of_column);
                (rank, map.chain(columns.concat()).collect())
            },
        );
        graph.dense.products = products;
        graph
    }

    /// Returns the graph of the results that `solve` computes, with the operands that it returns
    /// after the rank.
    fn with_derivatives(
        &self,
        layout: &UduLayout,
        apart: Option<ApartRows<'_>>,
        solve: impl FnOnce(
            (&MergedMechanism<Expr>, &MergedUduLayout),
            ForwardInput<'_, Expr>,
            ConstraintInput<'_, Expr, Vec<ContactTarget<Expr>>>,
            ConstraintWorkspaces<'_, Expr>,
            constraints::ConstrainedDerivatives<'_, Expr>,
        ) -> (Expr, Vec<Expr>),
    ) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let contacts = self.model.contacts();
        let groups = [nq, nv, nv, contacts, settings_count(self.model)];
        self.trace_groups(groups, |model, [q, qd, tau, active, settings]| {
            let count = model.constraints.len();
            let mut qdd = self.vector();
            let mut wrenches = vec![Wrench::zero(); count];
            let mut matrices: [Vec<Expr>; 3] = std::array::from_fn(|_| vec![Expr::zero(); nv * nv]);
            let mut changes: [Vec<Wrench<Expr>>; 3] =
                std::array::from_fn(|_| vec![Wrench::zero(); nv * count]);
            let outputs = constraints::ConstrainedDerivatives::new(
                &mut qdd,
                &mut wrenches,
                &mut matrices,
                &mut changes,
            );
            let model = &self.with_column_lanes(model);
            let layout = &MergedUduLayout::new(model, layout.clone());
            let memory = &mut ConstraintWorkspace::new(model, layout);
            let apart = apart.map(|apart| apart.given(memory, self.rows()));
            let (rank, dense) = solve(
                (model, layout),
                ForwardInput { q: &q, qd: &qd, tau: &tau },
                ConstraintInput { active: &active, settings: &settings_of(&settings) },
                ConstraintWorkspaces { workspace: &mut Workspace::new(model), memory },
                outputs,
            );
            let wrenches = wrenches.iter().chain(changes.iter().flatten());
            let first: Vec<_> = wrenches.clone().take(count).flat_map(Wrench::components).collect();
            let rest: Vec<_> = wrenches.skip(count).flat_map(Wrench::components).collect();
            let operands = apart.map_or_else(Vec::new, |apart| apart.operands(memory));
            [qdd, first, matrices.concat(), rest, vec![rank], dense, operands].concat()
        })
    }

    /// Returns the graph of the Delassus matrix and the operational-space inertia, by columns, and
    /// the rank. Inputs: `q`, active contacts and settings.
    #[must_use]
    pub fn operational_space_inertia(&self, layout: &UduLayout) -> Graph {
        self.around_rows(self.rows(), |apart| self.inertia(layout, apart))
    }

    fn inertia(&self, layout: &UduLayout, apart: Option<ApartRows<'_>>) -> Graph {
        let groups = [self.model.nq, self.model.contacts(), settings_count(self.model)];
        self.trace_groups(groups, |model, [q, active, settings]| {
            let rows: usize = model.constraints.iter().map(|c| c.rows.len()).sum();
            let matrix = || vec![Expr::zero(); rows * rows];
            let mut delassus = matrix();
            let mut inertia = matrix();
            let model = &self.with_column_lanes(model);
            let layout = &MergedUduLayout::new(model, layout.clone());
            let memory = &mut ConstraintWorkspace::new(model, layout);
            let apart = apart.map(|apart| apart.given(memory, self.rows()));
            let rank = constraints::operational_space_inertia(
                model,
                layout,
                &q,
                ConstraintInput { active: &active, settings: &settings_of(&settings) },
                ConstraintWorkspaces { workspace: &mut Workspace::new(model), memory },
                OperationalSpaceInertiaOutputs { delassus: &mut delassus, inertia: &mut inertia },
            );
            let operands = apart.map_or_else(Vec::new, |apart| apart.operands(memory));
            [delassus, inertia, vec![rank], operands].concat()
        })
    }
}

/// The unknowns of equations with the factors of J M^-1 J^T.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Unknowns {
    /// Accelerations, wrenches and residuals.
    Accelerations,
    /// Velocities after an impact, and impulses.
    Velocities,
    /// Steps of the coordinates and of the velocities.
    Steps,
}

impl Unknowns {
    /// Returns the number of right-hand sides of the equations.
    fn sides(self) -> usize {
        match self {
            Self::Accelerations | Self::Velocities => 1,
            Self::Steps => 2,
        }
    }

    /// Returns the joint vectors, then six numbers for each constraint, then the rank; `nv` and
    /// `count` are the length of qd and the number of constraints. The rank comes before the
    /// operands of equations that are solved `apart`.
    fn solve<T: Factorizable<Expr>>(
        self,
        tree: &T,
        layout: &T::Layout,
        [q, qd, tau, active, settings]: [Vec<Expr>; 5],
        nv: usize,
        count: usize,
        apart: Option<(ApartRows<'_>, usize)>,
    ) -> [Vec<Expr>; 3] {
        let vector = || vec![Expr::zero(); nv];
        let memory = &mut ConstraintWorkspace::new(tree, layout);
        let apart = apart.map(|(apart, rows)| apart.given(memory, rows));
        let workspace = &mut Workspace::new(tree);
        let workspaces = ConstraintWorkspaces { workspace, memory };
        let constraints = ConstraintInput { active: &active, settings: &settings_of(&settings) };
        let state = State { q: &q, qd: &qd };
        let [vectors, sixes, rank] = match self {
            Self::Accelerations => {
                let mut qdd = vector();
                let mut wrenches = vec![Wrench::zero(); count];
                let mut residuals = vec![Twist::zero(); count];
                let outputs = ConstrainedOutputs {
                    qdd: &mut qdd,
                    wrenches: &mut wrenches,
                    residuals: &mut residuals,
                };
                let input = ForwardInput { q: &q, qd: &qd, tau: &tau };
                let solve = constraints::constrained_forward_dynamics;
                let rank = solve(tree, layout, input, constraints, workspaces, outputs);
                let wrenches = wrenches.iter().flat_map(Wrench::components);
                let residuals = residuals.iter().flat_map(Twist::components);
                [qdd, wrenches.chain(residuals).collect(), vec![rank]]
            }
            Self::Velocities => {
                let mut after = vector();
                let mut impulses = vec![Wrench::zero(); count];
                let outputs = ImpulseOutputs { qd: &mut after, impulses: &mut impulses };
                let solve = constraints::impact_dynamics;
                let rank = solve(tree, layout, state, constraints, workspaces, outputs);
                let impulses = impulses.iter().flat_map(Wrench::components);
                [after, impulses.collect(), vec![rank]]
            }
            Self::Steps => {
                let mut step_q = vector();
                let mut step_qd = vector();
                let outputs = ProjectionOutputs { step_q: &mut step_q, step_qd: &mut step_qd };
                let solve = constraints::project_constraints;
                let rank = solve(tree, layout, state, constraints, workspaces, outputs);
                [[step_q, step_qd].concat(), Vec::new(), vec![rank]]
            }
        };
        let operands = apart.map_or_else(Vec::new, |apart| apart.operands(memory));
        [vectors, sixes, [rank, operands].concat()]
    }
}

/// Returns the settings of merged contacts, from the settings of the robot's contacts.
fn merged_settings(contacts: &ContactPacking, settings: &[Expr]) -> Vec<Expr> {
    let (numbers, targets) = settings.split_at(ConstraintSettings::<Expr>::COUNT);
    [numbers, &contacts.numbers(targets, ContactTarget::<Expr>::COUNT)].concat()
}

/// Returns the number of scalars of the settings.
pub(super) fn settings_count(model: &Mechanism<f64>) -> usize {
    ConstraintSettings::<Expr>::COUNT + ContactTarget::<Expr>::COUNT * model.contacts()
}

pub(super) fn settings_of(numbers: &[Expr]) -> ConstraintSettings<Expr, Vec<ContactTarget<Expr>>> {
    let (settings, targets) = numbers.split_first_chunk().expect("the settings are counted");
    let (targets, _) = targets.as_chunks();
    let contacts = targets.iter().map(|target| ContactTarget::from_numbers(*target)).collect();
    ConstraintSettings::from_numbers(*settings, contacts)
}
