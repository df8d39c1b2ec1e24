//! Is the text a URDF at all? XML or not, expanded or not, and which description language.

use roxmltree::{Document, Error, Node};

use super::limits::{self, Tags};
use super::report::Report;
use crate::error::{Code, Diagnostic, Position, Severity};

/// The elements of a joint or an inertial whose figures are read.
const USED: &[&str] = &[
    "inertial", "origin", "mass", "inertia", "parent", "child", "axis", "axis2", "limit", "mimic",
    "dynamics", "link1", "link2",
];

/// The tidied text; `None` if there is more of it than any description has.
pub fn bounded(text: &str, report: &mut Report<'_>) -> Option<String> {
    if !limits::is_short(text.len(), report) {
        return None;
    }
    let (text, tags) = tidied(text);
    tags.are_few(report).then_some(text)
}

/// Blanks out what XML forbids but robot files have all the same, byte for byte, so that
/// positions stay: comments (people draw lines of dashes in them), and whatever
/// stands before the XML declaration. And counts what there is in tags.
fn tidied(text: &str) -> (String, Tags<'_>) {
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
            // A declaration that does not open the file: the text is UTF-8 already.
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
        // Unfinished: the XML parser says so better.
        let Some(end) = end else { break };
        at = end;
    }
    // Only whole comments and declarations were replaced, by ASCII.
    (String::from_utf8(bytes).unwrap_or_else(|_| text.into()), tags)
}

/// Behind the `>` of the tag that starts here; attribute values may contain one.
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

/// Parses the XML; `None` with an error in the report.
pub fn parse<'t>(text: &'t str, report: &mut Report<'_>) -> Option<Document<'t>> {
    let error = match Document::parse(text) {
        Ok(document) => return Some(document),
        Err(error) => error,
    };
    let at = error.pos();
    let mut position = Position { line: at.row as usize, column: at.col as usize };
    let (code, message, help) = match &error {
        Error::DtdDetected => {
            position = report.position(text.find("<!DOCTYPE").unwrap_or(0));
            let message = "a document type declaration (DTD) can redefine what the file says";
            (Code::Dtd, message.into(), "remove `<!DOCTYPE ...>` and write entities out")
        }
        Error::UnknownNamespace(prefix, _) if prefix == "xacro" => {
            (Code::Xacro, "this is xacro, not yet a URDF".into(), XACRO_HELP)
        }
        Error::UnknownNamespace(prefix, _) => {
            let message = format!("the namespace prefix `{prefix}` is not declared");
            (
                Code::MalformedXml,
                message,
                "declare it on `<robot>`, as in `xmlns:p=\"...\"`, or remove the element",
            )
        }
        Error::UnexpectedEndOfStream | Error::UnclosedRootNode => {
            position = report.position(text.trim_end().len());
            let message = "the text ends before the element `<robot>` is closed";
            (Code::MalformedXml, message.into(), "close every element and every quote")
        }
        Error::NoRootNode => (
            Code::MalformedXml,
            "there is no element in the text".into(),
            "a URDF is one element `<robot>`",
        ),
        other => {
            let message = other.to_string().replace(&format!(" at {at}"), "");
            (Code::MalformedXml, message, "repair the XML; `xmllint FILE` shows where it breaks")
        }
    };
    report.push(Diagnostic::error(code, message).at(position).with_help(help));
    None
}

const XACRO_HELP: &str =
    "expand it first: `xacro robot.urdf.xacro -o robot.urdf` (ROS 2: `ros2 run xacro xacro ...`)";

/// The `<robot>` of an expanded URDF; `None` with an error in the report.
pub fn robot<'a, 't>(document: &'a Document<'t>, report: &mut Report<'_>) -> Option<Node<'a, 't>> {
    let root = document.root_element();
    let offset = root.range().start;
    let (code, message, help) = match root.tag_name().name() {
        "robot" => {
            if let Some(offset) = xacro(root) {
                let message = "this is xacro, not yet a URDF";
                report.error(Code::Xacro, offset, None, message, XACRO_HELP);
                return None;
            }
            return Some(root);
        }
        "sdf" | "gazebo" => (
            Code::Sdf,
            "this is an SDF, not a URDF".into(),
            "use the URDF that it was made from, or convert it (`sdf2urdf`, `sdformat_urdf`)",
        ),
        "mujoco" | "mujocoinclude" => (
            Code::Mjcf,
            "this is a MuJoCo model (MJCF), not a URDF".into(),
            "read it by `Builder::mjcf` (feature `mjcf`), or use the URDF that it was made from",
        ),
        other => (
            Code::NotUrdf,
            format!("the root element is `<{other}>`"),
            "a URDF is one element `<robot name=\"...\">` with links and joints",
        ),
    };
    report.add(Severity::Error, code, offset, None, message, help);
    None
}

/// Where xacro syntax stands in the way of reading the file, if it does: any xacro element next
/// to or in links and joints, any `${...}` or `$(...)` in a value that is read. Comments, what is
/// ignored anyway, and a declaration of the namespace that is left over are no matter.
fn xacro(root: Node) -> Option<usize> {
    for part in root.children().filter(Node::is_element) {
        if is_xacro(part) {
            return Some(part.range().start);
        }
        if !["link", "joint", "loop_joint"].iter().any(|name| is(root, part, name)) {
            continue;
        }
        let mut open = vec![part];
        while let Some(node) = open.pop() {
            if is_xacro(node) {
                return Some(node.range().start);
            }
            if node != part && !USED.iter().any(|name| is(root, node, name)) {
                continue;
            }
            if let Some(offset) = xacro_attribute(node) {
                return Some(offset);
            }
            let deeper = node == part || is(root, node, "inertial");
            open.extend(node.children().rev().filter(|child| deeper && child.is_element()));
        }
    }
    xacro_attribute(root)
}

fn is_xacro(node: Node) -> bool {
    let uri = node.tag_name().namespace();
    let text = &node.document().input_text()[node.range().start..];
    text.starts_with("<xacro:")
        || uri.is_some_and(|uri| uri.contains("xacro"))
            && uri != node.document().root_element().tag_name().namespace()
}

fn xacro_attribute(node: Node) -> Option<usize> {
    node.attributes()
        .find(|a| {
            let text = a.value();
            a.namespace().is_some_and(|uri| uri.contains("xacro"))
                || text.contains("${")
                || text.contains("$(")
        })
        .map(|a| a.range().start)
}

/// Whether `node` is URDF's element of this name: elements of other namespaces are extensions.
pub fn is(root: Node, node: Node, name: &str) -> bool {
    node.is_element()
        && node.tag_name().name() == name
        && node.tag_name().namespace() == root.tag_name().namespace()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blanking_moves_nothing() {
        let text = "\n<!-- \u{e9} -- --><?xml version='1.0'?>\n<a b='<!-- > -->'><![CDATA[<!-- -->]]></a><!---->";
        let (tidy, _) = tidied(text);
        assert_eq!(tidy.len(), text.len());
        assert_eq!(tidy.find("<a b='<!-- > -->'><![CDATA[<!-- -->]]></a>"), text.find("<a b="));
        assert!(!tidy.contains("<?xml"));
        assert_eq!(tidied("<?xml version='1.0'?><a/><!-- ").0, "<?xml version='1.0'?><a/><!-- ");
    }
}
