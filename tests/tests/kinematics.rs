//! Poses, velocities, accelerations and Jacobians of links, the centre of mass and the momentum about it: compared with
//! other software, with each other, and with finite differences.

use std::iter::zip;

use modyn_codegen::Function;
use modyn_codegen::graph::Node;
use modyn_codegen::passes::optimize;
use modyn_codegen::trace::{LinkFrame, Tracer};
use modyn_runtime::equations::dynamics::inverse_dynamics;
use modyn_runtime::equations::kinematics::Axes;
use modyn_runtime::equations::{self, Forces, Motion, Workspace};
use modyn_runtime::joint::JointType;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{DEFAULT_GRAVITY, Inertial, Joint, Link, Mimic, Model, MovingLink};
use modyn_runtime::spatial::{Momentum, Pose, Twist, Vector3, Wrench};
use modyn_runtime::{Interpreter, LinkError, ShapeError};
use modyn_tests::close::assert_close;
use modyn_tests::counting::measure;
use modyn_tests::golden::{self, FIXED_BASE, FLOATING_BASE, Golden};
use modyn_tests::quantities::{Quantities, numbers};
use modyn_tests::random::{Random, mixed_tree, tree};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion};

/// The tolerance that the reference data's README gives.
const TOLERANCE: f64 = 1e-9;

/// The tolerance for two computations of one quantity.
const EXACT: f64 = 1e-11;

/// The tolerance for central differences with the first error term removed.
const DIFFERENCES: f64 = 1e-7;

// Models

fn pose(random: &mut Random) -> Pose<f64> {
    let [x, y, z, w] = quaternion(random);
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    let rotation = *rotation.to_rotation_matrix().matrix();
    Pose {
        rotation: std::array::from_fn(|i| std::array::from_fn(|j| rotation[(i, j)])),
        translation: std::array::from_fn(|_| random.between(-0.5, 0.5)),
    }
}

fn quaternion(random: &mut Random) -> [f64; 4] {
    let numbers: [f64; 4] = std::array::from_fn(|_| random.between(0.1, 1.0));
    let length = numbers.iter().map(|x| x * x).sum::<f64>().sqrt();
    numbers.map(|x| x / length)
}

fn unit(random: &mut Random) -> [f64; 3] {
    let numbers: [f64; 3] = std::array::from_fn(|_| random.between(0.2, 1.0));
    let length = numbers.iter().map(|x| x * x).sum::<f64>().sqrt();
    numbers.map(|x| x / length)
}

fn inertial(random: &mut Random) -> Inertial {
    Inertial {
        mass: random.between(0.5, 2.0),
        center_of_mass: std::array::from_fn(|_| random.between(-0.3, 0.3)),
        inertia: [0.05, 0.004, -0.003, 0.06, 0.002, 0.04],
    }
}

/// Returns a tree with these joints, each with the index of its parent link; some are mimic joints.
fn by_hand(name: &str, joints: &[(JointType, Option<usize>)], mimics: &[(usize, Mimic)]) -> Model {
    let random = &mut Random::new(joints.len() as u64);
    let (mut links, mut frames) = (Vec::new(), Vec::new());
    for (i, &(joint_type, parent)) in joints.iter().enumerate() {
        let mut joint = Joint::new(format!("joint{i}"), joint_type, unit(random), pose(random));
        let [x, y, z] = unit(random);
        joint.second_axis = [-y, z, x];
        joint.mimic = mimics.iter().find(|(follower, _)| *follower == i).map(|(_, mimic)| *mimic);
        let (name, inertial) = (format!("link{i}"), inertial(random));
        links.push(MovingLink { name: name.clone(), parent, joint, inertial });
        frames.push(Link { name, moving_link: Some(i), pose: Pose::identity(), inertial });
        let frame = Link {
            name: format!("tool{i}"),
            moving_link: Some(i),
            pose: pose(random),
            inertial: Inertial::default(),
        };
        frames.push(frame);
    }
    let (pose, inertial) = (pose(random), Inertial::default());
    frames.push(Link { name: "ground".into(), moving_link: None, pose, inertial });
    Model::new(name, DEFAULT_GRAVITY, links, frames).unwrap_or_else(|e| panic!("{name}: {e:?}"))
}

