//! The suite for the Python package: arrays of many states and of one, whose layouts follow from the table.

use std::fmt::Write as _;
use std::process::Command;

use modyn_codegen::plan::{Elements, Shape};
use modyn_codegen::{Format, write};
use modyn_tests::conformance::{command, conforms, read_results, write_numbers};

use super::*;

/// The package, for one state at a time or for many.
struct Python {
    many: bool,
}

fn instruction_set() -> InstructionSet {
    InstructionSet::available().last().expect("one")
}

impl BackEnd for Python {
    type Robot = (Planning, String);

    fn name(&self) -> String {
        format!("python{}", if self.many { " many" } else { "" })
    }

    fn arithmetic(&self) -> Arithmetic {
        arithmetic(instruction_set())
    }

    /// The factors of the mass matrix have methods there, and fused functions are options.
    fn has(&self, planned: &Planned) -> bool {
        planned.function.is_some_and(|function| function != Function::Brge)
    }

    fn on_vectors(&self, float: FloatType) -> bool {
        !self.many && on_vectors(instruction_set(), float)
    }

    fn takes_parameters(&self) -> bool {
        false
    }

    /// Returns the programs of a URDF, which has no options, and the URDF.
    fn make(&self, builder: &Builder) -> Result<(Planning, String), Diagnostics> {
        let Planning { plan, model, .. } = builder.plan()?;
        let model = model.with_springs(Vec::new()).expect("no springs");
        let urdf = write(&model, Format::Urdf)?.text;
        let functions = plan.functions.iter().filter_map(|planned| planned.function);
        let builder = Builder::new().urdf_text(urdf.as_str(), "robot.urdf");
        Ok((builder.functions(functions).plan()?, urdf))
    }

    fn run(&self, subject: &Subject<'_, (Planning, String)>, folder: &Path) -> Vec<Vec<f64>> {
        let (planning, urdf) = subject.robot;
        let mut script = String::from(SCRIPT);
        for own in subject.calls.chunks(STATES) {
            let Call { function, link, .. } = &own[0];
            let mut all = planning.plan.functions.iter();
            let planned = all.find(|planned| planned.name == function).expect("planned");
            let arguments =
                planned.arguments.iter().map(|(_, shape)| format!("take{}", axes(shape)));
            let arguments: Vec<String> = arguments.collect();
            let link = link.map(|link| format!(", {link}")).unwrap_or_default();
            let _ = writeln!(
                script,
                "call('{function}', [{}]{link}, flat=lambda x: {})",
                arguments.join(", "),
                flat("x", &planned.result, usize::from(self.many)),
            );
        }
        let calls = subject.calls.chunks(STATES).flat_map(|own| {
            (0..own[0].arguments.len())
                .flat_map(move |i| own.iter().flat_map(move |call| &call.arguments[i]))
        });
        write_numbers(&folder.join("in"), calls, subject.float);
        std::fs::write(folder.join("robot.urdf"), urdf).expect("writes");
        std::fs::write(folder.join("main.py"), script).expect("writes");
        let many = if self.many { "many" } else { "one" };
        let scalar = if subject.float == FloatType::F64 { "f64" } else { "f32" };
        let script = ["-W", "ignore", "main.py", many, scalar];
        command(Command::new("python3").args(script).current_dir(folder));
        read_results(&folder.join("out"), &subject.calls, subject.float)
    }
}

/// The beginning of the script: `take` reads an argument of all states, `call` writes the numbers of the results.
const SCRIPT: &str = "\
import sys
import modyn, numpy as np

many, scalar = sys.argv[1] == 'many', sys.argv[2]
robot = modyn.loads(open('robot.urdf').read(), scalar=scalar)
numbers, out, states = np.fromfile('in', robot.dtype), open('out', 'wb'), 8


def take(*axes):
    global numbers
    count = states * int(np.prod(axes))
    own, numbers = numbers[:count], numbers[count:]
    return own.reshape(states, *axes)


def joined(array, outer):
    return array.reshape(*array.shape[:outer], int(np.prod(array.shape[outer:])))


def call(name, arguments, *link, flat):
    function = getattr(robot, name)
    one = lambda i: flat(function(*(argument[i] for argument in arguments), *link))
    found = flat(function(*arguments, *link)) if many else [one(i) for i in range(states)]
    out.write(np.array(found, robot.dtype).tobytes())


";

/// Returns the lengths of the axes of an argument of one state.
fn axes(shape: &Shape) -> String {
    match shape {
        Shape::Array(inner, n, _) if **inner != Shape::Scalar => format!("({n}, {})", inner.len()),
        Shape::Scalar => "()".into(),
        _ => format!("({})", shape.len()),
    }
}

/// Returns an expression for the numbers of a result with this layout, after this number of axes.
fn flat(value: &str, shape: &Shape, outer: usize) -> String {
    let joined = |array: &str| format!("joined({array}, {outer})");
    match shape {
        Shape::Scalar => format!("np.array({value})[..., None]"),
        Shape::Array(inner, _, Elements::Columns) if inner.is_vector() => {
            joined(&format!("{value}.swapaxes(-1, -2)"))
        }
        Shape::Array(inner, ..) if **inner == Shape::Scalar || inner.is_vector() => joined(value),
        Shape::Array(inner, ..) => joined(&flat(value, inner, outer + 1)),
        Shape::Record(record, fields) if record.result_type().is_some() => {
            let fields =
                fields.iter().map(|(name, shape)| flat(&format!("{value}.{name}"), shape, outer));
            format!("np.concatenate([{}], axis=-1)", fields.collect::<Vec<_>>().join(", "))
        }
        Shape::Record(..) => value.into(),
    }
}

#[test]
#[ignore = "slow: Python compiles each function by itself"]
fn robots_of_every_kind() {
    let import = Command::new("python3").args(["-c", "import modyn"]).output();
    if !import.is_ok_and(|output| output.status.success()) {
        println!("not compared: the Python package is not installed");
        return;
    }
    for many in [false, true] {
        let python = Python { many };
        let is_described = |case: &&Case| !["own_functions", "parameters"].contains(&case.name);
        let compared: usize = kinds()
            .iter()
            .filter(is_described)
            .map(|case| conforms(&python, case, FloatType::F64))
            .sum();
        assert!(compared > 200, "{compared}");
        conforms(&python, &small(), FloatType::F64);
        conforms(&python, &small(), FloatType::F32);
        conforms(&python, &large(), FloatType::F64);
    }
}
