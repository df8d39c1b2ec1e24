//! Checks that an XML document is an expanded URDF, and names the format of other documents.

use roxmltree::{Document, Node};

use crate::diagnostics::{Code, Report, Severity};
use crate::read::xml::element::{children, is};

/// The advice for a xacro that is read as a URDF.
const XACRO_HELP: &str = "give the file a name that ends in `.xacro`: then modyn expands it, \
                          unless it was asked to read a URDF";

/// The elements of a joint or an inertial whose numbers are read.
const USED: &[&str] = &[
    "inertial", "origin", "mass", "inertia", "parent", "child", "axis", "axis2", "limit", "mimic",
    "dynamics", "link1", "link2",
];

/// Returns the `<robot>` of an expanded URDF; `None` with an error in the report.
pub fn robot<'a, 't>(document: &'a Document<'t>, report: &mut Report<'_>) -> Option<Node<'a, 't>> {
    let root = document.root_element();
    let offset = root.range().start;
    let (code, message, help) = match root.tag_name().name() {
        "robot" => {
            if let Some(offset) = xacro(root) {
                let message = "this is a xacro file, not a URDF";
                report.error(Code::Xacro, offset, None, message, XACRO_HELP);
                return None;
            }
            return Some(root);
        }
        "sdf" | "gazebo" => (
            Code::Sdf,
            "this is an SDF, not a URDF".into(),
            "`modyn_read::read`, `modyn!`, `Builder::file` and the command `modyn` read it as an SDF",
        ),
        "mujoco" | "mujocoinclude" => (
            Code::Mjcf,
            "this is a MuJoCo model (MJCF), not a URDF".into(),
            "`modyn_read::read`, `modyn!`, `Builder::file` and the command `modyn` read it as an MJCF",
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

/// Returns the place of xacro syntax that has to be expanded: a xacro element beside or inside
/// links and joints, or `${...}` or `$(...)` in a value that is read. Comments, ignored elements,
/// and an unused declaration of the namespace are accepted.
fn xacro(root: Node) -> Option<usize> {
    for part in children(root).filter(Node::is_element) {
        if is_xacro(part) {
            return Some(part.range().start);
        }
        let read = ["link", "joint", "loop_joint", "contact_frame"];
        if !read.iter().any(|name| is(part, name)) {
            continue;
        }
        let mut open = vec![part];
        while let Some(node) = open.pop() {
            if is_xacro(node) {
                return Some(node.range().start);
            }
            if node != part && !USED.iter().any(|name| is(node, name)) {
                continue;
            }
            if let Some(offset) = xacro_attribute(node) {
                return Some(offset);
            }
            let deeper = node == part || is(node, "inertial");
            open.extend(children(node).rev().filter(|child| deeper && child.is_element()));
        }
    }
    xacro_attribute(root)
}

fn is_xacro(node: Node) -> bool {
    node.tag_name().name().starts_with(XACRO)
}

/// The prefix of xacro's elements.
const XACRO: &str = "xacro.";

fn xacro_attribute(node: Node) -> Option<usize> {
    node.attributes()
        .find(|a| {
            let text = a.value();
            a.name().starts_with(XACRO) || text.contains("${") || text.contains("$(")
        })
        .map(|a| a.range().start)
}
