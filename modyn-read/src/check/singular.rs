//! Finds joints that move no inertia: their pivot in the elimination of the mass matrix is zero.
//!
//! Forward dynamics divides by the inertia at each joint while all joints of its descendants are
//! free: the pivot of the articulated-body elimination (Featherstone 1987). If a pivot is zero, the
//! mass matrix is singular. Examples are a massless link at the end of a chain, and a massless link
//! between two joints about the same line. A massless link between joints about different lines is
//! valid. The elimination is therefore run here, on inertias only, at fixed generic configurations.
//! A pivot that is zero at all of them is zero for the robot, not for the configuration. It is a
//! loop over the links, not over pairs, so a chain of 100,000 joints takes little time.
//!
//! A joint of several degrees of freedom is eliminated one unit motion at a time. A rotor is
//! inertia at its own joint only.
//!
//! A mimic joint is locked, since its motion is the leader's, and its inertia is added to the
//! leader as a rotor. A leader is therefore rejected only if neither it nor a mimic joint that
//! follows it moves inertia. This is simpler than the mass matrix of the coupled joints: motions
//! that cancel exactly in the ratio of a mimic joint are not found.
//!
//! This elimination is the one equation that exists twice: it also tracks how much of each pivot
//! cancels, which tells a joint that moves no inertia from a joint that moves little.

use modyn_runtime::joint::{JointType, planar};
use modyn_runtime::model::{Inertial, Joint, Model};
use modyn_runtime::spatial::{
    ArticulatedInertia, Matrix3, Pose, Quaternion, RigidInertia, Symmetric3, Twist, Vector3,
};

/// Three numbers.
pub type Vec3 = [f64; 3];

/// A pivot below this fraction of the terms that cancelled in it is rounding noise.
const CANCELLED: f64 = 1e-12;
/// A pivot below this fraction of the whole inertia is rounding noise of the rotations.
const ROTATED: f64 = 1e-14;
/// The number of configurations that are tried.
pub const CONFIGURATIONS: usize = 3;

/// Returns the joints, as indices, that move no inertia in any configuration; mimic joints are not
/// among them.
///
/// A robot that was read has such joints only if their links have no inertia. It then has no
/// functions that [need inertia](modyn_runtime::quantities::Row::needs_inertia).
#[must_use]
pub fn singular_joints(model: &Model) -> Vec<usize> {
    let is_independent = |i: &usize| model.mimic(*i).is_none();
    let mut joints: Vec<usize> = (0..model.moving_links().len()).filter(is_independent).collect();
    for configuration in 0..CONFIGURATIONS {
        // Nearly always the case after the first configuration.
        if joints.is_empty() {
            break;
        }
        let singular = singular_pivots(model, configuration);
        joints.retain(|&i| singular[i]);
    }
    joints
}

/// Returns, for each joint, whether one of its pivots is zero in this configuration.
fn singular_pivots(model: &Model, configuration: usize) -> Vec<bool> {
    let mut rotors: Vec<f64> =
        model.moving_links().iter().map(|link| link.joint.dynamics.armature).collect();
    if model.has_mimics() {
        let pivots = least_pivots(model, configuration, &rotors);
        for (i, pivot) in pivots.into_iter().enumerate() {
            if let Some(mimic) = model.mimic(i) {
                rotors[mimic.leader] += mimic.multiplier * mimic.multiplier * pivot;
            }
        }
    }
    let pivots = least_pivots(model, configuration, &rotors);
    pivots.into_iter().map(|pivot| pivot == 0.0).collect()
}

