//! The parameters of private functions.

use super::shape::Shape;
use crate::plan::{ArgumentKind, BatchForm};

/// A parameter, passed by reference.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    pub name: &'static str,
    pub shape: Shape,
    /// The type of the numbers of a table of constants; `None` for other parameters.
    pub(super) constants: Option<&'static str>,
    /// The kind of an argument; `None` for other parameters.
    pub(super) kind: Option<ArgumentKind>,
}

impl Parameter {
    pub(super) fn new(name: &'static str, shape: Shape) -> Self {
        Self { name, shape, constants: None, kind: None }
    }

    /// Returns the parameter as an argument of this kind.
    pub(super) fn of_kind(self, kind: ArgumentKind) -> Self {
        Self { kind: Some(kind), ..self }
    }

    /// Returns the form in functions of many states.
    pub(super) fn batch_form(&self) -> BatchForm {
        self.kind.map_or(BatchForm::Numbers, ArgumentKind::batch_form)
    }

    /// Returns whether the parameter is the set of active contacts, for which public functions have
    /// a type.
    pub(super) fn is_contacts(&self) -> bool {
        self.kind == Some(ArgumentKind::ActiveContacts)
    }

    /// Returns a parameter of constants, in the type's own scalar.
    pub(super) fn constants(name: &'static str, shape: Shape, float: &'static str) -> Self {
        Self { name, shape, constants: Some(float), kind: None }
    }

    /// Returns the name of entry `i` in the function. It differs from all temporaries: names of
    /// temporaries start with letters and a digit (`x1`, `s1_0`), names of parameters have letters
    /// only (and are not `k`, a function of constants).
    pub(super) fn entry(&self, i: usize) -> String {
        debug_assert!(self.name != "k" && !self.name.contains(|c: char| c.is_ascii_digit()));
        format!("{}_{i}", self.name)
    }

    /// Returns the parameter with its type over scalar `t`.
    pub(super) fn typed(&self, t: &str) -> String {
        format!("{}: &{}", self.name, self.shape.type_of(self.constants.unwrap_or(t)))
    }
}

/// Returns the statement that names a parameter's entries.
pub(super) fn unpacked(parameter: &Parameter) -> String {
    let Parameter { name, shape, .. } = parameter;
    let names: Vec<String> = (0..shape.len()).map(|i| parameter.entry(i)).collect();
    format!("let {} = *{name};", shape.value(&names))
}
