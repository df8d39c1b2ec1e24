//! Functions of arrays of plain numbers: their derivatives against differences, in general position and with run-time parameters.

use std::path::{Path, PathBuf};

use modyn_codegen::plan::{Derivative, DerivativeMode, EntryFunction, EntrySource};
use modyn_codegen::{
    Builder, Function, FusedFunction, Interpreter, Scalar, UserArgument, UserError, UserFunction,
};

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/golden/joints_spherical.urdf")
}

fn builder() -> Builder {
    Builder::new().urdf(path()).runtime_gravity().payload(["link4"])
}

fn numbers(count: usize, seed: usize) -> Vec<f64> {
    (0..count).map(|k| ((k * 7 + seed * 13) % 19) as f64 / 9.5 - 0.9).collect()
}

/// A function of arrays, evaluated.
struct Evaluated(Builder, EntryFunction);

impl Evaluated {
    fn call(&self, x: &[f64]) -> Vec<f64> {
        let planning = self.0.plan_entries(&self.1).expect("a plan");
        let [planned] = &planning.plan.functions[..] else { panic!("one function") };
        assert_eq!(planned.arguments[0].1.len(), x.len());
        let (program, _) = planned.kernels.straight().expect("straight-line code");
        program.evaluate(x)
    }

    fn derivative(&self, mode: DerivativeMode, variables: &[usize]) -> Self {
        let mut function = self.1.clone();
        function.derivatives.push(Derivative { mode, variables: variables.to_vec() });
        Self(self.0.clone(), function)
    }
}

fn close(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(1.0_f64, |scale, x| scale.max(x.abs()));
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= tolerance * scale, "{a}, not {b}");
    }
}

fn of_the_table(
    function: Function,
    link: Option<usize>,
    results: Vec<Vec<usize>>,
) -> EntryFunction {
    entry(EntrySource::Table { function, link }, results)
}

fn entry(source: EntrySource, results: Vec<Vec<usize>>) -> EntryFunction {
    EntryFunction { source, results, feedback: None, cost: false, derivatives: Vec::new() }
}

/// Returns a function of `q` and two joint vectors with run-time gravity and a payload, its arrays, and their lengths.
fn function(function: Function) -> (Evaluated, Vec<f64>, [usize; 4]) {
    let robot = builder();
    let model = robot.plan().expect("a robot").model;
    let (nq, nv) = (model.nq(), model.nv());
    assert!(nq > nv, "there are quaternions");
    // The result as two arrays.
    let results = vec![(0..nv - 1).collect(), vec![nv - 1]];
    let own = of_the_table(function, None, results);
    let payload = [0.7, 0.1, -0.2, 0.3, 0.02, 0.001, -0.002, 0.03, 0.004, 0.025];
    let x = [&*numbers(nq + 2 * nv, 3), &[0.5, -0.7, -9.5], &payload].concat();
    (Evaluated(robot, own), x, [nq, nv, nv, 13])
}

/// Returns the differences of all results by the entries of the variables: a column for each entry.
fn differences(f: &Evaluated, x: &[f64], lengths: &[usize], variables: &[usize]) -> Vec<Vec<f64>> {
    let planning = f.0.plan_entries(&f.1).expect("a plan");
    let (program, _) = planning.plan.functions[0].kernels.straight().expect("straight-line code");
    let entries = variables.iter().flat_map(|&i| {
        let first: usize = lengths[..i].iter().sum();
        first..first + lengths[i]
    });
    let column = |entry: usize| {
        let at = |step: f64| {
            let mut x = x.to_vec();
            x[entry] += step;
            program.evaluate(&x)
        };
        let (h, all) = (1e-3, [at(-2e-3), at(-1e-3), at(1e-3), at(2e-3)]);
        let difference = |k: usize| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|i: usize| all[i][k]);
            (a - 8.0 * b + 8.0 * c - d) / (12.0 * h)
        };
        (0..all[0].len()).map(difference).collect()
    };
    entries.map(column).collect()
}

