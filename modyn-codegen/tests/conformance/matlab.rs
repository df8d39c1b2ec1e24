//! MATLAB's text, run by GNU Octave: all states of a function in one call, as columns.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use crate::conformance::{
    Arithmetic, BackEnd, STATES, Subject, command, read_results, write_numbers,
};
use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::plan::{Elements, Planned, Shape};
use modyn_codegen::{Builder, Emitted, Target};

pub struct Matlab;

impl BackEnd for Matlab {
    type Robot = Emitted;

    fn name(&self) -> String {
        "matlab".into()
    }

    /// Sines are the language's own.
    fn arithmetic(&self) -> Arithmetic {
        Arithmetic::Own(1e-13)
    }

    fn programs(&self) -> &[&'static str] {
        &["octave-cli"]
    }

    /// Results with constraints that depend on each other are not continuous.
    fn has(&self, planned: &Planned) -> bool {
        !planned.function.is_some_and(|function| function.row().of_constraints)
    }

    fn make(&self, builder: &Builder) -> Result<Emitted, Diagnostics> {
        builder.emit(Target::Matlab)
    }

    fn run(&self, subject: &Subject<'_, Emitted>, folder: &Path) -> Vec<Vec<f64>> {
        for file in &subject.robot.files {
            let path = folder.join(&file.name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            std::fs::write(path, &file.text).expect("writes");
        }
        let model = &subject.robot.model;
        let links: Vec<&str> = model.links().iter().map(|link| link.name.as_str()).collect();
        let links = modyn_codegen::names::fields(&links, &[]);
        let mut main = String::from("in = fopen('in', 'rb');\nout = fopen('out', 'wb');\n");
        for own in subject.calls.chunks(STATES) {
            let one = &own[0];
            let mut names: Vec<String> = Vec::new();
            for (i, argument) in one.arguments.iter().enumerate() {
                let len = argument.len();
                let _ = writeln!(main, "a{i} = fread(in, [{len}, {STATES}], 'double');");
                names.push(format!("a{i}"));
            }
            if let Some(link) = one.link {
                let at = names.len() - usize::from(one.has_parameters);
                names.insert(at, format!("'{}'", links[link]));
            }
            let _ = writeln!(main, "x = ours.{}({});", one.function, names.join(", "));
            let _ = writeln!(main, "fwrite(out, {}, 'double');", flat("x", &one.shape, true));
        }
        main += "fclose(out);\n";
        std::fs::write(folder.join("main.m"), main).expect("writes");
        // The numbers of an array of all states, a state after the other.
        let arrays = subject.calls.chunks(STATES).flat_map(|own| {
            (0..own[0].arguments.len())
                .flat_map(move |i| own.iter().flat_map(move |call| &call.arguments[i]))
        });
        write_numbers(&folder.join("in"), arrays, subject.float);
        let mut octave = Command::new("octave-cli");
        command(octave.args(["--norc", "--quiet", "--eval", "main"]).current_dir(folder));
        read_results(&folder.join("out"), &subject.calls, subject.float)
    }
}

/// Returns the numbers of a result with this layout as a matrix with a column for each state; `whole` for a function's result.
fn flat(value: &str, shape: &Shape, whole: bool) -> String {
    match shape {
        Shape::Array(of, n, Elements::Rows) if **of != Shape::Scalar => {
            let (len, columns) = (shape.len(), of.len());
            format!("reshape(permute(reshape({value}, {n}, {columns}, []), [2 1 3]), {len}, [])")
        }
        Shape::Record(record, fields) if record.result_type().is_some() => {
            let fields =
                fields.iter().map(|(name, shape)| flat(&format!("{value}.{name}"), shape, false));
            format!("[{}]", fields.collect::<Vec<String>>().join("; "))
        }
        _ if whole || *shape != Shape::Scalar => format!("reshape({value}, {}, [])", shape.len()),
        _ => value.into(),
    }
}
