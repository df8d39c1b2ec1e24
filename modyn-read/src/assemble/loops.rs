//! Loop joints of the description and of the options: constraints between two frames of links.

use modyn_runtime::model::{LoopConstraint, LoopConstraintEnd, LoopConstraintKind};
use modyn_runtime::spatial::Pose;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::description::{
    Description, EndRecord, Loop, LoopEnd, LoopRecord, MAX_NUMBER, normalized, roll_pitch_yaw,
};
use crate::diagnostics::{Code, Diagnostic, Report, Suggestions};

/// Returns the record of a loop joint of the options; its errors are in the report.
pub fn from_option(option: &Loop, report: &mut Report<'_>) -> LoopRecord {
    let ends = option.ends.each_ref().map(|LoopEnd { link, xyz, rpy }| {
        let pose = Pose { rotation: roll_pitch_yaw(*rpy), translation: *xyz };
        EndRecord { link: Some(link.clone()), at: None, pose }
    });
    let unit = |axis: [f64; 3]| {
        let finite = axis.iter().all(|x| x.abs() < MAX_NUMBER);
        normalized(axis).filter(|_| finite).map(|(unit, _)| unit)
    };
    let kind = match option.kind {
        LoopConstraintKind::Revolute(axis) => unit(axis).map(LoopConstraintKind::Revolute),
        LoopConstraintKind::Prismatic(axis) => unit(axis).map(LoopConstraintKind::Prismatic),
        kind => Some(kind),
    };
    let record = LoopRecord { name: option.name.clone(), at: None, kind, ends };
    if let (Some(axis), None) = (option.kind.axis(), kind) {
        let message = format!("{axis:?} is not a direction");
        let error = Diagnostic::error(Code::Option, message).with_subject(record.subject());
        report.push(error.with_help("give a direction, such as [0.0, 0.0, 1.0]"));
    }
    record
}

/// Returns the loop constraints. `carriers` has, for each link of the description, the moving link
/// that carries it.
pub fn loop_constraints(
    description: &Description,
    carriers: &[Option<usize>],
    report: &mut Report<'_>,
) -> Vec<LoopConstraint> {
    let mut links = FxHashMap::default();
    for (i, link) in description.link_names().enumerate() {
        links.entry(link).or_insert(i);
    }
    let names = description.joint_names().collect();
    let mut search = Search { description, links, names, near: Suggestions::new() };
    let all = description.loops.iter();
    all.filter_map(|record| search.constraint(record, carriers, report)).collect()
}

struct Search<'p> {
    description: &'p Description,
    links: FxHashMap<&'p str, usize>,
    /// The names of the joints so far.
    names: FxHashSet<&'p str>,
    near: Suggestions,
}

impl<'p> Search<'p> {
    /// Returns the constraint of a record; `None` with an error in the report.
    fn constraint(
        &mut self,
        record: &'p LoopRecord,
        carriers: &[Option<usize>],
        report: &mut Report<'_>,
    ) -> Option<LoopConstraint> {
        let errors = report.errors();
        let mut error = |code, at: Option<usize>, message: String, help: &str| {
            report.error(code, at, Some(&record.subject()), message, help);
        };
        // A missing name is already an error.
        if !record.name.is_empty() && !self.names.insert(&record.name) {
            let message = "another joint has the same name";
            error(Code::DuplicateJoint, record.at, message.into(), "give one of them another name");
        }
        let ends = record.ends.each_ref().map(|end| {
            let numbers = end.pose.rotation.iter().flatten().chain(&end.pose.translation);
            if !numbers.into_iter().all(|x| x.abs() < MAX_NUMBER) {
                let message = "its origin is too far away to compute with";
                error(Code::NotFinite, end.at.or(record.at), message.into(), "write `xyz` in m");
            }
            let link = end.link.as_deref()?;
            let index = self.links.get(link).copied();
            if index.is_none() {
                let message = format!("it refers to link `{link}`, which does not exist");
                let names = self.description.link_names();
                let help = self.near.suggest(link, names).map_or_else(
                    || "name a link of the description".into(),
                    |name| format!("did you mean `{name}`?"),
                );
                error(Code::LoopLink, end.at, message, &help);
            }
            index.map(|link| LoopConstraintEnd { link, pose: end.pose })
        });
        if let [Some(a), Some(b)] = &ends
            && carriers[a.link] == carriers[b.link]
        {
            let [a, b] = [a, b].map(|end| self.description.links[end.link].name.text.as_str());
            let message = if a == b {
                format!("it connects link `{a}` to itself")
            } else {
                format!(
                    "it connects links `{a}` and `{b}`, which cannot move relative to each other"
                )
            };
            let help = "name two links with a moving joint between them";
            error(Code::LoopEnds, record.ends[1].at, message, help);
        }
        if report.errors() > errors {
            return None;
        }
        let [a, b] = ends;
        Some(LoopConstraint { name: record.name.clone(), kind: record.kind?, ends: [a?, b?] })
    }
}
