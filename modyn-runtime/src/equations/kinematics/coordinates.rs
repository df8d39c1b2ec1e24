//! The configuration space: integration, differences, rates and random values of coordinates.
//!
//! Rotations and poses are no vector space. Tangent vectors have one entry for each degree of freedom.
//! At a rotation it is a rotation vector in the rotated axes. At a pose it is a linear part, then a
//! rotation vector, both in the moved axes. A velocity times a time is a tangent vector. The maps are the
//! exponential maps of SO(3) and SE(3) (Murray, Li and Sastry 1994, "A Mathematical Introduction to
//! Robotic Manipulation", chapter 2).

use crate::Scalar;
use crate::mechanism::Mechanism;
use crate::mechanism::coordinates::{CoordinateSpace, Coordinates};
use crate::spatial::{Quaternion, Vector3, screw_translation, screw_velocity};

/// Computes the coordinates after unit time at the constant velocities `v` from `q`: q (+) v, nq entries.
///
/// Quaternions keep length 1 over any number of steps.
pub fn integrate<S: Scalar>(model: &Mechanism<S>, (q, v): (&[S], &[S]), out: &mut [S]) {
    for block in &model.coordinates {
        match block.space {
            CoordinateSpace::Line { .. } => out[block.q] = q[block.q] + v[block.v],
            CoordinateSpace::Rotation => {
                let turned = rotation(q, block.q).times(Quaternion::exp(vector(v, block.v)));
                write_rotation(turned.renormalized(), out, block.q);
            }
            CoordinateSpace::Pose => {
                let (linear, w) = (vector(v, block.v), vector(v, block.v + 3));
                let attitude = rotation(q, block.q + 3);
                let moved = attitude.rotate(screw_translation(w, linear));
                write_vector(vector(q, block.q) + moved, out, block.q);
                let turned = attitude.times(Quaternion::exp(w)).renormalized();
                write_rotation(turned, out, block.q + 3);
            }
        }
    }
}

/// Computes the tangent vector v with `from` (+) v = `to`, nv entries. Rotations are the shortest ones;
/// joint angles are not wrapped.
pub fn difference<S: Scalar>(model: &Mechanism<S>, (from, to): (&[S], &[S]), out: &mut [S]) {
    let turn = |at| rotation(from, at).conjugate().times(rotation(to, at)).log();
    for block in &model.coordinates {
        match block.space {
            CoordinateSpace::Line { .. } => out[block.v] = to[block.q] - from[block.q],
            CoordinateSpace::Rotation => write_vector(turn(block.q), out, block.v),
            CoordinateSpace::Pose => {
                let w = turn(block.q + 3);
                let moved = vector(to, block.q) - vector(from, block.q);
                let moved = rotation(from, block.q + 3).conjugate().rotate(moved);
                write_vector(screw_velocity(w, moved), out, block.v);
                write_vector(w, out, block.v + 3);
            }
        }
    }
}

/// Computes dq/dt, the rates of the coordinates `q` at the velocities `qd`, nq entries.
pub fn velocity_to_qdot<S: Scalar>(model: &Mechanism<S>, (q, qd): (&[S], &[S]), out: &mut [S]) {
    for block in &model.coordinates {
        match block.space {
            CoordinateSpace::Line { .. } => out[block.q] = qd[block.v],
            CoordinateSpace::Rotation => {
                write_rotation(rotation(q, block.q).rate(vector(qd, block.v)), out, block.q);
            }
            CoordinateSpace::Pose => {
                let attitude = rotation(q, block.q + 3);
                write_vector(attitude.rotate(vector(qd, block.v)), out, block.q);
                write_rotation(attitude.rate(vector(qd, block.v + 3)), out, block.q + 3);
            }
        }
    }
}

/// Scales the quaternions in `q` to length 1. A quaternion of length 0 becomes the identity.
pub fn normalize<S: Scalar>(model: &Mechanism<S>, q: &mut [S]) {
    for at in model.coordinates.iter().filter_map(quaternion) {
        write_rotation(rotation(q, at).normalized(), q, at);
    }
}

/// Sets all coordinates to zero, and quaternions to the identity.
pub fn neutral<S: Scalar>(model: &Mechanism<S>, q: &mut [S]) {
    q.fill(S::zero());
    for at in model.coordinates.iter().filter_map(quaternion) {
        write_rotation(Quaternion::identity(), q, at);
    }
}

/// Computes random coordinates, uniformly distributed within the joint limits. Without limits, angles are
/// within -pi..pi, displacements within -1 m..1 m, and rotations uniformly distributed over SO(3).
///
/// `uniform` returns independent numbers, uniformly distributed in 0..1. It is called nv times.
pub fn random<S: Scalar>(model: &Mechanism<S>, uniform: &mut dyn FnMut() -> S, q: &mut [S]) {
    for block in &model.coordinates {
        match block.space {
            CoordinateSpace::Line { low, high } => q[block.q] = interpolate(low, high, uniform()),
            CoordinateSpace::Rotation => write_rotation(any_rotation(uniform), q, block.q),
            CoordinateSpace::Pose => {
                let one = S::one();
                let position = core::array::from_fn(|_| interpolate(-one, one, uniform()));
                write_vector(Vector3(position), q, block.q);
                write_rotation(any_rotation(uniform), q, block.q + 3);
            }
        }
    }
}

/// Returns low + (high - low) part, at most `high` in spite of rounding.
fn interpolate<S: Scalar>(low: S, high: S, part: S) -> S {
    -(-(low + (high - low) * part)).max(-high)
}

/// Returns a uniformly distributed rotation: Shoemake 1992, "Uniform random rotations", Graphics Gems III.
fn any_rotation<S: Scalar>(uniform: &mut dyn FnMut() -> S) -> Quaternion<S> {
    let turn = S::from_f64(core::f64::consts::TAU);
    let part = uniform();
    let (near, far) = ((S::one() - part).sqrt(), part.sqrt());
    let (first, second) = ((turn * uniform()).sin_cos(), (turn * uniform()).sin_cos());
    Quaternion::from_components([near * first.0, near * first.1, far * second.0, far * second.1])
}

/// Returns the index in q of the quaternion of these coordinates.
fn quaternion<S>(block: &Coordinates<S>) -> Option<usize> {
    match block.space {
        CoordinateSpace::Line { .. } => None,
        CoordinateSpace::Rotation => Some(block.q),
        CoordinateSpace::Pose => Some(block.q + 3),
    }
}

fn vector<S: Scalar>(x: &[S], at: usize) -> Vector3<S> {
    Vector3(core::array::from_fn(|i| x[at + i]))
}

fn rotation<S: Scalar>(q: &[S], at: usize) -> Quaternion<S> {
    Quaternion::from_components(core::array::from_fn(|i| q[at + i]))
}

fn write_vector<S: Scalar>(v: Vector3<S>, out: &mut [S], at: usize) {
    out[at..at + 3].copy_from_slice(&v.0);
}

fn write_rotation<S: Scalar>(rotation: Quaternion<S>, out: &mut [S], at: usize) {
    out[at..at + 4].copy_from_slice(&rotation.components());
}
