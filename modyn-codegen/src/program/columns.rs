//! Functions whose columns are results of calls of one routine, several columns at a time on vectors.

use super::{
    Call, Execution, InvalidProgram, Operand, Operation, Program, Routine, Source, Statement, Value,
};
use crate::trace::{ColumnResult, ColumnsGraph};

impl Program {
    /// Returns the program of a function with columns, over `arguments` scalars. Columns in several lanes need vectors.
    ///
    /// # Errors
    ///
    /// Returns the first violation of a rule.
    pub fn with_columns(
        of: &ColumnsGraph,
        arguments: usize,
        execution: Execution,
    ) -> Result<Self, InvalidProgram> {
        let ColumnsGraph { graph, column, columns, common, results, lanes } = of;
        let lanes = *lanes;
        let mut program = Self::lowered(graph, arguments, execution);
        let outputs = std::mem::take(&mut program.results);
        let own = columns.first().map_or(0, Vec::len);
        let routine = Self::try_new(column, own + common.len(), Execution::Scalar)?;
        if routine.chunks.len() > 1 {
            let rule = "the routine of columns is one function";
            return Err(InvalidProgram { statement: None, rule });
        }
        let common: Vec<Operand> = common.iter().map(|&output| outputs[output]).collect();
        // For each column, the operands of its results.
        let mut computed: Vec<Vec<Operand>> = Vec::new();
        for (repetition, group) in columns.chunks(lanes).enumerate() {
            let entry = |k: usize| group.iter().map(|column| outputs[column[k]]).collect();
            let own = (0..own).map(|k| program.packed(entry(k), lanes)).collect();
            let in_lanes = |operand: &Operand| Operand { lanes: lanes as u8, ..*operand };
            let common = common.iter().map(in_lanes).collect();
            let call = Call { routine: 0, repetition, own, common };
            let used = vec![true; routine.results.len()];
            let call = program.push(Operation::Call(call), lanes, used);
            let first = computed.len();
            computed.resize(first + group.len(), Vec::new());
            let operand =
                |value| Operand { source: Source::Result(value), negated: false, lanes: 1 };
            for (place, &constant) in routine.results.iter().enumerate() {
                let vector = Value { statement: call, place };
                let vector = Operand { lanes: lanes as u8, ..operand(vector) };
                let used = (0..lanes).map(|lane| lane < group.len()).collect();
                let scalars = match (constant.source, lanes) {
                    (Source::Constant(_), _) => None,
                    (_, 1) => Some(call),
                    (_, _) => Some(program.push(Operation::Unpack(vector), 1, used)),
                };
                for (lane, results) in computed[first..].iter_mut().enumerate() {
                    let place = if lanes == 1 { place } else { lane };
                    results.push(
                        scalars.map_or(constant, |statement| operand(Value { statement, place })),
                    );
                }
            }
        }
        let result = |result: &ColumnResult| match *result {
            ColumnResult::Output(output) => outputs[output],
            ColumnResult::OfColumn { column, output } => computed[column][output],
        };
        program.results = results.iter().map(result).collect();
        program.routines.push(Routine {
            tables: vec![Vec::new(); columns.len().div_ceil(lanes)],
            own,
            common: common.len(),
            never_inline: lanes == 1,
            program: routine,
        });
        program.finished()
    }

    /// Appends a statement, and returns its index.
    fn push(&mut self, operation: Operation, lanes: usize, used: Vec<bool>) -> usize {
        let (lanes, stores) = (lanes as u8, Vec::new());
        self.statements.push(Statement { operation, lanes, used, last_use: 0, stores });
        self.statements.len() - 1
    }

    /// Returns the scalars as lanes of a vector; the last one fills all further lanes.
    fn packed(&mut self, mut scalars: Vec<Operand>, lanes: usize) -> Operand {
        let last = scalars[scalars.len() - 1];
        if scalars.iter().all(|scalar| *scalar == last) {
            return Operand { lanes: lanes as u8, ..last };
        }
        scalars.resize(lanes, last);
        let constant = |scalar: &Operand| match scalar.source {
            Source::Constant(value) => Some(if scalar.negated { -value } else { value }),
            Source::Argument(_) | Source::Result(_) => None,
        };
        let constants: Option<Vec<f64>> = scalars.iter().map(constant).collect();
        let operation = constants.map_or(Operation::Pack(scalars), Operation::Constants);
        let statement = self.push(operation, lanes, vec![true]);
        let source = Source::Result(Value { statement, place: 0 });
        Operand { source, negated: false, lanes: lanes as u8 }
    }
}
