//! Calls with wrong arguments are refused with a message that names the reason, and write nothing.

use modyn_codegen::{Builder, Function};
use modyn_jit::{CompileError, Compiled, Options};
use modyn_tests::conformance::robot;

fn arm() -> Compiled<f64> {
    let functions =
        [Function::ForwardDynamics, Function::MassMatrix, Function::Jacobian, Function::LinkPoses];
    Compiled::build(&robot("arm6").functions(functions), Options::default()).expect("code")
}

#[test]
fn wrong_calls_name_the_error() {
    let (arm, q) = (arm(), [0.1; 6]);
    let mut qdd = [7.0; 6];
    let dynamics = arm.function(Function::ForwardDynamics).expect("compiled");
    let jacobian = arm.function(Function::Jacobian).expect("compiled");
    let links = arm.model().links().len();
    let cases = [
        (
            arm.inverse_dynamics(&q, &q, &q, &mut qdd),
            "`inverse_dynamics` was not compiled; compiled were: forward_dynamics, mass_matrix, link_poses, jacobian",
        ),
        (
            dynamics.one(&[&q, &q], &mut qdd),
            "`forward_dynamics` takes the arguments q, qd, tau, and 2 were given",
        ),
        (
            arm.forward_dynamics(&q, &q[..5], &q, &mut qdd),
            "`qd` of `forward_dynamics` has 6 numbers, and 5 were given",
        ),
        (
            arm.forward_dynamics(&q, &q, &q, &mut qdd[..5]),
            "`result` of `forward_dynamics` has 6 numbers, and 5 were given",
        ),
        (
            dynamics.many(&[&q, &q, &q], &mut qdd),
            "`forward_dynamics` was compiled for one state at a time; set `Options::batches`",
        ),
        (
            dynamics.link(0, &[&q, &q, &q], &mut qdd),
            "`forward_dynamics` is not about one link; call it without",
        ),
        (
            jacobian.one(&[&q], &mut qdd),
            "`jacobian` is about one link; call it with the link's index",
        ),
        (
            jacobian.link(99, &[&q], &mut qdd),
            &format!("`jacobian` of link 99: there are {links} links, the first is 0"),
        ),
    ];
    for (result, message) in cases {
        assert_eq!(result.expect_err(message).to_string(), message);
    }
    assert_eq!(qdd, [7.0; 6]);
}

#[test]
fn wrong_batches_name_the_error() {
    let builder = robot("arm6").functions([Function::MassMatrix]);
    let mut options = Options::default();
    options.batches = true;
    let arm = Compiled::<f32>::build(&builder, options).expect("code");
    let mass = arm.function(Function::MassMatrix).expect("compiled");
    let (q, mut result) = ([0.1; 13], [7.0; 72]);
    let error = mass.many(&[&q], &mut result).expect_err("13 are no states");
    let message = "`q` of `mass_matrix` has 6 numbers a state, and 13 are no multiple of that";
    assert_eq!(error.to_string(), message);
    let error = mass.many(&[&q[..12]], &mut result[..71]).expect_err("too short");
    assert_eq!(error.to_string(), "`result` of `mass_matrix` has 72 numbers, and 71 were given");
    assert!(result.iter().all(|&x| x == 7.0));
    // A batch without states is valid.
    mass.many(&[&[]], &mut []).expect("nothing to do");
}

#[test]
fn states_in_lanes() {
    let mut options = Options::default();
    options.batches = true;
    let builder = robot("arm6").functions([Function::MassMatrix, Function::Jacobian]);
    let arm = Compiled::<f64>::build(&builder, options).expect("code");
    let mass = arm.function(Function::MassMatrix).expect("compiled");
    let lanes = mass.lanes();
    assert!(lanes > 1);
    let q: Vec<f64> = (0..6 * lanes).map(|k| (k * 5 % 7) as f64 * 0.3 - 0.8).collect();
    let (mut found, mut one) = (vec![0.0; 36 * lanes], [0.0; 36]);
    mass.in_lanes(&[&q], &mut found).expect("fits");
    for lane in 0..lanes {
        let own: Vec<f64> = q.iter().skip(lane).step_by(lanes).copied().collect();
        mass.one(&[&own], &mut one).expect("fits");
        for (k, expected) in one.iter().enumerate() {
            assert!((found[k * lanes + lane] - expected).abs() < 1e-12);
        }
    }
    let error = mass.in_lanes(&[&q[1..]], &mut found).expect_err("too short").to_string();
    let (expected, given) = (6 * lanes, 6 * lanes - 1);
    let message = format!("`q` of `mass_matrix` has {expected} numbers, and {given} were given");
    assert_eq!(error, message);
    let jacobian = arm.function(Function::Jacobian).expect("compiled");
    let error = jacobian.in_lanes(&[&q], &mut found).expect_err("no link").to_string();
    assert_eq!(error, "`jacobian` is about one link; call it with the link's index");
    let single = Compiled::<f64>::build(&builder, Options::default()).expect("code");
    let mass = single.function(Function::MassMatrix).expect("compiled");
    assert_eq!(mass.lanes(), 1);
    mass.in_lanes(&[&q[..6]], &mut one).expect_err("no code for batches");
}

/// Several arguments may be the same slice; Rust's borrow rules keep the result apart.
#[test]
fn arguments_can_be_the_same() {
    let (arm, x) = (arm(), [0.3, -0.2, 0.5, 0.7, -1.1, 0.4]);
    let (copies, mut found, mut expected) = ([x; 3], [0.0; 6], [0.0; 6]);
    arm.forward_dynamics(&x, &x, &x, &mut found).expect("fits");
    arm.forward_dynamics(&copies[0], &copies[1], &copies[2], &mut expected).expect("fits");
    assert_eq!(found, expected);
    assert!(found.iter().all(|x| x.is_finite() && *x != 0.0));
}

#[test]
fn a_wrong_description_is_reported() {
    let builder = Builder::new().urdf_text("<robot name='x'><link/></robot>", "x.urdf");
    let error = Compiled::<f64>::build(&builder, Options::default()).expect_err("no link's name");
    assert!(matches!(error, CompileError::Description(_)), "{error}");
    assert!(error.to_string().contains("x.urdf"), "{error}");
}
