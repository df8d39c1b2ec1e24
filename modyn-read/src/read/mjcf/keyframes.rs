//! Keyframes, as named coordinates of the robot.

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

impl<'e> Bodies<'e, '_, '_> {
    /// Adds the keyframes of the main model, while the joints are the joints of the text: before
    /// constraints fix some.
    pub fn keyframes(&mut self) {
        let items = self.of_section("keyframe");
        // Those of the main model come first; a model that attaches a part of itself has them
        // again.
        let own_count = self.models[0].source.root.in_sections("keyframe").count();
        let mut taken = BTreeSet::new();
        let mut moving = Vec::new();
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
                let name = Located { text: name, at };
                self.description.keyframes.push(KeyframeRecord { name, coordinates });
            }
            let velocities = item.text("qvel").and_then(list).unwrap_or_default();
            if velocities.iter().any(|velocity| *velocity != 0.0) {
                moving.push((Some(at), None));
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
        let help = "copy its `qvel` into the program, and convert that of free joints by `modyn::conventions::mujoco`";
        self.report.warn_once(
            Code::NotRead,
            &moving,
            "the velocities of the keyframe are not read",
            help,
        );
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
        let message = format!(
            "`qpos` of the keyframe `{name}` has {} numbers, and the model {count} coordinates",
            written.len()
        );
        let help = format!(
            "write {count} numbers: one for each hinge and slide, four for each ball, seven for each free joint"
        );
        // MuJoCo fills in the coordinates of attached models.
        if self.attached.len() > 1 {
            self.report.warn_once(Code::NotRead, &[(Some(at), None)], &message, &help);
        } else {
            self.report.error(Code::NumberCount, at, None, message, help);
        }
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
