//! Measured and counted tables: pages show what the files in `docs/data` hold, and counts are the compiler's.
//!
//! A page marks a table, or a number within a sentence, with `<!-- data: NAME -->` and `<!-- end -->`. With the variable
//! `UPDATE_SNAPSHOTS`, the text between the marks is written, and `docs/data/operations.tsv` is counted anew. Times come
//! from the commands that the files name; each writes its file (`lab/record`).

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use modyn_codegen::{Base, Builder, Function};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn updating() -> bool {
    std::env::var_os("UPDATE_SNAPSHOTS").is_some()
}

fn read(path: &Path) -> String {
    let text = std::fs::read_to_string(path);
    text.unwrap_or_else(|error| panic!("{}: {error}", path.display())).replace("\r\n", "\n")
}

/// A file of `docs/data`: lines `# key: value`, a line with the columns' titles, and rows; cells end with tabs.
struct Data {
    name: String,
    notes: Vec<(String, String)>,
    titles: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Data {
    fn load(name: &str) -> Self {
        let text = read(&root().join(format!("docs/data/{name}.tsv")));
        let note = |line: &str| {
            let (key, value) = line.strip_prefix("# ")?.split_once(": ")?;
            Some((key.to_owned(), value.to_owned()))
        };
        let cells = |line: &str| line.split('\t').map(String::from).collect::<Vec<_>>();
        let mut lines = text.lines().filter(|line| !line.starts_with('#')).map(cells);
        let titles = lines.next().unwrap_or_else(|| panic!("{name} is empty"));
        let rows: Vec<Vec<String>> = lines.collect();
        assert!(!rows.is_empty(), "{name} has no rows");
        for row in &rows {
            assert_eq!(row.len(), titles.len(), "{name}: {row:?}");
        }
        Self { name: name.into(), notes: text.lines().filter_map(note).collect(), titles, rows }
    }

    fn column(&self, title: &str) -> usize {
        let found = self.titles.iter().position(|one| one == title);
        found.unwrap_or_else(|| panic!("{} has no column {title:?}", self.name))
    }

    /// The cell of column `title` in the row whose first cells are `key`.
    fn find(&self, key: &[&str], title: &str) -> Option<&str> {
        let row =
            self.rows.iter().find(|row| row.iter().zip(key).all(|(cell, key)| cell == key))?;
        Some(&row[self.column(title)])
    }

    fn number(&self, key: &[&str], title: &str) -> f64 {
        let cell = self.find(key, title).unwrap_or_else(|| panic!("{}: no {key:?}", self.name));
        cell.parse().unwrap_or_else(|_| panic!("{}: {cell:?} of {key:?}", self.name))
    }

    fn note(&self, key: &str) -> &str {
        let found = self.notes.iter().find(|(one, _)| one == key);
        &found.unwrap_or_else(|| panic!("{} does not state its {key}", self.name)).1
    }

    /// Returns a sentence that says how the table was computed, or how and when it was measured.
    fn source(&self) -> String {
        if !self.notes.iter().any(|(key, _)| key == "date") {
            return format!(
                "Computed by `{}`; the numbers are the same on every machine.",
                self.note("command")
            );
        }
        let note = self.notes.iter().find(|(key, _)| key == "note");
        let note = note.map_or(String::new(), |(_, note)| format!(" ({note})"));
        let [command, date, commit] = ["command", "date", "commit"].map(|key| self.note(key));
        format!("Measured on {date} at commit `{commit}` by `{command}`{note}.")
    }
}

/// A table in Markdown.
fn table<'a>(titles: &[impl AsRef<str>], rows: impl IntoIterator<Item = &'a [String]>) -> String {
    let titles: Vec<&str> = titles.iter().map(AsRef::as_ref).collect();
    let mut text = format!("| {} |\n|{}\n", titles.join(" | "), "---|".repeat(titles.len()));
    for row in rows {
        let _ = writeln!(text, "| {} |", row.join(" | "));
    }
    text.replace("|  |", "| |").replace("|  |", "| |")
}