/// Returns the product of a matrix by columns and a change of its variables.
fn along(columns: &[Vec<f64>], change: &[f64]) -> Vec<f64> {
    let row = |row: usize| columns.iter().zip(change).map(|(column, t)| column[row] * t).sum();
    (0..columns[0].len()).map(row).collect()
}

/// Returns the product of the transpose of a matrix by columns and weights of its rows.
fn gradient(columns: &[Vec<f64>], weights: &[f64]) -> Vec<f64> {
    let entry = |column: &Vec<f64>| column.iter().zip(weights).map(|(entry, w)| entry * w).sum();
    columns.iter().map(entry).collect()
}

#[test]
fn derivatives_are_those_of_the_function() {
    for own in [Function::ForwardDynamics, Function::InverseDynamics] {
        let (value, x, lengths) = function(own);
        let (nv, variables) = (lengths[1], [0, 2, 3]);
        let expected = differences(&value, &x, &lengths, &variables);
        let varying: usize = variables.iter().map(|&i| lengths[i]).sum();

        let change = numbers(varying, 5);
        let forward = value.derivative(DerivativeMode::Forward, &variables);
        close(&forward.call(&[&*x, &change].concat()), &along(&expected, &change), 1e-8);

        let weights = numbers(nv, 6);
        let reverse = value.derivative(DerivativeMode::Reverse, &variables);
        let weighted = [&*x, &weights].concat();
        close(&reverse.call(&weighted), &gradient(&expected, &weights), 1e-8);

        // Blocks by result and variable, each by rows.
        let matrix = value.derivative(DerivativeMode::Matrix, &variables).call(&x);
        let mut blocks = matrix.iter();
        for rows in [0..nv - 1, nv - 1..nv] {
            let mut first = 0;
            for &variable in &variables {
                for row in rows.clone() {
                    for column in &expected[first..first + lengths[variable]] {
                        close(&[*blocks.next().expect("an entry")], &[column[row]], 1e-8);
                    }
                }
                first += lengths[variable];
            }
        }
        assert_eq!(blocks.next(), None);

        // Second derivatives, in closed form and by differentiation.
        let lengths = [&lengths[..], &[nv - 1, 1]].concat();
        let variables = [0, 1, 3, 4];
        let second = differences(&reverse, &weighted, &lengths, &variables);
        let varying: usize = variables.iter().map(|&i| lengths[i]).sum();
        let change = numbers(varying, 8);
        let expected: Vec<f64> = (0..second[0].len())
            .map(|row| second.iter().zip(&change).map(|(column, t)| column[row] * t).sum())
            .collect();
        let product = reverse.derivative(DerivativeMode::Forward, &variables);
        close(&product.call(&[&*weighted, &change].concat()), &expected, 1e-7);
        let matrix = reverse.derivative(DerivativeMode::Matrix, &variables).call(&weighted);
        let (mut first, mut row, mut found) = (0, 0, vec![0.0; expected.len()]);
        for &output in &[0, 2, 3] {
            let mut column = 0;
            for &variable in &variables {
                for i in 0..lengths[output] {
                    for j in 0..lengths[variable] {
                        found[row + i] += matrix[first] * change[column + j];
                        first += 1;
                    }
                }
                column += lengths[variable];
            }
            row += lengths[output];
        }
        close(&found, &expected, 1e-7);
    }
}

#[test]
fn a_function_of_a_link_has_the_link() {
    let robot = Builder::new().urdf(path());
    let at = |link: usize| {
        let function = of_the_table(Function::LinkPose, Some(link), vec![vec![9, 10, 11]]);
        Evaluated(robot.clone(), function)
    };
    let model = robot.plan().expect("a robot").model;
    let q = numbers(model.nq(), 2);
    let mut unit = q.clone();
    let interpreter = modyn_runtime::Interpreter::<f64>::new(model.clone());
    interpreter.normalize_configuration(&mut unit).expect("lengths");
    for link in 0..model.links().len() {
        let pose = modyn_runtime::Interpreter::<f64>::new(model.clone()).link_pose(&unit, link);
        let pose = pose.expect("a link");
        close(&at(link).call(&q), &pose.translation, 1e-12);
    }
}