/// Returns models with every joint type at the root, in the middle and at the end, and with mimic joints.
fn models() -> Vec<Model> {
    use JointType::{Continuous, Floating, Planar, Prismatic, Revolute, Spherical, Universal};
    let follow = |leader, multiplier, offset| Mimic { leader, multiplier, offset };
    let mut models = vec![
        by_hand(
            "balls",
            &[
                (Spherical, None),
                (Revolute, Some(0)),
                (Spherical, Some(1)),
                (Prismatic, Some(2)),
                (Spherical, Some(0)),
            ],
            &[],
        ),
        by_hand(
            "free",
            &[
                (Revolute, None),
                (Floating, Some(0)),
                (Prismatic, Some(1)),
                (Continuous, Some(2)),
                (Floating, None),
                (Universal, Some(4)),
            ],
            &[],
        ),
        by_hand(
            "plane",
            &[(Planar, None), (Universal, Some(0)), (Revolute, Some(1)), (Planar, Some(1))],
            &[],
        ),
        by_hand(
            "hand",
            &[
                (Floating, None),
                (Revolute, Some(0)),
                (Revolute, Some(1)),
                (Prismatic, Some(2)),
                (Revolute, Some(0)),
                (Revolute, Some(4)),
                (Prismatic, Some(5)),
            ],
            &[
                (2, follow(1, -0.7, 0.3)),
                (3, follow(2, 0.5, 0.1)),
                (4, follow(1, 1.3, 0.0)),
                (6, follow(5, -2.0, -0.2)),
            ],
        ),
    ];
    models.extend((0..12).map(|seed| mixed_tree(seed, 1 + seed as usize)));
    models
}

/// Runs `check` on a few states of each model.
fn everywhere(mut check: impl FnMut(&mut Interpreter<f64>, &State)) {
    for model in models() {
        let mut interpreter = Interpreter::new(model);
        for seed in 0..3 {
            let state = State::random(seed, interpreter.model());
            check(&mut interpreter, &state);
        }
    }
}

// Motion

/// Coordinates, velocities and accelerations.
struct State {
    q: Vec<f64>,
    qd: Vec<f64>,
    qdd: Vec<f64>,
}

impl State {
    fn random(seed: u64, model: &Model) -> Self {
        let mut random = Random::new(seed ^ 0x004b_494e);
        let mut q: Vec<f64> = (0..model.nq()).map(|_| random.between(-2.0, 2.0)).collect();
        for range in quaternions(model) {
            q[range].copy_from_slice(&quaternion(&mut random));
        }
        let mut vector = |size: f64| (0..model.nv()).map(|_| random.between(-size, size)).collect();
        Self { q, qd: vector(1.5), qdd: vector(3.0) }
    }

    /// Returns the state after a short `time`, exact up to third order in `time`.
    fn after(&self, model: &Model, time: f64) -> Self {
        let middle = plus(&self.qd, 0.5 * time, &self.qdd);
        let q = moved(model, &self.q, time, &middle);
        Self { q, qd: plus(&self.qd, time, &self.qdd), qdd: self.qdd.clone() }
    }
}

fn plus(a: &[f64], factor: f64, b: &[f64]) -> Vec<f64> {
    zip(a, b).map(|(a, b)| a + factor * b).collect()
}

/// Returns the ranges of the quaternions in q.
fn quaternions(model: &Model) -> Vec<std::ops::Range<usize>> {
    let own = model.moving_links().iter().enumerate();
    let ranges = own.filter_map(|(i, link)| match link.joint.joint_type {
        JointType::Spherical | JointType::Floating => {
            let end = model.q_range(i).end;
            Some(end - 4..end)
        }
        _ => None,
    });
    ranges.collect()
}

