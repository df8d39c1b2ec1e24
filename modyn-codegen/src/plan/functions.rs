//! The way the compiler makes each function of the table of quantities.

use modyn_read::diagnostics::suggest;
use modyn_runtime::equations::dynamics::{
    BodyRecursion, forward_dynamics_of_bodies, inverse_dynamics_of_bodies,
};
use modyn_runtime::quantities::{Argument, ArgumentKind, Function, Shape, Sizes};

use super::PlanContext;
use crate::graph::{Expr, Graph};
use crate::trace::{Solvers, Tracer};

/// The factors of the mass matrix, an argument of the functions of the factors.
pub(super) const FACTORS: Argument = Argument { name: "factors", kind: ArgumentKind::Factors };

/// The right-hand side of a linear equation, an argument of the functions of the factors.
pub(super) const RHS: Argument = Argument { name: "rhs", kind: ArgumentKind::Velocities };

/// The forms of a function that C can call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CForm {
    /// C99 source, and a function that Rust exports.
    SourceAndExport,
    /// C99 source alone: in Rust its arguments or results are not arrays of numbers of one state.
    Source,
    /// None.
    None,
}

/// The way a function can be packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// No packing.
    Never,
    /// Equal limbs.
    Limbs,
    /// Equal limbs, with each of several partitions into modules.
    ByModules,
    /// Equal limbs, each group on one body, with their contacts; no loops.
    Contacts,
    /// Equal limbs whose parents are on one path to the root. Their composites are transformed
    /// together.
    OnRootPath,
    /// Second derivatives: as [`Derivatives`](Self::Derivatives), in languages with vectors.
    Columns,
    /// Derivatives: equal limbs whose parents are on one path to the root, or several columns.
    Derivatives,
    /// Derivatives under constraints: several columns.
    ConstrainedColumns,
}

impl Packing {
    /// Returns whether columns can share lanes.
    #[must_use]
    pub const fn has_columns(self) -> bool {
        matches!(self, Self::Derivatives | Self::Columns | Self::ConstrainedColumns)
    }
}

/// The source of a function's graphs.
#[derive(Clone, Copy)]
pub enum GraphSource {
    /// The evaluation of the table on expressions. A function of one link has a graph for each
    /// link; some links share one.
    Evaluation,
    /// Equations that support merged limbs or column lanes, or passes over other graphs.
    Traced(fn(&Tracer<'_>, &PlanContext<'_>) -> Graph),
    /// The poses of all links, of which some share a program.
    Poses,
    /// A step with soft constraints, whose solver is a loop.
    Step,
}

/// The way the compiler makes a function.
#[derive(Clone, Copy)]
pub struct Lowering {
    /// The source of its graphs.
    pub source: GraphSource,
    /// The way it is packed into vectors.
    pub packing: Packing,
    /// The equations of one body, if they can run in loops over the bodies.
    pub recursion: Option<fn() -> BodyRecursion<Expr>>,
    /// Whether loops can solve the equations of dependent constraint rows.
    pub has_rows: bool,
    /// Whether loops can multiply its matrices.
    pub has_products: bool,
    /// Other graphs of a function of one link, which share more with the graphs of other functions
    /// of a fused function.
    pub in_fused: Option<fn(&Tracer<'_>) -> Graph>,
    /// The forms that C can call.
    pub c_form: CForm,
}

impl Lowering {
    /// A function that is evaluated on expressions, with no other property.
    const EVALUATED: Self = Self {
        source: GraphSource::Evaluation,
        packing: Packing::Never,
        recursion: None,
        has_rows: false,
        has_products: false,
        in_fused: None,
        c_form: CForm::SourceAndExport,
    };

    /// Returns the lowering of a function with graphs of its own.
    const fn traced(trace: fn(&Tracer<'_>, &PlanContext<'_>) -> Graph) -> Self {
        Self { source: GraphSource::Traced(trace), ..Self::EVALUATED }
    }

    /// Returns the lowering of a function that is packed in this way.
    const fn packed(self, packing: Packing) -> Self {
        Self { packing, ..self }
    }

    /// Returns the lowering of a function that can run in loops over the bodies.
    const fn recursion(self, recursion: fn() -> BodyRecursion<Expr>) -> Self {
        Self { recursion: Some(recursion), ..self }
    }

