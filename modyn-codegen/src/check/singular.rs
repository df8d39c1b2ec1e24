//! Finds joints that move no inertia: their pivot in the elimination of the mass matrix is zero.
//!
//! Forward dynamics divides by the inertia at each joint while all joints of its descendants are free: the pivot of the
//! articulated-body elimination (Featherstone 1987). If a pivot is zero, the mass matrix is singular. Examples are a
//! massless link at the end of a chain, and a massless link between two joints about the same line. A massless link
//! between joints about different lines is valid. The elimination is therefore run here, on inertias only, at fixed
//! generic configurations. A pivot that is zero at all of them is zero for the robot, not for the configuration. It is a
//! loop over the links, not over pairs, so a chain of 100,000 joints takes little time.
//!
//! A joint of several degrees of freedom is eliminated one unit motion at a time. A rotor is inertia at its own joint
//! only.
//!
//! A mimic joint is locked, since its motion is the leader's, and its inertia is added to the leader as a rotor. A leader is
//! therefore rejected only if neither it nor a mimic joint that follows it moves inertia. This is simpler than the mass
//! matrix of the coupled joints: motions that cancel exactly in the ratio of a mimic joint are not found.

use modyn_runtime::joint::{JointType, planar};
use modyn_runtime::model::{Inertial, Joint, Model};
use modyn_runtime::spatial::{
    ArticulatedInertia, Matrix3, Pose, Quaternion, RigidInertia, Symmetric3, Twist, Vector3,
};

type Vec3 = [f64; 3];

/// A pivot below this fraction of the terms that cancelled in it is rounding noise.
const CANCELLED: f64 = 1e-12;
/// A pivot below this fraction of the whole inertia is rounding noise of the rotations.
const ROTATED: f64 = 1e-14;
/// The number of configurations that are tried.
const CONFIGURATIONS: usize = 3;

