//! Moving in the space of the coordinates, which for rotations and poses is no vector space.
//!
//! Tangent vectors have one number a degree of freedom: at a rotation, a rotation vector in the
//! turned axes; at a pose, a linear part, then a rotation vector, in the moved axes. So a velocity
//! times a time is one, and the maps are the exponential ones of SO(3) and SE(3) (Murray, Li and
//! Sastry 1994, A Mathematical Introduction to Robotic Manipulation, chapter 2).

use crate::Scalar;
use crate::mechanism::Mechanism;
use crate::mechanism::coordinates::{CoordinateSpace, Coordinates};
use crate::spatial::{Quaternion, Vector3, screw_translation, screw_velocity};

/// Where the constant velocities `v` lead from `q` in a unit of time: q (+) v into `out` (nq).
///
/// The quaternions' lengths stay at 1 over any number of steps.
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

/// The v with `from` (+) v = `to` into `out` (nv): the shortest rotations; angles are not wrapped.
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

/// The rates dq/dt of the coordinates `q` at velocities `qd` into `out` (nq).
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

/// Brings the quaternions in `q` to length 1; one of length 0 becomes the identity.
pub fn normalize<S: Scalar>(model: &Mechanism<S>, q: &mut [S]) {
    for at in model.coordinates.iter().filter_map(quaternion) {
        write_rotation(rotation(q, at).normalized(), q, at);
    }
}

/// The coordinates zero, with identity quaternions, into `q`.
pub fn neutral<S: Scalar>(model: &Mechanism<S>, q: &mut [S]) {
    q.fill(S::zero());
    for at in model.coordinates.iter().filter_map(quaternion) {
        write_rotation(Quaternion::identity(), q, at);
    }
}

/// Random coordinates into `q`, evenly spread within the joints' limits; without limits, angles in
/// half a turn both ways, displacements in 1 m both ways, and rotations everywhere.
///
/// `uniform` gives independent numbers evenly spread in 0..1; it is called nv times.
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

/// Not above `high`, whatever rounding does.
fn interpolate<S: Scalar>(low: S, high: S, part: S) -> S {
    -(-(low + (high - low) * part)).max(-high)
}

/// Evenly spread over all rotations: Shoemake 1992, "Uniform random rotations", Graphics Gems III.
fn any_rotation<S: Scalar>(uniform: &mut dyn FnMut() -> S) -> Quaternion<S> {
    let turn = S::from_f64(core::f64::consts::TAU);
    let part = uniform();
    let (near, far) = ((S::one() - part).sqrt(), part.sqrt());
    let (first, second) = ((turn * uniform()).sin_cos(), (turn * uniform()).sin_cos());
    Quaternion::from_components([near * first.0, near * first.1, far * second.0, far * second.1])
}

/// Where the quaternion of these coordinates starts in q.
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
