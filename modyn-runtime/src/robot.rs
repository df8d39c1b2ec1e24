//! What every generated robot offers, for code that is written once for all of them.

use core::fmt;

use crate::Scalar;
use crate::spatial::Pose;

/// A fixed number of scalars: `[T; N]`, where N cannot be named.
pub trait Array<T>: Copy + AsRef<[T]> + AsMut<[T]> {
    /// How many.
    const LEN: usize;

    /// Entry i is `f(i)`.
    fn from_fn(f: impl FnMut(usize) -> T) -> Self;
}

impl<T: Copy, const N: usize> Array<T> for [T; N] {
    const LEN: usize = N;

    fn from_fn(f: impl FnMut(usize) -> T) -> Self {
        core::array::from_fn(f)
    }
}

/// A generated robot, over any scalar.
///
/// The generated type has the same functions by itself on plain numbers; the trait is for code
/// that does not know the robot. Vectors stand in the order of [`JOINT_NAMES`](Self::JOINT_NAMES),
/// matrices are arrays of columns; SI units, radians.
pub trait Robot {
    /// The robot's name in its description.
    const NAME: &'static str;
    /// Length of the coordinate vector.
    const NQ: usize;
    /// Length of the velocity vector: degrees of freedom.
    const NV: usize;
    /// The joints, in the order of all joint vectors.
    const JOINT_NAMES: &'static [&'static str];
    /// All links of the description, in its order: the order of [`link_poses`](Self::link_poses).
    const LINK_NAMES: &'static [&'static str];
    /// The kinematic modules, parents before children.
    const MODULES: &'static [KinematicModule];

    /// What can be changed at run time; nothing, as yet.
    type Params: Default;
    /// Coordinates.
    type Q<T: Scalar>: Array<T>;
    /// Velocities, accelerations, torques.
    type V<T: Scalar>: Array<T>;
    /// Square matrices, an array of columns.
    type M<T: Scalar>: Array<Self::V<T>>;
    /// Link poses.
    type Poses<T: Scalar>: Array<Pose<T>>;
    /// The factorization by modules.
    type Brge<T: Scalar>: Factorization<T, V = Self::V<T>, M = Self::M<T>>;

    /// Joint accelerations under the joint torques `tau`.
    fn forward_dynamics_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
    ) -> Self::V<T>;

    /// Joint torques of the accelerations `qdd`.
    fn inverse_dynamics_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> Self::V<T>;

    /// Coriolis, centrifugal and gravity torques.
    fn bias_forces_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
    ) -> Self::V<T>;

    /// Joint torques that hold the robot still.
    fn gravity_torques_with<T: Scalar>(params: &Self::Params, q: &Self::Q<T>) -> Self::V<T>;

    /// The generalized inertia matrix.
    fn mass_matrix_with<T: Scalar>(params: &Self::Params, q: &Self::Q<T>) -> Self::M<T>;

    /// The generalized inertia matrix as U D U^T by modules.
    fn brge_with<T: Scalar>(params: &Self::Params, q: &Self::Q<T>) -> Self::Brge<T>;

    /// Kinetic energy, J.
    fn kinetic_energy_with<T: Scalar>(params: &Self::Params, q: &Self::Q<T>, qd: &Self::V<T>) -> T;

    /// Potential energy under gravity, J; zero at the world's origin.
    fn potential_energy_with<T: Scalar>(params: &Self::Params, q: &Self::Q<T>) -> T;

    /// The poses of all links in the world.
    fn link_poses<T: Scalar>(q: &Self::Q<T>) -> Self::Poses<T>;

    /// [`forward_dynamics_with`](Self::forward_dynamics_with) the default parameters.
    fn forward_dynamics<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
    ) -> Self::V<T> {
        Self::forward_dynamics_with(&Self::Params::default(), q, qd, tau)
    }

    /// [`inverse_dynamics_with`](Self::inverse_dynamics_with) the default parameters.
    fn inverse_dynamics<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> Self::V<T> {
        Self::inverse_dynamics_with(&Self::Params::default(), q, qd, qdd)
    }

    /// [`bias_forces_with`](Self::bias_forces_with) the default parameters.
    fn bias_forces<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>) -> Self::V<T> {
        Self::bias_forces_with(&Self::Params::default(), q, qd)
    }

    /// [`gravity_torques_with`](Self::gravity_torques_with) the default parameters.
    fn gravity_torques<T: Scalar>(q: &Self::Q<T>) -> Self::V<T> {
        Self::gravity_torques_with(&Self::Params::default(), q)
    }

    /// [`mass_matrix_with`](Self::mass_matrix_with) the default parameters.
    fn mass_matrix<T: Scalar>(q: &Self::Q<T>) -> Self::M<T> {
        Self::mass_matrix_with(&Self::Params::default(), q)
    }

    /// [`brge_with`](Self::brge_with) the default parameters.
    fn brge<T: Scalar>(q: &Self::Q<T>) -> Self::Brge<T> {
        Self::brge_with(&Self::Params::default(), q)
    }

    /// [`kinetic_energy_with`](Self::kinetic_energy_with) the default parameters.
    fn kinetic_energy<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>) -> T {
        Self::kinetic_energy_with(&Self::Params::default(), q, qd)
    }

    /// [`potential_energy_with`](Self::potential_energy_with) the default parameters.
    fn potential_energy<T: Scalar>(q: &Self::Q<T>) -> T {
        Self::potential_energy_with(&Self::Params::default(), q)
    }
}

