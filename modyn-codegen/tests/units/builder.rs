//! The builder: models, options, and texts that are too large.

use modyn_codegen::diagnostics::{Code, Severity};
use modyn_codegen::graph::{Expr, Graph};
use modyn_codegen::internals::{invalid_programs, traced_operations, within};
use modyn_codegen::program::InvalidProgram;
use modyn_codegen::{
    Builder, Contact, ContactKind, Function, LoopEnd, ModuleChoice, ReadOptions, read_urdf,
};
use modyn_runtime::Scalar;
use modyn_runtime::model::Model;

/// Returns a model of this number of chains with this number of links.
fn comb(chains: usize, length: usize) -> Model {
    let mut urdf = String::from("<robot name='comb'><link name='0'/>");
    for i in 1..=chains * length {
        let parent = if i % length == 1 % length { 0 } else { i - 1 };
        urdf += &format!(
            "<joint name='{i}' type='continuous'><parent link='{parent}'/><child link='{i}'/></joint>\
             <link name='{i}'><inertial><mass value='1'/>\
             <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>",
        );
    }
    let read = read_urdf(&(urdf + "</robot>"), "comb.urdf", &ReadOptions::default());
    read.expect("a good robot").model
}

/// Returns the model with its last link changed.
fn changed(model: &Model, change: impl Fn(&mut modyn_runtime::model::MovingLink)) -> Model {
    let mut links = model.moving_links().to_vec();
    links.iter_mut().next_back().into_iter().for_each(change);
    Model::new(model.name(), model.gravity(), links, model.links().to_vec()).expect("valid")
}

#[test]
fn a_model_is_checked_as_a_description_is() {
    let good = comb(1, 2);
    let codes = |model, severity| -> Vec<Code> {
        let result = Builder::new().model(model).unphysical_inertia(severity).generate();
        match result {
            Ok(generated) => generated.warnings.iter().map(|found| found.code).collect(),
            Err(errors) => {
                assert!(errors.has_errors());
                assert!(errors.iter().all(|e| e.subject.is_some() && e.help.is_some()));
                errors.iter().map(|found| found.code).collect()
            }
        }
    };
    let massless = changed(&good, |link| link.inertial = Default::default());
    let negative = changed(&good, |link| link.inertial.mass = -1.0);
    let unphysical = changed(&good, |link| link.inertial.inertia[0] = 3.0);
    let large = changed(&good, |link| link.inertial.center_of_mass[0] = 1e100);
    for severity in [Severity::Error, Severity::Warning] {
        assert_eq!(codes(good.clone(), severity), []);
        assert_eq!(codes(massless.clone(), severity), [Code::KinematicsOnly]);
        assert_eq!(codes(negative.clone(), severity), [Code::NegativeMass]);
        assert_eq!(codes(unphysical.clone(), severity), [Code::TriangleInequality]);
        assert_eq!(codes(large.clone(), severity), [Code::NotFinite]);
    }
    let builder = Builder::new().model(unphysical);
    assert!(builder.clone().generate().is_err());
    assert!(builder.unphysical_inertia(Severity::Warning).generate().is_ok());
}

#[test]
fn gravity_is_a_models_own_unless_it_is_given() {
    let model = comb(1, 1);
    let moon = [0.0, 0.0, -1.62];
    let (links, frames) = (model.moving_links().to_vec(), model.links().to_vec());
    let on_moon = Model::new("m", moon, links, frames).expect("valid");
    let builder = Builder::new().model(on_moon);
    assert_eq!(builder.clone().generate().expect("good").model.gravity(), moon);
    let other = builder.clone().gravity([1.0, 0.0, 0.0]).generate().expect("good");
    assert_eq!(other.model.gravity(), [1.0, 0.0, 0.0]);
    let errors = builder.gravity([1e70, 0.0, 0.0]).generate().expect_err("too large");
    assert_eq!(errors.iter().map(|error| error.code).collect::<Vec<_>>(), [Code::Gravity]);
}