/// Returns the coordinates after `time` at these velocities: for quaternions and floating joints by the exponential of
/// the twist.
fn moved(model: &Model, q: &[f64], time: f64, qd: &[f64]) -> Vec<f64> {
    let mut moved = q.to_vec();
    for (i, link) in model.moving_links().iter().enumerate() {
        if link.joint.mimic.is_some() {
            continue;
        }
        let (at, rates) = (model.q_range(i), &qd[model.v_range(i)]);
        let q = &mut moved[at];
        let rotations = |q: &[f64], omega: &[f64]| {
            let before = UnitQuaternion::new_normalize(Quaternion::new(q[3], q[0], q[1], q[2]));
            let omega = nalgebra::Vector3::from_column_slice(omega) * time;
            (before, UnitQuaternion::from_scaled_axis(omega), omega)
        };
        match link.joint.joint_type {
            JointType::Spherical => {
                let (before, rotation, _) = rotations(q, rates);
                q.copy_from_slice((before * rotation).coords.as_slice());
            }
            JointType::Floating => {
                let (before, rotation, omega) = rotations(&q[3..], &rates[3..]);
                let v = nalgebra::Vector3::from_column_slice(&rates[..3]) * time;
                // The integral of the rotation to third order.
                let displacement = v + omega.cross(&v) / 2.0 + omega.cross(&omega.cross(&v)) / 6.0;
                zip(&mut q[..3], &(before * displacement)).for_each(|(q, step)| *q += step);
                q[3..].copy_from_slice((before * rotation).coords.as_slice());
            }
            _ => zip(q, rates).for_each(|(q, rate)| *q += time * rate),
        }
    }
    moved
}

/// Returns the derivative at 0 by central differences, with the first error term removed.
fn derivative<const N: usize>(mut f: impl FnMut(f64) -> [f64; N]) -> [f64; N] {
    let h = 2e-4;
    let mut slope = |h: f64| {
        let (ahead, behind) = (f(h), f(-h));
        let slope: [f64; N] = std::array::from_fn(|i| (ahead[i] - behind[i]) / (2.0 * h));
        slope
    };
    let (near, far) = (slope(h), slope(2.0 * h));
    std::array::from_fn(|i| near[i] + (near[i] - far[i]) / 3.0)
}

// Quantities as values

const FINE: &str = "the lengths are right and the link is there";

fn jacobian(
    interpreter: &mut Interpreter<f64>,
    q: &[f64],
    frame: usize,
    axes: Axes,
) -> Vec<Twist<f64>> {
    let mut columns = vec![Twist::zero(); interpreter.model().nv()];
    match axes {
        Axes::World => interpreter.jacobian(q, frame, &mut columns).expect(FINE),
        Axes::Link => interpreter.jacobian_local(q, frame, &mut columns).expect(FINE),
    }
    columns
}

/// Returns the product of a matrix, given by columns, and the velocities.
fn times<const N: usize>(columns: impl Iterator<Item = [f64; N]>, rates: &[f64]) -> [f64; N] {
    zip(columns, rates)
        .fold([0.0; N], |sum, (column, rate)| std::array::from_fn(|i| sum[i] + column[i] * rate))
}

fn product(columns: &[Twist<f64>], rates: &[f64]) -> [f64; 6] {
    times(columns.iter().map(Twist::components), rates)
}

fn rotation(pose: &Pose<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| pose.rotation[i][j])
}

fn na(v: Vector3<f64>) -> nalgebra::Vector3<f64> {
    v.0.into()
}

/// Returns the components of a twist in link axes from those in world axes.
fn to_link(pose: &Pose<f64>, t: &Twist<f64>) -> [f64; 6] {
    let back = rotation(pose).transpose();
    let [linear, angular] = [t.linear, t.angular].map(|v| Vector3((back * na(v)).into()));
    Twist { linear, angular }.components()
}

// Other software

