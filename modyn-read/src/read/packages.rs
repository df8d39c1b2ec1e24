//! The folders of ROS packages, which descriptions name.

use std::ffi::OsStr;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use rustc_hash::FxHashMap;

use super::xml::element::is;
use crate::description::{Package, ReadOptions};

/// The environment variables with folders of packages, in the order of their precedence.
pub const PACKAGE_PATHS: [&str; 2] = ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"];

/// The largest number of neighbours of a folder whose `package.xml` is read.
const MAX_NEIGHBOURS: usize = 1000;

/// The largest number of bytes of a `package.xml`.
const MAX_BYTES: u64 = 1 << 20;

/// Finds the folders of packages, each once.
#[derive(Default)]
pub struct Packages {
    folders: FxHashMap<String, Option<PathBuf>>,
}

impl Packages {
    /// Returns the folder of a package: by the option `packages`; by the folders that contain the
    /// description and their neighbours, of which one has a `package.xml` with this `<name>`; by
    /// `ROS_PACKAGE_PATH` and `AMENT_PREFIX_PATH`; or the folder of this name that contains the
    /// description.
    ///
    /// A description without a folder has the packages of the options alone. Files in memory are
    /// found without the folder: any package is the folder of its name.
    pub fn find(&mut self, name: &str, options: &ReadOptions) -> Option<PathBuf> {
        if !self.folders.contains_key(name) {
            self.folders.insert(name.to_owned(), find(name, options));
        }
        self.folders.get(name).cloned().flatten()
    }
}

fn find(name: &str, options: &ReadOptions) -> Option<PathBuf> {
    if let Some(Package { folder, .. }) =
        options.packages.iter().find(|package| package.name == name)
    {
        let root = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default();
        return Some(Path::new(&root).join(folder));
    }
    let folder = options.folder.as_deref()?;
    if options.files.is_in_memory() {
        return Some(PathBuf::from(name));
    }
    // A name of several parts would leave the folders that are searched.
    let parts: Vec<Component<'_>> = Path::new(name).components().collect();
    let [Component::Normal(_)] = parts[..] else { return None };
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
    let is_meant = |folder: &PathBuf| is_package(folder, name);
    // Most packages are in a folder of their name, which needs no list of the neighbours.
    let near = absolute.ancestors().flat_map(|folder| [folder.to_owned(), folder.join(name)]);
    let of_ros = || {
        PACKAGE_PATHS.iter().find_map(|variable| {
            let list = std::env::var_os(variable)?;
            let folders: Vec<PathBuf> = std::env::split_paths(&list).collect();
            let usual = folders.iter().flat_map(|folder| {
                [folder.clone(), folder.join(name), folder.join("share").join(name)]
            });
            let inside = folders.iter().flat_map(|folder| inside(folder));
            usual.chain(inside).find(is_meant)
        })
    };
    let above = || {
        let is_named = |folder: &&Path| folder.file_name() == Some(OsStr::new(name));
        absolute.ancestors().find(is_named).map(Path::to_owned)
    };
    near.into_iter()
        .find(is_meant)
        .or_else(|| absolute.ancestors().flat_map(inside).find(is_meant))
        .or_else(of_ros)
        .or_else(above)
}

/// Returns the folders in a folder, in the order of their names; none if there are too many to look
/// into.
fn inside(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut folders: Vec<PathBuf> =
        entries.take(MAX_NEIGHBOURS + 1).map(|entry| entry.path()).collect();
    if folders.len() > MAX_NEIGHBOURS {
        return Vec::new();
    }
    folders.sort();
    folders
}

/// Returns whether a folder has a `package.xml` with this `<name>`; a package without a name has
/// the name of its folder.
fn is_package(folder: &Path, name: &str) -> bool {
    let Ok(file) = File::open(folder.join("package.xml")) else { return false };
    let mut text = String::new();
    let is_text = file.take(MAX_BYTES).read_to_string(&mut text).is_ok();
    let document = roxmltree::Document::parse(&text).ok().filter(|_| is_text);
    let written = document.as_ref().and_then(|document| {
        let mut elements = document.root_element().children();
        elements.find(|node| is(*node, "name"))?.text()
    });
    match written {
        Some(written) => written.trim() == name,
        None => folder.file_name() == Some(OsStr::new(name)),
    }
}
