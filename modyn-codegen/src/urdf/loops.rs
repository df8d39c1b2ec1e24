//! Loop joints: `<loop_joint>`, which other tools' URDFs have too, and the option `loops`.
//!
//! ```xml
//! <loop_joint name="pin" type="revolute">
//!   <link1 link="coupler" xyz="0.4 0 0" rpy="0 0 0"/>
//!   <link2 link="rocker" xyz="0 0 0.3"/>
//!   <axis xyz="0 1 0"/>
//! </loop_joint>
//! ```

use modyn_runtime::model::{LoopConstraint, LoopConstraintEnd, LoopConstraintKind};
use modyn_runtime::spatial::Pose;
use roxmltree::Node;
use rustc_hash::{FxHashMap, FxHashSet};

use super::{
    Loop, LoopEnd,
    build::LARGEST,
    joint::normalized,
    nearest::Suggestions,
    parts::{Located, Parts, Reader, roll_pitch_yaw},
    report::Report,
};
use crate::error::{Code, Diagnostic, Severity, Subject};

/// A loop joint, from wherever it is.
pub struct LoopPart<'a> {
    name: &'a str,
    /// Where it stands; `None` for an option's.
    at: Option<usize>,
    /// `None` where it could not be read.
    kind: Option<LoopConstraintKind>,
    ends: [EndPart<'a>; 2],
}

/// One of its two frames.
struct EndPart<'a> {
    /// `None` where it is missing.
    link: Option<&'a str>,
    at: Option<usize>,
    pose: Pose<f64>,
}

impl LoopPart<'_> {
    fn subject(&self) -> Subject {
        Subject::Joint(self.name.into())
    }
}

impl<'a> LoopPart<'a> {
    /// An option's; with errors in the report.
    fn of_option(option: &'a Loop, report: &mut Report<'_>) -> Self {
        let ends = option.ends.each_ref().map(|LoopEnd { link, xyz, rpy }| {
            let pose = Pose { rotation: roll_pitch_yaw(*rpy), translation: *xyz };
            EndPart { link: Some(link.as_str()), at: None, pose }
        });
        let unit = |axis: [f64; 3]| {
            let finite = axis.iter().all(|x| x.abs() < LARGEST);
            normalized(axis).filter(|_| finite).map(|(unit, _)| unit)
        };
        let kind = match option.kind {
            LoopConstraintKind::Revolute(axis) => unit(axis).map(LoopConstraintKind::Revolute),
            LoopConstraintKind::Prismatic(axis) => unit(axis).map(LoopConstraintKind::Prismatic),
            kind => Some(kind),
        };
        let part = Self { name: &option.name, at: None, kind, ends };
        if let (Some(axis), None) = (option.kind.axis(), kind) {
            let message = format!("{axis:?} is no axis");
            let error = Diagnostic::error(Code::Option, message).about(part.subject());
            report.push(error.with_help("give a direction, such as [0.0, 0.0, 1.0]"));
        }
        part
    }
}

const TYPES: &str = "supported are: spherical, fixed, revolute, continuous, prismatic";

impl<'a> Reader<'a, '_, '_, '_> {
    pub fn loop_joint(&mut self, node: Node<'a, '_>) -> LoopPart<'a> {
        let name = self.attribute(node, "name", None);
        let subject = name.map(|name| Subject::Joint(name.text.into()));
        let subject = subject.as_ref();
        self.known(node, &["name", "type"], subject);
        let kind = self.loop_kind(node, subject);
        for child in node.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            let axis = kind.is_none_or(|kind| kind.axis().is_some());
            if !(["link1", "link2"].contains(&name) || name == "axis" && axis) {
                let message = format!("the element `<{name}>` of `<loop_joint>` is not read");
                let help =
                    "a loop joint has `<link1>`, `<link2>`, and, if it turns or slides, `<axis>`";
                let at = child.range().start;
                self.report.add(Severity::Warning, Code::NotRead, at, subject, message, help);
            }
        }
        let ends = ["link1", "link2"].map(|end| self.loop_end(node, end, subject));
        let at = name.map_or(node.range().start, |name| name.at);
        LoopPart { name: name.map_or("", |name| name.text), at: Some(at), kind, ends }
    }

    fn loop_kind(
        &mut self,
        node: Node<'a, '_>,
        subject: Option<&Subject>,
    ) -> Option<LoopConstraintKind> {
        let text = self.attribute(node, "type", subject)?;
        let x = [1.0, 0.0, 0.0];
        let Some(kind) = LoopConstraintKind::of_joint(text.text, x) else {
            let message = format!("`{}` is no type of a loop joint", text.text);
            self.report.error(Code::UnknownJointType, text.at, subject, message, TYPES);
            return None;
        };
        if kind.axis().is_none() {
            return Some(kind);
        }
        LoopConstraintKind::of_joint(text.text, self.axis(node, "axis", x, subject)?)
    }

    fn loop_end(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        subject: Option<&Subject>,
    ) -> EndPart<'a> {
        let example = "link=\"...\" xyz=\"0 0 0\" rpy=\"0 0 0\"";
        let Some(end) = self.required(node, name, example, subject) else {
            return EndPart { link: None, at: None, pose: Pose::identity() };
        };
        self.known(end, &["link", "xyz", "rpy", "quat_xyzw"], subject);
        for child in end.children().filter(Node::is_element) {
            let message = format!("`<{}>` in `<{name}>` is not read", child.tag_name().name());
            let help = format!("write `<{name} link=\"...\" xyz=\"0 0 0\" rpy=\"0 0 0\"/>`");
            self.report.error(Code::NotRead, child.range().start, subject, message, help);
        }
        let pose = self.pose(end, subject);
        let link = self.attribute(end, "link", subject);
        let at = link.map_or(end.range().start, |Located { at, .. }| at);
        EndPart { link: link.map(|link| link.text), at: Some(at), pose }
    }
}