#[test]
fn a_misspelt_link_of_a_module_is_suggested() {
    let model = || changed(&comb(1, 2), |link| link.name = "forearm".into());
    let list = |name: &str| ModuleChoice::List(vec![vec!["1".into(), name.into()]]);
    let refused = |name| {
        let builder = Builder::new().model(model()).modules(list(name));
        builder.generate().expect_err("no such link").to_string()
    };
    assert!(refused("fourarm").contains("help: did you mean `forearm`?"));
    assert!(!refused("hand").contains("did you mean"));
}

#[test]
fn a_robot_called_robot_is_warned_of() {
    let text = |name: &str| {
        format!(
            "<robot{name}><link name='a'/><joint name='j' type='continuous'><parent link='a'/>\
             <child link='b'/></joint><link name='b'><inertial><mass value='1'/>\
             <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link></robot>"
        )
    };
    let warnings = |name: &str, builder: Builder| {
        let found = builder.urdf_text(text(name), "a.urdf").generate().expect("good");
        found.warnings.iter().map(|warning| warning.code).collect::<Vec<_>>()
    };
    let called = " name='robot'";
    assert_eq!(warnings(called, Builder::new()), [Code::TypeName]);
    assert_eq!(warnings("", Builder::new()), [Code::MissingAttribute]);
    assert_eq!(warnings(called, Builder::new().type_name("Arm")), []);
}

#[test]
fn all_that_is_wrong_is_said_at_once() {
    let builder = Builder::new().urdf("no such.urdf").type_name("my arm");
    let errors = builder.crate_("a b").visibility("x").gravity([f64::NAN; 3]).generate();
    let errors = errors.expect_err("all wrong");
    let codes: Vec<Code> = errors.iter().map(|error| error.code).collect();
    let options = [Code::TypeName, Code::Option, Code::Option, Code::Gravity];
    assert_eq!(codes, [&options[..], &[Code::MissingFile]].concat());
    assert!(errors.iter().all(|error| error.help.is_some()));
}

#[test]
fn too_long_functions_are_refused() {
    let refused = |model: Model, modules, functions: &[Function]| {
        let builder = Builder::new().model(model).modules(modules);
        let errors = builder.functions(functions.iter().copied()).generate();
        errors.expect_err("too long").to_string()
    };
    let errors = refused(comb(1, 1000), ModuleChoice::Chains, Function::DEFAULT);
    assert!(
        errors.starts_with("error[too-large]: `mass_matrix` of 1000 moving joints"),
        "{errors}"
    );
    assert!(errors.contains("more than 800000 operations"), "{errors}");
    assert!(errors.contains("1000 links, from `1` to `1000`"), "{errors}");
    assert!(errors.contains("leave `mass_matrix` out of the option `functions`"), "{errors}");
    // Modules of one link have too many operations, too, so they are not proposed.
    let errors = refused(comb(1, 300), ModuleChoice::Chains, &[Function::Brge]);
    assert!(errors.contains("`brge` of 300") && !errors.contains("modules = links"), "{errors}");
    assert!(errors.contains("`forward_dynamics` solves for accelerations"), "{errors}");
    let errors = refused(comb(1, 4001), ModuleChoice::Links, &[Function::GravityTorques]);
    assert!(errors.contains("at most 4000 moving joints, and the robot has 4001"), "{errors}");
    // The functions before are named if they are long.
    let functions = [Function::Jacobian, Function::JacobianTimeDerivative];
    let both = Builder::new().urdf_text(chain(150), "chain.urdf").functions(functions).plan();
    let errors = both.map(|_| ()).expect_err("too long").to_string();
    assert!(errors.contains("with the functions before it (`jacobian` "), "{errors}");
    assert!(errors.contains("leave `jacobian` or `jacobian_time_derivative` out"), "{errors}");
}

