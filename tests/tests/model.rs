//! The errors of models and module trees, and the data that they keep.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::ModelErrorKind::{
    Axis, DuplicateName, JointDynamics as JointDynamicsError, Mimic as MimicError, NoJoint,
    NotFinite, Order, Parent, Rotation, SecondAxis,
};
use modyn_runtime::model::{
    DEFAULT_GRAVITY, Inertial, InertialDefect, Joint, JointDynamics, JointFriction, JointReference,
    Link, Mimic, Model, ModelErrorKind, ModuleError, ModuleTree, MovingLink, SoftConstraints,
    Spring,
};
use modyn_runtime::spatial::Pose;
use modyn_tests::cases::{cases, robots};
use modyn_tests::random::{modules, with_tendons};
use proptest::prelude::*;

/// The parts of a model, to be made invalid.
#[derive(Clone)]
struct Parts {
    gravity: [f64; 3],
    links: Vec<MovingLink>,
    frames: Vec<Link>,
}

fn link(name: &str, parent: Option<usize>) -> MovingLink {
    MovingLink {
        name: name.into(),
        parent,
        joint: Joint::new(
            format!("{name}_joint"),
            JointType::Revolute,
            [0.0, 0.0, 1.0],
            Pose { translation: [0.3, 0.0, 0.0], ..Pose::identity() },
        ),
        inertial: Inertial {
            mass: 1.0,
            center_of_mass: [0.1, 0.0, 0.0],
            inertia: [0.1, 0.0, 0.0, 0.1, 0.0, 0.1],
        },
    }
}

/// ```text
/// base - a - b - c
///             \- d
/// ```
fn parts() -> Parts {
    let links = vec![link("a", None), link("b", Some(0)), link("c", Some(1)), link("d", Some(1))];
    let frame = |(name, link): (&str, _)| Link {
        name: name.into(),
        moving_link: link,
        pose: Pose::identity(),
        inertial: Inertial::default(),
    };
    let frames = [("base", None), ("a", Some(0)), ("b", Some(1)), ("c", Some(2)), ("d", Some(3))];
    Parts { gravity: DEFAULT_GRAVITY, links, frames: frames.map(frame).to_vec() }
}

fn model() -> Model {
    make(parts()).expect("a model")
}

fn make(parts: Parts) -> Result<Model, Vec<(String, ModelErrorKind)>> {
    let Parts { gravity, links, frames } = parts;
    Model::new("robot", gravity, links, frames).map_err(|errors| {
        for error in &errors {
            let message = error.to_string();
            assert!(message.starts_with(&format!("`{}` ", error.name)), "{message}");
        }
        errors.into_iter().map(|error| (error.name, error.kind)).collect()
    })
}

/// Asserts that the changed parts are refused for exactly these reasons.
#[track_caller]
fn assert_refused(break_them: impl FnOnce(&mut Parts), expected: &[(&str, ModelErrorKind)]) {
    let mut parts = parts();
    break_them(&mut parts);
    let errors = make(parts).expect_err("something is broken");
    let errors: Vec<_> = errors.iter().map(|(name, kind)| (name.as_str(), *kind)).collect();
    assert_eq!(errors, expected);
}

#[test]
fn a_model_keeps_its_parts() {
    let model = model();
    assert_eq!(
        (model.name(), model.gravity(), model.nq(), model.nv()),
        ("robot", DEFAULT_GRAVITY, 4, 4)
    );
    assert_eq!(model.moving_links(), parts().links);
    assert_eq!(model.links(), parts().frames);
    assert_eq!(model.children(), [vec![1], vec![2, 3], vec![], vec![]]);
}

#[test]
fn no_joint() {
    let nothing = |p: &mut Parts| {
        p.links.clear();
        p.frames.truncate(1);
    };
    assert_refused(nothing, &[("robot", NoJoint)]);
}

#[test]
fn duplicate_names() {
    assert_refused(|p| p.links[2].name = "a".into(), &[("a", DuplicateName)]);
    assert_refused(|p| p.links[2].joint.name = "a_joint".into(), &[("a_joint", DuplicateName)]);
    assert_refused(|p| p.frames[2].name = "base".into(), &[("base", DuplicateName)]);
    // A link and a joint may have the same name.
    let mut same = parts();
    same.links[0].joint.name = "a".into();
    assert!(make(same).is_ok());
}

