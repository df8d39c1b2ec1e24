//! Prints counts of the machine code of robots: `cargo run -p modyn-jit --example sizes -- robots/arm7.urdf`.

use std::time::Instant;

use modyn_codegen::{Builder, Function};
use modyn_jit::{CodeSize, Compiled, InstructionSet, Options};

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
        for instruction_set in InstructionSet::ALL
            .into_iter()
            .filter(|&instruction_set| Some(instruction_set) <= InstructionSet::detect())
        {
            let mut options = Options::default();
            options.instruction_set = Some(instruction_set);
            let start = Instant::now();
            let robot = Compiled::<f64>::from_plan(&planning, options)?;
            println!(
                "  {instruction_set:?}: {} us from the programs to code",
                start.elapsed().as_micros()
            );
            for function in robot.functions() {
                let CodeSize { bytes, constants, instructions, spills, loads, copies, .. } =
                    robot.function(function)?.size();
                println!(
                    "    {:30} {instructions:6} instructions, {spills:5} spills, {loads:5} loads, {copies:5} \
                     copies, {bytes:7} bytes, {constants:6} of constants",
                    function.name()
                );
            }
        }
    }
    Ok(())
}
