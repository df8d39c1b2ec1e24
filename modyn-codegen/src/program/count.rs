//! The number of operations of a program.

use modyn_runtime::OperationCount;

use super::{Addend, Loops, Operation, Program, Statement};

impl Program {
    /// Returns the operations of one call. Loops count with all iterations that they can have.
    #[must_use]
    pub fn operations_per_call(&self) -> OperationCount {
        let loops = self.loops().map(|loops| loops.operations(self)).sum();
        let products = self.products.iter().map(|products| products.operations(self));
        self.own_operations() + loops + products.sum()
    }

    /// Returns the operations in the program's text; the operations of a routine count once.
    #[must_use]
    pub fn static_operations(&self) -> OperationCount {
        let routines = self.routines.iter().map(|routine| routine.program.static_operations());
        let loops = self.loops().map(Loops::static_operations).sum();
        let products = self.products.iter().map(|products| products.static_operations(self));
        self.own_operations() + routines.sum() + loops + products.sum()
    }

    /// Returns the loops.
    pub fn loops(&self) -> impl Iterator<Item = &Loops> {
        self.statements.iter().filter_map(|statement| match &statement.operation {
            Operation::Loops(loops) => Some(loops),
            _ => None,
        })
    }

    /// Returns the operations of the program's own statements. An operation on lanes counts once;
    /// packs, unpacks and equations of dependent rows do not count.
    fn own_operations(&self) -> OperationCount {
        let mut count = OperationCount::default();
        for Statement { operation, .. } in &self.statements {
            match operation {
                Operation::Add(..) | Operation::Subtract(..) => count.additions += 1,
                Operation::Multiply(..) => count.multiplications += 1,
                Operation::MultiplyAdd(fused) => {
                    count.additions += 1;
                    count.multiplications += match fused.addend {
                        Addend::Value(_) => 1,
                        Addend::Product(..) => 2,
                    };
                }
                Operation::Reciprocal(_) => count.divisions += 1,
                Operation::SinCos(angles) => count.sin_cos += angles.len(),
                Operation::Atan2(..)
                | Operation::SquareRoot(_)
                | Operation::Logarithm(_)
                | Operation::Absolute(_)
                | Operation::Maximum(..)
                | Operation::Select(..) => count.others += 1,
                Operation::Pack(_)
                | Operation::Constants(_)
                | Operation::Unpack(_)
                | Operation::Loops(_)
                | Operation::RowEquations(_) => {}
            }
        }
        count
    }
}
