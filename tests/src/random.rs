//! Random robots and states, which are the same for a seed on every host. The file calls no sine or cosine, since their
//! last digit depends on the system. It uses `modyn_runtime` only, so that a build script can include it.

use std::collections::BTreeSet;
use std::ops::Range;

use modyn_runtime::joint::JointType;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{
    DEFAULT_GRAVITY, Inertial, Joint, JointDynamics, JointFriction, JointSum, Limits, Link, Mimic,
    Model, ModuleTree, MovingLink, SoftConstraints, SoftCoupling, SoftTendon, Softness, Spring,
    TendonJoint, TendonSpring,
};
use modyn_runtime::spatial::Pose;
use modyn_runtime::{ContactSurface, StepSettings};

/// A sequence of numbers: SplitMix64 (Steele, Lea and Flood 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Returns the sequence of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns the next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number in `low..high`.
    #[allow(clippy::cast_precision_loss)]
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.bits() >> 11) as f64 / (1u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// Returns an index below `n`, which must not be 0.
    #[allow(clippy::cast_possible_truncation)]
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// Returns true with this probability.
    pub fn chance(&mut self, part: f64) -> bool {
        self.between(0.0, 1.0) < part
    }

    /// Returns a point of the unit ball, uniformly distributed and not at its centre, and its norm.
    fn in_ball<const N: usize>(&mut self) -> ([f64; N], f64) {
        loop {
            let point: [f64; N] = std::array::from_fn(|_| self.between(-1.0, 1.0));
            let square: f64 = point.iter().map(|x| x * x).sum();
            if square > 0.01 && square < 1.0 {
                return (point, square.sqrt());
            }
        }
    }

    fn unit<const N: usize>(&mut self) -> [f64; N] {
        let (point, length) = self.in_ball();
        point.map(|x| x / length)
    }

    /// Returns an axis of the frame, or an oblique one.
    fn axis(&mut self) -> [f64; 3] {
        if self.chance(0.5) {
            return self.unit();
        }
        let mut axis = [0.0; 3];
        axis[self.below(3)] = if self.chance(0.5) { 1.0 } else { -1.0 };
        axis
    }

    /// Returns no rotation, a rotation by right angles, one about an axis of the frame, or any rotation.
    fn rotation(&mut self) -> [[f64; 3]; 3] {
        match self.below(4) {
            0 => Pose::identity().rotation,
            1 => self.right_angles(),
            2 => {
                let [c, s] = self.unit();
                match self.below(3) {
                    0 => [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]],
                    1 => [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]],
                    _ => [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]],
                }
            }
            _ => self.any_rotation(),
        }
    }

    /// Returns the numbers of settings of steps: the default solver, and planes in general position near the origin.
    #[must_use]
    pub fn step_settings(&mut self, contacts: usize) -> Vec<f64> {
        let surfaces = (0..contacts).flat_map(|_| {
            let mut surface = ContactSurface::<f64>::GROUND;
            surface.plane.rotation = self.any_rotation();
            surface.plane.translation = [0.0; 3].map(|_| self.between(-0.1, 0.1));
            surface.radius = self.between(0.0, 0.3);
            surface.friction = self.between(0.1, 1.0);
            surface.torsional_friction = self.between(0.01, 0.1);
            surface.rolling_friction = self.between(0.01, 0.1);
            surface.margin = self.between(0.0, 0.3);
            surface.numbers()
        });
        let settings = StepSettings::<f64>::DEFAULT.numbers();
        settings.into_iter().chain(surfaces).collect()
    }

    /// Returns a rotation in general position.
    pub fn any_rotation(&mut self) -> [[f64; 3]; 3] {
        let [w, x, y, z] = self.unit();
        let (xx, yy, zz) = (2.0 * x * x, 2.0 * y * y, 2.0 * z * z);
        let (xy, xz, yz) = (2.0 * x * y, 2.0 * x * z, 2.0 * y * z);
        let (wx, wy, wz) = (2.0 * w * x, 2.0 * w * y, 2.0 * w * z);
        [
            [1.0 - yy - zz, xy - wz, xz + wy],
            [xy + wz, 1.0 - xx - zz, yz - wx],
            [xz - wy, yz + wx, 1.0 - xx - yy],
        ]
    }

    /// Returns a signed permutation with determinant 1.
    fn right_angles(&mut self) -> [[f64; 3]; 3] {
        let start = self.below(3);
        let swapped = self.chance(0.5);
        let sign = |negative| if negative { -1.0 } else { 1.0 };
        let (a, b) = (sign(self.chance(0.5)), sign(self.chance(0.5)));
        // An odd permutation changes the sign of the determinant.
        let c = a * b * sign(swapped);
        let (second, third) = if swapped { (2, 1) } else { (1, 2) };
        let mut rows = [[0.0; 3]; 3];
        rows[0][start] = a;
        rows[1][(start + second) % 3] = b;
        rows[2][(start + third) % 3] = c;
        rows
    }

    /// Returns no translation, a translation along one axis, or any translation.
    fn translation(&mut self) -> [f64; 3] {
        let mut translation = [0.0; 3];
        match self.below(4) {
            0 => {}
            1 => translation[self.below(3)] = self.between(-0.5, 0.5),
            _ => translation = std::array::from_fn(|_| self.between(-0.4, 0.4)),
        }
        translation
    }

    /// Returns a pose in general position.
    fn any_pose(&mut self) -> Pose<f64> {
        let translation = std::array::from_fn(|_| self.between(-0.4, 0.4));
        Pose { rotation: self.any_rotation(), translation }
    }

    fn pose(&mut self) -> Pose<f64> {
        Pose { rotation: self.rotation(), translation: self.translation() }
    }

    /// Returns the inertia of a few point masses, which is the inertia of a rigid body.
    pub fn inertial(&mut self) -> Inertial {
        let about = self.translation();
        let points: Vec<(f64, [f64; 3])> = (0..5 + self.below(4))
            .map(|_| {
                let (point, _) = self.in_ball::<3>();
                let mass = self.between(0.1, 0.8);
                (mass, std::array::from_fn(|k| about[k] + 0.3 * point[k]))
            })
            .collect();
        let mass: f64 = points.iter().map(|(m, _)| m).sum();
        let center_of_mass =
            std::array::from_fn(|k| points.iter().map(|(m, p)| m * p[k]).sum::<f64>() / mass);
        let mut inertia = [0.0; 6];
        for (m, p) in points {
            let [x, y, z]: [f64; 3] = std::array::from_fn(|k| p[k] - center_of_mass[k]);
            let one = [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y];
            inertia.iter_mut().zip(one).for_each(|(sum, x)| *sum += m * x);
        }
        Inertial { mass, center_of_mass, inertia }
    }

    /// Returns a joint with one coordinate.
    fn joint(&mut self, number: usize) -> Joint {
        let joint_type =
            [JointType::Revolute, JointType::Revolute, JointType::Continuous, JointType::Prismatic]
                [self.below(4)];
        let limits = self.chance(0.5).then(|| {
            let bounded = joint_type != JointType::Continuous;
            Limits {
                lower: bounded.then(|| self.between(-3.0, 0.0)),
                upper: bounded.then(|| self.between(0.0, 3.0)),
                velocity: Some(self.between(1.0, 10.0)),
                effort: Some(self.between(1.0, 100.0)),
            }
        });
        let (axis, origin) = (self.axis(), self.pose());
        Joint { limits, ..Joint::new(format!("joint{number}"), joint_type, axis, origin) }
    }

    /// Returns a joint of any type; on the world it is often a floating joint.
    fn any_joint(&mut self, number: usize, parent: Option<usize>) -> Joint {
        let several =
            [JointType::Universal, JointType::Planar, JointType::Spherical, JointType::Floating];
        let joint_type = if parent.is_none() && self.chance(0.3) {
            JointType::Floating
        } else if self.chance(0.5) {
            several[self.below(4)]
        } else {
            return self.joint(number);
        };
        let (axis, origin) = (self.axis(), self.pose());
        let name = format!("joint{number}");
        Joint {
            second_axis: self.across(axis, Self::axis),
            ..Joint::new(name, joint_type, axis, origin)
        }
    }

    /// Returns an axis at an angle to `axis`, often not a right angle.
    fn across(
        &mut self,
        axis: [f64; 3],
        mut another: impl FnMut(&mut Self) -> [f64; 3],
    ) -> [f64; 3] {
        loop {
            let other = another(self);
            let cosine: f64 = axis.iter().zip(other).map(|(a, b)| a * b).sum();
            if cosine.abs() < 0.8 {
                return other;
            }
        }
    }

    /// Returns a positive number below `high` with this probability, else 0.
    fn some(&mut self, part: f64, high: f64) -> f64 {
        if self.chance(part) { self.between(0.1 * high, high) } else { 0.0 }
    }
}

