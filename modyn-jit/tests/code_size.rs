//! The counts of machine code in `docs/data/machine-code.tsv`. With the variable `UPDATE_SNAPSHOTS`, the test writes them.

use std::path::Path;

use modyn_codegen::{Builder, Function};
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

/// The instruction sets, with 16 and 32 registers.
const INSTRUCTION_SETS: [InstructionSet; 2] = [InstructionSet::Avx2, InstructionSet::Avx512];

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
        "# command: UPDATE_SNAPSHOTS=1 cargo test -p modyn-jit --test code_size\n\
         robot\tfunction\tprocessor\tinstructions\tof which spills\tof which loads\tbytes of code\n",
    );
    for (file, robot, function) in ROWS {
        let description = root.join(format!("tests/golden/{file}.urdf"));
        let planning =
            Builder::new().file(description).functions([function]).plan().expect("a robot");
        for (processor, instruction_set) in
            [("x86-64, AVX2", InstructionSet::Avx2), ("aarch64, NEON", InstructionSet::Neon)]
        {
            let sizes = code_sizes::<f64>(&planning, instruction_set).expect("code");
            let [(name, size)] = sizes.as_slice() else { panic!("one function") };
            let CodeSize { instructions, spills, loads, bytes, .. } = size;
            text += &format!(
                "{robot}\t`{name}`\t{processor}\t{instructions}\t{spills}\t{loads}\t{bytes}\n"
            );
        }
    }
    let path = root.join("docs/data/machine-code.tsv");
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        assert_eq!(sets, INSTRUCTION_SETS, "only a processor with AVX-512 updates the table");
        let head = "# command: UPDATE_SNAPSHOTS=1 cargo test -p modyn-jit --test code_size\n\
                    robot\tfunction\tinstruction set\tvalues alive\tinstructions\tof which spills\t\
                    of which loads\tbytes of code\n";
        std::fs::write(path, format!("{head}{}\n", lines.join("\n"))).expect("writes");
        return;
    }
    let expected = std::fs::read_to_string(path).expect("docs/data/machine-code.tsv");
    let of_sets = |line: &&str| sets.iter().any(|set| line.contains(&format!("\t`{set:?}`\t")));
    let expected: Vec<&str> = expected.lines().filter(of_sets).collect();
    assert_eq!(expected, lines, "counts have changed; the table's first line has the command");
}
