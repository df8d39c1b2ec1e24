//! Elements that are not read and may change the robot's motion, which a warning names once for
//! each kind.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::element::{is_extension, written};
use crate::diagnostics::{Code, Place, Report};

/// The places of elements that are not read and may change the robot's motion, by their meaning.
#[derive(Default)]
pub struct Unread {
    kinds: BTreeMap<String, Kind>,
}

/// The places of elements with one meaning, and the help.
struct Kind {
    places: Vec<Place>,
    help: &'static str,
}

/// Extensions that cannot change the equations of motion.
const HARMLESS_EXTENSIONS: &[&str] = &["drake.acceleration", "drake.collision_filter_group"];

const EXTENSION_HELP: &str =
    "extensions have no effect here; joints, forces and inertias that they add are missing";

impl Unread {
    /// Adds a place.
    pub fn add(&mut self, message: String, place: Place, help: &'static str) {
        let kind = self.kinds.entry(message).or_insert_with(|| Kind { places: Vec::new(), help });
        kind.places.push(place);
    }

    /// Adds an element of an extension, unless it is harmless; `false` if the element belongs to
    /// the format.
    pub fn add_extension(&mut self, node: Node, place: Place) -> bool {
        let name = node.tag_name().name();
        if !is_extension(name) {
            return false;
        }
        if !HARMLESS_EXTENSIONS.contains(&name) {
            let message = format!("the extension `<{}>` is not read", written(node));
            self.add(message, place, EXTENSION_HELP);
        }
        true
    }

    /// Warns once of each meaning.
    pub fn warn(self, report: &mut Report<'_>) {
        for (message, Kind { places, help }) in self.kinds {
            report.warn_once(Code::NotRead, &places, &message, help);
        }
    }
}