/// The robots that operations are counted for: the file in `robots/`, the base, the name in measurements of speed, and
/// the robot that the description is modelled on.
const ROBOTS: [(&str, Base, &str, &str); 6] = [
    ("arm6", Base::Fixed, "ur5", "UR5"),
    ("arm7", Base::Fixed, "panda", "Panda"),
    ("quadruped", Base::Fixed, "solo12", "Solo12"),
    ("quadruped", Base::Floating, "solo12_ff", "Solo12, floating base"),
    ("humanoid", Base::Fixed, "g1", "G1"),
    ("humanoid", Base::Floating, "g1_ff", "G1, floating base"),
];

/// The functions that are counted for all robots. (The fixed ones have all functions.)
const MAIN: [Function; 17] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::BiasForces,
    Function::MassMatrix,
    Function::Brge,
    Function::InverseDynamicsDerivatives,
    Function::ForwardDynamicsDerivatives,
    Function::InverseDynamicsVjp,
    Function::InverseDynamicsJvp,
    Function::ForwardDynamicsVjp,
    Function::ForwardDynamicsJvp,
    Function::InverseDynamicsHessian,
    Function::ForwardDynamicsHessian,
    Function::StepSemiImplicitHessian,
    Function::StepRk4,
    Function::StepImplicitMidpoint,
    Function::StepImplicitMidpointDerivatives,
];

/// The operations of each robot and function, as the file has them.
fn counted() -> String {
    let mut text = String::from(
        "# command: UPDATE_SNAPSHOTS=1 cargo test -p modyn-codegen data::\n\
         robot\tbase\tfunction\toperations\tin lanes\n",
    );
    for (robot, base, ..) in ROBOTS {
        let functions: Vec<Function> = match base {
            Base::Fixed => {
                Function::ALL.iter().copied().filter(|f| !f.is_of_constraints()).collect()
            }
            _ => MAIN.to_vec(),
        };
        let path = root().join(format!("robots/{robot}.urdf"));
        // All functions of a humanoid together are longer than a text may be.
        let generate = |functions: &[Function]| {
            let builder = Builder::new().urdf(&path).base(base);
            let generated = builder.functions(functions.iter().copied()).generate();
            generated.unwrap_or_else(|found| panic!("{robot}: {found}"))
        };
        let most = if base == Base::Fixed { 8 } else { 4 };
        let generated: Vec<_> = functions.chunks(most).map(generate).collect();
        let base = if base == Base::Fixed { "fixed" } else { "floating" };
        for (name, operations) in generated.iter().flat_map(|generated| &generated.operations) {
            let scalar = operations.total();
            let mut all = generated.iter().flat_map(|generated| &generated.static_operations);
            let all = all.find(|(one, _)| one == name);
            let all = all.map_or(scalar, |(_, all)| all.total());
            // A function of one state may have a second program, on vectors.
            let one = MAIN.iter().any(|function| function.name() == *name);
            let lanes = all.checked_sub(scalar).filter(|&lanes| one && lanes > 0 && lanes < scalar);
            let lanes = lanes.map_or(String::new(), |lanes| lanes.to_string());
            let _ = writeln!(text, "{robot}\t{base}\t{name}\t{scalar}\t{lanes}");
        }
    }
    text
}

#[test]
fn operations_are_the_compilers() {
    let path = root().join("docs/data/operations.tsv");
    let found = counted();
    if updating() {
        std::fs::write(&path, found).expect("writes");
        return;
    }
    let expected = read(&path);
    let differing = expected.lines().zip(found.lines()).find(|(a, b)| a != b);
    assert_eq!(expected, found, "operations have changed, first {differing:?}");
}

/// The gradient of forward dynamics takes at most 2.65 times the operations of forward dynamics, for each robot.
#[test]
fn gradients_cost_at_most_2_65_functions() {
    let data = Data::load("operations");
    for robot in ROBOTS {
        let count = |function| data.number(&key(robot, function), "operations");
        let [one, vjp] = ["forward_dynamics", "forward_dynamics_vjp"].map(count);
        assert!(vjp <= 2.65 * one, "{}: {vjp} operations instead of {one}", name(robot));
    }
}