#[test]
fn parents() {
    assert_refused(|p| p.links[3].parent = Some(3), &[("d", Parent)]);
    assert_refused(|p| p.links[3].parent = Some(usize::MAX), &[("d", Parent)]);
    assert_refused(|p| p.frames[0].moving_link = Some(4), &[("base", Parent)]);
}

#[test]
fn order() {
    // With d attached to a, the branch of b and c is complete.
    let late = |p: &mut Parts| {
        p.links[3].parent = Some(0);
        p.links.push(link("e", Some(2)));
    };
    assert_refused(late, &[("e", Order)]);
    // A second branch on the world is valid.
    let mut second = parts();
    second.links[3].parent = None;
    assert!(make(second).is_ok());
}

#[test]
fn numbers_that_are_not_finite() {
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_refused(|p| p.gravity[1] = x, &[("robot", NotFinite)]);
        assert_refused(|p| p.links[1].joint.axis[0] = x, &[("b", NotFinite)]);
        assert_refused(|p| p.links[1].joint.origin.translation[0] = x, &[("b", NotFinite)]);
        assert_refused(|p| p.links[1].joint.origin.rotation[2][1] = x, &[("b", NotFinite)]);
        assert_refused(|p| p.links[1].joint.second_axis[2] = x, &[("b", NotFinite)]);
        assert_refused(|p| p.links[1].joint.dynamics.armature = x, &[("b", NotFinite)]);
        assert_refused(|p| p.links[1].joint.dynamics.damping = x, &[("b", NotFinite)]);
        assert_refused(|p| p.links[1].joint.dynamics.friction = x, &[("b", NotFinite)]);
        let follow = |multiplier, offset| Some(Mimic { leader: 0, multiplier, offset });
        assert_refused(|p| p.links[1].joint.mimic = follow(x, 0.0), &[("b", NotFinite)]);
        assert_refused(|p| p.links[1].joint.mimic = follow(1.0, x), &[("b", NotFinite)]);
        assert_refused(|p| p.links[1].inertial.mass = x, &[("b", NotFinite)]);
        assert_refused(|p| p.links[1].inertial.center_of_mass[2] = x, &[("b", NotFinite)]);
        assert_refused(|p| p.links[1].inertial.inertia[5] = x, &[("b", NotFinite)]);
        assert_refused(|p| p.frames[2].pose.translation[0] = x, &[("b", NotFinite)]);
        assert_refused(|p| p.frames[2].pose.rotation[0][0] = x, &[("b", NotFinite)]);
    }
}

#[test]
fn axes() {
    for axis in [[0.0; 3], [0.0, 0.0, 2.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0 + 1e-6]] {
        assert_refused(|p| p.links[1].joint.axis = axis, &[("b_joint", Axis)]);
    }
}

#[test]
fn second_axes() {
    let universal = |axis| {
        move |p: &mut Parts| {
            p.links[1].joint.joint_type = JointType::Universal;
            p.links[1].joint.second_axis = axis;
        }
    };
    for axis in [[0.0; 3], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] {
        assert_refused(universal(axis), &[("b_joint", SecondAxis)]);
        // Other joint types ignore the second axis.
        let mut other = parts();
        other.links[1].joint.second_axis = axis;
        assert!(make(other).is_ok());
    }
    // The second axis need not be perpendicular to the first.
    let mut slanted = parts();
    universal([0.0, 0.6, 0.8])(&mut slanted);
    assert_eq!(make(slanted).expect("a model").nv(), 5);
}

#[test]
fn joint_dynamics() {
    for dynamics in [
        JointDynamics { armature: -1e-9, ..JointDynamics::default() },
        JointDynamics { damping: -1.0, ..JointDynamics::default() },
        JointDynamics { friction: -1.0, ..JointDynamics::default() },
    ] {
        assert_refused(
            |p| p.links[1].joint.dynamics = dynamics,
            &[("b_joint", JointDynamicsError)],
        );
    }
}

