//! The suite of all back ends, for machine code in memory and for object files: each computes the bits of its programs'
//! evaluation on robots of every kind, for all instruction sets of the processor.

mod python;

use std::path::Path;

use modyn_codegen::diagnostics::{Code, Diagnostics};
use modyn_codegen::plan::Planned;
use modyn_codegen::{Builder, FloatType, Function, Planning};
use modyn_jit::{Compiled, InstructionSet, Options, Real};
use modyn_runtime::model::Model;
use modyn_tests::conformance::{
    Arithmetic, BackEnd, Call, Case, STATES, Subject, kinds, large, robot, robot_conforms, small,
};
use modyn_tests::random;

/// Machine code in memory, for one state at a time or for many.
struct MachineCode {
    instruction_set: InstructionSet,
    many: bool,
}

/// Returns the arithmetic of an instruction set.
fn arithmetic(instruction_set: InstructionSet) -> Arithmetic {
    if instruction_set.fuses() { Arithmetic::FusedSines } else { Arithmetic::Separate }
}

/// Returns whether code for one state runs programs on vectors.
fn on_vectors(instruction_set: InstructionSet, float: FloatType) -> bool {
    instruction_set.fuses() || float == FloatType::F32
}

impl MachineCode {
    /// Runs all calls on numbers of one type.
    fn run_on<F: Real + Into<f64>>(&self, planning: &Planning, calls: &[Call]) -> Vec<Vec<f64>> {
        let mut options = Options::default();
        (options.instruction_set, options.batches) = (Some(self.instruction_set), self.many);
        let compiled = Compiled::<F>::from_plan(planning, options).expect("code");
        assert_eq!(compiled.instruction_set(), self.instruction_set);
        let mut results: Vec<Vec<F>> = Vec::new();
        for own in calls.chunks(if self.many { STATES } else { 1 }) {
            let Call { function, link, .. } = &own[0];
            let all = compiled.functions().find(|one| one.name() == function);
            let call = match all {
                Some(function) => compiled.function(function),
                None => compiled.fused(function),
            };
            let call = call.expect("compiled");
            // The numbers of all states; calls have the arrays that are not empty.
            let mut arrays = 0..own[0].arguments.len();
            let arguments: Vec<Vec<F>> = (call.arguments().iter())
                .map(|(_, shape)| match shape.len() {
                    0 => Vec::new(),
                    _ => {
                        let array = arrays.next().expect("an array");
                        let numbers = own.iter().flat_map(|call| &call.arguments[array]);
                        numbers.map(|&x| F::from_f64(x)).collect()
                    }
                })
                .collect();
            let arguments: Vec<&[F]> = arguments.iter().map(Vec::as_slice).collect();
            let length = call.result().len();
            let mut found = vec![F::from_f64(f64::NAN); length * own.len()];
            match (link, self.many) {
                (None, false) => call.one(&arguments, &mut found),
                (None, true) => call.many(&arguments, &mut found),
                (Some(link), false) => call.link(*link, &arguments, &mut found),
                (Some(link), true) => call.many_link(*link, &arguments, &mut found),
            }
            .expect("fits");
            results.extend(found.chunks(length).map(<[F]>::to_vec));
        }
        results.into_iter().map(|one| one.into_iter().map(Into::into).collect()).collect()
    }
}

impl BackEnd for MachineCode {
    type Robot = Planning;

    fn name(&self) -> String {
        format!("{:?}{}", self.instruction_set, if self.many { " many" } else { "" })
    }

    fn arithmetic(&self) -> Arithmetic {
        arithmetic(self.instruction_set)
    }

    /// A function without arguments has no states.
    fn has(&self, planned: &Planned) -> bool {
        !self.many || planned.arguments.iter().any(|(_, shape)| !shape.is_empty())
    }

    fn on_vectors(&self, float: FloatType) -> bool {
        !self.many && on_vectors(self.instruction_set, float)
    }

    fn takes_parameters(&self) -> bool {
        false
    }

    fn make(&self, builder: &Builder) -> Result<Planning, Diagnostics> {
        builder.plan()
    }

    fn run(&self, subject: &Subject<'_, Planning>, _: &Path) -> Vec<Vec<f64>> {
        match subject.float {
            FloatType::F64 => self.run_on::<f64>(subject.robot, &subject.calls),
            FloatType::F32 => self.run_on::<f32>(subject.robot, &subject.calls),
        }
    }
}

/// Compares machine code of programs with their evaluation, for all instruction sets of the processor, both precisions, one
/// state and many.
fn planning_conforms(name: &str, planning: &Planning) -> usize {
    let mut compared = 0;
    for instruction_set in InstructionSet::available() {
        for many in [false, true] {
            for float in [FloatType::F64, FloatType::F32] {
                let back_end = MachineCode { instruction_set, many };
                compared += robot_conforms(&back_end, name, planning, float);
            }
        }
    }
    compared
}

fn conforms(case: &Case) {
    let planning = case.builder.plan().unwrap_or_else(|errors| panic!("{}: {errors}", case.name));
    let compared = planning_conforms(case.name, &planning);
    assert!(compared >= 4 * STATES, "{}: {compared}", case.name);
}

#[test]
fn robots_of_every_kind() {
    kinds().iter().for_each(conforms);
}

#[test]
fn all_functions() {
    conforms(&small());
}

#[test]
fn a_large_robot() {
    conforms(&large());
}

#[test]
fn a_humanoid() {
    let functions = [
        Function::ForwardDynamics,
        Function::InverseDynamics,
        Function::MassMatrix,
        Function::ForwardDynamicsDerivatives,
        Function::Difference,
    ];
    conforms(&Case { name: "humanoid", builder: robot("humanoid").functions(functions) });
}

