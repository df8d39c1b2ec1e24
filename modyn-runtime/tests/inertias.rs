//! Inertias and payloads of the interpreter that change at run time.
#![cfg(feature = "alloc")]

use modyn_runtime::joint::JointType;
use modyn_runtime::mechanism::{inertia_without, rigid_inertia};
use modyn_runtime::model::{Joint, JointDynamics, Link, Mimic, Model, MovingLink};
use modyn_runtime::spatial::RigidInertia;
use modyn_runtime::{Inertial, InertialError, Interpreter, Pose, Scalar};

/// A fixed sequence of numbers in 0..1: SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn vector(&mut self) -> [f64; 3] {
        std::array::from_fn(|_| self.between(-0.5, 0.5))
    }

    fn axis(&mut self) -> [f64; 3] {
        let v = self.vector();
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.map(|x| x / length)
    }

    /// Returns a pose in general position.
    fn pose(&mut self) -> Pose<f64> {
        let q: [f64; 4] = std::array::from_fn(|_| self.between(0.2, 1.0));
        let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        let rotation = modyn_runtime::conventions::rotation_from_quaternion(q.map(|x| x / length));
        Pose { rotation, translation: self.vector() }
    }

    fn inertial(&mut self) -> Inertial {
        let [a, b, c] = self.vector();
        Inertial {
            mass: self.between(0.5, 5.0),
            center_of_mass: self.vector(),
            inertia: [0.25 + 0.1 * a * a, 0.01 * a, 0.01 * b, 0.3, 0.01 * c, 0.28 + 0.1 * b * b],
        }
    }
}

/// Returns a chain of these joints in general position; a tool is fixed to each link.
fn chain(seed: u64, joints: &[JointType]) -> Model {
    let mut random = Random(seed);
    let mut frames = Vec::new();
    let links = joints.iter().enumerate().map(|(i, joint_type)| {
        let mut joint = Joint::new(format!("joint{i}"), *joint_type, random.axis(), random.pose());
        joint.second_axis = random.axis();
        let (own, tool, pose) = (random.inertial(), random.inertial(), random.pose());
        let frame =
            |name: String, pose, inertial| Link { name, moving_link: Some(i), pose, inertial };
        frames.push(frame(format!("link{i}"), Pose::identity(), own));
        frames.push(frame(format!("tool{i}"), pose, tool));
        let inertial = own.merged(&tool.transformed(&pose));
        MovingLink { name: format!("link{i}"), parent: i.checked_sub(1), joint, inertial }
    });
    let links = links.collect();
    Model::new("chain", [0.3, -0.4, -9.6], links, frames).expect("sound parts")
}

const JOINTS: [JointType; 5] = [
    JointType::Floating,
    JointType::Revolute,
    JointType::Spherical,
    JointType::Prismatic,
    JointType::Universal,
];

/// Returns every number that depends on the inertias.
fn numbers<S: Scalar>(interpreter: &mut Interpreter<S>) -> Vec<S> {
    let (nq, nv) = (interpreter.model().nq(), interpreter.model().nv());
    let mut random = Random(99);
    let mut vector = |n| (0..n).map(|_| S::from_f64(random.between(-1.0, 1.0))).collect::<Vec<S>>();
    let (mut q, qd, tau) = (vector(nq), vector(nv), vector(nv));
    interpreter.normalize_configuration(&mut q).expect("the length");
    let mut all = vec![S::zero(); nv];
    interpreter.forward_dynamics(&q, &qd, &tau, &mut all).expect("lengths");
    let mut torques = vec![S::zero(); nv];
    interpreter.inverse_dynamics(&q, &qd, &tau, &mut torques).expect("lengths");
    let mut matrix = vec![S::zero(); nv * nv];
    interpreter.mass_matrix(&q, &mut matrix).expect("lengths");
    all.extend(torques);
    all.extend(matrix);
    all.push(interpreter.potential_energy(&q).expect("lengths"));
    all.push(interpreter.kinetic_energy(&q, &qd).expect("lengths"));
    all.extend(interpreter.center_of_mass(&q).expect("lengths"));
    all
}

