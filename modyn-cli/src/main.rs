//! The command `modyn`; its code is in the library.

fn main() -> std::process::ExitCode {
    modyn_cli::run()
}
