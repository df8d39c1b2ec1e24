//! Degrees of freedom: unit motions of bodies.

use crate::Scalar;
use crate::spatial::SpatialAxis;

/// A degree of freedom: the unit motion of a body in one component of its twist.
#[derive(Clone, Copy, Debug)]
pub struct Dof<S> {
    /// The body that it moves.
    pub body: usize,
    /// The component (linear x, y, z, angular x, y, z) of the body's twist.
    pub component: usize,
    /// The entry of qd, qdd and tau that belongs to it.
    pub v: usize,
    /// The multiplier of a mimic joint, relative to that entry.
    pub multiplier: Option<S>,
    /// The rotor's inertia about this motion (kg m^2, or kg); `None` without a rotor.
    pub armature: Option<S>,
    /// Viscous damping (N m s/rad, or N s/m); `None` if damping does not act.
    pub damping: Option<S>,
    /// Coulomb friction (N m, or N); `None` if friction does not act.
    pub friction: Option<S>,
}

impl<S> Dof<S> {
    /// Returns the axis that the body moves along or rotates about.
    #[must_use]
    pub fn axis(&self) -> SpatialAxis {
        SpatialAxis::of(self.component)
    }
}

impl<S: Scalar> Dof<S> {
    /// Returns the degree of freedom with `f` applied to its numbers.
    pub(super) fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> Dof<T> {
        Dof {
            body: self.body,
            component: self.component,
            v: self.v,
            multiplier: self.multiplier.map(f),
            armature: self.armature.map(f),
            damping: self.damping.map(f),
            friction: self.friction.map(f),
        }
    }

    /// Returns the rate (or acceleration) of the degree of freedom, given the joint vector `x`.
    #[must_use]
    pub fn rate(&self, x: &[S]) -> S {
        self.scale(x[self.v])
    }

    /// Returns `x` times the multiplier of a mimic joint.
    #[must_use]
    pub fn scale(&self, x: S) -> S {
        self.multiplier.map_or(x, |multiplier| multiplier * x)
    }

    /// Adds the generalized `force` along the degree of freedom to the joint vector `sum`.
    pub fn add(&self, force: S, sum: &mut [S]) {
        sum[self.v] = sum[self.v] + self.scale(force);
    }
}

/// The rates of a joint, one for each of its degrees of freedom.
#[derive(Clone, Copy, Debug)]
pub struct Rates<S> {
    pub(super) numbers: [S; 6],
    pub(super) count: usize,
}

impl<S> core::ops::Deref for Rates<S> {
    type Target = [S];
    fn deref(&self) -> &[S] {
        &self.numbers[..self.count]
    }
}