/// Returns the model with other own inertias of these links.
fn described(model: &Model, changes: &[(usize, Inertial)]) -> Model {
    let mut frames = model.links().to_vec();
    changes.iter().for_each(|(frame, inertial)| frames[*frame].inertial = *inertial);
    let mut links = model.moving_links().to_vec();
    for (i, link) in links.iter_mut().enumerate() {
        let parts = frames.iter().filter(|frame| frame.moving_link == Some(i));
        link.inertial = parts.fold(Inertial::default(), |sum, frame| {
            sum.merged(&frame.inertial.transformed(&frame.pose))
        });
    }
    Model::new(model.name(), model.gravity(), links, frames).expect("sound parts")
}

#[test]
fn a_hundred_thousand_updates_leave_no_trace() {
    let model = chain(1, &JOINTS[..2]);
    let mut fresh = Interpreter::<f32>::new(model.clone());
    let mut adapted = fresh.clone();
    let mut random = Random(2);
    let mut last = Vec::new();
    for step in 0..100_000 {
        let frame = step % model.links().len();
        let mut inertial = random.inertial();
        // The masses go from light to heavy, as in an estimate that has not converged.
        inertial.mass *= 1e3;
        inertial.inertia = inertial.inertia.map(|x| x * 1e3);
        adapted.set_inertial(frame, &inertial.map(|x| x as f32)).expect("a body's");
        if step >= 100_000 - model.links().len() {
            last.push((frame, inertial));
        }
    }
    // The last values alone determine the results,
    let mut direct = fresh.clone();
    for (frame, inertial) in &last {
        direct.set_inertial(*frame, &inertial.map(|x| x as f32)).expect("a body's");
    }
    let bits = |x: Vec<f32>| x.into_iter().map(f32::to_bits).collect::<Vec<_>>();
    assert_eq!(bits(numbers(&mut adapted)), bits(numbers(&mut direct)));
    // and the inertias of the description restore the described robot.
    for (frame, described) in model.links().iter().enumerate() {
        adapted.set_inertial(frame, &described.inertial.map(|x| x as f32)).expect("a body's");
    }
    assert_eq!(bits(numbers(&mut adapted)), bits(numbers(&mut fresh)));
}

#[test]
fn changes_are_another_description() {
    for seed in 0..20 {
        let model = chain(seed, &JOINTS);
        let mut random = Random(seed + 100);
        let mut changed = Interpreter::<f64>::new(model.clone());
        let mut changes: Vec<(usize, Inertial)> = Vec::new();
        for _ in 0..6 {
            let frame = (random.next() * model.links().len() as f64) as usize;
            let (own, load) = (random.inertial(), random.inertial());
            changed.set_inertial(frame, &own).expect("a body's");
            changed.set_payload(frame, &load).expect("a body's");
            changes.push((frame, own.merged(&load)));
            let mut other = Interpreter::<f64>::new(described(&model, &changes));
            let pairs = std::iter::zip(numbers(&mut changed), numbers(&mut other));
            for (i, (found, expected)) in pairs.enumerate() {
                let close = (found - expected).abs() <= 1e-9 * expected.abs().max(1.0);
                assert!(close, "seed {seed}, number {i}: {found} instead of {expected}");
            }
        }
    }
}

