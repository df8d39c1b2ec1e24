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

/// The items' text with `core` found through the module: in edition 2015 `::core` is no path to it.
pub(super) fn in_any_edition(items: &str) -> String {
    let core = format!("self::{MODULE}::__core::");
    let lines = items.lines().map(|line| match line.trim_start().starts_with("//") {
        true => line.to_owned(),
        false => outside_of_strings(line, |code| code.replace("::core::", &core)),
    });
    lines.flat_map(|line| [line, "\n".into()]).collect()
}

/// A line of Rust with what is no string changed. Strings must end in the line they begin in.
fn outside_of_strings(line: &str, change: impl Fn(&str) -> String) -> String {
    let (mut changed, mut rest) = (String::with_capacity(line.len()), line);
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

/// The module: what `items` mention of the runtime, and what that needs.
pub(super) fn module(items: &str) -> String {
    let mut text = format!(
        "\n/// The part of modyn's runtime that stands behind the text above, on `core` alone.\n\
         #[allow(clippy::all, clippy::pedantic, clippy::nursery, dead_code, unused_imports, unused_extern_crates)]\n\
         pub mod {MODULE} {{\n    #[doc(hidden)]\n    pub extern crate core as __core;\n\n"
    );
    let parameters = items.contains("__modyn::parameters::");
    let settings = items.contains("__modyn::ConstraintSettings");
    let spatial = parameters || settings || items.contains("__modyn::spatial::");
    let jacobi = parameters || items.contains("__modyn::jacobi::");
    let mut exports = vec!["pub use self::results::*;", "pub use self::scalar::Scalar;"];
    for module in ["configuration", "results"] {
        module_of(&mut text, &[module]);
    }
    exports.push("pub use self::configuration::ConfigurationError;");
    if parameters {
        module_of(&mut text, &["inertial"]);
        module_of(&mut text, &["parameters"]);
        exports.push("pub use self::inertial::{Inertial, InertialDefect};");
        exports.push("pub use self::parameters::ParameterError;");
    }
    if settings {
        module_of(&mut text, &["constraint_settings"]);
        exports.push(
            "pub use self::constraint_settings::{ConstraintSettings, ContactSet, ContactTarget};",
        );
    }
    if jacobi {
        module_of(&mut text, &["jacobi"]);
    }
    let scalar = ["abreast", "elementary", "float", "native", "real", "root", "trig"];
    folder_of(
        &mut text,
        "scalar",
        &scalar,
        "pub use self::real::Scalar;\n    pub(crate) use self::real::epsilon;",
    );
    if spatial {
        let exported = "pub use self::{\n        pose::Pose,\n        vector::Vector3,\n        \
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
    let public =
        [["configuration"], ["jacobi"], ["parameters"]].iter().any(|module| path == module);
    let visibility = if public { "pub mod" } else { "mod" };
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
        let line = line.replace("use core::", &format!("use {root}::__core::"));
        let _ = writeln!(text, "{}", format!("{inner}{line}").trim_end());
    }
    let _ = writeln!(text, "{indent}}}\n");
}

#[cfg(test)]
mod tests {
    use super::in_any_edition;

    #[test]
    fn core_is_found_through_the_module_and_strings_stay() {
        let text = "/// ::core::x\nf::<::core::x>(\"::core::\\\"::core::\\\\\", ::core::y);\n";
        let expected = "/// ::core::x\nf::<self::runtime::__core::x>(\"::core::\\\"::core::\\\\\", self::runtime::__core::y);\n";
        assert_eq!(in_any_edition(text), expected);
    }
}
