//! The state of reading several files.

use std::path::PathBuf;

/// The files that were read, and the folders in which others are looked for.
pub struct Files {
    /// The folder of the current file; `None`: no other file is read.
    pub folder: Option<PathBuf>,
    /// The folder of the first file.
    pub first: Option<PathBuf>,
    /// The files that are being read, each included by the one before.
    pub open: Vec<PathBuf>,
    /// The number of files so far.
    pub count: usize,
}
