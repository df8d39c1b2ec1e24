//! The command `modyn`; all of it is in the library.

fn main() -> std::process::ExitCode {
    modyn_cli::run()
}
