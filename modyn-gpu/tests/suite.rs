//! The suite of all back ends, for WGSL: kernels compute what the evaluation of their programs does, as far as single precision
//! allows. In CI, they run on Mesa's software processor.

use std::path::Path;

use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::plan::{Plan, Planned};
use modyn_codegen::{Base, Builder, Emitted, FloatType, Function, Target};
use modyn_gpu::{Gpu, GpuRobot};
use modyn_runtime::model::Model;

use crate::common::columns;
use crate::conformance::{
    Arithmetic, BackEnd, Call, Case, Made, STATES, Subject, conforms, kinds, large, robot, small,
};

struct Wgsl;

/// A robot's kernels with their programs.
struct Kernels {
    gpu: Gpu,
    kernels: GpuRobot,
    emitted: Emitted,
}

impl Made for Kernels {
    fn parts(&self) -> (&Plan, &Model) {
        self.emitted.parts()
    }
}

impl BackEnd for Wgsl {
    type Robot = Kernels;

    fn name(&self) -> String {
        "wgsl".into()
    }

    /// A driver may fuse products with sums, and order sums by itself.
    fn arithmetic(&self) -> Arithmetic {
        Arithmetic::Own(f64::from(f32::EPSILON) / 2.0)
    }

    /// Results with constraints that depend on each other are not continuous.
    fn has(&self, planned: &Planned) -> bool {
        !planned.function.is_some_and(|function| function.row().of_constraints)
    }

    fn make(&self, builder: &Builder) -> Result<Kernels, Diagnostics> {
        let gpu = Gpu::new().expect("a processor: Mesa has one in software");
        let kernels = GpuRobot::new(&gpu, builder).expect("kernels");
        Ok(Kernels { gpu, kernels, emitted: builder.emit(Target::Wgsl)? })
    }

    fn run(&self, subject: &Subject<'_, Kernels>, _: &Path) -> Vec<Vec<f64>> {
        let Kernels { gpu, kernels, emitted } = subject.robot;
        let mut results = Vec::new();
        for own in subject.calls.chunks(STATES) {
            let is_own =
                |call: &Call, function: &str, link| call.function == function && call.link == link;
            let mut all = emitted.kernels.iter();
            let kernel = all.find(|kernel| is_own(&own[0], kernel.function, kernel.link));
            let kernel = kernel.expect("a kernel of the function");
            let name = kernel.name.strip_prefix("ours_").expect("the prefix");
            // Run-time parameters are common to all states: each state runs by itself then.
            let common = kernel.arguments.iter().any(|argument| argument.common);
            for states in own.chunks(if common { 1 } else { STATES }) {
                let array = |i: usize| {
                    let numbers: Vec<Vec<f64>> =
                        states.iter().map(|call| call.arguments[i].clone()).collect();
                    gpu.upload(&columns(&numbers), states.len()).expect("room")
                };
                let arrays: Vec<_> = (0..kernel.arguments.len()).map(array).collect();
                let found = kernels.run(name, &arrays.iter().collect::<Vec<_>>()).expect("it runs");
                let found = found.read().expect("numbers");
                results.extend((0..states.len()).map(|i| {
                    let numbers = found.iter().skip(i).step_by(states.len());
                    numbers.map(|&x| f64::from(x)).collect::<Vec<f64>>()
                }));
            }
        }
        results
    }
}

#[test]
fn all_joint_types() {
    conforms(&Wgsl, &kinds()[0], FloatType::F32);
}

#[test]
#[ignore = "slow: a driver compiles every function of many robots"]
fn robots_of_every_kind() {
    let compared: usize = kinds().iter().map(|case| conforms(&Wgsl, case, FloatType::F32)).sum();
    assert!(compared > 200, "{compared}");
}

#[test]
fn all_functions() {
    conforms(&Wgsl, &small(), FloatType::F32);
}

#[test]
#[ignore = "slow: a driver compiles a large robot"]
fn a_large_robot() {
    conforms(&Wgsl, &large(), FloatType::F32);
}

/// Functions that are cut, whose values go through memory.
#[test]
#[ignore = "slow: a humanoid"]
fn a_humanoid() {
    let derivatives = robot("humanoid").functions([Function::ForwardDynamicsDerivatives]);
    conforms(&Wgsl, &Case { name: "fixed", builder: derivatives }, FloatType::F32);
    let functions = [Function::ForwardDynamics, Function::LinkPoses];
    let floating = robot("humanoid").base(Base::Floating).functions(functions);
    conforms(&Wgsl, &Case { name: "floating", builder: floating }, FloatType::F32);
}
