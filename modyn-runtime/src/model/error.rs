//! Defects of a model's parts.

use alloc::string::String;
use core::fmt;

use super::Actuation;

/// A defect of a model's parts, and the part that has it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ModelError {
    /// The joint, link or frame with the defect; the model's name for a defect of the whole model.
    pub name: String,
    /// The kind of defect.
    pub kind: ModelErrorKind,
}

/// The kinds of [`ModelError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ModelErrorKind {
    /// The model has no moving joint.
    NoJoint,
    /// Another link (or joint) has the same name.
    DuplicateName,
    /// The parent (or the link that a frame is fixed to) does not exist, or does not come before
    /// the child.
    Parent,
    /// The links are not in depth-first order.
    Order,
    /// A number is NaN or infinite.
    NotFinite,
    /// The axis is not of unit length.
    Axis,
    /// The two axes of a universal joint are parallel, or the second is not of unit length.
    SecondAxis,
    /// The rotation matrix is not orthonormal and right-handed.
    Rotation,
    /// A mimic joint or its leader has several coordinates, the leader does not exist, or mimic
    /// joints form a cycle.
    Mimic,
    /// Armature, damping or friction is negative.
    JointDynamics,
    /// A spring has a negative stiffness, or a reference that is no coordinates of its joint; or
    /// its joint does not exist or has another spring.
    Spring,
    /// There is not one factor of gravity compensation for each frame.
    GravityCompensation,
    /// The transition velocity of smooth friction is not positive.
    JointFriction,
    /// A loop constraint refers to a link that does not exist.
    LoopConstraintLink,
    /// A loop constraint connects two links that cannot move relative to each other.
    LoopConstraintEnds,
    /// A contact is on a link that does not exist.
    ContactLink,
    /// A contact is on a link that cannot move.
    ContactFixed,
    /// A shape that touches the ground has a size that is not above zero, or a setting out of its
    /// range.
    TouchingShape,
    /// The softness or the reference coordinate of a joint that does not exist, or that is out of its
    /// range.
    JointSoftness,
    /// The softness of a loop constraint that does not exist.
    LoopSoftness,
    /// A tendon has a negative friction, stiffness or damping, or a range whose lower end is above its
    /// upper end.
    Tendon,
    /// An actuator, a tendon or a coupling is on a joint or a tendon that does not exist, or on a
    /// joint with several degrees of freedom.
    Transmission,
    /// A range of a control, an activation or a force is empty, or a range of a tendon's forces does
    /// not contain zero.
    ActuatorRange,
    /// The time constant of an activation is negative.
    ActivationTime,
    /// The stall force or the no-load speed of a torque-speed line is not above zero.
    TorqueSpeedLine,
    /// The delays of the actuators up to this one have more than
    /// [`Actuation::MAX_DELAYS`](super::Actuation::MAX_DELAYS) steps together.
    Delay,
    /// A keyframe has another number of coordinates, velocities, controls or activations than the
    /// robot.
    KeyframeLength,
    /// A keyframe has a quaternion that is not of unit length.
    KeyframeQuaternion,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.kind {
            ModelErrorKind::NoJoint => "has no moving joint; a model needs at least one",
            ModelErrorKind::DuplicateName => "is a name used twice; names must be unique",
            ModelErrorKind::Parent => "has a parent that does not come before it in the model",
            ModelErrorKind::Order => "is out of order; links must be in depth-first order",
            ModelErrorKind::NotFinite => "has a number that is NaN or infinite",
            ModelErrorKind::Axis => "has an axis that is not of unit length",
            ModelErrorKind::SecondAxis => {
                "has a second axis that is not of unit length, or parallel to the first"
            }
            ModelErrorKind::Rotation => "has a rotation that is not orthonormal and right-handed",
            ModelErrorKind::Mimic => {
                "follows a joint that does not exist or follows it in turn, or one of the two has \
                 several coordinates"
            }
            ModelErrorKind::JointDynamics => "has a negative armature, damping or friction",
            ModelErrorKind::Spring => {
                "has a spring whose stiffness is negative or whose reference is no coordinates of the \
                 joint, or has several springs"
            }
            ModelErrorKind::GravityCompensation => {
                "has gravity compensation without one factor for each frame"
            }
            ModelErrorKind::JointFriction => {
                "has smooth friction whose transition velocity is not positive"
            }
            ModelErrorKind::LoopConstraintLink => "refers to a link that does not exist",
            ModelErrorKind::LoopConstraintEnds => {
                "connects two links that cannot move relative to each other"
            }
            ModelErrorKind::ContactLink => "is a contact on a link that does not exist",
            ModelErrorKind::ContactFixed => "is a contact on a link that cannot move",
            ModelErrorKind::TouchingShape => {
                "is a shape with a size that is not above zero, or with a setting out of its range"
            }
            ModelErrorKind::JointSoftness => {
                "has a softness or a reference coordinate out of its range, or is no such joint of the robot"
            }
            ModelErrorKind::LoopSoftness => {
                "has a softness, and is no loop constraint of the robot"
            }
            ModelErrorKind::Tendon => {
                "is a tendon with a negative friction, stiffness or damping, or with a range whose lower \
                 end is above its upper end"
            }
            ModelErrorKind::Transmission => {
                "is on a joint or tendon that does not exist, or on a joint with several degrees of \
                 freedom"
            }
            ModelErrorKind::ActuatorRange => {
                "has a range whose lower end is not below its upper end, or is a tendon with a range \
                 without zero"
            }
            ModelErrorKind::ActivationTime => "has an activation with a negative time constant",
            ModelErrorKind::TorqueSpeedLine => {
                "has a torque-speed line whose force or speed is not above zero"
            }
            ModelErrorKind::Delay => {
                return write!(
                    f,
                    "`{}` has a delay with which the delays of the actuators have more than {} steps \
                     together",
                    self.name,
                    Actuation::MAX_DELAYS
                );
            }
            ModelErrorKind::KeyframeLength => {
                "is a keyframe with another number of coordinates, velocities, controls or activations \
                 than the robot"
            }
            ModelErrorKind::KeyframeQuaternion => {
                "is a keyframe with a quaternion that is not of unit length"
            }
        };
        write!(f, "`{}` {what}", self.name)
    }
}

impl core::error::Error for ModelError {}
