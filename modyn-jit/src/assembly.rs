//! The machine code of all functions of a robot, one after another.

use modyn_codegen::Planning;
use modyn_codegen::plan::{Frames, Kernels, Plan, Planned, Shape};
use modyn_codegen::program::Program;

use crate::call::MAX_GIVEN;
use crate::code_size::CodeSize;
use crate::error::CompileError;
use crate::function::{CompiledFunction, CompiledKernels, Kernel};
use crate::generate::{MAX_ARRAYS, PADDING, generate};
use crate::helper::{Helper, Helpers, Linkage};
use crate::instruction_set::InstructionSet;
use crate::looped::{Lanes, LoopedCode};
use crate::lower::{Rows, lower};
use crate::machine::Code;
use crate::real::Real;
use crate::values::{Kept, Values};

/// Returns the counts of the code of each function for one state, by name. The processor
/// need not have the instruction set.
///
/// # Errors
///
/// If a function has too many arguments.
pub fn code_sizes<S: Real>(
    planning: &Planning,
    instruction_set: InstructionSet,
) -> Result<Vec<(&'static str, CodeSize)>, CompileError> {
    let linkage = Linkage::Addresses(Helpers::new::<S>());
    let mut assembly = Assembly::<S>::new(instruction_set, false, linkage);
    let functions = assembly.functions(&planning.plan)?;
    Ok(functions.iter().map(|function| (function.name, function.size)).collect())
}

/// The part of the code that one form of a program takes, by offsets. Object files alone read them.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "object"), allow(dead_code))]
pub(crate) struct KernelCode {
    /// Its start.
    pub start: usize,
    /// The offset after its return.
    pub end: usize,
    /// The offset after its last instruction.
    pub last: usize,
    /// The number of arrays of arguments.
    pub arrays: usize,
}

/// The code of all functions during compilation.
pub(crate) struct Assembly<S> {
    instruction_set: InstructionSet,
    batches: bool,
    linkage: Linkage,
    /// The code.
    pub code: Vec<u8>,
    /// The code of each form of a program.
    pub kernels: Vec<KernelCode>,
    /// The calls of helpers with [`Linkage::Relative`]: the offset of each call's distance.
    pub calls: Vec<(usize, Helper)>,
    number: std::marker::PhantomData<S>,
}

impl<S: Real> Assembly<S> {
    pub fn new(instruction_set: InstructionSet, batches: bool, linkage: Linkage) -> Self {
        let code = Vec::new();
        let kernels = Vec::new();
        let calls = Vec::new();
        let number = std::marker::PhantomData;
        Self { instruction_set, batches, linkage, code, kernels, calls, number }
    }

    /// Compiles all functions of a plan.
    ///
    /// # Errors
    ///
    /// If a function has too many arguments.
    pub fn functions(&mut self, plan: &Plan) -> Result<Vec<CompiledFunction>, CompileError> {
        for planned in &plan.functions {
            let arrays = planned.arguments.len() + usize::from(planned.parameters > 0);
            // The arguments of a program with loops become one array.
            let is_looped = matches!(
                &planned.kernels,
                Kernels::Straight { scalar, .. } if scalar.loops().next().is_some()
            );
            if arrays > if is_looped { MAX_GIVEN } else { MAX_ARRAYS } {
                return Err(CompileError::Arguments { function: planned.name, arrays });
            }
        }
        Ok(plan.functions.iter().map(|planned| self.function(planned, plan)).collect())
    }

    fn function(&mut self, planned: &Planned, plan: &Plan) -> CompiledFunction {
        let arrays = planned.lengths();
        let mut size = CodeSize::default();
        let mut kernel = |program: &Program, simd: Option<&Program>, arrays: &[usize]| {
            self.kernel(program, simd, arrays, &mut size)
        };
        let placed = [&*arrays, &[Frames::PLACEMENT]].concat();
        let kernels = match &planned.kernels {
            Kernels::Straight { scalar, simd } => match scalar.around_loops() {
                Some(_) => self.looped(scalar, simd.as_ref(), arrays.iter().sum(), &mut size),
                None => CompiledKernels::One(kernel(scalar, simd.as_ref(), &arrays)),
            },
            Kernels::ByLink(programs) => {
                let known_count = plan.frames.links_with_own_program().count();
                let arrays = |k: usize| if k < known_count { &arrays } else { &placed };
                let programs = programs.iter().enumerate();
                let kernels = programs.map(|(k, program)| kernel(program, None, arrays(k)));
                CompiledKernels::ByLink(plan.frames.programs().to_vec(), kernels.collect())
            }
            Kernels::Poses { bodies, placed, .. } => CompiledKernels::Poses {
                bodies: kernel(bodies, None, &arrays),
                placed: kernel(placed, None, &[Shape::pose().len(), Frames::PLACEMENT]),
                links: plan.frames.programs().to_vec(),
            },
        };
        let declared = planned.arguments.iter();
        let arguments = declared.map(|(argument, shape)| (argument.name, shape.clone()));
        CompiledFunction {
            function: planned.function,
            name: planned.name,
            arguments: arguments.collect(),
            has_parameters: planned.parameters > 0,
            result: planned.result.clone(),
            kernels,
            size,
        }
    }