fn name((robot, base, _, of): (&str, Base, &str, &str)) -> String {
    let floating = if base == Base::Floating { ", floating" } else { "" };
    format!("`{robot}`{floating} ({})", of.trim_end_matches(", floating base"))
}

fn key<'a>((robot, base, ..): (&'a str, Base, &str, &str), function: &'a str) -> [&'a str; 3] {
    [robot, if base == Base::Fixed { "fixed" } else { "floating" }, function]
}

/// Robots by functions; with the operations in lanes in brackets if `lanes`.
fn operations(functions: &[(&str, &str)], lanes: bool) -> String {
    let data = Data::load("operations");
    let mut titles = vec!["robot"];
    titles.extend(functions.iter().map(|(title, _)| *title));
    let row = |robot: (&str, Base, &str, &str)| {
        let cell = |(_, function): &(&str, &str)| {
            let key = key(robot, function);
            let count = data.find(&key, "operations").expect("counted").to_owned();
            match data.find(&key, "in lanes") {
                Some(in_lanes) if lanes && !in_lanes.is_empty() => format!("{count} ({in_lanes})"),
                _ => count,
            }
        };
        [vec![name(robot)], functions.iter().map(cell).collect()].concat()
    };
    let rows: Vec<Vec<String>> = ROBOTS.iter().map(|robot| row(*robot)).collect();
    table(&titles, rows.iter().map(Vec::as_slice))
}

/// Robots by functions under their names, with the operations in lanes in brackets.
fn by_name(functions: &[&str]) -> String {
    let titles: Vec<String> = functions.iter().map(|function| format!("`{function}`")).collect();
    let titled = titles.iter().map(String::as_str).zip(functions.iter().copied());
    operations(&titled.collect::<Vec<_>>(), true)
}

/// modyn's operations beside CasADi's instructions.
fn beside_casadi() -> String {
    let (own, casadi) = (Data::load("operations"), Data::load("casadi"));
    let functions =
        ["forward_dynamics", "inverse_dynamics", "mass_matrix", "forward_dynamics_derivatives"];
    let mut titles = vec![String::from("robot")];
    for function in functions {
        titles.push(format!("{}: modyn", function.replace('_', " ")));
        titles.push("CasADi".into());
    }
    let mut rows = Vec::new();
    for robot in ROBOTS {
        let mut row = vec![name(robot)];
        let theirs = functions.map(|function| casadi.find(&[function, robot.2], "instructions"));
        if theirs.iter().all(Option::is_none) {
            continue;
        }
        for (function, theirs) in functions.into_iter().zip(theirs) {
            let key = key(robot, function);
            let [count, lanes] =
                ["operations", "in lanes"].map(|title| own.find(&key, title).expect("counted"));
            row.push(if lanes.is_empty() { count.into() } else { format!("{count} ({lanes})") });
            row.push(theirs.unwrap_or_default().into());
        }
        rows.push(row);
    }
    table(&titles, rows.iter().map(Vec::as_slice))
}

/// The derivatives in closed form beside those by tangents.
fn beside_tangents() -> String {
    let (own, tangents) = (Data::load("operations"), Data::load("tangents"));
    let titles = [
        "robot",
        "derivatives of inverse dynamics, closed form",
        "by tangents",
        "derivatives of forward dynamics, closed form",
        "by tangents of the inverse dynamics",
    ];
    let row = |robot: (&str, Base, &str, &str)| {
        let own = |function| own.find(&key(robot, function), "operations").expect("counted").into();
        let by_tangents = |title| tangents.find(&[robot.2], title).expect("counted").into();
        vec![
            name(robot),
            own("inverse_dynamics_derivatives"),
            by_tangents("derivatives of inverse dynamics"),
            own("forward_dynamics_derivatives"),
            by_tangents("derivatives of forward dynamics"),
        ]
    };
    let rows: Vec<Vec<String>> = ROBOTS.iter().map(|robot| row(*robot)).collect();
    table(&titles, rows.iter().map(Vec::as_slice))
}

