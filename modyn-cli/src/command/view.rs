//! `modyn view`: shows a robot in a browser, with sliders of its joints, or motions beside each
//! other.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use clap::Args;
use modyn_codegen::diagnostics::{Diagnostics, sanitize_for_display};
use modyn_codegen::{ReadOptions, Shapes};
use modyn_runtime::model::Model;

use crate::command::outcome::{Failure, to_file, to_stderr};
use crate::command::robot::Robot;
use crate::viewer::{Motion, Scene};

/// Show a robot in a browser: its shapes, sliders of its joints, frames, masses
///
/// The page is one file, which needs no network. The exit code is 1 if the description is rejected.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    robot: Robot,
    /// Write the page to this file, instead of opening it
    #[arg(short, long, value_name = "FILE.html")]
    output: Option<PathBuf>,
    /// Show this motion, a table that `simulate --csv` wrote; several motions are shown beside each
    /// other
    #[arg(long, value_name = "FILE.csv")]
    motion: Vec<PathBuf>,
}

/// The largest number of shapes that could not be read which are named.
const MAX_NOTES: usize = 5;

/// Prints which shapes could not be read.
pub fn note_shapes(shapes: &Shapes) {
    for note in shapes.notes.iter().take(MAX_NOTES) {
        to_stderr(&format!("note: {}\n", sanitize_for_display(note)));
    }
    if let Some(more) = shapes.notes.len().checked_sub(MAX_NOTES).filter(|&more| more > 0) {
        to_stderr(&format!("note: {more} more shapes are not drawn\n"));
    }
}

/// Writes the page, and opens it unless the user named the file.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let description = arguments.robot.open()?;
    let options = arguments.robot.options.read_options();
    let read = description.read(&ReadOptions { shapes: true, ..options.clone() });
    let reading =
        read.map_err(|diagnostics| description.failure(arguments.robot.named(diagnostics)))?;
    let mut inputs = description.inputs(Some(&reading));
    inputs.extend(arguments.motion.iter().cloned());
    description.warn(arguments.robot.named(Diagnostics::new(reading.warnings)));
    note_shapes(&reading.shapes);
    let model = reading.model;
    let mut scene = Scene::new(model.name());
    let robot = scene.robot(model.clone(), reading.shapes);
    for path in &arguments.motion {
        scene.motion(motion(path, robot, &model)?);
    }
    let page = scene.page();
    if let Some(path) = &arguments.output {
        return to_file(path, &page, &inputs);
    }
    let file = tempfile::Builder::new().prefix("modyn-").suffix(".html").tempfile();
    let written = file.map_err(|error| error.to_string());
    let kept = written.and_then(|file| file.keep().map_err(|error| error.to_string()));
    let (_, path) = kept.map_err(|error| {
        Failure::usage(format!(
            "error: no temporary file can be made: {error}; name a file by `-o`"
        ))
    })?;
    to_file(&path, &page, &[])?;
    open(&path)
}

/// Opens a page in the user's browser.
fn open(path: &Path) -> Result<(), Failure> {
    let (program, first): (_, &[&str]) = match std::env::consts::OS {
        "windows" => ("cmd", &["/C", "start", ""]),
        "macos" => ("open", &[]),
        _ => ("xdg-open", &[]),
    };
    let shown = path.display();
    let done = Command::new(program).args(first).arg(path).stdout(Stdio::null()).status();
    match done {
        Ok(status) if status.success() => {
            to_stderr(&format!("the page is `{shown}`\n"));
            Ok(())
        }
        _ => Err(Failure::usage(format!(
            "error: `{program}` opens no browser: open `{shown}`, or write the page to a file by `-o FILE.html`"
        ))),
    }
}

/// Reads a motion of a robot from a table with a column for the time and one for each coordinate.
fn motion(path: &Path, robot: usize, model: &Model) -> Result<Motion, Failure> {
    let shown = sanitize_for_display(&path.display().to_string());
    let wrong = |why: String| Failure::usage(format!("error: `{shown}` {why}"));
    let mut reader =
        csv::Reader::from_path(path).map_err(|error| wrong(format!("cannot be read: {error}")))?;
    let head = reader.headers().map_err(|error| wrong(format!("has no head: {error}")))?.clone();
    let names = model.coordinate_names();
    // A column may have its unit after the name.
    let is_named = |column: &str, name: &str| {
        let column = column.trim().trim_start_matches('\'');
        column.strip_prefix(name).is_some_and(|unit| unit.is_empty() || unit.starts_with(" ("))
    };
    let column = |name: &str| {
        head.iter().position(|column| is_named(column, name)).ok_or_else(|| {
            wrong(format!(
                "has no column `{}`: `modyn simulate --csv` writes such tables, with the columns `time (s)` and all \
                 coordinates",
                sanitize_for_display(name)
            ))
        })
    };
    let time = column("time")?;
    let columns: Vec<usize> = names.iter().map(|name| column(name)).collect::<Result<_, _>>()?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut motion =
        Motion { name, robot, times: Vec::new(), coordinates: Vec::new(), forces: None };
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(|error| wrong(format!("cannot be read: {error}")))?;
        let number = |column: usize| {
            let text = record.get(column).unwrap_or_default().trim();
            text.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| {
                wrong(format!(
                    "has `{}` instead of a number in row {}",
                    sanitize_for_display(text),
                    row + 2
                ))
            })
        };
        let now = number(time)?;
        if motion.times.last().is_some_and(|&last| now < last) {
            return Err(wrong(format!(
                "has a time before that of the row above in row {}",
                row + 2
            )));
        }
        motion.times.push(now);
        motion
            .coordinates
            .push(columns.iter().map(|&column| number(column)).collect::<Result<_, _>>()?);
    }
    if motion.times.is_empty() {
        return Err(wrong("has no rows".into()));
    }
    Ok(motion)
}
