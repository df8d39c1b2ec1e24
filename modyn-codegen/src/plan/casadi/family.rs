//! A function with its derivatives, over the nonzeros of their inputs and results.

use super::matrix::CasadiMatrix;
use super::nonzeros::{matrix_blocks, weighted, with_outputs};
use crate::graph::Graph;
use crate::plan::context::PlanContext;
use crate::plan::{ArgumentKind, Elements, Function, Record, Shape, Sizes};
use crate::trace::{EntryDerivatives, Tracer, second_derivatives};

/// The inputs and results that a function and its derivatives have in common.
pub(super) struct Family {
    inputs: Vec<CasadiMatrix>,
    /// The entry of all inputs at which each argument of coordinates begins.
    coordinates: Vec<usize>,
    results: Vec<ResultMatrix>,
}

/// A function of a family.
pub(super) struct Member {
    /// The start of its name, before the name of the function that is differentiated.
    pub prefix: &'static str,
    pub inputs: Vec<CasadiMatrix>,
    pub outputs: Vec<CasadiMatrix>,
    /// The graph, from the nonzeros of all inputs to the nonzeros of all results.
    pub graph: Graph,
}

/// A result, as a matrix.
struct ResultMatrix {
    name: String,
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
        // A matrix without rows has columns, too.
        let nonzeros = match self.rows {
            0 => vec![Vec::new(); self.columns],
            rows => self.order.chunks(rows).map(column).collect(),
        };
        let rows = self.rows;
        let columns = self.columns;
        CasadiMatrix { name: self.name.clone(), rows, columns, nonzeros }
    }
}

impl Family {
    /// Returns the family of a function of the table.
    pub fn new(function: Function, context: &PlanContext<'_>) -> Self {
        let row = function.row();
        let sizes = &context.sizes;
        let mut inputs = Vec::new();
        let mut coordinates = Vec::new();
        let mut entries = 0;
        for argument in row.arguments {
            let (rows, columns) = size_of(&argument.shape(sizes));
            if argument.kind == ArgumentKind::Coordinates {
                coordinates.push(entries);
            }
            entries += rows * columns;
            inputs.push(CasadiMatrix::dense(argument.name, rows, columns));
        }
        let parameters = context.parameters(row.depends_on_parameters);
        if parameters > 0 {
            inputs.push(CasadiMatrix::dense("params", parameters, 1));
        }
        let mut matrices = Vec::new();
        let mut first = 0;
        for (name, shape) in results(function, sizes) {
            let (rows, columns) = size_of(&shape);
            let by_rows = matches!(shape, Shape::Array(_, _, Elements::Rows));
            let entry = |k: usize| if by_rows { k % rows * columns + k / rows } else { k };
            let order = (0..rows * columns).map(|k| first + entry(k)).collect();
            first += rows * columns;
            matrices.push(ResultMatrix { name, rows, columns, order });
        }
        Self { inputs, coordinates, results: matrices }
    }

    /// Returns the function of this graph and its derivatives, with quaternions scaled to length 1.
    /// Second derivatives of more than `max_operations` operations are left out.
    pub fn differentiated(
        &self,
        tracer: &Tracer<'_>,
        graph: &Graph,
        max_operations: usize,
    ) -> EntryDerivatives {
        let entries = self.inputs.iter().map(CasadiMatrix::entries).sum();
        let graph = tracer.with_unit_quaternions(graph, &self.coordinates, entries);
        EntryDerivatives::new(graph, entries, max_operations)
    }

    /// Returns the function and its first derivatives, and the function of second derivatives
    /// unless these were left out.
    pub fn members(&self, derivatives: EntryDerivatives) -> ([Member; 4], Option<Member>) {
        let Self { inputs, results, .. } = self;
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

        // CasADi gives the results to derivatives as well, which do not depend on them.
        let given = [&inputs[..], &empty("out_", &outputs)].concat();
        let gradient = renamed("adj_", inputs);
        let seeds = renamed("adj_", &outputs);
        let of_adjoint = [&given[..], &seeds].concat();
        // The second derivatives of all nonzeros of the gradient are a matrix, as the derivatives
        // of the results are.
        let second = hessian.map(|hessian| {
            let second = second_derivatives(&weights(&hessian), &jacobian, columns, kept.len());
            let (graph, outputs) = matrix_blocks(second, "jac_", &gradient, &of_adjoint);
            let inputs = [&of_adjoint[..], &empty("out_", &gradient)].concat();
            Member { prefix: "jac_adj1_", inputs, outputs, graph }
        });
        let (jacobian, blocks) = matrix_blocks(jacobian, "jac_", &outputs, inputs);
        let changes = [&given[..], &renamed("fwd_", inputs)].concat();
        let changed = renamed("fwd_", &outputs);
        let first = [
            Member { prefix: "", inputs: inputs.clone(), outputs, graph: value },
            Member { prefix: "jac_", inputs: given, outputs: blocks, graph: jacobian },
            Member { prefix: "fwd1_", inputs: changes, outputs: changed, graph: forward },
            Member {
                prefix: "adj1_",
                inputs: of_adjoint,
                outputs: gradient,
                graph: weights(&adjoint),
            },
        ];
        (first, second)
    }
}

/// Returns the matrices, with names that begin with `prefix`.
fn renamed(prefix: &str, matrices: &[CasadiMatrix]) -> Vec<CasadiMatrix> {
    matrices.iter().map(|matrix| matrix.renamed(format!("{prefix}{}", matrix.name))).collect()
}

/// Returns matrices of the same sizes without nonzeros, with names that begin with `prefix`.
fn empty(prefix: &str, matrices: &[CasadiMatrix]) -> Vec<CasadiMatrix> {
    matrices.iter().map(|matrix| matrix.empty(format!("{prefix}{}", matrix.name))).collect()
}

/// Returns the matrices that a function's result consists of, with their names. `CasADi` refuses a
/// result with the name of an input, so the fields of the resulting state are named for the next
/// state.
pub fn results(function: Function, sizes: &Sizes) -> Vec<(String, Shape)> {
    let row = function.row();
    match (row.result)(sizes) {
        Shape::Record(
            Record::ResultsByType(_) | Record::ResultsByField(_) | Record::Pose,
            fields,
        ) => {
            let name = |name: &str| match row.arguments.iter().any(|argument| argument.name == name)
            {
                true => format!("{name}_next"),
                false => name.to_string(),
            };
            fields.into_iter().map(|(field, shape)| (name(field), shape)).collect()
        }
        shape => vec![(function.result_name().into(), shape)],
    }
}

/// Returns the numbers of rows and columns of an array: lists and matrices of vectors, or numbers.
fn size_of(shape: &Shape) -> (usize, usize) {
    match shape {
        Shape::Array(row, rows, Elements::Rows) => (*rows, row.len()),
        Shape::Array(column, columns, _) if **column != Shape::Scalar => (column.len(), *columns),
        _ => (shape.len(), 1),
    }
}
