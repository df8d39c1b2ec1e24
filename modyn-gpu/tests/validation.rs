//! Kernels of every function through naga's parser and validator, which every text meets before a driver does.

use std::path::Path;

use modyn_codegen::{
    Base, Builder, Contact, ContactKind, Function, GpuLanguage, LoopEnd, RolloutOptions, Target,
};
use naga::Module;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::conformance::robot;

/// Validates the text of all these functions, and returns the number of kernels.
fn validate(name: &str, builder: &Builder, functions: impl Fn(Function) -> bool) -> usize {
    let functions = Function::ALL.iter().copied().filter(|&function| functions(function));
    let builder = builder.clone().functions(functions);
    let source = builder.emit(Target::Wgsl).expect("good");
    let module = parse(source.text(), name);
    let entries = module.entry_points.iter().map(|entry| entry.name.as_str());
    let kernels = source.kernels.iter().map(|kernel| kernel.name.as_str());
    assert!(entries.eq(kernels), "{name}: the kernels are the entry points");
    module.entry_points.len()
}

/// Returns a valid module.
fn parse(text: &str, name: &str) -> Module {
    let module = naga::front::wgsl::parse_str(text)
        .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(text)));
    // What every processor has: no capability is optional.
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    validator
        .validate(&module)
        .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(text)));
    module
}

/// Functions whose code is so long that validating that of large robots would take minutes.
fn is_short(function: Function) -> bool {
    !["hessian", "midpoint", "rk4_derivatives"].iter().any(|part| function.name().contains(part))
}

#[test]
fn all_functions_of_an_arm() {
    assert!(validate("arm6", &robot("arm6"), |_| true) > 100);
}

/// Kernels of rollouts call functions on the arrays of a thread, whose names WGSL must allow.
#[test]
fn functions_on_the_arrays_of_a_thread() {
    let end = LoopEnd { link: "tool".into(), xyz: [0.0; 3], rpy: [0.0; 3] };
    let hand = Contact { name: "hand".into(), kind: ContactKind::Point, end };
    let functions = Function::ALL.iter().copied().filter(|&function| is_short(function));
    let builder = robot("arm6").contacts([hand]).functions(functions);
    let emitted = builder.emit_rollouts(GpuLanguage::Wgsl, &RolloutOptions::default());
    let (source, _) = emitted.expect("good");
    let text = &source.text;
    assert!(text.contains("fn arm6_difference(") && text.contains("fn arm6_impact_dynamics("));
    parse(text, "arm6");
}

#[test]
fn all_joint_types() {
    validate("joint_zoo", &robot("joint_zoo"), is_short);
}

#[test]
fn all_functions_of_a_robot_with_closed_loops() {
    validate("five_bar", &robot("five_bar"), |_| true);
}

#[test]
fn a_floating_quadruped_with_contacts() {
    let feet = ["front_left_foot", "hind_right_foot"].map(|link| Contact {
        name: link.into(),
        kind: ContactKind::Point,
        end: LoopEnd { link: link.into(), xyz: [0.0; 3], rpy: [0.0; 3] },
    });
    let builder = robot("quadruped").base(Base::Floating).contacts(feet);
    validate("quadruped", &builder, is_short);
}

#[test]
#[ignore = "slow: a humanoid"]
fn derivatives_of_a_humanoid() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/golden/g1.urdf");
    let functions = [Function::ForwardDynamics, Function::ForwardDynamicsDerivatives];
    validate("g1", &Builder::new().urdf(file), |function| functions.contains(&function));
}
