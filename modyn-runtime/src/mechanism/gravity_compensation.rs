//! Masses whose weight is compensated: upward forces on links, in proportion to their masses.

use super::Mechanism;
use crate::Scalar;
use crate::spatial::{RigidInertia, Vector3};

/// A mass on a body whose weight is compensated. Unlike the body's inertia it is not accelerated.
#[derive(Clone, Copy, Debug)]
pub struct CompensatedMass<S> {
    /// The mass, kg.
    pub mass: S,
    /// The first moment about the body's origin, in the body's axes, kg m.
    pub first_moment: Vector3<S>,
}

impl<S: Scalar> CompensatedMass<S> {
    /// Returns the mass with `f` applied to its numbers.
    #[must_use]
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> CompensatedMass<T> {
        CompensatedMass { mass: f(self.mass), first_moment: Vector3(self.first_moment.0.map(f)) }
    }

    /// Returns the part `factor` of the mass of `inertia`.
    #[must_use]
    pub fn part(inertia: &RigidInertia<S>, factor: S) -> Self {
        let RigidInertia { mass, first_moment, .. } = *inertia;
        Self { mass: factor * mass, first_moment: first_moment.scale(factor) }
    }

    /// Returns the sum of both.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let first_moment = self.first_moment + other.first_moment;
        Self { mass: self.mass + other.mass, first_moment }
    }
}

impl<S> Mechanism<S> {
    /// Returns whether the weight of any body is compensated.
    #[must_use]
    pub fn compensates_gravity(&self) -> bool {
        self.bodies.iter().any(|body| body.compensated.is_some())
    }
}
