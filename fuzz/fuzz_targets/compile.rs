//! Any text that is a robot becomes Rust that parses and has finite constants. Any other text becomes errors of the text.
#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use modyn_codegen::diagnostics::{Code, Severity};
use modyn_codegen::{Base, JointFriction, Mimic};
use modyn_codegen::{Builder, FloatType, Function, ModuleChoice};

/// A few functions at a time: all of them would be few robots a second.
const FUNCTIONS: [&[Function]; 8] = [
    &[Function::ForwardDynamics],
    &[Function::InverseDynamics, Function::MassMatrix],
    &[Function::Brge, Function::ForwardDynamicsVjp],
    &[Function::InverseDynamicsDerivatives, Function::InverseDynamicsHessian],
    &[Function::LinkPoses, Function::Jacobian, Function::CentroidalMomentumDerivatives],
    &[Function::Integrate, Function::Difference, Function::RandomConfiguration],
    &[Function::Regressor, Function::KineticEnergy, Function::PotentialEnergy],
    &[Function::ForwardDynamicsExternalLocal, Function::ForwardDynamicsDerivatives],
];

fuzz_target!(|data: &[u8]| {
    let (text, choice) = modyn_fuzz::text(data);
    let flag = |bit: u8| choice >> bit & 1 == 1;
    let functions = FUNCTIONS[usize::from(choice & 7)];
    let mut builder =
        Builder::new().urdf_text(text, "fuzz.urdf").functions(functions.iter().copied());
    builder = builder.unphysical_inertia(Severity::Warning);
    if flag(3) {
        builder = builder
            .share_limbs()
            .modules(ModuleChoice::Links)
            .joint_friction(JointFriction::Smooth(0.01));
    }
    if flag(4) {
        builder = builder.self_contained().c_functions("robot");
    }
    if flag(5) {
        builder = builder.scalar(FloatType::F32).mimic(Mimic::Independent);
    }
    if flag(6) {
        builder = builder.base(Base::Floating);
    }
    if flag(7) {
        builder = builder.runtime_gravity();
    }
    match builder.generate() {
        Ok(generated) => {
            // A packed program that is invalid is replaced, and still a fault.
            assert!(generated.warnings.iter().all(|d| d.code != Code::InvalidProgram));
            syn::parse_file(&generated.text).expect("Rust");
            syn::parse_str::<syn::Ident>(&generated.type_name).expect("an identifier");
            // A self-contained text has the runtime's messages, and some of them mention NaN.
            assert!(flag(4) || !generated.text.contains("NaN"), "a constant is not a number");
        }
        Err(errors) => {
            assert!(errors.has_errors() && errors.iter().all(|d| d.code != Code::InvalidModel))
        }
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    modyn_fuzz::mutate(data, size, max_size, seed, &modyn_fuzz::vocabulary::URDF)
});
