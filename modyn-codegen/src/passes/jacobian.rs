//! Matrices of derivatives, from the products of [`differentiate`](super::differentiate).

use std::ops::Range;

use super::{jvp, vjp};
use crate::graph::Graph;

/// Returns the graph of the derivatives of the outputs of `graph` with respect to the inputs `wrt`: a matrix with a row for
/// each output, by columns.
///
/// Forward mode gives a column at a time, reverse mode a row at a time. The mode with fewer operations is taken.
#[must_use]
pub fn jacobian(graph: &Graph, inputs: usize, wrt: Range<usize>) -> Graph {
    let (rows, columns) = (graph.outputs.len(), wrt.len());
    let by_columns = at_unit_vectors(&jvp(graph, inputs, wrt.clone()), inputs, columns);
    let mut by_rows = at_unit_vectors(&vjp(graph, inputs, wrt), inputs, rows);
    by_rows.outputs =
        (0..rows * columns).map(|k| by_rows.outputs[k % rows * columns + k / rows]).collect();
    let operations = |graph: &Graph| graph.count().total();
    if operations(&by_rows) < operations(&by_columns) { by_rows } else { by_columns }
}

/// Returns the graph of the derivatives of `gradient` with respect to its first inputs, one for each output: a symmetric
/// matrix by columns, since `gradient` must be the gradient of a function of these inputs. Only half of the matrix is
/// computed. Returns `None` if it takes more than `max_operations`, as soon as some columns do.
#[must_use]
pub fn hessian(gradient: &Graph, inputs: usize, max_operations: usize) -> Option<Graph> {
    let size = gradient.outputs.len();
    let mut change = jvp(gradient, inputs, 0..size);
    let changes = std::mem::take(&mut change.outputs);
    let mut all = Graph::default();
    let given = all.inputs(0..inputs);
    let mut matrix = vec![0; size * size];
    for column in 0..size {
        change.outputs = changes[column..].to_vec();
        let unit = all.unit_vector(size, column);
        let ids = all.compose(&change, &[&*given, &unit].concat());
        for (row, id) in (column..).zip(ids) {
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

/// Returns the graph of the outputs of `linear` at each unit vector of its last `count` inputs, one after the other.
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