    /// Returns the lowering of a function whose constraint rows are independent in most states.
    const fn rows(self) -> Self {
        Self { has_rows: true, ..self }
    }

    /// Returns the lowering of a function whose products of matrices can be loops.
    const fn products(self) -> Self {
        Self { has_products: true, ..self }
    }

    /// Returns the lowering of a function with this graph as another one in fused functions.
    const fn in_fused(self, trace: fn(&Tracer<'_>) -> Graph) -> Self {
        Self { in_fused: Some(trace), ..self }
    }

    /// Returns the lowering of a function that C can call as C99 source alone.
    const fn not_exported(self) -> Self {
        Self { c_form: CForm::Source, ..self }
    }

    /// Returns the way the compiler makes a function. The form for many states has the graphs of
    /// the form for one.
    #[must_use]
    pub const fn of(function: Function) -> Self {
        match function {
            Function::ForwardDynamics => {
                Lowering::traced(|t, s| t.forward_dynamics(&s.elimination))
                    .packed(Packing::ByModules)
                    .recursion(forward_dynamics_of_bodies)
            }
            Function::InverseDynamics => Lowering::traced(|t, _| t.inverse_dynamics())
                .packed(Packing::Limbs)
                .recursion(inverse_dynamics_of_bodies),
            Function::BiasForces => Lowering::traced(|t, _| t.bias_forces()).packed(Packing::Limbs),
            Function::GravityTorques => {
                Lowering::traced(|t, _| t.gravity_torques()).packed(Packing::Limbs)
            }
            Function::MassMatrix => {
                Lowering::traced(|t, _| t.mass_matrix()).packed(Packing::OnRootPath)
            }
            Function::Brge => Lowering::EVALUATED.not_exported(),
            Function::InverseDynamicsDerivatives => {
                Lowering::traced(|t, _| t.inverse_dynamics_derivatives())
                    .packed(Packing::Derivatives)
            }
            Function::ForwardDynamicsDerivatives => {
                Lowering::traced(|t, s| t.forward_dynamics_derivatives(&s.for_derivatives))
                    .packed(Packing::Derivatives)
                    .products()
            }
            Function::InverseDynamicsVjp => Lowering::traced(|t, _| t.inverse_dynamics_vjp()),
            Function::InverseDynamicsJvp => Lowering::traced(|t, _| t.inverse_dynamics_jvp()),
            Function::ForwardDynamicsVjp => {
                Lowering::traced(|t, s| t.forward_dynamics_vjp(&s.forward_dynamics.graph))
            }
            Function::ForwardDynamicsJvp => {
                Lowering::traced(|t, s| t.forward_dynamics_jvp(&s.forward_dynamics.graph))
            }
            Function::InverseDynamicsHessian => {
                Lowering::traced(|t, _| t.inverse_dynamics_hessian()).packed(Packing::Columns)
            }
            Function::ForwardDynamicsHessian => {
                Lowering::traced(|t, s| t.forward_dynamics_hessian(&s.for_derivatives))
                    .packed(Packing::Columns)
                    .products()
            }
            Function::StepSemiImplicitDerivatives => {
                Lowering::traced(|t, s| t.step_semi_implicit_derivatives(&s.for_derivatives))
                    .packed(Packing::Derivatives)
            }
            Function::Knot => Lowering::traced(|t, s| t.knot(&s.for_derivatives))
                .packed(Packing::Derivatives)
                .products(),
            Function::StepSemiImplicitHessian => {
                Lowering::traced(|t, s| t.step_semi_implicit_hessian(&s.for_derivatives))
                    .packed(Packing::Columns)
            }
            Function::ConstrainedForwardDynamics => {
                Lowering::traced(|t, s| t.constrained_forward_dynamics(&s.for_derivatives))
                    .packed(Packing::Contacts)
                    .rows()
            }
            Function::ProjectConstraints => {
                Lowering::traced(|t, s| t.project_constraints(&s.for_derivatives))
                    .packed(Packing::Contacts)
                    .rows()
            }
            Function::ConstrainedForwardDynamicsDerivatives => {
                Lowering::traced(|t, s| t.constrained_forward_dynamics_derivatives(&s.layout))
                    .packed(Packing::ConstrainedColumns)
                    .products()
                    .rows()
            }
            Function::ConstrainedKnot => Lowering::traced(|t, s| t.constrained_knot(&s.layout))
                .packed(Packing::ConstrainedColumns)
                .products()
                .rows(),
            Function::ConstrainedForwardDynamicsHessian => {
                Lowering::traced(|t, s| t.constrained_forward_dynamics_hessian(&s.layout))
            }
            Function::ImpactDynamics => {
                Lowering::traced(|t, s| t.impact_dynamics(&s.for_derivatives))
                    .packed(Packing::Contacts)
                    .rows()
            }
            Function::OperationalSpaceInertia => {
                Lowering::traced(|t, s| t.operational_space_inertia(&s.layout))
                    .packed(Packing::ConstrainedColumns)
                    .rows()
            }
            _ if function.row().has_solver => {
                Lowering { source: GraphSource::Step, ..Lowering::EVALUATED }
            }
            Function::LinkPoses => Lowering { source: GraphSource::Poses, ..Lowering::EVALUATED },
            Function::LinkPose => Lowering::EVALUATED.in_fused(|t| t.link_pose_from_world(0)),
            Function::LinkAcceleration => {
                Lowering::EVALUATED.in_fused(|t| t.link_acceleration_from_world(0))
            }
            Function::JacobianDotQd => {
                Lowering::EVALUATED.in_fused(|t| t.jacobian_dot_qd_from_world(0))
            }
            Function::RandomConfiguration => Lowering::EVALUATED.not_exported(),
            _ => match function.batched() {
                Some(one) => Self { packing: Packing::Never, c_form: CForm::None, ..Self::of(one) },
                None => Self::EVALUATED,
            },
        }
    }
}

impl<'a> PlanContext<'a> {
    /// Returns the graph of a function that is none of one link, on scalars or as `tracer` packs
    /// it.
    pub(super) fn graph(&self, function: Function, tracer: &Tracer<'a>) -> Graph {
        match Lowering::of(function).source {
            GraphSource::Traced(trace) => trace(tracer, self),
            GraphSource::Poses => self.all_links.link_poses(),
            GraphSource::Step => unreachable!("a step has a program of its own"),
            GraphSource::Evaluation => {
                let on_links =
                    function.row().arguments.iter().any(|a| a.kind == ArgumentKind::Wrenches);
                let tracer = if on_links { &self.all_links } else { tracer };
                self.evaluation(function, tracer)
            }
        }
    }