/// Compensated weights are those of the present inertias, under the present gravity.
#[test]
fn compensated_weights_follow_inertias_and_gravity() {
    let compensated = |model: Model| {
        let factors = (0..model.links().len()).map(|i| 0.3 * i as f64 - 0.6).collect();
        model.with_gravity_compensation(factors).expect("a factor for each frame")
    };
    for seed in 0..5 {
        let model = chain(seed, &JOINTS);
        let mut random = Random(seed + 100);
        let mut changed = Interpreter::<f64>::new(compensated(model.clone()));
        assert_ne!(numbers(&mut changed), numbers(&mut Interpreter::new(model.clone())));
        let mut changes: Vec<(usize, Inertial)> = Vec::new();
        for _ in 0..6 {
            let frame = (random.next() * model.links().len() as f64) as usize;
            let (own, gravity) = (random.inertial(), random.vector().map(|x| 20.0 * x));
            changed.set_inertial(frame, &own).expect("a body's");
            changed.set_gravity(gravity);
            changes.push((frame, own));
            let other = described(&model, &changes).with_gravity(gravity).expect("finite");
            let mut other = Interpreter::<f64>::new(compensated(other));
            let pairs = std::iter::zip(numbers(&mut changed), numbers(&mut other));
            for (i, (found, expected)) in pairs.enumerate() {
                let close = (found - expected).abs() <= 1e-9 * expected.abs().max(1.0);
                assert!(close, "seed {seed}, number {i}: {found} instead of {expected}");
            }
        }
    }
}

#[test]
fn a_payload_is_added() {
    let model = chain(3, &JOINTS);
    let mut fresh = Interpreter::<f64>::new(model.clone());
    let expected = numbers(&mut fresh);
    let mut loaded = fresh.clone();
    loaded.set_payload(9, &Inertial::default()).expect("none");
    assert_eq!(numbers(&mut loaded), expected, "no payload changes nothing");
    loaded.set_payload(9, &Random(4).inertial()).expect("a body's");
    assert_ne!(numbers(&mut loaded), expected);
    loaded.set_payload(9, &Inertial::default()).expect("none");
    assert_eq!(numbers(&mut loaded), expected);
}

/// Returns the joint that `changed` would leave without inertia.
fn refused(changed: Result<(), InertialError>) -> String {
    match changed {
        Err(InertialError::NoInertia { joint }) => joint,
        other => panic!("{other:?}"),
    }
}

#[test]
fn no_joint_is_left_without_inertia() {
    let none = Inertial::default();
    for (joint_type, alone) in [
        (JointType::Revolute, none),
        (JointType::Prismatic, none),
        (JointType::Universal, none),
        (JointType::Spherical, none),
        // A point mass at the centre of a spherical joint, and at the centre of a floating joint.
        (JointType::Spherical, Inertial { mass: 1.0, ..none }),
        (JointType::Floating, Inertial { mass: 1.0, center_of_mass: [0.1, 0.2, 0.3], ..none }),
    ] {
        let model = chain(5, &[JointType::Revolute, joint_type]);
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let (link, tool) = (2, 3);
        interpreter.set_inertial(link, &none).expect("the tool is left");
        let before = numbers(&mut interpreter);
        let tool_alone = alone.transformed(&inverse(&model.links()[tool].pose));
        assert_eq!(refused(interpreter.set_inertial(tool, &tool_alone)), "joint1", "{alone:?}");
        assert_eq!(numbers(&mut interpreter), before, "nothing has changed");
        // A payload may give the joint its inertia; then the payload cannot be removed.
        let load = Random(6).inertial();
        interpreter.set_payload(link, &load).expect("a body's");
        interpreter.set_inertial(tool, &tool_alone).expect("the joint moves the payload");
        assert!(numbers(&mut interpreter).iter().all(|x| x.is_finite()));
        assert_eq!(refused(interpreter.set_payload(link, &none)), "joint1");
    }
}

/// Returns the inverse of a pose.
fn inverse(pose: &Pose<f64>) -> Pose<f64> {
    let r = &pose.rotation;
    let rotation = std::array::from_fn(|i| std::array::from_fn(|j| r[j][i]));
    let back = Pose { rotation, translation: [0.0; 3] };
    Pose { rotation, translation: back.rotate(pose.translation).map(|x| -x) }
}

