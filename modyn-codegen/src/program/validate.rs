//! The rules that every program satisfies, checked once before it is printed.

use std::collections::BTreeSet;

use super::loops::tables_fault;
use super::{Chunk, Execution, Operand, Operation, Program, Source, Value};

/// The rule about operands with other lanes than their operation.
pub(super) const COPIED: &str = "only scalars are copied to lanes";

/// A violation of a rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InvalidProgram {
    /// The statement that breaks the rule; `None` for the program as a whole.
    pub statement: Option<usize>,
    /// The rule.
    pub rule: &'static str,
}

impl Program {
    /// Checks that operands are computed before they are read, that lanes fit, that chunks and
    /// scopes cover all statements, and that every value that crosses a cut is declared there.
    ///
    /// # Errors
    ///
    /// Returns the first violation.
    pub fn validate(&self) -> Result<(), InvalidProgram> {
        for s in 0..self.statements.len() {
            self.statement_fault(s)
                .map_or(Ok(()), |rule| Err(InvalidProgram { statement: Some(s), rule }))?;
        }
        let end = self.statements.len();
        let outputs = || self.all_stored().chain(self.read_last());
        let results = outputs().find_map(|result| self.operand_fault(result, end));
        let scalars = outputs().all(|result| result.lanes == 1);
        let rule = results
            .or((!scalars).then_some("results are scalars"))
            .or_else(|| self.store_fault())
            .or_else(|| self.cut_fault())
            .or_else(|| self.products.as_ref()?.fault(self))
            .or_else(|| tables_fault(self));
        rule.map_or(Ok(()), |rule| Err(InvalidProgram { statement: None, rule }))?;
        self.routines.iter().try_for_each(|routine| routine.program.validate())
    }

    /// Returns the rule that statement `s` breaks.
    fn statement_fault(&self, s: usize) -> Option<&'static str> {
        let statement = &self.statements[s];
        let operands = statement.operation.operands();
        if let Some(rule) = operands.iter().find_map(|operand| self.operand_fault(operand, s)) {
            return Some(rule);
        }
        let lanes = usize::from(statement.lanes);
        let all = |lanes: u8| operands.iter().all(|operand| operand.lanes == lanes);
        let (fits, results) = match &statement.operation {
            Operation::Pack(packed) => (all(1) && packed.len() == lanes, 1),
            Operation::Constants(packed) => (packed.len() == lanes, 1),
            Operation::Unpack(vector) => {
                (lanes == 1 && self.lanes_of(vector.source) > 1, vector.lanes.into())
            }
            Operation::SinCos(angles) => (all(statement.lanes), 2 * angles.len()),
            Operation::Loops(loops) => {
                if let Some(rule) = loops.fault(self) {
                    return Some(rule);
                }
                (lanes == 1 && all(1), loops.results.len())
            }
            Operation::RowEquations(equations) => {
                (lanes == 1 && all(1) && equations.fits(), equations.results())
            }
            _ => (all(statement.lanes), 1),
        };
        if !fits {
            return Some("operands have the lanes of the operation");
        }
        if statement.used.len() != results || !statement.used.contains(&true) {
            return Some("a statement knows which of its results are used, and one is");
        }
        (self.execution != Execution::Simd && statement.lanes != 1)
            .then_some("only programs on vectors have lanes")
    }

    /// Returns the rule that an operand of statement `s` breaks.
    fn operand_fault(&self, operand: &Operand, s: usize) -> Option<&'static str> {
        match operand.source {
            Source::Constant(_) => {}
            Source::Argument(number) if number < self.arguments => {}
            Source::Argument(_) => return Some("arguments are counted"),
            Source::Result(value) => {
                if value.statement >= s {
                    return Some("a value is computed before it is read");
                }
                let read = &self.statements[value.statement];
                if read.used.get(value.place) != Some(&true) {
                    return Some("a result that is read is used");
                }
                if s < self.statements.len() && read.last_use < s {
                    return Some("no statement reads a value after its last use");
                }
            }
        }
        let lanes = self.lanes_of(operand.source);
        (lanes != 1 && lanes != operand.lanes).then_some(COPIED)
    }

    /// Returns the rule that the stores of results break.
    fn store_fault(&self) -> Option<&'static str> {
        let of_statements = self.statements.iter().flat_map(|statement| &statement.stores);
        let mut stored: Vec<usize> = of_statements.chain(&self.first_stores).copied().collect();
        stored.sort_unstable();
        let all = 0..self.all_stored().count();
        (!stored.iter().copied().eq(all)).then_some("each result is stored once")
    }

    /// Returns the rule that chunks or scopes break.
    fn cut_fault(&self) -> Option<&'static str> {
        let covers = |ranges: &[(usize, usize)], (start, end): (usize, usize)| {
            let starts = ranges.iter().map(|range| range.0);
            let ends = [start].into_iter().chain(ranges.iter().map(|range| range.1));
            starts.eq(ends.take(ranges.len())) && ranges.last().map_or(start, |r| r.1) == end
        };
        let chunks: Vec<(usize, usize)> =
            self.chunks.iter().map(|c| (c.statements.start, c.statements.end)).collect();
        if !covers(&chunks, (0, self.statements.len())) {
            return Some("chunks are all statements in their order");
        }
        let values_of = |chunk: &Chunk| chunk.live_out.iter().copied().collect::<BTreeSet<Value>>();
        let live_out: Vec<BTreeSet<Value>> = self.chunks.iter().map(values_of).collect();
        for chunk in &self.chunks {
            let scopes: Vec<(usize, usize)> =
                chunk.scopes.iter().map(|s| (s.statements.start, s.statements.end)).collect();
            if !covers(&scopes, (chunk.statements.start, chunk.statements.end)) {
                return Some("scopes are all statements of their chunk");
            }
            let read = chunk.statements.clone().flat_map(|s| {
                let operands = self.statements[s].operation.operands();
                operands.into_iter().filter_map(|operand| operand.value())
            });
            for value in read.filter(|value| value.statement < chunk.statements.start) {
                let from = self.chunks.iter().position(|c| c.statements.contains(&value.statement));
                let named = from.is_some_and(|from| {
                    chunk.live_in.contains(&from) && live_out[from].contains(&value)
                });
                if !named {
                    return Some("a value that crosses a cut is named there");
                }
            }
        }
        None
    }
}
