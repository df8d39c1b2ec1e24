//! modyn
