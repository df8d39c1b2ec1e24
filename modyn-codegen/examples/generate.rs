//! Writes a robot's dynamics to a file, or tells whether a file is stale:
//!
//! ```text
//! cargo run -p modyn-codegen --example generate -- \
//!     [--self-contained] [--scalar f32] [--functions a,b] [--type-name Name] [--c PREFIX]
//!     [--check] ROBOT.urdf [OUT.rs]
//! ```
//!
//! Without OUT the text goes to standard output.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use modyn_codegen::{Builder, FloatType, Function};

const USAGE: &str = "usage: generate [--self-contained] [--scalar f32|f64] [--functions all|a,b,...] \
    [--type-name Name] [--c PREFIX] [--check] ROBOT.urdf [OUT.rs]";

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut builder = Builder::new();
    let (mut check, mut paths) = (false, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(USAGE);
        builder = match argument.as_str() {
            "--self-contained" => builder.self_contained(),
            "--scalar" => match value()?.as_str() {
                "f32" => builder.float(FloatType::F32),
                "f64" => builder.float(FloatType::F64),
                other => return Err(format!("there is no scalar `{other}`").into()),
            },
            "--functions" => builder.functions(functions(&value()?)?),
            "--type-name" => builder.type_name(value()?),
            "--c" => builder.c_functions(value()?),
            "--check" => {
                check = true;
                builder
            }
            other if other.starts_with('-') => return Err(format!("{other}? {USAGE}").into()),
            path => {
                paths.push(PathBuf::from(path));
                builder
            }
        };
    }
    match (paths.as_slice(), check) {
        // Paths are from where the user stands, not from this crate.
        ([robot, out], _) => {
            let builder = builder.urdf(std::path::absolute(robot)?);
            if check {
                let stale = builder.is_stale(out)?;
                println!("{} is {}", out.display(), if stale { "stale" } else { "up to date" });
                return Ok(if stale { ExitCode::FAILURE } else { ExitCode::SUCCESS });
            }
            for warning in builder.write(out)?.warnings {
                eprintln!("{warning}");
            }
        }
        ([robot], false) => {
            print!("{}", builder.urdf(std::path::absolute(robot)?).generate()?.text);
        }
        _ => return Err(USAGE.into()),
    }
    Ok(ExitCode::SUCCESS)
}

fn functions(names: &str) -> Result<Vec<Function>, String> {
    if names == "all" {
        return Ok(Function::ALL.to_vec());
    }
    let function =
        |name: &str| Function::from_name(name).ok_or_else(|| format!("no function `{name}`"));
    names.split(',').map(function).collect()
}
