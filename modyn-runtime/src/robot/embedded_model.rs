//! The description of a generated robot.

use crate::model::Model;

/// A generated robot whose type has its description: the option `embed_model`.
///
/// With the model, an interpreter or a compiler at run time takes a generated robot where it would
/// take a file: `modyn_codegen::Builder::robot`, which graphics processors and machine code start
/// from.
///
/// ```
/// use modyn_runtime::{EmbeddedModel, Interpreter, Robot};
///
/// /// Returns the interpreter of the robot that `R` was generated for.
/// fn interpreter<R: Robot + EmbeddedModel>() -> Interpreter<f64> {
///     Interpreter::new(R::model())
/// }
/// ```
pub trait EmbeddedModel {
    /// Returns the robot as it was read, with the options about reading applied: base, gravity,
    /// mimics, rotors, friction, loops and contacts.
    fn model() -> Model;
}
