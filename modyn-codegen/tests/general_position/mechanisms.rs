//! Mechanisms with closed loops, as models, and the same mechanisms rotated and scaled.

use std::f64::consts::PI;

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    Inertial, Joint, Link, LoopConstraint, LoopConstraintEnd, LoopConstraintKind, Model, MovingLink,
};
use modyn_runtime::spatial::Pose;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Pseudo-random numbers in [-1, 1).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        f64::from(u32::try_from(self.0 >> 32).expect("32 bits")) / 2_147_483_648.0 - 1.0
    }

    pub fn vector(&mut self, n: usize, size: f64) -> Vec<f64> {
        (0..n).map(|_| size * self.next()).collect()
    }

    pub fn rotation(&mut self) -> Matrix3<f64> {
        let [x, y, z] = [0; 3].map(|_| 3.0 * self.next());
        Rotation3::new(Vector3::new(x, y, z)).into_inner()
    }
}

/// A mechanism, and coordinates near a closed configuration.
pub struct Mechanism {
    pub name: &'static str,
    pub model: Model,
    pub q: Vec<f64>,
    /// The number of independent constraint rows in closed configurations.
    pub rank: usize,
    /// Whether the loops can be closed.
    pub closes: bool,
}

pub fn matrix(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_row_slice(&rows.concat())
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[(i, j)]))
}

/// Returns the pose of a frame translated by (a, 0, 0) and then rotated by `twist` about x.
fn link_end(a: f64, twist: f64) -> Pose<f64> {
    let (sin, cos) = twist.sin_cos();
    Pose {
        rotation: [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]],
        translation: [a, 0.0, 0.0],
    }
}

fn inverse(pose: &Pose<f64>) -> Pose<f64> {
    let transposed = matrix(pose.rotation).transpose();
    let translation = -(transposed * Vector3::from(pose.translation));
    Pose { rotation: rows(&transposed), translation: translation.into() }
}

fn along(pose: &Pose<f64>, distance: f64) -> Pose<f64> {
    pose.compose(&Pose { translation: [0.0, 0.0, distance], ..Pose::identity() })
}

/// Returns the inertia of a bar of this mass from the link's origin to `end`. Its thickness is 1/20 of its length, and
/// at least 1/20 of 0.1 m.
fn bar(mass: f64, end: [f64; 3]) -> Inertial {
    let end = Vector3::from(end);
    let square = end.norm_squared().max(0.01);
    let across = Matrix3::identity() * end.norm_squared() - end * end.transpose();
    let i = (across / 12.0 + Matrix3::identity() * square / 400.0) * mass;
    Inertial {
        mass,
        center_of_mass: (end * 0.5).into(),
        inertia: [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]],
    }
}

/// A model under construction.
#[derive(Default)]
struct Parts {
    links: Vec<MovingLink>,
    constraints: Vec<LoopConstraint>,
}

const Z: [f64; 3] = [0.0, 0.0, 1.0];

impl Parts {
    fn link(
        &mut self,
        parent: Option<usize>,
        joint_type: JointType,
        axis: [f64; 3],
        origin: Pose<f64>,
        inertial: Inertial,
    ) -> usize {
        let i = self.links.len();
        let joint = Joint::new(format!("joint{i}"), joint_type, axis, origin);
        self.links.push(MovingLink { name: format!("link{i}"), parent, joint, inertial });
        i
    }

    fn close(&mut self, kind: LoopConstraintKind, ends: [(Option<usize>, Pose<f64>); 2]) {
        // The world is the last frame here and the first frame of the model.
        let ends =
            ends.map(|(link, pose)| LoopConstraintEnd { link: link.map_or(0, |i| i + 1), pose });
        let name = format!("loop{}", self.constraints.len());
        self.constraints.push(LoopConstraint { name, kind, ends });
    }

