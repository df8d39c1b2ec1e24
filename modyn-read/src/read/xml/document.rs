//! Parses XML, with tolerance for frequent faults of robot files.

use std::ops::Range;

use roxmltree::{Document, Error};

use super::limits::{self, Tags};
use crate::diagnostics::{Code, Diagnostic, Position, Report};

/// Returns the tidied text of the file that starts at offset `start`; `None` if it is longer than
/// any description.
pub fn within_limits(text: &str, start: usize, report: &mut Report<'_>) -> Option<String> {
    if !limits::is_short(text.len(), start, report) {
        return None;
    }
    let (text, tags) = blank_comments(text);
    tags.within_limits(start, report).then_some(text)
}

/// A part of a document that is in angle brackets.
enum Part {
    Comment,
    /// A processing instruction or an XML declaration.
    Instruction,
    Data,
    /// The tag of an element.
    Tag,
}

/// Returns the parts of a text that are in angle brackets, in order, up to one without an end,
/// which the XML parser reports.
fn parts(text: &str) -> impl Iterator<Item = (Part, Range<usize>)> {
    let after = |from: usize, end: &str| text[from..].find(end).map(|i| from + i + end.len());
    let mut at = 0;
    std::iter::from_fn(move || {
        let start = at + text[at..].find('<')?;
        let rest = &text[start..];
        let (part, end) = if rest.starts_with("<!--") {
            (Part::Comment, after(start + 4, "-->"))
        } else if rest.starts_with("<?") {
            (Part::Instruction, after(start, "?>"))
        } else if rest.starts_with("<![CDATA[") {
            (Part::Data, after(start, "]]>"))
        } else {
            (Part::Tag, end_of_tag(text, start))
        };
        at = end?;
        Some((part, start..at))
    })
}

/// Replaces text that XML forbids but robot files contain by spaces: comments (with lines of
/// dashes), and text before the XML declaration. Offsets do not change. Counts attributes and
/// namespaces in tags.
pub fn blank_comments(text: &str) -> (String, Tags<'_>) {
    let mut bytes = text.as_bytes().to_vec();
    let mut blank = |range: Range<usize>| {
        bytes[range].iter_mut().filter(|b| !b.is_ascii_whitespace()).for_each(|b| *b = b' ');
    };
    let mut nothing_yet = true;
    let mut tags = Tags::default();
    for (part, range) in parts(text) {
        match part {
            Part::Comment => blank(range),
            // A declaration that is not at the start of the file: the text is known to be UTF-8.
            Part::Instruction => {
                let is_declaration = text[range.start..].starts_with("<?xml ");
                if nothing_yet && range.start > 0 && is_declaration {
                    blank(range);
                }
            }
            Part::Data => {}
            Part::Tag => {
                nothing_yet = false;
                tags.take(text, range);
            }
        }
    }
    // Only whole comments and declarations were replaced, by ASCII.
    (String::from_utf8(bytes).unwrap_or_else(|_| text.into()), tags)
}

/// Returns the offset after the `>` of the tag that starts here; attribute values may contain `>`.
fn end_of_tag(text: &str, start: usize) -> Option<usize> {
    let mut quote = None;
    for (i, byte) in text.as_bytes().iter().enumerate().skip(start) {
        match (quote, byte) {
            (None, b'>') => return Some(i + 1),
            (None, b'"' | b'\'') => quote = Some(*byte),
            (Some(open), close) if open == *close => quote = None,
            _ => {}
        }
    }
    None
}

