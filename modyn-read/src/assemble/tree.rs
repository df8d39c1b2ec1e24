//! The tree of links: its root, its order, and the errors of joints that form no tree.

use rustc_hash::FxHashMap;

use super::cycles::cycles;
use crate::description::{Description, Located};
use crate::diagnostics::{Code, Report, Subject, Suggestions};

/// A tree in depth-first order; a link's children are in the order of their joints in the file.
pub struct Tree {
    /// The links, as indices into the description, parents before children.
    pub order: Vec<usize>,
    /// For each link, the joint (as an index) towards its parent; `None` for the root.
    pub joint: Vec<Option<usize>>,
    /// For each joint, its parent link.
    pub parent: Vec<Option<usize>>,
}

/// Returns the tree; `None` with errors in the report.
pub fn build_tree(description: &Description, report: &mut Report<'_>) -> Option<Tree> {
    let errors = report.errors();
    let links =
        index(description.links.iter().map(|l| &l.name), Code::DuplicateLink, "link", report);
    index(description.joints.iter().map(|j| &j.name), Code::DuplicateJoint, "joint", report);
    if description.links.is_empty() {
        let help = "write at least two `<link>` and a moving `<joint>` between them";
        report.error(Code::NoLink, description.at, None, "the robot has no link", help);
        return None;
    }
    let Ends { joint, parent, complete } = ends(description, &links, report);
    report_cycles(description, &joint, &parent, report);
    // A misspelt child leaves a link without a joint, which would be reported as another root.
    if complete {
        roots(description, &links, &joint, report);
    }
    // A joint without a parent or child was reported before.
    if report.errors() > errors || !complete || parent.contains(&None) {
        return None;
    }

    let mut children = vec![Vec::new(); description.links.len()];
    for (child, joint) in joint.iter().enumerate() {
        if let Some((j, p)) = joint.and_then(|j| Some((j, parent[j]?))) {
            children[p].push((j, child));
        }
    }
    let mut open: Vec<usize> =
        (0..description.links.len()).filter(|&l| joint[l].is_none()).collect();
    let mut order = Vec::with_capacity(description.links.len());
    while let Some(link) = open.pop() {
        order.push(link);
        children[link].sort_unstable();
        open.extend(children[link].iter().rev().map(|&(_, child)| child));
    }
    Some(Tree { order, joint, parent })
}

/// Returns the index of each name. The first of equal names counts; the others are errors.
fn index<'a>(
    names: impl Iterator<Item = &'a Located>,
    code: Code,
    what: &str,
    report: &mut Report<'_>,
) -> FxHashMap<&'a str, usize> {
    let mut indices = FxHashMap::default();
    let mut places = Vec::new();
    for (i, name) in names.enumerate() {
        places.push(name.at);
        // A missing name was reported before.
        if name.text.is_empty() {
            continue;
        }
        let first = *indices.entry(name.text.as_str()).or_insert(i);
        if first != i {
            let place = report.position(places[first]);
            let name_of = name.text.clone();
            let subject =
                if what == "link" { Subject::Link(name_of) } else { Subject::Joint(name_of) };
            let message = format!("another {what} has this name, at {place}");
            let help = "give each its own name";
            report.error(code, name.at, Some(&subject), message, help);
        }
    }
    indices
}

/// The parent and child links of the joints.
struct Ends {
    /// For each link, the joint whose child it is.
    joint: Vec<Option<usize>>,
    /// For each joint, its parent link.
    parent: Vec<Option<usize>>,
    /// Whether all children were found.
    complete: bool,
}

fn ends(
    description: &Description,
    links: &FxHashMap<&str, usize>,
    report: &mut Report<'_>,
) -> Ends {
    let mut joint_of: Vec<Option<usize>> = vec![None; description.links.len()];
    let mut parents = vec![None; description.joints.len()];
    let mut complete = true;
    let mut suggestions = Suggestions::new();
    for (j, joint) in description.joints.iter().enumerate() {
        let mut find = |end: &Option<Located>, code, what| {
            let end = end.as_ref()?;
            let index = links.get(end.text.as_str()).copied();
            if index.is_none() {
                let message = format!("its {what} `{}` does not exist", end.text);
                let names = description.link_names();
                let help = match suggestions.suggest(&end.text, names) {
                    Some(name) => format!("did you mean `{name}`?"),
                    None => format!("name a link, or write `<link name=\"{}\"/>`", end.text),
                };
                report.error(code, end.at, Some(&joint.subject()), message, help);
            }
            index
        };
        parents[j] = find(&joint.parent, Code::UnknownParent, "parent");
        let Some(child) = find(&joint.child, Code::UnknownChild, "child") else {
            complete = false;
            continue;
        };
        match joint_of[child] {
            None => joint_of[child] = Some(j),
            Some(first) => {
                let first = &description.joints[first];
                let at = joint.child.as_ref().map_or(joint.name.at, |end| end.at);
                let message = format!(
                    "it is the child of joint `{}` and also of joint `{}` (at {})",
                    joint.name.text,
                    first.name.text,
                    report.position(first.child.as_ref().map_or(first.name.at, |end| end.at)),
                );
                let help = "a link has one parent; to describe a closed loop, make one joint of \
                            the loop a `<loop_joint>`";
                report.error(
                    Code::SeveralParents,
                    at,
                    Some(&description.links[child].subject()),
                    message,
                    help,
                );
            }
        }
    }
    Ends { joint: joint_of, parent: parents, complete }
}

/// Reports all cycles, with the names of all joints of a cycle.
fn report_cycles(
    description: &Description,
    joint: &[Option<usize>],
    parent: &[Option<usize>],
    report: &mut Report<'_>,
) {
    // For each joint, the joint of its parent link.
    let above: Vec<Option<usize>> =
        parent.iter().map(|parent| parent.and_then(|link| joint[link])).collect();
    for mut on_cycle in cycles(&above) {
        // From parent to child.
        on_cycle[1..].reverse();
        let names: Vec<String> =
            on_cycle.iter().map(|&j| format!("`{}`", description.joints[j].name.text)).collect();
        let joint = &description.joints[on_cycle[0]];
        let message = format!("joints form a cycle: {}", names.join(", "));
        let help = "a robot is a tree: one link must not be the child of any joint";
        report.error(Code::Cycle, joint.name.at, Some(&joint.subject()), message, help);
    }
}

fn roots(
    description: &Description,
    links: &FxHashMap<&str, usize>,
    joint: &[Option<usize>],
    report: &mut Report<'_>,
) {
    // The second of two links with one name cannot be the child of a joint; its name is the error.
    let first_of_its_name =
        |link: usize| links.get(description.links[link].name.text.as_str()) == Some(&link);
    let roots: Vec<usize> =
        (0..joint.len()).filter(|&link| joint[link].is_none() && first_of_its_name(link)).collect();
    let Some(&second) = roots.get(1) else { return };
    let names: Vec<String> =
        roots.iter().take(10).map(|&r| format!("`{}`", description.links[r].name.text)).collect();
    let more = if roots.len() > names.len() { ", ..." } else { "" };
    let link = &description.links[second];
    let message =
        format!("{} links are not the child of any joint: {}{more}", roots.len(), names.join(", "));
    let help = "a robot has one root: connect the others to it, for example by fixed joints";
    report.error(Code::SeveralRoots, link.name.at, Some(&link.subject()), message, help);
}