#[test]
fn springs_and_gravity_compensation() {
    let mut parts = parts();
    parts.links[1].joint.joint_type = JointType::Spherical;
    let model = make(parts).expect("a model");
    let spring = |link, stiffness, reference: &[f64]| Spring {
        link,
        stiffness,
        reference: reference.to_vec(),
    };
    let kinds = |springs: &[Spring]| {
        let errors = model.clone().with_springs(springs.to_vec()).expect_err("refused");
        errors.into_iter().map(|error| (error.name, error.kind)).collect::<Vec<_>>()
    };
    let bad = |name: &str| vec![(name.to_string(), ModelErrorKind::Spring)];
    assert_eq!(kinds(&[spring(4, 1.0, &[0.0])]), bad(model.name()));
    assert_eq!(kinds(&[spring(0, -1.0, &[0.0])]), bad("a_joint"));
    assert_eq!(kinds(&[spring(0, 1.0, &[])]), bad("a_joint"));
    assert_eq!(kinds(&[spring(1, 1.0, &[0.0, 0.0, 0.0, 1.1])]), bad("b_joint"));
    assert_eq!(kinds(&[spring(0, 1.0, &[0.0]), spring(0, 2.0, &[0.0])]), bad("a_joint"));
    let not_finite = vec![("a_joint".to_string(), NotFinite)];
    assert_eq!(kinds(&[spring(0, f64::NAN, &[0.0])]), not_finite);
    assert_eq!(kinds(&[spring(0, 1.0, &[f64::INFINITY])]), not_finite);

    let springs = vec![spring(1, 2.0, &[0.6, 0.0, 0.0, 0.8]), spring(0, 0.0, &[0.3])];
    let sprung = model.clone().with_springs(springs.clone()).expect("sound");
    assert_eq!((sprung.springs(), sprung.spring(0)), (&*springs, Some(&springs[1])));
    assert_eq!(sprung.spring(2), None);

    for (factors, kind) in
        [(vec![1.0; 4], ModelErrorKind::GravityCompensation), (vec![f64::NAN; 5], NotFinite)]
    {
        let errors = model.clone().with_gravity_compensation(factors).expect_err("refused");
        assert_eq!(errors.iter().map(|error| error.kind).collect::<Vec<_>>(), [kind]);
    }
    for factors in [vec![], vec![0.0, 1.0, -0.5, 0.0, 2.0]] {
        let compensated = sprung.clone().with_gravity_compensation(factors.clone());
        assert_eq!(compensated.expect("sound").gravity_compensation(), factors);
    }
}

#[test]
fn tendons_and_couplings() {
    let good = with_tendons(model(), 1);
    let joints = good.soft_constraints().tendons[0].length.joints.len();
    assert!(joints > 1 && good.soft_constraints().couplings.len() == 1);
    let kinds = |change: &dyn Fn(&mut SoftConstraints)| {
        let mut soft = good.soft_constraints().clone();
        change(&mut soft);
        let errors = good.clone().with_soft_constraints(soft).expect_err("refused");
        errors.into_iter().map(|error| (error.name, error.kind)).collect::<Vec<_>>()
    };
    let of = |name: &str, kind| vec![(name.to_string(), kind)];
    let of_tendon = |kind| of("tendon0", kind);
    assert_eq!(
        kinds(&|soft| soft.tendons[0].length.joints[1].link = 9),
        of_tendon(ModelErrorKind::Transmission)
    );
    assert_eq!(kinds(&|soft| soft.tendons[0].length.offset = f64::NAN), of_tendon(NotFinite));
    assert_eq!(kinds(&|soft| soft.tendons[0].margin = f64::INFINITY), of_tendon(NotFinite));
    assert_eq!(kinds(&|soft| soft.tendons[0].range = Some([0.0, f64::NAN])), of_tendon(NotFinite));
    let negative = of_tendon(ModelErrorKind::Tendon);
    assert_eq!(kinds(&|soft| soft.tendons[0].dry_friction = -1.0), negative);
    assert_eq!(kinds(&|soft| soft.tendons[0].spring.stiffness = -1.0), negative);
    assert_eq!(kinds(&|soft| soft.tendons[0].spring.damping = -1.0), negative);
    assert_eq!(kinds(&|soft| soft.tendons[0].spring.rest = [1.0, 0.0]), negative);
    assert_eq!(kinds(&|soft| soft.tendons[0].range = Some([1.0, 0.0])), negative);
    let of_coupling = |kind| of("coupling", kind);
    assert_eq!(
        kinds(&|soft| soft.couplings[0].sums[1].joints[0].link = 9),
        of_coupling(ModelErrorKind::Transmission)
    );
    assert_eq!(kinds(&|soft| soft.couplings[0].polynomial[4] = f64::NAN), of_coupling(NotFinite));
    let reference = |joint, coordinate| {
        kinds(&|soft| soft.references = vec![JointReference { joint, coordinate }])
    };
    assert_eq!(reference(0, f64::NAN), of("a_joint", NotFinite));
    assert_eq!(reference(9, 0.0), of(good.name(), ModelErrorKind::JointSoftness));
}

