//! The configuration space: integration, differences, rates and random values of coordinates.
//!
//! Rotations and poses are no vector space. Tangent vectors have one entry for each degree of
//! freedom. At a rotation it is a rotation vector in the rotated axes. At a pose it is a linear
//! part, then a rotation vector, both in the moved axes. A velocity times a time is a tangent
//! vector. The maps are the exponential maps of SO(3) and SE(3) (Murray, Li and Sastry 1994, "A
//! Mathematical Introduction to Robotic Manipulation", chapter 2).

use crate::Scalar;
use crate::mechanism::Mechanism;
use crate::mechanism::coordinates::{CoordinateSpace, Coordinates};
use crate::scalar::at_most;
use crate::spatial::{
    Matrix3, Quaternion, Vector3, inverse_rotation_jacobian, rotation_jacobian, screw_translation,
    screw_translation_by_rotation, screw_velocity,
};

/// Computes the coordinates after unit time at the constant velocities `v` from `q`: q (+) v, nq
/// entries.
///
/// Quaternions keep length 1 over any number of steps.
pub fn integrate<S: Scalar>(model: &Mechanism<S>, q: &[S], v: &[S], out: &mut [S]) {
    for block in &model.coordinates {
        match block.space {
            CoordinateSpace::Line { .. } => out[block.q] = q[block.q] + v[block.v],
            CoordinateSpace::Rotation => {
                let rotated = rotation(q, block.q).times(Quaternion::exp(vector(v, block.v)));
                write_rotation(rotated.renormalized(), out, block.q);
            }
            CoordinateSpace::Pose => {
                let linear = vector(v, block.v);
                let w = vector(v, block.v + 3);
                let attitude = rotation(q, block.q + 3);
                let moved = attitude.rotate(screw_translation(w, linear));
                write_vector(vector(q, block.q) + moved, out, block.q);
                let rotated = attitude.times(Quaternion::exp(w)).renormalized();
                write_rotation(rotated, out, block.q + 3);
            }
        }
    }
}

/// Computes the coordinates after the time `dt` from `q`: origins of floating joints move straight
/// at their velocities at `q`, rotations follow the exponential map. Turns the linear velocities in
/// `qd` from the axes at `q` to the axes at the result.
pub fn move_straight<S: Scalar>(model: &Mechanism<S>, q: &[S], qd: &mut [S], dt: S, out: &mut [S]) {
    for block in &model.coordinates {
        match block.space {
            CoordinateSpace::Line { .. } => out[block.q] = q[block.q] + dt * qd[block.v],
            CoordinateSpace::Rotation => {
                let turn = Quaternion::exp(vector(qd, block.v).scale(dt));
                write_rotation(rotation(q, block.q).times(turn).renormalized(), out, block.q);
            }
            CoordinateSpace::Pose => {
                let linear = vector(qd, block.v);
                let w = vector(qd, block.v + 3);
                let attitude = rotation(q, block.q + 3);
                let turn = Quaternion::exp(w.scale(dt));
                let moved = attitude.rotate(linear.scale(dt));
                write_vector(vector(q, block.q) + moved, out, block.q);
                write_rotation(attitude.times(turn).renormalized(), out, block.q + 3);
                write_vector(turn.conjugate().rotate(linear), qd, block.v);
            }
        }
    }
}

/// Computes the tangent vector v with `from` (+) v = `to`, nv entries. Rotations are the shortest
/// ones; joint angles are not wrapped.
pub fn difference<S: Scalar>(model: &Mechanism<S>, from: &[S], to: &[S], out: &mut [S]) {
    for block in &model.coordinates {
        Tangent::between(block, from, to).write(block, out);
    }
}

/// Computes the derivatives of [`integrate`] with respect to `q` and `v`, nv x nv matrices by
/// columns, at the displacement `v`.
///
/// Both are in tangent space, in the axes at `q` and at the moved coordinates. They do not depend
/// on `q` (Sola, Deray and Atchuthan 2018, "A micro Lie theory for state estimation in robotics").
pub fn integrate_derivatives<S: Scalar>(
    model: &Mechanism<S>,
    v: &[S],
    dq_dq: &mut [S],
    dq_dv: &mut [S],
) {
    fill(model, dq_dq, |block| Transport::of_start(Tangent::read(block, v)));
    fill(model, dq_dv, |block| Transport::of_displacement(Tangent::read(block, v)));
}

