//! The functions that `CasADi` loads: each function of a robot with its derivatives, over the nonzeros of sparse matrices.
//!
//! `CasADi` finds derivatives by their names. For a function `f`, they are its Jacobian `jac_f`, products with it `fwd1_f` and
//! `adj1_f`, and the Jacobian of the latter `jac_adj1_f`, which has the second derivatives of a weighted sum of the results.

use modyn_runtime::model::{Model, ModuleTree};

use super::choices::Choices;
use super::functions::{Argument, Function, Row, Trace};
use super::packing;
use super::shape::{Record, Shape};
use super::strategy::Strategy;
use super::tracing::{TracedRobot, Tracing};
use crate::graph::{Graph, Id};
use crate::names;
use crate::passes::optimize;
use crate::program::{Program, Target};
use crate::trace::{EntryDerivatives, Tracer};

/// The functions in `CasADi`'s form, with the names of their results.
///
/// Functions of derivatives are not among them, since `CasADi` has the derivatives of the functions themselves; nor are
/// functions whose results are no matrices of numbers of one state.
const FUNCTIONS: &[(Function, &[&str])] = &[
    (Function::ForwardDynamics, &["qdd"]),
    (Function::InverseDynamics, &["tau"]),
    (Function::BiasForces, &["tau"]),
    (Function::GravityTorques, &["tau"]),
    (Function::MassMatrix, &["mass_matrix"]),
    (Function::CoriolisMatrix, &["coriolis_matrix"]),
    (Function::KineticEnergy, &["energy"]),
    (Function::PotentialEnergy, &["energy"]),
    (Function::ForwardDynamicsExternal, &["qdd"]),
    (Function::ForwardDynamicsExternalWorld, &["qdd"]),
    (Function::InverseDynamicsExternal, &["tau"]),
    (Function::InverseDynamicsExternalWorld, &["tau"]),
    (Function::StepSemiImplicit, &["q_next", "qd_next"]),
    (Function::StepRk4, &["q_next", "qd_next"]),
    (Function::CenterOfMass, &["position"]),
    (Function::CenterOfMassJacobian, &["jacobian"]),
    (Function::CentroidalMomentumMatrix, &["momentum_matrix"]),
    (Function::CentroidalMomentum, &["momentum"]),
    (Function::LinkPose, &["rotation", "translation"]),
    (Function::LinkVelocity, &["velocity"]),
    (Function::LocalLinkVelocity, &["velocity"]),
    (Function::LinkAcceleration, &["acceleration"]),
    (Function::LocalLinkAcceleration, &["acceleration"]),
    (Function::Jacobian, &["jacobian"]),
    (Function::LocalJacobian, &["jacobian"]),
    (Function::BiasAcceleration, &["acceleration"]),
    (Function::LocalBiasAcceleration, &["acceleration"]),
    (Function::Integrate, &["q_next"]),
    (Function::Difference, &["displacement"]),
    (Function::VelocityToQdot, &["qdot"]),
    (Function::Normalize, &["unit_q"]),
];

/// The largest number of operations of second derivatives. Longer code would take a C compiler minutes.
const MAX_OPERATIONS: usize = 250_000;

/// A matrix of an input or a result: its size, and the entries that are not zero by structure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CasadiMatrix {
    /// The name.
    pub name: String,
    /// The number of rows.
    pub rows: usize,
    /// The number of columns.
    pub columns: usize,
    /// For each column, the rows of its nonzeros, in order.
    pub nonzeros: Vec<Vec<usize>>,
}

impl CasadiMatrix {
    fn dense(name: &str, rows: usize, columns: usize) -> Self {
        let nonzeros = vec![(0..rows).collect(); columns];
        Self { name: name.into(), rows, columns, nonzeros }
    }

    /// Returns a matrix of this size without nonzeros.
    fn empty(&self, name: String) -> Self {
        let nonzeros = vec![Vec::new(); self.columns];
        Self { name, nonzeros, ..*self }
    }