/// Returns a tree with this number of links (at least one). It is serial or has few or many branches, also on the world;
/// fixed frames are on links and on the world. Joints have one coordinate each, and no armature, damping or friction.
#[must_use]
pub fn tree(seed: u64, links: usize) -> Model {
    let parts = grow(seed, links, serial(seed), |random, i, _| random.joint(i));
    parts.model(format!("tree{seed}_{links}"))
}

/// Returns such a tree in general position: no axis is a coordinate axis, and no two frames are parallel.
#[must_use]
pub fn general_tree(seed: u64, links: usize) -> Model {
    let mut parts = grow(seed, links, serial(seed), |random, i, _| random.joint(i));
    parts.unalign(seed);
    parts.model(format!("general_tree{seed}_{links}"))
}

/// Returns a chain with this number of links (at least one).
#[must_use]
pub fn chain(seed: u64, links: usize) -> Model {
    let parts = grow(seed, links, 1.0, |random, i, _| random.joint(i));
    parts.model(format!("tree{seed}_{links}"))
}

/// Returns such a tree with joints of all types. Some joints follow others, in any direction through the tree; some have
/// armature, damping and smooth friction; fixed frames have inertias.
#[must_use]
pub fn zoo(seed: u64, links: usize) -> Model {
    let parts = grow(seed, links, serial(seed), Random::any_joint);
    furnished(parts, seed, format!("zoo{seed}_{links}"))
}