#[test]
fn poses_and_jacobians_of_other_software() {
    let mut seen = 0;
    for name in FIXED_BASE.into_iter().chain(FLOATING_BASE) {
        let Golden { model, states } = Golden::load(name);
        let mut interpreter = Interpreter::new(model);
        for state in states {
            let q = state.q();
            for placement in state.frames() {
                let link = &placement.name;
                let frame = interpreter.model().link_index(link).expect(link);
                let found = numbers(&interpreter.link_pose(&q, frame).expect(FINE));
                let what = format!("{name} {link}");
                assert_close(&what, &found, &placement.numbers, TOLERANCE);
                let columns = jacobian(&mut interpreter, &q, frame, Axes::World);
                let found: Vec<f64> = columns.iter().flat_map(Twist::components).collect();
                assert_close(&what, &found, placement.jacobian.as_slice(), TOLERANCE);
                seen += 1;
            }
        }
    }
    assert!(seen > 100, "{seen} frames");
}

// Identities

#[test]
fn one_links_pose_is_that_among_all() {
    everywhere(|interpreter, State { q, .. }| {
        for (frame, pose) in interpreter.poses(q).iter().enumerate() {
            let found = interpreter.link_pose(q, frame).expect(FINE);
            assert_close("pose", &numbers(&found), &numbers(pose), EXACT);
        }
    });
}

#[test]
fn velocities_are_the_poses_rates_and_the_jacobians_products() {
    everywhere(|interpreter, state| {
        let model = interpreter.model().clone();
        for frame in 0..model.links().len() {
            let State { q, qd, .. } = state;
            let velocity = interpreter.link_velocity(q, qd, frame).expect(FINE);
            let pose = interpreter.link_pose(q, frame).expect(FINE);
            let rates: [f64; 12] = derivative(|time| {
                let pose = interpreter.link_pose(&moved(&model, q, time, qd), frame).expect(FINE);
                numbers(&pose).try_into().expect("twelve numbers")
            });
            let rate = Matrix3::from_row_slice(&rates[..9]) * rotation(&pose).transpose();
            let expected =
                [rates[9], rates[10], rates[11], rate[(2, 1)], rate[(0, 2)], rate[(1, 0)]];
            assert_close("rate of the pose", &velocity.components(), &expected, DIFFERENCES);

            let columns = jacobian(interpreter, q, frame, Axes::World);
            assert_close("J qd", &product(&columns, qd), &velocity.components(), EXACT);
            let local = interpreter.link_velocity_local(q, qd, frame).expect(FINE);
            assert_close("in link axes", &local.components(), &to_link(&pose, &velocity), EXACT);
            let columns = jacobian(interpreter, q, frame, Axes::Link);
            assert_close("J qd in link axes", &product(&columns, qd), &local.components(), EXACT);
        }
    });
}

#[test]
fn accelerations_are_the_velocities_rates_and_the_jacobians_products() {
    everywhere(|interpreter, state| {
        let model = interpreter.model().clone();
        for frame in 0..model.links().len() {
            let State { q, qd, qdd } = state;
            let acceleration = interpreter.link_acceleration(q, qd, qdd, frame).expect(FINE);
            let expected = derivative(|time| {
                let State { q, qd, .. } = state.after(&model, time);
                interpreter.link_velocity(&q, &qd, frame).expect(FINE).components()
            });
            assert_close("acceleration", &acceleration.components(), &expected, DIFFERENCES);

            let rate = interpreter.jacobian_dot_qd(q, qd, frame).expect(FINE);
            let columns = jacobian(interpreter, q, frame, Axes::World);
            let sum = plus(&product(&columns, qdd), 1.0, &rate.components());
            assert_close("J qdd + J' qd", &sum, &acceleration.components(), EXACT);

            let pose = interpreter.link_pose(q, frame).expect(FINE);
            let local = interpreter.link_acceleration_local(q, qd, qdd, frame).expect(FINE);
            let expected = to_link(&pose, &acceleration);
            assert_close("in link axes", &local.components(), &expected, EXACT);

            let coasting = State { q: q.clone(), qd: qd.clone(), qdd: vec![0.0; qd.len()] };
            let rate = interpreter.jacobian_dot_qd_local(q, qd, frame).expect(FINE);
            let expected = derivative(|time| {
                let State { q, qd, .. } = coasting.after(&model, time);
                product(&jacobian(interpreter, &q, frame, Axes::Link), &qd)
            });
            assert_close("J' qd in link axes", &rate.components(), &expected, DIFFERENCES);
        }
    });
}

