//! The scalars of robots, which are the types of the numbers in their arrays.

use modyn_codegen::FloatType;
use modyn_jit::Real;
use modyn_runtime::batch::Float;
use numpy::Element;

/// A scalar with machine code and with arrays of NumPy.
pub trait Number: Real + Float + Element + Into<f64> {
    /// The name of NumPy's type.
    const DTYPE: &'static str;

    /// The scalar among the options.
    const FLOAT: FloatType;
}

impl Number for f64 {
    const DTYPE: &'static str = "float64";
    const FLOAT: FloatType = FloatType::F64;
}

impl Number for f32 {
    const DTYPE: &'static str = "float32";
    const FLOAT: FloatType = FloatType::F32;
}
