//! Is there a joint that feels no inertia?
//!
//! Forward dynamics divides by the inertia that each joint feels when all joints behind it give
//! way: the pivot of the articulated-body elimination (Featherstone 1987). Where a pivot is
//! zero, the mass matrix is singular: a massless link at the end of a chain, but also a massless
//! link between two joints about one line. A massless link between joints about different lines
//! is fine. So the elimination is run here, with inertia alone, at fixed generic configurations: a
//! pivot that is zero in all of them is zero for the robot, not for the configuration. It is a
//! loop over the links, not over pairs, so a chain of 100,000 joints takes no time to speak of.
//!
//! A joint of several degrees of freedom is eliminated one unit motion after another on its body.
//! A rotor is inertia that its joint alone feels.
//!
//! A joint that follows another one is held, since its motion is the leader's, and what it would
//! feel by itself is a rotor to the leader. So a leader is refused only if neither it nor any joint
//! that follows it feels anything. That is simpler than the mass matrix of the coupled joints: motions
//! that would cancel in just the ratio of a mimic go unseen.

use modyn_runtime::{
    joint::{JointType, planar},
    model::{Inertial, Joint, Model},
    spatial::Pose,
};

type Vec3 = [f64; 3];
type Mat3 = [Vec3; 3];

/// A pivot below this part of the terms that cancelled in it is rounding.
const CANCELLED: f64 = 1e-12;
/// A pivot below this part of the whole inertia is rounding of the rotations.
const ROTATED: f64 = 1e-14;
/// How many configurations are tried.
const CONFIGURATIONS: usize = 3;

/// What is wrong with a joint that carries this link and feels no inertia.
pub fn message(link: &str) -> String {
    format!(
        "nothing that it moves has inertia that it alone would feel (it carries link `{link}`), \
         so its acceleration is undefined"
    )
}

/// What to do about it.
pub const HELP: &str =
    "give the link a mass (and, if it turns, a rotational inertia), or make the joint `fixed`";

/// The same for a base that floats.
pub const BASE_MESSAGE: &str = "the base floats, but nothing that it moves has inertia that it alone would feel, so its \
     acceleration is undefined";

/// What to do about it.
pub const BASE_HELP: &str = "give the link, or one that is fixed to it, a mass and a rotational \
                             inertia, or let the base be fixed";

/// The joints, as indices, that feel no inertia in any configuration; of those that move by themselves.
pub fn unfelt(model: &Model) -> Vec<usize> {
    let own = |i: &usize| model.mimic(*i).is_none();
    let mut unfelt: Vec<usize> = (0..model.links().len()).filter(own).collect();
    for configuration in 0..CONFIGURATIONS {
        // Nearly always done after the first.
        if unfelt.is_empty() {
            break;
        }
        let singular = singular_pivots(model, configuration);
        unfelt.retain(|&i| singular[i]);
    }
    unfelt
}