/// Returns such a tree with all joint types in general position.
#[must_use]
pub fn general_zoo(seed: u64, links: usize) -> Model {
    let mut parts = grow(seed, links, serial(seed), Random::any_joint);
    parts.unalign(seed);
    furnished(parts, seed, format!("general_zoo{seed}_{links}"))
}

/// Returns the robot with tendons and couplings of its joints with one degree of freedom: limits,
/// friction, springs and dampers, of all these joints and of one.
///
/// # Panics
///
/// If the model refuses the tendons and couplings, which is a fault of this function.
#[must_use]
pub fn with_tendons(model: Model, seed: u64) -> Model {
    let mut random = Random::new(seed);
    let links = model.moving_links().iter().enumerate();
    let single = links.filter(|(_, link)| link.joint.joint_type.nv() == 1).map(|(link, _)| link);
    let single: Vec<usize> = single.collect();
    let sum = |random: &mut Random, joints: &[usize]| {
        let term = |&link: &usize| TendonJoint { link, coefficient: random.between(-1.0, 1.0) };
        JointSum { joints: joints.iter().map(term).collect(), offset: 0.1 }
    };
    let softness = Softness::standard();
    let tendon = |(k, joints): (usize, &[usize])| SoftTendon {
        name: format!("tendon{k}"),
        length: sum(&mut random, joints),
        range: (!seed.is_multiple_of(3)).then_some([-0.2, 0.1]),
        margin: 0.2 * (k % 2) as f64,
        limit: softness,
        dry_friction: if seed.is_multiple_of(2) { 0.3 } else { 0.0 },
        friction: softness,
        spring: TendonSpring { stiffness: 5.0, rest: [-0.1, 0.1], damping: 0.4 },
    };
    let tendons = [&single[..], &single[..single.len().min(1)]].into_iter().enumerate();
    let tendons = tendons.map(tendon).collect();
    let coupling = SoftCoupling {
        name: "coupling".into(),
        sums: [&single[..single.len().min(2)], &single[single.len().min(1)..]]
            .map(|joints| sum(&mut random, joints)),
        polynomial: [0.1, 0.7, -0.3, 0.2, 0.4],
        softness,
    };
    let couplings = if seed.is_multiple_of(5) { Vec::new() } else { vec![coupling] };
    let soft = SoftConstraints { tendons, couplings, ..model.soft_constraints().clone() };
    model.with_soft_constraints(soft).expect("tendons of the robot's joints")
}

