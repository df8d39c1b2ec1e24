//! Compiles the arm to a self-contained file with functions for C, and writes their header.

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
    builder.c_functions("arm7").write(&source)?;

    let config = cbindgen::Config {
        language: cbindgen::Language::C,
        include_guard: Some("ARM7_H".into()),
        cpp_compat: true,
        usize_is_size_t: true,
        ..cbindgen::Config::default()
    };
    let sizes = "#ifdef __cplusplus\n#define ARM7_ASSERT static_assert\n#else\n\
                 #define ARM7_ASSERT _Static_assert\n#endif\n\
                 ARM7_ASSERT(sizeof(double) == 8, \"f64\");\n\
                 ARM7_ASSERT(sizeof(double[ARM7_NV]) == 8 * ARM7_NV, \"arrays without gaps\");";
    let header =
        std::env::var_os("ARM7_HEADER").map_or_else(|| Path::new(&out).join("arm7.h"), Into::into);
    cbindgen::Builder::new()
        .with_config(config)
        .with_src(&source)
        .with_trailer(sizes)
        .generate()?
        .write_to_file(header);
    Ok(())
}
