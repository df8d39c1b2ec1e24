//! Machine code at run time. A description that is read at run time becomes functions for this
//! robot and this processor, within milliseconds and without a compiler on the machine.
//!
//! ```
//! use modyn_codegen::{Builder, Function};
//! use modyn_jit::{Compiled, Options};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let urdf = r#"<robot name="pendulum"><link name="world"/>
//! #   <joint name="pivot" type="continuous">
//! #     <parent link="world"/><child link="rod"/><axis xyz="0 1 0"/>
//! #   </joint>
//! #   <link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
//! #     <inertia ixx="0.1" iyy="0.1" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;
//! let builder = Builder::new().urdf_text(urdf, "pendulum.urdf");
//! # if modyn_jit::InstructionSet::detect().is_none() { return Ok(()) }
//! let robot = Compiled::<f64>::build(&builder, Options::default())?;
//! let mut qdd = [0.0];
//! robot.forward_dynamics(&[0.3], &[0.0], &[0.0], &mut qdd)?;
//! assert!((qdd[0] + 4.905 * 0.3_f64.sin() / 0.35).abs() < 1e-12);
//! # Ok(())
//! # }
//! ```
//!
//! ```text
//! Program ─ lower ─▶ values in registers' lanes ─ generate (registers, encode) ─▶ bytes ─▶ pages ─▶ calls
//! ```
//!
//! The input is a [`Program`](modyn_codegen::program::Program), as for printers: straight-line code
//! with lanes and fused products. `lower` rewrites it as operations that the processor has.
//! `generate` visits them once: it frees the register whose value has the most distant next use,
//! and an architecture, x86-64 or aarch64, writes the instruction. `machine` holds the pages.
//!
//! Results equal the generated Rust code's results within rounding, and are the same bits at each
//! call. For a given [`InstructionSet`], they are bit for bit the results of
//! [`Program::evaluate`](modyn_codegen::program::Program::evaluate) on numbers that fuse products
//! where the instruction set does; that includes angles of any size, infinities and zeros. The bits
//! of a NaN are not specified. Functions have no state: threads can call one robot at the same
//! time.

mod assembly;
mod call;
mod code_size;
mod compiled;
mod error;
mod function;
mod generate;
mod helper;
mod instruction_set;
mod looped;
mod lower;
mod machine;
#[cfg(feature = "object")]
pub mod object;
mod parameters;
mod real;
mod registers;
mod values;

#[cfg(test)]
extern crate self as modyn_jit;
#[cfg(test)]
mod tests;

pub use assembly::code_sizes;
pub use call::Call;
pub use code_size::CodeSize;
pub use compiled::{Compiled, Options};
pub use error::{CallError, CompileError};
pub use instruction_set::InstructionSet;
pub use parameters::ParameterError;
pub use real::Real;
