//! The reader of an SDF: numbers, flags and poses, which are the contents of elements.

use modyn_runtime::conventions::rotation_from_quaternion;
use modyn_runtime::spatial::Pose;
use roxmltree::Node;

use super::files::Files;
use super::world::World;
use crate::description::{Located, MAX_NUMBER, ReadOptions, roll_pitch_yaw};
use crate::diagnostics::{Code, Subject};
use crate::read::xml::element::{Attribute, Elements, children, shown, written};
use crate::read::xml::unread::Unread;

/// Reads elements into a [`World`]: models and links in `model`, joints in `joint`, other
/// files in `include`.
pub struct Reader<'a, 't, 'r, 'f> {
    pub xml: Elements<'a, 't, 'r, 'f>,
    pub world: &'r mut World,
    pub files: &'r mut Files,
    pub options: &'r ReadOptions,
    /// The version of the file, times 100.
    pub version: u32,
    pub unread: Unread,
}

impl<'a> Reader<'a, '_, '_, '_> {
    /// Returns the number in an optional child element.
    pub fn number(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<f64> {
        let child = self.xml.single(node, name, subject)?;
        self.xml.numbers::<1>(self.xml.content(child), subject).map(|[value]| value)
    }

    /// Returns the number in an optional child element; `None` also for an infinite number.
    pub fn finite(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<f64> {
        let child = self.xml.single(node, name, subject)?;
        let text = self.xml.content(child);
        let unsigned = text.text.trim().trim_start_matches(['+', '-']).to_ascii_lowercase();
        if matches!(unsigned.as_str(), "inf" | "infinity") {
            return None;
        }
        let [value] = self.xml.numbers::<1>(text, subject)?;
        (value.abs() < INFINITE).then_some(value)
    }

    /// Returns the truth value in an optional child element.
    pub fn flag(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<bool> {
        let child = self.xml.single(node, name, subject)?;
        self.truth(self.xml.content(child), name, subject)
    }

    /// Returns a truth value.
    pub fn truth(
        &mut self,
        text: Attribute<'a>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<bool> {
        match text.text.trim().to_ascii_lowercase().as_str() {
            "true" | "1" => Some(true),
            "false" | "0" => Some(false),
            _ => {
                let message = format!("`{name}` is neither `true` nor `false`");
                let help = "write `true` or `false`";
                self.xml.report.error(Code::BadNumber, text.at, subject, message, help);
                None
            }
        }
    }

    /// Returns the name in a required child element.
    pub fn name_in(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<Located> {
        let child = self.xml.single(node, name, subject);
        let text =
            child.map(|node| self.xml.content(node)).filter(|text| !text.text.trim().is_empty());
        if text.is_none() {
            let name = shown(name);
            let message = format!("`<{}>` has no `<{name}>`", written(node));
            let help = format!("write `<{name}>...</{name}>` with the name of a link");
            let at = child.unwrap_or(node).range().start;
            self.xml.report.error(Code::MissingElement, at, subject, message, help);
        }
        text.map(trimmed)
    }

    /// Returns the pose of the `<pose>` in an element, and the name of its frame. The default is
    /// the identity.
    pub fn pose(
        &mut self,
        node: Node<'a, '_>,
        subject: Option<&Subject>,
    ) -> (Pose<f64>, Option<Located>) {
        let Some(node) = self.xml.single(node, "pose", subject) else {
            return (Pose::identity(), None);
        };
        let known = ["relative_to", "rotation_format", "degrees", "frame"];
        self.xml.warn_of_unknown_attributes(node, &known, subject);
        let frame = self.xml.optional(node, "relative_to").map(trimmed);
        let pose = self.pose_numbers(node, subject).unwrap_or_else(Pose::identity);
        (pose, frame.filter(|name| !name.text.is_empty()))
    }

    fn pose_numbers(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Option<Pose<f64>> {
        let attribute = self.xml.optional(node, "degrees");
        let degrees = attribute.and_then(|text| self.truth(text, "degrees", subject));
        let text = self.xml.content(node);
        let format = self.xml.optional(node, "rotation_format");
        let format_name = format.map_or("euler_rpy", |format| format.text.trim());
        if text.text.trim().is_empty() {
            return None;
        }
        let (translation, rotation) = match format_name {
            "" | "euler_rpy" => {
                let [x, y, z, roll, pitch, yaw] = self.xml.numbers::<6>(text, subject)?;
                let unit = if degrees == Some(true) { core::f64::consts::PI / 180.0 } else { 1.0 };
                ([x, y, z], roll_pitch_yaw([roll, pitch, yaw].map(|angle| angle * unit)))
            }
            "quat_xyzw" if degrees != Some(true) => {
                let [x, y, z, qx, qy, qz, qw] = self.xml.numbers::<7>(text, subject)?;
                let largest =
                    [qx, qy, qz, qw].into_iter().fold(0.0, |max: f64, x| max.max(x.abs()));
                let scaled = [qx, qy, qz, qw].map(|entry| entry / largest);
                let length = libm::sqrt(scaled.iter().map(|x| x * x).sum());
                if largest == 0.0 {
                    let message = "the quaternion of the pose is zero";
                    let help = "write `x y z qx qy qz qw`, where `0 0 0 1` is no rotation";
                    self.xml.report.error(Code::BadNumber, text.at, subject, message, help);
                    return None;
                }
                ([x, y, z], rotation_from_quaternion(scaled.map(|entry| entry / length)))
            }
            other => {
                let message = if other == "quat_xyzw" {
                    "a quaternion has no degrees".into()
                } else {
                    format!("`{other}` is not a form of rotation")
                };
                let help = "write `rotation_format=\"euler_rpy\"`, perhaps with `degrees=\"true\"`, or \
                            `rotation_format=\"quat_xyzw\"`";
                let at = format.map_or(text.at, |format| format.at);
                self.xml.report.error(Code::NotRead, at, subject, message, help);
                return None;
            }
        };
        if !translation.iter().all(|x| x.abs() < MAX_NUMBER) {
            let message = "the pose is too far away to compute with";
            let help = "write it in m";
            self.xml.report.error(Code::NotFinite, text.at, subject, message, help);
            return None;
        }
        Some(Pose { rotation, translation })
    }

    /// Reports child elements that SDF does not have here, and extensions, once for each name: a
    /// misspelt element would silently have no effect.
    pub fn warn_of_unknown(
        &mut self,
        node: Node<'a, '_>,
        known: &[&str],
        subject: Option<&Subject>,
    ) {
        for child in children(node).filter(Node::is_element) {
            let name = child.tag_name().name();
            let place = (Some(self.xml.at(child)), subject.cloned());
            if !known.contains(&name) && !self.unread.add_extension(child, place.clone()) {
                let message = format!("the element `<{name}>` is not read");
                self.unread.add(message, place, "check its spelling; SDF has no such element here");
            }
        }
    }
}

/// The magnitude from which a limit is none: the default of old versions.
const INFINITE: f64 = 1e16;

/// Returns a text without the blanks around it.
pub fn trimmed(text: Attribute) -> Located {
    Located { text: text.text.trim().into(), at: text.at }
}
