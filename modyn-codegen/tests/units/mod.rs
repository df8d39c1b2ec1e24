//! Parts of the compiler, one module each.

mod balance;
mod builder;
mod casadi_matrix;
mod embedded;
mod factor;
mod graph_table;
mod layout;
mod limb_groups;
mod literals;
mod names;
mod option_values;
mod packed_programs;
mod partition;
mod places;
mod selection;
mod syntax;
