//! Where the description is, and how the compiler learns to watch it.

use std::path::{Path, PathBuf};

use modyn_codegen::error::{Diagnostic, Diagnostics};
use proc_macro2::Span;

/// A description that was read.
pub(crate) struct Found {
    pub text: String,
    /// An item that makes the crate depend on the file.
    pub tracking: String,
}

/// Reads `wanted` from beside the source file, or from the folder of `Cargo.toml`.
pub(crate) fn locate(wanted: &str, span: Span) -> Result<Found, Diagnostics> {
    let root = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from).unwrap_or_default();
    // rustc names source files relative to where it was started, the workspace's root.
    let beside = span
        .unwrap()
        .local_file()
        .and_then(|file| file.parent().map(|folder| (folder.join(wanted), folder.to_owned())));
    let mut tried = Vec::new();
    if let Some((place, _)) = beside {
        tried.push(place);
    }
    tried.push(root.join(wanted));
    for place in &tried {
        if let Ok(text) = std::fs::read_to_string(place) {
            let tracked = tracked(place, &root);
            let tracking = format!("const _: &[u8] = ::core::include_bytes!({tracked});\n");
            return Ok(Found { text, tracking });
        }
    }
    let places: Vec<_> = tried.iter().map(|place| place.display()).collect();
    Err(Diagnostic::missing_file(wanted, &places).into())
}

/// An expression for the file's path without an absolute path in it.
fn tracked(place: &Path, root: &Path) -> String {
    let absolute = std::path::absolute(place).unwrap_or_else(|_| place.to_owned());
    // The path of a file in another package of the workspace leads out of the root first.
    let mut up = String::new();
    for base in root.ancestors() {
        if let Ok(inside) = absolute.strip_prefix(base) {
            let inside = format!("{up}/{}", inside.display());
            return format!("::core::concat!(::core::env!(\"CARGO_MANIFEST_DIR\"), {inside:?})");
        }
        up.push_str("/..");
    }
    format!("{:?}", absolute.display().to_string())
}
