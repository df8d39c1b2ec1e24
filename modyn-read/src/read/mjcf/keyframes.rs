//! Keyframes, as named states of the robot.

use std::collections::BTreeSet;

use modyn_runtime::conventions::{mujoco, xyzw_from_wxyz};
use modyn_runtime::joint::JointType;

use super::bodies::Bodies;
use super::check::list;
use super::item::Item;
use crate::description::{KeyframeRecord, Kind, Located};
use crate::diagnostics::Code;

/// The largest number of coordinates of all keyframes together. Each keyframe has the coordinates
/// of all joints.
const MAX_COORDINATES: usize = 1_000_000;

/// An attribute of a keyframe with a wrong number of numbers.
struct WrongCount<'a> {
    attribute: &'static str,
    /// The name of the keyframe.
    keyframe: &'a str,
    /// The number of numbers that the attribute has, and the number that the model needs.
    counts: [usize; 2],
    /// The meaning of the numbers.
    numbers: &'static str,
}

impl<'e> Bodies<'e, '_, '_> {
    /// Adds the keyframes of the main model, while the joints are the joints of the text: before
    /// constraints fix some.
    pub fn keyframes(&mut self) {
        let items = self.of_section("keyframe");
        // Those of the main model come first; a model that attaches a part of itself has them
        // again.
        let own_count = self.models[0].source.root.in_sections("keyframe").count();
        let mut taken = BTreeSet::new();
        let coordinates: usize =
            self.drawn_coordinates().iter().map(|(_, values)| values.len()).sum();
        for (i, item) in items.iter().take(own_count).enumerate() {
            let at = item.element().at;
            if (i + 1).saturating_mul(coordinates) > MAX_COORDINATES {
                let message = format!(
                    "{own_count} keyframes of {coordinates} coordinates are more than {MAX_COORDINATES} \
                     coordinates together"
                );
                let help = "keep the keyframes that the program needs, or read the others as data";
                self.report.error(Code::Excessive, at, None, message, help);
                return;
            }
            if !self.models[item.model].is_sound(&item.chain) {
                continue;
            }
            let name = item.name().unwrap_or_else(|| format!("key_{i}"));
            if !taken.insert(name.clone()) {
                let message = format!("another keyframe has the name `{name}`");
                let help = "give one of them another name";
                self.report.error(Code::RepeatedElement, at, None, message, help);
                continue;
            }
            if let Some(coordinates) = self.coordinates(item, &name) {
                let velocities = self.velocities(item, &name, &coordinates);
                let [ctrl, act] = ["ctrl", "act"]
                    .map(|attribute| item.text(attribute).and_then(list).unwrap_or_default());
                let name = Located { text: name, at };
                let keyframe = KeyframeRecord { name, coordinates, velocities, ctrl, act };
                self.description.keyframes.push(keyframe);
            }
        }
        let is_attached = |item: &&Item| item.model != 0;
        let attached: Vec<_> =
            items.iter().filter(is_attached).map(|item| (Some(item.element().at), None)).collect();
        let help = "write the keyframe in the main model, with the coordinates of the whole robot";
        self.report.warn_once(
            Code::NotRead,
            &attached,
            "a keyframe of an attached model is not read",
            help,
        );
    }

    /// Keeps the controls of the keyframes for the actuators that are read, and their activations.
    /// `is_read` says of each actuator of the text whether it is read.
    pub fn keyframe_controls(&mut self, is_read: &[bool]) {
        let actuators = &self.description.actuation.actuators;
        let activations = actuators.iter().filter(|one| one.activation.is_some()).count();
        let reads_all = is_read.iter().all(|is_read| *is_read);
        let mut records = std::mem::take(&mut self.description.keyframes);
        let mut unread = Vec::new();
        for KeyframeRecord { name, ctrl, act, .. } in &mut records {
            if !ctrl.is_empty() && ctrl.len() != is_read.len() {
                let count = WrongCount {
                    attribute: "ctrl",
                    keyframe: &name.text,
                    counts: [ctrl.len(), is_read.len()],
                    numbers: "one for each actuator",
                };
                self.wrong_count(name.at, &count);
                ctrl.clear();
            }
            let mut is_read = is_read.iter();
            ctrl.retain(|_| is_read.next().is_some_and(|is_read| *is_read));
            if !reads_all {
                // The other actuators may have several activations each.
                if act.iter().any(|x| *x != 0.0) {
                    unread.push((Some(name.at), None));
                }
                act.clear();
            } else if !act.is_empty() && act.len() != activations {
                let count = WrongCount {
                    attribute: "act",
                    keyframe: &name.text,
                    counts: [act.len(), activations],
                    numbers: "one for each actuator with an activation",
                };
                self.wrong_count(name.at, &count);
                act.clear();
            }
        }
        self.description.keyframes = records;
        self.report.warn_once(
            Code::NotRead,
            &unread,
            "the activations of the keyframe are not read: some actuators are not read",
            "give the activations to the function `step_actuated`",
        );
    }

    /// Reports that an attribute of a keyframe has a wrong number of numbers.
    fn wrong_count(&mut self, at: usize, count: &WrongCount<'_>) {
        let WrongCount { attribute, keyframe, counts: [given, expected], numbers } = count;
        let message = format!(
            "`{attribute}` of the keyframe `{keyframe}` has {given} numbers, and the model needs {expected}"
        );
        let help = format!("write {expected} numbers: {numbers}");
        // MuJoCo fills in the numbers of attached models.
        if self.attached.len() > 1 {
            self.report.warn_once(Code::NotRead, &[(Some(at), None)], &message, &help);
        } else {
            self.report.error(Code::NumberCount, at, None, message, help);
        }
    }

