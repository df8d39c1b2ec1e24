//! Tests of the robots of the fleet, one module a topic.

mod compiled_announced;
mod compiled_generic;
mod compiled_golden;
mod compiled_interpreted;
mod params;
mod simulate;

/// Tests of allocations count those of their own thread.
#[global_allocator]
static ALLOCATOR: modyn_tests::counting::Counting = modyn_tests::counting::Counting;
