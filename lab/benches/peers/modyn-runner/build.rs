//! Compiles the robots of `robots.txt`, and writes tables of them for `src/generated.rs` and `src/c.rs`.

#[path = "src/robots.rs"]
mod robots;

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use modyn_codegen::{Builder, Function, Target, names};

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=../robots.txt");
    println!("cargo::rerun-if-changed=../../../../target/peers/robots");
    let folder = std::env::var_os("OUT_DIR").ok_or("no OUT_DIR")?;
    let folder = Path::new(&folder);
    let (mut includes, mut table, mut sources) = (String::new(), String::new(), String::new());
    for robot in robots::all() {
        let named = |name: &&str| {
            Function::ALL
                .iter()
                .copied()
                .find(|function| function.name() == *name)
                .expect("a function")
        };
        let functions: Vec<Function> = robot.quantities.iter().map(named).collect();
        let names = robot.quantities;
        let type_name = robot.type_name();
        let constrained = !robot.contacts.is_empty();
        let (kind, batch) = match (robot.batch, constrained) {
            (false, _) => ("none", None),
            (true, false) => ("free", Some(Function::ForwardDynamicsBatch)),
            (true, true) => ("constrained", Some(Function::ConstrainedForwardDynamicsBatch)),
        };
        let builder = Builder::new()
            .urdf(&robot.description)
            .base(robot.base)
            .contacts(robot.contacts.clone())
            .type_name(&type_name);
        let (name, text) = (&robot.name, builder.clone().functions(functions.clone()));
        text.write_as(Target::C, folder.join(format!("{name}.c")))?;
        let prefix = names::snake(&type_name);
        let [header, source] = ["h", "c"]
            .map(|kind| format!("include_str!(concat!(env!(\"OUT_DIR\"), \"/{name}.{kind}\"))"));
        writeln!(sources, "    ({name:?}, {prefix:?}, {header}, {source}),")?;
        builder.functions(functions.into_iter().chain(batch)).compile()?;
        writeln!(includes, "::modyn::include_model!({});", robot.name)?;
        let (contacts, names) = (robot.contacts.len(), names.join(" "));
        writeln!(table, "    {:?} {type_name} {kind} {contacts} [{names}];", robot.name)?;
    }
    std::fs::write(folder.join("robots.rs"), format!("{includes}\ngenerated! {{\n{table}}}\n"))?;
    std::fs::write(folder.join("c.rs"), format!("[\n{sources}]\n"))?;
    Ok(())
}
