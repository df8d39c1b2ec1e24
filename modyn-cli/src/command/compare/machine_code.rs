//! The robot as machine code of this processor, called in this process.

use std::hint::black_box;

use modyn_codegen::Planning;
use modyn_jit::{CallError, Compiled, Options};

use super::harness::Measured;
use super::quantities::{Quantity, State};
use super::timing;
use crate::command::outcome::Failure;

/// A robot's machine code.
pub struct MachineCode(Compiled<f64>);

impl MachineCode {
    /// Compiles the planned functions for this processor.
    pub fn compile(planning: &Planning) -> Result<Self, Failure> {
        let compiled = Compiled::from_plan(planning, Options::default());
        compiled.map(Self).map_err(|error| {
            Failure::usage(format!(
                "error: {error}\nhelp: `--rustc` compiles the generated Rust instead"
            ))
        })
    }

    /// Returns the compiler in words.
    pub fn name(&self) -> String {
        format!("machine code ({:?})", self.0.instruction_set())
    }

    /// Returns the results of each function at these states.
    pub fn run(&self, quantities: &[Quantity], states: &[State]) -> Result<Vec<Measured>, Failure> {
        let measure = |quantity| self.measure(quantity, states);
        let measured: Result<_, CallError> = quantities.iter().map(measure).collect();
        measured.map_err(|error| Failure::usage(format!("error: {error}")))
    }

    fn measure(&self, quantity: &Quantity, states: &[State]) -> Result<Measured, CallError> {
        let call = self.0.function(quantity.function)?;
        let arguments_of = |state| -> Vec<&[f64]> {
            call.arguments().iter().map(|(name, _)| State::argument(state, name)).collect()
        };
        let arguments: Vec<_> = states.iter().map(arguments_of).collect();
        let mut results = vec![vec![0.0; call.result().len()]; states.len()];
        for (arguments, result) in arguments.iter().zip(&mut results) {
            call.one(arguments, result)?;
        }
        let mut result = vec![0.0; call.result().len()];
        let mut done = Ok(());
        let nanoseconds = timing::nanoseconds(arguments.len(), || {
            for arguments in &arguments {
                let called = call.one(black_box(arguments), black_box(&mut result));
                done = done.clone().and(called);
            }
        });
        done?;
        Ok((results, nanoseconds))
    }
}