/// Returns a chain of this number of joints in general position.
fn chain(joints: usize) -> String {
    let mut urdf = String::from("<robot name='chain'><link name='0'/>");
    for i in 1..=joints {
        urdf += &format!(
            "<joint name='{i}' type='continuous'><origin xyz='0.1 0.2 0.3' rpy='0.3 0.2 -0.4'/><axis xyz='0.6 0.48 0.64'/>\
             <parent link='{}'/><child link='{i}'/></joint><link name='{i}'><inertial><origin xyz='0.1 0.2 0.3'/>\
             <mass value='1'/><inertia ixx='1' iyy='1.1' izz='1.2' ixy='0' ixz='0' iyz='0'/></inertial></link>",
            i - 1
        );
    }
    urdf + "</robot>"
}

/// Each function of a long chain in general position, on the ground by its tip, is made or refused in less than half a minute,
/// also by a compiler that is not optimised.
#[test]
#[ignore = "slow: all functions of a chain of thousands of links"]
fn functions_of_a_long_chain_are_refused_soon() {
    let tip = LoopEnd { link: "3000".into(), xyz: [0.1; 3], rpy: [0.0; 3] };
    let tip = Contact { name: "tip".into(), kind: ContactKind::Point, end: tip };
    let builder = Builder::new().urdf_text(chain(3000), "chain.urdf").contacts([tip]);
    let mut refused = 0;
    for &function in Function::ALL.iter().filter(|function| function.batched().is_none()) {
        let start = std::time::Instant::now();
        let result = builder.clone().functions([function]).plan().map(|_| ());
        let seconds = start.elapsed().as_secs_f64();
        println!("{}: {seconds:.1} s, {}", function.name(), result.is_ok());
        assert!(seconds < 30.0, "{}: {seconds}", function.name());
        if let Err(errors) = result {
            assert!(errors.iter().all(|error| error.code == Code::TooLarge), "{errors}");
            refused += 1;
        }
    }
    assert!(refused > 30, "{refused}");
}

/// Returns contacts of points with the ground, on these links.
fn points(links: impl Iterator<Item = String>) -> Vec<Contact> {
    let point = |(i, link)| {
        let end = LoopEnd { link, xyz: [0.1 * i as f64, 0.2, 0.3], rpy: [0.0; 3] };
        Contact { name: format!("p{i}"), kind: ContactKind::Point, end }
    };
    links.enumerate().map(point).collect()
}

/// Returns the number of traced operations of a function, and whether it is made.
fn traced(builder: &Builder, function: Function) -> (usize, bool) {
    let before = traced_operations();
    let is_made = match builder.clone().functions([function]).plan() {
        Ok(_) => true,
        Err(errors) => {
            assert!(errors.iter().all(|error| error.code == Code::TooLarge), "{errors}");
            false
        }
    };
    (traced_operations() - before, is_made)
}

/// A function far beyond the limit is refused before it is traced: forward dynamics is traced
/// alone, for its partition.
#[test]
fn far_too_long_functions_are_refused_before_they_are_traced() {
    for function in [
        Function::ConstrainedForwardDynamics,
        Function::ProjectConstraints,
        Function::ImpactDynamics,
        Function::OperationalSpaceInertia,
        Function::ConstrainedForwardDynamicsDerivatives,
        Function::ConstrainedForwardDynamicsHessian,
    ] {
        for count in [50, 100, 1000] {
            let builder = Builder::new().urdf_text(chain(7), "chain.urdf");
            let builder = builder.contacts(points((0..count).map(|_| "3".into())));
            let (operations, is_made) = traced(&builder, function);
            let most = 50_000 + 200 * count;
            assert!(!is_made && operations < most, "{function:?} {count}: {operations}");
        }
    }
    for function in [
        Function::ForwardDynamicsDerivatives,
        Function::StepSemiImplicitDerivatives,
        Function::ForwardDynamicsHessian,
        Function::StepSemiImplicitHessian,
    ] {
        for count in [150, 300, 600] {
            let builder = Builder::new().urdf_text(chain(count), "chain.urdf");
            let (operations, is_made) = traced(&builder, function);
            assert!(!is_made && operations < 5000 * count, "{function:?} {count}: {operations}");
        }
    }
}