/// Returns [`tree`], or [`general_tree`] for every second seed.
#[must_use]
pub fn mixed_tree(seed: u64, links: usize) -> Model {
    if seed.is_multiple_of(2) { tree(seed, links) } else { general_tree(seed, links) }
}

/// Returns the seeds of a random test: those of the variable `MODYN_SEEDS`, as in `MODYN_SEEDS=1000..2000`, else the first
/// `few`.
///
/// # Panics
///
/// If the variable is no range of seeds.
#[must_use]
pub fn seeds(few: u64) -> Range<u64> {
    let Ok(given) = std::env::var("MODYN_SEEDS") else { return 0..few };
    let range = given.split_once("..").and_then(|(first, end)| {
        let (first, end) = (first.parse().ok()?, end.parse().ok()?);
        (first < end).then_some(first..end)
    });
    range.unwrap_or_else(|| panic!("MODYN_SEEDS={given}: expected a range such as 1000..2000"))
}

/// Returns [`zoo`], or [`general_zoo`] for every second seed.
#[must_use]
pub fn mixed_zoo(seed: u64, links: usize) -> Model {
    if seed.is_multiple_of(2) { zoo(seed, links) } else { general_zoo(seed, links) }
}

/// Returns a robot with one or two groups of 2 to 9 limbs of the same joint types, at most `joints` joints (at least two) in each group. The base
/// is fixed or floats; limbs are on it and on a trunk that moves. The limbs of a group are equal, mirrored, or differ by their
/// inertias or by all numbers; some are longer or shorter than the others.
#[must_use]
pub fn limbs(seed: u64, joints: usize) -> Model {
    let mut random = Random::new(seed ^ 0x004c_494d_4253);
    let floats = random.chance(0.5);
    let mut parts: Vec<LimbPart> = Vec::new();
    if floats {
        let joint = Joint::new("", JointType::Floating, [0.0, 0.0, 1.0], random.pose());
        parts.push(LimbPart { parent: None, joint, inertial: random.inertial() });
    }
    for _ in 0..random.below(3) {
        let (joint, inertial) = (random.joint(0), random.inertial());
        parts.push(LimbPart { parent: parts.len().checked_sub(1), joint, inertial });
    }
    // The bodies that limbs may be on: the base, and those of the trunk.
    let mut mounts: Vec<Option<usize>> = (0..parts.len()).map(Some).collect();
    if !floats {
        mounts.insert(0, None);
    }
    for _ in 0..=usize::from(random.chance(0.4)) {
        random.group(&mounts, joints, &mut parts);
    }
    let (count, base) = (
        parts.len(),
        Link {
            name: "base".into(),
            moving_link: None,
            pose: Pose::identity(),
            inertial: Inertial::default(),
        },
    );
    // A link comes before its descendants, and these before the next child of its parent.
    let (mut order, mut open) = (Vec::with_capacity(count), vec![None]);
    while let Some(parent) = open.pop() {
        order.extend(parent);
        let mut children: Vec<Option<usize>> =
            (0..count).filter(|&i| parts[i].parent == parent).map(Some).collect();
        if random.chance(0.5) {
            children.reverse();
        }
        open.extend(children);
    }
    let place = |part: usize| order.iter().position(|&other| other == part);
    let links = order.iter().enumerate().map(|(i, &part)| {
        let LimbPart { parent, joint, inertial } = parts[part].clone();
        let joint = Joint { name: format!("joint{i}"), ..joint };
        MovingLink { name: format!("link{i}"), parent: parent.and_then(place), joint, inertial }
    });
    let links: Vec<MovingLink> = links.collect();
    let frames = links.iter().enumerate().map(|(i, link)| Link {
        name: link.name.clone(),
        moving_link: Some(i),
        pose: Pose::identity(),
        inertial: link.inertial,
    });
    let frames = [base].into_iter().chain(frames).collect();
    let mut parts = Parts { gravity: DEFAULT_GRAVITY, links, frames };
    let friction = if random.chance(0.3) {
        parts.joint_dynamics(&mut random);
        JointFriction::Viscous
    } else {
        JointFriction::None
    };
    let model = parts.model(format!("limbs{seed}_{joints}"));
    let model = model.with_joint_friction(friction).expect("sound friction");
    let springs = springs(seed, 0.3, &model);
    model.with_springs(springs).expect("sound springs")
}

