//! The rows of loop constraints at a state: MuJoCo's `connect` and `weld`, and the loops of other
//! joints.

use alloc::vec::Vec;

use super::law::{RowState, SoftRow};
use super::rows::LoopParameters;
use crate::Scalar;
use crate::equations::kinematics::kinematic_path::{self, OriginMotion};
use crate::equations::{State, TimeStepInput};
use crate::mechanism::{BodyFrame, ConstrainedFrames, ConstraintRow, Mechanism};
use crate::scalar::at_least;
use crate::spatial::{Matrix3, Pose, Twist, Vector3};

/// The smallest cosine of half the angle between two frames that a weld holds.
const LEAST_COSINE: f64 = 1e-6;

/// A loop constraint at a state.
///
/// A displacement d between the origins has the components n.d along the rows' directions n, which
/// are fixed at the instant, as in MuJoCo. If only some displacements are constrained, they are
/// components in the first frame, which rotates. A rotation is the vector part of the quaternion
/// of the first frame in the second, as in MuJoCo; for a hinge the cross product of its axes in
/// both frames.
#[derive(Clone, Debug)]
pub(super) struct LoopRows<S> {
    constraint: ConstrainedFrames<S>,
    /// The axes of the bodies that carry the ends, in the world; of the world itself without a
    /// body.
    bodies: [Matrix3<S>; 2],
    /// The axes of the two frames in the world.
    axes: [Matrix3<S>; 2],
    /// The place of the second frame's origin relative to the first, in the world.
    displacement: Vector3<S>,
    rotation: Rotation<S>,
    /// The law of each row.
    pub rows: Vec<SoftRow<S>>,
}

/// The rotation between the frames of a loop.
#[derive(Clone, Copy, Debug)]
enum Rotation<S> {
    /// The quaternion of the first frame in the second, and the factor of its rows.
    Weld { scalar: S, vector: Vector3<S>, factor: S },
    /// The axis in the first frame, and the second frame's axis in the first frame.
    Hinge([Vector3<S>; 2]),
}

impl<S: Scalar> LoopRows<S> {
    /// Returns a loop at a state. `poses` are the bodies' poses in the world.
    pub fn new(
        model: &Mechanism<S>,
        constraint: &ConstrainedFrames<S>,
        parameters: &LoopParameters<S>,
        input: TimeStepInput<'_, S>,
        poses: &[Pose<S>],
    ) -> Self {
        let pose = |end: &BodyFrame<S>| match end.body {
            Some(body) => poses[body],
            None => Pose::identity(),
        };
        let bodies = constraint.ends.each_ref().map(|end| Matrix3(pose(end).rotation));
        let axes = [0, 1].map(|k| bodies[k].times(&Matrix3(constraint.ends[k].pose.rotation)));
        let state = State { q: input.q, qd: input.qd };
        let motions = constraint.ends.each_ref().map(|end| {
            let fixed = OriginMotion::fixed(Vector3(end.pose.translation));
            kinematic_path::towards_world(model, end.body)
                .fold(fixed, |frame, i| frame.towards_world(model, i, state, None))
        });
        let rotation = match constraint.hinge {
            Some(hinge) => {
                Rotation::Hinge([hinge, axes[0].transposed().times(&axes[1]).mul_vector(hinge)])
            }
            None => weld(&axes[1].transposed().times(&axes[0]), parameters.torque_scale),
        };
        let mut rows = Self {
            constraint: constraint.clone(),
            bodies,
            axes,
            displacement: motions[1].point - motions[0].point,
            rotation,
            rows: Vec::new(),
        };
        let velocities = rows.components(motions.map(|motion| motion.velocity));
        let biases = rows.components(motions.map(|motion| motion.acceleration));
        let transport = rows.along_rows(&rows.transport(motions.map(|motion| motion.velocity)));
        let displacements = rows.along_rows(&Twist {
            angular: match rows.rotation {
                Rotation::Weld { vector, factor, .. } => vector.scale(factor),
                Rotation::Hinge([first, second]) => first.cross(second),
            },
            linear: rows.axes[0].transposed().mul_vector(rows.displacement),
        });
        let square = displacements.iter().fold(S::zero(), |sum, &x| sum + x * x);
        let impedance = parameters.softness.impedance.at(square.sqrt());
        let laws = constraint.rows.iter().enumerate().map(|(k, row)| {
            let mobility = parameters.mobility[usize::from(row.angular)];
            let state = RowState { position: displacements[k], velocity: velocities[k], mobility };
            let law = parameters.softness.row_of_impedance(impedance, &state, input.dt);
            SoftRow { reference: law.reference - biases[k] - transport[k], ..law }
        });
        rows.rows = laws.collect();
        rows
    }

