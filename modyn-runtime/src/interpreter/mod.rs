//! The interpreter: the equations run on numbers, for any model at run time.
//!
//! The methods have typed results (`Twist`, `Pose`, records of slices) and allocate nothing,
//! whereas the layouts of a row of the table of functions allocate. [`Interpreter::evaluate`] calls
//! the methods by the table, on plain numbers. Public methods check the lengths of slices; inside,
//! lengths fit by construction.

mod actuation;
mod checks;
mod constraint_hessians;
mod constraints;
mod coordinates;
mod derivatives;
mod dynamics;
mod errors;
mod factorization;
mod hessians;
mod inertias;
mod kinematics;
mod momentum;
mod paper;
mod products;
mod regressor;
mod soft_constraints;
mod steps;

use alloc::{vec, vec::Vec};

use crate::Scalar;
use crate::equations::actuation::ActuationWorkspace;
use crate::equations::brge::UduLayout;
use crate::equations::dynamics::Elimination;
use crate::equations::soft_constraints::SoftModel;
use crate::equations::{
    ConstraintWorkspace, MidpointWorkspace, RungeKuttaWorkspace, StepWorkspace, Workspace,
};
use crate::mechanism::Mechanism;
use crate::model::{Model, ModuleTree};
use crate::spatial::{Pose, Vector3};
use inertias::Inertias;

pub use actuation::ActuatorOutputs;
pub use constraint_hessians::ConstrainedHessianOutputs;
pub use constraints::ConstrainedDerivatives;
pub use derivatives::ForwardDerivatives;
pub(crate) use errors::check;
pub use errors::{DecompositionError, LinkError, ModuleMismatch, ShapeError, UpdateError};
pub use factorization::UduFactorization;
pub use hessians::{HessianOutputs, StepHessianOutputs};
pub use inertias::InertialError;
pub use soft_constraints::{StateChange, StateDerivatives, StateGradients, StepSolutionOutputs};
pub use steps::{ConstrainedKnotOutputs, KnotOutputs, StepOutputs};

/// The dynamics of a model that is known at run time only.
///
/// Joint vectors have the order of [`Model::moving_links`]; matrices are stored by columns. Units are SI
/// units and radians. Quaternions in `q` must have length 1; only
/// [`check_configuration`](Self::check_configuration) checks them.
///
/// Methods take time and memory linear in the number of links, apart from dense results and steps
/// of the implicit midpoint rule, which solve dense equations. Nothing recurses on the call stack.
/// Memory is allocated once, with three exceptions: [`brge`](Self::brge), [`denoc`](Self::denoc)
/// and [`decomposition`](Self::decomposition) return new objects;
/// [`forward_dynamics_derivatives`](Self::forward_dynamics_derivatives),
/// [`set_inertial`](Self::set_inertial) and [`set_payload`](Self::set_payload) allocate at their
/// first call; and so does the first call of
/// [`constrained_forward_dynamics`](Self::constrained_forward_dynamics) or
/// [`project_constraints`](Self::project_constraints), and the first step of each kind. Products
/// with derivatives and Hessians allocate matrices at each call.
///
/// ```
/// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
/// use modyn_runtime::Interpreter;
///
/// // A pendulum: 2 kg, 0.5 m below its joint.
/// let mut pendulum = Interpreter::<f64>::new(model);
/// let (mut q, mut qd, mut qdd) = ([0.1], [0.0], [0.0]);
/// for _ in 0..1000 {
///     pendulum.forward_dynamics(&q, &qd, &[0.0], &mut qdd)?;
///     qd[0] += 0.001 * qdd[0];
///     q[0] += 0.001 * qd[0];
/// }
/// assert!(q[0].abs() <= 0.1001);
/// # Ok::<(), modyn_runtime::ShapeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Interpreter<S = f64> {
    model: Model,
    modules: ModuleTree,
    mechanism: Mechanism<S>,
    elimination: Elimination,
    workspace: Workspace<S>,
    body_poses: Vec<Pose<S>>,
    /// Created when an inertia is first changed.
    inertias: Option<Inertias<S>>,
    /// The layout of `modules`.
    layout: UduLayout,
    /// The layout for derivatives and constraints: with modules of one link unless chosen
    /// otherwise. Created when it is first needed.
    links: Option<UduLayout>,
    /// Created when constrained dynamics is first computed.
    constraints: Option<ConstraintWorkspace<S>>,
    /// Created when a step is first computed.
    steps: Option<StepWorkspace<S>>,
    /// Created when the derivatives of a Runge-Kutta step are first computed.
    runge_kutta: Option<RungeKuttaWorkspace<S>>,
    /// Created when a step of the implicit midpoint rule is first computed.
    midpoint: Option<MidpointWorkspace<S>>,
    /// Created when the forces of actuators are first computed.
    actuation: Option<ActuationWorkspace<S>>,
    /// Created when a step with soft constraints is first computed.
    soft: Option<SoftModel<S>>,
    /// For each contact, 1 if it is active, else 0.
    active: Vec<S>,
    /// A joint that moves no inertia, since its link has none.
    without_inertia: Option<usize>,
}

