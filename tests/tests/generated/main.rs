//! Tests of robots that the macro compiles, one module a topic. Clippy would take minutes for their code.
#![cfg(not(clippy))]

mod batch;
mod configuration;
mod constraint_vectors;
mod contact_batch;
mod embedded_model;
mod fused;
mod looped;
mod mjcf;
mod no_heap;
mod paper_gripper;
mod runtime_inertia;

/// Tests of allocations count those of their own thread.
#[global_allocator]
static ALLOCATOR: modyn_tests::counting::Counting = modyn_tests::counting::Counting;