#[test]
fn a_joint_does_not_move_a_point_mass_on_its_axis() {
    let none = Inertial::default();
    for seed in 0..50 {
        let model = chain(seed, &[JointType::Revolute, JointType::Revolute]);
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let mut single = Interpreter::<f32>::new(model.clone());
        interpreter.set_inertial(3, &none).expect("the link is left");
        single.set_inertial(3, &Inertial::default()).expect("the link is left");
        let at = |factor: f64, beside: f64| Inertial {
            mass: 2.0,
            center_of_mass: model.moving_links()[1].joint.axis.map(|x| x * factor + beside),
            ..none
        };
        // On the axis the moment of inertia consists of rounding errors.
        assert_eq!(refused(interpreter.set_inertial(2, &at(0.7, 0.0))), "joint1");
        let on_axis = at(0.7, 0.0).map(|x| x as f32);
        assert!(matches!(single.set_inertial(2, &on_axis), Err(InertialError::NoInertia { .. })));
        interpreter.set_inertial(2, &at(0.7, 0.01)).expect("beside the axis");
        single.set_inertial(2, &at(0.7, 0.05).map(|x| x as f32)).expect("beside the axis");
    }
}

#[test]
fn a_small_moment_of_inertia_is_no_rounding_of_the_mass() {
    let none = Inertial::default();
    for seed in 0..20 {
        let model = chain(seed, &[JointType::Revolute, JointType::Revolute]);
        let mut single = Interpreter::<f32>::new(model);
        single.set_inertial(3, &Inertial::default()).expect("the link is left");
        // A kilogram within 2 mm of its axis: the rounding of the mass is above its moment of inertia.
        let within = Inertial { mass: 1.0, inertia: [4e-6, 0.0, 0.0, 4e-6, 0.0, 4e-6], ..none };
        single.set_inertial(2, &within.map(|x| x as f32)).expect("a moment of inertia");
    }
}

#[test]
fn nothing_is_left_of_a_link_without_its_frames() {
    for seed in 0..20 {
        for size in [1e-3, 1.0, 1e3_f64] {
            // Rods along each axis, of which the difference of two moments of inertia is zero.
            for across in [[0, 3], [3, 5], [5, 0]] {
                let mut random = Random(seed);
                let frames = ["link", "tool", "camera"].map(|name| {
                    let mass = random.between(0.5, 5.0) * size.powi(3);
                    let mut inertial = Inertial { mass, ..Inertial::default() };
                    across.iter().for_each(|&i| inertial.inertia[i] = mass * size * size);
                    let mut pose = if name == "link" { Pose::identity() } else { random.pose() };
                    pose.translation = pose.translation.map(|x| 1e-3 * size * x);
                    Link { name: name.into(), moving_link: Some(0), pose, inertial }
                });
                let placed = frames.each_ref().map(|f| f.inertial.transformed(&f.pose));
                let inertial = placed[0].merged(&placed[1]).merged(&placed[2]);
                let joint =
                    Joint::new("joint", JointType::Revolute, [0.0, 0.0, 1.0], random.pose());
                let link = MovingLink { name: "link".into(), parent: None, joint, inertial };
                let model = Model::new("rods", [0.0; 3], vec![link], frames.into()).expect("sound");
                let left = inertia_without(&model, 0, |_| true);
                assert_eq!(left, RigidInertia::zero(), "seed {seed}, size {size}, rod {across:?}");
                let left = inertia_without(&model, 0, |frame| frame == 1);
                let expected = rigid_inertia(&placed[0].merged(&placed[2]));
                let close = |found: f64, expected: f64, unit: f64| {
                    assert!((found - expected).abs() <= 1e-12 * unit, "{found} {expected}");
                };
                let mass = expected.mass;
                close(left.mass, mass, mass);
                for i in 0..3 {
                    let [found, expected] = [&left, &expected].map(|x| x.first_moment.0[i]);
                    close(found, expected, mass * size);
                    assert!(found != 0.0, "the camera's first moment");
                }
                close(left.second_moment.zz, expected.second_moment.zz, mass * size * size);
            }
        }
    }
}

