//! `cargo run --release --manifest-path lab/Cargo.toml [-- OUTDIR]`: makes all tables and plots.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let folder = std::env::args_os().nth(1).unwrap_or_else(|| "target/reproduce".into());
    match modyn_reproduce::run(Path::new(&folder)) {
        Ok(page) => {
            println!("{}", page.display());
            ExitCode::SUCCESS
        }
        Err(failure) => {
            eprintln!("{}: {failure}", Path::new(&folder).display());
            ExitCode::FAILURE
        }
    }
}