#[test]
fn numbers_of_the_whole_model() {
    for width in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        let errors =
            model().with_joint_friction(JointFriction::Smooth(width)).expect_err("no velocity");
        assert_eq!(
            errors.iter().map(|e| e.kind).collect::<Vec<_>>(),
            [ModelErrorKind::JointFriction]
        );
    }
    let errors = model().with_gravity([0.0, f64::NAN, 0.0]).expect_err("not finite");
    assert_eq!(errors.iter().map(|e| e.kind).collect::<Vec<_>>(), [NotFinite]);
    let model = model()
        .with_joint_friction(JointFriction::Smooth(0.1))
        .and_then(|m| m.with_gravity([0.0; 3]));
    let model = model.expect("sound");
    assert_eq!((model.joint_friction(), model.gravity()), (JointFriction::Smooth(0.1), [0.0; 3]));
}

#[test]
fn joints_that_follow() {
    let follow = |leader| Some(Mimic { leader, multiplier: 2.0, offset: 1.0 });
    assert_refused(|p| p.links[1].joint.mimic = follow(1), &[("b_joint", MimicError)]);
    assert_refused(|p| p.links[1].joint.mimic = follow(4), &[("b_joint", MimicError)]);
    let circle = |p: &mut Parts| {
        p.links[1].joint.mimic = follow(2);
        p.links[2].joint.mimic = follow(1);
    };
    assert_refused(circle, &[("b_joint", MimicError), ("c_joint", MimicError)]);
    for (follower, leader) in [(1, 2), (2, 1)] {
        let several = |p: &mut Parts| {
            p.links[2].joint.joint_type = JointType::Planar;
            p.links[follower].joint.mimic = follow(leader);
        };
        let name = ["b_joint", "c_joint"][follower - 1];
        assert_refused(several, &[(name, MimicError)]);
    }
    // A chain of mimic joints, against the order of the links.
    let mut chain = parts();
    chain.links[0].joint.mimic = follow(1);
    chain.links[1].joint.mimic = follow(3);
    let model = make(chain).expect("a model");
    assert_eq!((model.nq(), model.nv(), model.has_mimics()), (2, 2, true));
    assert_eq!(model.mimic(0), Some(Mimic { leader: 3, multiplier: 4.0, offset: 3.0 }));
    assert_eq!(model.mimic(1), follow(3));
    assert_eq!((model.mimic(2), model.mimic(3)), (None, None));
    assert_eq!([0, 1, 2, 3].map(|i| model.v_range(i)), [1..2, 1..2, 0..1, 1..2]);
    assert_eq!(model.coordinate_names(), ["c_joint", "d_joint"]);
}

#[test]
fn joints_of_several_coordinates() {
    let mut parts = parts();
    let types =
        [JointType::Floating, JointType::Spherical, JointType::Planar, JointType::Universal];
    for (link, joint_type) in parts.links.iter_mut().zip(types) {
        link.joint.joint_type = joint_type;
    }
    let model =
        make(parts).expect("a model").with_joint_friction(JointFriction::Viscous).expect("sound");
    assert_eq!((model.nq(), model.nv(), model.has_mimics()), (16, 14, false));
    assert_eq!(model.joint_friction(), JointFriction::Viscous);
    assert_eq!([0, 1, 2, 3].map(|i| model.q_range(i)), [0..7, 7..11, 11..14, 14..16]);
    assert_eq!([0, 1, 2, 3].map(|i| model.v_range(i)), [0..6, 6..9, 9..12, 12..14]);
    let names = model.coordinate_names();
    assert_eq!(names[..4], ["a_joint.x", "a_joint.y", "a_joint.z", "a_joint.qx"]);
    assert_eq!(names[13..], ["c_joint.angle", "d_joint.first", "d_joint.second"]);
    let names = model.velocity_names();
    assert_eq!(names[3..8], ["a_joint.wx", "a_joint.wy", "a_joint.wz", "b_joint.wx", "b_joint.wy"]);
}

