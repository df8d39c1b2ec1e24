//! Parts of the compiler, one module each.

mod balance;
mod builder;
mod casadi_matrix;
mod check;
mod code;
mod cycles;
mod diagnostic;
mod document;
mod embedded;
mod factor;
#[cfg(feature = "mjcf")]
mod formats;
mod graph_table;
mod layout;
mod limb_groups;
mod line_index;
mod literals;
mod names;
mod numbers;
mod option_values;
mod packed_programs;
mod partition;
mod places;
mod read_file;
mod report;
mod selection;
mod singular_joints;
mod suggest;
mod syntax;