/// By joint: whether one of its pivots is zero in this configuration.
fn singular_pivots(model: &Model, configuration: usize) -> Vec<bool> {
    let mut rotors: Vec<f64> = model.links().iter().map(|link| link.joint.drive.armature).collect();
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

/// By joint: the smallest of its pivots in this configuration, with the rotor's inertia; zero for
/// what is rounding.
fn least_pivots(model: &Model, configuration: usize, rotors: &[f64]) -> Vec<f64> {
    let links = model.links();
    let mut bodies: Vec<Felt> = links.iter().map(|link| Felt::alone(&link.inertial)).collect();
    let mut least = vec![f64::INFINITY; links.len()];
    for (i, link) in links.iter().enumerate().rev() {
        let (mut motions, pose) = motions(&link.joint, &coordinates(model, i, configuration));
        let body = bodies[i];
        let mut behind = body.articulated;
        let mut held = body.articulated;
        while let Some(k) = clearest(&motions, |axis| behind.pivot(axis).0 / body.rounding(axis)) {
            let axis = motions.swap_remove(k);
            let (mut pivot, momentum) = behind.pivot(&axis);
            if pivot.abs() > body.rounding(&axis) {
                pivot += rotors[i];
                behind.give_way(pivot, &momentum);
            } else {
                // Where the pivot is zero, so is the momentum: there is nothing to give way. What is
                // left there is rounding, and known as such by what it is left of.
                pivot = rotors[i];
                held = body.before;
            }
            least[i] = least[i].min(pivot.abs());
        }
        if model.mimic(i).is_some() {
            behind = body.articulated;
        }
        let Some(parent) = link.parent else { continue };
        let pose = link.joint.origin.compose(&pose);
        let parent = &mut bodies[parent];
        parent.articulated.add(&behind.seen_from(&pose));
        parent.before.add(&held.seen_from(&pose));
        let [x, y, z] = pose.translation;
        parent.rounding += trace(&held.angular) + trace(&held.linear) * (x * x + y * y + z * z);
    }
    least
}

/// The motion to be eliminated next: the order is free, and the clearest pivot keeps most digits.
fn clearest(motions: &[Axis], pivot: impl Fn(&Axis) -> f64) -> Option<usize> {
    let clear = |&k: &usize| pivot(&motions[k]).abs();
    (0..motions.len()).max_by(|a, b| clear(a).total_cmp(&clear(b)))
}

/// The unit motions that a joint allows its link, in the link's axes, and the link's pose in the
/// joint's frame at these coordinates. What a set of motions spans is all that counts, so those of a
/// universal or planar joint may be seen from any frame that the joint leads through.
fn motions(joint: &Joint, q: &[f64; 6]) -> (Vec<Axis>, Pose<f64>) {
    let axis = joint.axis;
    let turn = |rotation| Pose { rotation, translation: [0.0; 3] };
    let shift = |translation| Pose { translation, ..Pose::identity() };
    match joint.joint_type {
        JointType::Revolute | JointType::Continuous => {
            (vec![Axis::turn(axis)], turn(turned(axis, q[0])))
        }
        JointType::Prismatic => (vec![Axis::slide(axis)], shift(axis.map(|x| x * q[0]))),
        JointType::Universal => {
            let second = joint.second_axis;
            let behind = turned(second, q[1]);
            let first = apply(&transposed(&behind), axis);
            let pose = turn(product(&turned(axis, q[0]), &behind));
            (vec![Axis::turn(second), Axis::turn(first)], pose)
        }
        JointType::Planar => {
            // The plane stays when the link turns in it.
            let [x, y, normal] = transposed(&planar::plane(axis));
            let translation = core::array::from_fn(|i| x[i] * q[0] + y[i] * q[1]);
            let pose = Pose { rotation: turned(normal, q[2]), translation };
            (vec![Axis::turn(normal), Axis::slide(x), Axis::slide(y)], pose)
        }
        JointType::Spherical => (UNITS.map(Axis::turn).into(), turn(any_turn([q[0], q[1], q[2]]))),
        JointType::Floating => {
            let motions = UNITS.map(Axis::slide).into_iter().chain(UNITS.map(Axis::turn));
            let pose =
                Pose { rotation: any_turn([q[3], q[4], q[5]]), translation: [q[0], q[1], q[2]] };
            (motions.collect(), pose)
        }
        // The enum may grow; such a joint must not pass for one that is fixed.
        other => unreachable!("joints of type `{}` are not known here", other.name()),
    }
}

/// The axes of a frame.
const UNITS: [Vec3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A rotation of no special kind.
fn any_turn(angles: Vec3) -> Mat3 {
    let [x, y, z]: [Mat3; 3] = core::array::from_fn(|i| turned(UNITS[i], angles[i]));
    product(&product(&x, &y), &z)
}

/// Coordinates of no special kind, one for each degree of freedom; in the ratio of its mimic for a
/// joint that follows.
fn coordinates(model: &Model, link: usize, configuration: usize) -> [f64; 6] {
    let start = model.v_range(link).start;
    let own: [f64; 6] = core::array::from_fn(|k| coordinate(start + k, configuration));
    match model.mimic(link) {
        Some(mimic) => own.map(|q| mimic.multiplier * q + mimic.offset),
        None => own,
    }
}

/// Irregular, between 0.3 and 6.3, and the same on every host.
fn coordinate(freedom: usize, configuration: usize) -> f64 {
    #[allow(clippy::cast_precision_loss)] // Precise up to 2^52 of them.
    let n = (freedom * CONFIGURATIONS + configuration) as f64;
    let golden = n * 0.618_033_988_749_895;
    0.3 + 6.0 * (golden - libm::floor(golden))
}

/// Rodrigues' formula.
fn turned(axis: Vec3, angle: f64) -> Mat3 {
    let (sin, cos) = libm::sincos(angle);
    let mut rotation = cross(axis).map(|row| row.map(|x| x * sin));
    for i in 0..3 {
        for j in 0..3 {
            rotation[i][j] += axis[i] * axis[j] * (1.0 - cos);
        }
        rotation[i][i] += cos;
    }
    rotation
}

/// A unit motion.
struct Axis {
    angular: Vec3,
    linear: Vec3,
}

impl Axis {
    fn turn(angular: Vec3) -> Self {
        Self { angular, linear: [0.0; 3] }
    }

    fn slide(linear: Vec3) -> Self {
        Self { angular: [0.0; 3], linear }
    }
}

/// What a link and all behind it put up against being moved.
#[derive(Clone, Copy)]
struct Felt {
    /// With the joints behind giving way.
    articulated: Articulated,
    /// The same with the joints next to the link held: what cancelled in `articulated`.
    before: Articulated,
    /// The size of the terms that moments of inertia are made of.
    rounding: f64,
}

impl Felt {
    fn alone(inertial: &Inertial) -> Self {
        let rigid = Articulated::rigid(inertial);
        let [x, y, z] = inertial.center_of_mass;
        let rounding = trace(&rigid.angular) + inertial.mass.abs() * (x * x + y * y + z * z);
        Self { articulated: rigid, before: rigid, rounding }
    }

    /// A pivot along this motion that is not above this is rounding.
    fn rounding(&self, axis: &Axis) -> f64 {
        let turns = axis.linear == [0.0; 3];
        let scale = if turns { self.rounding } else { trace(&self.before.linear) };
        CANCELLED * self.before.pivot(axis).0 + ROTATED * scale
    }
}

/// The articulated inertia about the link's origin, `[angular, coupling; coupling^T, linear]`.
#[derive(Clone, Copy)]
struct Articulated {
    angular: Mat3,
    coupling: Mat3,
    linear: Mat3,
}

impl Articulated {
    fn rigid(inertial: &Inertial) -> Self {
        let Inertial { mass, center_of_mass: c, inertia: [xx, xy, xz, yy, yz, zz] } = *inertial;
        let lever = cross(c);
        let steiner = product(&lever, &transposed(&lever));
        let own = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        Self {
            angular: entries(|i, j| own[i][j] + mass * steiner[i][j]),
            coupling: lever.map(|row| row.map(|x| x * mass)),
            linear: entries(|i, j| if i == j { mass } else { 0.0 }),
        }
    }

    /// The inertia along a motion, and the momentum of that motion.
    fn pivot(&self, axis: &Axis) -> (f64, Axis) {
        let (angular, linear) = (axis.angular, axis.linear);
        let momentum = Axis {
            angular: sum(apply(&self.angular, angular), apply(&self.coupling, linear)),
            linear: sum(apply(&transposed(&self.coupling), angular), apply(&self.linear, linear)),
        };
        (dot(angular, momentum.angular) + dot(linear, momentum.linear), momentum)
    }

    /// Lets the joint go that has this pivot.
    fn give_way(&mut self, pivot: f64, momentum: &Axis) {
        let Axis { angular: n, linear: f } = momentum;
        for i in 0..3 {
            for j in 0..3 {
                self.angular[i][j] -= n[i] * n[j] / pivot;
                self.coupling[i][j] -= n[i] * f[j] / pivot;
                self.linear[i][j] -= f[i] * f[j] / pivot;
            }
        }
    }

    /// About the origin of the frame in which this one stands at `pose`.
    fn seen_from(&self, pose: &Pose<f64>) -> Self {
        let r = &pose.rotation;
        let turn = |block: &Mat3| product(&product(r, block), &transposed(r));
        let (angular, coupling, linear) =
            (turn(&self.angular), turn(&self.coupling), turn(&self.linear));
        let lever = cross(pose.translation);
        let moved = product(&lever, &linear);
        let (first, second) = (product(&coupling, &lever), product(&moved, &lever));
        Self {
            // The transpose of `coupling * lever` is `-lever * coupling^T`.
            angular: entries(|i, j| angular[i][j] - first[i][j] - first[j][i] - second[i][j]),
            coupling: entries(|i, j| coupling[i][j] + moved[i][j]),
            linear,
        }
    }

    fn add(&mut self, other: &Self) {
        for (own, other) in [
            (&mut self.angular, &other.angular),
            (&mut self.coupling, &other.coupling),
            (&mut self.linear, &other.linear),
        ] {
            *own = entries(|i, j| own[i][j] + other[i][j]);
        }
    }
}

fn entries(entry: impl Fn(usize, usize) -> f64) -> Mat3 {
    core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j)))
}

