//! The values that travel together through the equations of constraints.

use super::ConstraintWorkspace;
use crate::constraint_settings::ConstraintSettings;
use crate::equations::Workspace;
use crate::spatial::{Twist, Wrench};

/// The constraints of a state: the active contacts, and the settings of all constraints.
#[derive(Debug)]
pub struct ConstraintInput<'a, S, C> {
    /// For each contact, 1 if it is active, else 0.
    pub active: &'a [S],
    /// The settings of all constraints.
    pub settings: &'a ConstraintSettings<S, C>,
}

impl<S, C> Clone for ConstraintInput<'_, S, C> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, C> Copy for ConstraintInput<'_, S, C> {}

/// The memory of constrained dynamics.
#[derive(Debug)]
pub struct ConstraintWorkspaces<'a, S> {
    /// The memory of the recursions over bodies.
    pub workspace: &'a mut Workspace<S>,
    /// The memory of the constraints.
    pub memory: &'a mut ConstraintWorkspace<S>,
}

impl<S> ConstraintWorkspaces<'_, S> {
    /// Returns the same memory for a call.
    pub fn reborrow(&mut self) -> ConstraintWorkspaces<'_, S> {
        let Self { workspace, memory } = self;
        ConstraintWorkspaces { workspace, memory }
    }
}

/// The results of [`constrained_forward_dynamics`](super::constrained_forward_dynamics).
#[derive(Debug)]
pub struct ConstrainedOutputs<'a, S> {
    /// The joint accelerations.
    pub qdd: &'a mut [S],
    /// The wrench on each constraint's second link.
    pub wrenches: &'a mut [Wrench<S>],
    /// For each constraint, the part of the required relative acceleration that is not met.
    pub residuals: &'a mut [Twist<S>],
}

/// The results of [`project_constraints`](super::project_constraints).
#[derive(Debug)]
pub struct ProjectionOutputs<'a, S> {
    /// The step of the coordinates, in tangent space.
    pub step_q: &'a mut [S],
    /// The step of the velocities.
    pub step_qd: &'a mut [S],
}

/// The results of [`constraint_residual`](super::constraint_residual), an entry for each
/// constraint.
#[derive(Debug)]
pub struct ResidualOutputs<'a, S> {
    /// The displacements that violate the constraints.
    pub displacements: &'a mut [Twist<S>],
    /// The velocities that violate the constraints.
    pub velocities: &'a mut [Twist<S>],
}

/// The results of [`impact_dynamics`](super::impact_dynamics).
#[derive(Debug)]
pub struct ImpulseOutputs<'a, S> {
    /// The velocities after the impact.
    pub qd: &'a mut [S],
    /// The impulse on each constraint's second link.
    pub impulses: &'a mut [Wrench<S>],
}

/// The results of [`constrained_inverse_dynamics`](super::constrained_inverse_dynamics).
#[derive(Debug)]
pub struct ConstrainedInverseOutputs<'a, S> {
    /// The joint forces.
    pub tau: &'a mut [S],
    /// The wrench on each constraint's second link.
    pub wrenches: &'a mut [Wrench<S>],
}

/// The results of [`operational_space_inertia`](super::operational_space_inertia), arrays of columns.
#[derive(Debug)]
pub struct OperationalSpaceInertiaOutputs<'a, S> {
    /// J M^-1 J^T.
    pub delassus: &'a mut [S],
    /// The pseudo-inverse of J M^-1 J^T.
    pub inertia: &'a mut [S],
}

/// The weights of the results of
/// [`constrained_forward_dynamics`](super::constrained_forward_dynamics) in a sum.
#[derive(Clone, Copy, Debug)]
pub struct ConstrainedCotangent<'a, S> {
    /// The weight of each joint acceleration.
    pub qdd: &'a [S],
    /// The weight of each component of each constraint's wrench, in the wrench's axes.
    pub wrenches: &'a [Wrench<S>],
}
