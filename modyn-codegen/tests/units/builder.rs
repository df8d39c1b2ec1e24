//! The builder: models, options, and texts that are too large.

use modyn_codegen::diagnostics::{Code, Severity};
use modyn_codegen::internals::{Selected, invalid_programs, too_large};
use modyn_codegen::program::InvalidProgram;
use modyn_codegen::{Builder, Function, ModuleChoice, ReadOptions, read_urdf};
use modyn_runtime::model::{Model, ModuleTree};

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
fn changed(model: &Model, change: impl Fn(&mut modyn_runtime::model::Link)) -> Model {
    let mut links = model.links().to_vec();
    links.iter_mut().next_back().into_iter().for_each(change);
    Model::new(model.name(), model.gravity(), links, model.frames().to_vec()).expect("valid")
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
    let (links, frames) = (model.links().to_vec(), model.frames().to_vec());
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
fn too_large_code_is_refused_at_once() {
    let refused = |model: Model, modules| {
        let errors = Builder::new().model(model).modules(modules).generate();
        errors.expect_err("too large").to_string()
    };
    let errors = refused(comb(1, 1000), ModuleChoice::Chains);
    assert!(errors.starts_with("error[too-large]: code for 1000 moving joints"), "{errors}");
    assert!(errors.contains("1000 links, from `1` to `1000`"), "{errors}");
    // Modules of one link would not help here.
    assert!(!errors.contains("modules = links"), "{errors}");
    let errors = refused(comb(1, 66), ModuleChoice::Chains);
    assert!(errors.contains("`brge` 2") && errors.contains("modules = links"), "{errors}");
    // The most expensive function is named, and a set of functions without it.
    let errors = refused(comb(600, 1), ModuleChoice::Links);
    assert!(errors.contains("`jacobian` 5"), "{errors}");
    assert!(errors.contains("leave `jacobian` out of the option `functions`"), "{errors}");
}

#[test]
fn the_limit_is_about_cost_not_joints() {
    let refused = |model: &Model, modules: &ModuleTree, functions: &[Function]| {
        too_large(model, modules, Selected::straight(functions)).is_some()
    };
    for (model, chains, links) in [
        (comb(1, 60), false, false),
        (comb(1, 66), true, false),
        (comb(1, 150), true, true),
        (comb(40, 5), false, false),
        (comb(25, 8), false, false),
        (comb(300, 1), false, false),
    ] {
        let (by_chains, by_links) = (ModuleTree::chains(&model), ModuleTree::links(&model));
        let default = Function::DEFAULT;
        assert_eq!(refused(&model, &by_chains, default), chains, "{}", model.nv());
        assert_eq!(refused(&model, &by_links, default), links, "{}", model.nv());
        // A single function with linear code size is small.
        let one = [Function::ForwardDynamics];
        assert!(!refused(&model, &by_links, &one), "{}", model.nv());
    }
    // Derivatives of a chain grow with the cube of its length, and twice as fast with batches.
    let model = comb(1, 45);
    let links = ModuleTree::links(&model);
    let mut functions = vec![Function::ForwardDynamicsDerivatives];
    assert!(!refused(&model, &links, &functions));
    functions.push(Function::ForwardDynamicsDerivativesBatch);
    assert!(refused(&model, &links, &functions));
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
