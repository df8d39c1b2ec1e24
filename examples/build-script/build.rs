//! Compiles the robot to a file in `OUT_DIR`, and again when its description changes.

mod reach;

use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::{Builder, Function, FusedFunction};
use reach::ReachCost;

fn main() -> Result<(), Diagnostics> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=reach.rs");
    // All that an optimal controller needs of a state, in one call that does the common work once.
    let stage = FusedFunction::new("stage")
        .function(Function::StepSemiImplicitDerivatives)
        .own_function("reach_cost_gradient");
    Builder::new()
        .urdf("robots/double_pendulum.urdf")
        .type_name("Pendulum")
        // Functions that are not selected cost no compile time.
        .functions([Function::InverseDynamics, Function::GravityTorques, Function::LinkPose])
        // A function of one's own, with its derivatives, for one state and for many.
        .function_batch("reach_cost", ReachCost { link: "tip" })
        .fused([stage])
        .compile()?;
    Ok(())
}
