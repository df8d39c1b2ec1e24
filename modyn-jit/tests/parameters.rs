//! Gravity, inertias and payloads that are set at run time give the interpreter's results, for one state and many.

use modyn_codegen::Function;
use modyn_jit::{Compiled, Options, ParameterError};
use modyn_runtime::Interpreter;
use modyn_runtime::model::Inertial;
use modyn_tests::conformance::robot;
use modyn_tests::random;

fn load() -> Inertial<f64> {
    Inertial {
        mass: 2.5,
        center_of_mass: [0.1, -0.05, 0.2],
        inertia: [0.02, 0.001, -0.002, 0.03, 0.0015, 0.025],
    }
}

#[test]
fn parameters_are_as_the_interpreter_has_them() {
    let model = robot("arm7").plan().expect("good").model;
    let links: Vec<String> = model.moving_links().iter().map(|link| link.name.clone()).collect();
    let (own, carrying) = (links[3].clone(), links[6].clone());
    let builder = robot("arm7")
        .functions([Function::ForwardDynamics])
        .runtime_gravity()
        .runtime_inertia([&own])
        .payload([&carrying]);
    let mut options = Options::default();
    options.batches = true;
    let mut compiled = Compiled::<f64>::build(&builder, options).expect("code");
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    let random::State { q, qd, tau, .. } = random::state(5, &model);
    let frame = |name: &str| model.links().iter().position(|f| f.name == name).expect("a link");
    let mut before = vec![0.0; model.nv()];
    for change in 0..4 {
        match change {
            1 => {
                compiled.set_gravity([1.0, -2.0, -3.0]).expect("a parameter");
                interpreter.set_gravity([1.0, -2.0, -3.0]);
            }
            2 => {
                compiled.set_inertia(&own, &load()).expect("a parameter");
                interpreter.set_inertial(frame(&own), &load()).expect("a link");
            }
            3 => {
                compiled.set_payload(&carrying, &load()).expect("a parameter");
                interpreter.set_payload(frame(&carrying), &load()).expect("a link");
            }
            _ => {}
        }
        let (mut found, mut expected) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
        compiled.forward_dynamics(&q, &qd, &tau, &mut found).expect("fits");
        interpreter.forward_dynamics(&q, &qd, &tau, &mut expected).expect("fits");
        let mut many = vec![0.0; 5 * model.nv()];
        let call = compiled.function(Function::ForwardDynamics).expect("compiled");
        call.many(&[&q.repeat(5), &qd.repeat(5), &tau.repeat(5)], &mut many).expect("fits");
        let size = expected.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
        for (i, many) in many.iter().enumerate() {
            let (found, expected) = (found[i % model.nv()], expected[i % model.nv()]);
            assert!((found - expected).abs() < 1e-10 * size, "{change}: {found} {expected}");
            assert!((many - expected).abs() < 1e-10 * size, "{change}: {many} {expected}");
        }
        assert_ne!(found, before, "{change}");
        before = found;
    }
}

#[test]
fn wrong_parameters_are_refused() {
    let model = robot("arm6").plan().expect("good").model;
    let last = model.moving_links()[5].name.clone();
    let functions = [Function::ForwardDynamics];
    let constant = robot("arm6").functions(functions);
    let mut constant = Compiled::<f32>::build(&constant, Options::default()).expect("code");
    let error = constant.set_gravity([0.0; 3]).expect_err("a constant");
    assert!(error.to_string().contains("Builder::runtime_gravity"), "{error}");
    let builder = robot("arm6").functions(functions).runtime_inertia([&last]).runtime_gravity();
    let mut arm = Compiled::<f64>::build(&builder, Options::default()).expect("code");
    let error = arm.set_payload(&last, &load()).expect_err("no payload");
    assert!(error.to_string().contains(&format!("`{last}` has no `payload`")), "{error}");
    let error = arm.set_inertia("nowhere", &load()).expect_err("no link");
    assert!(matches!(error, ParameterError::NotAParameter { .. }), "{error}");
    let error = arm.set_inertia(&last, &Inertial { mass: -1.0, ..load() }).expect_err("negative");
    assert!(matches!(error, ParameterError::Defect(_)), "{error}");
    let error = arm.set_gravity([f64::NAN, 0.0, 0.0]).expect_err("NaN");
    assert_eq!(error, ParameterError::Gravity);
    let none = Inertial { mass: 0.0, center_of_mass: [0.0; 3], inertia: [0.0; 6] };
    let error = arm.set_inertia(&last, &none).expect_err("the last joint moves this link alone");
    assert!(matches!(&error, ParameterError::NoInertia { joint } if !joint.is_empty()), "{error}");
}