    /// Adds a chain of revolute joints about z on `base` at `at`: link i ends at a_i along x, rotated by alpha_i about
    /// x. The chain's end, moved by `offset` along its z, is held on the base. There the transform `closing` leads to
    /// the start of the chain.
    fn chain(
        &mut self,
        (base, at): (Option<usize>, Pose<f64>),
        links: &[(f64, f64, f64)],
        closing: (f64, f64),
        kind: LoopConstraintKind,
        offset: f64,
    ) -> usize {
        let (mut parent, mut origin) = (base, at);
        let first = self.links.len();
        for &(a, twist, mass) in links {
            let end = if a == 0.0 { [0.1, 0.05 * twist, 0.2] } else { [a, 0.0, 0.0] };
            let link = self.link(parent, JointType::Revolute, Z, origin, bar(mass, end));
            (parent, origin) = (Some(link), link_end(a, twist));
        }
        let goal = at.compose(&inverse(&link_end(closing.0, closing.1)));
        self.close(kind, [(parent, along(&origin, offset)), (base, along(&goal, offset))]);
        first
    }

    fn model(self) -> Model {
        let frame = |name: &str, link| Link {
            name: name.into(),
            moving_link: link,
            pose: Pose::identity(),
            inertial: Inertial::default(),
        };
        let of_links = self.links.iter().enumerate();
        let of_links = of_links
            .map(|(i, link)| Link { inertial: link.inertial, ..frame(&link.name, Some(i)) });
        let frames = [frame("world", None)].into_iter().chain(of_links).collect();
        let model = Model::new("mechanism", [0.3, -9.0, 2.0], self.links, frames).expect("a tree");
        model.with_loop_constraints(self.constraints).expect("loops")
    }
}

const HINGE: LoopConstraintKind = LoopConstraintKind::Revolute(Z);
const WORLD: Option<usize> = None;

