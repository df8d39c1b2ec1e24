//! Parses XML, with tolerance for frequent faults of robot files.

use roxmltree::{Document, Error};

use super::limits::{self, Tags};
use crate::diagnostics::{Code, Diagnostic, Position, Report};

/// Returns the tidied text of the file that starts at offset `start`; `None` if it is longer than any description.
pub fn within_limits(text: &str, start: usize, report: &mut Report<'_>) -> Option<String> {
    if !limits::is_short(text.len(), start, report) {
        return None;
    }
    let (text, tags) = blank_comments(text);
    tags.within_limits(start, report).then_some(text)
}

/// Replaces text that XML forbids but robot files contain by spaces, so that offsets do not change: comments (with
/// lines of dashes), and text before the XML declaration. Counts attributes and namespaces in tags.
pub fn blank_comments(text: &str) -> (String, Tags<'_>) {
    let mut bytes = text.as_bytes().to_vec();
    let mut blank = |from: usize, to: usize| {
        bytes[from..to].iter_mut().filter(|b| !b.is_ascii_whitespace()).for_each(|b| *b = b' ');
    };
    let after = |from: usize, end: &str| text[from..].find(end).map(|i| from + i + end.len());
    let mut at = 0;
    let mut nothing_yet = true;
    let mut tags = Tags::default();
    while let Some(start) = text[at..].find('<').map(|i| at + i) {
        let rest = &text[start..];
        let end = if rest.starts_with("<!--") {
            let end = after(start + 4, "-->");
            if let Some(end) = end {
                blank(start, end);
            }
            end
        } else if rest.starts_with("<?") {
            let end = after(start, "?>");
            // A declaration that is not at the start of the file: the text is known to be UTF-8.
            if let Some(end) =
                end.filter(|_| nothing_yet && start > 0 && rest.starts_with("<?xml "))
            {
                blank(start, end);
            }
            end
        } else if rest.starts_with("<![CDATA[") {
            after(start, "]]>")
        } else {
            nothing_yet = false;
            let end = end_of_tag(text, start);
            if let Some(end) = end {
                tags.take(text, start..end);
            }
            end
        };
        // The XML parser reports the missing end.
        let Some(end) = end else { break };
        at = end;
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

/// Returns the parsed XML of the file that starts at offset `start`; `None` with an error in the report. The outermost
/// element has the name `root` in its format.
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
            let help =
                format!("declare it on `<{root}>`, as in `xmlns:p=\"...\"`, or remove the element");
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
pub const USD_HELP: &str = "convert it to URDF: `pip install nvidia-srl-usd-to-urdf`, then `usd_to_urdf robot.usd -o FOLDER`";

/// Returns the text with `<prefix:name>` replaced by `<prefix_name>` for prefixes that are not declared, so that offsets do
/// not change; `None` if all are declared. Such elements are extensions, which readers of URDF and SDF ignore.
pub fn without_undeclared_prefixes(text: &str) -> Option<String> {
    let is_name = |c: char| c.is_alphanumeric() || "_-.".contains(c);
    let mut prefixes = std::collections::BTreeMap::new();
    let mut places = Vec::new();
    for (at, _) in text.match_indices('<') {
        let start = at + 1 + usize::from(text[at + 1..].starts_with('/'));
        let rest = &text[start..];
        let end = rest.find(|c| !is_name(c)).unwrap_or(rest.len());
        let prefix = &rest[..end];
        if end == 0 || !rest[end..].starts_with(':') || prefix == "xacro" {
            continue;
        }
        let declared = || text.contains(&format!("xmlns:{prefix}"));
        if !*prefixes.entry(prefix).or_insert_with(declared) {
            places.push(start + end);
        }
    }
    if places.is_empty() {
        return None;
    }
    let mut bytes = text.as_bytes().to_vec();
    places.into_iter().for_each(|colon| bytes[colon] = b'_');
    String::from_utf8(bytes).ok()
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
