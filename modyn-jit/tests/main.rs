//! The tests of machine code, one module a topic.

mod calls;
mod code_size;
mod conformance;
mod contacts;
mod fused;
mod interpreter;
mod memory;
mod object;
mod parameters;
mod user_functions;
