//! The tests of the compiler, one module a topic.

mod availability;
mod c_header;
mod casadi;
mod contacts;
mod entries;
mod fixed_links;
mod functions;
mod fused;
mod general_position;
mod graphs;
mod imports;
mod injection;
mod limb_derivatives;
mod limbs;
mod loops;
mod options;
mod programs;
mod runtime_parameters;
mod same_text;
mod self_contained;
mod single_precision;
mod singular;
mod step_derivatives;
mod type_page;
mod units;
mod user_functions;