/// The time of each function's compilation, with its operations.
fn functions() -> String {
    let (times, own) = (Data::load("functions"), Data::load("operations"));
    let mut titles = times.titles.clone();
    titles.insert(2, "operations".into());
    let row = |row: &Vec<String>| {
        let function = row[1].trim_matches('`');
        let operations = own.find(&[&row[0], "fixed", function], "operations");
        let operations =
            operations.unwrap_or_else(|| panic!("{function} of {} is not counted", row[0]));
        let mut row = row.clone();
        row.insert(2, operations.into());
        row
    };
    let rows: Vec<Vec<String>> = times.rows.iter().map(row).collect();
    table(&titles, rows.iter().map(Vec::as_slice)) + "\n" + &times.source() + "\n"
}

/// A ratio of times, to two digits.
fn ratio(ratio: f64) -> String {
    if ratio >= 9.95 { format!("{ratio:.0}") } else { format!("{ratio:.1}") }
}

/// Times by robot and program, the ratio to the program `reference` in brackets, then the fastest of a program's variants.
fn speed(file: &str, reference: &str) -> String {
    let data = Data::load(file);
    let mut programs: Vec<&str> = Vec::new();
    let mut cases: Vec<[&str; 2]> = Vec::new();
    for row in &data.rows {
        let (case, program) = ([row[0].as_str(), row[1].as_str()], row[2].as_str());
        if !programs.contains(&program) {
            programs.push(program);
        }
        if !cases.contains(&case) {
            cases.push(case);
        }
    }
    let mut titles = vec!["quantity", "robot"];
    titles.extend(&programs);
    let rows: Vec<Vec<String>> = cases
        .into_iter()
        .map(|[quantity, robot]| {
            let own = data.number(&[quantity, robot, reference], "ns");
            let cell = |program: &&str| {
                let key = [quantity, robot, program];
                let Some(ns) = data.find(&key, "ns") else { return String::new() };
                let Ok(value) = ns.parse::<f64>() else { return ns.into() };
                let variant = data.find(&key, "variant").unwrap_or_default();
                let times = if *program == reference {
                    String::new()
                } else {
                    format!(" ({}x)", ratio(value / own))
                };
                format!("{ns}{times} {variant}").trim_end().into()
            };
            let mut row = vec![quantity.into(), robot.into()];
            row.extend(programs.iter().map(cell));
            row
        })
        .collect();
    table(&titles, rows.iter().map(Vec::as_slice)) + "\n" + &data.source() + "\n"
}

/// The README's table.
fn speed_in_short() -> String {
    let data = Data::load("speed");
    let robots = [
        ("ur5", "UR5, 6 joints"),
        ("panda", "Panda, 7 joints"),
        ("solo12_ff", "Solo12 quadruped, floating, 18"),
        ("g1", "G1 humanoid, 29 joints"),
        ("g1_ff", "G1 humanoid, floating, 35"),
    ];
    let cell = |quantity: &str, robot: &str| {
        let ns = |program| data.find(&[quantity, robot, program], "ns")?.parse::<f64>().ok();
        let own = ns("modyn native")?;
        let [casadi, pinocchio] =
            ["CasADi C", "Pinocchio C++"].map(|program| Some(ratio(ns(program)? / own)));
        Some(format!("{own:.0} ns (CasADi {}x, Pinocchio {}x)", casadi?, pinocchio?))
    };
    let row = |(robot, title): (&str, &str)| {
        let quantities = ["forward dynamics", "forward dynamics derivatives"];
        let cells =
            quantities.map(|quantity| cell(quantity, robot).unwrap_or("not measured".into()));
        vec![title.into(), cells[0].clone(), cells[1].clone()]
    };
    let rows = robots.map(row);
    table(&["robot", "forward dynamics", "its derivatives"], rows.iter().map(Vec::as_slice))
}

/// The least and the largest of numbers, as text.
fn range(numbers: impl IntoIterator<Item = f64>) -> String {
    let (low, high) =
        numbers.into_iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
    assert!(low <= high);
    if low.round() == high.round() { format!("{low:.0}") } else { format!("{low:.0} to {high:.0}") }
}

/// The interpreter's times over those of generated code.
fn interpreter() -> String {
    let data = Data::load("speed");
    let slow = data.rows.iter().filter(|row| row[2] == "modyn interpreter");
    range(slow.map(|row| {
        let key = [row[0].as_str(), &row[1], "modyn native"];
        row[3].parse::<f64>().expect("a time") / data.number(&key, "ns")
    }))
}

