//! Joints that move no inertia.

use modyn_read::internals::{
    CONFIGURATIONS, UNITS, Vec3, articulated, coordinates, motions, rotation, singular_joints,
};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    DEFAULT_GRAVITY, Inertial, Joint, JointDynamics, Mimic, Model, MovingLink,
};
use modyn_runtime::spatial::{Matrix3, Pose, Twist, Vector3};

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

    fn link(&mut self, i: usize) -> MovingLink {
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
        MovingLink { name: format!("l{i}"), parent, joint, inertial }
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
    for (i, link) in model.moving_links().iter().enumerate() {
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
        assert!(singular || !found, "{:#?}", model.moving_links());
        // Through several consecutive massless links, rounding errors can exceed their estimate.
        let massless = |link: &MovingLink| link.inertial.mass == 0.0;
        if model.moving_links().windows(2).all(|pair| !pair.iter().all(massless)) {
            assert_eq!(singular, found, "{:#?}", model.moving_links());
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
            let speed = core::array::from_fn(|i| rate(ahead.translation[i], behind.translation[i]));
            let linear = back.mul_vector(Vector3(speed)).0;
            let change = [linear[0], linear[1], linear[2], spin[2][1], spin[0][2], spin[1][0]];
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
        MovingLink { name: format!("l{i}"), parent: None, joint, inertial }
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
