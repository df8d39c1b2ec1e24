//! The part of the runtime that a self-contained file carries with it.

use std::fmt::Write as _;

use modyn_runtime::sources::{SOURCES, Source};

/// What it is called in the file.
pub(super) const MODULE: &str = "runtime";

/// Stands for `scalar/native` of the runtime, which has `libm` and features.
const NATIVE: &str = "\
//! What only some processors have instructions for.

pub(super) use super::root::{sqrt_f32, sqrt_f64};

/// a * b + c, rounded twice: the same on every processor.
#[inline]
pub(super) fn mul_add_f64(a: f64, b: f64, c: f64) -> f64 {
    a * b + c
}

/// a * b + c, rounded twice: the same on every processor.
#[inline]
pub(super) fn mul_add_f32(a: f32, b: f32, c: f32) -> f32 {
    a * b + c
}

/// Equal limbs, one after the other.
#[inline]
pub(super) fn abreast_f64<W: super::abreast::Abreast<f64>>(work: W) -> W::Output {
    work.scalar()
}

/// Equal limbs, one after the other.
#[inline]
pub(super) fn abreast_f32<W: super::abreast::Abreast<f32>>(work: W) -> W::Output {
    work.scalar()
}
";

/// The module: what `items` mention of the runtime, and what that needs.
pub(super) fn module(items: &str) -> String {
    let mut text = format!(
        "\n/// The part of modyn's runtime that stands behind the text above, on `core` alone.\n\
         #[allow(clippy::all, clippy::pedantic, clippy::nursery, dead_code, unused_imports)]\n\
         pub mod {MODULE} {{\n"
    );
    let payload = items.contains("__modyn::Payload");
    let spatial = payload || items.contains("__modyn::spatial::");
    let jacobi = payload || items.contains("__modyn::jacobi::");
    let mut exports = vec!["pub use results::*;", "pub use scalar::Scalar;"];
    module_of(&mut text, &["results"]);
    if payload {
        module_of(&mut text, &["inertial"]);
        exports.push("pub use inertial::{Inertial, InertialDefect, Payload};");
    }
    if jacobi {
        module_of(&mut text, &["jacobi"]);
    }
    let scalar = ["abreast", "elementary", "float", "native", "real", "root", "trig"];
    folder_of(&mut text, "scalar", &scalar, "pub use real::Scalar;");
    if spatial {
        let exported = "pub use {\n        pose::Pose,\n        vector::Vector3,\n        \
                        wrench::{Momentum, Twist, Wrench},\n    };";
        folder_of(&mut text, "spatial", &["pose", "vector", "wrench"], exported);
    }
    for export in exports {
        let _ = writeln!(text, "    {export}");
    }
    text + "}\n"
}

fn folder_of(text: &mut String, folder: &str, files: &[&str], exported: &str) {
    let _ = writeln!(text, "    pub mod {folder} {{\n        //! See `modyn::{folder}`.");
    for file in files {
        module_of(text, &[folder, file]);
    }
    let _ = writeln!(text, "    {exported}\n    }}\n");
}

/// One file of the runtime as a module.
fn module_of(text: &mut String, path: &[&str]) {
    let source = match path {
        ["scalar", "native"] => NATIVE,
        _ => SOURCES
            .iter()
            .find(|Source { path: at, .. }| *at == path.join("/"))
            .map_or("", |s| s.text),
    };
    // What tests and documents it does not stand alone, nor does what features add.
    let source = source.split("\n#[cfg(test)]\n").next().unwrap_or_default();
    let root = vec!["super"; path.len()].join("::");
    let (indent, inner) = ("    ".repeat(path.len()), "    ".repeat(path.len() + 1));
    let visibility = if path == ["jacobi"] { "pub mod" } else { "mod" };
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
        let line = line.replace("crate::", &format!("{root}::"));
        let _ = writeln!(text, "{}", format!("{inner}{line}").trim_end());
    }
    let _ = writeln!(text, "{indent}}}\n");
}