/// A link of a robot with limbs, before all links are in order.
#[derive(Clone)]
struct LimbPart {
    parent: Option<usize>,
    joint: Joint,
    inertial: Inertial,
}

impl LimbPart {
    /// Returns the part mirrored in the plane of x and z; its parent is the same.
    fn mirrored(&self) -> Self {
        let sign = |k: usize| if k == 1 { -1.0 } else { 1.0 };
        let mut part = self.clone();
        let Joint { joint_type, axis, second_axis, origin, .. } = &mut part.joint;
        // Axes of rotations are axial vectors.
        let axial = if *joint_type == JointType::Prismatic { 1.0 } else { -1.0 };
        for k in 0..3 {
            axis[k] *= axial * sign(k);
            second_axis[k] *= axial * sign(k);
            origin.translation[k] *= sign(k);
            part.inertial.center_of_mass[k] *= sign(k);
            for column in 0..3 {
                origin.rotation[k][column] *= sign(k) * sign(column);
            }
        }
        // The entries xy and yz.
        part.inertial.inertia[1] *= -1.0;
        part.inertial.inertia[4] *= -1.0;
        part
    }
}

impl Random {
    /// Adds a group of limbs on some of the bodies `mounts`, with at most `joints` joints.
    fn group(&mut self, mounts: &[Option<usize>], joints: usize, parts: &mut Vec<LimbPart>) {
        let limbs = 2 + self.below(8.min(joints - 1));
        let length = 1 + self.below(5.min(joints / limbs));
        let (is_forked, has_all_types) = (self.chance(0.2), self.chance(0.2));
        let pattern: Vec<LimbPart> = (0..length)
            .map(|i| {
                let joint = if has_all_types { self.any_joint(0, Some(0)) } else { self.joint(0) };
                // The place of the parent in the limb; without meaning for the first link.
                let parent = match i.saturating_sub(1) {
                    last if is_forked && last > 0 => self.below(last + 1),
                    last => last,
                };
                LimbPart { parent: Some(parent), joint, inertial: self.inertial() }
            })
            .collect();
        let one = mounts[self.below(mounts.len())];
        let (on_one, similarity) = (self.chance(0.6), self.below(5));
        for limb in 0..limbs {
            let mount = if on_one { one } else { mounts[self.below(mounts.len())] };
            let first = parts.len();
            let shorter = usize::from(length > 1 && similarity == 4 && self.chance(0.3));
            for (i, part) in pattern[..length - shorter].iter().enumerate() {
                let mut part =
                    if similarity == 1 && limb % 2 == 1 { part.mirrored() } else { part.clone() };
                part.parent = if i == 0 { mount } else { part.parent.map(|k| first + k) };
                if similarity > 1 {
                    part.inertial = self.inertial();
                }
                if similarity > 2 {
                    part.joint.axis = self.axis();
                    part.joint.second_axis = self.across(part.joint.axis, Self::axis);
                    part.joint.origin = self.pose();
                } else if i == 0 && similarity != 1 {
                    part.joint.origin = self.pose();
                }
                parts.push(part);
            }
        }
    }
}

