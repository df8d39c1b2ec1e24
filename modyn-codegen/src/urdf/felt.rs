//! Is there a joint that feels no inertia?
//!
//! Forward dynamics divides by the inertia that each joint feels when all joints behind it give
//! way: the pivot of the articulated-body elimination (Featherstone 1987). Where a pivot is
//! zero, the mass matrix is singular: a massless link at the end of a chain, but also a massless
//! link between two joints about one line. A massless link between joints about different lines
//! is fine. So the elimination is run here, with inertia alone, at fixed generic configurations: a
//! pivot that is zero in all of them is zero for the robot, not for the configuration. It is a
//! loop over the links, not over pairs, so a chain of 100,000 joints takes no time to speak of.

use modyn_runtime::{
    joint::JointType,
    model::{Inertial, Link},
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

/// The joints, as indices, that feel no inertia in any configuration.
pub fn unfelt(links: &[Link]) -> Vec<usize> {
    let mut unfelt: Vec<usize> = (0..links.len()).collect();
    for configuration in 0..CONFIGURATIONS {
        // Nearly always done after the first.
        if unfelt.is_empty() {
            break;
        }
        let singular = singular_pivots(links, configuration);
        unfelt.retain(|&i| singular[i]);
    }
    unfelt
}

/// By joint: whether its pivot is zero in this configuration.
fn singular_pivots(links: &[Link], configuration: usize) -> Vec<bool> {
    let mut bodies: Vec<Felt> = links.iter().map(|link| Felt::alone(&link.inertial)).collect();
    let mut singular = vec![false; links.len()];
    for (i, link) in links.iter().enumerate().rev() {
        let turns = turns(link.joint.joint_type);
        let axis = if turns {
            Axis { angular: link.joint.axis, linear: [0.0; 3] }
        } else {
            Axis { angular: [0.0; 3], linear: link.joint.axis }
        };
        let Felt { articulated, before, rounding } = bodies[i];
        let (pivot, momentum) = articulated.pivot(&axis);
        let scale = if turns { rounding } else { trace(&before.linear) };
        singular[i] = pivot.abs() <= CANCELLED * before.pivot(&axis).0 + ROTATED * scale;

        let Some(parent) = link.parent else { continue };
        let pose = pose_at(link, coordinate(i, configuration));
        let mut behind = articulated;
        // Where the pivot is zero, so is the momentum: there is nothing to give way.
        if !singular[i] {
            behind.give_way(pivot, &momentum);
        }
        let parent = &mut bodies[parent];
        parent.articulated.add(&behind.seen_from(&pose));
        parent.before.add(&articulated.seen_from(&pose));
        let [x, y, z] = pose.translation;
        parent.rounding +=
            trace(&articulated.angular) + trace(&articulated.linear) * (x * x + y * y + z * z);
    }
    singular
}

/// Whether this code has the joint type; see [`turns`].
pub fn is_known(joint_type: JointType) -> bool {
    matches!(joint_type, JointType::Revolute | JointType::Continuous | JointType::Prismatic)
}

/// Whether joints of this type turn; the others slide.
fn turns(joint_type: JointType) -> bool {
    match joint_type {
        JointType::Revolute | JointType::Continuous => true,
        JointType::Prismatic => false,
        // The enum may grow; such a joint must not pass for one that turns.
        other => unreachable!("joints of type `{}` are refused before", other.name()),
    }
}

/// Irregular, between 0.3 and 6.3, and the same on every host.
fn coordinate(joint: usize, configuration: usize) -> f64 {
    #[allow(clippy::cast_precision_loss)] // Precise up to 2^52 joints.
    let n = (joint * CONFIGURATIONS + configuration) as f64;
    let golden = n * 0.618_033_988_749_895;
    0.3 + 6.0 * (golden - libm::floor(golden))
}

/// The link's pose in its parent at this coordinate.
fn pose_at(link: &Link, coordinate: f64) -> Pose<f64> {
    let axis = link.joint.axis;
    let motion = if turns(link.joint.joint_type) {
        Pose { rotation: turned(axis, coordinate), translation: [0.0; 3] }
    } else {
        Pose { translation: axis.map(|x| x * coordinate), ..Pose::identity() }
    };
    link.joint.origin.compose(&motion)
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