    fn renamed(&self, name: String) -> Self {
        Self { name, ..self.clone() }
    }

    /// Returns the number of entries, zeros included.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.rows * self.columns
    }

    /// Returns the number of nonzeros.
    #[must_use]
    pub fn len(&self) -> usize {
        self.nonzeros.iter().map(Vec::len).sum()
    }

    /// Returns whether there are no nonzeros.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns, for each nonzero, the index among all entries, by columns.
    fn places(&self) -> impl Iterator<Item = usize> {
        let column = |(column, rows): (usize, &Vec<usize>)| {
            rows.iter().map(|row| column * self.rows + row).collect::<Vec<usize>>()
        };
        self.nonzeros.iter().enumerate().flat_map(column)
    }

    /// Returns the pattern in compressed columns, as `CasADi` reads it: the number of rows and of columns; then the number of
    /// nonzeros before each column and in all, and the row of each nonzero. For a matrix without zeros, 1 in place of these.
    #[must_use]
    pub fn compressed_columns(&self) -> Vec<usize> {
        let mut numbers = vec![self.rows, self.columns];
        if self.len() == self.entries() {
            return [numbers, vec![1]].concat();
        }
        let mut before = 0;
        numbers.push(before);
        for rows in &self.nonzeros {
            before += rows.len();
            numbers.push(before);
        }
        numbers.extend(self.nonzeros.iter().flatten());
        numbers
    }
}

/// A function that `CasADi` loads.
pub struct CasadiFunction {
    /// The name.
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

/// The functions of a robot that `CasADi` loads.
pub struct CasadiPlan {
    /// The functions, each followed by its derivatives.
    pub functions: Vec<CasadiFunction>,
    /// The functions without second derivatives, whose code would be too long.
    pub without_hessian: Vec<String>,
}

impl Function {
    /// Returns whether the function has a form for `CasADi`.
    #[must_use]
    pub fn is_for_casadi(self) -> bool {
        FUNCTIONS.iter().any(|(function, _)| *function == self)
    }
}

impl CasadiPlan {
    /// Returns the functions of `model`, whose names begin with `prefix`; `modules` is the user's partition.
    #[must_use]
    pub fn new(model: &Model, modules: &ModuleTree, choices: &Choices, prefix: &str) -> Self {
        let robot = TracedRobot::new(model, choices.parameters(model));
        let tracing = Tracing::new(&robot, (model, modules), Strategy::Scalar, Vec::new());
        let tracer = &tracing.tracer;
        let links: Vec<&str> = model.frames().iter().map(|frame| frame.name.as_str()).collect();
        let links = names::fields(&links, &[]);
        let mut plan = Self { functions: Vec::new(), without_hessian: Vec::new() };
        for (function, results) in FUNCTIONS {
            if !choices.functions.contains(function) {
                continue;
            }
            let row = function.row();
            let own = Family::new(&row, results, &tracing);
            let name = format!("{prefix}_{}", function.name());
            match row.trace {
                Trace::ByLink(trace) => {
                    for (link, link_name) in links.iter().enumerate() {
                        let graph = optimize(tracing.frames.of_link(link, trace));
                        let name = format!("{name}_{link_name}");
                        plan.add(&name, row.docs, &own, own.differentiated(tracer, &graph));
                    }
                }
                Trace::One(trace) => {
                    let derivatives = match function {
                        Function::ForwardDynamics => tracer.forward_dynamics_by_entries(
                            &tracing.forward_dynamics.graph,
                            &tracing.for_derivatives,
                        ),
                        Function::InverseDynamics => tracer.inverse_dynamics_by_entries(),
                        _ => own.differentiated(tracer, &optimize(trace(tracer, &tracing))),
                    };
                    plan.add(&name, row.docs, &own, derivatives);
                }
                Trace::Poses => unreachable!("the poses of all links have no form for CasADi"),
            }
        }
        plan
    }

