//! Forces of fluids, which are not read.

use modyn_runtime::spatial::Pose;

use super::bodies::Bodies;
use super::check::list;
use super::item::Item;
use crate::diagnostics::{Code, Severity};

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
                    "write {}, or set the option `unsupported_forces = warn`: the robot moves as in a vacuum",
                    zeros.join(" and ")
                );
                self.report.add(severity, Code::NotRead, first.at, None, message, help);
            }
        }
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
