//! The listings and pictures of `docs/internals/machine-code.md`: a small program at each step of
//! compilation. With the variable `UPDATE_SNAPSHOTS`, the test writes them:
//! `UPDATE_SNAPSHOTS=1 cargo test -p modyn-jit --lib page`.

mod pictures;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use iced_x86::{Decoder, DecoderOptions, Formatter as _, Instruction, IntelFormatter};
use iced_x86::{MemorySizeOptions, Mnemonic, OpKind, Register};
use modyn_codegen::graph::Graph;
use modyn_codegen::passes::{balance, optimize};
use modyn_codegen::plan::Kernels;
use modyn_codegen::program::{
    Addend, Execution, MultiplyAdd, Operand, Operation as Statement, Program, Source,
};
use modyn_codegen::trace::Tracer;
use modyn_codegen::{Builder, Function};
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::ModuleTree;

use crate::code_size::CodeSize;
use crate::generate::{Generated, generate};
use crate::helper::Linkage;
use crate::instruction_set::InstructionSet;
use crate::lower::{Rows, lower};
use crate::values::{Definition, FarCheck, Operation, Step, Value, Values};

/// A cart on rails with a pole: two joints, whose mass matrix depends on the angle of the pole.
const CART_POLE: &str = r#"<robot name="cart_pole"><link name="rails"/>
<joint name="slide" type="prismatic"><parent link="rails"/><child link="cart"/><axis xyz="1 0 0"/>
  <limit lower="-2" upper="2" effort="100" velocity="10"/></joint>
<link name="cart"><inertial><mass value="1.5"/>
  <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="cart"/><child link="pole"/><axis xyz="0 1 0"/></joint>
<link name="pole"><inertial><origin xyz="0 0 0.5"/><mass value="0.25"/>
  <inertia ixx="0.02" iyy="0.02" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;

const INPUTS: [&str; 6] = ["q0", "q1", "qd0", "qd1", "tau0", "tau1"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Returns a function's scalar program and the lengths of its arguments.
fn program(builder: &Builder) -> (Program, Vec<usize>) {
    let builder = builder.clone().functions([Function::ForwardDynamics]);
    let mut planning = builder.plan().expect("a robot");
    let planned = planning.plan.functions.remove(0);
    let arrays = planned.arguments.iter().map(|(_, shape)| shape.len()).collect();
    match planned.kernels {
        Kernels::Straight { scalar, .. } => (scalar, arrays),
        _ => panic!("a function of the whole robot"),
    }
}

/// Returns the graph that becomes the program of forward dynamics.
fn graph(builder: &Builder) -> Graph {
    let planning = builder.clone().functions([Function::ForwardDynamics]).plan().expect("a robot");
    let mechanism = Mechanism::new(&planning.model);
    let elimination = Elimination::new(&mechanism, &ModuleTree::chains(&planning.model));
    balance(&optimize(Tracer::new(&mechanism).forward_dynamics(&elimination)))
}

/// Returns a number with at most six digits.
fn number(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().expect("a number");
    let is_short = rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs());
    if is_short { format!("{rounded}") } else { format!("{rounded:e}") }
}

fn operand(operand: &Operand) -> String {
    let text = match operand.source {
        Source::Constant(x) => number(x),
        Source::Argument(i) => INPUTS[i].into(),
        Source::Result(value) => format!("x{}{}", value.statement, ["", "'"][value.place]),
    };
    if operand.negated { format!("-{text}") } else { text }
}

/// Returns the statements of a program, one in each line.
fn statements(program: &Program) -> String {
    let mut text = String::new();
    for (i, statement) in program.statements.iter().enumerate() {
        let (name, written) = match &statement.operation {
            Statement::Add(a, b) => (format!("x{i}"), format!("{} + {}", operand(a), operand(b))),
            Statement::Subtract(a, b) => {
                (format!("x{i}"), format!("{} - {}", operand(a), operand(b)))
            }
            Statement::Multiply(a, b) => {
                (format!("x{i}"), format!("{} * {}", operand(a), operand(b)))
            }
            Statement::Reciprocal(a) => (format!("x{i}"), format!("1 / {}", operand(a))),
            Statement::SinCos(angles) => {
                (format!("x{i}, x{i}'"), format!("sin_cos({})", operand(&angles[0])))
            }
            Statement::MultiplyAdd(fused) => (format!("x{i}"), multiply_add(fused)),
            other => panic!("the example has {other:?}"),
        };
        let _ = writeln!(text, "{name:8} = {written}");
    }
    let results: Vec<String> = program.results.iter().map(operand).collect();
    text + &format!("results: {}\n", results.join(", "))
}

fn multiply_add(fused: &MultiplyAdd) -> String {
    let MultiplyAdd { negative_product, factors: [a, b], negative_addend, addend } = fused;
    let addend = match addend {
        Addend::Value(c) => operand(c),
        Addend::Product(c, d) => format!("{} * {}", operand(c), operand(d)),
    };
    let sign = ["", "-"][usize::from(*negative_product)];
    let join = ["+", "-"][usize::from(*negative_addend)];
    format!("fused({sign}{} * {} {join} {addend})", operand(a), operand(b))
}

