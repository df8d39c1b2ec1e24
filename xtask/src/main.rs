//! Tasks of the repository.
//!
//! ```console
//! cargo xtask pages           # writes the pages and files that follow from the compiler's tables and from docs/data
//! cargo xtask pages --check   # writes nothing: fails where a file differs, and names its first differing line
//! ```

mod pages;

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let check = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["pages"] => false,
        ["pages", "--check"] => true,
        _ => {
            eprintln!("usage: cargo xtask pages [--check]");
            return ExitCode::from(2);
        }
    };
    let faults = pages::run(check);
    for fault in &faults {
        eprintln!("{fault}");
    }
    if faults.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