/// Returns kinematic loops of revolute joints from link lengths, twists and masses; the fixed link is the last.
fn ring(
    (name, rank): (&'static str, usize),
    links: &[(f64, f64, f64)],
    closing: (f64, f64),
    kind: LoopConstraintKind,
    offset: f64,
    q: &[f64],
) -> Mechanism {
    let mut parts = Parts::default();
    parts.chain((WORLD, Pose::identity()), links, closing, kind, offset);
    Mechanism { name, model: parts.model(), q: q.to_vec(), rank, closes: true }
}

/// Crank 0.2, coupler 0.5, rocker 0.4, ground 0.5; the second frame of the loop belongs to the rocker.
const FOUR_BAR: [(f64, f64, f64); 3] = [(0.2, 0.0, 0.2), (0.5, 0.0, 0.5), (0.4, 0.0, 0.4)];
const FOUR_BAR_Q: [f64; 3] = [1.0, -0.6, -1.8];

fn bennett(kind: LoopConstraintKind, name: &'static str) -> Mechanism {
    // sin(alpha) / a = sin(beta) / b.
    let (a, b, alpha) = (0.3_f64, 0.45_f64, 0.6_f64);
    let beta = (alpha.sin() * b / a).asin();
    let first: f64 = 1.1;
    let second = 2.0
        * ((0.5 * (beta + alpha)).sin() / (0.5 * (beta - alpha)).sin() / (0.5 * first).tan())
            .atan();
    let mut links = vec![(a, alpha, 0.5), (b, beta, 0.8), (a, alpha, 0.4)];
    let mut q = vec![first, second, -first];
    if matches!(kind, LoopConstraintKind::Rigid) {
        links.push((b, beta, 0.3));
        q.push(-second);
        return ring((name, 3), &links, (0.0, 0.0), kind, 0.0, &q);
    }
    ring((name, 2), &links, (b, beta), kind, 0.0, &q)
}

/// Returns a bar on three parallel cranks of equal length, one of which is redundant.
fn three_cranks() -> Mechanism {
    let mut parts = Parts::default();
    let place = |x: f64| Pose { translation: [x, 0.0, 0.0], ..Pose::identity() };
    let crank = |parts: &mut Parts, x: f64| {
        parts.link(WORLD, JointType::Revolute, Z, place(x), bar(0.3, [0.2, 0.0, 0.0]))
    };
    let first = crank(&mut parts, 0.0);
    let carried = bar(1.0, [0.6, 0.0, 0.0]);
    let platform = parts.link(Some(first), JointType::Revolute, Z, place(0.2), carried);
    for x in [0.35, 0.6] {
        let crank = crank(&mut parts, x);
        parts.close(HINGE, [(Some(platform), place(x)), (Some(crank), place(0.2))]);
    }
    let q = vec![0.7, -0.7, 0.7, 0.7];
    Mechanism { name: "three cranks", model: parts.model(), q, rank: 3, closes: true }
}

/// Returns a four-bar linkage of 2 kg with a four-bar linkage of 0.5 g on its coupler, smaller and in another plane.
fn heavy_and_light() -> Mechanism {
    let mut parts = Parts::default();
    let first =
        parts.link(WORLD, JointType::Revolute, Z, Pose::identity(), bar(0.4, [0.2, 0.0, 0.0]));
    let at = Pose { translation: [0.2, 0.0, 0.0], ..Pose::identity() };
    let coupler = parts.link(Some(first), JointType::Revolute, Z, at, bar(0.9, [0.5, 0.0, 0.0]));
    let light = FOUR_BAR.map(|(a, twist, mass)| (0.1 * a, twist, mass * 5e-4 / 1.1));
    let tilted = Pose { translation: [0.1, 0.2, 0.0], ..link_end(0.0, 0.9) };
    parts.chain((Some(coupler), tilted), &light, (0.05, 0.0), HINGE, 0.0);
    let at = Pose { translation: [0.5, 0.0, 0.0], ..Pose::identity() };
    let rocker = parts.link(Some(coupler), JointType::Revolute, Z, at, bar(0.7, [0.4, 0.0, 0.0]));
    let end = Pose { translation: [0.4, 0.0, 0.0], ..Pose::identity() };
    let goal = Pose { translation: [-0.5, 0.0, 0.0], ..Pose::identity() };
    parts.close(HINGE, [(Some(rocker), end), (WORLD, goal)]);
    let q = [&FOUR_BAR_Q[..2], &FOUR_BAR_Q, &FOUR_BAR_Q[2..]].concat();
    Mechanism { name: "2 kg and 0.5 g", model: parts.model(), q, rank: 4, closes: true }
}

/// Returns the same linkages with their loop constraints in the other order.
fn light_and_heavy() -> Mechanism {
    let mechanism = heavy_and_light();
    let mut constraints = mechanism.model.loop_constraints().to_vec();
    constraints.reverse();
    let model = mechanism.model.with_loop_constraints(constraints).expect("loops");
    Mechanism { name: "0.5 g and 2 kg", model, ..mechanism }
}

/// Returns a platform on six legs. Six joints of one degree of freedom move the platform; each leg has a universal
/// joint and a prismatic one.
fn stewart() -> Mechanism {
    let mut parts = Parts::default();
    let mut platform = WORLD;
    let units = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], Z];
    for (i, axis) in units.into_iter().chain(units).enumerate() {
        let joint_type = if i < 3 { JointType::Prismatic } else { JointType::Revolute };
        let inertial = if i < 5 { Inertial::default() } else { bar(3.0, [0.3, 0.2, 0.1]) };
        platform = Some(parts.link(platform, joint_type, axis, Pose::identity(), inertial));
    }
    let mut q = vec![0.05, -0.02, 0.8, 0.1, -0.15, 0.2];
    for leg in 0..6 {
        let leg = f64::from(leg);
        let (foot, head) = (leg * 1.05 + 0.4 * (leg % 2.0), leg * 1.05 + 0.25);
        let at =
            Pose { translation: [0.7 * foot.cos(), 0.7 * foot.sin(), 0.0], ..Pose::identity() };
        let rotated_bar = bar(0.4, [0.0, 0.1, 0.4]);
        let first = parts.link(WORLD, JointType::Universal, units[0], at, rotated_bar);
        let slide = parts.link(
            Some(first),
            JointType::Prismatic,
            Z,
            Pose::identity(),
            bar(0.2, [0.0, 0.0, 0.3]),
        );
        let joint =
            Pose { translation: [0.4 * head.cos(), 0.4 * head.sin(), 0.05], ..Pose::identity() };
        parts
            .close(LoopConstraintKind::Point, [(platform, joint), (Some(slide), Pose::identity())]);
        q.extend([-0.1, -0.3, 0.9]);
    }
    Mechanism { name: "Stewart", model: parts.model(), q, rank: 18, closes: true }
}