/// Batches' times over those of single calls.
fn batched(robot: &str) -> String {
    let data = Data::load("speed");
    let ns = |program| data.number(&["forward dynamics", robot, program], "ns");
    format!("{:.2}", ns("modyn batch") / ns("modyn native"))
}

/// Pairs of rows of the firmware's table, as numbers of column `title`: those that `pick` names, over those it is
/// compared with.
fn firmware(title: &str, pairs: impl Fn(&[String]) -> Option<[String; 4]>) -> Vec<f64> {
    let data = Data::load("firmware");
    let value = |row: &[String]| {
        row[data.column(title)].trim_end_matches('*').parse::<f64>().expect("a number")
    };
    let pair = |row: &Vec<String>| {
        let key = pairs(row)?;
        let key = key.each_ref().map(String::as_str);
        let other = data.rows.iter().find(|row| row.iter().zip(key).all(|(a, b)| a == b))?;
        Some(value(row) / value(other))
    };
    let found: Vec<f64> = data.rows.iter().filter_map(pair).collect();
    assert!(found.len() > 1, "{title}: {found:?}");
    found
}

/// The row of the same limbs one by one, for a row of shared limbs at opt-level 3 on a core that has the scalar.
fn shared(row: &[String]) -> Option<[String; 4]> {
    let function =
        row[3].strip_prefix("`legs_shared::").filter(|name| name.ends_with("_dynamics`"))?;
    (row[2] == "3" && (row[1] == "f32" || row[0] == "M7"))
        .then(|| [row[0].clone(), row[1].clone(), row[2].clone(), format!("`legs::{function}")])
}

/// The row of the Rust function, for a row of the same function in C at opt-level 3 on a core that has the scalar.
fn rust(row: &[String]) -> Option<[String; 4]> {
    let function = row[3].strip_prefix("`arm7_c::")?;
    (row[2] == "3" && (row[1] == "f32" || row[0] == "M7"))
        .then(|| [row[0].clone(), row[1].clone(), row[2].clone(), format!("`arm7::{function}")])
}

/// The row at opt-level 3, for a row at "s".
fn at_three(row: &[String]) -> Option<[String; 4]> {
    (row[2] == "s" && row[3] == "`arm7::forward_dynamics`")
        .then(|| [row[0].clone(), row[1].clone(), "3".into(), row[3].clone()])
}

/// The row in `f32` for one in `f64`, on a core that computes `f64` by software.
fn single(row: &[String]) -> Option<[String; 4]> {
    (row[0] == "M4F" && row[1] == "f64" && row[2] == "3" && row[3].ends_with("_dynamics`"))
        .then(|| [row[0].clone(), "f32".into(), "3".into(), row[3].clone()])
}

/// An estimate of the speed of a kernel on an H200.
struct H200 {
    /// The threads that the processor has at a time.
    threads: usize,
    /// The time of a state, or of a step of a rollout, if all instructions of a thread run at the full rate.
    nanoseconds: f64,
    /// The sum behind the time.
    sum: String,
}

/// Estimates the speed of a kernel of the table `cuda`, by NVIDIA's data sheet of the H200.
fn h200(robot: &str, kernel: &str, scalar: &str) -> H200 {
    const MULTIPROCESSORS: usize = 132;
    const REGISTERS: usize = 65_536;
    const MAX_WARPS: usize = 64;
    const GIGAHERTZ: f64 = 1.98;
    // A block has 4 warps of 32 threads; a warp's registers are given out in units of 8 a thread.
    let (warps_of_block, warp) = (4, 32);
    let data = Data::load("cuda");
    let key = [robot, kernel, scalar, "sm_90"];
    let registers = (data.number(&key, "registers") as usize).next_multiple_of(8);
    let instructions = data.number(&key, "instructions");
    let blocks = REGISTERS / (registers * warp * warps_of_block);
    let threads = MULTIPROCESSORS * warp * (blocks * warps_of_block).min(MAX_WARPS);
    let lanes = if scalar == "f32" { 128.0 } else { 64.0 };
    let nanoseconds = instructions / (MULTIPROCESSORS as f64 * lanes * GIGAHERTZ);
    let sum = format!(
        "{instructions} instructions / ({MULTIPROCESSORS} * {lanes} * {GIGAHERTZ} GHz) = {nanoseconds:.3} ns a state"
    );
    H200 { threads, nanoseconds, sum }
}

