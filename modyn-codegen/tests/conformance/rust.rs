//! Self-contained Rust, called from C through the functions that it exports.

use std::path::Path;
use std::process::Command;

use crate::conformance::c::{execute, write, write_main};
use crate::conformance::{Arithmetic, BackEnd, Call, Subject, command};
use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::plan::{CForm, Planned, Shape};
use modyn_codegen::{Builder, Emitted, Target};

pub struct Rust;

impl BackEnd for Rust {
    type Robot = Emitted;

    fn name(&self) -> String {
        "rust".into()
    }

    fn arithmetic(&self) -> Arithmetic {
        Arithmetic::Separate
    }

    fn has(&self, planned: &Planned) -> bool {
        planned.c_form == CForm::SourceAndExport
    }

    /// Exported functions have the described parameters.
    fn takes_parameters(&self) -> bool {
        false
    }

    fn make(&self, builder: &Builder) -> Result<Emitted, Diagnostics> {
        builder.clone().self_contained().c_functions("ours").emit(Target::Rust)
    }

    fn run(&self, subject: &Subject<'_, Emitted>, folder: &Path) -> Vec<Vec<f64>> {
        write(subject.robot, folder);
        let mut rustc = Command::new(std::env::var_os("RUSTC").unwrap_or("rustc".into()));
        rustc.args(["--edition=2024", "--crate-type=staticlib", "--crate-name=ours", "ours.rs"]);
        rustc.args(["-C", "opt-level=0", "-C", "panic=abort", "--cap-lints=allow"]);
        command(rustc.current_dir(folder));
        let call = |call: &Call, arguments: &str| {
            let (name, arguments_alone) = (&call.function, arguments.trim_end_matches(", "));
            match (&call.shape, call.link) {
                (Shape::Scalar, _) => format!("*(real *)x = ours_{name}({arguments_alone});"),
                (_, Some(link)) => format!("if (!ours_{name}({arguments}{link}, x)) return 1;"),
                (_, None) => format!("ours_{name}({arguments}x);"),
            }
        };
        write_main(subject, folder, call);
        let mut gcc = Command::new("gcc");
        gcc.args(["-std=c99", "main.c", "-o", "main", "-L.", "-lours", "-lpthread", "-ldl", "-lm"]);
        command(gcc.current_dir(folder));
        execute(subject, folder, &["./main"])
    }
}