    /// Returns the graph of a function's evaluation on expressions. A function of one link is that
    /// of the tracer's link.
    pub(super) fn evaluation(&self, function: Function, tracer: &Tracer<'_>) -> Graph {
        let Self { elimination, layout, for_derivatives, .. } = self;
        let solvers = Solvers { elimination, layout, for_derivatives };
        tracer.evaluation(function, self.model, Some(&solvers))
    }
}

/// Returns the names of the Rust functions that a function becomes, each with the number of its
/// arguments without the robot's run-time parameters.
pub(crate) fn signatures(function: Function) -> Vec<(String, usize)> {
    let row = function.row();
    let inputs = row.arguments.len() + usize::from(row.by_link);
    let Some(one) = row.batch_of else { return vec![(function.name().into(), inputs)] };
    // Over slices for each coordinate, each result is an argument; over slices of states the
    // results are one argument.
    let outputs = match (row.result)(&Sizes::default()) {
        Shape::Record(_, fields) => fields.len(),
        Shape::Scalar | Shape::Array(..) => 1,
    };
    let name = one.name();
    vec![(format!("{name}_batch"), inputs + outputs), (format!("{name}_each"), inputs + 1)]
}

/// Returns the message that there is no function named `name`. It suggests the closest name, or
/// else lists all names that the macro and the command line accept.
#[must_use]
pub fn unknown_function(name: &str) -> String {
    let all = Function::ALL.iter().map(|one| one.name());
    let names: Vec<&str> = ["default", "all"].into_iter().chain(all).collect();
    match suggest(name, names.iter().copied()) {
        Some(meant) => format!("there is no function `{name}`; did you mean `{meant}`?"),
        None => format!("there is no function `{name}`; there are: {}", names.join(", ")),
    }
}
