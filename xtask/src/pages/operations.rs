//! The operations of the compiler's functions: `docs/data/operations.tsv`, and the tables of it.

use std::fmt::Write as _;

use modyn_codegen::{Base, Builder, Function};

use super::data::{Data, table};
use super::root;

/// A robot that operations are counted for.
struct Robot {
    /// The file in `robots/`.
    file: &'static str,
    base: Base,
    /// The name in measurements of speed.
    measured: &'static str,
    /// The robot that the description is modelled on.
    of: &'static str,
}

const ROBOTS: [Robot; 6] = [
    Robot { file: "arm6", base: Base::Fixed, measured: "ur5", of: "UR5" },
    Robot { file: "arm7", base: Base::Fixed, measured: "panda", of: "Panda" },
    Robot { file: "quadruped", base: Base::Fixed, measured: "solo12", of: "Solo12" },
    Robot { file: "quadruped", base: Base::Floating, measured: "solo12_ff", of: "Solo12" },
    Robot { file: "humanoid", base: Base::Fixed, measured: "g1", of: "G1" },
    Robot { file: "humanoid", base: Base::Floating, measured: "g1_ff", of: "G1" },
];

impl Robot {
    fn title(&self) -> String {
        let floating = if self.base == Base::Floating { ", floating" } else { "" };
        format!("`{}`{floating} ({})", self.file, self.of)
    }

    /// Returns the first cells of the row of a function.
    fn key<'a>(&self, function: &'a str) -> [&'a str; 3] {
        [self.file, if self.base == Base::Fixed { "fixed" } else { "floating" }, function]
    }
}

/// The functions that are counted for all robots. (The fixed ones have all functions.)
const MAIN: &str = "forward_dynamics inverse_dynamics bias_forces mass_matrix brge inverse_dynamics_derivatives \
    forward_dynamics_derivatives inverse_dynamics_vjp inverse_dynamics_jvp forward_dynamics_vjp forward_dynamics_jvp \
    inverse_dynamics_hessian forward_dynamics_hessian step_semi_implicit_hessian step_rk4 step_implicit_midpoint \
    step_implicit_midpoint_derivatives step_semi_implicit_derivatives";

/// Returns the rows of the operations of a robot's functions.
fn count(robot: &Robot) -> String {
    let is_fixed = robot.base == Base::Fixed;
    let all = Function::ALL.iter().copied().filter(|function| function.row().is_general());
    let main = MAIN.split(' ').map(|name| Function::from_name(name).expect("a function"));
    let functions: Vec<Function> = if is_fixed { all.collect() } else { main.collect() };
    let path = root(&format!("robots/{}.urdf", robot.file));
    // All functions of a humanoid together are longer than a text may be.
    let generated = functions.chunks(if is_fixed { 8 } else { 4 }).map(|functions| {
        let builder = Builder::new().urdf(&path).base(robot.base);
        let generated = builder.functions(functions.iter().copied()).generate();
        generated.unwrap_or_else(|found| panic!("{}: {found}", robot.file))
    });
    let generated: Vec<_> = generated.collect();
    let mut text = String::new();
    for (name, operations) in generated.iter().flat_map(|generated| &generated.operations) {
        let scalar = operations.total();
        // A function of one state may have a second program, on vectors.
        let one = MAIN.split(' ').any(|function| function == *name);
        let mut lanes = generated.iter().flat_map(|generated| &generated.operations_in_lanes);
        let lanes = lanes.find(|(function, _)| one && function == name);
        let lanes = lanes.map(|(_, lanes)| lanes.total()).filter(|&lanes| lanes < scalar);
        let lanes = lanes.map_or(String::new(), |lanes| lanes.to_string());
        let _ = writeln!(text, "{}\t{scalar}\t{lanes}", robot.key(name).join("\t"));
    }
    text
}

/// Returns the operations of each robot and function, as the file has them.
pub(super) fn counted() -> String {
    let head = "# command: cargo xtask pages\nrobot\tbase\tfunction\toperations\tin lanes\n";
    let rows: Vec<String> = std::thread::scope(|scope| {
        let counts = ROBOTS.each_ref().map(|robot| scope.spawn(|| count(robot)));
        counts.map(|count| count.join().expect("counted")).into()
    });
    head.to_owned() + &rows.concat()
}

/// Returns the count of a function, with the operations in lanes in brackets if there are some.
fn cell(data: &Data, robot: &Robot, function: &str) -> String {
    let [count, in_lanes] =
        ["operations", "in lanes"].map(|title| data.cell(&robot.key(function), title));
    if in_lanes.is_empty() { count.into() } else { format!("{count} ({in_lanes})") }
}

/// Robots by functions.
fn operations_in_lanes() -> String {
    let data = Data::load("operations");
    let functions = [
        "forward_dynamics",
        "inverse_dynamics",
        "mass_matrix",
        "inverse_dynamics_derivatives",
        "forward_dynamics_derivatives",
    ];
    let title = |function: &str| match function.strip_suffix("_derivatives") {
        Some(of) => format!("derivatives of {}", of.replace('_', " ")),
        None => function.replace('_', " "),
    };
    let rows = ROBOTS.iter().map(|robot| {
        let cells = functions.map(|function| cell(&data, robot, function));
        [robot.title()].into_iter().chain(cells).collect::<Vec<_>>()
    });
    table(&format!("robot | {}", functions.map(title).join(" | ")), rows)
}

/// modyn's operations beside CasADi's instructions.
fn beside_casadi() -> String {
    let (own, casadi) = (Data::load("operations"), Data::load("casadi"));
    let functions =
        ["forward_dynamics", "inverse_dynamics", "mass_matrix", "forward_dynamics_derivatives"];
    let title = |function: &str| format!(" | {}: modyn | CasADi", function.replace('_', " "));
    let titles = functions.map(title).concat();
    let theirs = |robot: &Robot, function| casadi.find(&[function, robot.measured], "instructions");
    let measured = |robot: &&Robot| functions.iter().any(|f| theirs(robot, f).is_some());
    let rows = ROBOTS.iter().filter(measured).map(|robot| {
        let mut row = vec![robot.title()];
        for function in functions {
            let theirs = theirs(robot, function).unwrap_or_default().into();
            row.extend([cell(&own, robot, function), theirs]);
        }
        row
    });
    table(&format!("robot{titles}"), rows)
}

/// Returns the text of the mark `name`, if it is a table of operations.
pub(super) fn text_of(name: &str) -> Option<String> {
    match name {
        "casadi" => Some(beside_casadi()),
        "operations-in-lanes" => Some(operations_in_lanes()),
        _ => None,
    }
}

/// The gradient of forward dynamics takes at most 2.65 times the operations of forward dynamics,
/// for each robot.
#[test]
fn gradients_cost_at_most_2_65_functions() {
    let data = Data::load("operations");
    for robot in ROBOTS {
        let count = |function| data.number(&robot.key(function), "operations");
        let [one, vjp] = ["forward_dynamics", "forward_dynamics_vjp"].map(count);
        assert!(vjp <= 2.65 * one, "{}: {vjp} operations instead of {one}", robot.title());
    }
}
