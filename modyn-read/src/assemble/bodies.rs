//! From the tree of links and joints to moving bodies: links that fixed joints connect are merged.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{self, Inertial, Joint, MovingLink};
use modyn_runtime::spatial::Pose;

use super::tree::Tree;
use crate::check::{self, InertialView, JointView, LinkView};
use crate::description::{Base, Description, JointRecord, Kind, LinkRecord, MimicRecord};
use crate::diagnostics::Report;

/// A moving body: a link with a moving joint, and all links that are fixed to it.
pub struct MergedBody {
    /// The moving link, then the links that are fixed to it, as indices into the description.
    pub links: Vec<usize>,
    /// The joint; `None` for a floating base.
    pub joint: Option<usize>,
    /// Whether its inertia and its joint could be read, so that its motion can be checked.
    pub known: bool,
}

/// The bodies assembled so far.
pub struct Assembly {
    pub links: Vec<MovingLink>,
    pub bodies: Vec<MergedBody>,
    /// For each link of the description, the moving link that carries it, and its pose on that
    /// link.
    pub place: Vec<(Option<usize>, Pose<f64>)>,
}

/// Assigns each link to its body: a link that is fixed to a moving link is merged into it.
pub fn merge(
    description: &Description,
    tree: &Tree,
    base: Base,
    report: &mut Report<'_>,
) -> Assembly {
    let place = vec![(None, Pose::identity()); description.links.len()];
    let mut assembly = Assembly { links: Vec::new(), bodies: Vec::new(), place };
    for &link in &tree.order {
        let record = &description.links[link];
        if let Some(j) = tree.joint[link] {
            let joint = &description.joints[j];
            let above = tree.parent[j].map_or((None, Pose::identity()), |p| assembly.place[p]);
            let origin = joint_origin(joint, &above.1, report);
            assembly.place[link] = match moving_joint(joint, origin) {
                None => (above.0, origin),
                Some(moved) => {
                    let known = joint.sound && joint.kind != Kind::Unknown;
                    assembly.push(record, above.0, moved, Some(j), known)
                }
            };
            if let (Some(carrier), false) = (assembly.place[link].0, joint.sound) {
                assembly.bodies[carrier].known = false;
            }
        } else if base == Base::Floating {
            let up = [0.0, 0.0, 1.0];
            let joint =
                Joint::new(base_name(description), JointType::Floating, up, Pose::identity());
            assembly.place[link] = assembly.push(record, None, joint, None, true);
        }
        assembly.add_inertia(link, record);
    }
    assembly
}

impl Assembly {
    /// Adds a moving link, which carries itself.
    fn push(
        &mut self,
        record: &LinkRecord,
        parent: Option<usize>,
        joint: Joint,
        index: Option<usize>,
        known: bool,
    ) -> (Option<usize>, Pose<f64>) {
        let name = record.name.text.clone();
        self.links.push(MovingLink { name, parent, joint, inertial: Inertial::default() });
        self.bodies.push(MergedBody { links: Vec::new(), joint: index, known });
        (Some(self.links.len() - 1), Pose::identity())
    }

    /// Adds the inertia of a link of the description to the moving link that carries it.
    fn add_inertia(&mut self, link: usize, record: &LinkRecord) {
        // Links that are fixed to the world have no effect on the dynamics.
        let (Some(carrier), pose) = self.place[link] else { return };
        let body = &mut self.bodies[carrier];
        body.links.push(link);
        if let Some(record) = &record.inertial {
            let sum = &mut self.links[carrier].inertial;
            *sum = sum.merged(&record.inertial.transformed(&pose));
        }
    }

    /// Sets the leaders of mimic joints, which may be anywhere in the tree.
    pub fn resolve_mimics(
        &mut self,
        description: &Description,
        leaders: &[Option<usize>],
        follows: bool,
    ) {
        let mut moved_by = vec![None; description.joints.len()];
        for (i, body) in self.bodies.iter().enumerate() {
            if let Some(joint) = body.joint {
                moved_by[joint] = Some(i);
            }
        }
        for (link, body) in self.links.iter_mut().zip(&mut self.bodies) {
            let Some(joint) = body.joint else { continue };
            let Some(mimic) = &description.joints[joint].mimic else { continue };
            if let Some(leader) = leaders[joint].and_then(|leader| moved_by[leader]) {
                let MimicRecord { multiplier, offset, .. } = *mimic;
                link.joint.mimic = Some(model::Mimic { leader, multiplier, offset });
            } else if follows {
                body.known = false;
            }
        }
    }
}

/// Returns a joint's frame in the frame of its carrying body; the joint's parent has the pose
/// `above` there.
fn joint_origin(joint: &JointRecord, above: &Pose<f64>, report: &mut Report<'_>) -> Pose<f64> {
    let origin = above.compose(&joint.origin);
    let near = check::is_near(&origin, Some(joint.name.at), &joint.subject(), report);
    if near { origin } else { Pose::identity() }
}

/// Returns the joint; `None` for a fixed joint.
fn moving_joint(record: &JointRecord, origin: Pose<f64>) -> Option<Joint> {
    let joint_type = match record.kind {
        Kind::Fixed => return None,
        Kind::Moving(joint_type) => joint_type,
        // An unknown type is already an error; with a stand-in the rest can be checked.
        Kind::Unknown => JointType::Revolute,
    };
    Some(Joint {
        second_axis: record.second_axis,
        limits: record.limits,
        dynamics: record.dynamics,
        ..Joint::new(record.name.text.clone(), joint_type, record.axis, origin)
    })
}

/// Returns the name of a floating base's joint: one that no other joint has.
fn base_name(description: &Description) -> String {
    let taken = description.joints_by_name();
    let numbered = (1..).map(|n| format!("floating_base_{n}"));
    let mut names = std::iter::once("floating_base".into()).chain(numbered);
    names.find(|name: &String| !taken.contains_key(name.as_str())).unwrap_or_default()
}

impl MergedBody {
    /// Returns the body in the form of the checks.
    pub fn view<'d>(&self, description: &'d Description) -> check::Body<'d> {
        let joint = self.joint.map(|joint| {
            let record = &description.joints[joint];
            JointView {
                name: &record.name.text,
                at: Some(record.name.at),
                mimic_at: record.mimic.as_ref().map(|mimic| mimic.leader.at),
                dynamics: record.dynamics,
                dynamics_at: Some(record.dynamics_at),
            }
        });
        let link = |&link: &usize| {
            let LinkRecord { name, inertial, auxiliary, .. } = &description.links[link];
            let inertial = inertial.as_ref().map(|record| InertialView {
                inertial: record.inertial,
                at: Some(record.at),
                mass_at: Some(record.mass_at),
                sound: record.sound,
            });
            LinkView { name: &name.text, at: Some(name.at), inertial, auxiliary: *auxiliary }
        };
        check::Body { joint, links: self.links.iter().map(link).collect(), known: self.known }
    }
}
