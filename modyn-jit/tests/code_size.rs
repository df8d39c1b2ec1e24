//! The counts of machine code in `docs/data/machine-code.tsv`. With the variable `UPDATE_SNAPSHOTS`, the test writes them.

use std::path::Path;

use modyn_codegen::{Builder, Function};
use modyn_jit::{CodeSize, InstructionSet, code_sizes};

/// Descriptions in `tests/golden`, the robots' names, and functions.
const ROWS: [(&str, &str, Function); 6] = [
    ("ur5", "UR5", Function::ForwardDynamics),
    ("panda", "Panda", Function::ForwardDynamics),
    ("panda", "Panda", Function::ForwardDynamicsDerivatives),
    ("solo12", "Solo12", Function::ForwardDynamics),
    ("g1", "G1", Function::ForwardDynamics),
    ("g1", "G1", Function::ForwardDynamicsDerivatives),
];

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
        std::fs::write(path, text).expect("writes");
        return;
    }
    let expected = std::fs::read_to_string(path).expect("docs/data/machine-code.tsv");
    assert_eq!(expected, text, "counts have changed; the table's first line has the command");
}
