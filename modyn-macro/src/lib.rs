//! The macro of modyn.
