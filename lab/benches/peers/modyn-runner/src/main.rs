//! modyn's part in the comparison with other software.
//!
//! `modyn-runner states FOLDER` writes the states, and the interpreter's results, against which every program is
//! checked. `modyn-runner c FOLDER` writes the robots' C sources. `modyn-runner CONTENDER FOLDER ROBOT QUANTITY
//! REPETITIONS` measures.

mod c;
mod generated;
mod interpreted;
mod measure;
mod robots;
mod scalar_only;
mod states;

use std::path::Path;

use measure::Job;

/// The programs: add more here, and in `../contenders/modyn.py`.
const CONTENDERS: [(&str, fn(&Job)); 4] = [
    ("generated", generated::measure),
    ("alone", generated::measure_alone),
    ("batch", generated::measure_batch),
    ("interpreted", interpreted::measure),
];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["states", folder] => robots::all().iter().for_each(|robot| {
            states::write(robot, Path::new(folder));
        }),
        ["c", folder] => c::write(Path::new(folder)),
        [contender, folder, robot, quantity, repetitions] => {
            let (_, measure) =
                CONTENDERS.iter().find(|(name, _)| *name == contender).expect("a contender");
            measure(&Job::read(Path::new(folder), robot, quantity, repetitions));
        }
        _ => panic!("states FOLDER, c FOLDER, or CONTENDER FOLDER ROBOT QUANTITY REPETITIONS"),
    }
}