    /// Returns the velocities of a keyframe by joint; none, with a diagnostic in the report, if their
    /// number is wrong.
    fn velocities(
        &mut self,
        item: &Item<'e>,
        name: &str,
        coordinates: &[(usize, Vec<f64>)],
    ) -> Vec<(usize, Vec<f64>)> {
        let Some(written) = item.text("qvel").and_then(list) else { return Vec::new() };
        let kind = |joint: usize| match self.description.joints[joint].kind {
            Kind::Moving(kind) => kind,
            _ => JointType::Revolute,
        };
        let count: usize = coordinates.iter().map(|(joint, _)| kind(*joint).nv()).sum();
        let mut rest = &written[..];
        let mut all = Vec::new();
        for (joint, q) in coordinates {
            let Some((qvel, others)) = rest.split_at_checked(kind(*joint).nv()) else { break };
            rest = others;
            let qd = match (&qvel, &q[..]) {
                (&&[vx, vy, vz, wx, wy, wz], &[x, y, z, a, b, c, d]) => {
                    let q = [x, y, z, a, b, c, d];
                    mujoco::from_qvel(q, [vx, vy, vz, wx, wy, wz]).to_vec()
                }
                (numbers, _) => numbers.to_vec(),
            };
            all.push((*joint, qd));
        }
        if written.len() == count {
            return all;
        }
        let count = WrongCount {
            attribute: "qvel",
            keyframe: name,
            counts: [written.len(), count],
            numbers: "one for each hinge and slide, three for each ball, six for each free joint",
        };
        let at = item.element().attribute("qvel").map_or(item.element().at, |qvel| qvel.value_at);
        self.wrong_count(at, &count);
        Vec::new()
    }

    /// Returns the coordinates of a keyframe by joint; `None` with a diagnostic in the report.
    /// Those that it lacks are those in which the model is drawn.
    fn coordinates(&mut self, item: &Item<'e>, name: &str) -> Option<Vec<(usize, Vec<f64>)>> {
        let written = item.text("qpos").and_then(list);
        let mut rest = written.as_deref();
        let mut all = Vec::new();
        let mut count = 0;
        for (joint, record) in self.description.joints.iter().enumerate() {
            let Kind::Moving(kind) = record.kind else { continue };
            count += kind.nq();
            let own_numbers = match &mut rest {
                // The length is wrong, and reported below.
                Some(rest) if rest.len() < kind.nq() => continue,
                Some(rest) => {
                    let (of_joint, others) = rest.split_at(kind.nq());
                    *rest = others;
                    Some(of_joint)
                }
                None => None,
            };
            let values = match (kind, own_numbers) {
                (JointType::Floating, Some(&[x, y, z, a, b, c, d])) => {
                    mujoco::from_qpos(joined([x, y, z], unit([a, b, c, d]))).to_vec()
                }
                (JointType::Spherical, Some(&[a, b, c, d])) => {
                    xyzw_from_wxyz(unit([a, b, c, d])).to_vec()
                }
                (JointType::Floating, Some(_)) | (_, None) => self.drawn(joint, kind),
                (_, Some(numbers)) => numbers.to_vec(),
            };
            all.push((joint, values));
        }
        let Some(written) = written.filter(|written| written.len() != count) else {
            return Some(all);
        };
        let at = item.element().attribute("qpos").map_or(item.element().at, |qpos| qpos.value_at);
        let count = WrongCount {
            attribute: "qpos",
            keyframe: name,
            counts: [written.len(), count],
            numbers: "one for each hinge and slide, four for each ball, seven for each free joint",
        };
        self.wrong_count(at, &count);
        None
    }

    /// Returns the coordinates of each moving joint in the pose in which the model is drawn.
    pub fn drawn_coordinates(&self) -> Vec<(usize, Vec<f64>)> {
        let moving = self.description.joints.iter().enumerate().filter_map(|(joint, record)| {
            let Kind::Moving(kind) = record.kind else { return None };
            Some((joint, self.drawn(joint, kind)))
        });
        moving.collect()
    }

    /// Returns the coordinates of a joint in the pose in which the model is drawn.
    fn drawn(&self, joint: usize, kind: JointType) -> Vec<f64> {
        match kind {
            JointType::Floating => {
                self.free_poses.get(&joint).map(|pose| pose.to_vec()).unwrap_or_default()
            }
            JointType::Spherical => vec![0.0, 0.0, 0.0, 1.0],
            _ => vec![self.references[joint].drawn],
        }
    }
}

fn joined([x, y, z]: [f64; 3], [a, b, c, d]: [f64; 4]) -> [f64; 7] {
    [x, y, z, a, b, c, d]
}

/// Returns a quaternion w, x, y, z of unit length; zero is the identity, as in `MuJoCo`.
fn unit(quaternion: [f64; 4]) -> [f64; 4] {
    let largest = quaternion.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if largest < 1e-15 {
        return [1.0, 0.0, 0.0, 0.0];
    }
    let scaled = quaternion.map(|x| x / largest);
    let length = libm::sqrt(scaled.iter().map(|x| x * x).sum());
    scaled.map(|x| x / length)
}
