//! Compiles forward dynamics of chains and robots, as straight-line code and as loops, and writes tables of them for
//! `src/main.rs` and `src/bin/cold.rs`.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use modyn_codegen::{Base, Builder, CodeForm, Function, ModuleChoice};
use modyn_reproduce::robots;

const LENGTHS: [usize; 6] = [4, 7, 14, 28, 56, 112];

const ROBOTS: [(&str, &str, Base); 5] = [
    ("arm7", "Arm7", Base::Fixed),
    ("quadruped", "Quadruped", Base::Fixed),
    ("quadruped", "FloatingQuadruped", Base::Floating),
    ("humanoid", "Humanoid", Base::Fixed),
    ("humanoid", "FloatingHumanoid", Base::Floating),
];

/// The types of a file, and the calls of a macro with them.
#[derive(Default)]
struct Types {
    items: String,
    table: String,
}

impl Types {
    /// Adds both forms of a robot, in a row that begins with `label`.
    fn add(&mut self, label: &str, name: &str, builder: &Builder) -> Result<(), Box<dyn Error>> {
        write!(self.table, "    {label}")?;
        for code in [CodeForm::Fast, CodeForm::Small] {
            let name = format!("{code:?}{name}");
            let generated = builder.clone().type_name(&name).code(code).generate()?;
            self.items += &generated.text;
            let mut counts = generated.operations.iter();
            let found = counts.find(|(name, _)| *name == "forward_dynamics");
            let (_, count) = found.ok_or("no forward dynamics")?;
            write!(self.table, " {name} {}", count.total())?;
        }
        writeln!(self.table, ";")?;
        Ok(())
    }

    /// Writes the types, and the call of the macro.
    fn write(self, folder: &Path, call: &str) -> Result<(), Box<dyn Error>> {
        let text = format!("{}\n{call}! {{\n{}}}\n", self.items, self.table);
        Ok(std::fs::write(folder.join(format!("{call}.rs")), text)?)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    let out = std::env::var_os("OUT_DIR").ok_or("no OUT_DIR")?;
    let mut chains = Types::default();
    for n in LENGTHS {
        let builder = Builder::new()
            .model(robots::chain(n))
            // The factorization by the user's modules limits the size; it is not generated here.
            .modules(ModuleChoice::Links)
            .functions([Function::ForwardDynamics]);
        chains.add(&n.to_string(), &format!("Chain{n}"), &builder)?;
    }
    chains.write(Path::new(&out), "chains")?;
    let mut all = Types::default();
    for (robot, name, base) in ROBOTS {
        let functions = [Function::ForwardDynamics, Function::Random];
        let file = format!("../../../robots/{robot}.urdf");
        let builder = Builder::new().urdf(file).base(base).functions(functions);
        let floating = if base == Base::Floating { ", floating" } else { "" };
        all.add(&format!("{:?}", format!("{robot}{floating}")), name, &builder)?;
    }
    all.write(Path::new(&out), "robots")
}
