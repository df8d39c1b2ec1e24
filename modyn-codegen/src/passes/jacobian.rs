//! Matrices of derivatives, from the products of [`differentiate`](super::differentiate).

use std::ops::Range;

use super::{jvp, vjp};
use crate::graph::{Graph, Node};

/// Returns the graph of the derivatives of the outputs of `graph` with respect to the inputs `wrt`:
/// a matrix with a row for each output, by columns.
///
/// Forward mode gives a column at a time, reverse mode a row at a time. The mode with fewer
/// operations is taken.
#[must_use]
pub fn jacobian(graph: &Graph, inputs: usize, wrt: Range<usize>) -> Graph {
    let rows = graph.outputs.len();
    let columns = wrt.len();
    matrix(&jvp(graph, inputs, wrt.clone()), &vjp(graph, inputs, wrt), inputs, rows, columns)
}

/// Returns the graph of a matrix by columns. `times_vector` is the graph of its product with a
/// vector, and `vector_times` the graph of the product of a vector and the matrix; the vector is
/// further inputs, after the `inputs` inputs of the matrix. One of the two graphs gives the matrix
/// at unit vectors: that with fewer operations.
#[must_use]
pub fn matrix(
    times_vector: &Graph,
    vector_times: &Graph,
    inputs: usize,
    rows: usize,
    columns: usize,
) -> Graph {
    let by_columns = at_unit_vectors(times_vector, inputs, columns);
    let mut by_rows = at_unit_vectors(vector_times, inputs, rows);
    by_rows.outputs =
        (0..rows * columns).map(|k| by_rows.outputs[k % rows * columns + k / rows]).collect();
    let operations = |graph: &Graph| graph.count().total();
    if operations(&by_rows) < operations(&by_columns) { by_rows } else { by_columns }
}

/// Returns the graph of the derivatives of `gradient` with respect to its first inputs, one for
/// each output: a symmetric matrix by columns, since `gradient` must be the gradient of a function
/// of these inputs. Only half of the matrix is computed. Returns `None` if it takes more than
/// `max_operations`, as soon as some columns do.
#[must_use]
pub fn hessian(gradient: &Graph, inputs: usize, max_operations: usize) -> Option<Graph> {
    let size = gradient.outputs.len();
    let alone: Vec<Range<usize>> = (0..size).map(|entry| entry..entry + 1).collect();
    symmetric_matrix(jvp(gradient, inputs, 0..size), inputs, &alone, max_operations)
}

/// Returns the graph of a matrix by columns, the symmetric part of the matrix whose product with a
/// vector is the graph `times_vector`; the vector is further inputs, after the `inputs` inputs of
/// the matrix. Entries (i, j) and (j, i) are equal, unless i is in the group `groups[j]`: the lower
/// half is computed, and the groups as a whole. Returns `None` if it takes more than
/// `max_operations`, as soon as some columns do.
#[must_use]
pub fn symmetric_matrix(
    mut times_vector: Graph,
    inputs: usize,
    groups: &[Range<usize>],
    max_operations: usize,
) -> Option<Graph> {
    let size = groups.len();
    let products = std::mem::take(&mut times_vector.outputs);
    let mut all = Graph::default();
    let given = all.inputs(0..inputs);
    let mut matrix = vec![0; size * size];
    for (column, group) in groups.iter().enumerate() {
        times_vector.outputs = products[group.start..].to_vec();
        let unit = all.unit_vector(size, column);
        let ids = all.compose(&times_vector, &[&*given, &unit].concat());
        for (row, id) in (group.start..).zip(ids) {
            // The entries above the diagonal, which earlier columns of the group have computed
            // below it.
            let id = if row < column {
                let sum = all.make(Node::Add(matrix[row * size + column], id));
                let half = all.constant(0.5);
                all.make(Node::Mul(half, sum))
            } else {
                id
            };
            matrix[column * size + row] = id;
            matrix[row * size + column] = id;
        }
        all.outputs.extend(&matrix[column * size..][..size]);
        if all.takes_more_than(max_operations) {
            return None;
        }
    }
    all.outputs = matrix;
    Some(all)
}

/// Returns the graph of the outputs of `linear` at each unit vector of its last `count` inputs, one
/// after the other.
fn at_unit_vectors(linear: &Graph, inputs: usize, count: usize) -> Graph {
    let mut all = Graph::default();
    let given = all.inputs(0..inputs);
    let mut outputs = Vec::with_capacity(count * linear.outputs.len());
    for k in 0..count {
        let unit = all.unit_vector(count, k);
        outputs.extend(all.compose(linear, &[&*given, &unit].concat()));
    }
    all.outputs = outputs;
    all
}
