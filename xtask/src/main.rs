//! Tasks of the repository.
//!
//! ```console
//! cargo xtask pages           # writes the pages and files that follow from the compiler's tables and from docs/data
//! cargo xtask pages --check   # writes nothing: fails where a file differs, and names its first differing line
//! cargo xtask style           # fails if the library has more lines of a kind that is hard to read than before
//! cargo xtask style --write   # enters the present counts
//! ```

mod pages;
mod style;

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let faults = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["pages"] => pages::run(false),
        ["pages", "--check"] => pages::run(true),
        ["style"] => style::run(false),
        ["style", "--write"] => style::run(true),
        _ => {
            eprintln!("usage: cargo xtask pages [--check], or cargo xtask style [--write]");
            return ExitCode::from(2);
        }
    };
    for fault in &faults {
        eprintln!("{fault}");
    }
    if faults.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
