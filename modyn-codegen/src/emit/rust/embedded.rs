//! The parts of the runtime that a self-contained file carries.

use std::fmt::Write as _;

use modyn_runtime::sources::{SOURCES, Source};

/// The name of the module in the file.
pub(super) const MODULE: &str = "runtime";

/// The replacement of `float/native` of the runtime, which uses `libm` and features.
const NATIVE: &str = "\
//! Operations with instructions on some processors only.

pub(super) use super::root::{sqrt_f32, sqrt_f64};

/// Returns a * b + c, rounded twice: the same on every processor.
#[inline]
pub(super) fn mul_add_f64(a: f64, b: f64, c: f64) -> f64 {
    a * b + c
}

/// Returns a * b + c, rounded twice: the same on every processor.
#[inline]
pub(super) fn mul_add_f32(a: f32, b: f32, c: f32) -> f32 {
    a * b + c
}

/// Runs work on packed limbs one limb after the other.
#[inline]
pub(super) fn run_simd_f64<W: crate::scalar::SimdTask<f64>>(work: W) -> W::Output {
    work.scalar()
}

/// Runs work on packed limbs one limb after the other.
#[inline]
pub(super) fn run_simd_f32<W: crate::scalar::SimdTask<f32>>(work: W) -> W::Output {
    work.scalar()
}
";

/// Returns the items with `core` found through the module, since `::core` is no path to it in
/// edition 2015.
pub fn in_any_edition(items: &str) -> String {
    let core = format!("self::{MODULE}::__core::");
    let lines = items.lines().map(|line| match line.trim_start().starts_with("//") {
        true => line.to_owned(),
        false => map_outside_strings(line, |code| code.replace("::core::", &core)),
    });
    lines.flat_map(|line| [line, "\n".into()]).collect()
}

/// Returns a line of Rust with `change` applied outside of strings. Strings must end on the line
/// they start on.
fn map_outside_strings(line: &str, change: impl Fn(&str) -> String) -> String {
    let mut changed = String::with_capacity(line.len());
    let mut rest = line;
    while let Some(start) = rest.find('"') {
        let mut escaped = false;
        let length = rest[start + 1..].find(|c| {
            let ends = c == '"' && !escaped;
            escaped = c == '\\' && !escaped;
            ends
        });
        let end = length.map_or(rest.len(), |length| start + length + 2);
        changed += &change(&rest[..start]);
        changed += &rest[start..end];
        rest = &rest[end..];
    }
    changed + &change(rest)
}

/// Returns the module with the parts of the runtime that `items` use, and their dependencies.
pub(super) fn module(items: &str) -> String {
    let mut text = format!(
        "\n/// The part of modyn's runtime that the text above uses; it needs `core` only.\n\
         #[allow(clippy::all, clippy::pedantic, clippy::nursery, dead_code, unused_imports, unused_extern_crates)]\n\
         pub mod {MODULE} {{\n    #[doc(hidden)]\n    pub extern crate core as __core;\n\n"
    );
    let parameters = items.contains("__modyn::parameters::");
    let settings = items.contains("__modyn::ConstraintSettings");
    let step_settings = items.contains("__modyn::StepSettings");
    let spatial = parameters || settings || step_settings || items.contains("__modyn::spatial::");
    let jacobi = parameters || items.contains("__modyn::jacobi::");
    let mut exports = vec![
        "pub use self::constants::*;",
        "pub use self::results::*;",
        "pub use self::scalar::Scalar;",
    ];
    for module in ["configuration", "constants", "results"] {
        write_module(&mut text, &[module]);
    }
    exports.push("pub use self::configuration::ConfigurationError;");
    if parameters {
        write_module(&mut text, &["inertial"]);
        write_module(&mut text, &["parameters"]);
        exports.push("pub use self::inertial::{Inertial, InertialDefect};");
        exports.push("pub use self::parameters::ParameterError;");
    }
    if settings {
        write_module(&mut text, &["constraint_settings"]);
        exports.push(
            "pub use self::constraint_settings::{ConstraintSettings, ContactSet, ContactTarget};",
        );
    }
    if step_settings {
        write_module(&mut text, &["step_settings"]);
        exports.push("pub use self::step_settings::{ContactSurface, StepSettings};");
    }
    if jacobi {
        write_module(&mut text, &["jacobi"]);
    }
    write_folder(&mut text, "float", &["elementary", "native", "root", "scalars"], "");
    write_folder(
        &mut text,
        "scalar",
        &["traits", "trig"],
        "pub(crate) use self::traits::epsilon;\n    pub use self::traits::{Chunk, Scalar, SimdTask};",
    );
    if spatial {
        let exported = "pub use self::{\n        pose::Pose,\n        vector::Vector3,\n        \
                        wrench::{Momentum, Twist, Wrench},\n    };";
        write_folder(&mut text, "spatial", &["pose", "vector", "wrench"], exported);
    }
    if items.contains("__modyn::solve::") {
        write_folder(
            &mut text,
            "solve",
            &["rank"],
            "pub use self::rank::{RowEquations, RowSolutions};",
        );
    }
    for export in exports {
        let _ = writeln!(text, "    {export}");
    }
    text + "}\n"
}

fn write_folder(text: &mut String, folder: &str, files: &[&str], exported: &str) {
    let _ = writeln!(text, "    pub mod {folder} {{\n        //! See `modyn::{folder}`.");
    for file in files {
        write_module(text, &[folder, file]);
    }
    if !exported.is_empty() {
        let _ = writeln!(text, "    {exported}");
    }
    let _ = writeln!(text, "    }}\n");
}

/// Prints one file of the runtime as a module.
fn write_module(text: &mut String, path: &[&str]) {
    let whole_source = match path {
        ["float", "native"] => NATIVE,
        _ => SOURCES
            .iter()
            .find(|Source { path: at, .. }| *at == path.join("/"))
            .map_or("", |s| s.text),
    };
    // Tests, examples and items for features are left out.
    let source = whole_source.split("\n#[cfg(test)]\n").next().unwrap_or_default();
    let root = vec!["super"; path.len()].join("::");
    let indent = "    ".repeat(path.len());
    let inner = "    ".repeat(path.len() + 1);
    let visibility = match path {
        ["configuration" | "jacobi" | "parameters"] => "pub mod",
        [_] => "mod",
        _ => "pub(crate) mod",
    };
    let _ = writeln!(text, "{indent}{visibility} {} {{", path[path.len() - 1]);
    let mut example = false;
    for line in source.lines() {
        if line.trim_start().starts_with("/// ```") {
            example = !example;
            continue;
        }
        if example || line.trim_start().starts_with("#[cfg_attr(feature") {
            continue;
        }
        let renamed = line.replace("crate::", &format!("{root}::"));
        let line = renamed.replace("use core::", &format!("use {root}::__core::"));
        let _ = writeln!(text, "{}", format!("{inner}{line}").trim_end());
    }
    let _ = writeln!(text, "{indent}}}\n");
}
