//! The scalars of robots, which are the types of the numbers in their arrays.

use modyn_jit::Real;
use modyn_runtime::batch::Float;
use modyn_runtime::{ConstraintSettings, ContactTarget, StepSettings};
use numpy::Element;

/// A scalar with machine code and with arrays of NumPy.
pub trait Number: Real + Float + Element + Into<f64> {
    /// The name of NumPy's type.
    const DTYPE: &'static str;

    /// The default settings of constraints.
    const SETTINGS: ConstraintSettings<Self>;

    /// The default target of a contact.
    const GROUND: ContactTarget<Self>;

    /// The default settings of steps.
    const STEP_SETTINGS: StepSettings<Self>;
}

impl Number for f64 {
    const DTYPE: &'static str = "float64";
    const SETTINGS: ConstraintSettings<Self> = ConstraintSettings::<Self>::DEFAULT;
    const GROUND: ContactTarget<Self> = ContactTarget::<Self>::GROUND;
    const STEP_SETTINGS: StepSettings<Self> = StepSettings::<Self>::DEFAULT;
}

impl Number for f32 {
    const DTYPE: &'static str = "float32";
    const SETTINGS: ConstraintSettings<Self> = ConstraintSettings::<Self>::DEFAULT;
    const GROUND: ContactTarget<Self> = ContactTarget::<Self>::GROUND;
    const STEP_SETTINGS: StepSettings<Self> = StepSettings::<Self>::DEFAULT;
}
