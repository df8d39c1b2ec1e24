//! Compiles the same robots by a build script.
use modyn_codegen::Builder;
use modyn_codegen::diagnostics::Diagnostics;

fn main() -> Result<(), Diagnostics> {
    Builder::new().urdf("../../../robots/gripper.urdf").compile()?;
    Builder::new().urdf("../../../robots/arm7.urdf").visibility("").compile()?;
    for name in ["Robot", "Option", "T", "Some", "None"] {
        Builder::new().urdf("robots/clash.urdf").type_name(name).compile()?;
    }
    Ok(())
}
