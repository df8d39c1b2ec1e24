//! A planned function with its Rust types.

use super::parameter::Parameter;
use super::shape::Shape;
use crate::plan::{self, Argument, CForm, Function, Kernels, Planned};

/// A planned function with its Rust types.
#[derive(Clone)]
pub(super) struct Quantity<'a> {
    /// The function; `None` for a fused function and a user's function.
    pub function: Option<Function>,
    pub name: &'static str,
    /// The name of the function of one state, if this is its form for many states.
    pub batch_of: Option<&'static str>,
    pub parameters: Vec<Parameter>,
    /// The arguments with their layouts.
    pub arguments: &'a [(Argument, plan::Shape)],
    /// The layout of the result.
    pub result: &'a plan::Shape,
    /// The result as a Rust type.
    pub shape: Shape,
    /// Whether a source of random numbers stands for the argument.
    pub takes_source: bool,
    /// Whether the function of the trait depends on run-time parameters.
    pub dynamic: bool,
    /// The number of run-time parameters.
    pub runtime: usize,
    pub kernels: &'a Kernels,
    pub docs: &'static str,
    /// The documentation of each field of the result, if the result is a type of the robot's own.
    pub fields: &'a [&'static str],
    pub c_form: CForm,
}

impl<'a> Quantity<'a> {
    pub fn new(planned: &'a Planned, robot: &str) -> Self {
        let parameter = |(argument, shape): &(Argument, plan::Shape)| {
            Parameter::new(argument.name, Shape::new(shape, robot)).of_kind(argument.kind)
        };
        Self {
            function: planned.function,
            name: planned.name,
            batch_of: planned.batch_of,
            parameters: planned.arguments.iter().map(parameter).collect(),
            arguments: &planned.arguments,
            shape: Shape::new(&planned.result, robot),
            result: &planned.result,
            takes_source: planned.function.is_some_and(Function::is_of_random_numbers),
            dynamic: planned.function.is_some_and(Function::depends_on_parameters),
            runtime: planned.parameters,
            kernels: &planned.kernels,
            docs: planned.docs,
            fields: &planned.fields,
            c_form: planned.c_form,
        }
    }

    /// Returns the function with a number for each contact, as C passes a set of contacts; `None`
    /// for a function without contacts.
    pub fn with_numbers_of_contacts(&self) -> Option<Self> {
        let mut of_numbers = self.clone();
        let mut parameters = of_numbers.parameters.iter_mut();
        parameters.find(|p| p.is_contacts() && !p.shape.is_empty())?.kind = None;
        Some(of_numbers)
    }

    /// Returns the parameter of a private function for the run-time parameters.
    pub fn runtime_parameter(&self) -> Option<Parameter> {
        (self.runtime > 0).then(|| Parameter::new("params", Shape::vector(self.runtime)))
    }

    /// Returns the parameters of a private function.
    pub fn all_parameters(&self) -> Vec<Parameter> {
        self.parameters.iter().cloned().chain(self.runtime_parameter()).collect()
    }
}
