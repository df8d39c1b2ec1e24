//! Transforms of joints with a general rotation.

use crate::Scalar;
use crate::spatial::{Matrix3, Twist, Wrench};

pub(super) fn twist_to_child<S: Scalar>(rotation: &Matrix3<S>, t: Twist<S>) -> Twist<S> {
    let back = rotation.transposed();
    Twist { angular: back.mul_vector(t.angular), linear: back.mul_vector(t.linear) }
}

pub(super) fn wrench_to_parent<S: Scalar>(rotation: &Matrix3<S>, w: Wrench<S>) -> Wrench<S> {
    Wrench { moment: rotation.mul_vector(w.moment), force: rotation.mul_vector(w.force) }
}
