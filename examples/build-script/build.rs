//! Compiles the robot to a file in `OUT_DIR`, and again when its description changes.

use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::{Builder, Function};

fn main() -> Result<(), Diagnostics> {
    Builder::new()
        .urdf("robots/double_pendulum.urdf")
        .type_name("Pendulum")
        // Functions that are not selected cost no compile time.
        .functions([Function::InverseDynamics, Function::GravityTorques])
        .compile()?;
    Ok(())
}
