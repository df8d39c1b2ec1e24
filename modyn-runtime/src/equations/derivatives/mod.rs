//! Derivatives of inverse and forward dynamics, in closed form.
//!
//! After Singh, Russell and Wensing 2022 ("Efficient analytical derivatives of rigid-body dynamics
//! using spatial vector algebra"), but in the bodies' own axes, with classical accelerations, and
//! with 12 numbers a composite for its Coriolis forces
//! ([`VelocityMoments`](crate::spatial::VelocityMoments)).
//!
//! A degree of freedom displaces each point after it. Its coordinate and its rate change the points'
//! accelerations by fields of one form (`perturbation`). A composite's wrench under such a field acts on its
//! ancestors' joints; the power of such a field at a unit displacement of a descendant acts on the
//! descendant's joint (`projection`).
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