/// Returns, for each joint, the smallest of its pivots in this configuration, with the rotor's
/// inertia; zero for rounding noise.
fn least_pivots(model: &Model, configuration: usize, rotors: &[f64]) -> Vec<f64> {
    let links = model.moving_links();
    let mut bodies: Vec<ArticulatedState> =
        links.iter().map(|link| ArticulatedState::of_body(&link.inertial)).collect();
    let mut least = vec![f64::INFINITY; links.len()];
    for (i, link) in links.iter().enumerate().rev() {
        let (mut motions, pose) = motions(&link.joint, &coordinates(model, i, configuration));
        let body = bodies[i];
        let mut subtree = body.articulated;
        let mut uncancelled = body.articulated;
        while let Some(k) =
            largest_pivot(&motions, |axis| pivot(&subtree, axis) / body.rounding(axis))
        {
            let axis = motions.swap_remove(k);
            let mut pivot = pivot(&subtree, &axis);
            if pivot.abs() > body.rounding(&axis) {
                pivot += rotors[i];
                subtree = eliminate(&subtree, &axis, pivot);
            } else {
                // Where the pivot is zero, so is the momentum: there is nothing to eliminate. The
                // remaining inertia along the axis is rounding noise, which the terms that
                // cancelled reveal.
                pivot = rotors[i];
                uncancelled = body.before;
            }
            least[i] = least[i].min(pivot.abs());
        }
        if model.mimic(i).is_some() {
            subtree = body.articulated;
        }
        let Some(parent) = link.parent else { continue };
        let pose = link.joint.origin.compose(&pose);
        let parent = &mut bodies[parent];
        parent.articulated = parent.articulated + to_parent(&subtree, &pose);
        parent.before = parent.before + to_parent(&uncancelled, &pose);
        let [x, y, z] = pose.translation;
        parent.rounding += trace(&uncancelled.rotational)
            + trace(&uncancelled.translational) * (x * x + y * y + z * z);
    }
    least
}

/// Returns the motion to eliminate next: the one with the largest pivot, which keeps most digits.
/// The order is free.
fn largest_pivot(motions: &[Twist<f64>], pivot: impl Fn(&Twist<f64>) -> f64) -> Option<usize> {
    let clear = |&k: &usize| pivot(&motions[k]).abs();
    (0..motions.len()).max_by(|a, b| clear(a).total_cmp(&clear(b)))
}

/// Returns the unit motions that a joint allows its link, in the link's axes, and the link's pose
/// in the joint's frame at these coordinates. Only the span of the motions counts, so the
/// motions of a universal or planar joint may be in any intermediate frame of the joint.
pub fn motions(joint: &Joint, q: &[f64; 6]) -> (Vec<Twist<f64>>, Pose<f64>) {
    let axis = joint.axis;
    let rotated = |rotation| Pose { rotation, translation: [0.0; 3] };
    let translated = |translation| Pose { translation, ..Pose::identity() };
    match joint.joint_type {
        JointType::Revolute | JointType::Continuous => {
            (vec![rotation_about(axis)], rotated(rotation(axis, q[0]).0))
        }
        JointType::Prismatic => (vec![translation_along(axis)], translated(axis.map(|x| x * q[0]))),
        JointType::Universal => {
            let second = joint.second_axis;
            let inner = rotation(second, q[1]);
            let first = inner.transposed().mul_vector(Vector3(axis)).0;
            let pose = rotated(rotation(axis, q[0]).times(&inner).0);
            (vec![rotation_about(second), rotation_about(first)], pose)
        }
        JointType::Planar => {
            // The plane is invariant when the link rotates in it.
            let [x, y, normal] = Matrix3(planar::plane(axis)).transposed().0;
            let translation = core::array::from_fn(|i| x[i] * q[0] + y[i] * q[1]);
            let pose = Pose { rotation: rotation(normal, q[2]).0, translation };
            (vec![rotation_about(normal), translation_along(x), translation_along(y)], pose)
        }
        JointType::Spherical => {
            (UNITS.map(rotation_about).into(), rotated(any_rotation([q[0], q[1], q[2]])))
        }
        JointType::Floating => {
            let motions = UNITS.map(translation_along).into_iter().chain(UNITS.map(rotation_about));
            let pose = Pose {
                rotation: any_rotation([q[3], q[4], q[5]]),
                translation: [q[0], q[1], q[2]],
            };
            (motions.collect(), pose)
        }
    }
}

