//! Reads the file of a description, for the macro, build scripts and the command line.

use std::fmt::Display;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::xml::document::USD_HELP;
use super::xml::limits::MAX_BYTES;
use crate::description::FileStore;
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Position, Report};

/// Returns the path and the text of the first of `places` that exists. Diagnostics name the file
/// `wanted`.
///
/// # Errors
///
/// If no place exists, or if the file cannot be read as text.
pub fn read_first(
    wanted: impl Display,
    places: &[PathBuf],
) -> Result<(&Path, String), Diagnostics> {
    read_first_of(&FileStore::default(), wanted, places)
}

/// Returns the path and the text of the first of `places` that exists in a store, as
/// [`read_first`].
fn read_first_of<'p>(
    files: &FileStore,
    wanted: impl Display,
    places: &'p [PathBuf],
) -> Result<(&'p Path, String), Diagnostics> {
    let Some(place) = places.iter().find(|place| files.exists(place)) else {
        let mut shown: Vec<String> = places.iter().map(|place| relative(place)).collect();
        shown.dedup();
        return Err(Diagnostic::missing_file(wanted, &shown).into());
    };
    Ok((place, read_in(files, wanted, place)?))
}

/// Returns the text of a file of a store. Diagnostics name the file `wanted`.
pub(super) fn read_in(
    files: &FileStore,
    wanted: impl Display,
    place: &Path,
) -> Result<String, Diagnostics> {
    let unreadable = |reason: &dyn Display| {
        let message = format!("`{}` cannot be read: {reason}", relative(place));
        let help = "give the path of a readable URDF file";
        Diagnostics::from(Diagnostic::error(Code::MissingFile, message).with_help(help))
    };
    // A device or a pipe might have no end.
    if !files.is_file(place) {
        return Err(unreadable(&"it is not a file"));
    }
    let (length, file) = files.open(place).map_err(|error| unreadable(&error))?;
    if length > MAX_BYTES as u64 {
        let message = format!("`{}` has {length} bytes, more than {MAX_BYTES}", relative(place));
        let help = "give the path of a URDF file; none is this large";
        return Err(Diagnostic::error(Code::Excessive, message).with_help(help).into());
    }
    // The file may have grown since.
    read_text(wanted, file)
}

/// Returns the text of a file that the description names at offset `at`, and the start of the file
/// in the report; `None` with an error in the report. Diagnostics name the file `shown`.
///
/// The robot depends on the file, whether it can be read or not.
pub(crate) fn read_named(
    files: &FileStore,
    path: &Path,
    shown: &str,
    at: usize,
    report: &mut Report<'_>,
) -> Option<(String, usize)> {
    report.depends_on(path.to_owned());
    match read_first_of(files, shown, &[path.to_owned()]) {
        Ok((_, text)) => {
            let start = report.add_file(shown.to_owned(), &text);
            Some((text, start))
        }
        Err(errors) => {
            for error in errors {
                let help = "give the path of a readable file, relative to the folder of the file that names it";
                report.error(error.code, at, None, error.message, help);
            }
            None
        }
    }
}

/// Returns the text of a stream, such as standard input. Diagnostics name it `wanted`.
///
/// # Errors
///
/// If the stream cannot be read, is not UTF-8, or is longer than any description.
pub fn read_text(wanted: impl Display, stream: impl Read) -> Result<String, Diagnostics> {
    read_at_most(MAX_BYTES, wanted, stream)
}

/// Returns the text of a stream of at most this number of bytes.
pub fn read_at_most(
    limit: usize,
    wanted: impl Display,
    stream: impl Read,
) -> Result<String, Diagnostics> {
    let mut bytes = Vec::new();
    stream.take(limit as u64 + 1).read_to_end(&mut bytes).map_err(|reason| {
        let message = format!("{wanted} cannot be read: {reason}");
        let help = "give a URDF as UTF-8 text";
        Diagnostics::from(Diagnostic::error(Code::MissingFile, message).with_help(help))
    })?;
    if bytes.len() > limit {
        let message = format!("{wanted} has more than {limit} bytes");
        let help = "give a URDF file; none is this large";
        return Err(Diagnostic::error(Code::Excessive, message).with_help(help).into());
    }
    if bytes.starts_with(b"PK\x03\x04") {
        let error =
            Diagnostic::error(Code::NotText, "this is a zip archive, such as MuJoCo's `.mjz`");
        let help = "unpack it, and give the path of the description in it: `unzip FILE -d FOLDER`";
        return Err(error.in_file(wanted.to_string()).with_help(help).into());
    }
    String::from_utf8(bytes).map_err(|error| not_text(wanted, &error))
}

/// Returns the error that a file is not UTF-8, with its place.
pub fn not_text(wanted: impl Display, error: &std::string::FromUtf8Error) -> Diagnostics {
    let (good, rest) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
    let line = String::from_utf8_lossy(good.rsplit(|&b| b == b'\n').next().unwrap_or_default());
    let position = Position {
        line: 1 + good.iter().filter(|&&b| b == b'\n').count(),
        column: 1 + line.chars().count(),
    };
    if good.starts_with(b"PXR-USDC") {
        let error = Diagnostic::error(Code::NotText, "this is a USD, which is not read");
        return error.in_file(wanted.to_string()).with_help(USD_HELP).into();
    }
    let byte = rest.first().copied().unwrap_or_default();
    Diagnostic::error(Code::NotText, format!("this is not UTF-8 text: byte 0x{byte:02x}"))
        .in_file(wanted.to_string())
        .at(position)
        .with_help("save the file as UTF-8")
        .into()
}

/// Returns a path relative to the folder of `Cargo.toml`, if it is inside.
fn relative(place: &Path) -> String {
    let root = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default();
    let absolute = std::path::absolute(place).unwrap_or_else(|_| place.into());
    absolute.strip_prefix(root).unwrap_or(place).display().to_string()
}
