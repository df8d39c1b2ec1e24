//! The option `embed_model`: a type returns the model that was read, with the options about reading.

use modyn::EmbeddedModel;
use modyn_codegen::{
    Base, Builder, Contact, ContactKind, Function, JointFriction, LoopEnd, Mimic, Rotor,
};
use modyn_runtime::Interpreter;

modyn::modyn! {
    pub(crate) JointZoo = "../../../robots/joint_zoo.urdf",
    functions = [potential_energy],
    gravity = [0.5, -1.5, -9.0],
    joint_friction = smooth(0.02),
    embed_model = true,
}
modyn::modyn! {
    MimicGripper = "../../../robots/mimic_gripper.urdf",
    functions = [potential_energy],
    embed_model = true,
}
modyn::modyn! {
    Quadruped = "../../../robots/quadruped.urdf",
    functions = [potential_energy],
    base = floating,
    rotors = ["front_left_knee": (0.0001, 9)],
    contacts = ["toe": point("front_left_foot", [0.01, 0.02, -0.3], [0.1, 0.2, 0.3])],
    embed_model = true,
}
modyn::modyn! {
    FiveBar = "../../../robots/five_bar.urdf",
    functions = [potential_energy],
    embed_model = true,
}

fn read(name: &str) -> Builder {
    let robots = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots");
    Builder::new().urdf(robots.join(format!("{name}.urdf"))).functions([Function::PotentialEnergy])
}

/// Compares the model of a type with that of the description.
fn check<R: EmbeddedModel>(expected: &Builder) {
    let expected = expected.plan().expect("good").model;
    assert_eq!(R::model(), expected);
    // A compiler takes the type as it takes the file.
    let again = Builder::new().robot::<R>().functions([Function::PotentialEnergy]);
    assert_eq!(again.plan().expect("good").model, expected);
}

#[test]
fn types_have_their_models() {
    let zoo = read("joint_zoo").gravity([0.5, -1.5, -9.0]);
    check::<JointZoo>(&zoo.joint_friction(JointFriction::Smooth(0.02)));
    check::<MimicGripper>(&read("mimic_gripper").mimic(Mimic::Follow));
    check::<FiveBar>(&read("five_bar"));
    let rotor = Rotor::new("front_left_knee", 0.0001, 9.0);
    let toe = Contact {
        name: "toe".into(),
        kind: ContactKind::Point,
        end: LoopEnd {
            link: "front_left_foot".into(),
            xyz: [0.01, 0.02, -0.3],
            rpy: [0.1, 0.2, 0.3],
        },
    };
    check::<Quadruped>(&read("quadruped").base(Base::Floating).rotors([rotor]).contacts([toe]));
    assert!(!FiveBar::model().loop_constraints().is_empty());
    assert!(MimicGripper::model().moving_links().iter().any(|link| link.joint.mimic.is_some()));
}

/// The interpreter of a type's model gives what the type's function gives.
#[test]
fn an_interpreter_of_a_type() {
    let model = JointZoo::model();
    let q: [f64; JointZoo::NQ] = core::array::from_fn(|i| 0.3 * i as f64 - 1.0);
    let mut interpreter = Interpreter::<f64>::new(model);
    let mut unit = q;
    interpreter.normalize_configuration(&mut unit).expect("lengths");
    let expected = JointZoo::potential_energy(&unit);
    let found = interpreter.potential_energy(&unit).expect("lengths");
    assert!(expected.abs() > 1.0 && (found - expected).abs() < 1e-9 * expected.abs());
}

#[test]
fn files_without_the_crate_have_no_model() {
    let error = read("arm6").embed_model().self_contained().generate().expect_err("no crate");
    assert!(error.to_string().contains("remove `embed_model` or `self_contained`"), "{error}");
    let error = read("arm6").embed_model().plan_object().err().expect("an object has none");
    assert!(error.to_string().contains("remove the option `embed_model`"), "{error}");
}
