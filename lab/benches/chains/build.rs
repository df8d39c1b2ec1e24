//! Compiles forward dynamics of chains and robots and its derivatives of robots, as straight-line code and as loops, and writes tables
//! of them for `src/main.rs` and the files of `src/bin`.

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

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
    /// Adds both forms of a robot and its function, in a row that begins with `label`.
    fn add(
        &mut self,
        label: &str,
        name: &str,
        builder: &Builder,
        function: Function,
    ) -> Result<(), Box<dyn Error>> {
        write!(self.table, "    {label}")?;
        for code in [CodeForm::Unrolled, CodeForm::Looped] {
            let name = format!("{code:?}{name}");
            let functions = [function, Function::RandomConfiguration];
            let builder = builder.clone().functions(functions).type_name(&name).code(code);
            let generated = builder.generate()?;
            self.items += &generated.text;
            let mut counts = generated.operations.iter();
            let found = counts.find(|(name, _)| *name == function.name());
            let (_, count) = found.ok_or("no such function")?;
            write!(self.table, " {name} {}", count.total())?;
        }
        writeln!(self.table, ";")?;
        Ok(())
    }

    /// Writes a file of the types, and of the call of a macro, which starts with `start`.
    fn write(self, file: &Path, start: &str) -> Result<(), Box<dyn Error>> {
        let text = format!("{}\n{start}\n{}}}\n", self.items, self.table);
        Ok(std::fs::write(file, text)?)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("no OUT_DIR")?);
    let mut chains = Types::default();
    for n in LENGTHS {
        let builder = Builder::new()
            .model(robots::chain(n))
            // The factorization by the user's modules limits the size; it is not generated here.
            .modules(ModuleChoice::Links);
        chains.add(&n.to_string(), &format!("Chain{n}"), &builder, Function::ForwardDynamics)?;
    }
    chains.write(&out.join("chains.rs"), "chains! {")?;
    let mut of_robots = [Types::default(), Types::default()];
    for (robot, name, base) in ROBOTS {
        let file = format!("../../../robots/{robot}.urdf");
        let builder = Builder::new().urdf(file).base(base);
        let floating = if base == Base::Floating { ", floating" } else { "" };
        let label = format!("{:?}", format!("{robot}{floating}"));
        let functions = [Function::ForwardDynamics, Function::ForwardDynamicsDerivatives];
        for (types, function) in of_robots.iter_mut().zip(functions) {
            types.add(&label, name, &builder, function)?;
        }
    }
    let [forward, derivatives] = of_robots;
    forward.write(&out.join("robots.rs"), "robots! { forward_dynamics")?;
    derivatives.write(&out.join("derivatives.rs"), "robots! { forward_dynamics_derivatives")
}