/// Calls `check` with each of these models, named by its index. Expects that together they have joints of at least seven types,
/// and three or more of each: mimic joints, rotors, and joints with friction.
///
/// # Panics
/// If the models have less.
pub fn for_all_kinds(models: impl Iterator<Item = Model>, mut check: impl FnMut(u64, &Model)) {
    let (mut followers, mut types, mut driven, mut resisted) = (0, BTreeSet::new(), 0, 0);
    let (mut sprung, mut compensated) = (BTreeSet::new(), 0);
    for (index, model) in (0..).zip(models) {
        followers += model.moving_links().iter().filter(|link| link.joint.mimic.is_some()).count();
        types.extend(model.moving_links().iter().map(|link| link.joint.joint_type.name()));
        let dofs = Mechanism::new(&model).dofs;
        driven += dofs.iter().filter(|dof| dof.armature.is_some()).count();
        resisted += dofs.iter().filter(|dof| dof.friction.is_some()).count();
        let springs = model.springs().iter().map(|spring| &model.moving_links()[spring.link].joint);
        sprung.extend(springs.map(|joint| joint.joint_type.name()));
        compensated += usize::from(!model.gravity_compensation().is_empty());
        check(index, &model);
    }
    assert!(compensated > 0, "gravity compensation");
    assert!(sprung.len() >= 6, "springs at {sprung:?}");
    assert!(followers >= 3 && types.len() >= 7, "{followers} mimic joints, {types:?}");
    assert!(driven >= 3 && resisted >= 3, "{driven} rotors, {resisted} with friction");
}

/// Returns the model of these parts with mimic joints, joint dynamics, friction, and inertias of fixed frames.
fn furnished(mut parts: Parts, seed: u64, name: String) -> Model {
    let mut random = Random::new(seed ^ 0x005a_4f4f);
    parts.weigh_frames(&mut random);
    if random.chance(0.5) {
        parts.follow(&mut random);
    }
    if random.chance(0.7) {
        parts.joint_dynamics(&mut random);
    }
    let friction = match random.below(3) {
        0 => JointFriction::None,
        1 => JointFriction::Viscous,
        _ => JointFriction::Smooth(random.between(0.05, 0.5)),
    };
    let model = parts.model(name);
    let model = model.with_joint_friction(friction).expect("sound friction");
    let springs = springs(seed, 0.5, &model);
    let model = model.with_springs(springs).expect("sound springs");
    let factors = gravity_compensation(seed, &model);
    model.with_gravity_compensation(factors).expect("a factor for each frame")
}

/// Returns factors of gravity compensation for some links of some robots.
fn gravity_compensation(seed: u64, model: &Model) -> Vec<f64> {
    let mut random = Random::new(seed ^ 0x4752_4156);
    let any = random.chance(0.3);
    let frames = model.links().iter().filter(|_| any);
    frames.map(|_| if random.chance(0.5) { random.between(-0.5, 1.5) } else { 0.0 }).collect()
}

/// Returns whether all springs of ball and floating joints are at least a tenth of a radian away from half a turn, where
/// their forces jump.
#[must_use]
pub fn springs_are_smooth(model: &Model, q: &[f64]) -> bool {
    model.springs().iter().all(|Spring { link, reference, .. }| {
        let first = match model.moving_links()[*link].joint.joint_type {
            JointType::Spherical => 0,
            JointType::Floating => 3,
            _ => return true,
        };
        let own = &q[model.q_range(*link)];
        let products = (first..first + 4).map(|k| own[k] * reference[k]);
        products.sum::<f64>().abs() > 0.05
    })
}

