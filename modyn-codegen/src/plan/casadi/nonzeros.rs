//! Graphs over nonzeros alone: of results, of weights, and of matrices of derivatives.

use super::matrix::CasadiMatrix;
use crate::graph::{Graph, Id};

/// Returns the graph with these of its outputs.
pub(super) fn with_outputs(mut graph: Graph, outputs: impl Fn(&[Id]) -> Vec<Id>) -> Graph {
    graph.outputs = outputs(&graph.outputs);
    graph
}

/// Returns the graph with weights for the results `kept` alone, of `all`: inputs after the first
/// `inputs` inputs. The other weights are zero.
pub(super) fn weighted(graph: &Graph, inputs: usize, kept: &[usize], all: usize) -> Graph {
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

/// Returns the nonzeros of the blocks of a matrix of derivatives, with the blocks: of each result
/// by each input. The matrix has a row for each nonzero of the results and a column for each
/// nonzero of the inputs. The rows and columns of a block are all entries.
pub(super) fn matrix_blocks(
    mut graph: Graph,
    prefix: &str,
    results: &[CasadiMatrix],
    inputs: &[CasadiMatrix],
) -> (Graph, Vec<CasadiMatrix>) {
    let rows: usize = results.iter().map(CasadiMatrix::len).sum();
    let mut outputs = Vec::new();
    let mut blocks = Vec::new();
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
