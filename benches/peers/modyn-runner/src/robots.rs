//! The list of robots, for the build script and the program.

use std::path::{Path, PathBuf};

use modyn_codegen::Base;

/// A line of `robots.txt`.
pub struct Robot {
    pub name: String,
    pub description: PathBuf,
    pub base: Base,
    /// Whether its derivatives are measured.
    #[allow(dead_code)]
    pub derivatives: bool,
}

impl Robot {
    /// Returns the name in upper camel case.
    #[allow(dead_code)]
    pub fn type_name(&self) -> String {
        let upper = |word: &str| word[..1].to_uppercase() + &word[1..];
        self.name.split('_').map(upper).collect()
    }
}

/// Returns the listed robots whose files are there: the command copies robots of Python packages here.
pub fn all() -> Vec<Robot> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let lines = include_str!("../../robots.txt").lines().filter(|line| !line.starts_with('#'));
    let robot = |line: &str| {
        let [name, description, base, derivatives] =
            line.split_whitespace().collect::<Vec<_>>().try_into().expect("four columns");
        let copied = || format!("target/peers/robots/{name}.urdf");
        let description = if description.starts_with("wheel:") { &copied() } else { description };
        Robot {
            name: String::from(name),
            description: root.join(description),
            base: if base == "floating" { Base::Floating } else { Base::Fixed },
            derivatives: derivatives == "derivatives",
        }
    };
    lines.map(robot).filter(|robot| robot.description.exists()).collect()
}
