//! Degrees of freedom: unit motions of bodies.

use crate::Scalar;

/// A degree of freedom: the unit motion of a body in one component.
#[derive(Clone, Copy, Debug)]
pub struct Dof<S> {
    /// The body that it moves.
    pub body: usize,
    /// The component (angular x, y, z, linear x, y, z) of the body's twist.
    pub component: usize,
    /// The entry of qd, qdd and tau.
    pub v: usize,
    /// The ratio to that entry, for a joint that mimics.
    pub multiplier: Option<S>,
    /// The rotor's inertia about this motion (kg m^2, or kg), if there is one.
    pub armature: Option<S>,
    /// Viscous damping (N m s/rad, or N s/m), if it acts.
    pub damping: Option<S>,
    /// Coulomb friction (N m, or N), if it acts.
    pub friction: Option<S>,
}

impl<S: Scalar> Dof<S> {
    /// Each number through `f`.
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

    /// Returns its rate (or acceleration) in the joint vector `x`.
    #[must_use]
    pub fn rate(&self, x: &[S]) -> S {
        self.scale(x[self.v])
    }

    /// Returns `x` times the ratio of a joint that mimics.
    #[must_use]
    pub fn scale(&self, x: S) -> S {
        self.multiplier.map_or(x, |multiplier| multiplier * x)
    }

    /// Adds the generalized `force` along it to the joint vector `sum`.
    pub fn add(&self, force: S, sum: &mut [S]) {
        sum[self.v] = sum[self.v] + self.scale(force);
    }
}

/// The rates of a joint: as many numbers as it has degrees of freedom.
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
