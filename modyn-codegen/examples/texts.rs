//! Prints a hash of the text that is generated for each of the repository's robots, by every kind of
//! output, and of each model that is read from an MJCF or an SDF of the tests.
//!
//! ```console
//! cargo run -p modyn-codegen --example texts
//! ```
//!
//! The output is the same on every host and however the compiler was built: `lab/check` compares that of a
//! compiler with fused products and of one without.

use std::error::Error;
use std::path::{Path, PathBuf};

use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::{Builder, FloatType, Function, ReadOptions};
use rayon::prelude::*;

/// 64-bit FNV-1a.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

fn descriptions(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == ending) {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut cases = Vec::new();
    for folder in ["robots", "tests/golden"] {
        for path in descriptions(&root.join(folder), "urdf")? {
            let name = name(&path);
            // Hessians and implicit steps are made of the same numbers; with them, a humanoid's text would be too long.
            let functions = Function::ALL.iter().copied();
            let functions = functions.filter(|function| {
                !["hessian", "midpoint", "rk4_derivatives"]
                    .iter()
                    .any(|word| function.name().contains(word))
            });
            let builder = Builder::new().urdf(&path).functions(functions);
            let shared = builder.clone().share_limbs();
            let contained = builder.clone().self_contained().runtime_gravity();
            cases.push((format!("{name} f32"), builder.clone().scalar(FloatType::F32)));
            cases.push((format!("{name} f64"), builder));
            cases.push((format!("{name} shared"), shared));
            cases.push((format!("{name} self-contained"), contained.c_functions("robot")));
        }
    }
    let line = |(name, builder): (String, Builder)| {
        let generated = builder.generate()?;
        let header = generated.c_header.unwrap_or_default();
        Ok(format!("{:016x} {:016x} {name}", hash(&generated.text), hash(&header)))
    };
    let lines: Result<Vec<String>, Diagnostics> = cases.into_par_iter().map(line).collect();
    lines?.iter().for_each(|line| println!("{line}"));
    for (folder, ending) in [("mjcf", "xml"), ("sdf", "sdf")] {
        for path in descriptions(&root.join("modyn-read/tests").join(folder), ending)? {
            // A file without a robot is a part of another one.
            if let Ok(reading) = modyn_read::read_file(&path, &ReadOptions::default()) {
                println!("{:016x} {} model", hash(&format!("{:?}", reading.model)), name(&path));
            }
        }
    }
    Ok(())
}
