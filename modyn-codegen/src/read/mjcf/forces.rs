//! Forces of fluids and tendons, which are not read, and the limits of actuators' forces.

use std::collections::BTreeSet;

use modyn_runtime::model::Limits;
use modyn_runtime::spatial::Pose;

use super::bodies::Bodies;
use super::check::list;
use super::item::Item;
use super::joints::is_limited;
use crate::description::MAX_NUMBER;
use crate::diagnostics::{Code, Place, Severity, Subject};

/// Actuators whose force is that of a controller: the target is the argument, and not the force.
const SERVOS: [&str; 8] =
    ["position", "velocity", "intvelocity", "orientation", "pid", "damper", "dcmotor", "cylinder"];

impl<'e> Bodies<'e, '_, '_> {
    /// Reports the forces of fluids, such as air.
    pub fn fluids(&mut self, severity: Severity) {
        for model in &self.models {
            for option in model.source.root.named("option") {
                let is_set = |name: &&str| {
                    let numbers = option.text(name).and_then(list);
                    numbers.is_some_and(|numbers| numbers.iter().any(|number| *number != 0.0))
                };
                let names: Vec<&str> =
                    ["density", "viscosity"].into_iter().filter(is_set).collect();
                let Some(first) = names.first().and_then(|name| option.attribute(name)) else {
                    continue;
                };
                let message = format!(
                    "forces of air and other fluids (`{}`) are not read",
                    names.join("`, `")
                );
                let zeros: Vec<String> =
                    names.iter().map(|name| format!("`{name}=\"0\"`")).collect();
                let help = format!(
                    "write {}, or set the option `unread_forces = warn`: the robot moves as in a vacuum",
                    zeros.join(" and ")
                );
                self.report.add(severity, Code::NotRead, first.at, None, message, help);
            }
        }
    }

    /// Reports tendons that exert forces. A constraint can hold the length of a tendon: its forces then do nothing.
    pub fn tendons(&mut self, severity: Severity) {
        let held = self.held_tendons();
        let (mut found, mut kinds): (Vec<Place>, BTreeSet<String>) = Default::default();
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
            if sets("armature") {
                let message = "the `armature` of a tendon is not read";
                let help = "write `armature=\"0\"`, or give it to the joints";
                self.report.error(Code::NotRead, element.at, None, message, help);
            }
            let own =
                ["stiffness", "damping", "frictionloss"].into_iter().filter(|name| sets(name));
            kinds.extend(own.clone().map(|name| format!("`{name}`")));
            found.extend(own.take(1).map(|_| (Some(element.at), None)));
        }
        let kinds: Vec<String> = kinds.into_iter().collect();
        let message = format!("forces of a tendon ({}) are not read", kinds.join(", "));
        let help = format!(
            "give them with the joint forces: write 0 for {} in it, or set the option `unread_forces = warn`",
            kinds.join(" and ")
        );
        self.report.add_once(severity, Code::NotRead, &found, &message, &help);
    }

    /// Sets the effort limits of joints whose actuators have a limited force, and warns of servo actuators.
    pub fn actuators(&mut self) {
        let mut servos: Vec<Place> = Vec::new();
        let (mut has_general, mut has_others) = (false, false);
        // For each joint, the sum of its actuators' largest forces; `None` if one has no limit.
        let mut efforts = vec![Some(0.0); self.description.joints.len()];
        let joints = self.description.joints_by_name();
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
            if let Some(&found) = joint.and_then(|name| joints.get(name.as_str())) {
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
