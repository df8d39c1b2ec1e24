//! Compiles the arm to a self-contained file with functions for C, and writes the header.

use std::error::Error;
use std::path::Path;

use modyn_codegen::{Builder, Function};

const FUNCTIONS: [Function; 6] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::MassMatrix,
    Function::KineticEnergy,
    Function::LinkPoses,
    Function::Jacobian,
];

fn main() -> Result<(), Box<dyn Error>> {
    let urdf = "../../robots/arm7.urdf";
    println!("cargo::rerun-if-changed={urdf}");
    println!("cargo::rerun-if-env-changed=ARM7_HEADER");
    let out = std::env::var_os("OUT_DIR").ok_or("no OUT_DIR")?;
    let source = Path::new(&out).join("arm7.rs");
    let builder = Builder::new().urdf(urdf).functions(FUNCTIONS).self_contained();
    let generated = builder.c_functions("arm7").write(&source)?;
    let header =
        std::env::var_os("ARM7_HEADER").map_or_else(|| Path::new(&out).join("arm7.h"), Into::into);
    std::fs::write(header, generated.c_header.ok_or("no functions for C")?)?;
    Ok(())
}
