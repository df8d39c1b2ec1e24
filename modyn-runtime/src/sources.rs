//! The parts of this crate that self-contained generated files carry, as text.
#![doc(hidden)]

/// A module of the carried runtime: its path and its text.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// The path, such as `spatial/pose`.
    pub path: &'static str,
    /// The text, including tests; `crate` is the carried runtime.
    pub text: &'static str,
}

macro_rules! sources {
    ($($path:literal)*) => {
        &[$(Source { path: $path, text: include_str!(concat!($path, ".rs")) }),*]
    };
}

/// All modules, by their paths.
pub const SOURCES: &[Source] = sources!(
    "configuration" "constants" "constraint_settings" "float/elementary" "float/root" "float/scalars" "inertial"
    "jacobi" "parameters" "results" "scalar/traits" "scalar/trig"
    "solve/rank" "spatial/pose" "spatial/vector" "spatial/wrench" "step_settings"
);
