//! Which joint follows which.

use modyn_runtime::model::Model;
use rustc_hash::FxHashMap;

use super::{
    Mimic,
    build::LARGEST,
    circles::circles,
    joint::{JointPart, Kind, MimicPart},
    nearest::Suggestions,
    parts::Parts,
    report::Report,
};
use crate::error::{Code, Severity};

/// By joint: the joint, as an index, that it follows.
pub fn leaders(parts: &Parts, option: Mimic, report: &mut Report<'_>) -> Vec<Option<usize>> {
    let mut search = Search { parts, names: parts.joints_by_name(), near: Suggestions::new() };
    let mut leaders = vec![None; parts.joints.len()];
    for (joint, leader) in parts.joints.iter().zip(&mut leaders) {
        let Some(mimic) = &joint.mimic else { continue };
        match option {
            Mimic::Follow => *leader = search.leader(joint, mimic, report),
            Mimic::Independent => search.independent(joint, mimic, report),
            // Every one is an error already.
            Mimic::Refuse => {}
        }
    }
    for circle in circles(&leaders) {
        report_circle(parts, &circle, report);
    }
    leaders
}

struct Search<'p, 'a> {
    parts: &'p Parts<'a>,
    names: FxHashMap<&'a str, usize>,
    near: Suggestions,
}

impl Search<'_, '_> {
    /// The leader of a joint; `None` with an error in the report.
    fn leader(
        &mut self,
        follower: &JointPart,
        mimic: &MimicPart,
        report: &mut Report<'_>,
    ) -> Option<usize> {
        let name = mimic.leader.text;
        let mut error = |code, message: String, help: &str| {
            report.error(code, mimic.leader.at, Some(&follower.subject()), message, help);
        };
        let mut single = has_one_coordinate(follower.kind);
        if !single {
            let message = format!("it has several coordinates, so it cannot mimic joint `{name}`");
            error(Code::MimicCoordinates, message, ONE_COORDINATE);
        }
        let Some(&leader) = self.names.get(name) else {
            let message = format!("it mimics joint `{name}`, which does not exist");
            let near = self.near.nearest(name, self.parts.joints.iter().map(|j| j.name.text));
            let help = near.map_or_else(
                || "name a joint that moves, or remove `<mimic>`".into(),
                |name| format!("did you mean `{name}`?"),
            );
            error(Code::MimicTarget, message, &help);
            return None;
        };
        let kind = self.parts.joints[leader].kind;
        if kind == Kind::Fixed {
            let message = format!("it mimics joint `{name}`, which does not move");
            let help = "name a joint that moves, or make this one `fixed` as well";
            error(Code::MimicTarget, message, help);
            single = false;
        } else if !has_one_coordinate(kind) {
            let message = format!("it mimics joint `{name}`, which has several coordinates");
            error(Code::MimicCoordinates, message, ONE_COORDINATE);
            single = false;
        }
        single.then_some(leader)
    }

    /// A joint that is independent anyway may name whatever it likes, but it is worth a word.
    fn independent(&self, joint: &JointPart, mimic: &MimicPart, report: &mut Report<'_>) {
        if self.names.contains_key(mimic.leader.text) {
            return;
        }
        let message = format!("it mimics joint `{}`, which does not exist", mimic.leader.text);
        let help = "name a joint, or remove `<mimic>`: the joint is independent here";
        let (code, subject) = (Code::MimicTarget, joint.subject());
        report.add(Severity::Warning, code, mimic.leader.at, Some(&subject), message, help);
    }
}

const ONE_COORDINATE: &str =
    "mimics are between joints of the types `revolute`, `continuous` and `prismatic`";

/// A kind that could not be read is an error already.
fn has_one_coordinate(kind: Kind) -> bool {
    !matches!(kind, Kind::Moving(joint_type) if joint_type.nq() > 1)
}

fn report_circle(parts: &Parts, circle: &[usize], report: &mut Report<'_>) {
    let Some(&first) = circle.first() else { return };
    let joint = &parts.joints[first];
    let message = if circle.len() == 1 {
        "it mimics itself".into()
    } else {
        let names = circle.iter().map(|&j| format!("`{}`", parts.joints[j].name.text));
        let names: Vec<String> = names.collect();
        format!("joints mimic each other in a circle: {}", names.join(", "))
    };
    let at = joint.mimic.as_ref().map_or(joint.name.at, |mimic| mimic.leader.at);
    let help = "let one of them move by itself: remove its `<mimic>`";
    report.error(Code::MimicCycle, at, Some(&joint.subject()), message, help);
}

/// The links, as indices, whose joints follow in a ratio that one cannot compute with; along a chain
/// of mimics ratios multiply.
pub fn too_large(model: &Model) -> impl Iterator<Item = usize> {
    let large = |i: &usize| {
        let mimic = model.mimic(*i);
        mimic.is_some_and(|m| !(m.multiplier.abs() < LARGEST && m.offset.abs() < LARGEST))
    };
    (0..model.links().len()).filter(large)
}

pub const TOO_LARGE: &str =
    "its coordinate is too large a multiple of its leader's to compute with";
pub const TOO_LARGE_HELP: &str = "write `multiplier` as a ratio, and `offset` in rad or m";
