//! Measures machine code that is made at run time: its calls, as a program of the comparison, and how long it takes to make.
//!
//! - `native-runner sets` prints the instruction sets of this kind of processor.
//! - `native-runner one|batch SET FOLDER ROBOT QUANTITY REPETITIONS` measures calls, as `../README.md` says.
//! - `native-runner times` prints a table of the times from a description to a result. `native-runner times-of ROBOT QUANTITY`
//!   measures one of them.

mod calls;
#[path = "../../modyn-runner/src/measure.rs"]
mod measure;
#[path = "../../modyn-runner/src/robots.rs"]
mod robots;
mod times;

use std::path::Path;

use measure::Job;
use modyn_jit::InstructionSet;

/// Returns the instruction sets of this kind of processor, which another machine may have.
fn sets() -> impl Iterator<Item = InstructionSet> {
    let arm = cfg!(target_arch = "aarch64");
    InstructionSet::ALL.into_iter().filter(move |set| (*set == InstructionSet::Neon) == arm)
}

/// Returns the robot of this name in `robots.txt`.
fn robot(name: &str) -> robots::Robot {
    let mut all = robots::all().into_iter();
    all.find(|robot| robot.name == name).unwrap_or_else(|| panic!("no robot `{name}`"))
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["sets"] => sets().for_each(|set| println!("{set:?}")),
        ["times"] => times::table(),
        ["times-of", robot, quantity] => times::one(&self::robot(robot), quantity),
        [states @ ("one" | "batch"), set, folder, robot, quantity, repetitions] => {
            let set = sets().find(|found| format!("{found:?}") == set).expect("of `sets`");
            assert!(set.is_available(), "the processor does not have it");
            let job = Job::read(Path::new(folder), robot, quantity, repetitions);
            calls::measure(&job, &self::robot(robot), set, states == "batch");
        }
        _ => panic!("see the head of src/main.rs"),
    }
}
