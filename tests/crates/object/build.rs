//! Compiles each robot twice: to an object file with a Rust text that calls it, and to Rust.
use std::path::Path;

use modyn_codegen::{
    Base, Builder, Contact, ContactKind, FloatType, Function, FusedFunction, LoopEnd,
};
use modyn_jit::object::ObjectBuilder;
use modyn_jit::{CompileError, InstructionSet};

fn leg() -> Builder {
    let end = LoopEnd { link: "foot".into(), xyz: [0.01, 0.02, -0.03], rpy: [0.1, 0.2, 0.3] };
    let fused = FusedFunction::new("control").function(Function::MassMatrix);
    Builder::new()
        .urdf("robots/leg.urdf")
        .base(Base::Floating)
        .contacts([Contact { name: "toe".into(), kind: ContactKind::Point, end }])
        .functions([
            Function::ForwardDynamics,
            Function::ForwardDynamicsExternalLocal,
            Function::ForwardDynamicsDerivatives,
            Function::ConstrainedForwardDynamics,
            Function::KineticEnergy,
            Function::LinkPoses,
            Function::LinkPose,
            Function::LinkVelocity,
            Function::Jacobian,
            Function::Difference,
            Function::StepSemiImplicitDerivatives,
            Function::RandomConfiguration,
        ])
        .fused([fused.of_link(Function::Jacobian, "foot")])
        .runtime_gravity()
        .payload(["foot"])
}

fn main() -> Result<(), CompileError> {
    let leg = leg();
    leg.clone().type_name("Portable").compile()?;
    let object = leg.clone().type_name("InObject").compile_object(Some(InstructionSet::Sse2))?;
    // The form for types whose fields Rust has put into another order.
    let text = object.wrapper.replace("IN_ORDER: bool =", "IN_ORDER: bool = false &&");
    assert_ne!(text, object.wrapper);
    let folder = std::env::var("OUT_DIR").expect("a build script");
    std::fs::write(Path::new(&folder).join("copied.rs"), text).expect("writable");
    leg.clone().type_name("Fused").compile_object(Some(InstructionSet::Avx2))?;
    leg.clone().type_name("Largest").compile_object(Some(InstructionSet::Avx512))?;
    let single = leg.clone().scalar(FloatType::F32);
    single.clone().type_name("SinglePortable").compile()?;
    single.clone().type_name("Single").compile_object(Some(InstructionSet::Sse2))?;
    single.type_name("SingleFused").compile_object(Some(InstructionSet::Avx2))?;
    // Without a choice, it is what rustc may use.
    let own = leg.type_name("Own").functions([Function::MassMatrix]).compile_object(None)?;
    assert!(
        !own.wrapper.contains("target_feature")
            || std::env::var("CARGO_CFG_TARGET_FEATURE").is_ok_and(|f| f.contains("fma"))
    );
    Ok(())
}
