//! Tests of the interpreter and of the compiler's output, one module a topic; none of them compiles a robot with its own type.

mod actuators;
mod allocation;
mod budget;
mod changes;
mod constrained_hessians;
mod coordinate_derivatives;
mod coordinates;
mod coriolis;
mod derivatives;
mod differentiation;
mod dual;
mod generator;
mod golden;
mod golden_contacts;
mod golden_loops;
mod graph;
mod hessians;
mod identities;
mod implicit_midpoint;
mod instructions;
mod kinematics;
mod knots;
mod large;
mod loop_derivatives;
mod model;
mod nan;
mod operation_counts;
mod output;
mod pages;
mod regressor;
mod rigid_steps;
mod rotors;
mod scale;
mod shapes;
mod soft_steps;
mod step_hessians;
mod step_laws;
mod steps;
mod ui;
mod user_crates;
mod user_functions;

/// Tests of allocations count those of their own thread.
#[global_allocator]
static ALLOCATOR: modyn_tests::counting::Counting = modyn_tests::counting::Counting;
