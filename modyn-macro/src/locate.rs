//! Where the description is, and how the compiler learns to watch it.

use std::path::{Path, PathBuf};

use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::read::file::read_first;
use proc_macro2::Span;

/// A description that was read.
pub(crate) struct Found {
    pub text: String,
    /// An item that makes the crate depend on the file.
    pub tracking: String,
}

/// Reads `wanted` from beside the source file, or from the folder of `Cargo.toml`.
pub(crate) fn locate(wanted: &str, span: Span) -> Result<Found, Diagnostics> {
    let root = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    // rustc names source files relative to where it was started, the workspace's root. A doc test
    // has no file of its own.
    let source = span.unwrap().local_file();
    let folders = source.as_deref().and_then(Path::parent).into_iter().chain(root.as_deref());
    let places: Vec<PathBuf> = folders.map(|folder| folder.join(wanted)).collect();
    let (place, text) = read_first(wanted, &places)?;
    Ok(Found { text, tracking: tracking(place, root.as_deref()) })
}

/// Has rustc note the file among those that the crate is made of. The text holds no absolute path
/// if Cargo runs rustc.
fn tracking(place: &Path, root: Option<&Path>) -> String {
    let absolute = std::path::absolute(place).unwrap_or_else(|_| place.to_owned());
    // A file in another package of the workspace: out of the root first.
    let relative = root.and_then(|root| {
        root.ancestors().enumerate().find_map(|(levels, base)| {
            let inside = Path::new(&"../".repeat(levels)).join(absolute.strip_prefix(base).ok()?);
            root.join(&inside).is_file().then_some(inside)
        })
    });
    let (before, path) = match &relative {
        Some(relative) => ("::core::env!(\"CARGO_MANIFEST_DIR\"), \"/\", ", relative.to_str()),
        None => ("", absolute.to_str()),
    };
    // A path that is no text cannot be written into a source; such a file is not watched.
    path.map_or_else(String::new, |path| {
        format!("const _: &[u8] = ::core::include_bytes!(::core::concat!({before}{path:?}));\n")
    })
}