/// The estimates for the kernels of the table `cuda`.
fn cuda_estimates() -> String {
    let data = Data::load("cuda");
    let rows = data.rows.iter().filter(|row| row[data.column("architecture")] == "sm_90");
    let rows: Vec<Vec<String>> = rows
        .map(|row| {
            let estimate = h200(&row[0], &row[1], &row[2]);
            let time = format!("{:.2}", estimate.nanoseconds);
            [&row[..3], &[estimate.threads.to_string(), time]].concat()
        })
        .collect();
    let titles = [
        "robot",
        "kernel",
        "scalar",
        "threads at a time",
        "estimate, ns a state (of a rollout: a step)",
    ];
    table(&titles, rows.iter().map(Vec::as_slice))
        + "\nEstimated from the table `docs/data/cuda.tsv`.\n"
}

/// From how many states on the kernels of forward dynamics in `f64` are faster than batches on cores of a processor, by the
/// estimates for the kernels and the batch times of the table `speed`.
fn cuda_crossover() -> String {
    /// The time to start a kernel and to wait for it, ns.
    const START: f64 = 10_000.0;
    /// The bytes of a copy in a nanosecond: PCI Express 5 with 16 lanes.
    const BYTES: f64 = 63.0;
    const CORES: f64 = 16.0;
    let speed = Data::load("speed");
    let robots = [
        ("Panda", "panda", "panda", Base::Fixed),
        ("Solo12, floating base", "solo12_ff", "solo12", Base::Floating),
        ("G1", "g1", "g1", Base::Fixed),
    ];
    let rows: Vec<Vec<String>> = robots
        .into_iter()
        .map(|(title, measured, file, base)| {
            let kernel = h200(title, "`forward_dynamics`", "f64").nanoseconds;
            let core = speed.number(&["forward dynamics", measured, "modyn batch"], "ns");
            let file = root().join(format!("tests/golden/{file}.urdf"));
            let model = Builder::new().urdf(file).base(base).plan().expect("a robot").model;
            // The arguments and the result.
            let copies = 8.0 * (model.nq() + 3 * model.nv()) as f64 / BYTES;
            let from = |core: f64, state: f64| match core - state {
                gain if gain > 0.0 => format!("{:.0}", (START / gain / 100.0).ceil() * 100.0),
                _ => "never".into(),
            };
            vec![
                title.into(),
                format!("{core}"),
                format!("{kernel:.2}"),
                from(core, kernel),
                from(core / CORES, kernel),
                format!("{copies:.1}"),
                from(core, kernel + copies),
                from(core / CORES, kernel + copies),
            ]
        })
        .collect();
    let titles = [
        "robot",
        "one core, ns a state (measured)",
        "kernel, ns a state",
        "faster than one core from",
        "than 16 cores from",
        "copies, ns a state",
        "with copies, than one core from",
        "with copies, than 16 cores from",
    ];
    let date = format!("{} of {}", speed.note("command"), speed.note("date"));
    table(&titles, rows.iter().map(Vec::as_slice))
        + &format!(
            "\nEstimated from the tables `docs/data/cuda.tsv` and `docs/data/speed.tsv` (`{date}`).\n"
        )
}

/// The rows of the firmware's table that its page shows.
fn firmware_in_short() -> String {
    const SHOWN: [&str; 8] = [
        "leg::forward_dynamics",
        "arm7::brge_solve",
        "arm7::mass_matrix",
        "arm7::forward_dynamics",
        "arm7::inverse_dynamics",
        "arm7_c::forward_dynamics",
        "legs::forward_dynamics",
        "legs_shared::forward_dynamics",
    ];
    let data = Data::load("firmware");
    let shown = |row: &&Vec<String>| {
        let function = row[3].trim_matches('`');
        SHOWN.contains(&function) && (row[2] == "3" || function == "arm7::forward_dynamics")
    };
    let mut rows: Vec<&[String]> = data.rows.iter().filter(shown).map(Vec::as_slice).collect();
    let place = |row: &[String]| SHOWN.iter().position(|name| row[3].trim_matches('`') == *name);
    let core = |row: &[String]| data.rows.iter().position(|one| one[..3] == row[..3]);
    rows.sort_by_key(|row| (core(row), place(row)));
    table(&data.titles, rows) + "\n" + &data.source() + "\n"
}