#[test]
fn rotations() {
    let mirrored = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    let scaled = [[2.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 1.0]];
    let sheared = [[1.0, 1e-3, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let skewed = [[1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.25]];
    for rotation in [mirrored, scaled, sheared, skewed, [[0.0; 3]; 3]] {
        assert_refused(|p| p.links[1].joint.origin.rotation = rotation, &[("b_joint", Rotation)]);
        assert_refused(|p| p.frames[2].pose.rotation = rotation, &[("b", Rotation)]);
    }
}

#[test]
fn rotations_sheared_along_their_last_axis() {
    // The rows' determinant is 1 and the first two are orthonormal.
    let sheared = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.1, 0.0, 1.0]];
    assert_refused(|p| p.links[1].joint.origin.rotation = sheared, &[("b_joint", Rotation)]);
    assert_refused(|p| p.frames[2].pose.rotation = sheared, &[("b", Rotation)]);
}

#[test]
fn all_defects_at_once() {
    let several = |p: &mut Parts| {
        p.links[0].joint.axis = [0.0; 3];
        p.links[1].inertial.mass = f64::NAN;
        p.frames[0].moving_link = Some(9);
    };
    assert_refused(several, &[("a_joint", Axis), ("b", NotFinite), ("base", Parent)]);
}

#[test]
fn inertial_defects() {
    let with = |mass, inertia| Inertial { mass, center_of_mass: [0.0; 3], inertia }.defect();
    assert_eq!(with(1.0, [0.1, 0.0, 0.0, 0.1, 0.0, 0.1]), None);
    assert_eq!(with(0.0, [0.0; 6]), None);
    // An ideal thin rod is the limit of physical inertias.
    assert_eq!(with(1.0, [0.0, 0.0, 0.0, 0.1, 0.0, 0.1]), None);
    assert_eq!(with(-1.0, [0.0; 6]), Some(InertialDefect::NegativeMass(-1.0)));
    let massless = with(0.0, [0.1, 0.0, 0.0, 0.1, 0.0, 0.1]);
    assert_eq!(massless, Some(InertialDefect::InertiaWithoutMass));
    let moments = |defect| match defect {
        Some(
            InertialDefect::NotPositiveSemidefinite(x) | InertialDefect::TriangleInequality(x),
        ) => x,
        other => panic!("{other:?}"),
    };
    // 0.1 and -0.1 on a diagonal, rotated by 45 degrees.
    let negative = with(1.0, [0.0, 0.1, 0.0, 0.0, 0.0, 0.1]);
    assert!(matches!(negative, Some(InertialDefect::NotPositiveSemidefinite(_))));
    modyn_tests::close::assert_close("moments", &moments(negative), &[-0.1, 0.1, 0.1], 1e-12);
    let triangle = with(1.0, [0.1, 0.0, 0.0, 0.3, 0.0, 0.1]);
    assert!(matches!(triangle, Some(InertialDefect::TriangleInequality(_))));
    modyn_tests::close::assert_close("moments", &moments(triangle), &[0.1, 0.1, 0.3], 1e-12);
}

#[test]
fn modules_of_the_whole_tree() {
    let model = model();
    let links = |tree: &ModuleTree| -> Vec<_> {
        tree.modules().iter().map(|m| (m.links.clone(), m.parent)).collect()
    };
    let chains = ModuleTree::chains(&model);
    assert_eq!(links(&chains), [(0..2, None), (2..3, Some(0)), (3..4, Some(0))]);
    assert_eq!(chains.modules()[0].children, [1, 2]);
    let single = ModuleTree::links(&model);
    assert_eq!(links(&single), [(0..1, None), (1..2, Some(0)), (2..3, Some(1)), (3..4, Some(1))]);
    let named = ModuleTree::from_names(&model, &[vec!["d"], vec!["a", "b"], vec!["c"]]);
    assert_eq!(named, Ok(chains));
}

/// Asserts that the module list is refused for these reasons.
#[track_caller]
fn assert_no_partition(list: &[&[&str]], expected: &[ModuleError]) {
    let list: Vec<Vec<&str>> = list.iter().map(|module| module.to_vec()).collect();
    let errors = ModuleTree::from_names(&model(), &list).expect_err("no partition");
    assert_eq!(errors, expected);
    assert!(errors.iter().all(|error| !error.to_string().is_empty()));
}