#[test]
fn links_on_the_ground_do_not_move() {
    everywhere(|interpreter, State { q, qd, qdd }| {
        let frames = interpreter.model().links().to_vec();
        let fixed = frames.iter().enumerate().filter(|(_, frame)| frame.moving_link.is_none());
        for (frame, expected) in fixed {
            assert_eq!(interpreter.link_pose(q, frame), Ok(expected.pose));
            let still = Ok(Twist::zero());
            assert_eq!(interpreter.link_velocity(q, qd, frame), still);
            assert_eq!(interpreter.link_velocity_local(q, qd, frame), still);
            assert_eq!(interpreter.link_acceleration(q, qd, qdd, frame), still);
            assert_eq!(interpreter.link_acceleration_local(q, qd, qdd, frame), still);
            assert_eq!(interpreter.jacobian_dot_qd(q, qd, frame), still);
            assert_eq!(interpreter.jacobian_dot_qd_local(q, qd, frame), still);
            for axes in [Axes::World, Axes::Link] {
                let columns = jacobian(interpreter, q, frame, axes);
                assert!(columns.iter().all(|column| *column == Twist::zero()));
            }
        }
    });
}

#[test]
fn external_forces_act_through_the_jacobian() {
    everywhere(|interpreter, State { q, qd, qdd }| {
        let mechanism = Mechanism::new(interpreter.model());
        let (frames, n) = (interpreter.model().links().len(), interpreter.model().nv());
        let wrench = [0.3, -1.2, 0.7, 2.0, -0.4, 1.1];
        for frame in 0..frames {
            let mut forces = vec![Wrench::zero(); frames];
            forces[frame] = Wrench::from_components(wrench);
            let tau = interpreter.tau(q, qd, qdd);
            for (axes, forces) in [
                (Axes::World, Forces::InWorldAxes(&forces)),
                (Axes::Link, Forces::InLinkAxes(&forces)),
            ] {
                let mut found = vec![0.0; n];
                let workspace = &mut Workspace::new(&mechanism);
                inverse_dynamics(
                    &mechanism,
                    equations::State { q, qd },
                    Some(qdd),
                    Some(forces),
                    workspace,
                    &mut found,
                );
                let columns = jacobian(interpreter, q, frame, axes);
                let joint_forces = columns.iter().map(|column| -> f64 {
                    zip(column.components(), wrench).map(|(a, b)| a * b).sum()
                });
                let joint_forces: Vec<f64> = joint_forces.collect();
                assert_close("tau - J^T w", &found, &plus(&tau, -1.0, &joint_forces), EXACT);
            }
        }
    });
}

// All links together

/// The mass, the centre of mass and the momentum about it, summed over the links.
struct Summed {
    mass: f64,
    center: nalgebra::Vector3<f64>,
    momentum: [f64; 6],
}

fn summed(interpreter: &mut Interpreter<f64>, q: &[f64], qd: &[f64]) -> Summed {
    let model = interpreter.model().clone();
    let mut parts = Vec::new();
    for (i, link) in model.moving_links().iter().enumerate() {
        // The frame of the link itself, which has the link's name.
        let frame = model.link_index(&link.name).expect("its own frame");
        assert_eq!(model.links()[frame].moving_link, Some(i));
        let pose = interpreter.link_pose(q, frame).expect(FINE);
        let velocity = interpreter.link_velocity(q, qd, frame).expect(FINE);
        let arm = rotation(&pose) * nalgebra::Vector3::from(link.inertial.center_of_mass);
        let [xx, xy, xz, yy, yz, zz] = link.inertial.inertia;
        let own = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let spin = rotation(&pose) * own * rotation(&pose).transpose() * na(velocity.angular);
        let v = na(velocity.linear) + na(velocity.angular).cross(&arm);
        parts.push((link.inertial.mass, nalgebra::Vector3::from(pose.translation) + arm, v, spin));
    }
    let mass: f64 = parts.iter().map(|part| part.0).sum();
    let center = parts.iter().map(|(m, at, ..)| at * *m).sum::<nalgebra::Vector3<f64>>() / mass;
    let linear: nalgebra::Vector3<f64> = parts.iter().map(|(m, _, v, _)| v * *m).sum();
    let angular: nalgebra::Vector3<f64> =
        parts.iter().map(|(m, at, v, spin)| spin + (at - center).cross(&(v * *m))).sum();
    let momentum = [linear.as_slice(), angular.as_slice()].concat();
    Summed { mass, center, momentum: momentum.try_into().expect("six numbers") }
}