/// The values of a program with the code that was made of them.
struct Code {
    values: Values,
    generated: Generated,
    /// The instructions up to the return, each with its bytes.
    instructions: Vec<(Instruction, Vec<u8>)>,
    /// For each value its number in listings: the number of values that are computed before it.
    numbers: Vec<usize>,
}

impl Code {
    fn new(program: &Program, arrays: &[usize]) -> Self {
        let set = InstructionSet::Avx2;
        let values = lower::<f64>(program, arrays, set, false, Rows::All);
        let linkage = &Linkage::Relative;
        let generated = generate(&values, set, size_of::<f64>(), arrays.len(), linkage, None);
        let code = &generated.code[..generated.end];
        let mut decoder = Decoder::with_ip(64, code, 0, DecoderOptions::NONE);
        let mut instructions = Vec::new();
        while decoder.can_decode() {
            let instruction = decoder.decode();
            let start = instruction.ip() as usize;
            instructions.push((instruction, code[start..start + instruction.len()].to_vec()));
        }
        let mut numbers = vec![usize::MAX; values.definitions.len()];
        let computed = values.steps.iter().filter_map(|step| match step {
            Step::Compute(value) => Some(*value),
            Step::Check(_) | Step::Guard(_) => None,
        });
        for (number, value) in computed.enumerate() {
            numbers[value as usize] = number;
        }
        Self { values, generated, instructions, numbers }
    }

    /// Returns the name of a value.
    fn name(&self, value: Value) -> String {
        match self.values.definitions[value as usize] {
            Definition::Constant(place) => match self.values.pool[place as usize][0] {
                0x8000_0000_0000_0000 => "sign bit".into(),
                bits => number(f64::from_bits(bits)),
            },
            Definition::Argument { array, first } => {
                INPUTS[2 * usize::from(array) + first as usize].into()
            }
            Definition::Lane(vector, lane) => format!("{}[{lane}]", self.name(vector)),
            Definition::Result(..) => format!("v{}", self.numbers[value as usize]),
        }
    }

    /// Returns a step as text.
    fn step(&self, step: &Step) -> String {
        let value = match step {
            Step::Compute(value) => *value,
            Step::Guard(_) => unreachable!("the example has no constraints"),
            Step::Check(FarCheck { squares, limit, .. }) => {
                return format!(
                    "if {} >= {}: reduce again",
                    self.name(*squares),
                    self.name(*limit)
                );
            }
        };
        let Definition::Result(operation, _) = self.values.definitions[value as usize] else {
            panic!("a step computes a result");
        };
        let names: Vec<String> =
            self.values.operands(value).iter().map(|&operand| self.name(operand)).collect();
        let text = match (operation, names.as_slice()) {
            (Operation::Add, [a, b]) => format!("{a} + {b}"),
            (Operation::Subtract, [a, b]) => format!("{a} - {b}"),
            (Operation::Multiply, [a, b]) => format!("{a} * {b}"),
            (Operation::Divide, [a, b]) => format!("{a} / {b}"),
            (Operation::Xor, [a, b]) => format!("{a} xor {b}"),
            (Operation::ShiftToSign, [a]) => format!("lowest bit of {a} as sign"),
            (Operation::MultiplyAdd(negated), [a, b, c]) => {
                let sign = if negated.product { "-" } else { "" };
                let join = if negated.addend { "-" } else { "+" };
                format!("{sign}{a} * {b} {join} {c}")
            }
            other => panic!("the example has {other:?}"),
        };
        format!("{} = {text}", self.name(value))
    }

    /// Returns the instructions of a step, or those before or after all steps.
    fn of_step(&self, step: Option<usize>) -> &[(Instruction, Vec<u8>)] {
        let at = |offset: usize| {
            self.instructions
                .partition_point(|(instruction, _)| (instruction.ip() as usize) < offset)
        };
        let steps = &self.generated.steps;
        match step {
            Some(step) => &self.instructions[at(steps[step])..at(steps[step + 1])],
            None => &self.instructions[..at(steps[0])],
        }
    }

    /// Returns the instructions after all steps, up to the return.
    fn after(&self) -> &[(Instruction, Vec<u8>)] {
        let last = *self.generated.steps.last().expect("the end of the steps");
        let is_before =
            |(instruction, _): &(Instruction, Vec<u8>)| (instruction.ip() as usize) < last;
        &self.instructions[self.instructions.partition_point(is_before)..]
    }

    /// Returns the register in which a step leaves its value: the destination of its last
    /// instruction that is no store.
    fn register(&self, step: usize) -> Option<usize> {
        let instructions =
            self.of_step(Some(step)).iter().rev().map(|(instruction, _)| instruction);
        let mut written =
            instructions.filter(|instruction| instruction.op0_kind() == OpKind::Register);
        let register = written.next()?.op0_register();
        register.is_vector_register().then(|| register.number())
    }

    /// Returns whether a step stores a value in the stack frame for lack of a register.
    fn spills(&self, step: usize) -> bool {
        self.of_step(Some(step)).iter().any(|(instruction, _)| {
            instruction.op0_kind() == OpKind::Memory
                && instruction.memory_base() == Register::RAX
                && instruction.mnemonic() != Mnemonic::Or
        })
    }

