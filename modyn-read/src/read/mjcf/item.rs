//! An element of a body, with what it has from the elements around it.

use std::rc::Rc;

use modyn_runtime::spatial::Pose;

use super::check;
use super::element::Element;

/// The names of a copy of a model's part: models are attached with a prefix, and replicas have a
/// suffix.
#[derive(Default)]
pub struct Naming {
    pub prefix: String,
    pub suffix: String,
}

impl Naming {
    /// Returns the name of an element in the whole model.
    pub fn name(&self, name: &str) -> String {
        format!("{}{name}{}", self.prefix, self.suffix)
    }
}

/// An element with its classes, its frame and its names.
#[derive(Clone)]
pub struct Item<'e> {
    /// The element, then the elements of its classes, whose attributes it has as well.
    pub chain: Vec<&'e Element>,
    /// The frame in which its pose is written, in the frame of the body.
    pub frame: Pose<f64>,
    /// The class of elements in it, unless they have their own.
    pub inherited: Option<&'e str>,
    pub naming: Rc<Naming>,
    /// The index of the model.
    pub model: usize,
}

impl<'e> Item<'e> {
    /// Returns the element itself.
    pub fn element(&self) -> &'e Element {
        self.chain[0]
    }

    /// Returns the text of an attribute of the element or of its classes.
    pub fn text(&self, name: &str) -> Option<&'e str> {
        self.chain.iter().find_map(|element| element.text(name))
    }

    /// Returns the numbers of an attribute; `None` if there is none, or if it is not sound.
    pub fn numbers<const N: usize>(&self, name: &str) -> Option<[f64; N]> {
        self.text(name).and_then(check::numbers)
    }

    /// Returns the number of an attribute; `None` if there is none, or if it is not sound.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers(name).map(|[number]| number)
    }

    /// Returns whether an attribute has a number that is not zero.
    pub fn sets(&self, name: &str) -> bool {
        let numbers = self.text(name).and_then(check::list);
        numbers.is_some_and(|numbers| numbers.iter().any(|number| *number != 0.0))
    }

    /// Returns the name of the element in the whole model; `None` if it has none.
    pub fn name(&self) -> Option<String> {
        let written = self.element().text("name").filter(|name| !name.is_empty());
        written.map(|given| self.naming.name(given))
    }
}