/// Returns springs at some joints; with this probability, there are any.
fn springs(seed: u64, part: f64, model: &Model) -> Vec<Spring> {
    let mut random = Random::new(seed ^ 0x5350_5249_4e47);
    if !random.chance(part) {
        return Vec::new();
    }
    let mut springs = Vec::new();
    for (link, MovingLink { joint, .. }) in model.moving_links().iter().enumerate() {
        if random.chance(0.4) {
            continue;
        }
        let nq = joint.joint_type.nq();
        let mut reference: Vec<f64> = (0..nq).map(|_| random.between(-1.0, 1.0)).collect();
        match joint.joint_type {
            JointType::Spherical => reference.copy_from_slice(&random.unit::<4>()),
            JointType::Floating => reference[3..].copy_from_slice(&random.unit::<4>()),
            _ => {}
        }
        springs.push(Spring { link, stiffness: random.between(0.5, 20.0), reference });
    }
    springs
}

/// Returns the probability that a link's parent is the link before it.
fn serial(seed: u64) -> f64 {
    [1.0, 0.8, 0.4][Random::new(!seed).below(3)]
}

/// The parts of a model.
struct Parts {
    gravity: [f64; 3],
    links: Vec<MovingLink>,
    frames: Vec<Link>,
}

/// Returns a tree in which a link's parent is the link before it with this probability; `joint` makes the joints.
fn grow(
    seed: u64,
    count: usize,
    serial: f64,
    mut joint: impl FnMut(&mut Random, usize, Option<usize>) -> Joint,
) -> Parts {
    let mut random = Random::new(seed);
    let gravity = match random.below(4) {
        0 => std::array::from_fn(|_| random.between(-10.0, 10.0)),
        _ => DEFAULT_GRAVITY,
    };
    let base = Link {
        name: "base".into(),
        moving_link: None,
        pose: Pose::identity(),
        inertial: Inertial::default(),
    };
    let (mut links, mut frames) = (Vec::with_capacity(count), vec![base]);
    // From the world to the link before; the next link is connected to one of them.
    let mut path: Vec<usize> = Vec::new();
    for i in 0..count {
        if !random.chance(serial) {
            path.truncate(random.below(path.len() + 1));
        }
        let parent = path.last().copied();
        path.push(i);
        let name = format!("link{i}");
        let joint = joint(&mut random, i, parent);
        let inertial = random.inertial();
        links.push(MovingLink { name: name.clone(), parent, joint, inertial });
        let inertial = links[i].inertial;
        frames.push(Link { name, moving_link: Some(i), pose: Pose::identity(), inertial });
        if random.chance(0.2) {
            let link = random.chance(0.8).then_some(i);
            frames.push(Link {
                name: format!("fixed{i}"),
                moving_link: link,
                pose: random.pose(),
                inertial: Inertial::default(),
            });
        }
    }
    Parts { gravity, links, frames }
}

impl Parts {
    fn model(self, name: String) -> Model {
        let Self { gravity, links, frames } = self;
        Model::new(&*name, gravity, links, frames)
            .unwrap_or_else(|errors| panic!("{name}: {errors:?}"))
    }

    /// Replaces the axes and poses of joints and fixed frames by ones in general position.
    fn unalign(&mut self, seed: u64) {
        let mut random = Random::new(seed ^ 0x0047_454e);
        for MovingLink { joint, .. } in &mut self.links {
            joint.axis = random.unit();
            joint.second_axis = random.across(joint.axis, Random::unit);
            joint.origin = random.any_pose();
        }
        for frame in self.frames.iter_mut().filter(|frame| frame.name.starts_with("fixed")) {
            frame.pose = random.any_pose();
        }
    }