/// Returns the joints, as indices, that move no inertia in any configuration; mimic joints are not among them.
pub fn singular_joints(model: &Model) -> Vec<usize> {
    let own = |i: &usize| model.mimic(*i).is_none();
    let mut joints: Vec<usize> = (0..model.links().len()).filter(own).collect();
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
        model.links().iter().map(|link| link.joint.dynamics.armature).collect();
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

/// Returns, for each joint, the smallest of its pivots in this configuration, with the rotor's inertia; zero for rounding
/// noise.
fn least_pivots(model: &Model, configuration: usize, rotors: &[f64]) -> Vec<f64> {
    let links = model.links();
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
                // Where the pivot is zero, so is the momentum: there is nothing to eliminate. The remaining inertia along
                // the axis is rounding noise, which the terms that cancelled reveal.
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

/// Returns the motion to eliminate next: the one with the largest pivot, which keeps most digits. The order is free.
fn largest_pivot(motions: &[Twist<f64>], pivot: impl Fn(&Twist<f64>) -> f64) -> Option<usize> {
    let clear = |&k: &usize| pivot(&motions[k]).abs();
    (0..motions.len()).max_by(|a, b| clear(a).total_cmp(&clear(b)))
}

/// Returns the unit motions that a joint allows its link, in the link's axes, and the link's pose in the joint's frame at
/// these coordinates. Only the span of the motions counts, so those of a universal or planar joint may be in any
/// intermediate frame of the joint.
fn motions(joint: &Joint, q: &[f64; 6]) -> (Vec<Twist<f64>>, Pose<f64>) {
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
        // The enum may grow; a new type must not be treated as fixed.
        other => unreachable!("joints of type `{}` are not known here", other.name()),
    }
}

/// The axes of a frame.
const UNITS: [Vec3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Returns a rotation in general position.
fn any_rotation(angles: Vec3) -> [Vec3; 3] {
    let [x, y, z]: [Matrix3<f64>; 3] = core::array::from_fn(|i| rotation(UNITS[i], angles[i]));
    x.times(&y).times(&z).0
}

/// Returns coordinates in general position, one for each degree of freedom; a mimic joint's follow its ratio.
fn coordinates(model: &Model, link: usize, configuration: usize) -> [f64; 6] {
    let start = model.v_range(link).start;
    let own: [f64; 6] = core::array::from_fn(|k| coordinate(start + k, configuration));
    match model.mimic(link) {
        Some(mimic) => own.map(|q| mimic.multiplier * q + mimic.offset),
        None => own,
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
fn rotation(axis: Vec3, angle: f64) -> Matrix3<f64> {
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

/// The inertia of a link with its descendants during the elimination, and the magnitude of its rounding errors.
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
fn articulated(inertial: &Inertial) -> ArticulatedInertia<f64> {
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

#[cfg(test)]
mod tests {
    use modyn_runtime::model::{DEFAULT_GRAVITY, JointDynamics, Link, Mimic};

    use super::*;

    const TYPES: [JointType; 6] = [
        JointType::Revolute,
        JointType::Prismatic,
        JointType::Universal,
        JointType::Planar,
        JointType::Spherical,
        JointType::Floating,
    ];

    /// A generator of small pseudo-random numbers.
    struct PseudoRandom(u64);

    impl PseudoRandom {
        fn below(&mut self, n: usize) -> usize {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            usize::try_from(self.0 >> 40).unwrap_or(0) % n
        }

        /// Returns one of few directions, so that some axes are parallel.
        fn axis(&mut self) -> Vec3 {
            [UNITS[0], UNITS[1], UNITS[2], [0.6, 0.0, -0.8]][self.below(4)]
        }

        fn link(&mut self, i: usize) -> Link {
            let kinds = [6, 3, 3][self.below(3)];
            let joint_type = TYPES[self.below(kinds)];
            let axis = self.axis();
            let mut joint = Joint::new(format!("j{i}"), joint_type, axis, Pose::identity());
            joint.second_axis = if axis == UNITS[1] { UNITS[2] } else { UNITS[1] };
            if self.below(2) == 0 {
                joint.origin.rotation = rotation(self.axis(), 0.7).0;
            }
            if self.below(2) == 0 {
                joint.origin.translation = [0.3, -0.2, 0.5];
            }
            if self.below(8) == 0 {
                joint.dynamics = JointDynamics { armature: 0.1, ..JointDynamics::default() };
            }
            let inertial = match self.below(4) {
                0 => Inertial { mass: 1.0, center_of_mass: [0.2, 0.3, 0.4], inertia: [0.0; 6] },
                1 => Inertial {
                    mass: 2.0,
                    center_of_mass: [0.1, 0.0, 0.0],
                    inertia: [0.3, 0.0, 0.1, 0.4, 0.0, 0.5],
                },
                _ => Inertial::default(),
            };
            let parent = i.checked_sub(1);
            Link { name: format!("l{i}"), parent, joint, inertial }
        }

        /// Returns a chain of up to four links.
        fn model(&mut self) -> Model {
            let links = (0..=self.below(4)).map(|i| self.link(i)).collect();
            Model::new("r", DEFAULT_GRAVITY, links, Vec::new()).expect("valid")
        }
    }

    /// Returns the mass matrix of a chain, from the bodies' Jacobians.
    fn mass_matrix(model: &Model, configuration: usize) -> Vec<Vec<f64>> {
        let mut matrix = vec![vec![0.0; model.nv()]; model.nv()];
        // The unit motions of all joints so far, in the link's frame.
        let mut jacobian: Vec<Twist<f64>> = Vec::new();
        for (i, link) in model.links().iter().enumerate() {
            let (own, pose) = motions(&link.joint, &coordinates(model, i, configuration));
            let pose = link.joint.origin.compose(&pose);
            let back = Matrix3(pose.rotation).transposed();
            for Twist { angular, linear } in &mut jacobian {
                let lever = angular.cross(Vector3(pose.translation));
                (*angular, *linear) = (back.mul_vector(*angular), back.mul_vector(*linear + lever));
            }
            let known = jacobian.len();
            jacobian.extend(own);
            for (k, row) in matrix.iter_mut().enumerate().take(jacobian.len()).skip(known) {
                row[k] += link.joint.dynamics.armature;
            }
            let rigid = articulated(&link.inertial);
            for (j, axis) in jacobian.iter().enumerate() {
                let momentum = rigid.times(axis);
                for (k, other) in jacobian.iter().enumerate() {
                    matrix[j][k] +=
                        momentum.moment.dot(other.angular) + momentum.force.dot(other.linear);
                }
            }
        }
        matrix
    }

    /// Returns the pivots of an elimination that takes the largest pivot next.
    fn pivots(mut m: Vec<Vec<f64>>) -> Vec<f64> {
        let mut left: Vec<usize> = (0..m.len()).collect();
        let mut pivots = Vec::new();
        while let Some(at) =
            (0..left.len()).max_by(|&a, &b| m[left[a]][left[a]].total_cmp(&m[left[b]][left[b]]))
        {
            let p = left.swap_remove(at);
            pivots.push(m[p][p]);
            if m[p][p] < 1e-13 {
                break;
            }
            for &i in &left {
                for &j in &left {
                    m[i][j] -= m[i][p] * m[p][j] / m[p][p];
                }
            }
        }
        pivots
    }

    #[test]
    fn a_joint_is_singular_exactly_where_the_mass_matrix_is_singular() {
        let mut dice = PseudoRandom(7);
        let mut count = [0; 2];
        for _ in 0..10_000 {
            let model = dice.model();
            let pivots: Vec<f64> =
                (0..CONFIGURATIONS).flat_map(|c| pivots(mass_matrix(&model, c))).collect();
            // Nearly singular configurations decide nothing.
            if pivots.iter().any(|&pivot| pivot > 1e-13 && pivot < 1e-3) {
                continue;
            }
            let singular = pivots.iter().any(|&pivot| pivot <= 1e-13);
            let found = !singular_joints(&model).is_empty();
            assert!(singular || !found, "{:#?}", model.links());
            // Through several consecutive massless links, rounding errors can exceed their estimate.
            let massless = |link: &Link| link.inertial.mass == 0.0;
            if model.links().windows(2).all(|pair| !pair.iter().all(massless)) {
                assert_eq!(singular, found, "{:#?}", model.links());
                count[usize::from(singular)] += 1;
            }
        }
        assert!(count.iter().all(|&n| n > 500), "{count:?}");
    }

    /// The motions of a joint span the possible changes of its pose.
    #[test]
    fn motions_are_the_changes_of_the_pose() {
        for joint_type in TYPES {
            let mut joint = Joint::new("j", joint_type, [0.48, 0.6, -0.64], Pose::identity());
            joint.second_axis = [0.6, 0.0, 0.8];
            let q = [0.3, -0.8, 1.2, 0.4, 2.0, -0.6];
            let (allowed, pose) = motions(&joint, &q);
            assert_eq!(allowed.len(), joint_type.nv());
            let back = Matrix3(pose.rotation).transposed();
            for k in 0..joint_type.nv() {
                let at = |d: f64| {
                    let mut q = q;
                    q[k] += d;
                    motions(&joint, &q).1
                };
                let (ahead, behind) = (at(1e-5), at(-1e-5));
                let rate = |a: f64, b: f64| (a - b) / 2e-5;
                let spin: [Vec3; 3] = core::array::from_fn(|i| {
                    core::array::from_fn(|j| rate(ahead.rotation[i][j], behind.rotation[i][j]))
                });
                let spin = back.times(&Matrix3(spin)).0;
                let speed =
                    core::array::from_fn(|i| rate(ahead.translation[i], behind.translation[i]));
                let linear = back.mul_vector(Vector3(speed)).0;
                let change = [spin[2][1], spin[0][2], spin[1][0], linear[0], linear[1], linear[2]];
                assert!(change.iter().any(|x| x.abs() > 0.1), "{joint_type:?}");
                let rest = left_over(&allowed, change);
                assert!(rest.iter().all(|x| x.abs() < 1e-8), "{joint_type:?}: {rest:?}");
            }
        }
    }

    /// Returns the component of a motion outside of the span of `allowed`.
    fn left_over(allowed: &[Twist<f64>], mut motion: [f64; 6]) -> [f64; 6] {
        let dot = |a: &[f64; 6], b: &[f64; 6]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut basis: Vec<[f64; 6]> = Vec::new();
        for mut next in allowed.iter().map(Twist::components) {
            for known in &basis {
                let part = dot(known, &next);
                next.iter_mut().zip(known).for_each(|(x, k)| *x -= part * k);
            }
            let length = libm::sqrt(dot(&next, &next));
            basis.push(next.map(|x| x / length));
        }
        for known in &basis {
            let part = dot(known, &motion);
            motion.iter_mut().zip(known).for_each(|(x, k)| *x -= part * k);
        }
        motion
    }

    #[test]
    fn a_leader_moves_the_inertia_of_its_followers() {
        let body = Inertial {
            mass: 1.0,
            center_of_mass: [0.1, 0.0, 0.0],
            inertia: [0.3, 0.0, 0.1, 0.4, 0.0, 0.5],
        };
        let link = |i: usize, inertial, mimic: Option<Mimic>| {
            let mut joint = Joint::new(format!("j{i}"), TYPES[0], UNITS[2], Pose::identity());
            joint.mimic = mimic;
            Link { name: format!("l{i}"), parent: None, joint, inertial }
        };
        let singular = |inertials: [Inertial; 2], multiplier| {
            let mimic = Mimic { leader: 0, multiplier, offset: 0.0 };
            let links = vec![link(0, inertials[0], None), link(1, inertials[1], Some(mimic))];
            singular_joints(&Model::new("r", DEFAULT_GRAVITY, links, Vec::new()).expect("valid"))
        };
        let none = Inertial::default();
        assert_eq!(singular([body, none], 1.0), []);
        assert_eq!(singular([none, body], -2.0), []);
        assert_eq!(singular([none, body], 0.0), [0]);
        assert_eq!(singular([none, none], 1.0), [0]);

        // A massless link before a joint about the same line: a mimic joint does not move without its leader.
        let mimic = Mimic { leader: 1, multiplier: 0.5, offset: 0.0 };
        for (follows, expected) in [(None, vec![0]), (Some(mimic), vec![])] {
            let mut links = vec![link(0, none, None), link(1, body, None), link(2, body, follows)];
            links[1].parent = Some(0);
            let model = Model::new("r", DEFAULT_GRAVITY, links, Vec::new()).expect("valid");
            assert_eq!(singular_joints(&model), expected);
        }
    }
}