impl<S: Scalar> Interpreter<S> {
    /// Returns the interpreter of `model`. The modules of [`brge`](Self::brge) are its maximal
    /// serial chains.
    ///
    /// Forward dynamics eliminates link by link, so that a long chain does not need a large dense
    /// pivot block.
    #[must_use]
    pub fn new(model: Model) -> Self {
        let modules = ModuleTree::chains(&model);
        Self::from_parts(model, modules)
    }

    /// Returns the interpreter of `model`, with `modules` as the modules of [`brge`](Self::brge).
    ///
    /// # Errors
    ///
    /// If the modules belong to another model.
    pub fn with_modules(model: Model, modules: ModuleTree) -> Result<Self, ModuleMismatch> {
        if modules.fits(&model) {
            Ok(Self::from_parts(model, modules))
        } else {
            Err(ModuleMismatch {})
        }
    }

    fn from_parts(model: Model, modules: ModuleTree) -> Self {
        let mechanism = Mechanism::new(&model);
        let without_inertia = inertias::joint_without_inertia(&model, &mechanism);
        Self { without_inertia, ..Self::from_mechanism(model, modules, mechanism.cast()) }
    }

    /// Returns the interpreter of `model`, whose mechanism may have other inertias and another
    /// gravity.
    #[doc(hidden)]
    #[must_use]
    pub fn with_mechanism(model: Model, mechanism: Mechanism<S>) -> Self {
        let modules = ModuleTree::chains(&model);
        Self::from_mechanism(model, modules, mechanism)
    }

    fn from_mechanism(model: Model, modules: ModuleTree, mechanism: Mechanism<S>) -> Self {
        let elimination = Elimination::new(&mechanism, &ModuleTree::links(&model));
        let mut workspace = Workspace::new(&mechanism);
        elimination.reserve(&mechanism, &mut workspace);
        let body_poses = vec![Pose::identity(); mechanism.bodies.len()];
        let layout = UduLayout::new(&mechanism, &modules);
        let inertias = None;
        let links = None;
        let constraints = None;
        let steps = None;
        let runge_kutta = None;
        let midpoint = None;
        let active = vec![S::zero(); model.contacts().len()];
        Self {
            model,
            modules,
            mechanism,
            elimination,
            workspace,
            body_poses,
            inertias,
            layout,
            links,
            constraints,
            steps,
            runge_kutta,
            midpoint,
            actuation: None,
            soft: None,
            active,
            without_inertia: None,
        }
    }

    /// Returns a joint that moves no inertia because its link has none, as an index into
    /// [`Model::moving_links`]; `None` if all joints move inertia.
    ///
    /// A robot with such a joint has kinematics alone: poses, velocities, Jacobians and the other
    /// functions that [need no inertia](crate::quantities::Row::needs_inertia).
    /// [`evaluate`](Self::evaluate) refuses the others; the methods for them return zero, infinite
    /// or NaN results. [`set_inertial`](Self::set_inertial) gives a link inertia.
    #[must_use]
    pub fn joint_without_inertia(&self) -> Option<usize> {
        self.without_inertia
    }

    /// Returns the interpreter with this solver of forward dynamics, the layout of
    /// [`brge`](Self::brge), and the layout for derivatives and constraints.
    #[doc(hidden)]
    #[must_use]
    pub fn with_solvers(
        mut self,
        elimination: Elimination,
        layout: UduLayout,
        for_derivatives: UduLayout,
    ) -> Self {
        self.elimination = elimination;
        self.elimination.reserve(&self.mechanism, &mut self.workspace);
        (self.layout, self.links) = (layout, Some(for_derivatives));
        self
    }

    /// Returns the layout of the factors of the mass matrix.
    pub(crate) fn layout(&self) -> &UduLayout {
        &self.layout
    }

    /// Returns the interpreter with forward dynamics by these modules.
    ///
    /// The accelerations are the same up to rounding for any modules.
    ///
    /// # Errors
    ///
    /// If the modules belong to another model.
    pub fn eliminating_by(mut self, modules: &ModuleTree) -> Result<Self, ModuleMismatch> {
        if !modules.fits(&self.model) {
            return Err(ModuleMismatch {});
        }
        self.elimination = Elimination::new(&self.mechanism, modules);
        self.elimination.reserve(&self.mechanism, &mut self.workspace);
        Ok(self)
    }

    /// Returns the model that the interpreter was created for. [`set_gravity`](Self::set_gravity)
    /// and [`set_inertial`](Self::set_inertial) do not change it.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Sets gravity: the acceleration of free fall in world axes, m/s^2. Does not allocate.
    pub fn set_gravity(&mut self, gravity: [S; 3]) {
        self.mechanism.gravity = Vector3(gravity);
    }

    /// Returns the modules of [`brge`](Self::brge).
    #[must_use]
    pub fn modules(&self) -> &ModuleTree {
        &self.modules
    }
}