/// The factorization I = U D U^T of a generalized inertia matrix by kinematic modules, (35)-(57).
pub trait Factorization<T: Scalar> {
    /// Joint vectors.
    type V;
    /// Matrices, an array of columns.
    type M;

    /// The block upper triangular U, (43).
    fn u(&self) -> Self::M;
    /// The block diagonal D, (45).
    fn d(&self) -> Self::M;
    /// U^-1, (54).
    fn u_inverse(&self) -> Self::M;
    /// D^-1, (54).
    fn d_inverse(&self) -> Self::M;
    /// The x with I x = `rhs`, by the three steps of (60).
    fn solve(&self, rhs: &Self::V) -> Self::V;
    /// The inverse, (50).
    fn inverse(&self) -> Self::M;
    /// The natural logarithm of the determinant.
    fn log_determinant(&self) -> T;
    /// The condition number (2-norm) of module `module`'s pivot block; `None` if there is none.
    fn condition_number(&self, module: usize) -> Option<T>;
}

/// A kinematic module of a generated robot: links in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KinematicModule {
    /// The module whose last link it leaves, as an index; `None` for the base.
    pub parent: Option<usize>,
    /// The modules that leave its last link.
    pub children: &'static [usize],
    /// Its links from the inside out.
    pub links: &'static [&'static str],
    /// Their joints, in the same order.
    pub joints: &'static [&'static str],
    /// The first joint's index in joint vectors; the others follow.
    pub first: usize,
}

/// How many operations a function takes; changes of sign are free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OperationCount {
    /// Multiplications.
    pub multiplications: usize,
    /// Additions and subtractions.
    pub additions: usize,
    /// Divisions.
    pub divisions: usize,
    /// Angles whose sine, cosine or both are taken.
    pub sin_cos: usize,
    /// Square roots and logarithms, absolute values, maxima and selections.
    pub others: usize,
}

impl OperationCount {
    /// Multiplications, additions and divisions together.
    #[must_use]
    pub const fn total(&self) -> usize {
        self.multiplications + self.additions + self.divisions
    }
}

impl fmt::Display for OperationCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { multiplications, additions, divisions, sin_cos, .. } = self;
        write!(
            f,
            "{} operations ({multiplications} multiplications, {additions} additions, \
             {divisions} divisions) and {sin_cos} sin/cos",
            self.total()
        )
    }
}
