//! The functions that `CasADi` loads: each function of a robot with its derivatives, over the
//! nonzeros of sparse matrices.
//!
//! `CasADi` finds derivatives by their names. For a function `f`, they are its Jacobian `jac_f`,
//! products with it `fwd1_f` and `adj1_f`, and the Jacobian of the latter `jac_adj1_f`, which has
//! the second derivatives of a weighted sum of the results.
//!
//! Results that are constant zeros are dropped: the remaining entries are the sparsity patterns.
//! The signatures of the derivatives follow from the function's.

mod family;
mod matrix;
mod nonzeros;

use modyn_runtime::model::Model;
use modyn_runtime::quantities::Function;

pub use matrix::CasadiMatrix;

use super::context::PlanContext;
use super::limit::{Budget, TooLong};
use super::packing;
use super::wrapped::docs_of;
use crate::names;
use crate::passes::optimize;
use crate::program::{Execution, Program};
use crate::trace::{EntryDerivatives, Tracer};
use family::{Family, Member};

/// The largest number of operations of second derivatives. Longer code would take a C compiler
/// minutes. The number depends on all zeros, so it is known from the graph alone; but no graph
/// grows far beyond it.
const MAX_OPERATIONS: usize = 250_000;

/// A function that `CasADi` loads.
pub struct CasadiFunction {
    /// The beginning of the name of a derivative, such as `jac_`; empty for the function itself.
    pub derivative: &'static str,
    /// The name of the function, without the robot's.
    pub name: String,
    /// The documentation, in lines; `None` for a derivative.
    pub docs: Option<&'static str>,
    /// The inputs.
    pub inputs: Vec<CasadiMatrix>,
    /// The results.
    pub outputs: Vec<CasadiMatrix>,
    /// The program, from the nonzeros of all inputs to the nonzeros of all results.
    pub program: Program,
}

impl CasadiFunction {
    /// Returns the name in a text whose functions have this prefix.
    #[must_use]
    pub fn full_name(&self, prefix: &str) -> String {
        format!("{}{prefix}_{}", self.derivative, self.name)
    }
}

/// The functions of a robot that `CasADi` loads.
#[derive(Default)]
pub struct CasadiPlan {
    /// The functions, each followed by its derivatives.
    pub functions: Vec<CasadiFunction>,
    /// The functions without second derivatives, whose code would be too long.
    pub without_hessian: Vec<String>,
}

impl CasadiPlan {
    /// Returns the functions of `model` among the selected ones.
    pub(super) fn new(
        context: &PlanContext<'_>,
        model: &Model,
        selected: &[Function],
        budget: &mut Budget,
    ) -> Result<Self, TooLong> {
        let tracer = &context.tracer;
        let link_names: Vec<&str> = model.links().iter().map(|link| link.name.as_str()).collect();
        let links = names::fields(&link_names, &[]);
        let mut plan = Self::default();
        let has_form =
            |f: &&Function| f.row().casadi && f.fits(&context.sizes) && selected.contains(f);
        for function in Function::ALL.iter().filter(has_form) {
            let row = function.row();
            let family = Family::new(*function, context);
            let name = function.name();
            let docs = docs_of(*function);
            let least = context.least_operations(*function);
            let before = plan.operations();
            let add = || match row.by_link {
                true => {
                    for (link, link_name) in links.iter().enumerate() {
                        let evaluation =
                            |tracer: &Tracer<'_>| context.evaluation(*function, tracer);
                        let graph = optimize(context.frames.of_link(link, evaluation));
                        let name = format!("{name}_{link_name}");
                        let derivatives = family.differentiated(tracer, &graph, MAX_OPERATIONS);
                        plan.add(&name, docs, &family, derivatives);
                    }
                }
                false => {
                    let graph = || packing::on_scalars(*function, context);
                    let derivatives = match function {
                        Function::ForwardDynamics => tracer.forward_dynamics_by_entries(
                            &graph(),
                            &context.for_derivatives,
                            MAX_OPERATIONS,
                        ),
                        Function::InverseDynamics => {
                            tracer.inverse_dynamics_by_entries(MAX_OPERATIONS)
                        }
                        _ => family.differentiated(tracer, &graph(), MAX_OPERATIONS),
                    };
                    plan.add(name, docs, &family, derivatives);
                }
            };
            budget.spend(name, least, add, |()| 0)?;
            let added = plan.operations() - before;
            budget.spend(name, added, || (), |()| added)?;
        }
        Ok(plan)
    }

    /// Returns the operations of all functions.
    fn operations(&self) -> usize {
        self.functions.iter().map(|function| function.program.static_operations().total()).sum()
    }

    /// Adds a function and its derivatives.
    fn add(
        &mut self,
        name: &str,
        docs: &'static str,
        family: &Family,
        derivatives: EntryDerivatives,
    ) {
        let (first, second) = family.members(derivatives);
        let second = second.filter(|member| !member.graph.takes_more_than(MAX_OPERATIONS));
        if second.is_none() {
            self.without_hessian.push(name.into());
        }
        for Member { prefix, inputs, outputs, graph } in first.into_iter().chain(second) {
            let graph = packing::balanced(optimize(graph));
            let scalars = inputs.iter().map(CasadiMatrix::len).sum();
            self.functions.push(CasadiFunction {
                derivative: prefix,
                name: name.into(),
                docs: prefix.is_empty().then_some(docs),
                inputs,
                outputs,
                program: Program::new(&graph, scalars, Execution::Scalar),
            });
        }
    }
}