/// The rows of the table of machine code that its page shows: forward dynamics and its derivatives.
fn machine_code_in_short() -> String {
    let data = Data::load("machine-code");
    let shown = data.rows.iter().filter(|row| row[1].starts_with("`forward_dynamics"));
    table(&data.titles, shown.map(Vec::as_slice)) + "\n" + &data.source() + "\n"
}

/// Counts of the real robots, as part of a sentence.
fn robots_in_short() -> String {
    let data = Data::load("robots");
    let (check, differences) =
        (data.column("`modyn check`"), data.column("mass matrix, Pinocchio"));
    let count =
        |accepts: &dyn Fn(&[String]) -> bool| data.rows.iter().filter(|row| accepts(row)).count();
    let all = data.rows.len();
    let usable = count(&|row| row[check].starts_with("usable"));
    let with_option = count(&|row| row[check].starts_with("refused; usable"));
    let loaded = count(&|row| row[differences] != "does not load");
    let compared =
        |row: &[String]| !["loads", "does not load"].contains(&row[differences].as_str());
    let agreeing = |row: &[String]| row[differences..].iter().all(|cell| !cell.contains("DIFFERS"));
    let [both, agree] = [count(&compared), count(&|row| compared(row) && agreeing(row))];
    format!(
        "{all} descriptions of real robots. {usable} of them are usable as they are, {with_option} with an option, and \
         {} are refused. Pinocchio loads {loaded}; {both} of these were computed by both, and {agree} agree",
        all - usable - with_option
    )
}

/// The quotient of the numbers in a column of two rows, `file; row; row; column`.
fn quotient(place: &str) -> f64 {
    let place: Vec<&str> = place.split("; ").collect();
    let [file, row, other, column] = place[..] else { panic!("{place:?}") };
    let data = Data::load(file);
    data.number(&[row], column) / data.number(&[other], column)
}

/// The text of the mark `name`.
fn rendered(name: &str) -> String {
    let per_cent = |numbers: Vec<f64>| numbers.into_iter().map(|x| 100.0 * x).collect::<Vec<_>>();
    match name {
        "speed" | "speed-cold" | "contacts-speed" | "contacts-speed-cold" => {
            speed(name, "modyn native")
        }
        "speed-of-c" => speed(name, "modyn, limbs one by one"),
        "speed-in-short" => speed_in_short(),
        "interpreter" => interpreter(),
        "batched-ur5" => batched("ur5"),
        "batched-panda" => batched("panda"),
        "functions" => functions(),
        "operations" => operations(
            &[
                ("forward dynamics", "forward_dynamics"),
                ("inverse dynamics", "inverse_dynamics"),
                ("mass matrix", "mass_matrix"),
                ("U D U^T", "brge"),
                ("derivatives of forward dynamics", "forward_dynamics_derivatives"),
            ],
            false,
        ),
        "operations-in-lanes" => operations(
            &[
                ("forward dynamics", "forward_dynamics"),
                ("inverse dynamics", "inverse_dynamics"),
                ("mass matrix", "mass_matrix"),
                ("derivatives of inverse dynamics", "inverse_dynamics_derivatives"),
                ("derivatives of forward dynamics", "forward_dynamics_derivatives"),
            ],
            true,
        ),
        "adjoints" => by_name(&[
            "inverse_dynamics",
            "inverse_dynamics_vjp",
            "inverse_dynamics_jvp",
            "forward_dynamics",
            "forward_dynamics_vjp",
            "forward_dynamics_jvp",
        ]),
        "hessians" => by_name(&["inverse_dynamics_hessian", "forward_dynamics_hessian"]),
        "step-hessians" => by_name(&["forward_dynamics_hessian", "step_semi_implicit_hessian"]),
        "steps" => {
            by_name(&["step_rk4", "step_implicit_midpoint", "step_implicit_midpoint_derivatives"])
        }
        "casadi" => beside_casadi(),
        "robots-in-short" => robots_in_short(),
        "tangents" => beside_tangents(),
        "cuda-sum" => h200("Panda", "`forward_dynamics`", "f32").sum,
        "cuda-estimates" => cuda_estimates(),
        "cuda-crossover" => cuda_crossover(),
        "firmware" => firmware_in_short(),
        "machine-code" => machine_code_in_short(),
        "f64-by-software" => range(firmware("instructions", single)),
        "shared-flash" => range(per_cent(firmware("flash, with callees", shared))),
        "shared-instructions" => {
            range(per_cent(firmware("instructions", shared)).into_iter().map(|x| 100.0 - x))
        }
        "c-instructions" => range(per_cent(firmware("instructions", rust))),
        "c-flash" => range(per_cent(firmware("flash, with callees", rust))),
        "small-flash" => range(
            per_cent(firmware("flash, with callees", at_three)).into_iter().map(|x| 100.0 - x),
        ),
        "small-instructions" => {
            range(per_cent(firmware("instructions", at_three)).into_iter().map(|x| x - 100.0))
        }
        _ if name.starts_with("ratio ") => ratio(quotient(&name["ratio ".len()..])),
        _ if name.starts_with("increase ") => {
            format!("{:.0}", 100.0 * (quotient(&name["increase ".len()..]) - 1.0))
        }
        _ => {
            let data = Data::load(name);
            table(&data.titles, data.rows.iter().map(Vec::as_slice)) + "\n" + &data.source() + "\n"
        }
    }
}

