//! About how much machine code a function comes to.

use modyn_runtime::OperationCount;

/// Bytes for an operation, its loads and stores, and for the sines and cosines behind a function that
/// takes any.
///
/// Fitted to the table in `docs/functions.md` (x86-64, `f64`, release, no batches) by least squares of the logarithms;
/// every row of at least 2 kB is met within a factor of 2.4.
const AN_OPERATION: f64 = 14.2;
const SIN_COS: f64 = 3850.0;

/// Of the operations that stand in a function.
pub fn bytes(static_operations: &OperationCount) -> f64 {
    let sin_cos = if static_operations.sin_cos > 0 { SIN_COS } else { 0.0 };
    AN_OPERATION * static_operations.total() as f64 + sin_cos
}
