//! The random robots are the same on every host, and they vary in every property.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{JointDynamics, JointFriction, Model};
use modyn_tests::random::{State, chain, general_tree, general_zoo, state, tree, zoo};

/// Returns the FNV-1a hash of the bits of a model's and a state's numbers.
fn fingerprint(model: &Model) -> u64 {
    let State { q, qd, qdd, tau } = state(0, model);
    let links = model.moving_links().iter().flat_map(|link| {
        let parent = [link.parent.map_or(0.0, |_| 1.0)];
        let (joint, inertial) = (&link.joint, &link.inertial);
        [
            &parent[..],
            &joint.axis,
            &joint.origin.translation,
            &joint.origin.rotation.concat(),
            &[inertial.mass],
            &inertial.center_of_mass,
            &inertial.inertia,
        ]
        .concat()
    });
    let extras = model.moving_links().iter().flat_map(|link| {
        let JointDynamics { armature, damping, friction } = link.joint.dynamics;
        let mimic = link.joint.mimic.map_or([0.0; 2], |mimic| [mimic.multiplier, mimic.offset]);
        [&link.joint.second_axis[..], &[armature, damping, friction], &mimic].concat()
    });
    let frames = model
        .links()
        .iter()
        .flat_map(|frame| [frame.pose.rotation.concat(), frame.pose.translation.to_vec()].concat());
    let numbers = links.chain(frames).chain(extras).chain([q, qd, qdd, tau].concat());
    numbers.flat_map(|x| x.to_bits().to_le_bytes()).fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[test]
fn every_host_grows_the_same_robots() {
    let robots = [tree(1, 30), tree(2, 7), chain(3, 100), zoo(4, 20), zoo(10153, 8)];
    let expected = [
        "f07d58c48a211472",
        "eeef527b9671e558",
        "32d849d41570fc7d",
        "acde70e3be74ffd5",
        "b7e1cec9061b07e9",
    ];
    assert_eq!(robots.map(|robot| format!("{:016x}", fingerprint(&robot))), expected);
}

#[test]
fn the_same_seed_grows_the_same_robot() {
    assert_eq!(tree(5, 12), tree(5, 12));
    assert_ne!(tree(5, 12).moving_links(), tree(6, 12).moving_links());
}

#[test]
fn inertias_are_physical() {
    for seed in 0..100 {
        let model = tree(seed, 10);
        for link in model.moving_links() {
            assert_eq!(link.inertial.defect(), None, "seed {seed}, {}", link.name);
            assert!(link.inertial.mass > 0.0);
        }
    }
}

/// Asserts that some, but not all, of the links of many robots satisfy a condition.
#[track_caller]
fn assert_mixed(is_so: impl Fn(&Model, usize) -> bool) {
    let models: Vec<Model> = (0..50).map(|seed| tree(seed, 20)).collect();
    let links = models.iter().flat_map(|model| (0..20).map(|i| is_so(model, i)));
    let count = links.filter(|&so| so).count();
    assert!((20..=980).contains(&count), "{count} of 1000");
}

#[test]
fn robots_are_various() {
    let joint = |model: &Model, i: usize| model.moving_links()[i].joint.clone();
    for joint_type in [JointType::Revolute, JointType::Continuous, JointType::Prismatic] {
        assert_mixed(|model, i| joint(model, i).joint_type == joint_type);
    }
    let on_axis = |axis: [f64; 3]| axis.iter().filter(|&&x| x == 0.0).count() == 2;
    let entries = |rotation: [[f64; 3]; 3]| rotation.concat();
    assert_mixed(|model, i| on_axis(joint(model, i).axis));
    assert_mixed(|model, i| joint(model, i).axis.contains(&-1.0));
    assert_mixed(|model, i| joint(model, i).origin.translation == [0.0; 3]);
    assert_mixed(|model, i| {
        joint(model, i).origin.rotation == [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    });
    assert_mixed(|model, i| {
        entries(joint(model, i).origin.rotation).iter().all(|x| x.fract() == 0.0)
    });
    assert_mixed(|model, i| !entries(joint(model, i).origin.rotation).contains(&0.0));
    assert_mixed(|model, i| joint(model, i).limits.is_some());
    assert_mixed(|model, i| model.children()[i].len() > 1);
    assert_mixed(|model, i| model.moving_links()[i].parent.is_none());
    assert_mixed(|model, i| model.links().iter().any(|f| f.name == format!("fixed{i}")));
    let serial = (0..50).filter(|&seed| {
        let model = tree(seed, 20);
        model.moving_links().iter().enumerate().all(|(i, link)| link.parent == i.checked_sub(1))
    });
    assert!((5..=45).contains(&serial.count()));
}

#[test]
fn zoos_have_all_there_is() {
    let zoos: Vec<Model> = (0..50).map(|seed| zoo(seed, 10)).collect();
    let count = |is_so: &dyn Fn(&Model) -> bool| zoos.iter().filter(|model| is_so(model)).count();
    for joint_type in JointType::ALL {
        let has =
            |model: &Model| model.moving_links().iter().any(|l| l.joint.joint_type == joint_type);
        assert!((20..=50).contains(&count(&has)), "{joint_type:?}");
    }
    assert!((10..=40).contains(&count(&Model::has_mimics)));
    let driven = |model: &Model| {
        model.moving_links().iter().any(|l| l.joint.dynamics != JointDynamics::default())
    };
    assert!((20..=45).contains(&count(&driven)));
    assert!((5..=30).contains(&count(&|model| model.joint_friction() == JointFriction::Viscous)));
    assert!(
        (5..=30)
            .contains(&count(&|model| matches!(model.joint_friction(), JointFriction::Smooth(_))))
    );
}

/// No entry of an axis, a rotation or a translation is near 0 or 1 in magnitude.
#[test]
fn general_robots_have_nothing_special() {
    for seed in 0..50 {
        for model in [general_tree(seed, 10), general_zoo(seed, 5)] {
            let poses = model.moving_links().iter().map(|link| link.joint.origin);
            let fixed = model.links().iter().filter(|link| link.name.starts_with("fixed"));
            for pose in poses.chain(fixed.map(|frame| frame.pose)) {
                let entries = [pose.rotation.concat(), pose.translation.to_vec()].concat();
                assert!(entries.iter().all(|x| x.abs() > 1e-6 && (1.0 - x.abs()) > 1e-9), "{seed}");
            }
            for link in model.moving_links() {
                for axis in [link.joint.axis, link.joint.second_axis] {
                    assert!(axis.iter().all(|x| x.abs() > 1e-6), "{seed}: {axis:?}");
                }
            }
        }
    }
}
