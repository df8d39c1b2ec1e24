//! Forces of fluids and tendons, which are not read.

use std::collections::BTreeSet;

use modyn_runtime::spatial::Pose;

use super::bodies::Bodies;
use super::check::list;
use super::item::Item;
use crate::diagnostics::{Code, Place, Severity};

impl<'e> Bodies<'e, '_, '_> {
    /// Reports the forces of fluids, such as air.
    pub fn fluids(&mut self, severity: Severity) {
        if !self.models[0].settings.flags.is_passive() {
            return;
        }
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

    /// Reports tendons that exert forces. A constraint can hold the length of a tendon: its forces
    /// then do nothing.
    pub fn tendons(&mut self, severity: Severity) {
        let held = self.held_tendons();
        let flags = self.models[0].settings.flags;
        let (mut places, mut kinds): (Vec<Place>, BTreeSet<String>) = Default::default();
        for item in self.of_section("tendon") {
            let element = item.element();
            if item.name().is_some_and(|name| held.contains(&name)) {
                continue;
            }
            if item.sets("armature") {
                let message = "the `armature` of a tendon is not read";
                let help = "write `armature=\"0\"`, or give it to the joints";
                self.report.error(Code::NotRead, element.at, None, message, help);
            }
            let kinds_of_force = [
                ("stiffness", flags.springs),
                ("damping", flags.dampers),
                ("frictionloss", flags.friction),
            ];
            let acting = kinds_of_force
                .into_iter()
                .filter_map(|(name, acts)| (acts && item.sets(name)).then_some(name));
            kinds.extend(acting.clone().map(|name| format!("`{name}`")));
            places.extend(acting.take(1).map(|_| (Some(element.at), None)));
        }
        let kinds: Vec<String> = kinds.into_iter().collect();
        let message = format!("forces of a tendon ({}) are not read", kinds.join(", "));
        let help = format!(
            "give them with the joint forces: write 0 for {} in it, or set the option `unread_forces = warn`",
            kinds.join(" and ")
        );
        self.report.add_once(severity, Code::NotRead, &places, &message, &help);
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
