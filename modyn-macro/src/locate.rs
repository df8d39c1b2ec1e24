//! Finds the description, and makes rustc track the file.

use std::path::{Path, PathBuf};

use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::read::file::read_first;
use proc_macro2::Span;

/// The text of a description.
pub(crate) struct Found {
    pub text: String,
    /// The folder of the file.
    pub folder: PathBuf,
    /// An item that makes the crate depend on the file.
    pub tracking: String,
}

/// Reads `wanted` from the folder of the source file, or else from the folder of `Cargo.toml`.
pub(crate) fn locate(wanted: &str, span: Span) -> Result<Found, Diagnostics> {
    let root = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    // rustc names source files relative to its current folder, the workspace's root. A doc test has
    // no file of its own.
    let source = span.unwrap().local_file();
    let folders = source.as_deref().and_then(Path::parent).into_iter().chain(root.as_deref());
    let places: Vec<PathBuf> = folders.map(|folder| folder.join(wanted)).collect();
    let (place, text) = read_first(wanted, &places)?;
    let folder = place.parent().map(Path::to_owned).unwrap_or_default();
    Ok(Found { text, folder, tracking: tracking(place) })
}

/// Returns an item that makes rustc track the file. It contains no absolute path if Cargo runs
/// rustc.
pub(crate) fn tracking(place: &Path) -> String {
    let root = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let absolute = std::path::absolute(place).unwrap_or_else(|_| place.to_owned());
    // A file in another package of the workspace: the path leaves the package's folder first.
    let relative = root.as_deref().and_then(|root| {
        root.ancestors().enumerate().find_map(|(levels, base)| {
            let inside = Path::new(&"../".repeat(levels)).join(absolute.strip_prefix(base).ok()?);
            root.join(&inside).is_file().then_some(inside)
        })
    });
    let (before, path) = match &relative {
        Some(relative) => ("::core::env!(\"CARGO_MANIFEST_DIR\"), \"/\", ", relative.to_str()),
        None => ("", absolute.to_str()),
    };
    // A path that is not UTF-8 cannot be part of a source; such a file is not tracked.
    path.map_or_else(String::new, |path| {
        format!("const _: &[u8] = ::core::include_bytes!(::core::concat!({before}{path:?}));\n")
    })
}