    /// Compiles a program with loops.
    fn looped(
        &mut self,
        scalar: &Program,
        simd: Option<&Program>,
        arguments: usize,
        size: &mut CodeSize,
    ) -> CompiledKernels {
        let simd = simd.filter(|_| self.instruction_set.packs(size_of::<S>()));
        let program = simd.unwrap_or(scalar);
        let single = LoopedCode::new(program, arguments, Lanes::Numbers, |program, length, _| {
            let (code, bytes) = self.append(program, &[length], false, None);
            *size += bytes;
            code
        });
        let batch = self.batches.then(|| {
            LoopedCode::new(scalar, arguments, Lanes::States, |program, length, kept| {
                self.append(program, &[length], true, kept).0
            })
        });
        CompiledKernels::Looped { single: Box::new(single), batch: batch.map(Box::new) }
    }

    /// Compiles a program. The code for one state has vectors if the program has some and they are
    /// profitable; the code for batches is the scalar program with a state in each lane.
    fn kernel(
        &mut self,
        scalar: &Program,
        simd: Option<&Program>,
        arrays: &[usize],
        size: &mut CodeSize,
    ) -> Kernel {
        let single = match simd {
            Some(simd) if self.instruction_set.packs(size_of::<S>()) => simd,
            _ => scalar,
        };
        let (single, bytes) = self.append(single, arrays, false, None);
        *size += bytes;
        let batch = self.batches.then(|| self.append(scalar, arrays, true, None).0);
        Kernel { single, batch }
    }

    /// Compiles a program for one state, or for a batch whose states keep numbers. Code for
    /// independent constraint rows alone is worth its length if it leaves out an eighth of the
    /// steps.
    pub fn append(
        &mut self,
        program: &Program,
        arrays: &[usize],
        batch: bool,
        kept: Option<&Kept>,
    ) -> (Code, CodeSize) {
        let lower = |rows| {
            let mut values = lower::<S>(program, arrays, self.instruction_set, batch, rows);
            if let Some(kept) = kept {
                values.keep(kept);
            }
            values
        };
        let all = lower(Rows::All);
        let alternative = program.has_row_equations().then(|| lower(Rows::Independent));
        let independent = alternative.filter(|few| 8 * few.steps.len() <= 7 * all.steps.len());
        let (any_rank, size) = self.write(&all, arrays, batch, None);
        let Some(independent) = independent else { return (any_rank, size) };
        let (code, mut total) = self.write(&independent, arrays, batch, Some(any_rank.entry));
        total.bytes += size.bytes;
        total.constants += size.constants;
        total.frame += size.frame;
        (code, total)
    }

    /// Writes the code of values. `any_rank` is the start of the code which its guards call.
    fn write(
        &mut self,
        values: &Values,
        arrays: &[usize],
        batch: bool,
        any_rank: Option<usize>,
    ) -> (Code, CodeSize) {
        self.code.resize(self.code.len().next_multiple_of(64), PADDING);
        let entry = self.code.len();
        let any_rank = any_rank.map(|start| start as i64 - entry as i64);
        let set = self.instruction_set;
        let linkage = &self.linkage;
        let generated = generate(values, set, size_of::<S>(), arrays.len(), linkage, any_rank);
        self.code.extend_from_slice(&generated.code);
        let end = entry + generated.end;
        let last = entry + generated.size.bytes;
        self.kernels.push(KernelCode { start: entry, end, last, arrays: arrays.len() });
        let calls = generated.calls.into_iter().map(|(at, helper)| (entry + at, helper));
        self.calls.extend(calls);
        let lanes = if batch { self.instruction_set.vector(true) / size_of::<S>() } else { 1 };
        let arguments = arrays.iter().map(|length| length * lanes).collect();
        (Code { entry, arguments, results: values.results.len() * lanes }, generated.size)
    }
}