/// Returns two cranks in different planes with a thin rod on ball joints, which rotates freely about its axis.
fn thin_rod() -> Mechanism {
    let mut parts = Parts::default();
    let crank =
        parts.link(WORLD, JointType::Revolute, Z, Pose::identity(), bar(0.5, [0.2, 0.0, 0.0]));
    let at = Pose { translation: [0.2, 0.0, 0.0], ..Pose::identity() };
    let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let first = parts.link(Some(crank), JointType::Revolute, Z, at, Inertial::default());
    let second =
        parts.link(Some(first), JointType::Revolute, y, Pose::identity(), Inertial::default());
    let thin = Inertial {
        mass: 0.1,
        center_of_mass: [0.25, 0.0, 0.0],
        inertia: [1e-7, 0.0, 0.0, 2e-3, 0.0, 2e-3],
    };
    let rod = parts.link(Some(second), JointType::Revolute, x, Pose::identity(), thin);
    let stand = Pose { translation: [0.5, 0.1, 0.0], ..link_end(0.0, 1.2) };
    let rocker = parts.link(WORLD, JointType::Revolute, Z, stand, bar(0.4, [0.4, 0.0, 0.0]));
    let end = |x: f64| Pose { translation: [x, 0.0, 0.0], ..Pose::identity() };
    parts.close(LoopConstraintKind::Point, [(Some(rod), end(0.5)), (Some(rocker), end(0.4))]);
    let q = vec![0.8, -0.3, -0.4, 0.5, 1.5];
    Mechanism { name: "thin rod", model: parts.model(), q, rank: 3, closes: true }
}

/// Returns the four-bar linkage with a second hinge 10 cm from its last one: three joints cannot satisfy four rows in
/// the plane.
fn contradictory() -> Mechanism {
    let mut mechanism = ring(("contradictory", 3), &FOUR_BAR, (0.5, 0.0), HINGE, 0.0, &FOUR_BAR_Q);
    let mut constraints = mechanism.model.loop_constraints().to_vec();
    let mut again = constraints[0].clone();
    again.name = "again".into();
    again.ends[1].pose.translation[1] += 0.1;
    constraints.push(again);
    mechanism.model = mechanism.model.with_loop_constraints(constraints).expect("loops");
    Mechanism { closes: false, ..mechanism }
}

/// Returns the four-bar linkage with its last hinge tilted by 0.01 rad: that constraint can never be satisfied.
fn tilted() -> Mechanism {
    let mut mechanism = ring(("tilted", 2), &FOUR_BAR, (0.5, 0.0), HINGE, 0.0, &FOUR_BAR_Q);
    let mut constraints = mechanism.model.loop_constraints().to_vec();
    let pose = &mut constraints[0].ends[1].pose;
    *pose = pose.compose(&link_end(0.0, 0.01));
    mechanism.model = mechanism.model.with_loop_constraints(constraints).expect("loops");
    Mechanism { closes: false, ..mechanism }
}

/// Returns a parallelogram in its flat configuration, where the rank is lower by one than elsewhere.
fn flat() -> Mechanism {
    let links = [(0.2, 0.0, 0.2), (0.5, 0.0, 0.5), (0.2, 0.0, 0.3)];
    let q = [PI, 0.0, PI];
    ring(("flat", 1), &links, (0.5, 0.0), HINGE, 0.0, &q)
}

