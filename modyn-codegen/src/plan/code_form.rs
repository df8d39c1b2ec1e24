//! The form of code: straight-line or loops.

/// The form of the code of recursions over the bodies (forward and inverse dynamics), and of
/// products of matrices in the derivatives of forward dynamics, also under constraints, and in
/// their Hessian.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CodeForm {
    /// Loops where straight-line code would be too long for the instruction cache of a processor.
    #[default]
    Auto,
    /// Straight-line code: the fewest operations.
    Fast,
    /// Loops over the bodies with tables of constants: the shortest code.
    Small,
}
