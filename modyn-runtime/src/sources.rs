//! The parts of this crate that generated files can carry with them, as text.
#![doc(hidden)]

/// A module of the carried runtime: its path, and the text behind it.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// Where it stands: `spatial/pose`.
    pub path: &'static str,
    /// Its text, with tests, and with `crate` for the carried runtime.
    pub text: &'static str,
}

macro_rules! sources {
    ($($path:literal)*) => {
        &[$(Source { path: $path, text: include_str!(concat!($path, ".rs")) }),*]
    };
}

/// All, by their paths.
pub const SOURCES: &[Source] = sources!(
    "configuration" "constraint_settings" "inertial" "jacobi" "parameters" "results"
    "scalar/abreast" "scalar/elementary" "scalar/float" "scalar/real" "scalar/root" "scalar/trig"
    "spatial/pose" "spatial/vector" "spatial/wrench"
);
