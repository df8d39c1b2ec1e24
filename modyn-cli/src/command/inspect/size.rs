//! Estimates the machine code of a function.

use modyn_runtime::OperationCount;

/// Bytes for each operation with its loads and stores, and for the sine and cosine routines of a
/// function that uses any.
///
/// The values were fitted to the table `docs/data/functions.tsv` (x86-64, `f64`, release,
/// no batches) by least squares of the logarithms. Every row of at least 2 kB is within a factor of
/// 2.4.
const AN_OPERATION: f64 = 14.2;
const SIN_COS: f64 = 3850.0;

/// Returns the estimated bytes of a function with these operations in its text.
pub fn bytes(static_operations: &OperationCount) -> f64 {
    let sin_cos = if static_operations.sin_cos > 0 { SIN_COS } else { 0.0 };
    AN_OPERATION * static_operations.total() as f64 + sin_cos
}
