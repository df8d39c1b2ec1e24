//! Compiled code of functions of arrays: calls on many states, rollouts, and the handles that keep it.

mod code;
mod handle;
mod kernel;
mod rollout;
mod states;

use std::sync::Arc;

use modyn_codegen::{FloatType, Planning};

use crate::number::Number;

pub use code::ArrayCode;
pub use handle::{CodeHandle, Identity, find, leading, missing, no_step};
pub use kernel::{ArrayShapes, Kernel, Lanes, OwnCode, OwnKernel, StateFunction};
pub use states::{Broadcast, Numbers, Results, common};

/// The code of a function of arrays, for either scalar.
pub enum AnyCode {
    F64(ArrayCode<f64>),
    F32(ArrayCode<f32>),
}

/// Numbers that code computes with: a variant of [`AnyCode`].
pub trait CodeNumber: Number {
    /// Returns the code for these numbers; `None` if the code is for others.
    fn code(any: &AnyCode) -> Option<&ArrayCode<Self>>;

    /// Returns code for these numbers as code for either scalar.
    fn any(code: ArrayCode<Self>) -> AnyCode;
}

macro_rules! code_numbers {
    ($($number:ident $variant:ident)*) => {$(
        impl CodeNumber for $number {
            fn code(any: &AnyCode) -> Option<&ArrayCode<Self>> {
                match any {
                    AnyCode::$variant(code) => Some(code),
                    _ => None,
                }
            }

            fn any(code: ArrayCode<Self>) -> AnyCode {
                AnyCode::$variant(code)
            }
        }
    )*};
}

code_numbers! { f64 F64 f32 F32 }

impl AnyCode {
    /// Returns the only function of a planning, and the reason why there is no machine code, if it
    /// was wanted.
    pub fn new(
        planning: Planning,
        arrays: ArrayShapes,
        scalar: FloatType,
        machine: bool,
    ) -> Option<(Self, Option<String>)> {
        fn of<S: CodeNumber>(
            planning: Planning,
            arrays: ArrayShapes,
            machine: bool,
        ) -> Option<(AnyCode, Option<String>)> {
            let (function, reason) = StateFunction::<S>::new(planning, arrays, machine)?;
            Some((S::any(ArrayCode::Function(Arc::new(function))), reason))
        }
        match scalar {
            FloatType::F64 => of::<f64>(planning, arrays, machine),
            FloatType::F32 => of::<f32>(planning, arrays, machine),
        }
    }
}
