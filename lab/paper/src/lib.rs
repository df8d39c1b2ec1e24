//! The paper's tables and plots, reproduced, and studies beyond them.
//!
//! `cargo run --release --manifest-path lab/Cargo.toml -- OUTDIR` writes all of them into a folder with an index
//! page, the paper's numbers beside modyn's. Each topic has one file; `docs/internals/equations.md` lists the equations with their places.

pub mod biped;
pub mod complexity;
pub mod conditioning;
pub mod dense;
pub mod energy;
pub mod gait;
pub mod gripper;
pub mod motion;
pub mod parallel;
pub mod plot;
pub mod precision;
pub mod report;
pub mod robots;
pub mod scalar;
pub mod stability;
pub mod table6;

use std::path::{Path, PathBuf};

use report::{Failure, Report, Table};

/// Returns the tables that pages of the documentation show, with the names of their files in `docs/data`.
#[must_use]
pub fn tables() -> [(&'static str, Table); 5] {
    let [gripper, biped] = stability::tables();
    let [single, fixed] = precision::tables();
    [
        ("table5-gripper", gripper),
        ("table5-biped", biped),
        ("stability-f32", single),
        ("stability-fixed", fixed),
        ("fig6", complexity::table()),
    ]
}

/// Writes everything into `folder`, and returns the path of the page.
///
/// # Errors
///
/// If a file cannot be written.
pub fn run(folder: &Path) -> Result<PathBuf, Failure> {
    let mut report = Report::new(folder)?;
    gripper::report(&mut report);
    stability::report(&mut report)?;
    precision::report(&mut report)?;
    complexity::report(&mut report)?;
    biped::report(&mut report)?;
    energy::report(&mut report)?;
    conditioning::report(&mut report)?;
    parallel::report(&mut report)?;
    Ok(report.write()?)
}