/// The height of the last link above a level.
struct Height;

impl UserFunction<2> for Height {
    fn docs(&self) -> String {
        "Returns the height of the last link above `level`, m.".into()
    }

    fn arguments(&self) -> [UserArgument; 2] {
        [UserArgument::Q, UserArgument::numbers("level", 1)]
    }

    fn evaluate<S: Scalar>(
        &self,
        robot: &mut Interpreter<S>,
        [q, level]: [&[S]; 2],
    ) -> Result<Vec<S>, UserError> {
        let last = robot.model().links().len() - 1;
        Ok(vec![robot.link_pose(q, last)?.translation[2] - level[0]])
    }
}

#[test]
fn a_fused_function_has_the_results_of_its_functions() {
    let robot = builder();
    let model = robot.plan().expect("a robot").model;
    let nq = model.nq();
    let nv = model.nv();
    let last = model.links().len() - 1;
    // In the order of the arguments of the fused function: the user's come last.
    let lengths = [nq, nv, nv, 1, 13];
    let [q, qd, qdd] = [numbers(nq, 3), numbers(nv, 4), numbers(nv, 5)];
    let payload = [0.7, 0.1, -0.2, 0.3, 0.02, 0.001, -0.002, 0.03, 0.004, 0.025];
    let parameters = [&[0.5, -0.7, -9.5], &payload[..]].concat();
    let level = [0.4];

    let all = |count: usize| vec![(0..count).collect::<Vec<usize>>()];
    let alone = |function, link, count, arguments: &[&[f64]]| {
        let function = of_the_table(function, link, all(count));
        Evaluated(robot.clone(), function).call(&arguments.concat())
    };
    let matrix = alone(Function::MassMatrix, None, nv * nv, &[&q, &parameters]);
    let pose = alone(Function::LinkPose, Some(last), 12, &[&q]);
    let forces = alone(Function::InverseDynamics, None, nv, &[&q, &qd, &qdd, &parameters]);
    let height = [pose[11] - level[0]];
    let expected = [&*matrix, &pose, &forces, &height].concat();

    let fused = FusedFunction::new("control")
        .function(Function::MassMatrix)
        .of_link(Function::LinkPose, &*model.links()[last].name)
        .function(Function::InverseDynamics)
        .own_function("height");
    let with_fused = robot.clone().function("height", Height).fused([fused]);
    let source = EntrySource::Fused("control".into());
    let count = expected.len();
    // Two arrays, in another order than the numbers of the result.
    let results = vec![(0..nv * nv).rev().collect(), (nv * nv..count).collect()];
    let value = Evaluated(with_fused.clone(), entry(source, results));
    let x = [&*q, &qd, &qdd, &level, &parameters].concat();
    let reordered: Vec<f64> = matrix.iter().rev().chain(&expected[nv * nv..]).copied().collect();
    close(&value.call(&x), &reordered, 1e-12);

    let variables = [0, 2, 3, 4];
    let columns = differences(&value, &x, &lengths, &variables);
    let change = numbers(columns.len(), 6);
    let forward = value.derivative(DerivativeMode::Forward, &variables);
    close(&forward.call(&[&*x, &change].concat()), &along(&columns, &change), 1e-8);
    let weights = numbers(count, 7);
    let reverse = value.derivative(DerivativeMode::Reverse, &variables);
    close(&reverse.call(&[&*x, &weights].concat()), &gradient(&columns, &weights), 1e-8);

    let unknown = entry(EntrySource::Fused("contrl".into()), all(1));
    let errors = with_fused.plan_entries(&unknown).map(|_| ()).expect_err("no such function");
    assert!(errors.to_string().contains("there is no fused function `contrl`"), "{errors}");
    assert!(errors.to_string().contains("did you mean `control`?"), "{errors}");
}
