//! The coordinates along a motion, for finite differences.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::Model;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::random::normalize_configuration;

/// Returns dq/dt at `q` and velocities `qd`: q (w, 0) / 2 for a quaternion, R v for the position of a floating joint,
/// and the velocities themselves for other joints.
#[must_use]
pub fn rates(model: &Model, q: &[f64], qd: &[f64]) -> Vec<f64> {
    let mut rates = Vec::with_capacity(q.len());
    for (i, link) in model.moving_links().iter().enumerate() {
        if link.joint.mimic.is_some() {
            continue;
        }
        let (q, qd) = (&q[model.q_range(i)], &qd[model.v_range(i)]);
        match link.joint.joint_type {
            JointType::Spherical => rates.extend(quaternion_rate(q, qd)),
            JointType::Floating => {
                let rotation = UnitQuaternion::new_unchecked(quaternion(&q[3..]));
                rates.extend(rotation.transform_vector(&vector(&qd[..3])).iter());
                rates.extend(quaternion_rate(&q[3..], &qd[3..]));
            }
            _ => rates.extend(qd),
        }
    }
    rates
}

/// Returns `q` after a motion with velocities `qd` for `time`. The result is exact for coordinates without a quaternion,
/// and exact to first order in the time for quaternions.
#[must_use]
pub fn along(model: &Model, q: &[f64], time: f64, qd: &[f64]) -> Vec<f64> {
    let mut moved = rates(model, q, qd);
    moved.iter_mut().zip(q).for_each(|(rate, q)| *rate = q + time * *rate);
    normalize_configuration(model, &mut moved);
    moved
}

fn quaternion_rate(q: &[f64], omega: &[f64]) -> [f64; 4] {
    let rate = quaternion(q) * Quaternion::from_imag(vector(omega)) / 2.0;
    rate.coords.into()
}

/// Returns the quaternion with components x, y, z, w.
fn quaternion(q: &[f64]) -> Quaternion<f64> {
    Quaternion::new(q[3], q[0], q[1], q[2])
}

fn vector(x: &[f64]) -> Vector3<f64> {
    Vector3::new(x[0], x[1], x[2])
}
