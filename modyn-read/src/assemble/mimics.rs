//! The leaders of mimic joints.

use rustc_hash::FxHashMap;

use super::cycles::cycles;
use crate::description::{Description, JointRecord, Kind, Mimic, MimicRecord};
use crate::diagnostics::{Code, Report, Severity, Suggestions};

/// Returns the leader of each joint, as an index; `None` for joints that are no mimic joints.
pub fn leaders(
    description: &Description,
    option: Mimic,
    report: &mut Report<'_>,
) -> Vec<Option<usize>> {
    let mut search =
        Search { description, names: description.joints_by_name(), near: Suggestions::new() };
    let mut leaders = vec![None; description.joints.len()];
    for (joint, leader) in description.joints.iter().zip(&mut leaders) {
        let Some(mimic) = &joint.mimic else { continue };
        match option {
            Mimic::Follow => *leader = search.leader(joint, mimic, report),
            Mimic::Independent => search.independent(joint, mimic, report),
            Mimic::Refuse => {
                let message =
                    format!("it mimics joint `{}`, which is refused here", mimic.leader.text);
                let help = "remove `<mimic>`, or set the option `mimic = follow`, or `mimic = independent`: the joint \
                            is then moved by its own coordinate";
                let at = mimic.leader.at;
                let subject = joint.subject();
                report.error(Code::Mimic, at, Some(&subject), message, help);
            }
        }
    }
    for cycle in cycles(&leaders) {
        report_cycle(description, &cycle, report);
    }
    leaders
}

struct Search<'p> {
    description: &'p Description,
    names: FxHashMap<&'p str, usize>,
    near: Suggestions,
}

impl Search<'_> {
    /// Returns the leader of a joint; `None` with an error in the report.
    fn leader(
        &mut self,
        follower: &JointRecord,
        mimic: &MimicRecord,
        report: &mut Report<'_>,
    ) -> Option<usize> {
        let name = mimic.leader.text.as_str();
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
            let near = self.near.suggest(name, self.description.joint_names());
            let help = near.map_or_else(
                || "name a joint that moves, or remove `<mimic>`".into(),
                |name| format!("did you mean `{name}`?"),
            );
            error(Code::MimicTarget, message, &help);
            return None;
        };
        let kind = self.description.joints[leader].kind;
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

    /// Warns of a missing leader: a joint that the options make independent may name any leader.
    fn independent(&self, joint: &JointRecord, mimic: &MimicRecord, report: &mut Report<'_>) {
        if self.names.contains_key(mimic.leader.text.as_str()) {
            return;
        }
        let message = format!("it mimics joint `{}`, which does not exist", mimic.leader.text);
        let help = "name a joint, or remove `<mimic>`: the joint is independent here";
        let code = Code::MimicTarget;
        let subject = joint.subject();
        report.add(Severity::Warning, code, mimic.leader.at, Some(&subject), message, help);
    }
}

const ONE_COORDINATE: &str =
    "only `revolute`, `continuous` and `prismatic` joints can mimic and be mimicked";

/// Returns whether joints of this kind have one coordinate. An unreadable kind is already an error,
/// so it passes.
fn has_one_coordinate(kind: Kind) -> bool {
    !matches!(kind, Kind::Moving(joint_type) if joint_type.nq() > 1)
}

fn report_cycle(description: &Description, cycle: &[usize], report: &mut Report<'_>) {
    let Some(&first) = cycle.first() else { return };
    let joint = &description.joints[first];
    let message = if cycle.len() == 1 {
        "it mimics itself".into()
    } else {
        let shown = cycle.iter().map(|&j| format!("`{}`", description.joints[j].name.text));
        let names: Vec<String> = shown.collect();
        format!("mimic joints form a cycle: {}", names.join(", "))
    };
    let at = joint.mimic.as_ref().map_or(joint.name.at, |mimic| mimic.leader.at);
    let help = "make one of them independent: remove its `<mimic>`";
    report.error(Code::MimicCycle, at, Some(&joint.subject()), message, help);
}
