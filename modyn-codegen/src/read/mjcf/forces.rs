//! Tendons, which are read if they exert no force, and the limits of actuators' forces.

use modyn_runtime::model::Limits;
use modyn_runtime::spatial::Pose;

use super::bodies::Bodies;
use super::check::list;
use super::item::Item;
use super::joints::is_limited;
use crate::description::MAX_NUMBER;
use crate::diagnostics::{Code, Place, Subject};

/// Actuators whose force is that of a controller: the target is the argument, and not the force.
const SERVOS: [&str; 8] =
    ["position", "velocity", "intvelocity", "orientation", "pid", "damper", "dcmotor", "cylinder"];

impl<'e> Bodies<'e, '_, '_> {
    /// Refuses tendons that exert forces. A constraint can hold the length of a tendon: its forces then do nothing.
    pub fn tendons(&mut self) {
        let held = self.held_tendons();
        for item in self.of_section("tendon") {
            let element = item.element();
            if item.name().is_some_and(|name| held.contains(&name)) {
                continue;
            }
            let sets = |name: &str| {
                item.text(name)
                    .and_then(list)
                    .is_some_and(|numbers| numbers.iter().any(|number| *number != 0.0))
            };
            let forces = ["stiffness", "damping", "frictionloss", "armature"];
            if let Some(name) = forces.into_iter().find(|name| sets(name)) {
                let message = format!("a tendon with `{name}` is not read");
                let help = format!(
                    "forces of tendons are not supported: write `{name}=\"0\"` in it, and give them with the joint forces"
                );
                self.report.error(Code::NotRead, element.at, None, message, help);
            }
        }
    }

    /// Sets the effort limits of joints whose actuators have a limited force, and warns of servo actuators.
    pub fn actuators(&mut self) {
        let mut servos: Vec<Place> = Vec::new();
        let (mut has_general, mut has_others) = (false, false);
        // For each joint, the sum of its actuators' largest forces; `None` if one has no limit.
        let mut efforts = vec![Some(0.0); self.description.joints.len()];
        for item in self.of_section("actuator") {
            let element = item.element();
            let is_affine =
                ["affine", "so3", "dcmotor"].contains(&item.text("biastype").unwrap_or_default());
            let joint = element.attribute("joint").or(element.attribute("jointinparent"));
            let joint = joint.map(|joint| item.naming.name(&joint.value));
            if SERVOS.contains(&element.name.as_str()) || element.name == "general" && is_affine {
                servos.push((Some(element.at), joint.clone().map(Subject::Joint)));
                has_general |= element.name == "general";
                has_others |= element.name != "general";
            }
            let found = joint.and_then(|name| {
                self.description.joints.iter().position(|joint| joint.name.text == name)
            });
            if let Some(found) = found {
                let effort = self.largest_force(&item);
                efforts[found] = efforts[found].zip(effort).map(|(sum, effort)| sum + effort);
            }
        }
        for (joint, effort) in self.description.joints.iter_mut().zip(efforts) {
            let effort = effort.filter(|effort| *effort > 0.0 && *effort < MAX_NUMBER);
            let none = Limits { lower: None, upper: None, velocity: None, effort: None };
            if effort.is_some() && joint.limits.is_none_or(|limits| limits.effort.is_none()) {
                joint.limits = Some(Limits { effort, ..joint.limits.unwrap_or(none) });
            }
        }
        servos.sort_by_key(|(at, _)| *at);
        let message = "the controller of the actuator is not read: the dynamics have the joint force as an argument";
        let laws = [
            (
                has_general,
                "for `<general>` `gear * (gainprm[0] * ctrl + biasprm[0] + biasprm[1] * gear * q + biasprm[2] * gear * qd)`, ",
            ),
            (has_others, "for `<position>` `gear * (kp * (target - gear * q) - kv * gear * qd)`, "),
        ];
        let laws: String = laws.iter().filter(|(has, _)| *has).map(|(_, law)| *law).collect();
        let help = format!("compute the force, {laws}within `forcerange`, and pass it as `tau`");
        self.report.warn_once(Code::NotRead, &servos, message, &help);
    }

    /// Returns the largest force of an actuator on its joint, if it is the same in both directions.
    fn largest_force(&self, item: &Item<'e>) -> Option<f64> {
        let model = &self.models[item.model];
        let gear =
            item.text("gear").and_then(list).and_then(|gear| gear.first().copied()).unwrap_or(1.0);
        let is_motor = item.element().name == "motor";
        let ranges = [("forcelimited", "forcerange", true), ("ctrllimited", "ctrlrange", is_motor)];
        let bounds = ranges.into_iter().filter(|(.., applies)| *applies).filter_map(
            |(limited, range, _)| {
                let [lower, upper]: [f64; 2] = item.numbers(range)?;
                (is_limited(item, limited, range, model) && -lower == upper && upper > 0.0)
                    .then_some(upper)
            },
        );
        bounds.reduce(f64::min).map(|bound| bound * gear.abs())
    }

    /// Returns the elements of a section of all models.
    pub fn of_section(&self, name: &'e str) -> Vec<Item<'e>> {
        let attached = self.attached.iter().flat_map(|(index, naming)| {
            let model = &self.models[*index];
            model.source.root.in_sections(name).map(move |element| Item {
                chain: model.classes.chain(element, None),
                frame: Pose::identity(),
                inherited: None,
                naming: naming.clone(),
                model: *index,
            })
        });
        attached.collect()
    }
}