/// The loop constraints; `carriers` has by link of the description the moving link that carries it.
pub fn loop_constraints(
    parts: &Parts,
    options: &[Loop],
    carriers: &[Option<usize>],
    report: &mut Report<'_>,
) -> Vec<LoopConstraint> {
    let mut links = FxHashMap::default();
    for (i, link) in parts.links.iter().enumerate() {
        links.entry(link.name.text).or_insert(i);
    }
    let names = parts.joints.iter().map(|joint| joint.name.text).collect();
    let mut search = Search { parts, links, names, near: Suggestions::new() };
    let options: Vec<LoopPart> =
        options.iter().map(|option| LoopPart::of_option(option, report)).collect();
    let all = parts.loops.iter().chain(&options);
    all.filter_map(|part| search.constraint(part, carriers, report)).collect()
}

struct Search<'p, 'a> {
    parts: &'p Parts<'a>,
    links: FxHashMap<&'a str, usize>,
    /// Of the joints so far.
    names: FxHashSet<&'p str>,
    near: Suggestions,
}

impl<'p> Search<'p, '_> {
    /// `None` with an error in the report.
    fn constraint(
        &mut self,
        part: &LoopPart<'p>,
        carriers: &[Option<usize>],
        report: &mut Report<'_>,
    ) -> Option<LoopConstraint> {
        let errors = report.errors();
        let mut error = |code, at: Option<usize>, message: String, help: &str| match at {
            Some(at) => report.error(code, at, Some(&part.subject()), message, help),
            None => {
                report.push(Diagnostic::error(code, message).with_help(help).about(part.subject()))
            }
        };
        // A name that is missing is an error already.
        if !part.name.is_empty() && !self.names.insert(part.name) {
            let message = "another joint has the same name";
            error(Code::DuplicateJoint, part.at, message.into(), "give one of them another name");
        }
        let ends = part.ends.each_ref().map(|end| {
            let figures = end.pose.rotation.iter().flatten().chain(&end.pose.translation);
            if !figures.into_iter().all(|x| x.abs() < LARGEST) {
                let message = "its place is too far away to compute with";
                error(Code::NotFinite, end.at.or(part.at), message.into(), "write `xyz` in m");
            }
            let link = end.link?;
            let found = self.links.get(link).copied();
            if found.is_none() {
                let message = format!("it holds link `{link}`, which does not exist");
                let names = self.parts.links.iter().map(|link| link.name.text);
                let help = self.near.nearest(link, names).map_or_else(
                    || "name a link of the description".into(),
                    |name| format!("did you mean `{name}`?"),
                );
                error(Code::LoopLink, end.at, message, &help);
            }
            found.map(|frame| LoopConstraintEnd { frame, pose: end.pose })
        });
        if let [Some(a), Some(b)] = &ends
            && carriers[a.frame] == carriers[b.frame]
        {
            let [a, b] = [a, b].map(|end| self.parts.links[end.frame].name.text);
            let message = if a == b {
                format!("it holds link `{a}` to itself")
            } else {
                format!("it holds links `{a}` and `{b}`, which cannot move against each other")
            };
            let help = "name two links with a joint that moves between them";
            error(Code::LoopEnds, part.ends[1].at, message, help);
        }
        if report.errors() > errors {
            return None;
        }
        let [a, b] = ends;
        Some(LoopConstraint { name: part.name.into(), kind: part.kind?, ends: [a?, b?] })
    }
}
