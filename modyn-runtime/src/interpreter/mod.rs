//! The equations run on numbers, for any model at run time.

mod closures;
mod coordinates;
mod derivatives;
mod kinematics;
mod regressor;

use alloc::{vec, vec::Vec};
use core::fmt;

use crate::Scalar;
use crate::equations::brge::{self, Layout};
use crate::equations::dynamics::{
    Elimination, forward_dynamics, gravity_torques, inverse_dynamics, kinetic_energy, mass_matrix,
    potential_energy,
};
use crate::equations::kinematics::link_poses;
use crate::equations::paper::{DeNoc, Decomposition, denoc};
use crate::equations::{ClosureWorkspace, Forces, Workspace};
use crate::mechanism::{Prepared, rigid_inertia};
use crate::model::{Inertial, InertialDefect, Model, ModuleTree};
use crate::spatial::{Pose, RigidInertia, Vector3};

pub use kinematics::FrameError;

pub use derivatives::ForwardDerivatives;

/// A vector or matrix that was given has the wrong length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShapeError {
    /// The parameter.
    pub parameter: &'static str,
    /// How many numbers it must hold.
    pub expected: usize,
    /// How many it holds.
    pub found: usize,
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { parameter, expected, found } = self;
        write!(f, "`{parameter}` must hold {expected} numbers but holds {found}")
    }
}

impl core::error::Error for ShapeError {}

fn check<T>(parameter: &'static str, given: &[T], expected: usize) -> Result<(), ShapeError> {
    let found = given.len();
    if found == expected { Ok(()) } else { Err(ShapeError { parameter, expected, found }) }
}

/// The modules are those of another model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModuleMismatch;

impl fmt::Display for ModuleMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the modules are those of another model; make them from this one")
    }
}

impl core::error::Error for ModuleMismatch {}

/// Why a link cannot be given an inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InertialError {
    /// There is no link of that index.
    NoFrame {
        /// The index.
        frame: usize,
        /// How many links the description has.
        count: usize,
    },
    /// It is no rigid body's inertia.
    Defect(InertialDefect),
}

impl fmt::Display for InertialError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFrame { frame, count } => {
                write!(f, "there is no link {frame}; the description has {count}")
            }
            Self::Defect(defect) => defect.fmt(f),
        }
    }
}

impl core::error::Error for InertialError {}