/// A step far beyond the limit has parts without inputs, since operations beyond it are one of their operands.
#[test]
fn steps_beyond_the_limit_are_refused() {
    let builder = Builder::new().urdf_text(chain(7), "chain.urdf");
    for (count, is_expected) in [(2, true), (1500, false), (3000, false)] {
        let builder = builder.clone().contacts(points((0..count).map(|_| "3".into())));
        let (_, is_made) = traced(&builder, Function::Step);
        assert_eq!(is_made, is_expected, "{count} contacts");
    }
}

/// A function a little beyond the limit is traced to the limit, and not by columns in lanes as
/// well.
#[test]
#[ignore = "slow: millions of operations"]
fn too_long_functions_are_traced_once() {
    for count in [60, 100] {
        let builder = Builder::new().urdf_text(chain(count), "chain.urdf");
        let (operations, is_made) = traced(&builder, Function::ForwardDynamicsDerivatives);
        println!("{count}: {operations}");
        assert!(!is_made && operations < 8_000_000, "{count}: {operations}");
    }
}

/// Beyond the limit an operation is one of its operands, so that graphs stay valid; traces outside have no limit.
#[test]
fn traces_end_at_their_limit() {
    let sums = |count: usize| {
        move || {
            Graph::trace(|| {
                let pack = Expr::pack(&[Expr::input(0), Expr::input(1)]);
                let mut sum = pack;
                for i in 0..count {
                    sum = sum * pack + Expr::input(i % 7).sin_cos().0;
                }
                vec![sum.extract_lane(0), sum.extract_lane(1)]
            })
        }
    };
    assert!(within(100, sums(1000)).is_none());
    let graph = within(5000, sums(1000)).expect("within its limit");
    assert_eq!(graph.nodes(), sums(1000)().nodes());
    assert!(within(5000, || [sums(1000)(), sums(1001)(), sums(1002)()]).is_none(), "together");
    let inner = within(5000, || within(100, sums(1000)).is_none()).expect("the inner limit alone");
    assert!(inner);
}

#[test]
fn an_invalid_program_is_a_warning() {
    let mut plan = Builder::new().model(comb(2, 1)).plan().expect("good").plan;
    assert_eq!(invalid_programs(&plan).count(), 0);
    let (name, rule) = (plan.functions[1].name, "a rule");
    plan.functions[1].fault = Some(InvalidProgram { statement: Some(3), rule });
    let found: Vec<_> = invalid_programs(&plan).collect();
    let [found] = &*found else { panic!("{found:?}") };
    assert_eq!((found.severity, found.code), (Severity::Warning, Code::InvalidProgram));
    assert!(found.message.contains(name) && found.message.contains(rule), "{found}");
}

/// A model that is given as text compiles as the same model in a file.
#[test]
fn texts_compile_as_files_do() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../modyn-read/tests/mjcf/arm.xml");
    let text = include_str!("../../../modyn-read/tests/mjcf/arm.xml");
    let generated = |builder: Builder| {
        let generated = builder.type_name("Arm").generate().expect("an arm");
        generated.operations
    };
    let from_text = generated(Builder::new().mjcf_text(text, "arm.xml"));
    assert!(!from_text.is_empty());
    assert_eq!(from_text, generated(Builder::new().mjcf(path)));
}

/// A chain and a star of joints are a good model for the interpreter.
#[test]
fn robots_of_too_many_links_are_refused_before_code_is_generated() {
    for model in [comb(1, 10_000), comb(10_000, 1)] {
        let errors = Builder::new().model(model).generate().expect_err("too large");
        let codes: Vec<Code> = errors.iter().map(|error| error.code).collect();
        assert_eq!(codes, [Code::TooLarge]);
    }
}
