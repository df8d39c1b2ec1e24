//! The files that a description can name: files of the file system, or files in memory.

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// The place from which a description and the files that it names are read.
///
/// Files in memory are found by the end of their path: `package://arm/meshes/hand.stl` is the file
/// `hand.stl`, unless the files have one in a folder `meshes`, which is preferred. Nothing is read
/// from the file system then.
///
/// ```
/// use modyn_read::{FileStore, ReadOptions};
///
/// let main = r#"<mujoco><include file="parts/arm.xml"/></mujoco>"#;
/// let arm = r#"<mujoco><worldbody><body name="arm"><joint axis="0 1 0"/>
///     <inertial pos="0 0 1" mass="2" diaginertia="1 1 1"/></body></worldbody></mujoco>"#;
/// let files = FileStore::in_memory([("arm.xml".into(), arm.as_bytes().to_vec())]);
/// let options = ReadOptions { folder: Some("".into()), files, ..ReadOptions::default() };
/// assert_eq!(modyn_read::read(main, "robot.xml", &options)?.model.nv(), 1);
/// # Ok::<(), modyn_read::diagnostics::Diagnostics>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileStore(Option<Arc<[MemoryFile]>>);

#[derive(Debug, PartialEq)]
struct MemoryFile {
    path: PathBuf,
    bytes: Vec<u8>,
}

/// Returns the number of components at the ends of two paths that are equal.
fn common_end(a: &Path, b: &Path) -> usize {
    let names = |path: &Path| -> Vec<_> {
        let parts = path.components().filter(|part| matches!(part, Component::Normal(_)));
        parts.map(|part| part.as_os_str().to_owned()).collect()
    };
    let a = names(a);
    let b = names(b);
    a.iter().rev().zip(b.iter().rev()).take_while(|(a, b)| a == b).count()
}

impl FileStore {
    /// Returns the files with these paths and contents.
    #[must_use]
    pub fn in_memory(files: impl IntoIterator<Item = (PathBuf, Vec<u8>)>) -> Self {
        let files = files.into_iter().map(|(path, bytes)| MemoryFile { path, bytes });
        Self(Some(files.collect()))
    }

    /// Returns the text of a file, for display; empty if it cannot be read.
    #[must_use]
    pub fn text(&self, path: &Path) -> String {
        let mut bytes = Vec::new();
        let read = self.open(path).and_then(|(_, mut file)| file.read_to_end(&mut bytes));
        read.map(|_| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default()
    }

    /// Returns whether the files are in memory.
    pub(crate) fn is_in_memory(&self) -> bool {
        self.0.is_some()
    }

    /// Returns the file in memory whose path has the longest common end with this path, the first
    /// of several; `None` if none has its name.
    fn find(files: &[MemoryFile], path: &Path) -> Option<usize> {
        let ends = files.iter().map(|file| common_end(&file.path, path)).enumerate();
        let best = ends.rev().max_by_key(|(_, end)| *end)?;
        (best.1 > 0).then_some(best.0)
    }

    /// Returns whether there is a file at this path.
    pub(crate) fn is_file(&self, path: &Path) -> bool {
        match &self.0 {
            None => path.is_file(),
            Some(files) => Self::find(files, path).is_some(),
        }
    }

    /// Returns whether there is a folder at this path.
    pub(crate) fn is_folder(&self, path: &Path) -> bool {
        match &self.0 {
            None => path.is_dir(),
            Some(files) => files.iter().any(|file| {
                file.path.ancestors().skip(1).any(|folder| common_end(folder, path) > 0)
            }),
        }
    }

    /// Returns whether there is anything at this path.
    pub(crate) fn exists(&self, path: &Path) -> bool {
        match &self.0 {
            None => path.exists(),
            Some(_) => self.is_file(path) || self.is_folder(path),
        }
    }

    /// Returns the path under which a file is in memory; on the file system the path itself.
    pub(crate) fn named(&self, path: PathBuf) -> PathBuf {
        if self.is_in_memory() { self.canonical(&path) } else { path }
    }

    /// Returns the path that is equal for all paths of a file.
    pub(crate) fn canonical(&self, path: &Path) -> PathBuf {
        let canonical = match &self.0 {
            None => std::fs::canonicalize(path).ok(),
            Some(files) => Self::find(files, path).map(|file| files[file].path.clone()),
        };
        canonical.unwrap_or_else(|| path.to_owned())
    }

    /// Returns the number of bytes of the file at this path, and its content.
    ///
    /// # Errors
    ///
    /// If the file cannot be opened.
    pub(crate) fn open(&self, path: &Path) -> io::Result<(u64, Box<dyn Read + '_>)> {
        match &self.0 {
            None => {
                let file = File::open(path)?;
                Ok((file.metadata()?.len(), Box::new(file)))
            }
            Some(files) => {
                let file = Self::find(files, path).ok_or(io::ErrorKind::NotFound)?;
                let bytes = &files[file].bytes;
                Ok((bytes.len() as u64, Box::new(Cursor::new(bytes))))
            }
        }
    }
}