/// Returns the parsed XML of the file that starts at offset `start`; `None` with an error in the
/// report. The outermost element has the name `root` in its format.
pub fn parse<'t>(
    text: &'t str,
    start: usize,
    root: &str,
    report: &mut Report<'_>,
) -> Option<Document<'t>> {
    if text.starts_with("#usda") {
        report.error(Code::NotUrdf, start, None, "this is a USD, which is not read", USD_HELP);
        return None;
    }
    if text.starts_with("version https://git-lfs.github.com/spec/") {
        let message = "this is a pointer of Git LFS in place of the file";
        let help = "fetch the file: `git lfs pull`";
        report.error(Code::NotUrdf, start, None, message, help);
        return None;
    }
    let error = match Document::parse(text) {
        Ok(document) => return Some(document),
        Err(error) => error,
    };
    let at = error.pos();
    let mut position = Position { line: at.row as usize, column: at.col as usize };
    let (code, message, help) = match &error {
        Error::DtdDetected => {
            position = report.position(start + text.find("<!DOCTYPE").unwrap_or(0));
            let message = "a document type declaration (DTD) can redefine the contents of the file";
            (Code::Dtd, message.into(), "remove `<!DOCTYPE ...>` and write entities out".into())
        }
        Error::UnknownNamespace(prefix, _) if prefix == "xacro" => {
            let message = "the namespace prefix `xacro` is not declared";
            let help = "write `<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" ...>`";
            (Code::Xacro, message.into(), help.into())
        }
        Error::UnknownNamespace(prefix, _) => {
            let message = format!("the namespace prefix `{prefix}` is not declared");
            let help = format!(
                "declare it on `<{root}>`, as in `xmlns:{prefix}=\"...\"`, or remove the element \
                 or attribute"
            );
            (Code::MalformedXml, message, help)
        }
        Error::UnexpectedEndOfStream | Error::UnclosedRootNode => {
            position = report.position(start + text.trim_end().len());
            let message = format!("the text ends before the element `<{root}>` is closed");
            (Code::MalformedXml, message, "close every element and every quote".into())
        }
        Error::NoRootNode => (
            Code::MalformedXml,
            "the text has no element".into(),
            format!("a description is one element `<{root}>`"),
        ),
        other => {
            let message = other.to_string().replace(&format!(" at {at}"), "");
            let help = "repair the XML; `xmllint FILE` shows where it breaks".into();
            (Code::MalformedXml, message, help)
        }
    };
    let mut diagnostic = Diagnostic::error(code, message).at(position).with_help(help);
    diagnostic.file = report.file_name(start).map(String::from);
    report.push(diagnostic);
    None
}

/// The advice for files of Universal Scene Description.
pub const USD_HELP: &str = "convert it to URDF: `pip install nvidia-srl-usd-to-urdf`, then \
                            `usd_to_urdf robot.usd -o FOLDER`";

/// The character that replaces the colon after a prefix. No name of URDF and SDF contains it.
pub const PREFIX_END: char = '.';

/// Returns the text with each `prefix:name` of an element or attribute replaced by `prefix.name`.
/// Offsets do not change. The programs that read URDF and SDF know no namespaces: to them, a prefix
/// is a part of the name, whether it is declared or not.
pub fn with_prefixes_in_names(text: &str) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for (_, range) in parts(text).filter(|(part, _)| matches!(part, Part::Tag)) {
        let mut quote = None;
        let mut start = range.start + 1;
        for at in range {
            match (quote, text.as_bytes()[at]) {
                (None, byte @ (b'"' | b'\'')) => quote = Some(byte),
                (Some(open), close) if open == close => quote = None,
                (None, b'/') => start = at + 1,
                (None, byte) if byte.is_ascii_whitespace() => start = at + 1,
                // XML itself declares these two prefixes.
                (None, b':') if !["xml", "xmlns"].contains(&&text[start..at]) => {
                    bytes[at] = PREFIX_END as u8;
                }
                _ => {}
            }
        }
    }
    // Only ASCII was replaced, by ASCII.
    String::from_utf8(bytes).unwrap_or_else(|_| text.into())
}

/// Returns the name of the first element, without parsing the text; `None` if there is no element.
pub fn first_element(text: &str) -> Option<&str> {
    let mut rest = text;
    loop {
        rest = &rest[rest.find('<')?..];
        let end = match rest {
            comment if comment.starts_with("<!--") => "-->",
            instruction if instruction.starts_with("<?") => "?>",
            declaration if declaration.starts_with("<!") => ">",
            _ => break,
        };
        rest = &rest[rest.find(end)? + end.len()..];
    }
    let name = &rest[1..];
    let end = name.find(|c: char| c.is_whitespace() || "/>".contains(c)).unwrap_or(name.len());
    Some(&name[..end]).filter(|name| !name.is_empty())
}