/// Computes the derivatives of [`difference`] with respect to `from` and `to`, nv x nv matrices by
/// columns, in tangent space.
pub fn difference_derivatives<S: Scalar>(
    model: &Mechanism<S>,
    from: &[S],
    to: &[S],
    dv_dfrom: &mut [S],
    dv_dto: &mut [S],
) {
    // `difference` of exchanged arguments has the other sign.
    let backwards = |block: &_| Tangent::between(block, from, to).negated();
    fill(model, dv_dfrom, |block| Transport::inverse_of_displacement(backwards(block)).negated());
    let forwards = |block: &_| Tangent::between(block, from, to);
    fill(model, dv_dto, |block| Transport::inverse_of_displacement(forwards(block)));
}

/// Computes dq/dt, the rates of the coordinates `q` at the velocities `qd`, nq entries.
pub fn velocity_to_qdot<S: Scalar>(model: &Mechanism<S>, q: &[S], qd: &[S], out: &mut [S]) {
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

/// Computes the velocities at which the coordinates `q` have the rates `qdot`, nv entries: the inverse
/// of [`velocity_to_qdot`].
pub fn qdot_to_velocity<S: Scalar>(model: &Mechanism<S>, q: &[S], qdot: &[S], out: &mut [S]) {
    // q* dq is half of the angular velocity.
    let angular = |at: usize| {
        let [x, y, z, _] = rotation(q, at).conjugate().times(rotation(qdot, at)).components();
        Vector3([x, y, z]).scale(S::from_f64(2.0))
    };
    for block in &model.coordinates {
        match block.space {
            CoordinateSpace::Line { .. } => out[block.v] = qdot[block.q],
            CoordinateSpace::Rotation => write_vector(angular(block.q), out, block.v),
            CoordinateSpace::Pose => {
                let back = rotation(q, block.q + 3).conjugate();
                write_vector(back.rotate(vector(qdot, block.q)), out, block.v);
                write_vector(angular(block.q + 3), out, block.v + 3);
            }
        }
    }
}

/// Scales the quaternions in `q` to length 1. A quaternion of length 0 becomes the identity.
pub fn normalize_configuration<S: Scalar>(model: &Mechanism<S>, q: &mut [S]) {
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

/// Computes random coordinates, uniformly distributed within the joint limits. Without limits,
/// angles are within -pi..pi, displacements within -1 m..1 m, and rotations uniformly distributed
/// over SO(3).
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

/// The entries of a tangent vector at a group of coordinates.
#[derive(Clone, Copy)]
enum Tangent<S> {
    /// The entry of a number.
    Line(S),
    /// A rotation vector.
    Rotation(Vector3<S>),
    /// A linear part, then a rotation vector.
    Pose(Vector3<S>, Vector3<S>),
}

impl<S: Scalar> Tangent<S> {
    /// Returns the entries of `v`.
    fn read(block: &Coordinates<S>, v: &[S]) -> Self {
        match block.space {
            CoordinateSpace::Line { .. } => Self::Line(v[block.v]),
            CoordinateSpace::Rotation => Self::Rotation(vector(v, block.v)),
            CoordinateSpace::Pose => Self::Pose(vector(v, block.v), vector(v, block.v + 3)),
        }
    }

    /// Returns the entries of the displacement that leads from `from` to `to`.
    fn between(block: &Coordinates<S>, from: &[S], to: &[S]) -> Self {
        let displacement = |at| rotation(from, at).conjugate().times(rotation(to, at)).log();
        match block.space {
            CoordinateSpace::Line { .. } => Self::Line(to[block.q] - from[block.q]),
            CoordinateSpace::Rotation => Self::Rotation(displacement(block.q)),
            CoordinateSpace::Pose => {
                let w = displacement(block.q + 3);
                let in_world = vector(to, block.q) - vector(from, block.q);
                let moved = rotation(from, block.q + 3).conjugate().rotate(in_world);
                Self::Pose(screw_velocity(w, moved), w)
            }
        }
    }

    fn write(self, block: &Coordinates<S>, out: &mut [S]) {
        match self {
            Self::Line(x) => out[block.v] = x,
            Self::Rotation(w) => write_vector(w, out, block.v),
            Self::Pose(linear, w) => {
                write_vector(linear, out, block.v);
                write_vector(w, out, block.v + 3);
            }
        }
    }

    fn negated(self) -> Self {
        match self {
            Self::Line(x) => Self::Line(-x),
            Self::Rotation(w) => Self::Rotation(-w),
            Self::Pose(linear, w) => Self::Pose(-linear, -w),
        }
    }
}

/// A linear map of the tangent vectors at a group of coordinates.
#[derive(Clone, Copy)]
enum Transport<S> {
    /// A factor, for a number.
    Line(S),
    /// A map of rotation vectors.
    Rotation(Matrix3<S>),
    /// A map of rotation vectors and of linear parts, and the linear parts that rotation vectors
    /// add.
    Pose(Matrix3<S>, Matrix3<S>),
}

impl<S: Scalar> Transport<S> {
    /// Returns the derivative of the coordinates after the displacement `v` with respect to the
    /// coordinates before.
    fn of_start(v: Tangent<S>) -> Self {
        match v {
            Tangent::Line(_) => Self::Line(S::one()),
            Tangent::Rotation(w) => Self::Rotation(Quaternion::exp(w).conjugate().matrix()),
            Tangent::Pose(linear, w) => {
                let back = Quaternion::exp(w).conjugate().matrix();
                let lever = Matrix3::cross(-screw_translation(w, linear));
                Self::Pose(back, back.times(&lever))
            }
        }
    }

    /// Returns the derivative of the coordinates after the displacement `v` with respect to `v`.
    fn of_displacement(v: Tangent<S>) -> Self {
        match v {
            Tangent::Line(_) => Self::Line(S::one()),
            Tangent::Rotation(w) => Self::Rotation(rotation_jacobian(w)),
            Tangent::Pose(linear, w) => {
                Self::Pose(rotation_jacobian(w), screw_translation_by_rotation(w, linear))
            }
        }
    }

    /// Returns the inverse of [`of_displacement`](Self::of_displacement).
    fn inverse_of_displacement(v: Tangent<S>) -> Self {
        match v {
            Tangent::Line(_) => Self::Line(S::one()),
            Tangent::Rotation(w) => Self::Rotation(inverse_rotation_jacobian(w)),
            Tangent::Pose(linear, w) => {
                let inverse = inverse_rotation_jacobian(w);
                let coupling = screw_translation_by_rotation(w, linear);
                Self::Pose(inverse, inverse.times(&coupling).times(&inverse).negated())
            }
        }
    }

    fn negated(self) -> Self {
        match self {
            Self::Line(factor) => Self::Line(-factor),
            Self::Rotation(map) => Self::Rotation(map.negated()),
            Self::Pose(map, coupling) => Self::Pose(map.negated(), coupling.negated()),
        }
    }

    /// Replaces the entries of `x` at these coordinates by their image.
    fn apply(self, block: &Coordinates<S>, x: &mut [S]) {
        let image = match (self, Tangent::read(block, x)) {
            (Self::Rotation(map), Tangent::Rotation(w)) => Tangent::Rotation(map.mul_vector(w)),
            (Self::Pose(map, coupling), Tangent::Pose(linear, w)) => {
                let linear = map.mul_vector(linear) + coupling.mul_vector(w);
                Tangent::Pose(linear, map.mul_vector(w))
            }
            (Self::Line(factor), Tangent::Line(x)) => Tangent::Line(factor * x),
            (_, x) => x,
        };
        image.write(block, x);
    }
}

/// Fills the block-diagonal matrix of these maps, by columns.
fn fill<S: Scalar>(
    model: &Mechanism<S>,
    columns: &mut [S],
    map: impl Fn(&Coordinates<S>) -> Transport<S>,
) {
    columns.fill(S::zero());
    for block in &model.coordinates {
        let map = map(block);
        for j in block.v..block.v + block.velocities() {
            let column = &mut columns[j * model.nv..][..model.nv];
            column[j] = S::one();
            map.apply(block, column);
        }
    }
}

/// Returns low + (high - low) part, at most `high` in spite of rounding; NaN for NaN.
fn interpolate<S: Scalar>(low: S, high: S, part: S) -> S {
    at_most(low + (high - low) * part, high)
}

/// Returns a uniformly distributed rotation: Shoemake 1992, "Uniform random rotations", Graphics
/// Gems III.
fn any_rotation<S: Scalar>(uniform: &mut dyn FnMut() -> S) -> Quaternion<S> {
    let full_turn = S::from_f64(core::f64::consts::TAU);
    let part = uniform();
    let near = (S::one() - part).sqrt();
    let far = part.sqrt();
    let first = (full_turn * uniform()).sin_cos();
    let second = (full_turn * uniform()).sin_cos();
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