fn product(a: &Mat3, b: &Mat3) -> Mat3 {
    entries(|i, j| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j])
}

fn transposed(a: &Mat3) -> Mat3 {
    entries(|i, j| a[j][i])
}

fn apply(a: &Mat3, x: Vec3) -> Vec3 {
    a.map(|row| dot(row, x))
}

/// The matrix of `a x`.
fn cross([x, y, z]: Vec3) -> Mat3 {
    [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
}

fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sum(a: Vec3, b: Vec3) -> Vec3 {
    core::array::from_fn(|i| a[i] + b[i])
}

fn trace(a: &Mat3) -> f64 {
    a[0][0].abs() + a[1][1].abs() + a[2][2].abs()
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

    /// Small numbers that look random.
    struct Dice(u64);

    impl Dice {
        fn below(&mut self, n: usize) -> usize {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            usize::try_from(self.0 >> 40).unwrap_or(0) % n
        }

        /// One of few directions, so that some axes are parallel.
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
                joint.origin.rotation = turned(self.axis(), 0.7);
            }
            if self.below(2) == 0 {
                joint.origin.translation = [0.3, -0.2, 0.5];
            }
            if self.below(8) == 0 {
                joint.drive = JointDynamics { armature: 0.1, ..JointDynamics::default() };
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

        /// A chain of up to four links.
        fn model(&mut self) -> Model {
            let links = (0..=self.below(4)).map(|i| self.link(i)).collect();
            Model::new("r", DEFAULT_GRAVITY, links, Vec::new()).expect("valid")
        }
    }

    /// The mass matrix of a chain, of the bodies' Jacobians.
    fn mass_matrix(model: &Model, configuration: usize) -> Vec<Vec<f64>> {
        let mut matrix = vec![vec![0.0; model.nv()]; model.nv()];
        // The unit motions of all joints so far, seen from the link.
        let mut jacobian: Vec<Axis> = Vec::new();
        for (i, link) in model.links().iter().enumerate() {
            let (own, pose) = motions(&link.joint, &coordinates(model, i, configuration));
            let pose = link.joint.origin.compose(&pose);
            let back = transposed(&pose.rotation);
            for Axis { angular, linear } in &mut jacobian {
                let lever = apply(&cross(*angular), pose.translation);
                (*angular, *linear) = (apply(&back, *angular), apply(&back, sum(*linear, lever)));
            }
            let known = jacobian.len();
            jacobian.extend(own);
            for (k, row) in matrix.iter_mut().enumerate().take(jacobian.len()).skip(known) {
                row[k] += link.joint.drive.armature;
            }
            let rigid = Articulated::rigid(&link.inertial);
            for (j, axis) in jacobian.iter().enumerate() {
                let (_, momentum) = rigid.pivot(axis);
                for (k, other) in jacobian.iter().enumerate() {
                    matrix[j][k] +=
                        dot(momentum.angular, other.angular) + dot(momentum.linear, other.linear);
                }
            }
        }
        matrix
    }

    /// Of elimination with the largest pivot next.
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
    fn a_joint_is_unfelt_exactly_where_the_mass_matrix_is_singular() {
        let mut dice = Dice(7);
        let mut count = [0; 2];
        for _ in 0..10_000 {
            let model = dice.model();
            let pivots: Vec<f64> =
                (0..CONFIGURATIONS).flat_map(|c| pivots(mass_matrix(&model, c))).collect();
            // Configurations that are nearly singular tell nothing.
            if pivots.iter().any(|&pivot| pivot > 1e-13 && pivot < 1e-3) {
                continue;
            }
            let singular = pivots.iter().any(|&pivot| pivot <= 1e-13);
            let found = !unfelt(&model).is_empty();
            assert!(singular || !found, "{:#?}", model.links());
            // Through several massless links in a row, rounding can grow beyond what is known of it.
            let massless = |link: &Link| link.inertial.mass == 0.0;
            if model.links().windows(2).all(|pair| !pair.iter().all(massless)) {
                assert_eq!(singular, found, "{:#?}", model.links());
                count[usize::from(singular)] += 1;
            }
        }
        assert!(count.iter().all(|&n| n > 500), "{count:?}");
    }

    /// The motions of a joint span what its pose can change by.
    #[test]
    fn motions_are_the_changes_of_the_pose() {
        for joint_type in TYPES {
            let mut joint = Joint::new("j", joint_type, [0.48, 0.6, -0.64], Pose::identity());
            joint.second_axis = [0.6, 0.0, 0.8];
            let q = [0.3, -0.8, 1.2, 0.4, 2.0, -0.6];
            let (allowed, pose) = motions(&joint, &q);
            assert_eq!(allowed.len(), joint_type.nv());
            let back = transposed(&pose.rotation);
            for k in 0..joint_type.nv() {
                let at = |d: f64| {
                    let mut q = q;
                    q[k] += d;
                    motions(&joint, &q).1
                };
                let (ahead, behind) = (at(1e-5), at(-1e-5));
                let rate = |a: f64, b: f64| (a - b) / 2e-5;
                let turn = entries(|i, j| rate(ahead.rotation[i][j], behind.rotation[i][j]));
                let turn = product(&back, &turn);
                let speed =
                    core::array::from_fn(|i| rate(ahead.translation[i], behind.translation[i]));
                let linear = apply(&back, speed);
                let change = [turn[2][1], turn[0][2], turn[1][0], linear[0], linear[1], linear[2]];
                assert!(change.iter().any(|x| x.abs() > 0.1), "{joint_type:?}");
                let rest = left_over(&allowed, change);
                assert!(rest.iter().all(|x| x.abs() < 1e-8), "{joint_type:?}: {rest:?}");
            }
        }
    }

    /// What of a motion is none of these.
    fn left_over(allowed: &[Axis], mut motion: [f64; 6]) -> [f64; 6] {
        let dot = |a: &[f64; 6], b: &[f64; 6]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut basis: Vec<[f64; 6]> = Vec::new();
        for Axis { angular: [a, b, c], linear: [d, e, f] } in allowed {
            let mut next = [*a, *b, *c, *d, *e, *f];
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
    fn a_leader_feels_what_its_followers_feel() {
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
        let unfelt = |inertials: [Inertial; 2], multiplier| {
            let mimic = Mimic { leader: 0, multiplier, offset: 0.0 };
            let links = vec![link(0, inertials[0], None), link(1, inertials[1], Some(mimic))];
            unfelt(&Model::new("r", DEFAULT_GRAVITY, links, Vec::new()).expect("valid"))
        };
        let none = Inertial::default();
        assert_eq!(unfelt([body, none], 1.0), []);
        assert_eq!(unfelt([none, body], -2.0), []);
        assert_eq!(unfelt([none, body], 0.0), [0]);
        assert_eq!(unfelt([none, none], 1.0), [0]);

        // A massless link before a joint about the same line: that one does not give way alone if
        // it is followed.
        let mimic = Mimic { leader: 1, multiplier: 0.5, offset: 0.0 };
        for (follows, expected) in [(None, vec![0]), (Some(mimic), vec![])] {
            let mut links = vec![link(0, none, None), link(1, body, None), link(2, body, follows)];
            links[1].parent = Some(0);
            let model = Model::new("r", DEFAULT_GRAVITY, links, Vec::new()).expect("valid");
            assert_eq!(super::unfelt(&model), expected);
        }
    }
}