    /// Gives inertias to fixed frames, which are then part of their links.
    fn weigh_frames(&mut self, random: &mut Random) {
        for frame in self.frames.iter_mut().filter(|frame| frame.name.starts_with("fixed")) {
            frame.inertial = random.inertial();
            if let Some(link) = frame.moving_link {
                let own = frame.inertial.transformed(&frame.pose);
                self.links[link].inertial = self.links[link].inertial.merged(&own);
            }
        }
    }

    /// Makes some joints with one coordinate follow others.
    fn follow(&mut self, random: &mut Random) {
        let single = |link: &MovingLink| link.joint.joint_type.nq() == 1;
        let all = self.links.iter().enumerate();
        let candidates: Vec<usize> = all.filter(|(_, link)| single(link)).map(|(i, _)| i).collect();
        for &i in &candidates {
            let leader = candidates[random.below(candidates.len())];
            let sign = if random.chance(0.5) { 1.0 } else { -1.0 };
            let multiplier = sign * random.between(0.3, 1.5);
            let offset = if random.chance(0.5) { random.between(-1.0, 1.0) } else { 0.0 };
            if random.chance(0.6) && !self.follows(leader, i) {
                self.links[i].joint.mimic = Some(Mimic { leader, multiplier, offset });
            }
        }
    }

    /// Returns whether joint `i` is joint `leader` or follows it.
    fn follows(&self, mut i: usize, leader: usize) -> bool {
        while i != leader {
            match &self.links[i].joint.mimic {
                Some(mimic) => i = mimic.leader,
                None => return false,
            }
        }
        true
    }

    /// Gives armature, damping and friction to joints.
    fn joint_dynamics(&mut self, random: &mut Random) {
        for link in &mut self.links {
            link.joint.dynamics = JointDynamics {
                armature: random.some(0.4, 0.5),
                damping: random.some(0.5, 1.0),
                friction: random.some(0.5, 2.0),
            };
        }
    }
}

/// Returns a random partition into modules: the maximal chains, divided at some links.
#[must_use]
pub fn modules(seed: u64, model: &Model) -> ModuleTree {
    let mut random = Random::new(seed);
    let part = random.between(0.0, 1.0);
    let mut list: Vec<Vec<&str>> = Vec::new();
    for chain in ModuleTree::chains(model).modules() {
        for i in chain.links.clone() {
            if i == chain.links.start || random.chance(part) {
                list.push(Vec::new());
            }
            if let Some(module) = list.last_mut() {
                module.push(&model.moving_links()[i].name);
            }
        }
    }
    ModuleTree::from_names(model, &list).unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// Positions, velocities, accelerations and torques.
#[derive(Clone, Debug)]
pub struct State {
    /// Positions, rad or m.
    pub q: Vec<f64>,
    /// Velocities, rad/s or m/s.
    pub qd: Vec<f64>,
    /// Accelerations, rad/s^2 or m/s^2.
    pub qdd: Vec<f64>,
    /// Torques and forces, independent of these accelerations.
    pub tau: Vec<f64>,
}

/// Returns a random state of `model`; its quaternions have unit length.
#[must_use]
pub fn state(seed: u64, model: &Model) -> State {
    let mut random = Random::new(seed ^ 0x5354_4154_4553);
    let mut vector = |length: usize, size: f64| -> Vec<f64> {
        (0..length).map(|_| random.between(-size, size)).collect()
    };
    let (nq, nv) = (model.nq(), model.nv());
    let mut q = vector(nq, 3.0);
    normalize_configuration(model, &mut q);
    State { q, qd: vector(nv, 1.5), qdd: vector(nv, 3.0), tau: vector(nv, 10.0) }
}

/// Scales the quaternions in `q` to unit length.
pub fn normalize_configuration(model: &Model, q: &mut [f64]) {
    for (i, link) in model.moving_links().iter().enumerate() {
        let range = model.q_range(i);
        let quaternion = match link.joint.joint_type {
            JointType::Spherical => &mut q[range],
            JointType::Floating => &mut q[range.start + 3..range.end],
            _ => continue,
        };
        let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
        quaternion.iter_mut().for_each(|x| *x /= length);
    }
}