    /// Returns for each step that computes a value the value, the step, and the last step that
    /// reads it.
    fn lives(&self) -> Vec<(Value, usize, usize)> {
        let mut last = vec![0; self.values.definitions.len()];
        for (i, step) in self.values.steps.iter().enumerate() {
            for value in self.values.reads(step) {
                if let Some(computed) = self.values.computed(value) {
                    last[computed as usize] = i;
                }
            }
        }
        let computed = self.values.steps.iter().enumerate().filter_map(|(i, step)| match step {
            Step::Compute(value) => Some((*value, i, last[*value as usize].max(i))),
            Step::Check(_) | Step::Guard(_) => None,
        });
        computed.collect()
    }

    /// Returns the counts of the instructions of aarch64.
    fn size_of_aarch64(&self, arrays: usize) -> CodeSize {
        // Both instruction sets fuse products, and the example has no vectors: so its values are
        // the same.
        let linkage = &Linkage::Relative;
        generate(&self.values, InstructionSet::Neon, size_of::<f64>(), arrays, linkage, None).size
    }

    /// Returns the instructions with their bytes, the instructions of each step after its text.
    fn listing(&self) -> String {
        let mut formatter = IntelFormatter::new();
        let options = formatter.options_mut();
        options.set_memory_size_options(MemorySizeOptions::Never);
        options.set_rip_relative_addresses(true);
        let mut text = String::new();
        let mut lines = |heading: &str, instructions: &[(Instruction, Vec<u8>)]| {
            let _ = writeln!(text, "{heading}");
            for (instruction, bytes) in instructions {
                let mut written = String::new();
                formatter.format(instruction, &mut written);
                let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
                let _ = writeln!(text, "    {written:38} {}", bytes.join(" "));
            }
        };
        lines("entry", self.of_step(None));
        for (i, step) in self.values.steps.iter().enumerate() {
            lines(&self.step(step), self.of_step(Some(i)));
        }
        lines("return", self.after());
        text
    }
}

/// Replaces what stands between `<!-- listing: NAME -->` and `<!-- end -->` in the page by a block
/// of text.
fn with_listing(page: &str, name: &str, listing: &str) -> String {
    let begin = format!("<!-- listing: {name} -->\n");
    let (before, rest) = page.split_once(&begin).unwrap_or_else(|| panic!("no {begin}"));
    let (_, after) = rest.split_once("<!-- end -->").expect("the end of the listing");
    format!("{before}{begin}```text\n{listing}```\n<!-- end -->{after}")
}

/// Returns the counts of code in one line.
fn counts(size: &CodeSize) -> String {
    let CodeSize { instructions, bytes, constants, frame, .. } = size;
    format!(
        "{instructions} instructions, {bytes} bytes of instructions, {constants} bytes of constants, {frame} bytes of \
         stack\n"
    )
}

/// Compares a file of the documentation with the text that it should have, or writes it.
fn check(path: &str, text: impl Fn(&str) -> String) {
    let path = root().join("docs").join(path);
    let present = std::fs::read_to_string(&path).unwrap_or_default();
    let expected = text(&present);
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        std::fs::write(&path, expected).expect("writes");
        return;
    }
    let command = "UPDATE_SNAPSHOTS=1 cargo test -p modyn-jit --lib page";
    assert!(present == expected, "{} is not current; `{command}` writes it", path.display());
}

#[test]
fn the_page_shows_what_the_compiler_does() {
    let builder = Builder::new().urdf_text(CART_POLE, "cart_pole.urdf");
    let (program, arrays) = program(&builder);
    let graph = graph(&builder);
    // The picture of the graph shows this program.
    let again = Program::new(&graph, program.arguments, Execution::Scalar);
    assert_eq!(format!("{:?}", again.statements), format!("{:?}", program.statements));
    let code = Code::new(&program, &arrays);
    assert_eq!(code.generated.size.spills, 0, "the text says that the example needs no spill");
    let size_of_aarch64 = code.size_of_aarch64(arrays.len());
    check("internals/machine-code.md", |page| {
        let listings = [
            ("description", CART_POLE.to_owned() + "\n"),
            ("program", statements(&program)),
            ("size", counts(&code.generated.size)),
            ("aarch64-size", counts(&size_of_aarch64)),
        ];
        listings.iter().fold(page.to_owned(), |page, (name, text)| with_listing(&page, name, text))
    });
    check("internals/cart-pole.txt", |_| code.listing());
    check("figures/machine-code-graph.svg", |_| pictures::graph(&graph, &INPUTS));
    check("figures/machine-code-lives.svg", |_| pictures::lives(&code));
}

#[test]
fn the_page_shows_registers_of_an_arm() {
    let builder = Builder::new().file(root().join("tests/golden/panda.urdf"));
    let (program, arrays) = program(&builder);
    let code = Code::new(&program, &arrays);
    assert!(code.generated.size.spills > 50);
    check("figures/machine-code-pressure.svg", |_| pictures::pressure(&code));
}
