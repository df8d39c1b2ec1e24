//! Measures what each function of a robot costs to compile: the time to generate it, rustc's time (for a crate with
//! this function alone, beyond that of a crate with constants alone), and the machine code.
//!
//! ```console
//! cargo run -p modyn-codegen --example cost -- robots/arm7.urdf robots/humanoid.urdf
//! cargo run -p modyn-codegen --example cost -- tests/golden/g1.urdf forward_dynamics
//! cargo run -p modyn-codegen --example cost -- tests/golden/solo12.urdf point:FL_FOOT point:HR_FOOT impact_dynamics
//! ```
//!
//! Without names of functions, all are measured. A robot with contacts (points and surfaces of links, as
//! `point:foot@0.1,0,-0.02` with an origin) has a floating base.
//!
//! The output is a table in Markdown, from which `lab/record` makes `docs/data/functions.tsv` (operations are in
//! `docs/data/operations.tsv`). Times are processor time, so that other work on the machine matters little. Do not run it
//! with `--release`: macros and build scripts, which generate, run unoptimised. The crates are written to and built in the
//! folder `target/cost`. It needs Linux, which says how much processor time children took.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;

use modyn_codegen::{Base, Builder, Contact, ContactKind, Function, LoopEnd};
use object::{Object as _, ObjectSection as _, SectionKind};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize()?;
    let folder = workspace.join("target/cost");
    std::fs::create_dir_all(folder.join("src"))?;
    let manifest = format!(
        "[package]\nname = \"cost\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\n\
         modyn-runtime = {{ path = {:?}, default-features = false, features = [\"std\"] }}\n\n\
         [profile.release]\ncodegen-units = 1\n\n[workspace]\n",
        workspace.join("modyn-runtime")
    );
    std::fs::write(folder.join("Cargo.toml"), manifest)?;
    println!("| robot | function | generated, s | debug, s | release, s | code, kB |");
    println!("|---|---|---|---|---|---|");
    let named = |argument: &String| Function::ALL.iter().find(|f| f.name() == argument).copied();
    let (functions, others): (Vec<_>, Vec<_>) =
        std::env::args().skip(1).partition(|argument| named(argument).is_some());
    let functions: Vec<Function> = functions.iter().filter_map(named).collect();
    // Contacts follow their robot.
    let mut robots: Vec<(String, Vec<Contact>)> = Vec::new();
    for argument in others {
        match (contact(&argument), robots.last_mut()) {
            (Some(contact), Some((_, contacts))) => contacts.push(contact),
            _ => robots.push((argument, Vec::new())),
        }
    }
    for (path, contacts) in robots {
        let robot = Path::new(&path).file_stem().unwrap_or_default().to_string_lossy();
        let path = std::env::current_dir()?.join(&path);
        let generate = |functions: &[Function]| {
            let mut builder = Builder::new().urdf(&path).crate_("::modyn_runtime");
            if !contacts.is_empty() {
                builder = builder.base(Base::Floating).contacts(contacts.clone());
            }
            builder.functions(functions.iter().copied()).generate()
        };
        let alone = generate(&[])?.text;
        // The dependencies, too, are compiled the first time.
        let debug_alone = least(|| debug(&folder, &alone))?;
        let release_alone = least(|| release(&folder, &alone))?;
        for &function in if functions.is_empty() { Function::ALL } else { &functions[..] } {
            let before = processor_time(Whose::Own)?;
            let generated = generate(&[function])?;
            let taken = processor_time(Whose::Own)? - before;
            let operations = generated.operations.iter().find(|(name, _)| *name == function.name());
            // A robot without loops has no function for them.
            if operations.is_none() {
                continue;
            }
            println!(
                "| {robot} | `{}` | {taken:.2} | {:.2} | {:.2} | {:.1} |",
                function.name(),
                (debug(&folder, &generated.text)? - debug_alone).max(0.0),
                (release(&folder, &generated.text)? - release_alone).max(0.0),
                code(&folder)? as f64 / 1000.0
            );
        }
    }
    Ok(())
}

/// Reads `KIND:LINK`; `None` for another word.
fn contact(text: &str) -> Option<Contact> {
    let (kind, place) = text.split_once(':')?;
    let (link, origin) = place.split_once('@').unwrap_or((place, "0,0,0"));
    let origin: Option<Vec<f64>> = origin.split(',').map(|x| x.parse().ok()).collect();
    let end = LoopEnd { link: link.into(), xyz: origin?.try_into().ok()?, rpy: [0.0; 3] };
    Some(Contact { name: place.into(), kind: ContactKind::from_name(kind)?, end })
}

/// Seconds in Cargo for a debug build.
fn debug(folder: &Path, text: &str) -> Result<f64> {
    compile(folder, text, &["rustc", "--quiet", "--lib"])
}

/// Seconds in Cargo for a release build.
fn release(folder: &Path, text: &str) -> Result<f64> {
    compile(folder, text, &["rustc", "--release", "--quiet", "--lib", "--", "--emit=obj"])
}

fn compile(folder: &Path, text: &str, arguments: &[&str]) -> Result<f64> {
    std::fs::write(folder.join("src/lib.rs"), text)?;
    let before = processor_time(Whose::Childrens)?;
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    command.args(arguments).current_dir(folder).env("CARGO_TARGET_DIR", folder.join("target"));
    if !command.status()?.success() {
        return Err("the generated crate does not compile".into());
    }
    Ok(processor_time(Whose::Childrens)? - before)
}

/// The least of a few.
fn least(measure: impl Fn() -> Result<f64>) -> Result<f64> {
    (0..4).try_fold(f64::INFINITY, |least, _| Ok(least.min(measure()?)))
}

#[derive(Clone, Copy)]
enum Whose {
    Own,
    Childrens,
}

/// Seconds of processor time, of this process or of all children that have ended.
fn processor_time(whose: Whose) -> Result<f64> {
    let text = std::fs::read_to_string("/proc/self/stat")?;
    let (_, behind_the_name) = text.rsplit_once(") ").ok_or("no statistics")?;
    let first = match whose {
        Whose::Own => 11,
        Whose::Childrens => 13,
    };
    let ticks = behind_the_name.split(' ').skip(first).take(2).map(str::parse::<f64>);
    let ticks: std::result::Result<Vec<f64>, _> = ticks.collect();
    // A tick is a hundredth of a second on all of Linux.
    Ok(ticks?.iter().sum::<f64>() / 100.0)
}

/// Bytes of machine code of the last release build.
fn code(folder: &Path) -> Result<u64> {
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
    Ok(bytes)
}