    /// Lowers the references by the accelerations of the rows in free fall.
    pub fn relative_to_fall(mut self, twists: &[Twist<S>]) -> Self {
        let fall = self.accelerations(twists);
        for (row, fall) in self.rows.iter_mut().zip(fall) {
            row.reference = row.reference - fall;
        }
        self
    }

    /// Returns the accelerations of the rows under these accelerations of the bodies.
    pub fn accelerations(&self, twists: &[Twist<S>]) -> Vec<S> {
        let of_end = |k: usize| {
            let BodyFrame { body, pose } = self.constraint.ends[k];
            let Some(body) = body else { return Twist::zero() };
            let Twist { angular, linear } = twists[body];
            let at_origin = linear + angular.cross(Vector3(pose.translation));
            let to_world = &self.bodies[k];
            Twist { angular: to_world.mul_vector(angular), linear: to_world.mul_vector(at_origin) }
        };
        self.components([of_end(0), of_end(1)])
    }

    /// Returns the components of the rows: of velocities, and of accelerations but for
    /// [`transport`](Self::transport). The arguments are the twists of both frames at their
    /// origins, in world axes.
    fn components(&self, [first, second]: [Twist<S>; 2]) -> Vec<S> {
        let mut linear = second.linear - first.linear;
        if self.is_in_first_frame() {
            linear = linear - first.angular.cross(self.displacement);
        }
        self.along_rows(&Twist {
            angular: self.turning(first.angular - second.angular),
            linear: self.axes[0].transposed().mul_vector(linear),
        })
    }

    /// Returns the rate of the rotation at the first frame's velocity relative to the second.
    fn turning(&self, relative: Vector3<S>) -> Vector3<S> {
        match self.rotation {
            Rotation::Weld { scalar, vector, factor } => {
                let rate = self.axes[1].transposed().mul_vector(relative);
                let turned = rate.scale(scalar) + rate.cross(vector);
                turned.scale(factor * S::from_f64(0.5))
            }
            Rotation::Hinge([axis, other]) => {
                let rate = self.axes[0].transposed().mul_vector(relative);
                axis.cross(other.cross(rate))
            }
        }
    }

    /// Returns the accelerations of the rows at these velocities of both frames, without the part
    /// that is linear in the frames' accelerations.
    fn transport(&self, [first, second]: [Twist<S>; 2]) -> Twist<S> {
        let relative = first.angular - second.angular;
        let half = S::from_f64(0.5);
        let angular = match self.rotation {
            Rotation::Weld { scalar, vector, factor } => {
                let rate = self.axes[1].transposed().mul_vector(relative);
                let scalar_rate = -(rate.dot(vector) * half);
                let vector_rate = (rate.scale(scalar) + rate.cross(vector)).scale(half);
                let turned = rate.scale(scalar_rate) + rate.cross(vector_rate);
                let of_axes = self.turning(relative.cross(second.angular));
                turned.scale(factor * half) + of_axes
            }
            Rotation::Hinge([axis, other]) => {
                let rate = self.axes[0].transposed().mul_vector(relative);
                axis.cross(rate.cross(rate.cross(other)))
                    + self.turning(relative.cross(first.angular))
            }
        };
        let linear = match self.is_in_first_frame() {
            true => {
                let turned = first.angular.cross(self.displacement);
                let velocity = second.linear - first.linear;
                first.angular.cross(turned - velocity - velocity)
            }
            false => Vector3::zero(),
        };
        Twist { angular, linear: self.axes[0].transposed().mul_vector(linear) }
    }

    /// Returns whether displacements are components in the first frame, which rotates.
    fn is_in_first_frame(&self) -> bool {
        self.constraint.rows.iter().filter(|row| !row.angular).count() < 3
    }

    fn along_rows(&self, twist: &Twist<S>) -> Vec<S> {
        let component = |row: &ConstraintRow<S>| {
            row.direction.dot(if row.angular { twist.angular } else { twist.linear })
        };
        self.constraint.rows.iter().map(component).collect()
    }
}

/// Returns the quaternion of a rotation, whose scalar part is not negative.
fn weld<S: Scalar>(rotation: &Matrix3<S>, factor: S) -> Rotation<S> {
    let Matrix3([[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]]) = *rotation;
    let square = (S::one() + xx + yy + zz) * S::from_f64(0.25);
    let least = S::from_f64(LEAST_COSINE * LEAST_COSINE);
    let scalar = at_least(square, least).sqrt();
    let vector = Vector3([zy - yz, xz - zx, yx - xy]).scale((scalar * S::from_f64(4.0)).recip());
    Rotation::Weld { scalar, vector, factor }
}
