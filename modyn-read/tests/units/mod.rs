//! Parts of the reader, one module each.

mod check;
mod code;
mod cycles;
mod diagnostic;
mod document;
mod formats;
mod line_index;
mod mjcf_table;
mod numbers;
mod read_file;
mod report;
mod singular_joints;
mod suggest;
