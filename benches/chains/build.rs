//! Compiles forward dynamics of chains, and writes a table of them for `src/main.rs`.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use modyn_codegen::{Builder, Function, ModuleChoice};
use modyn_reproduce::robots;

const LENGTHS: [usize; 6] = [4, 7, 14, 28, 56, 112];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    let (mut includes, mut table) = (String::new(), String::new());
    for n in LENGTHS {
        let name = format!("Chain{n}");
        let generated = Builder::new()
            .model(robots::chain(n))
            // The factorization by the user's modules limits the size; it is not generated here.
            .modules(ModuleChoice::Links)
            .type_name(&name)
            .functions([Function::ForwardDynamics])
            .generate()?;
        includes += &generated.text;
        let (_, count) = generated.operations[0];
        writeln!(table, "    {name} {n} {};", count.total())?;
    }
    let out = std::env::var_os("OUT_DIR").ok_or("no OUT_DIR")?;
    let text = format!("{includes}\nchains! {{\n{table}}}\n");
    std::fs::write(Path::new(&out).join("chains.rs"), text)?;
    Ok(())
}
