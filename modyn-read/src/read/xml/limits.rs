//! Limits on documents: no description reaches them, and parsing beyond them would take more than
//! linear time or memory.

use std::collections::HashSet;
use std::ops::Range;

use crate::diagnostics::{Code, Report};

/// The largest number of bytes of a text; a robot of a million joints has half as many.
pub const MAX_BYTES: usize = 1 << 30;

/// The largest number of attributes of an element; each is compared with the others.
pub const MAX_ATTRIBUTES: usize = 256;

/// The largest number of namespaces of a document; each element that declares one copies all of
/// them.
pub const MAX_NAMESPACES: usize = 256;

/// Returns whether the file that starts at offset `start` may be read; otherwise an error is in the
/// report.
pub fn is_short(bytes: usize, start: usize, report: &mut Report<'_>) -> bool {
    let short = bytes <= MAX_BYTES;
    if !short {
        let message = format!("the text has {bytes} bytes, more than {MAX_BYTES}");
        report.error(Code::Excessive, start, None, message, HELP);
    }
    short
}

/// Counts the attributes and namespaces of a document, tag by tag.
#[derive(Default)]
pub struct Tags<'t> {
    namespaces: HashSet<&'t str>,
    /// The place of the first excess, and its description.
    excess: Option<(usize, String)>,
}

impl<'t> Tags<'t> {
    /// Counts the tag in this part of the text.
    pub fn take(&mut self, text: &'t str, tag: Range<usize>) {
        if self.excess.is_some() {
            return;
        }
        let mut attributes = 0;
        // The text before a quote, the text in quotes, the text before a quote, ...
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
        self.excess = excess.map(|(_, most, unit)| (tag.start, format!("more than {most} {unit}")));
    }

    /// Returns whether the document, a file that starts at offset `start`, may be parsed; otherwise
    /// an error is in the report.
    pub fn within_limits(self, start: usize, report: &mut Report<'_>) -> bool {
        let Some((at, message)) = self.excess else { return true };
        report.error(Code::Excessive, start + at, None, message, HELP);
        false
    }
}

const HELP: &str = "remove everything that is not part of the robot's dynamics; valid descriptions \
                    stay below the limit";
