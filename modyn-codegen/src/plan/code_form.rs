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
    Unrolled,
    /// Loops over the bodies with tables of constants: the shortest code.
    Looped,
}

/// The choices of a user about the code of all functions.
#[derive(Clone, Copy, Debug)]
pub(super) struct CodeChoices {
    /// Whether equal limbs share one routine.
    pub share_limbs: bool,
    /// The form of the code of recursions.
    pub form: CodeForm,
    /// Whether the programs are for machine code.
    pub machine_code: bool,
}
