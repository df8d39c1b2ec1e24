//! Compiles the robots of `tests/src/fleet.rs` that belong to the package, and writes a table of them for the macro of
//! `tests/src/compiled.rs`. All packages of parts of the fleet have this build script.

#[allow(dead_code)]
#[path = "../../src/fleet.rs"]
mod fleet;
#[allow(dead_code)]
#[path = "../../src/random.rs"]
mod random;

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use modyn_codegen::FloatType;

fn main() -> Result<(), Box<dyn Error>> {
    let (mut includes, mut table) = (String::new(), String::new());
    let all = fleet::FLEET.iter().enumerate();
    for (index, spec) in all.filter(|(_, spec)| spec.part.package() == env!("CARGO_PKG_NAME")) {
        let generated = spec.builder().compile()?;
        let (module, name) = (spec.module(), generated.type_name);
        let float = match spec.float {
            FloatType::F64 => "f64 Double",
            FloatType::F32 => "f32 Single",
        };
        let modules = spec.modules(&generated.model).modules().len();
        let pivots: Vec<String> = (0..modules).map(|m| format!("pivot_block_{m}")).collect();
        writeln!(includes, "::modyn::include_model!({module});")?;
        let functions = if spec.all { "all" } else { "default" };
        let constant = |name: &str| format!("{name:?} {}_OPERATIONS", name.to_uppercase());
        let operations: Vec<String> =
            generated.operations.iter().map(|(name, _)| constant(name)).collect();
        writeln!(
            table,
            "    {index} {name} {name}Joint {name}Link {functions} {float} {module:?} [{}] [{}];",
            operations.join(" "),
            pivots.join(" ")
        )?;
    }
    let folder = std::env::var_os("OUT_DIR").ok_or("no OUT_DIR")?;
    let text = format!(
        "/// The types of the robots.\npub mod robots {{\n{includes}}}\nuse robots::*;\n\n\
         ::modyn_tests::compiled! {{\n{table}}}\n"
    );
    std::fs::write(Path::new(&folder).join("fleet.rs"), text)?;
    Ok(())
}
