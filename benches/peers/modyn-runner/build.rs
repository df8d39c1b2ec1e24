//! Compiles the robots of `robots.txt`, and writes a table of them for `src/generated.rs`.

#[path = "src/robots.rs"]
mod robots;

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use modyn_codegen::{Builder, Function};

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=../robots.txt");
    println!("cargo::rerun-if-changed=../../../target/peers/robots");
    let (mut includes, mut table) = (String::new(), String::new());
    for robot in robots::all() {
        let mut functions =
            vec![Function::ForwardDynamics, Function::InverseDynamics, Function::MassMatrix];
        if robot.derivatives {
            functions.push(Function::ForwardDynamicsDerivatives);
        }
        let names: Vec<&str> = functions.iter().map(|function| function.name()).collect();
        let type_name = robot.type_name();
        let batch = [Function::ForwardDynamicsBatch];
        Builder::new()
            .urdf(&robot.description)
            .base(robot.base)
            .type_name(&type_name)
            .functions(functions.into_iter().chain(batch))
            .compile()?;
        writeln!(includes, "::modyn::include_model!({});", robot.name)?;
        writeln!(table, "    {:?} {type_name} [{}];", robot.name, names.join(" "))?;
    }
    let folder = std::env::var_os("OUT_DIR").ok_or("no OUT_DIR")?;
    let text = format!("{includes}\ngenerated! {{\n{table}}}\n");
    std::fs::write(Path::new(&folder).join("robots.rs"), text)?;
    Ok(())
}
