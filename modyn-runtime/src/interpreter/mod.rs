//! The equations run on numbers, for any model at run time.

mod constraints;
mod coordinates;
mod derivatives;
mod dynamics;
mod errors;
mod factorization;
mod inertias;
mod kinematics;
mod momentum;
mod paper;
mod regressor;

use alloc::{vec, vec::Vec};

use crate::Scalar;
use crate::equations::brge::UduLayout;
use crate::equations::dynamics::Elimination;
use crate::equations::{ConstraintWorkspace, Workspace};
use crate::mechanism::Mechanism;
use crate::model::{Model, ModuleTree};
use crate::spatial::{Pose, Vector3};
use inertias::Inertias;

pub use constraints::ConstrainedDerivatives;
pub use derivatives::ForwardDerivatives;
pub use errors::{DecompositionError, FrameError, ModuleMismatch, ShapeError, UpdateError};
pub use factorization::Brge;
pub use inertias::InertialError;

/// Dynamics of a model that is only known at run time.
///
/// Calls work in memory that was allocated once (but for [`brge`](Self::brge), [`denoc`](Self::denoc)
/// and [`decomposition`](Self::decomposition), which return new objects, and the first call of
/// [`forward_dynamics_derivatives`](Self::forward_dynamics_derivatives), of
/// [`set_inertial`](Self::set_inertial) or [`set_payload`](Self::set_payload), and of either of
/// [`constrained_forward_dynamics`](Self::constrained_forward_dynamics) and
/// [`project_constraints`](Self::project_constraints)), in time and memory linear in the number of
/// links (but for dense results); nothing recurses on the call stack. Vectors stand in the order of
/// [`Model::links`]; matrices are given by columns. Quaternions in `q` must have length 1, which
/// [`check_configuration`](Self::check_configuration) alone checks.
#[derive(Clone, Debug)]
pub struct Interpreter<S = f64> {
    model: Model,
    modules: ModuleTree,
    mechanism: Mechanism<S>,
    elimination: Elimination,
    workspace: Workspace<S>,
    body_poses: Vec<Pose<S>>,
    /// Made when an inertia is first changed.
    inertias: Option<Inertias<S>>,
    /// By links, made when derivatives are first asked for.
    links: Option<UduLayout>,
    /// Made when loops are first closed.
    constraints: Option<ConstraintWorkspace<S>>,
    /// By contact: 1 if it is active, else 0.
    active: Vec<S>,
}

impl<S: Scalar> Interpreter<S> {
    /// For a model whose modules (for [`brge`](Self::brge)) are its maximal serial chains.
    ///
    /// Forward dynamics works link by link: a long chain must not make a large dense pivot.
    #[must_use]
    pub fn new(model: Model) -> Self {
        let modules = ModuleTree::chains(&model);
        Self::made(model, modules)
    }

    /// For a model with modules of the user's choice.
    ///
    /// # Errors
    ///
    /// If the modules are those of another model.
    pub fn with_modules(model: Model, modules: ModuleTree) -> Result<Self, ModuleMismatch> {
        if modules.fits(&model) { Ok(Self::made(model, modules)) } else { Err(ModuleMismatch {}) }
    }

    fn made(model: Model, modules: ModuleTree) -> Self {
        let mechanism = Mechanism::new(&model).cast();
        let elimination = Elimination::new(&mechanism, &ModuleTree::links(&model));
        let mut workspace = Workspace::new(&mechanism);
        elimination.make_room(&mechanism, &mut workspace);
        let body_poses = vec![Pose::identity(); mechanism.bodies.len()];
        let (inertias, links, constraints) = (None, None, None);
        let active = vec![S::zero(); model.contacts().len()];
        Self {
            model,
            modules,
            mechanism,
            elimination,
            workspace,
            body_poses,
            inertias,
            links,
            constraints,
            active,
        }
    }

    /// The same, with forward dynamics by these modules as well.
    ///
    /// The results are the same up to rounding, whatever the modules.
    ///
    /// # Errors
    ///
    /// If the modules are those of another model.
    pub fn eliminating_by(mut self, modules: &ModuleTree) -> Result<Self, ModuleMismatch> {
        if !modules.fits(&self.model) {
            return Err(ModuleMismatch {});
        }
        self.elimination = Elimination::new(&self.mechanism, modules);
        self.elimination.make_room(&self.mechanism, &mut self.workspace);
        Ok(self)
    }

    /// The model that it was made for; [`set_gravity`](Self::set_gravity) and
    /// [`set_inertial`](Self::set_inertial) leave it as it was.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Sets the acceleration of free fall in world axes, m/s^2. Allocates nothing.
    pub fn set_gravity(&mut self, gravity: [S; 3]) {
        self.mechanism.gravity = Vector3(gravity);
    }

    /// The modules that [`brge`](Self::brge) works by.
    #[must_use]
    pub fn modules(&self) -> &ModuleTree {
        &self.modules
    }
}