/// Compares machine code of some functions of a random robot.
fn some_functions_conform(seed: u64, model: Model) {
    let mut random = random::Random::new(seed);
    let mut functions = Function::ALL.to_vec();
    functions.retain(|function| {
        let fits = function.row().is_general() && function.batched().is_none();
        fits && random.chance(0.2)
    });
    let name = format!("seed {seed}, {}", model.name());
    match Builder::new().model(model).functions(functions).plan() {
        Ok(planning) => {
            planning_conforms(&name, &planning);
        }
        // A few of many seeds: a Runge-Kutta derivative of such a robot would be too long.
        Err(errors) if errors.iter().all(|error| error.code == Code::TooLarge) => {}
        Err(errors) => panic!("{errors}"),
    }
}

/// With joints of all types.
#[test]
fn random_robots() {
    for seed in random::seeds(2) {
        some_functions_conform(seed, random::mixed_zoo(seed, 2 + (seed % 6) as usize));
    }
}

/// With equal and similar limbs.
#[test]
fn random_limbs() {
    for seed in random::seeds(2) {
        some_functions_conform(seed, random::limbs(seed, 3 + (seed % 4) as usize));
    }
}

#[cfg(all(feature = "object", target_arch = "x86_64", target_os = "linux"))]
mod objects {
    use std::process::Command;

    use modyn_jit::object::{Object, ObjectBuilder, ObjectFormat, ObjectOptions};
    use modyn_tests::conformance::c::{STRICT, call, execute, write_main};
    use modyn_tests::conformance::{command, conforms, is_installed};

    use super::*;

    /// An object file that a program in C has in itself.
    #[derive(Clone, Copy, Debug)]
    enum Link {
        Executable,
        Static,
        Shared,
    }

    /// Object files, linked by a C compiler.
    struct Objects {
        instruction_set: InstructionSet,
        compiler: &'static [&'static str],
        link: Link,
    }

    impl BackEnd for Objects {
        type Robot = (Planning, Object);

        fn name(&self) -> String {
            format!("{} {:?} {:?}", self.compiler[0], self.link, self.instruction_set)
        }

        fn arithmetic(&self) -> Arithmetic {
            arithmetic(self.instruction_set)
        }

        fn programs(&self) -> &[&'static str] {
            self.compiler
        }

        fn on_vectors(&self, float: FloatType) -> bool {
            on_vectors(self.instruction_set, float)
        }

        /// The factors of the mass matrix are a type of Rust.
        fn has(&self, planned: &Planned) -> bool {
            planned.function != Some(Function::Brge)
        }

        fn takes_parameters(&self) -> bool {
            false
        }

        fn make(&self, builder: &Builder) -> Result<(Planning, Object), Diagnostics> {
            let options = ObjectOptions {
                instruction_set: self.instruction_set,
                format: ObjectFormat::Elf,
                prefix: Some("ours".into()),
            };
            let object = builder.generate_object(&options).expect("an object");
            Ok((builder.plan()?, object))
        }

        fn run(&self, subject: &Subject<'_, (Planning, Object)>, folder: &Path) -> Vec<Vec<f64>> {
            let (_, object) = subject.robot;
            let files: [(&str, &[u8]); 3] = [
                ("ours.o", &object.bytes),
                ("libours.a", &object.static_library().expect("a library")),
                ("ours.h", object.header.as_bytes()),
            ];
            for (name, bytes) in files {
                std::fs::write(folder.join(name), bytes).expect("writes");
            }
            write_main(subject, folder, call);
            let new = || {
                let mut compiler = Command::new(self.compiler[0]);
                compiler.current_dir(folder);
                compiler
            };
            // Code that had to be changed when it is loaded, or a stack with code, would be errors.
            let strict = ["-Wl,-z,text", "-Wl,-z,defs", "-Wl,--fatal-warnings"];
            let mut compile = new();
            // An optimised caller has values in registers that a call must keep.
            compile.args(STRICT).args(["-O1", "-o", "main", "main.c"]);
            match self.link {
                Link::Executable => compile.args(["-fPIE", "-pie", "ours.o"]).args(strict),
                Link::Static => compile.args(["-static", "-L.", "-lours"]),
                Link::Shared => {
                    command(new().args(["-shared", "ours.o", "-o", "libours.so"]).args(strict));
                    let path = format!("-Wl,-rpath,{}", folder.display());
                    compile.args(["-fPIE", "-pie", "libours.so", &path])
                }
            };
            command(&mut compile);
            execute(subject, folder, &["./main"])
        }
    }

    fn all_sets_conform(case: &Case, float: FloatType, links: &[Link]) {
        for instruction_set in InstructionSet::available() {
            for compiler in [&["gcc"], &["clang"]] {
                for &link in links {
                    let objects = Objects { instruction_set, compiler, link };
                    if is_installed(&objects) {
                        conforms(&objects, case, float);
                    }
                }
            }
        }
    }

    #[test]
    fn all_functions_in_executables_and_libraries() {
        all_sets_conform(&small(), FloatType::F64, &[Link::Executable, Link::Static, Link::Shared]);
    }

    #[test]
    fn single_precision() {
        all_sets_conform(&small(), FloatType::F32, &[Link::Executable]);
    }

    #[test]
    fn robots_of_every_kind() {
        for case in kinds() {
            all_sets_conform(&case, FloatType::F64, &[Link::Executable]);
        }
    }
}
