//! What no description has, and what parsing would take more than linear time or memory for.

use std::collections::HashSet;
use std::ops::Range;

use crate::diagnostics::{Code, Report};

/// Most bytes of a text: a robot of a million joints has half as many.
pub const MAX_BYTES: usize = 1 << 30;

/// Most attributes of an element: each is compared with those before it.
pub const MAX_ATTRIBUTES: usize = 256;

/// Most namespaces of a document: each element that declares one copies all of them.
pub const MAX_NAMESPACES: usize = 256;

/// Whether a text of so many bytes may be read; else it is in the report.
pub fn is_short(bytes: usize, report: &mut Report<'_>) -> bool {
    let short = bytes <= MAX_BYTES;
    if !short {
        let message = format!("the text has {bytes} bytes, more than {MAX_BYTES}");
        report.error(Code::Excessive, 0, None, message, HELP);
    }
    short
}

/// Counts what the tags of a document have, in the order in which they stand.
#[derive(Default)]
pub struct Tags<'t> {
    namespaces: HashSet<&'t str>,
    /// Where there was too much, and of what.
    excess: Option<(usize, String)>,
}

impl<'t> Tags<'t> {
    /// Takes the tag that is in this part of the text.
    pub fn take(&mut self, text: &'t str, tag: Range<usize>) {
        if self.excess.is_some() {
            return;
        }
        let mut attributes = 0;
        // What stands before a quote, in quotes, before a quote...
        let mut rest = &text[tag.clone()];
        while let Some(open) = rest.find(['"', '\'']) {
            let inside = &rest[open + 1..];
            let Some(end) = inside.find(char::from(rest.as_bytes()[open])) else { break };
            attributes += 1;
            if rest[..open].trim_start().starts_with("xmlns") {
                self.namespaces.insert(rest[..=open + 1 + end].trim());
            }
            rest = &inside[end + 1..];
        }
        let counted = [
            (attributes, MAX_ATTRIBUTES, "attributes in one element"),
            (self.namespaces.len(), MAX_NAMESPACES, "namespaces in one document"),
        ];
        let excess = counted.into_iter().find(|(count, most, _)| count > most);
        self.excess = excess.map(|(_, most, of)| (tag.start, format!("more than {most} {of}")));
    }

    /// Whether that is no more than may be parsed; else it is in the report.
    pub fn within_limits(self, report: &mut Report<'_>) -> bool {
        let Some((at, message)) = self.excess else { return true };
        report.error(Code::Excessive, at, None, message, HELP);
        false
    }
}

const HELP: &str = "leave out what the robot's motion has no use for; no description is like this";
