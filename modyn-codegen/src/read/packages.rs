//! The folders of ROS packages, which descriptions name.

use std::path::{Component, Path, PathBuf};

use crate::description::{Package, ReadOptions};

/// The environment variables with folders of packages, in the order of their precedence.
pub const PACKAGE_PATHS: [&str; 2] = ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"];

/// Returns the folder of a package: by the option `packages`; by the folders that contain the description and their
/// neighbours, of which one has this name and a `package.xml`; or by `ROS_PACKAGE_PATH` and `AMENT_PREFIX_PATH`.
///
/// A description without a folder has the packages of the options alone.
#[allow(dead_code, reason = "formats of several files use it")]
pub fn find(name: &str, options: &ReadOptions) -> Option<PathBuf> {
    if let Some(Package { folder, .. }) = options.packages.iter().find(|own| own.name == name) {
        let root = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default();
        return Some(Path::new(&root).join(folder));
    }
    let folder = options.folder.as_deref()?;
    // A name of several parts would leave the folders that are searched.
    let mut parts = Path::new(name).components();
    let (Some(Component::Normal(_)), None) = (parts.next(), parts.next()) else { return None };
    let is_package = |folder: &PathBuf| {
        folder.file_name().is_some_and(|own| own == name) && folder.join("package.xml").is_file()
    };
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
    let around = absolute.ancestors().flat_map(|folder| [folder.to_owned(), folder.join(name)]);
    around.into_iter().find(is_package).or_else(|| {
        PACKAGE_PATHS.iter().find_map(|variable| {
            let folders = std::env::var_os(variable)?;
            std::env::split_paths(&folders).find_map(|folder| {
                [folder.clone(), folder.join(name), folder.join("share").join(name)]
                    .into_iter()
                    .find(is_package)
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_found() {
        let root = std::env::temp_dir().join(format!("modyn-packages-{}", std::process::id()));
        let package = root.join("arm_description");
        std::fs::create_dir_all(package.join("urdf")).expect("a folder");
        std::fs::create_dir_all(root.join("grippers/hand")).expect("a folder");
        for folder in [&package, &root.join("grippers/hand")] {
            std::fs::write(folder.join("package.xml"), "<package/>").expect("a file");
        }
        let mut options = ReadOptions { folder: Some(package.join("urdf")), ..Default::default() };
        assert_eq!(find("arm_description", &options), Some(package.clone()));
        for name in ["urdf", "hand", "..", "/", "", "../arm_description", "grippers/hand"] {
            assert_eq!(find(name, &options), None, "{name}");
        }
        options.folder = Some(root.join("grippers"));
        assert_eq!(find("hand", &options), Some(root.join("grippers/hand")));
        options.packages = vec![Package::new("hand", "left_hands")];
        assert!(find("hand", &options).is_some_and(|folder| folder.ends_with("left_hands")));
        options.folder = None;
        assert_eq!(find("arm_description", &options), None);
        let _ = std::fs::remove_dir_all(&root);
    }
}
