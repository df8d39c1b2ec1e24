//! The counts of machine code in `docs/data/machine-code.tsv`. With the variable `UPDATE_SNAPSHOTS`, the test writes them.

use std::path::Path;

use modyn_codegen::program::Program;
use modyn_codegen::{Base, Builder, Function};
use modyn_jit::{CodeSize, InstructionSet, code_sizes};

/// Descriptions in `tests/golden`, the robots' names, and their bases.
const ROBOTS: [(&str, &str, Base); 6] = [
    ("ur5", "UR5", Base::Fixed),
    ("panda", "Panda", Base::Fixed),
    ("solo12", "Solo12", Base::Fixed),
    ("solo12", "Solo12, floating", Base::Floating),
    ("g1", "G1", Base::Fixed),
    ("g1", "G1, floating", Base::Floating),
];

const FUNCTIONS: [Function; 4] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::MassMatrix,
    Function::ForwardDynamicsDerivatives,
];

/// The processors: with 16 and 32 vector registers of four lanes, and with 32 of two lanes.
const PROCESSORS: [(&str, InstructionSet); 3] = [
    ("x86-64, AVX2", InstructionSet::Avx2),
    ("x86-64, AVX-512", InstructionSet::Avx512),
    ("aarch64, NEON", InstructionSet::Neon),
];

/// Returns the largest number of values that are alive between two statements of a program. The last use of a result is
/// where it is computed, since it is stored there.
fn alive(program: &Program) -> usize {
    let count = program.statements.len();
    let mut last_use: Vec<usize> = (0..count).collect();
    for s in 0..count {
        program.reads(s).for_each(|read| last_use[read] = s);
    }
    let mut ends = vec![0; count];
    let (mut alive, mut most) = (0, 0);
    for (s, statement) in program.statements.iter().enumerate() {
        let values = statement.used.iter().filter(|used| **used).count();
        alive += values;
        ends[last_use[s]] += values;
        alive -= ends[s];
        most = most.max(alive);
    }
    most
}

#[test]
fn counts_are_those_of_the_page() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut text = String::from(
        "# command: UPDATE_SNAPSHOTS=1 cargo test -p modyn-jit code_size::\n\
         robot\tfunction\tprocessor\tvalues alive\tinstructions\tof which spills\tof which loads\t\
         bytes of code\n",
    );
    for (file, robot, base) in ROBOTS {
        let description = root.join(format!("tests/golden/{file}.urdf"));
        let builder = Builder::new().file(description).base(base).functions(FUNCTIONS);
        let planning = builder.plan().expect("a robot");
        let sizes =
            PROCESSORS.map(|(name, set)| (name, code_sizes::<f64>(&planning, set).expect("code")));
        for (k, planned) in planning.plan.functions.iter().enumerate() {
            let (_, program) = planned.kernels.straight().expect("one program for all links");
            let alive = alive(program);
            for (processor, sizes) in &sizes {
                let (name, CodeSize { instructions, spills, loads, bytes, .. }) = &sizes[k];
                assert_eq!(*name, planned.name);
                text += &format!(
                    "{robot}\t`{name}`\t{processor}\t{alive}\t{instructions}\t{spills}\t{loads}\t{bytes}\n"
                );
            }
        }
    }
    let path = root.join("docs/data/machine-code.tsv");
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        std::fs::write(path, text).expect("writes");
        return;
    }
    let expected = std::fs::read_to_string(path).expect("docs/data/machine-code.tsv");
    assert_eq!(expected, text, "counts have changed; the table's first line has the command");
}