#[test]
fn inertia_is_needed_where_a_joint_moves_it() {
    // A link between joints about different lines needs no inertia; a link between joints about the same line does.
    let mut links = chain(7, &[JointType::Revolute; 3]).moving_links().to_vec();
    let frames = chain(7, &[JointType::Revolute; 3]).links().to_vec();
    let none = Inertial::default();
    let model = Model::new("oblique", [0.0; 3], links.clone(), frames.clone()).expect("sound");
    let mut interpreter = Interpreter::<f64>::new(model);
    interpreter.set_inertial(2, &none).expect("the tool is left");
    interpreter.set_inertial(3, &none).expect("joints about different lines");
    let axis = links[2].joint.axis;
    links[1].joint.axis = axis;
    links[2].joint.origin = Pose { translation: axis.map(|x| 0.3 * x), ..Pose::identity() };
    let model = Model::new("parallel", [0.0; 3], links.clone(), frames.clone()).expect("sound");
    let mut interpreter = Interpreter::<f64>::new(model);
    interpreter.set_inertial(2, &none).expect("the tool is left");
    assert_eq!(refused(interpreter.set_inertial(3, &none)), "joint1");
    // A rotor is enough, and so is a mimic joint that moves an inertia.
    links[1].joint.dynamics = JointDynamics { armature: 0.1, ..JointDynamics::default() };
    let model = Model::new("rotor", [0.0; 3], links.clone(), frames.clone()).expect("sound");
    let mut interpreter = Interpreter::<f64>::new(model);
    interpreter.set_inertial(2, &none).expect("the tool is left");
    interpreter.set_inertial(3, &none).expect("the joint moves the rotor");
    links[1].joint.dynamics = JointDynamics::default();
    links[2].joint.mimic = Some(Mimic { leader: 1, multiplier: -0.5, offset: 0.1 });
    let model = Model::new("mimic", [0.0; 3], links, frames).expect("sound");
    let mut interpreter = Interpreter::<f64>::new(model);
    for frame in 2..5 {
        interpreter.set_inertial(frame, &none).expect("the joint moves the last tool");
    }
    assert_eq!(refused(interpreter.set_inertial(5, &none)), "joint1");
}

#[test]
fn a_robot_without_inertia_keeps_its_defects() {
    // A model that is singular as described can be changed, if no further joint loses its inertia.
    let model = chain(8, &[JointType::Revolute; 2]);
    let none = Inertial::default();
    let massless = described(&model, &[(2, none), (3, none)]);
    let mut interpreter = Interpreter::<f64>::new(massless);
    interpreter.set_inertial(0, &Random(9).inertial()).expect("the first joint moves its link");
    interpreter.set_inertial(0, &none).expect("and its tool");
    assert_eq!(refused(interpreter.set_inertial(1, &none)), "joint0");
}

#[test]
fn a_mimic_joint_carries_inertia_for_its_leader() {
    let described = chain(7, &[JointType::Revolute, JointType::Revolute]);
    for mimics in [true, false] {
        let mut links = described.moving_links().to_vec();
        links[1].parent = None;
        let mimic = Mimic { leader: 0, multiplier: -0.7, offset: 0.2 };
        links[1].joint.mimic = mimics.then_some(mimic);
        let model = Model::new("pair", [0.0, 0.0, -9.8], links, described.links().to_vec());
        let mut interpreter = Interpreter::<f64>::new(model.expect("sound parts"));
        let none = Inertial::default();
        interpreter.set_inertial(0, &none).expect("the tool is left");
        let leader_alone = interpreter.set_inertial(1, &none);
        if mimics {
            leader_alone.expect("the mimic joint's link is left");
            assert!(numbers(&mut interpreter).iter().all(|x| x.is_finite()));
            interpreter.set_inertial(2, &none).expect("its tool is left");
            assert_eq!(refused(interpreter.set_inertial(3, &none)), "joint0");
        } else {
            assert_eq!(refused(leader_alone), "joint0");
        }
    }
}