    /// Adds a function and its derivatives.
    fn add(
        &mut self,
        name: &str,
        docs: &'static str,
        family: &Family,
        derivatives: EntryDerivatives,
    ) {
        let Family { inputs, results } = family;
        let EntryDerivatives { value, jacobian, forward, adjoint, hessian } = derivatives;
        // The results, from arrays by rows or by columns to columns, without zeros.
        let order: Vec<usize> = results.iter().flat_map(|result| result.order.clone()).collect();
        let is_zero = |k: usize| value.value(value.outputs[k]) == Some(0.0);
        let kept: Vec<usize> = order.iter().copied().filter(|&k| !is_zero(k)).collect();
        let outputs: Vec<CasadiMatrix> =
            results.iter().map(|result| result.matrix(|k| !is_zero(k))).collect();
        let all = value.outputs.len();
        let columns: usize = inputs.iter().map(CasadiMatrix::entries).sum();
        let weights = |graph: &Graph| weighted(graph, columns, &kept, all);

        let value = with_outputs(value, |given| kept.iter().map(|&k| given[k]).collect());
        let forward = with_outputs(forward, |given| kept.iter().map(|&k| given[k]).collect());
        let jacobian = with_outputs(jacobian, |given| {
            (0..columns).flat_map(|x| kept.iter().map(move |&k| given[x * all + k])).collect()
        });
        let (adjoint, hessian) = (weights(&adjoint), weights(&hessian));

        let like = |prefix: &str, matrices: &[CasadiMatrix]| -> Vec<CasadiMatrix> {
            matrices.iter().map(|m| m.renamed(format!("{prefix}{}", m.name))).collect()
        };
        let empty = |prefix: &str, matrices: &[CasadiMatrix]| -> Vec<CasadiMatrix> {
            matrices.iter().map(|m| m.empty(format!("{prefix}{}", m.name))).collect()
        };
        let given = [&inputs[..], &empty("out_", &outputs)].concat();

        // The derivatives of all nonzeros of the results are a matrix; so are those of the gradient.
        let (sparse, blocks) = matrix_blocks(jacobian.clone(), "jac_", &outputs, inputs);
        let gradient = like("adj_", inputs);
        let seeds = like("adj_", &outputs);
        let of_adjoint = [&given[..], &seeds].concat();
        let second = second_derivatives(&hessian, &jacobian, columns, kept.len());
        let (second, second_blocks) = matrix_blocks(second, "jac_", &gradient, &of_adjoint);
        let of_second = [&of_adjoint[..], &empty("out_", &gradient)].concat();

        let members = [
            (String::new(), inputs.clone(), outputs.clone(), value),
            ("jac_".into(), given.clone(), blocks, sparse),
            (
                "fwd1_".into(),
                [&given[..], &like("fwd_", inputs)].concat(),
                like("fwd_", &outputs),
                forward,
            ),
            ("adj1_".into(), of_adjoint, gradient, adjoint),
            ("jac_adj1_".into(), of_second, second_blocks, second),
        ];
        for (prefix, inputs, outputs, graph) in members {
            if graph.count().total() > MAX_OPERATIONS && prefix == "jac_adj1_" {
                self.without_hessian.push(name.into());
                continue;
            }
            let graph = packing::balanced(optimize(graph));
            let scalars = inputs.iter().map(CasadiMatrix::len).sum();
            self.functions.push(CasadiFunction {
                docs: prefix.is_empty().then_some(docs),
                name: prefix + name,
                inputs,
                outputs,
                program: Program::new(&graph, scalars, Target::Scalar),
            });
        }
    }
}

/// The inputs and results that a function and its derivatives have in common.
struct Family {
    inputs: Vec<CasadiMatrix>,
    results: Vec<ResultMatrix>,
}

/// A result, as a matrix.
struct ResultMatrix {
    name: &'static str,
    rows: usize,
    columns: usize,
    /// For each entry by columns, the index among the function's results.
    order: Vec<usize>,
}

impl ResultMatrix {
    /// Returns the matrix whose nonzeros are the results for which `nonzero` holds.
    fn matrix(&self, nonzero: impl Fn(usize) -> bool) -> CasadiMatrix {
        let column = |order: &[usize]| {
            (0..order.len()).filter(|&row| nonzero(order[row])).collect::<Vec<usize>>()
        };
        let nonzeros = self.order.chunks(self.rows).map(column).collect();
        let (rows, columns) = (self.rows, self.columns);
        CasadiMatrix { name: self.name.into(), rows, columns, nonzeros }
    }
}

impl Family {
    fn new(row: &Row, names: &[&'static str], tracing: &Tracing<'_>) -> Self {
        let sizes = &tracing.sizes;
        let input = |argument: &Argument| {
            let (rows, columns) = size_of(&(argument.shape)(sizes));
            CasadiMatrix::dense(argument.name, rows, columns)
        };
        let mut inputs: Vec<CasadiMatrix> = row.arguments.iter().map(input).collect();
        let parameters = tracing.parameters(row.depends_on_parameters);
        if parameters > 0 {
            inputs.push(CasadiMatrix::dense("params", parameters, 1));
        }
        let (mut results, mut first) = (Vec::new(), 0);
        for (shape, name) in fields(&(row.result)(sizes)).iter().zip(names) {
            let (rows, columns) = size_of(shape);
            // A rotation is stored by rows.
            let by_rows = *shape == Shape::matrix(3, 3) && *name == "rotation";
            let entry = |k: usize| if by_rows { k % 3 * 3 + k / 3 } else { k };
            let order = (0..rows * columns).map(|k| first + entry(k)).collect();
            first += rows * columns;
            results.push(ResultMatrix { name, rows, columns, order });
        }
        Self { inputs, results }
    }

    /// Returns the function of this graph and its derivatives, with quaternions scaled to length 1.
    fn differentiated(&self, tracer: &Tracer<'_>, graph: &Graph) -> EntryDerivatives {
        let (mut first, mut coordinates) = (0, Vec::new());
        for input in &self.inputs {
            if matches!(&*input.name, "q" | "from" | "to") {
                coordinates.push(first);
            }
            first += input.entries();
        }
        let graph = tracer.with_unit_quaternions(graph, &coordinates, first);
        EntryDerivatives::new(graph, first)
    }
}

/// Returns the matrices that a result consists of.
fn fields(shape: &Shape) -> Vec<Shape> {
    match shape {
        Shape::Record(Record::Several(_) | Record::Each(_) | Record::Spatial("Pose"), fields) => {
            fields.iter().map(|(_, field)| field.clone()).collect()
        }
        _ => vec![shape.clone()],
    }
}

/// Returns the numbers of rows and columns of an array: columns of numbers, or numbers.
fn size_of(shape: &Shape) -> (usize, usize) {
    match shape {
        Shape::Array(column, columns) if **column != Shape::Scalar => (column.len(), *columns),
        _ => (shape.len(), 1),
    }
}

fn with_outputs(mut graph: Graph, outputs: impl Fn(&[Id]) -> Vec<Id>) -> Graph {
    graph.outputs = outputs(&graph.outputs);
    graph
}

/// Returns the graph with weights for the results `kept` alone, of `all`: inputs after the first `inputs` inputs. The other
/// weights are zero.
fn weighted(graph: &Graph, inputs: usize, kept: &[usize], all: usize) -> Graph {
    let mut result = Graph::default();
    let zero = result.constant(0.0);
    let mut given = result.inputs(0..inputs);
    given.resize(inputs + all, zero);
    for (number, &k) in kept.iter().enumerate() {
        given[inputs + k] = result.input(inputs + number);
    }
    let outputs = result.compose(graph, &given);
    result.outputs = outputs;
    result
}

/// Returns the graph of the Jacobian of a gradient by the function's inputs and then by the weights, by columns: the
/// Hessian, then the transposed Jacobian. `columns` is the number of inputs, `rows` the number of results.
fn second_derivatives(hessian: &Graph, jacobian: &Graph, columns: usize, rows: usize) -> Graph {
    let mut all = Graph::default();
    let given = all.inputs(0..columns + rows);
    let mut outputs = all.compose(hessian, &given);
    let first = all.compose(jacobian, &given);
    outputs.extend(
        (0..rows)
            .flat_map(|row| (0..columns).map(move |x| (row, x)))
            .map(|(row, column)| first[column * rows + row]),
    );
    all.outputs = outputs;
    all
}

/// Returns the nonzeros of the blocks of a matrix of derivatives, with the blocks: of each result by each input. The matrix
/// has a row for each nonzero of the results and a column for each nonzero of the inputs. The rows and columns of a block
/// are all entries.
fn matrix_blocks(
    mut graph: Graph,
    prefix: &str,
    results: &[CasadiMatrix],
    inputs: &[CasadiMatrix],
) -> (Graph, Vec<CasadiMatrix>) {
    let rows: usize = results.iter().map(CasadiMatrix::len).sum();
    let (mut outputs, mut blocks) = (Vec::new(), Vec::new());
    let mut first_row = 0;
    for result in results {
        let mut column = 0;
        for input in inputs {
            let mut nonzeros = vec![Vec::new(); input.entries()];
            for place in input.places() {
                for (row, entry) in result.places().enumerate() {
                    let id = graph.outputs[column * rows + first_row + row];
                    if graph.value(id) != Some(0.0) {
                        nonzeros[place].push(entry);
                        outputs.push(id);
                    }
                }
                column += 1;
            }
            blocks.push(CasadiMatrix {
                name: format!("{prefix}{}_{}", result.name, input.name),
                rows: result.entries(),
                columns: input.entries(),
                nonzeros,
            });
        }
        first_row += result.len();
    }
    graph.outputs = outputs;
    (graph, blocks)
}

#[cfg(test)]
mod tests {
    use super::{CasadiMatrix, FUNCTIONS, Shape, Trace, fields};
    use crate::plan::Sizes;