/// Dynamics of a model that is only known at run time.
///
/// Calls work in memory that was allocated once (but for [`brge`](Self::brge), [`denoc`](Self::denoc)
/// and [`decomposition`](Self::decomposition), which return new objects, and the first call of
/// [`forward_dynamics_derivatives`](Self::forward_dynamics_derivatives) and of either of
/// [`constrained_forward_dynamics`](Self::constrained_forward_dynamics) and
/// [`closing_step`](Self::closing_step)), in time and memory linear in the number of
/// links (but for dense results); nothing recurses on the call stack. Vectors stand in the order of
/// [`Model::links`]; matrices are given by columns.
#[derive(Clone, Debug)]
pub struct Interpreter<S = f64> {
    model: Model,
    modules: ModuleTree,
    prepared: Prepared<S>,
    elimination: Elimination,
    workspace: Workspace<S>,
    body_poses: Vec<Pose<S>>,
    /// By link of the description: its own inertia at present.
    inertias: Vec<RigidInertia<S>>,
    /// By links, made when derivatives are first asked for.
    links: Option<Layout>,
    /// Made when loops are first closed.
    closing: Option<ClosureWorkspace<S>>,
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
        if modules.fits(&model) { Ok(Self::made(model, modules)) } else { Err(ModuleMismatch) }
    }

    fn made(model: Model, modules: ModuleTree) -> Self {
        let prepared = Prepared::new(&model).cast();
        let elimination = Elimination::new(&prepared, &ModuleTree::links(&model));
        let mut workspace = Workspace::new(&prepared);
        elimination.make_room(&prepared, &mut workspace);
        let body_poses = vec![Pose::identity(); prepared.bodies.len()];
        let inertias = model.frames().iter().map(|frame| inertia(&frame.inertial)).collect();
        let (links, closing) = (None, None);
        Self {
            model,
            modules,
            prepared,
            elimination,
            workspace,
            body_poses,
            inertias,
            links,
            closing,
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
            return Err(ModuleMismatch);
        }
        self.elimination = Elimination::new(&self.prepared, modules);
        self.elimination.make_room(&self.prepared, &mut self.workspace);
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
        self.prepared.gravity = Vector3(gravity);
    }

    /// Gives link `frame` of the description (an index into [`Model::frames`]) another inertia of
    /// its own, in its own frame: a payload, or an identified figure. What is fixed to the link
    /// keeps its own; on a link that is fixed to the world nothing depends. Allocates nothing.
    ///
    /// As in a model, no joint may be left without any inertia to feel.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if this is no rigid body's inertia; nothing has changed then.
    pub fn set_inertial(&mut self, frame: usize, inertial: &Inertial) -> Result<(), InertialError> {
        let count = self.inertias.len();
        let Some(own) = self.inertias.get_mut(frame) else {
            return Err(InertialError::NoFrame { frame, count });
        };
        if let Some(defect) = inertial.defect() {
            return Err(InertialError::Defect(defect));
        }
        let other = inertia(inertial);
        self.prepared.replace_inertia(frame, own, &other);
        *own = other;
        Ok(())
    }

    /// The modules that [`brge`](Self::brge) works by.
    #[must_use]
    pub fn modules(&self) -> &ModuleTree {
        &self.modules
    }

    /// The joint accelerations `qdd` (rad/s^2 or m/s^2) under the joint torques or forces `tau`:
    /// the inter- and intra-modular recursion, (60).
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn forward_dynamics(
        &mut self,
        q: &[S],
        qd: &[S],
        tau: &[S],
        qdd: &mut [S],
    ) -> Result<(), ShapeError> {
        self.accelerate((q, qd, tau), None, qdd)
    }

    /// The same under `forces` from outside: one wrench for each link of the description, fixed
    /// ones too, in the order of [`Model::frames`].
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn forward_dynamics_external(
        &mut self,
        q: &[S],
        qd: &[S],
        tau: &[S],
        forces: Forces<'_, S>,
        qdd: &mut [S],
    ) -> Result<(), ShapeError> {
        self.accelerate((q, qd, tau), Some(forces), qdd)
    }

    fn accelerate(
        &mut self,
        (q, qd, tau): (&[S], &[S], &[S]),
        forces: Option<Forces<'_, S>>,
        qdd: &mut [S],
    ) -> Result<(), ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        check("tau", tau, n)?;
        self.check_forces(forces)?;
        check("qdd", qdd, n)?;
        let Self { prepared, elimination, workspace, .. } = self;
        let state = (q, qd, tau);
        forward_dynamics(prepared, elimination, state, forces, workspace, qdd);
        Ok(())
    }

    fn check_forces(&self, forces: Option<Forces<'_, S>>) -> Result<(), ShapeError> {
        forces
            .map_or(Ok(()), |forces| check("forces", forces.wrenches(), self.model.frames().len()))
    }

    /// The joint torques or forces `tau` (N m or N) of a motion: recursive Newton-Euler.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn inverse_dynamics(
        &mut self,
        q: &[S],
        qd: &[S],
        qdd: &[S],
        tau: &mut [S],
    ) -> Result<(), ShapeError> {
        self.act((q, qd, Some(qdd)), None, tau)
    }

    /// The same under `forces` from outside, which take their share off the joints: one wrench for
    /// each link of the description, fixed ones too, in the order of [`Model::frames`].
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn inverse_dynamics_external(
        &mut self,
        q: &[S],
        qd: &[S],
        qdd: &[S],
        forces: Forces<'_, S>,
        tau: &mut [S],
    ) -> Result<(), ShapeError> {
        self.act((q, qd, Some(qdd)), Some(forces), tau)
    }

    fn act(
        &mut self,
        (q, qd, qdd): (&[S], &[S], Option<&[S]>),
        forces: Option<Forces<'_, S>>,
        tau: &mut [S],
    ) -> Result<(), ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        qdd.map_or(Ok(()), |qdd| check("qdd", qdd, n))?;
        self.check_forces(forces)?;
        check("tau", tau, n)?;
        let (motion, workspace) = ((q, qd, qdd), &mut self.workspace);
        inverse_dynamics(&self.prepared, motion, forces, workspace, tau);
        Ok(())
    }

    /// The bias forces h(q, qd) into `tau`: inverse dynamics without acceleration.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn bias_forces(&mut self, q: &[S], qd: &[S], tau: &mut [S]) -> Result<(), ShapeError> {
        self.act((q, qd, None), None, tau)
    }

    /// The joint torques that hold the robot still, into `tau`.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn gravity_torques(&mut self, q: &[S], tau: &mut [S]) -> Result<(), ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("tau", tau, n)?;
        gravity_torques(&self.prepared, q, &mut self.workspace, tau);
        Ok(())
    }

    /// The GIM by columns into `columns` (nv times nv), (7)-(10).
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn mass_matrix(&mut self, q: &[S], columns: &mut [S]) -> Result<(), ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("columns", columns, n * n)?;
        mass_matrix(&self.prepared, q, &mut self.workspace, columns);
        Ok(())
    }

    /// Kinetic energy of the moving links, J.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn kinetic_energy(&mut self, q: &[S], qd: &[S]) -> Result<S, ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        Ok(kinetic_energy(&self.prepared, q, qd, &mut self.workspace))
    }

    /// Potential energy of the moving links under gravity, J; zero at the world's origin.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn potential_energy(&mut self, q: &[S]) -> Result<S, ShapeError> {
        check("q", q, self.model.nq())?;
        Ok(potential_energy(&self.prepared, q, &mut self.workspace))
    }

    /// The poses in the world of all links of the description, fixed ones too, in the order of
    /// [`Model::frames`].
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn link_poses(&mut self, q: &[S], poses: &mut [Pose<S>]) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())?;
        check("poses", poses, self.model.frames().len())?;
        let Self { prepared, workspace, body_poses, .. } = self;
        link_poses(prepared, q, workspace, body_poses, poses);
        Ok(())
    }

    /// The factorization I = U D U^T by modules at `q`, (35)-(49). Allocates its result; to use
    /// the memory of an earlier one again, see [`Brge::update`].
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length.
    pub fn brge(&self, q: &[S]) -> Result<Brge<S>, ShapeError> {
        check("q", q, self.model.nq())?;
        let layout = Layout::new(&self.prepared, &self.modules);
        let factors = vec![S::zero(); layout.size()];
        let workspace = Workspace::new(&self.prepared);
        let modules = self.modules.clone();
        let (nq, n) = (self.model.nq(), self.model.nv());
        let mut brge = Brge { modules, layout, factors, workspace, nq, n };
        brge.factorize(self, q);
        Ok(brge)
    }

    /// The dense DeNOC matrices at `q`, (1)-(5), with the links' inertias as the model has them.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length.
    pub fn denoc(&mut self, q: &[S]) -> Result<DeNoc<S>, ShapeError> {
        check("q", q, self.model.nq())?;
        Ok(denoc(&self.prepared, q, &mut self.workspace))
    }

    /// The paper's dense matrices of the block decomposition at `q`, (1)-(57), by the modules of
    /// [`brge`](Self::brge), with the links' inertias as the model has them.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length, or if joints mimic others.
    pub fn decomposition(&mut self, q: &[S]) -> Result<Decomposition<S>, DecompositionError> {
        check("q", q, self.model.nq()).map_err(DecompositionError::Shape)?;
        let Self { prepared, modules, workspace, .. } = self;
        Decomposition::new(prepared, modules, q, workspace).ok_or(DecompositionError::Mimics)
    }
}

