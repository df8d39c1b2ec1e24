//! Derivatives of inverse and forward dynamics, in closed form.
//!
//! The method follows Singh, Russell and Wensing 2022 ("Efficient analytical derivatives of
//! rigid-body dynamics using spatial vector algebra"). It differs in three points: it works in the
//! bodies' own axes, with classical accelerations, and stores 12 numbers for the Coriolis forces of
//! a composite ([`VelocityMoments`](crate::spatial::VelocityMoments)).
//!
//! A degree of freedom displaces all points of its body and of the body's descendants. Its
//! coordinate and its rate change the accelerations of these points by fields of one form
//! (`perturbation`). The wrench of a composite under such a field acts on the joints of its
//! ancestors. The power of such a field at a unit displacement of a descendant is the force on the
//! descendant's joint (`projection`).
//!
//! Derivatives with respect to coordinates are in the tangent space. For spherical and floating
//! joints the tangent vectors are displacements in the link's own axes. Matrices are nv x nv by
//! columns.
//!
//! Velocity forces are quadratic in qd, so forward dynamics with derivatives gets its bias forces
//! from d tau / d qd, and needs one Newton-Euler pass, at the computed accelerations. The
//! derivatives are solved for by the factors of the mass matrix, not by the recursion, because the
//! columns then share more operations; in lanes they are products with the inverse, which takes
//! fewer operations there. Columns move to the root one by one in the interpreter, and four in the
//! lanes of a pack in vector code (`MergedMechanism::with_column_lanes`).

mod centroidal;
mod composite;
mod coriolis;
mod external;
mod forward;
mod inverse;
mod perturbation;
mod projection;

pub use {centroidal::*, coriolis::*, external::*, forward::*, inverse::*};
