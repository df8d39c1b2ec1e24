//! Derivatives of inverse and forward dynamics, in closed form.
//!
//! After Singh, Russell and Wensing 2022 ("Efficient analytical derivatives of rigid-body dynamics
//! using spatial vector algebra"), but in the bodies' own axes, with classical accelerations, and
//! with 12 numbers a composite for its Coriolis forces
//! ([`VelocityMoments`](crate::spatial::VelocityMoments)).
//!
//! A degree of freedom gives each point behind it a displacement. Its coordinate and its rate
//! change the points' accelerations by fields of one form (`perturbation`); what a composite answers
//! to such a field is felt in front, what such a field does to a unit displacement further behind
//! is felt there (`projection`).
//!
//! Derivatives by coordinates are in the tangent space: for spherical and floating joints, by a
//! displacement in the link's own axes. Matrices are nv x nv by columns.

mod composite;
mod forward;
mod inverse;
mod perturbation;
mod projection;

pub use forward::{ForwardDerivatives, forward_dynamics_derivatives};
pub use inverse::inverse_dynamics_derivatives;
