//! What each function of a robot costs to compile: its time in rustc (release, one crate with this
//! function alone, over that of one with constants alone) and its machine code.
//!
//! ```console
//! cargo run --release -p modyn-codegen --example cost -- robots/arm7.urdf robots/humanoid.urdf
//! ```
//!
//! A table in Markdown. The crates are written to and built in the folder `target/cost`.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use modyn_codegen::{Builder, Function};
use object::{Object as _, ObjectSection as _, SectionKind};

fn main() -> Result<(), Box<dyn Error>> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize()?;
    let folder = workspace.join("target/cost");
    std::fs::create_dir_all(folder.join("src"))?;
    let manifest = format!(
        "[package]\nname = \"cost\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n\
         [dependencies]\nmodyn-runtime = {{ path = {:?}, default-features = false }}\n\n\
         [profile.release]\ncodegen-units = 1\n\n[workspace]\n",
        workspace.join("modyn-runtime")
    );
    std::fs::write(folder.join("Cargo.toml"), manifest)?;
    println!("| robot | function | operations | rustc, s | code, kB |");
    println!("|---|---|---|---|---|");
    for path in std::env::args().skip(1) {
        let robot = Path::new(&path).file_stem().unwrap_or_default().to_string_lossy();
        let path = std::env::current_dir()?.join(&path);
        let compile = |functions: &[Function]| {
            let builder = Builder::new().urdf(&path).krate("::modyn_runtime");
            builder.functions(functions.iter().copied()).generate()
        };
        // The dependencies, too, are compiled the first time.
        measure(&folder, &compile(&[])?.text)?;
        let (base, _) = measure(&folder, &compile(&[])?.text)?;
        for &function in Function::ALL.iter().filter(|function| function.batched().is_none()) {
            let generated = compile(&[function])?;
            let operations = generated.operations.iter().find(|(name, _)| *name == function.name());
            let operations = operations.map_or(0, |(_, count)| count.total());
            let (seconds, bytes) = measure(&folder, &generated.text)?;
            println!(
                "| {robot} | `{}` | {operations} | {:.2} | {:.1} |",
                function.name(),
                (seconds - base).max(0.0),
                bytes as f64 / 1000.0
            );
        }
    }
    Ok(())
}

/// Seconds in Cargo, and bytes of machine code.
fn measure(folder: &Path, text: &str) -> Result<(f64, u64), Box<dyn Error>> {
    std::fs::write(folder.join("src/lib.rs"), format!("#![no_std]\n{text}"))?;
    let start = Instant::now();
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    command.args(["rustc", "--release", "--quiet", "--lib", "--", "--emit=obj"]);
    command.current_dir(folder).env("CARGO_TARGET_DIR", folder.join("target"));
    if !command.status()?.success() {
        return Err("the generated crate does not compile".into());
    }
    let seconds = start.elapsed().as_secs_f64();
    let objects = std::fs::read_dir(folder.join("target/release/deps"))?;
    let objects: Vec<PathBuf> = objects
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "o"))
        .filter(|path| path.file_name().is_some_and(|n| n.to_string_lossy().starts_with("cost")))
        .collect();
    let mut bytes = 0;
    for path in objects {
        let data = std::fs::read(&path)?;
        let sections = object::File::parse(&*data)?;
        let code = sections.sections().filter(|section| section.kind() == SectionKind::Text);
        bytes += code.map(|section| section.size()).sum::<u64>();
        std::fs::remove_file(path)?;
    }
    Ok((seconds, bytes))
}
