//! Prints counts of the machine code of robots: `cargo run -p modyn-jit --example sizes -- robots/arm7.urdf`.

use std::time::Instant;

use modyn_codegen::{Builder, Function};
use modyn_jit::{CodeSize, InstructionSet, code_sizes};

const FUNCTIONS: [Function; 5] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::MassMatrix,
    Function::ForwardDynamicsDerivatives,
    Function::LinkPoses,
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for file in std::env::args().skip(1) {
        let place = std::env::current_dir()?.join(&file);
        let builder = Builder::new().file(place).functions(FUNCTIONS);
        let start = Instant::now();
        let planning = builder.plan()?;
        println!("{file}: {} ms from the text to the programs", start.elapsed().as_millis());
        for instruction_set in InstructionSet::ALL {
            let start = Instant::now();
            let sizes = code_sizes::<f64>(&planning, instruction_set)?;
            println!(
                "  {instruction_set:?}: {} us from the programs to code",
                start.elapsed().as_micros()
            );
            for (name, size) in sizes {
                let CodeSize { bytes, constants, instructions, spills, loads, copies, .. } = size;
                println!(
                    "    {:30} {instructions:6} instructions, {spills:5} spills, {loads:5} loads, {copies:5} \
                     copies, {bytes:7} bytes, {constants:6} of constants",
                    name
                );
            }
        }
    }
    Ok(())
}
