//! The folders of ROS packages, which descriptions name.

use std::path::{Component, Path, PathBuf};

use crate::description::{Package, ReadOptions};

/// The environment variables with folders of packages, in the order of their precedence.
pub const PACKAGE_PATHS: [&str; 2] = ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"];

/// Returns the folder of a package: by the option `packages`; by the folders that contain the description and their
/// neighbours, of which one has this name and a `package.xml`; by `ROS_PACKAGE_PATH` and `AMENT_PREFIX_PATH`; or the folder of
/// this name that contains the description.
///
/// A description without a folder has the packages of the options alone. Files in memory are found without the folder: any package
/// is the folder of its name.
pub fn find(name: &str, options: &ReadOptions) -> Option<PathBuf> {
    if let Some(Package { folder, .. }) = options.packages.iter().find(|own| own.name == name) {
        let root = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default();
        return Some(Path::new(&root).join(folder));
    }
    let folder = options.folder.as_deref()?;
    if options.files.is_in_memory() {
        return Some(PathBuf::from(name));
    }
    // A name of several parts would leave the folders that are searched.
    let mut parts = Path::new(name).components();
    let (Some(Component::Normal(_)), None) = (parts.next(), parts.next()) else { return None };
    let is_named = |folder: &Path| folder.file_name().is_some_and(|own| own == name);
    let is_package = |folder: &PathBuf| is_named(folder) && folder.join("package.xml").is_file();
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
    let around = absolute.ancestors().flat_map(|folder| [folder.to_owned(), folder.join(name)]);
    let of_ros = || {
        PACKAGE_PATHS.iter().find_map(|variable| {
            let folders = std::env::var_os(variable)?;
            std::env::split_paths(&folders).find_map(|folder| {
                [folder.clone(), folder.join(name), folder.join("share").join(name)]
                    .into_iter()
                    .find(is_package)
            })
        })
    };
    let above = || absolute.ancestors().find(|folder| is_named(folder)).map(Path::to_owned);
    around.into_iter().find(is_package).or_else(of_ros).or_else(above)
}
