//! The number of operations of a program.

use modyn_runtime::OperationCount;

use super::{Addend, Operation, Program, Routine, Statement};

impl Program {
    /// Returns the operations of one call; those of routines count as often as they are called.
    #[must_use]
    pub fn operations_per_call(&self) -> OperationCount {
        let calls = |routine: &Routine| {
            let one = routine.program.operations_per_call();
            std::iter::repeat_n(one, routine.tables.len()).sum::<OperationCount>()
        };
        let products = self.products.iter().map(|products| products.operations(self));
        self.own_operations() + self.routines.iter().map(calls).sum() + products.sum()
    }

    /// Returns the operations in the program's text; those of routines count once.
    #[must_use]
    pub fn static_operations(&self) -> OperationCount {
        let routines = self.routines.iter().map(|routine| routine.program.static_operations());
        let products = self.products.iter().map(|products| products.static_operations(self));
        self.own_operations() + routines.sum() + products.sum()
    }

    /// Returns the operations of the program's own statements. An operation on lanes counts once; packs, unpacks and
    /// equations of dependent rows do not count.
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
                | Operation::Call(_)
                | Operation::RowEquations(_) => {}
            }
        }
        count
    }
}