pub fn all() -> Vec<Mechanism> {
    let spherical = [(0.0, 0.7, 0.3), (0.0, 1.1, 0.5), (0.0, 0.9, 0.4)];
    let q = [0.9, -1.3, 1.2];
    let slider = [(0.2, 0.0, 0.3), (0.6, 0.0, 0.4), (0.1, 0.0, 0.5)];
    let slide = LoopConstraintKind::Prismatic([0.6, 0.8, 0.0]);
    vec![
        ring(("four-bar", 2), &FOUR_BAR, (0.5, 0.0), HINGE, 0.0, &FOUR_BAR_Q),
        ring(
            ("four-bar, point", 2),
            &FOUR_BAR,
            (0.5, 0.0),
            LoopConstraintKind::Point,
            0.1,
            &FOUR_BAR_Q,
        ),
        ring(
            ("four-bar, rigid", 3),
            &[&FOUR_BAR[..], &[(0.5, 0.0, 0.6)]].concat(),
            (0.0, 0.0),
            LoopConstraintKind::Rigid,
            0.0,
            &[&FOUR_BAR_Q[..], &[-4.9]].concat(),
        ),
        ring(("slider crank", 2), &slider, (0.3, 0.0), slide, 0.0, &[0.7, -0.5, -0.2]),
        ring(("spherical", 2), &spherical, (0.0, 1.3), HINGE, 0.0, &q),
        ring(("spherical, offset", 2), &spherical, (0.0, 1.3), HINGE, 0.3, &q),
        bennett(HINGE, "Bennett"),
        bennett(LoopConstraintKind::Rigid, "Bennett, rigid"),
        three_cranks(),
        heavy_and_light(),
        light_and_heavy(),
        thin_rod(),
        stewart(),
        contradictory(),
        tilted(),
        flat(),
    ]
}

/// Returns the model with every vector rotated and every length scaled. Gravity is scaled, too, so that the motion has
/// the same duration.
pub fn rotated(model: &Model, r: &Matrix3<f64>, scale: f64) -> Model {
    let direction = |v: [f64; 3]| -> [f64; 3] { (r * Vector3::from(v)).into() };
    let point = |v: [f64; 3]| direction(v).map(|x| x * scale);
    let pose = |pose: &Pose<f64>| Pose {
        rotation: rows(&(r * matrix(pose.rotation) * r.transpose())),
        translation: point(pose.translation),
    };
    let inertial = |inertial: &Inertial| {
        let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
        let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let i = r * tensor * r.transpose() * (scale * scale);
        Inertial {
            center_of_mass: point(inertial.center_of_mass),
            inertia: [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]],
            ..*inertial
        }
    };
    let links = model.moving_links().iter().cloned().map(|mut link| {
        let joint = &mut link.joint;
        joint.origin = pose(&joint.origin);
        joint.axis = direction(joint.axis);
        joint.second_axis = direction(joint.second_axis);
        link.inertial = inertial(&link.inertial);
        link
    });
    let frames = model.links().iter().map(|link| Link {
        pose: pose(&link.pose),
        inertial: inertial(&link.inertial),
        ..link.clone()
    });
    let constraints = model.loop_constraints().iter().cloned().map(|mut constraint| {
        constraint.ends.iter_mut().for_each(|end| end.pose = pose(&end.pose));
        match &mut constraint.kind {
            LoopConstraintKind::Revolute(axis) | LoopConstraintKind::Prismatic(axis) => {
                *axis = direction(*axis);
            }
            LoopConstraintKind::Point | LoopConstraintKind::Rigid => {}
        }
        constraint
    });
    let (gravity, constraints) = (point(model.gravity()), constraints.collect());
    let model =
        Model::new("mechanism", gravity, links.collect(), frames.collect()).expect("a tree");
    model.with_loop_constraints(constraints).expect("loops")
}

/// Returns, for each entry of q and qd, whether it is a displacement.
pub fn lengths(model: &Model) -> Vec<bool> {
    model
        .moving_links()
        .iter()
        .flat_map(|link| {
            let joint_type = link.joint.joint_type;
            vec![matches!(joint_type, JointType::Prismatic); joint_type.nv()]
        })
        .collect()
}
