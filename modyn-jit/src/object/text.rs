//! The code of an object: programs, the helpers that they call, tables, entries and default
//! parameters, in one section. Distances within it are constants, so the code works at any address
//! without relocations.

use modyn_codegen::plan::{LinkProgram, Plan};
use modyn_runtime::model::Model;

use super::assembler::{Assembler, Label};
use super::convention::Convention;
use super::entry::{Body, Call, Pointer, entry};
use super::helpers::{helper, is_supported};
use super::looped::LoopedBody;
use super::unwind::{Frame, FrameKind};
use crate::assembly::Assembly;
use crate::code_size::CodeSize;
use crate::error::CompileError;
use crate::function::{CompiledFunction, CompiledKernels};
use crate::generate::x86_64::keeps_bases;
use crate::helper::{Helper, Linkage};
use crate::instruction_set::InstructionSet;
use crate::looped::LoopedCode;
use crate::machine::Code;
use crate::real::Real;

/// A name in an object.
#[derive(Clone, Debug)]
pub(super) struct Symbol {
    /// The name without the prefix.
    pub name: String,
    pub start: usize,
    pub length: usize,
    /// Whether it is a function, not data.
    pub is_function: bool,
}

/// The code of an object.
pub(super) struct Text {
    pub code: Vec<u8>,
    pub symbols: Vec<Symbol>,
    pub frames: Vec<Frame>,
    /// The size of each function's programs.
    pub sizes: Vec<(&'static str, CodeSize)>,
}

/// Returns the code of a robot's functions.
pub(super) fn text<S: Real>(
    plan: &Plan,
    model: &Model,
    instruction_set: InstructionSet,
    convention: Convention,
) -> Result<Text, CompileError> {
    let mut assembly = Assembly::<S>::new(instruction_set, false, Linkage::Relative);
    let functions = assembly.functions(plan)?;
    let Assembly { code, kernels, calls, .. } = assembly;
    let mut writer = Writer::<S> {
        frames: kernels
            .iter()
            .map(|kernel| Frame {
                start: kernel.start,
                end: kernel.end,
                last: kernel.last,
                kind: FrameKind::Program { keeps_bases: keeps_bases(kernel.arrays) },
            })
            .collect(),
        a: Assembler::new(code),
        convention,
        symbols: Vec::new(),
        number: std::marker::PhantomData,
    };
    for wanted in [Helper::Reduce, Helper::Atan2, Helper::Logarithm] {
        let places = || calls.iter().filter(|(_, helper)| *helper == wanted).map(|(at, _)| *at);
        if places().next().is_some() {
            let label = helper::<S>(&mut writer.a, wanted);
            writer.leaf(label);
            places().for_each(|at| writer.a.refer(at, label));
        }
    }
    let numbers = plan.parameters.described(model.gravity());
    let defaults = (!numbers.is_empty()).then(|| {
        let start = writer.a.code.len().next_multiple_of(16);
        let label = writer.numbers(&numbers);
        writer.symbol("default_parameters", start, false);
        label
    });
    let placements: Vec<Label> =
        plan.frames.placements().map(|numbers| writer.numbers(&numbers)).collect();
    for function in &functions {
        writer.function(function, defaults, &placements);
    }
    let label = is_supported(&mut writer.a, instruction_set);
    writer.leaf(label);
    let start = writer.a.position(label);
    writer.symbol("is_supported", start, true);
    let Writer { a, symbols, frames, .. } = writer;
    let sizes = functions.iter().map(|function| (function.name, function.size)).collect();
    Ok(Text { code: a.finish(), symbols, frames, sizes })
}

struct Writer<S> {
    a: Assembler,
    convention: Convention,
    symbols: Vec<Symbol>,
    frames: Vec<Frame>,
    number: std::marker::PhantomData<S>,
}

impl<S: Real> Writer<S> {
    /// Appends numbers, and returns their label.
    fn numbers(&mut self, numbers: &[f64]) -> Label {
        self.a.align(16);
        let label = self.a.label_at(self.a.code.len());
        for &number in numbers {
            let bits = S::from_f64(number).bits().to_le_bytes();
            self.a.bytes(&bits[..size_of::<S>()]);
        }
        label
    }

    /// Records the frame of the helper that was appended.
    fn leaf(&mut self, label: Label) {
        let start = self.a.position(label);
        let end = self.a.code.len();
        self.frames.push(Frame { start, end, last: end, kind: FrameKind::Leaf });
    }