/// The axes of a frame.
pub const UNITS: [Vec3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Returns a rotation in general position.
fn any_rotation(angles: Vec3) -> [Vec3; 3] {
    let [x, y, z]: [Matrix3<f64>; 3] = core::array::from_fn(|i| rotation(UNITS[i], angles[i]));
    x.times(&y).times(&z).0
}

/// Returns coordinates in general position, one for each degree of freedom; a mimic joint's follow
/// its ratio.
pub fn coordinates(model: &Model, link: usize, configuration: usize) -> [f64; 6] {
    let start = model.v_range(link).start;
    let coordinates: [f64; 6] = core::array::from_fn(|k| coordinate(start + k, configuration));
    match model.mimic(link) {
        Some(mimic) => coordinates.map(|q| mimic.multiplier * q + mimic.offset),
        None => coordinates,
    }
}

/// Returns an irregular number between 0.3 and 6.3, the same on every host.
fn coordinate(freedom: usize, configuration: usize) -> f64 {
    #[allow(clippy::cast_precision_loss)] // Precise up to 2^52 of them.
    let n = (freedom * CONFIGURATIONS + configuration) as f64;
    let golden = n * 0.618_033_988_749_895;
    0.3 + 6.0 * (golden - libm::floor(golden))
}

/// Returns the rotation by an angle about a unit vector.
pub fn rotation(axis: Vec3, angle: f64) -> Matrix3<f64> {
    Quaternion::exp(Vector3(axis).scale(angle)).matrix()
}

/// Returns the unit rotation about this axis through the origin.
fn rotation_about(axis: Vec3) -> Twist<f64> {
    Twist { angular: Vector3(axis), linear: Vector3::zero() }
}

/// Returns the unit translation along this axis.
fn translation_along(axis: Vec3) -> Twist<f64> {
    Twist { angular: Vector3::zero(), linear: Vector3(axis) }
}

/// The inertia of a link with its descendants during the elimination, and the magnitude of its
/// rounding errors.
#[derive(Clone, Copy)]
struct ArticulatedState {
    /// The inertia with the joints of all descendants eliminated.
    articulated: ArticulatedInertia<f64>,
    /// The inertia with the child joints locked: the terms that cancelled in `articulated`.
    before: ArticulatedInertia<f64>,
    /// The magnitude of the terms in moments of inertia.
    rounding: f64,
}

impl ArticulatedState {
    /// Returns the state of a rigid body without children.
    fn of_body(inertial: &Inertial) -> Self {
        let rigid = articulated(inertial);
        let [x, y, z] = inertial.center_of_mass;
        let rounding = trace(&rigid.rotational) + inertial.mass.abs() * (x * x + y * y + z * z);
        Self { articulated: rigid, before: rigid, rounding }
    }

    /// Returns the bound below which a pivot along this motion is rounding noise.
    fn rounding(&self, axis: &Twist<f64>) -> f64 {
        let rotates = axis.linear == Vector3::zero();
        let scale = if rotates { self.rounding } else { trace(&self.before.translational) };
        CANCELLED * pivot(&self.before, axis) + ROTATED * scale
    }
}

/// Returns the inertia of a rigid body about its link's origin.
pub fn articulated(inertial: &Inertial) -> ArticulatedInertia<f64> {
    let Inertial { mass, center_of_mass, inertia: [xx, xy, xz, yy, yz, zz] } = *inertial;
    let about_center = Symmetric3 { xx, xy, xz, yy, yz, zz };
    RigidInertia::new(mass, Vector3(center_of_mass), &about_center).articulated()
}

/// Returns the inertia along a motion.
fn pivot(inertia: &ArticulatedInertia<f64>, axis: &Twist<f64>) -> f64 {
    let momentum = inertia.times(axis);
    axis.angular.dot(momentum.moment) + axis.linear.dot(momentum.force)
}

/// Returns the inertia with the joint along `axis`, of this pivot, free to move.
fn eliminate(
    inertia: &ArticulatedInertia<f64>,
    axis: &Twist<f64>,
    pivot: f64,
) -> ArticulatedInertia<f64> {
    let momentum = inertia.times(axis).components();
    ArticulatedInertia::from_fn(|i, j| inertia.entry(i, j) - momentum[i] * momentum[j] / pivot)
}

/// Returns the inertia about the origin of the parent's frame, in which the link has this pose.
fn to_parent(inertia: &ArticulatedInertia<f64>, pose: &Pose<f64>) -> ArticulatedInertia<f64> {
    inertia.rotated(&Matrix3(pose.rotation)).shifted(Vector3(pose.translation))
}

fn trace(a: &Symmetric3<f64>) -> f64 {
    a.xx.abs() + a.yy.abs() + a.zz.abs()
}