#[test]
fn unknown_links() {
    let links = ["a", "b", "c", "d"].map(String::from).to_vec();
    let unknown = ModuleError::UnknownLink { name: "e".into(), links };
    assert!(unknown.to_string().contains("`e`") && unknown.to_string().contains("a, b, c, d"));
    assert_no_partition(&[&["a", "b"], &["c"], &["d"], &["e"]], &[unknown]);
}

#[test]
fn links_in_two_modules_or_in_none() {
    let twice = ModuleError::Twice("c".into());
    assert_no_partition(&[&["a", "b"], &["c"], &["d"], &["c"]], &[twice]);
    let missing = ["c", "d"].map(|name| ModuleError::Missing(name.into()));
    assert_no_partition(&[&["a", "b"]], &missing);
    assert_no_partition(&[], &["a", "b", "c", "d"].map(|name| ModuleError::Missing(name.into())));
}

#[test]
fn modules_that_are_no_chain() {
    let not_serial = |before: &str, link: &str, parent: &str| ModuleError::NotSerial {
        before: before.into(),
        link: link.into(),
        parent: parent.into(),
    };
    assert_no_partition(&[&["b", "a"], &["c"], &["d"]], &[not_serial("b", "a", "the base")]);
    assert_no_partition(&[&["a"], &["b"], &["c", "d"]], &[not_serial("c", "d", "b")]);
    let inside = ModuleError::BranchInside { at: "b".into(), leaving: "d".into() };
    assert_no_partition(&[&["a", "b", "c"], &["d"]], &[inside]);
    assert_no_partition(&[&["a", "b"], &["c"], &[], &["d"]], &[ModuleError::Empty]);
}

#[test]
fn a_broken_model_is_not_deserialized() {
    let mut json = serde_json::to_value(model()).expect("plain data");
    json["moving_links"][1]["joint"]["axis"] = serde_json::json!([0.0, 0.0, 0.0]);
    json["links"][0]["moving_link"] = serde_json::json!(9);
    let error = serde_json::from_value::<Model>(json).expect_err("no axis").to_string();
    assert!(
        error.contains("`b_joint` has an axis") && error.contains("`base` has a parent"),
        "{error}"
    );
    let mut json = serde_json::to_value(model()).expect("plain data");
    json["joint_friction"] = serde_json::json!({ "Smooth": -0.1 });
    let error = serde_json::from_value::<Model>(json).expect_err("no velocity").to_string();
    assert!(error.contains("smooth friction"), "{error}");
}

#[test]
fn optional_fields_can_be_left_out() {
    let mut json = serde_json::to_value(model()).expect("plain data");
    for part in ["joint_friction", "loop_constraints"] {
        json.as_object_mut().expect("an object").remove(part).expect("written");
    }
    assert_eq!(serde_json::from_value::<Model>(json).expect("a model"), model());
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn a_model_survives_json(robot in robots(20)) {
        let model = robot.model();
        let json = serde_json::to_string(&model).expect("plain data");
        let back: Model = serde_json::from_str(&json).expect("the same data");
        prop_assert_eq!(back, model);
    }

    #[test]
    fn modules_are_a_tree_of_chains(robot in robots(30)) {
        let model = robot.model();
        let [chains, links] = [ModuleTree::chains, ModuleTree::links].map(|by| by(&model));
        let trees = [chains, links, modules(robot.seed(), &model)];
        for tree in trees {
            let mut next = 0;
            for (m, module) in tree.modules().iter().enumerate() {
                prop_assert_eq!(module.links.start, next);
                next = module.links.end;
                let leaves = model.moving_links()[module.links.start].parent;
                let parent = module.parent.map(|p| &tree.modules()[p]);
                prop_assert_eq!(leaves, parent.map(|parent| parent.links.end - 1));
                prop_assert!(parent.is_none_or(|parent| parent.children.contains(&m)));
                for i in module.links.clone().skip(1) {
                    prop_assert_eq!(model.moving_links()[i].parent, Some(i - 1));
                }
            }
            prop_assert_eq!(next, model.moving_links().len());
            // The names of a tree's modules give the same tree again.
            let names: Vec<Vec<&str>> = tree.modules().iter().rev()
                .map(|m| m.links.clone().map(|i| model.moving_links()[i].name.as_str()).collect())
                .collect();
            prop_assert_eq!(ModuleTree::from_names(&model, &names), Ok(tree));
        }
    }
}
