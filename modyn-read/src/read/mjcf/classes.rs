//! Attributes of elements and of their default classes.

use std::collections::BTreeMap;

use super::element::Element;
use super::table::ACTUATORS;
use crate::diagnostics::{Code, Report};
use crate::work::counted;

/// The name of the outermost class, which all elements have.
const MAIN: &str = "main";

/// The largest number of elements of a class: all elements of the model look at all of them.
const MAX_ELEMENTS: usize = 200;

/// The classes of a model.
pub struct Classes<'e> {
    by_name: BTreeMap<&'e str, Class<'e>>,
}

struct Class<'e> {
    /// The class around it; `None` for the outermost one.
    parent: Option<&'e str>,
    /// The elements of its `<default>`s, without the elements of nested classes.
    elements: Vec<&'e Element>,
}

impl<'e> Classes<'e> {
    /// Returns the classes of the model whose root element is `root`; their errors are in the
    /// report.
    pub fn new(root: &'e Element, report: &mut Report<'_>) -> Self {
        let mut classes = Self { by_name: BTreeMap::new() };
        classes.by_name.insert(MAIN, Class { parent: None, elements: Vec::new() });
        for section in root.named("default") {
            if let Some(class) = section.attribute("class").filter(|class| class.value != MAIN) {
                let message =
                    format!("`class=\"{}\"` of the outermost `<default>` is not read", class.value);
                let help = "the outermost `<default>` is the class `main`: write the class in it";
                report.error(Code::NotRead, class.at, None, message, help);
            }
            classes.add(section, MAIN, report);
        }
        classes
    }

    fn add(&mut self, section: &'e Element, name: &'e str, report: &mut Report<'_>) {
        if let Some(class) = self.by_name.get_mut(name) {
            let elements = counted(section.children.iter()).filter(|child| child.name != "default");
            class.elements.extend(elements);
            if let Some(beyond) = class.elements.get(MAX_ELEMENTS) {
                let message = format!("the class `{name}` has more than {MAX_ELEMENTS} elements");
                let help = "write each kind of element once in a class; the last one counts";
                report.error(Code::Excessive, beyond.at, None, message, help);
                class.elements.truncate(MAX_ELEMENTS);
            }
        }
        for inner in section.named("default") {
            let Some(class) = inner.attribute("class").filter(|class| !class.value.is_empty())
            else {
                let message = "`<default>` in `<default>` has no `class`";
                report.error(Code::NotRead, inner.at, None, message, "write its `class`");
                continue;
            };
            // A class in one of the same name would be its own parent.
            if self.contains(&class.value) {
                let message = format!("another `<default>` has the class `{}`", class.value);
                let help = "give each class its own name";
                report.error(Code::NotRead, class.at, None, message, help);
                continue;
            }
            let entry = Class { parent: Some(name), elements: Vec::new() };
            self.by_name.insert(&class.value, entry);
            self.add(inner, &class.value, report);
        }
    }

    /// Returns whether there is a class of this name.
    pub fn contains(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }

    /// Returns the elements whose attributes an element has, the nearest first: the element itself,
    /// the elements of its class or else of the class `inherited` from the bodies around it, and
    /// the elements of the classes around its class.
    pub fn chain(&self, element: &'e Element, inherited: Option<&str>) -> Vec<&'e Element> {
        let mut chain = vec![element];
        let mut next = Some(element.text("class").or(inherited).unwrap_or(MAIN));
        while let Some(class) = next.and_then(|name| self.by_name.get(name)) {
            let elements = class.elements.iter().rev().copied();
            chain.extend(elements.filter(|child| is_default_of(&child.name, &element.name)));
            next = class.parent;
        }
        chain
    }
}

/// Returns whether the attributes of the element `class` in a `<default>` are the attributes of
/// elements of this name. (A joint of a body has no attribute of `<equality>`.)
fn is_default_of(class: &str, name: &str) -> bool {
    let both = |names: &[&str]| names.contains(&class) && names.contains(&name);
    class == name && name != "default"
        || both(ACTUATORS)
        || class == "tendon" && ["spatial", "fixed"].contains(&name)
        || class == "equality" && ["connect", "weld", "joint", "tendon"].contains(&name)
}
