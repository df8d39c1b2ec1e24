//! Random robots and states: the same for a seed on every host, so no sine or cosine is taken
//! here, whose last digit is the system's to choose. Needs `modyn_runtime` alone, so that a build
//! script can include this file.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    DEFAULT_GRAVITY, Frame, Inertial, Joint, Limits, Link, Model, ModuleTree,
};
use modyn_runtime::spatial::Pose;

/// A stream of numbers: SplitMix64 (Steele, Lea and Flood 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The stream of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number in `low..high`.
    #[allow(clippy::cast_precision_loss)]
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.bits() >> 11) as f64 / (1u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// An index below `n`, which must not be 0.
    #[allow(clippy::cast_possible_truncation)]
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// True in that part of all cases.
    pub fn chance(&mut self, part: f64) -> bool {
        self.between(0.0, 1.0) < part
    }

    /// A point of the ball, evenly spread, not at its centre.
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

    /// Along an axis of the frame or slanted.
    fn axis(&mut self) -> [f64; 3] {
        if self.chance(0.5) {
            return self.unit();
        }
        let mut axis = [0.0; 3];
        axis[self.below(3)] = if self.chance(0.5) { 1.0 } else { -1.0 };
        axis
    }

    /// None, by right angles, about one axis, or any.
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
            _ => {
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
        }
    }

    /// A signed permutation that keeps handedness.
    fn right_angles(&mut self) -> [[f64; 3]; 3] {
        let start = self.below(3);
        let swapped = self.chance(0.5);
        let sign = |negative| if negative { -1.0 } else { 1.0 };
        let (a, b) = (sign(self.chance(0.5)), sign(self.chance(0.5)));
        // An odd permutation changes handedness once more.
        let c = a * b * sign(swapped);
        let (second, third) = if swapped { (2, 1) } else { (1, 2) };
        let mut rows = [[0.0; 3]; 3];
        rows[0][start] = a;
        rows[1][(start + second) % 3] = b;
        rows[2][(start + third) % 3] = c;
        rows
    }

    /// None, along one axis, or any.
    fn translation(&mut self) -> [f64; 3] {
        let mut translation = [0.0; 3];
        match self.below(4) {
            0 => {}
            1 => translation[self.below(3)] = self.between(-0.5, 0.5),
            _ => translation = std::array::from_fn(|_| self.between(-0.4, 0.4)),
        }
        translation
    }

    fn pose(&mut self) -> Pose<f64> {
        Pose { rotation: self.rotation(), translation: self.translation() }
    }

    /// That of a few point masses, so it is a rigid body's.
    fn inertial(&mut self) -> Inertial {
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
        Joint {
            name: format!("joint{number}"),
            joint_type,
            axis: self.axis(),
            origin: self.pose(),
            limits,
        }
    }
}

/// A tree of that many links (at least one): serial, branching a little or a lot, several branches
/// on the world among them; with fixed frames on links and on the world.
#[must_use]
pub fn tree(seed: u64, links: usize) -> Model {
    let serial = [1.0, 0.8, 0.4][Random::new(!seed).below(3)];
    grow(seed, links, serial)
}

/// A chain of that many links (at least one).
#[must_use]
pub fn chain(seed: u64, links: usize) -> Model {
    grow(seed, links, 1.0)
}

/// A tree in which a link hangs on the one before it in that part of all cases.
fn grow(seed: u64, count: usize, serial: f64) -> Model {
    let mut random = Random::new(seed);
    let gravity = match random.below(4) {
        0 => std::array::from_fn(|_| random.between(-10.0, 10.0)),
        _ => DEFAULT_GRAVITY,
    };
    let base = Frame { name: "base".into(), link: None, pose: Pose::identity() };
    let (mut links, mut frames) = (Vec::with_capacity(count), vec![base]);
    // From the world to the link before; what comes next leaves one of them.
    let mut path: Vec<usize> = Vec::new();
    for i in 0..count {
        if !random.chance(serial) {
            path.truncate(random.below(path.len() + 1));
        }
        let parent = path.last().copied();
        path.push(i);
        let name = format!("link{i}");
        let joint = random.joint(i);
        let inertial = random.inertial();
        links.push(Link { name: name.clone(), parent, joint, inertial });
        frames.push(Frame { name, link: Some(i), pose: Pose::identity() });
        if random.chance(0.2) {
            let link = random.chance(0.8).then_some(i);
            frames.push(Frame { name: format!("fixed{i}"), link, pose: random.pose() });
        }
    }
    Model::new(format!("tree{seed}_{count}"), gravity, links, frames)
        .unwrap_or_else(|errors| panic!("seed {seed}, {count} links: {errors:?}"))
}

/// A random partition into modules: the maximal chains, cut in places.
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
                module.push(&model.links()[i].name);
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
    /// Velocities.
    pub qd: Vec<f64>,
    /// Accelerations.
    pub qdd: Vec<f64>,
    /// Torques and forces, not those of these accelerations.
    pub tau: Vec<f64>,
}

/// A random state of `model`.
#[must_use]
pub fn state(seed: u64, model: &Model) -> State {
    let mut random = Random::new(seed ^ 0x5354_4154_4553);
    let mut vector = |size: f64| (0..model.nv()).map(|_| random.between(-size, size)).collect();
    State { q: vector(3.0), qd: vector(1.5), qdd: vector(3.0), tau: vector(10.0) }
}
