//! Compiled code of functions of arrays: calls on many states, rollouts, and the handles that keep it.

mod code;
mod handle;
mod kernel;
mod rollout;
mod states;

use std::sync::Arc;

use modyn_codegen::{FloatType, Planning};

pub use code::ArrayCode;
pub use handle::{CodeHandle, Identity, find, leading, missing, no_step};
pub use kernel::{ArrayShapes, Kernel, OwnCode, OwnKernel, StateFunction};
pub use states::{Broadcast, Numbers, Results};

/// The code of a function of arrays, for either scalar.
pub enum AnyCode {
    F64(ArrayCode<f64>),
    F32(ArrayCode<f32>),
}

impl AnyCode {
    /// Returns the only function of a planning, and the reason why there is no machine code, if it
    /// was wanted.
    pub fn new(
        planning: Planning,
        arrays: ArrayShapes,
        scalar: FloatType,
        machine: bool,
    ) -> Option<(Self, Option<String>)> {
        Some(match scalar {
            FloatType::F64 => {
                let (function, reason) = StateFunction::new(planning, arrays, machine)?;
                (Self::F64(ArrayCode::Function(Arc::new(function))), reason)
            }
            FloatType::F32 => {
                let (function, reason) = StateFunction::new(planning, arrays, machine)?;
                (Self::F32(ArrayCode::Function(Arc::new(function))), reason)
            }
        })
    }
}