    /// Gives a name to what was appended since `start`.
    fn symbol(&mut self, name: &str, start: usize, is_function: bool) {
        let length = self.a.code.len() - start;
        self.symbols.push(Symbol { name: name.into(), start, length, is_function });
    }

    /// Returns the parts of the entry of a program with loops.
    fn looped<'a>(&mut self, function: &CompiledFunction, code: &'a LoopedCode) -> LoopedBody<'a> {
        let mut label = |code: &Code| self.a.label_at(code.entry);
        let arguments: Vec<usize> =
            function.arguments.iter().map(|(_, shape)| shape.len()).collect();
        let given: usize = arguments.iter().sum();
        // The run-time parameters are the last argument.
        let parameters = code.plan.layout.before - given;
        LoopedBody {
            before: label(&code.before),
            after: label(&code.after),
            routines: code.routines.iter().map(label).collect(),
            arguments: arguments.into_iter().chain([parameters]).collect(),
            plan: &code.plan,
            routine_results: code.routine_results(),
            number: size_of::<S>(),
        }
    }

    /// Appends the entries of a function: one for the described parameters and one for run-time
    /// parameters.
    fn function(
        &mut self,
        function: &CompiledFunction,
        defaults: Option<Label>,
        placements: &[Label],
    ) {
        let rows = match &function.kernels {
            CompiledKernels::ByLink(links, kernels) => {
                self.a.align(16);
                let rows = self.a.label_at(self.a.code.len());
                for &LinkProgram { program, placement: row } in links {
                    let program = self.a.label_at(kernels[program].single.entry);
                    self.a.offset(rows, program);
                    // Without a placement the entry is the distance of the table itself, which is
                    // never read.
                    self.a.offset(rows, row.map_or(rows, |row| placements[row]));
                }
                Some((rows, links.len()))
            }
            CompiledKernels::One(_)
            | CompiledKernels::Looped { .. }
            | CompiledKernels::Poses { .. } => None,
        };
        let links: Vec<(usize, Option<Label>)> = match &function.kernels {
            CompiledKernels::Poses { links, .. } => {
                let link =
                    |link: &LinkProgram| (link.program, link.placement.map(|row| placements[row]));
                links.iter().map(link).collect()
            }
            CompiledKernels::One(_)
            | CompiledKernels::Looped { .. }
            | CompiledKernels::ByLink(..) => Vec::new(),
        };
        let looped = match &function.kernels {
            CompiledKernels::Looped { single, .. } => Some(self.looped(function, single)),
            _ => None,
        };
        let body = match (&function.kernels, rows) {
            (CompiledKernels::One(kernel), _) => Body::One(self.a.label_at(kernel.single.entry)),
            (CompiledKernels::ByLink(..), Some(rows)) => Body::Link { rows },
            (CompiledKernels::ByLink(..), None) => unreachable!("the table is there"),
            (CompiledKernels::Looped { .. }, _) => {
                Body::Looped(looped.as_ref().expect("it was made above"))
            }
            (CompiledKernels::Poses { bodies, placed, .. }, _) => {
                let pose = placed.single.results * size_of::<S>();
                let all = bodies.single.results * size_of::<S>();
                let [bodies, placed] =
                    [bodies, placed].map(|kernel| self.a.label_at(kernel.single.entry));
                Body::Poses { bodies, placed, sizes: (pose, all), links: &links }
            }
        };
        // C has no arrays without numbers.
        let mut arguments = 0;
        let mut table: Vec<Pointer> = Vec::new();
        for (_, shape) in &function.arguments {
            let pointer = if shape.is_empty() {
                Pointer::Nothing
            } else {
                arguments += 1;
                Pointer::Argument(arguments - 1)
            };
            table.push(pointer);
        }
        let mut forms = Vec::new();
        if let Some(defaults) = defaults.filter(|_| function.has_parameters) {
            let with = [&*table, &[Pointer::Argument(arguments)]].concat();
            table.push(Pointer::Data(defaults));
            forms.push((format!("{}_with", function.name), with, arguments + 1));
        }
        forms.push((function.name.to_owned(), table, arguments));
        for (name, table, arguments) in forms {
            let link = rows.map(|_| arguments);
            let results = arguments + usize::from(link.is_some());
            let call = Call { table: &table, link, results, body };
            let frame = entry(&mut self.a, self.convention, &call);
            self.symbol(&name, frame.start, true);
            self.frames.push(frame);
        }
    }
}