#[test]
fn center_of_mass_and_momentum_are_the_links_sums() {
    everywhere(|interpreter, State { q, qd, .. }| {
        let n = interpreter.model().nv();
        let expected = summed(interpreter, q, qd);
        let center = interpreter.center_of_mass(q).expect(FINE);
        assert_close("centre of mass", &center, expected.center.as_slice(), EXACT);

        let mut columns = vec![Vector3::zero(); n];
        interpreter.center_of_mass_jacobian(q, &mut columns).expect(FINE);
        let velocity = times(columns.iter().map(|column| column.0), qd);
        let linear = velocity.map(|v| v * expected.mass);
        assert_close("linear momentum", &linear, &expected.momentum[..3], EXACT);

        let momentum = interpreter.centroidal_momentum(q, qd).expect(FINE);
        assert_close("momentum", &momentum.components(), &expected.momentum, EXACT);
        let mut columns = vec![Momentum::zero(); n];
        interpreter.centroidal_momentum_matrix(q, &mut columns).expect(FINE);
        let product = times(columns.iter().map(Momentum::components), qd);
        assert_close("A qd", &product, &expected.momentum, EXACT);
    });
}

#[test]
fn the_center_of_masss_jacobian_is_its_derivative() {
    everywhere(|interpreter, State { q, .. }| {
        let model = interpreter.model().clone();
        let mut columns = vec![Vector3::zero(); model.nv()];
        interpreter.center_of_mass_jacobian(q, &mut columns).expect(FINE);
        for (j, column) in columns.iter().enumerate() {
            let unit: Vec<f64> = (0..columns.len()).map(|i| f64::from(u8::from(i == j))).collect();
            let expected = derivative(|time| {
                interpreter.center_of_mass(&moved(&model, q, time, &unit)).expect(FINE)
            });
            assert_close("derivative", &column.0, &expected, DIFFERENCES);
        }
    });
}

/// The rate is the derivative of the links' summed momenta along a motion, and its change with qdd is that of A qdd.
#[test]
fn the_rate_of_the_momentum_is_its_derivative() {
    everywhere(|interpreter, state| {
        let State { q, qd, qdd } = state;
        let model = interpreter.model().clone();
        let found =
            interpreter.centroidal_momentum_rate(Motion { q, qd, qdd }).expect(FINE).components();
        let expected = derivative(|time| {
            let State { q, qd, .. } = state.after(&model, time);
            summed(interpreter, &q, &qd).momentum
        });
        assert_close("rate", &found, &expected, DIFFERENCES);
        let none = vec![0.0; model.nv()];
        let bias = interpreter
            .centroidal_momentum_rate(Motion { q, qd, qdd: &none })
            .expect(FINE)
            .components();
        let mut columns = vec![Momentum::zero(); model.nv()];
        interpreter.centroidal_momentum_matrix(q, &mut columns).expect(FINE);
        let product = times(columns.iter().map(Momentum::components), qdd);
        let sum: Vec<f64> = product.iter().zip(bias).map(|(a, b)| a + b).collect();
        assert_close("A qdd + A' qd", &found, &sum, EXACT);
    });
}

