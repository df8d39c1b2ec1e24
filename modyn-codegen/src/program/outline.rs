//! Cuts statements into chunks, which become functions, and chunks into scopes.
//!
//! Compilers take more than linear time for long functions, and rustc with debug information has
//! crashed on thousands of `let`s in one scope. A chunk returns the values that later chunks need,
//! and these read the values from its result. Chunks that copied values in order to pass them on
//! would double the work of a long function.
//!
//! Scopes have at most 250 statements; chunks 500 to 800.

use std::collections::BTreeSet;
use std::ops::Range;

use super::{Chunk, Execution, Program, Scope, Value};

/// The largest number of statements in one scope.
const MAX_SCOPE: usize = 250;

/// The lengths of functions, in statements.
struct Limits {
    /// A program up to this length stays one chunk.
    whole: usize,
    /// The largest number of statements in a chunk of a longer program.
    chunk: usize,
}

/// For many states. The compiler initially keeps lanes in memory, and takes more than linear time.
const BATCH: Limits = Limits { whole: 500, chunk: 500 };

/// For one state on scalars. Short chunks fit registers better, and take less compile time.
const SCALAR: Limits = Limits { whole: 1500, chunk: 500 };

/// For one state with vectors. A humanoid's forward dynamics (1,600 statements) as one function
/// takes a fifth less time with 32 registers, the same time with 16 registers, and a tenth more
/// compile time. Its derivatives would gain as much, but take rustc twice as long. Chunks of 800
/// are as fast as any longer chunks.
const PACKED: Limits = Limits { whole: 3000, chunk: 800 };

/// In a thread of a graphics processor: values that cross a cut go through memory, and compilers
/// take a function of 5,000 statements well. A longer program spills its registers in any case. In
/// chunks of 700, a gradient of a quadruped's step spills a ninth of what it spills in chunks of
/// 2,500, accesses local memory less often, and compiles sooner.
const THREAD: Limits = Limits { whole: 5000, chunk: 700 };

/// Returns the statements of a program in chunks of about equal length.
pub(super) fn chunks(program: &Program) -> Vec<Chunk> {
    let count = program.statements.len();
    let Limits { whole, chunk } = match program.execution {
        Execution::Batch => BATCH,
        Execution::Threads => THREAD,
        Execution::Simd if program.widths().len() > 1 => PACKED,
        Execution::Scalar | Execution::Simd => SCALAR,
    };
    let chunks = if count <= whole { 1 } else { count.div_ceil(chunk) };
    let ranges: Vec<Range<usize>> =
        (0..chunks).map(|k| k * count / chunks..(k + 1) * count / chunks).collect();
    let chunk = |statements: &Range<usize>| {
        let read = statements.clone().flat_map(|s| program.reads(s));
        let earlier = read.filter(|&s| s < statements.start);
        let chunks = earlier.filter_map(|s| ranges.iter().position(|range| range.contains(&s)));
        Chunk {
            statements: statements.clone(),
            live_in: chunks.collect::<BTreeSet<usize>>().into_iter().collect(),
            live_out: live_out(program, statements),
            scopes: scopes(program, statements),
        }
    };
    ranges.iter().map(chunk).collect()
}

/// Returns the scopes of a chunk, each of maximal length.
fn scopes(program: &Program, chunk: &Range<usize>) -> Vec<Scope> {
    chunk
        .clone()
        .step_by(MAX_SCOPE)
        .map(|start| {
            let statements = start..(start + MAX_SCOPE).min(chunk.end);
            Scope { live_out: live_out(program, &statements), statements }
        })
        .collect()
}

/// Returns the values that these statements compute and later statements read.
fn live_out(program: &Program, range: &Range<usize>) -> Vec<Value> {
    let statements = range.clone().filter(|&s| program.statements[s].last_use >= range.end);
    let mut values: Vec<Value> = statements
        .flat_map(|statement| {
            let used = program.statements[statement].used.iter().enumerate();
            used.filter(|(_, used)| **used).map(move |(place, _)| Value { statement, place })
        })
        .collect();
    values.sort_by_key(|value| (program.statements[value.statement].lanes, *value));
    values
}
