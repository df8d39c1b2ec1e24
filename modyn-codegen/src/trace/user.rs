//! The graphs of users' functions.
//!
//! A `UserFunction` is called on an `Interpreter<Expr>`, whose mechanism has the run-time
//! parameters as inputs, so it can call every function of the interpreter. `Builder` traces it
//! before a plan is made, so its errors are errors of the compilation. `tangent` makes its
//! derivatives from the value's graph.

use modyn_runtime::model::Model;
use modyn_runtime::{Interpreter, UserError};

use super::Tracer;
use super::tangent::{TangentGraphs, TangentInput};
use crate::graph::{Expr, ForeignExpr};
use crate::passes::optimize;

/// The reason why a user's function cannot be traced.
#[derive(Debug)]
pub enum UserTraceError {
    /// It returned an error.
    Own(UserError),
    /// It used an expression of another trace.
    Foreign(ForeignExpr),
}

/// The graphs of a user's function, with the graphs of its derivatives.
pub struct UserGraphs<'a> {
    /// After all passes.
    pub optimized: TangentGraphs<'a>,
    /// As traced. Quantities of the robot have the operations that they have in the graphs of the
    /// table's functions, so a union with these does them once; passes would have rewritten them.
    pub traced: TangentGraphs<'a>,
}

impl Tracer<'_> {
    /// Traces a user's function of `model`. `evaluate` has the robot and the numbers of each
    /// argument.
    ///
    /// # Errors
    ///
    /// Errors of the function, and if it used an expression of another trace.
    pub fn user_function(
        &self,
        model: &Model,
        inputs: Vec<TangentInput>,
        evaluate: impl FnOnce(&mut Interpreter<Expr>, &[&[Expr]]) -> Result<Vec<Expr>, UserError>,
    ) -> Result<UserGraphs<'_>, UserTraceError> {
        let arguments = inputs.iter().map(|input| input.len).sum();
        let mut error = None;
        let graph = self.try_trace_groups([arguments], |mechanism, [numbers]| {
            let mut rest = &numbers[..];
            let mut next = |input: &TangentInput| {
                let (numbers, others) = rest.split_at(input.len);
                rest = others;
                numbers
            };
            let groups: Vec<&[Expr]> = inputs.iter().map(&mut next).collect();
            let mut robot = Interpreter::with_mechanism(model.clone(), mechanism.clone());
            evaluate(&mut robot, &groups).unwrap_or_else(|fault| {
                error = Some(fault);
                Vec::new()
            })
        });
        match (error, graph) {
            (Some(error), _) => Err(UserTraceError::Own(error)),
            (None, Err(foreign)) => Err(UserTraceError::Foreign(foreign)),
            (None, Ok(graph)) => Ok(UserGraphs {
                traced: TangentGraphs::new(self, inputs.clone(), graph.clone()),
                optimized: TangentGraphs::new(self, inputs, optimize(graph)),
            }),
        }
    }
}