    /// `CasADi` refuses a function in which an input and a result have the same name.
    #[test]
    fn every_result_has_a_name_of_its_own() {
        let sizes = Sizes { nq: 7, nv: 6, links: 3, moving: 2, ..Sizes::default() };
        for (function, names) in FUNCTIONS {
            let row = function.row();
            assert!(!matches!(row.trace, Trace::Poses) && row.batch_of.is_none(), "{function:?}");
            assert_eq!(fields(&(row.result)(&sizes)).len(), names.len(), "{function:?}");
            let arguments = row.arguments.iter().map(|argument| argument.name);
            let all: Vec<&str> = arguments.chain(names.iter().copied()).collect();
            let mut different = all.clone();
            different.sort_unstable();
            different.dedup();
            assert_eq!(different.len(), all.len(), "{function:?}: {all:?}");
        }
        assert_eq!(fields(&Shape::pose()).len(), 2);
    }

    #[test]
    fn patterns_are_compressed_columns() {
        let of = |rows, nonzeros: &[&[usize]]| CasadiMatrix {
            name: "a".into(),
            rows,
            columns: nonzeros.len(),
            nonzeros: nonzeros.iter().map(|rows| rows.to_vec()).collect(),
        };
        // A matrix with an empty column, a dense one, and one without nonzeros.
        let some = of(3, &[&[0, 2], &[], &[1]]).compressed_columns();
        assert_eq!(some, [3, 3, 0, 2, 2, 3, 0, 2, 1]);
        assert_eq!(of(2, &[&[0, 1]]).compressed_columns(), [2, 1, 1]);
        assert_eq!(of(2, &[&[], &[]]).compressed_columns(), [2, 2, 0, 0, 0]);
    }
}
