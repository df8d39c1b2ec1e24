//! modyn's generated C.

use std::path::Path;

/// Of each robot: its name, the prefix of its functions, the header and the source.
const ROBOTS: &[(&str, &str, &str, &str)] = &include!(concat!(env!("OUT_DIR"), "/c.rs"));

/// Writes `PREFIX.h` and `PREFIX.c` into a folder of the robot's name.
pub fn write(folder: &Path) {
    for (robot, prefix, header, source) in ROBOTS {
        let folder = folder.join(robot);
        std::fs::create_dir_all(&folder).expect("a folder");
        for (kind, text) in [("h", header), ("c", source)] {
            let file = folder.join(format!("{prefix}.{kind}"));
            // A file that is as it was stays: what was built of it is newer.
            if std::fs::read_to_string(&file).ok().as_deref() != Some(text) {
                std::fs::write(file, text).expect("a file");
            }
        }
    }
}