/// The derivatives are differences of the momenta of the links, and of the rate.
#[test]
fn derivatives_of_the_momentum_and_of_its_rate_are_differences() {
    everywhere(|interpreter, State { q, qd, qdd }| {
        let model = interpreter.model().clone();
        let n = model.nv();
        let found = interpreter.centroidal_derivatives(Motion { q, qd, qdd });
        let [momentum, rate] = [&found[..6], &found[6..12]];
        let columns = |matrix: usize| found[12..].chunks(6).skip(matrix * n).take(n);
        assert_close("momentum", momentum, &summed(interpreter, q, qd).momentum, EXACT);
        let expected = interpreter.centroidal_momentum_rate(Motion { q, qd, qdd }).expect(FINE);
        assert_close("rate", rate, &expected.components(), EXACT);
        let matrices = columns(0).zip(columns(1)).zip(columns(2));
        for (j, ((dmomentum_dq, drate_dq), drate_dqd)) in matrices.enumerate() {
            let unit: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i == j))).collect();
            let changed = |time: f64| {
                let sum = qd.iter().zip(&unit).map(|(qd, unit)| qd + time * unit);
                sum.collect::<Vec<f64>>()
            };
            let expected =
                derivative(|t| summed(interpreter, &moved(&model, q, t, &unit), qd).momentum);
            assert_close("momentum by q", dmomentum_dq, &expected, DIFFERENCES);
            let mut rate = |q: &[f64], qd: &[f64]| {
                interpreter
                    .centroidal_momentum_rate(Motion { q, qd, qdd })
                    .expect(FINE)
                    .components()
            };
            let expected = derivative(|t| rate(&moved(&model, q, t, &unit), qd));
            assert_close("rate by q", drate_dq, &expected, DIFFERENCES);
            let expected = derivative(|t| rate(q, &changed(t)));
            assert_close("rate by qd", drate_dqd, &expected, DIFFERENCES);
        }
    });
}

#[test]
fn momentum_of_a_free_robot_changes_by_gravity_alone() {
    use JointType::{Floating, Prismatic, Revolute, Spherical, Universal};
    let joints = [
        (Floating, None),
        (Revolute, Some(0)),
        (Spherical, Some(1)),
        (Prismatic, Some(0)),
        (Universal, Some(3)),
    ];
    let model = by_hand("diver", &joints, &[]);
    let mut interpreter = Interpreter::new(model.clone());
    for seed in 0..5 {
        let State { q, qd, qdd: mut tau } = State::random(seed, &model);
        // Joint torques do not change the momentum.
        tau[..6].fill(0.0);
        let qdd = interpreter.qdd(&q, &qd, &tau);
        let mass = summed(&mut interpreter, &q, &qd).mass;
        let state = State { q, qd, qdd };
        let found = derivative(|time| {
            let State { q, qd, .. } = state.after(&model, time);
            interpreter.centroidal_momentum(&q, &qd).expect(FINE).components()
        });
        let [x, y, z] = model.gravity().map(|g| mass * g);
        assert_close("m g", &found, &[x, y, z, 0.0, 0.0, 0.0], 1e-6);
    }
}

#[test]
fn without_mass_there_is_no_center() {
    let joint = Joint::new("joint", JointType::Revolute, [0.0, 0.0, 1.0], Pose::identity());
    let link =
        MovingLink { name: "link".into(), parent: None, joint, inertial: Inertial::default() };
    let model = Model::new("nothing", DEFAULT_GRAVITY, vec![link], Vec::new()).expect("a model");
    let mut interpreter = Interpreter::<f64>::new(model);
    let center = interpreter.center_of_mass(&[0.4]).expect(FINE);
    assert!(center.iter().all(|x| x.is_nan()), "{center:?}");
}

// Borders

#[test]
fn a_link_that_is_not_there_is_an_error() {
    let mut interpreter = Interpreter::<f64>::new(tree(3, 4));
    let (q, frames) = ([0.0; 4], interpreter.model().links().len());
    let missing = LinkError::NoLink { link: frames, count: frames };
    assert_eq!(interpreter.link_pose(&q, frames), Err(missing));
    assert_eq!(interpreter.link_velocity(&q, &q, frames), Err(missing));
    assert_eq!(interpreter.link_acceleration(&q, &q, &q, frames), Err(missing));
    assert_eq!(interpreter.jacobian(&q, frames, &mut [Twist::zero(); 4]), Err(missing));
    assert_eq!(interpreter.jacobian_dot_qd(&q, &q, frames), Err(missing));
    let message = format!("there is no link {frames}; the description has {frames}");
    assert_eq!(missing.to_string(), message);

    let shape = ShapeError::new("columns", 4, 3);
    let found = interpreter.jacobian_local(&q, 0, &mut [Twist::zero(); 3]);
    assert_eq!(found, Err(LinkError::Shape(shape)));
    assert_eq!(interpreter.center_of_mass_jacobian(&q, &mut [Vector3::zero(); 3]), Err(shape));
    assert_eq!(
        interpreter.model().link_index("link2").map(|i| &*interpreter.model().links()[i].name),
        Some("link2")
    );
    assert_eq!(interpreter.model().link_index("nobody"), None);
}

