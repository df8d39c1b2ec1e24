//! Self-contained Rust, called from C through the functions that it exports.

use std::path::Path;
use std::process::Command;

use crate::suite::{Arithmetic, BackEnd, Call, Subject, command};
use modyn_codegen::plan::{CForm, Planned, Shape};
use modyn_codegen::{Builder, Target};

use super::c::{driver, execute};

pub struct Rust;

impl BackEnd for Rust {
    const TARGET: Target = Target::Rust;
    const ARITHMETIC: Arithmetic = Arithmetic::Separate;

    fn name(&self) -> String {
        "rust".into()
    }

    /// Exported functions have the described parameters.
    fn has(&self, planned: &Planned) -> bool {
        planned.c_form == CForm::SourceAndExport && planned.parameters == 0
    }

    fn configure(&self, builder: Builder) -> Builder {
        builder.type_name("Ours").self_contained().c_functions("ours")
    }

    fn run(&self, subject: &Subject, folder: &Path) -> Vec<Vec<f64>> {
        for file in &subject.emitted.files {
            std::fs::write(folder.join(&file.name), &file.text).expect("writes");
        }
        let mut rustc = Command::new(std::env::var_os("RUSTC").unwrap_or("rustc".into()));
        rustc.args(["--edition=2024", "--crate-type=staticlib", "--crate-name=ours", "ours.rs"]);
        rustc.args(["-C", "opt-level=0", "-C", "panic=abort", "--cap-lints=allow"]);
        command(rustc.current_dir(folder));
        let call = |call: &Call, arguments: &str| {
            let (name, arguments_alone) = (&call.function, arguments.trim_end_matches(", "));
            match (&call.shape, call.link) {
                (Shape::Scalar, _) => format!("x[0] = ours_{name}({arguments_alone});"),
                (_, Some(link)) => format!("if (!ours_{name}({arguments}{link}, x)) return 1;"),
                (_, None) => format!("ours_{name}({arguments}x);"),
            }
        };
        let text = driver(subject, "#include \"ours.h\"\n", call);
        std::fs::write(folder.join("main.c"), text).expect("writes");
        let mut gcc = Command::new("gcc");
        gcc.args(["-std=c99", "main.c", "-o", "main", "-L.", "-lours", "-lpthread", "-ldl", "-lm"]);
        command(gcc.current_dir(folder));
        execute(subject, folder, &["./main"])
    }
}
