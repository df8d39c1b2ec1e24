//! The list of robots, for the build script and the program.

use std::path::{Path, PathBuf};

use modyn_codegen::{Base, Contact, ContactKind, LoopEnd};

/// A line of `robots.txt`.
pub struct Robot {
    pub name: String,
    pub description: PathBuf,
    pub base: Base,
    /// Its contacts. With contacts, only functions of contacts are measured.
    #[allow(dead_code)]
    pub contacts: Vec<Contact>,
    /// Whether forward dynamics is also measured for many states a call.
    #[allow(dead_code)]
    pub batch: bool,
    /// The measured functions.
    pub quantities: &'static [&'static str],
}

/// The functions of a robot with contacts, derivatives last.
const CONSTRAINED: &[&str] =
    &["constrained_forward_dynamics", "constrained_forward_dynamics_derivatives"];
/// The functions of a robot without contacts, derivatives last.
const FREE: &[&str] =
    &["forward_dynamics", "inverse_dynamics", "mass_matrix", "forward_dynamics_derivatives"];

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
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../..");
    let lines = include_str!("../../robots.txt").lines().filter(|line| !line.starts_with('#'));
    let robot = |line: &str| {
        let [name, description, base, timed] =
            line.split_whitespace().collect::<Vec<_>>().try_into().expect("four columns");
        let copied = || format!("target/peers/robots/{name}.urdf");
        let description = if description.starts_with("wheel:") { &copied() } else { description };
        let contacts: Vec<Contact> = timed.split(',').filter_map(contact).collect();
        let all = if contacts.is_empty() { FREE } else { CONSTRAINED };
        let has = |wanted| timed.split(',').any(|word| word == wanted);
        let quantities = &all[..all.len() - usize::from(!has("derivatives"))];
        Robot {
            name: String::from(name),
            description: root.join(description),
            base: if base == "floating" { Base::Floating } else { Base::Fixed },
            contacts,
            batch: has("batch"),
            quantities,
        }
    };
    lines.map(robot).filter(|robot| robot.description.exists()).collect()
}

/// Reads `KIND:LINK`; `None` for another word.
fn contact(text: &str) -> Option<Contact> {
    let (kind, link) = text.split_once(':')?;
    let kind = if kind == "point" { ContactKind::Point } else { ContactKind::Surface };
    let end = LoopEnd { link: link.into(), xyz: [0.0; 3], rpy: [0.0; 3] };
    Some(Contact { name: link.into(), kind, end })
}