/// Why a model has no block decomposition in the paper's matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecompositionError {
    /// `q` has the wrong length.
    Shape(ShapeError),
    /// Joints mimic others, which couples modules across the tree.
    Mimics,
}

impl fmt::Display for DecompositionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape(error) => error.fmt(f),
            Self::Mimics => write!(
                f,
                "joints mimic others, which couples modules across the tree; `brge` factorizes such models"
            ),
        }
    }
}

impl core::error::Error for DecompositionError {}

/// An inertia about the origin of its frame.
fn inertia<S: Scalar>(inertial: &Inertial) -> RigidInertia<S> {
    rigid_inertia(inertial).map(S::from_f64)
}

/// Why a factorization cannot be updated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpdateError {
    /// It is that of another model or by other modules.
    Modules(ModuleMismatch),
    /// `q` has the wrong length.
    Shape(ShapeError),
}

impl fmt::Display for UpdateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Modules(error) => error.fmt(f),
            Self::Shape(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for UpdateError {}

/// The factorization I = U D U^T of the GIM by modules. Matrices are given by columns.
///
/// [`update`](Self::update) and [`solve_in_place`](Self::solve_in_place) allocate nothing; what
/// returns a vector or matrix allocates it, and [`condition_number`](Self::condition_number) a
/// copy of its block.
#[derive(Clone, Debug)]
pub struct Brge<S = f64> {
    modules: ModuleTree,
    layout: Layout,
    factors: Vec<S>,
    workspace: Workspace<S>,
    nq: usize,
    n: usize,
}

impl<S: Scalar> Brge<S> {
    /// Factorizes anew at another `q`, in the memory that is there.
    ///
    /// # Errors
    ///
    /// If this is the factorization of another model or by other modules, or if `q` does not have
    /// the model's length.
    pub fn update(&mut self, interpreter: &Interpreter<S>, q: &[S]) -> Result<(), UpdateError> {
        if self.modules != interpreter.modules {
            return Err(UpdateError::Modules(ModuleMismatch));
        }
        check("q", q, self.nq).map_err(UpdateError::Shape)?;
        self.factorize(interpreter, q);
        Ok(())
    }

    fn factorize(&mut self, interpreter: &Interpreter<S>, q: &[S]) {
        let Self { layout, factors, workspace, .. } = self;
        brge::factorize(&interpreter.prepared, layout, q, workspace, factors);
    }

    fn matrix(&self, fill: impl FnOnce(&mut [S])) -> Vec<S> {
        let mut columns = vec![S::zero(); self.n * self.n];
        fill(&mut columns);
        columns
    }

    /// The block upper triangular U, (43).
    #[must_use]
    pub fn u(&self) -> Vec<S> {
        self.matrix(|columns| brge::upper(&self.layout, &self.factors[self.layout.u()], columns))
    }

    /// The block diagonal D, (45).
    #[must_use]
    pub fn d(&self) -> Vec<S> {
        self.matrix(|columns| brge::diagonal(&self.layout, &self.factors, columns))
    }

    /// U^-1, (54).
    #[must_use]
    pub fn u_inverse(&self) -> Vec<S> {
        let u = &self.factors[self.layout.u()];
        self.matrix(|columns| brge::upper_inverse(&self.layout, u, columns))
    }

    /// D^-1, (54).
    #[must_use]
    pub fn d_inverse(&self) -> Vec<S> {
        self.matrix(|columns| brge::diagonal_inverse(&self.layout, &self.factors, columns))
    }

    /// The inverse of the GIM, (50).
    #[must_use]
    pub fn inverse(&self) -> Vec<S> {
        self.matrix(|columns| brge::inverse(&self.layout, &self.factors, columns))
    }

    /// The x with I x = `rhs`, by the three steps of (60).
    ///
    /// # Errors
    ///
    /// If `rhs` does not have the model's length.
    pub fn solve(&self, rhs: &[S]) -> Result<Vec<S>, ShapeError> {
        check("rhs", rhs, self.n)?;
        let mut x = rhs.to_vec();
        brge::solve(&self.layout, &self.factors, &mut x);
        Ok(x)
    }

    /// The same in place: `x` is the right-hand side, then the solution.
    ///
    /// # Errors
    ///
    /// If `x` does not have the model's length.
    pub fn solve_in_place(&self, x: &mut [S]) -> Result<(), ShapeError> {
        check("x", x, self.n)?;
        brge::solve(&self.layout, &self.factors, x);
        Ok(())
    }

    /// The natural logarithm of the GIM's determinant.
    #[must_use]
    pub fn log_determinant(&self) -> S {
        brge::log_determinant(&self.layout, &self.factors)
    }

    /// Module `module`'s pivot block I_hat, (46), by columns; `None` if there is no such module.
    #[must_use]
    pub fn pivot_block(&self, module: usize) -> Option<Vec<S>> {
        let exists = module < self.layout.blocks().len();
        exists.then(|| self.factors[self.layout.d(module)].to_vec())
    }

    /// The condition number (2-norm) of that block, by a fixed number of Jacobi sweeps.
    #[must_use]
    pub fn condition_number(&self, module: usize) -> Option<S> {
        let exists = module < self.layout.blocks().len();
        exists.then(|| brge::condition_number(&self.layout, &self.factors, module))
    }
}
