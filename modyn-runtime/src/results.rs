//! What generated robots say of themselves, and results that have parts.

use core::fmt;

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
    /// Where its first entry stands in velocity vectors; the others follow.
    pub first: usize,
    /// How many entries it has there.
    pub dofs: usize,
}

/// The derivatives of the inverse dynamics: square matrices by columns, a column for each entry
/// of what is derived by.
///
/// The derivative by the accelerations is the mass matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseDynamicsDerivatives<M> {
    /// d tau / d q, in tangent space.
    pub dq: M,
    /// d tau / d qd.
    pub dqd: M,
}

/// The derivatives of the forward dynamics, and the accelerations at which they are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForwardDynamicsDerivatives<V, M> {
    /// The accelerations.
    pub qdd: V,
    /// d qdd / d q, in tangent space.
    pub dq: M,
    /// d qdd / d qd.
    pub dqd: M,
    /// d qdd / d tau: the inverse of the mass matrix.
    pub dtau: M,
}

/// How constraints are stabilized, and which of their rows count as independent.
///
/// A constraint whose frames are displaced by phi obeys phi'' = -2 alpha phi' - beta^2 phi (Baumgarte 1972).
/// Alpha = beta is the fastest return without oscillation, by half in 1.7 / beta; zeros keep the
/// displacement that an integrator's errors have caused.
///
/// A row of the constraints depends on others where they leave it a mobility (inverse inertia, 1/kg) of at
/// most `tolerance` times the mobility of its constraint's relative motion, plus `rounding` times the
/// row's own. Rotations count times the constraint's characteristic length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintSettings<T> {
    /// Damping of the displacements, 1/s.
    pub alpha: T,
    /// Stiffness of the displacements, 1/s.
    pub beta: T,
    /// The mobility of a dependent row as a share of its constraint's mobility in all six directions: the
    /// square of the error, as an angle, that axes and joints of the mechanism may have.
    pub tolerance: T,
    /// The share of a row's own mobility that rounding may leave of it.
    pub rounding: T,
}

impl ConstraintSettings<f64> {
    /// alpha = beta = 20/s, axes that are off by 1e-5 rad, and the square root of the precision.
    pub const DEFAULT: Self = Self { alpha: 20.0, beta: 20.0, tolerance: 1e-10, rounding: 1e-10 };

    /// Constraints of accelerations alone: for mechanisms whose constraints are met exactly.
    pub const EXACT: Self = Self { alpha: 0.0, beta: 0.0, ..Self::DEFAULT };
}

impl ConstraintSettings<f32> {
    /// alpha = beta = 20/s, axes that are off by 1e-4 rad, and a hundred times the precision.
    pub const DEFAULT: Self = Self { alpha: 20.0, beta: 20.0, tolerance: 1e-8, rounding: 1e-5 };

    /// Constraints of accelerations alone: for mechanisms whose constraints are met exactly.
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

/// The accelerations of a robot under its constraints, and the wrenches that meet them.
///
/// Wrenches and residuals are arrays with an entry for each loop constraint, at its second frame's
/// origin in its first frame's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstrainedForwardDynamics<V, W, R, T> {
    /// The accelerations, rad/s^2 or m/s^2.
    pub qdd: V,
    /// The wrench on the constraint's second link, N m and N; the first link feels the opposite. Where
    /// rows are redundant, the wrenches with the smallest sum of force^2 + (moment / l)^2 over all
    /// constraints, with the characteristic length l of each.
    pub wrenches: W,
    /// The part of each constraint's relative acceleration that could not be met, rad/s^2 and m/s^2:
    /// rounding, unless rows contradict each other. Then it is the smallest possible, as a sum of
    /// linear^2 + (l angular)^2.
    pub residuals: R,
    /// The number of independent constraint rows, an integer.
    pub rank: T,
}

/// A step that meets the constraints, and the change of the velocities that keeps them met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintProjection<V, T> {
    /// The displacement, in tangent space, from coordinates that nearly meet the constraints.
    pub dq: V,
    /// The change of the velocities.
    pub dqd: V,
    /// The number of independent constraint rows, an integer.
    pub rank: T,
}

/// How far constraints are from being met: arrays with an entry for each loop constraint, of its second
/// frame relative to its first, in the first frame's axes, without the free directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintResidual<D> {
    /// Displacements, m; rotations by their axes times the sines of their angles.
    pub displacements: D,
    /// Velocities, m/s and rad/s.
    pub velocities: D,
}

/// The limits of a robot's joints, infinite where the description states none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits<'a> {
    /// Smallest coordinates, rad or m; one for each entry of `q`.
    pub lower: &'a [f64],
    /// Largest coordinates, rad or m.
    pub upper: &'a [f64],
    /// Largest speeds, rad/s or m/s; one for each entry of `qd`.
    pub velocity: &'a [f64],
    /// Largest efforts, N m or N.
    pub effort: &'a [f64],
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
