//! The results with several parts, and the descriptions of generated robots.

use core::fmt;

/// A kinematic module of a generated robot: a serial chain of links.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KinematicModule {
    /// The index of the parent module, whose last link carries this module; `None` for the base.
    pub parent: Option<usize>,
    /// The indices of the modules that this module's last link carries.
    pub children: &'static [usize],
    /// The names of the module's links, from the parent to the tip.
    pub links: &'static [&'static str],
    /// The names of the links' joints, in the same order.
    pub joints: &'static [&'static str],
    /// The module's first entry in velocity vectors; its other entries follow.
    pub first: usize,
    /// The number of the module's entries in velocity vectors.
    pub dofs: usize,
}

/// The derivatives of inverse dynamics: square matrices by columns, a column for each variable.
///
/// The derivative with respect to the accelerations is the mass matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseDynamicsDerivatives<M> {
    /// d tau / d q, in tangent space.
    pub dq: M,
    /// d tau / d qd.
    pub dqd: M,
}

/// The accelerations of forward dynamics and their derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForwardDynamicsDerivatives<V, M> {
    /// The joint accelerations.
    pub qdd: V,
    /// d qdd / d q, in tangent space.
    pub dq: M,
    /// d qdd / d qd.
    pub dqd: M,
    /// d qdd / d tau: the inverse of the mass matrix.
    pub dtau: M,
}

/// The stabilization of constraints, and the limits below which rows count as dependent.
///
/// A constraint whose frames are displaced by phi obeys phi'' = -2 alpha phi' - beta^2 phi (Baumgarte 1972).
/// alpha = beta gives the fastest return without oscillation; the displacement halves in 1.7 / beta. With zeros
/// the displacement by an integrator's errors remains.
///
/// The mobility of a row is an inverse inertia, 1/kg. A row depends on others if the mobility that they leave to it
/// is at most a threshold. The threshold is `tolerance` times the mobility of the constraint's relative motion, plus
/// `rounding` times the row's own mobility. Rotations are multiplied by the constraint's characteristic length.
///
/// ```
/// use modyn_runtime::ConstraintSettings;
///
/// let stiff = ConstraintSettings { alpha: 100.0, beta: 100.0, ..ConstraintSettings::<f64>::DEFAULT };
/// assert_eq!(stiff.tolerance, 1e-10);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintSettings<T> {
    /// The damping of the displacements, 1/s.
    pub alpha: T,
    /// The stiffness of the displacements, 1/s.
    pub beta: T,
    /// The mobility of a dependent row relative to its constraint's mobility in all six directions: the squared
    /// angular error of the mechanism's axes, rad^2.
    pub tolerance: T,
    /// The part of a row's own mobility that rounding may leave.
    pub rounding: T,
}

impl ConstraintSettings<f64> {
    /// alpha = beta = 20/s, axes that are off by 1e-5 rad, and the square root of the precision.
    pub const DEFAULT: Self = Self { alpha: 20.0, beta: 20.0, tolerance: 1e-10, rounding: 1e-10 };

    /// No stabilization, for mechanisms whose constraints are satisfied exactly.
    pub const EXACT: Self = Self { alpha: 0.0, beta: 0.0, ..Self::DEFAULT };
}

impl ConstraintSettings<f32> {
    /// alpha = beta = 20/s, axes that are off by 1e-4 rad, and a hundred times the precision.
    pub const DEFAULT: Self = Self { alpha: 20.0, beta: 20.0, tolerance: 1e-8, rounding: 1e-5 };

    /// No stabilization, for mechanisms whose constraints are satisfied exactly.
    pub const EXACT: Self = Self { alpha: 0.0, beta: 0.0, ..Self::DEFAULT };
}

impl Default for ConstraintSettings<f64> {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Default for ConstraintSettings<f32> {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The accelerations of a robot under its constraints, and the constraint wrenches.
///
/// Wrenches and residuals are arrays with an entry for each loop constraint, at its second frame's origin in its
/// first frame's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstrainedForwardDynamics<V, W, R, T> {
    /// The joint accelerations, rad/s^2 or m/s^2.
    pub qdd: V,
    /// The wrench on each constraint's second link, N m and N; the opposite wrench acts on the first link. If rows
    /// are redundant, the wrenches minimize the sum of force^2 + (moment / l)^2 over all constraints, with the
    /// characteristic length l of each.
    pub wrenches: W,
    /// The unmet part of each constraint's relative acceleration, rad/s^2 and m/s^2. It is within rounding of zero
    /// unless rows contradict each other. Then it minimizes the sum of linear^2 + (l angular)^2.
    pub residuals: R,
    /// The number of independent constraint rows, an integer.
    pub rank: T,
}

/// A step that satisfies the constraints, and the change of the velocities that keeps them satisfied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintProjection<V, T> {
    /// The displacement, in tangent space, from coordinates that nearly satisfy the constraints.
    pub dq: V,
    /// The change of the velocities.
    pub dqd: V,
    /// The number of independent constraint rows, an integer.
    pub rank: T,
}

/// The violation of the constraints: arrays with an entry for each loop constraint, for its second frame relative
/// to its first, in the first frame's axes, without the free directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintResidual<D> {
    /// The displacements, m; a rotation is its axis times the sine of its angle.
    pub displacements: D,
    /// The velocities, m/s and rad/s.
    pub velocities: D,
}

/// The limits of a robot's joints; infinite without a limit in the description.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits<'a> {
    /// The lower position limits, rad or m, one for each entry of `q`.
    pub lower: &'a [f64],
    /// The upper position limits, rad or m, one for each entry of `q`.
    pub upper: &'a [f64],
    /// The velocity limits, rad/s or m/s, one for each entry of `qd`.
    pub velocity: &'a [f64],
    /// The effort limits, N m or N, one for each entry of `qd`.
    pub effort: &'a [f64],
}

/// The number of operations of a function. Changes of sign are not counted.
///
/// ```
/// use modyn_runtime::OperationCount;
///
/// let count = OperationCount { multiplications: 3, additions: 2, ..OperationCount::default() };
/// assert_eq!((count + count).total(), 10);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OperationCount {
    /// The number of multiplications.
    pub multiplications: usize,
    /// The number of additions and subtractions.
    pub additions: usize,
    /// The number of divisions.
    pub divisions: usize,
    /// The number of angles whose sine, cosine or both are computed.
    pub sin_cos: usize,
    /// The number of square roots, logarithms, absolute values, maxima and selections.
    pub others: usize,
}

impl OperationCount {
    /// Returns the number of multiplications, additions and divisions together.
    #[must_use]
    pub const fn total(&self) -> usize {
        self.multiplications + self.additions + self.divisions
    }
}

impl core::iter::Sum for OperationCount {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        counts.fold(Self::default(), |sum, count| sum + count)
    }
}

impl core::ops::Add for OperationCount {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            multiplications: self.multiplications + other.multiplications,
            additions: self.additions + other.additions,
            divisions: self.divisions + other.divisions,
            sin_cos: self.sin_cos + other.sin_cos,
            others: self.others + other.others,
        }
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