const BEGIN: &str = "<!-- data: ";
const END: &str = "<!-- end -->";

/// The page with the text of each mark rendered, and the names of the marks.
fn page(text: &str) -> (String, Vec<String>) {
    let (mut out, mut names, mut rest) = (String::new(), Vec::new(), text);
    while let Some((before, after)) = rest.split_once(BEGIN) {
        let (name, after) = after.split_once(" -->").expect("the mark ends");
        let (old, after) = after.split_once(END).unwrap_or_else(|| panic!("{name} has no end"));
        let line = if old.starts_with('\n') { "\n" } else { "" };
        // A comment at the beginning of a line would end the paragraph.
        let begins = before.trim_end_matches(' ').ends_with('\n');
        assert!(!line.is_empty() || !begins, "{name} begins a line within a sentence");
        out += &[before, BEGIN, name, " -->", line, &rendered(name), END].concat();
        names.push(name.into());
        rest = after;
    }
    (out + rest, names)
}

#[test]
fn pages_show_the_data() {
    let mut pages = vec![root().join("README.md")];
    for entry in std::fs::read_dir(root().join("docs")).expect("docs") {
        pages.push(entry.expect("an entry").path());
    }
    pages.retain(|path| path.extension().is_some_and(|ending| ending == "md"));
    let mut shown = BTreeSet::new();
    for path in pages {
        let text = read(&path);
        let (expected, names) = page(&text);
        shown.extend(names);
        if updating() {
            if expected != text {
                std::fs::write(&path, expected).expect("writes");
            }
            continue;
        }
        let differing = text.lines().zip(expected.lines()).find(|(a, b)| a != b);
        assert!(
            expected == text,
            "{} does not show the data, first {differing:?}: UPDATE_SNAPSHOTS=1 cargo test -p modyn-codegen data::",
            path.display()
        );
    }
    // No file is forgotten: each is shown by itself or through a table that is made of it.
    let through = ["operations", "speed", "firmware", "functions", "casadi", "tangents"];
    for entry in std::fs::read_dir(root().join("docs/data")).expect("docs/data") {
        let path = entry.expect("an entry").path();
        let name = path.file_stem().and_then(|name| name.to_str()).expect("a name").to_owned();
        assert!(shown.contains(&name) || through.contains(&name.as_str()), "no page shows {name}");
    }
    assert!(shown.len() > 15, "{shown:?}");
}