#[test]
fn calls_allocate_nothing() {
    everywhere(|interpreter, State { q, qd, qdd }| {
        let (frames, n) = (interpreter.model().links().len(), interpreter.model().nv());
        let (mut twists, mut vectors) = (vec![Twist::zero(); n], vec![Vector3::zero(); n]);
        let mut momenta = vec![Momentum::zero(); n];
        let (result, allocated) = measure(|| {
            for frame in 0..frames {
                interpreter.link_pose(q, frame)?;
                interpreter.link_velocity(q, qd, frame)?;
                interpreter.link_velocity_local(q, qd, frame)?;
                interpreter.link_acceleration(q, qd, qdd, frame)?;
                interpreter.link_acceleration_local(q, qd, qdd, frame)?;
                interpreter.jacobian(q, frame, &mut twists)?;
                interpreter.jacobian_local(q, frame, &mut twists)?;
                interpreter.jacobian_dot_qd(q, qd, frame)?;
                interpreter.jacobian_dot_qd_local(q, qd, frame)?;
            }
            interpreter.center_of_mass(q)?;
            interpreter.center_of_mass_jacobian(q, &mut vectors)?;
            interpreter.centroidal_momentum_matrix(q, &mut momenta)?;
            interpreter.centroidal_momentum(q, qd)?;
            interpreter.centroidal_momentum_rate(Motion { q, qd, qdd })?;
            Ok::<_, LinkError>(())
        });
        assert_eq!((result, allocated.calls), (Ok(()), 0));
    });
}

// Compiled

#[test]
fn a_link_depends_on_its_chain_alone() {
    let model = golden::model(&golden::urdf("solo12"));
    let frame = model.link_index("HR_FOOT").expect("a foot");
    let mut own = Vec::new();
    let mut at = model.links()[frame].moving_link;
    while let Some(i) = at {
        own.push(i);
        at = model.moving_links()[i].parent;
    }
    assert_eq!(own.len(), 3, "joints of a leg");
    let mut mechanism = Mechanism::new(&model);
    let link = LinkFrame::Known(mechanism.frames[frame]);
    mechanism.frames.clear();
    let tracer = Tracer::with_link(&mechanism, link);
    let n = model.nv();
    for (function, most) in [
        (Function::LinkPose, 27),
        (Function::Jacobian, 29),
        (Function::LinkVelocity, 36),
        (Function::LinkAcceleration, 77),
        (Function::JacobianDotQd, 60),
        (Function::JacobianLocal, 20),
        (Function::LinkVelocityLocal, 20),
        (Function::LinkAccelerationLocal, 65),
        (Function::JacobianDotQdLocal, 31),
    ] {
        let (what, graph) = (function.name(), tracer.evaluation(function, &model, None));
        // No node has a forbidden input, not even a node that no result needs.
        for node in graph.nodes() {
            if let Node::Input(input) = node {
                let joint = *input as usize % n;
                let there = own.contains(&joint);
                assert!(
                    there || graph.uses()[graph.find(*node).expect("it") as usize] == 0,
                    "{what}: {joint}"
                );
            }
        }
        let angles = graph.nodes().iter().filter(|node| matches!(node, Node::Sin(_))).count();
        assert!(angles <= own.len(), "{what}: {angles} sines");
        let count = optimize(graph).count();
        assert!(count.multiplications + count.additions <= most, "{what}: {count}");
    }
}
