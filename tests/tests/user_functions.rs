//! Functions of users: the programs of their values and derivatives against the same functions on numbers, on dual numbers
//! and on num-dual's numbers, on robots in general position.

use std::collections::BTreeMap;

use modyn_codegen::Builder;
use modyn_codegen::plan::{Kernels, Planned, Shape};
use modyn_runtime::model::Model;
use modyn_runtime::num_dual::HyperDual64;
use modyn_runtime::{Interpreter, Scalar, UserArgument, UserError, UserFunction};
use modyn_tests::close::assert_close;
use modyn_tests::dual::{Tangent, along, along_velocity, constant};
use modyn_tests::floating::floated;
use modyn_tests::random::{self, Random, State};

/// A number with two directions.
type Twice = Tangent<Tangent<f64>>;

/// The arguments of [`Terms`] in their order.
const ARGUMENTS: [UserArgument; 8] = [
    UserArgument::Q,
    UserArgument::numbers("target", 3),
    UserArgument::QD,
    UserArgument::QDD,
    UserArgument::coordinates("reference"),
    UserArgument::numbers("force", 3).variable(),
    UserArgument::number("weight").variable(),
    UserArgument::coordinates("other").variable(),
];

/// Quantities of the last link, of the whole robot and of its coordinates, or the sum of their squares.
#[derive(Clone, Copy)]
struct Terms {
    is_sum: bool,
}

impl UserFunction<8> for Terms {
    fn docs(&self) -> String {
        "Returns terms, or the sum of their squares. */ They are in world axes.".into()
    }

    fn arguments(&self) -> [UserArgument; 8] {
        ARGUMENTS
    }

    fn evaluate<S: Scalar>(
        &self,
        robot: &mut Interpreter<S>,
        [q, target, qd, qdd, reference, force, weight, other]: [&[S]; 8],
    ) -> Result<Vec<S>, UserError> {
        let link = robot.model().links().len() - 1;
        let n = robot.model().nv();
        let dot = |a: &[S], b: &[S]| a.iter().zip(b).fold(S::zero(), |sum, (&a, &b)| sum + a * b);
        let pose = robot.link_pose(q, link)?;
        let velocity = robot.link_velocity(q, qd, link)?;
        let position = pose.translation;
        let to_target: Vec<S> = position.iter().zip(target).map(|(&x, &t)| x - t).collect();
        let mut tau = vec![S::zero(); n];
        robot.inverse_dynamics(q, qd, qdd, &mut tau)?;
        let mut displacement = vec![S::zero(); n];
        robot.difference(reference, q, &mut displacement)?;
        let mut between = vec![S::zero(); n];
        robot.difference(q, other, &mut between)?;
        let kinetic = robot.kinetic_energy(q, qd)?;
        let terms = [
            dot(&to_target, &to_target).sqrt(),
            dot(&velocity.linear.0, force),
            (dot(&tau, &tau) * S::from_f64(0.01) + S::one()).ln() * weight[0],
            dot(&displacement, &between),
            kinetic * weight[0] * weight[0] * pose.rotation[0][1],
        ];
        match self.is_sum {
            true => Ok(vec![dot(&terms, &terms)]),
            false => Ok(terms.to_vec()),
        }
    }
}

/// Returns the numbers of each field of the results of all forms of a function.
fn evaluated(
    builder: Builder,
    function: Terms,
    inputs: &BTreeMap<&str, Vec<f64>>,
) -> BTreeMap<String, Vec<f64>> {
    let planning = builder.functions([]).function("terms", function).plan().expect("good");
    let mut found = BTreeMap::new();
    for Planned { name, arguments, parameters, result, kernels, .. } in &planning.plan.functions {
        let Kernels::Straight { scalar: program, simd: None } = kernels else { panic!("{name}") };
        let mut numbers: Vec<f64> = Vec::new();
        for (argument, shape) in arguments {
            let own = &inputs[argument.name];
            assert_eq!(own.len(), shape.len(), "{name}: {}", argument.name);
            numbers.extend(own);
        }
        assert_eq!(*parameters, planning.plan.parameters.len(), "{name}");
        numbers.extend(planning.plan.parameters.described(planning.model.gravity()));
        let mut all = &program.evaluate::<f64>(&numbers)[..];
        assert_eq!(all.len(), result.len(), "{name}");
        let fields = match result {
            Shape::Record(_, fields) => fields.clone(),
            shape => vec![("", shape.clone())],
        };
        for (field, shape) in fields {
            let (own, rest) = all.split_at(shape.len());
            all = rest;
            found.insert(format!("{name}.{field}"), own.to_vec());
        }
    }
    found
}

/// Evaluates the function with the arguments of `move_` in place of numbers.
fn on<S: Scalar>(
    model: &Model,
    function: Terms,
    inputs: &BTreeMap<&str, Vec<f64>>,
    moved: impl Fn(&str, &[f64]) -> Vec<S>,
) -> Vec<S> {
    let arguments = ARGUMENTS.map(|argument| moved(argument.name(), &inputs[argument.name()]));
    let mut robot = Interpreter::<S>::new(model.clone());
    function.evaluate(&mut robot, arguments.each_ref().map(Vec::as_slice)).expect("good")
}

/// An argument, and an entry of its displacement.
type Entry = (&'static str, usize);

/// Returns an argument's numbers with derivatives along an entry.
fn moved<S: Scalar>(model: &Model, name: &str, x: &[S], (variable, k): Entry) -> Vec<Tangent<S>> {
    match name {
        _ if name != variable => constant(x),
        "q" | "other" => along_velocity(model, x, k),
        _ => along(x, k),
    }
}

/// Returns the derivatives of the results along an entry.
fn first(model: &Model, function: Terms, inputs: &BTreeMap<&str, Vec<f64>>, a: Entry) -> Vec<f64> {
    let results = on(model, function, inputs, |name, x| moved(model, name, x, a));
    results.iter().map(|x| x.dx).collect()
}

/// Returns the second derivatives of the results along an entry, then along another one.
fn second(
    model: &Model,
    function: Terms,
    inputs: &BTreeMap<&str, Vec<f64>>,
    [a, b]: [Entry; 2],
) -> Vec<f64> {
    let results = on(model, function, inputs, |name, x| {
        let once = moved(model, name, x, a);
        let twice: Vec<Twice> = moved(model, name, &once, b);
        let number = |t: Twice| HyperDual64::new(t.x.x, t.x.dx, t.dx.x, t.dx.dx);
        twice.into_iter().map(number).collect()
    });
    results.iter().map(|x| x.eps1eps2).collect()
}

/// Compares all forms of a function of a robot with dual numbers.
fn compare(name: &str, builder: Builder, model: &Model, function: Terms, seed: u64) {
    let random = &mut Random::new(seed);
    let [now, reference, other] = [seed, seed + 100, seed + 200].map(|s| random::state(s, model));
    let State { q, qd, qdd, .. } = now;
    let mut numbers = |n: usize| (0..n).map(|_| random.between(-1.0, 1.0)).collect::<Vec<f64>>();
    let nv = model.nv();
    let results = if function.is_sum { 1 } else { 5 };
    let mut inputs: BTreeMap<&str, Vec<f64>> = [
        ("q", q),
        ("qd", qd),
        ("qdd", qdd),
        ("reference", reference.q),
        ("other", other.q),
        ("target", numbers(3)),
        ("force", numbers(3)),
        ("weight", numbers(1)),
        ("tangent_q", numbers(nv)),
        ("tangent_qd", numbers(nv)),
        ("tangent_qdd", numbers(nv)),
        ("tangent_other", numbers(nv)),
        ("tangent_force", numbers(3)),
        ("tangent_weight", numbers(1)),
        ("cotangent", numbers(results)),
    ]
    .into();
    let found = evaluated(builder, function, &inputs);
    if function.is_sum {
        inputs.insert("cotangent", vec![1.0]);
    }
    let variables =
        [("q", nv), ("qd", nv), ("qdd", nv), ("force", 3), ("weight", 1), ("other", nv)];
    let entries = |(variable, n): (&'static str, usize)| (0..n).map(move |k| (variable, k));
    let weighted =
        |x: &[f64]| -> f64 { x.iter().zip(&inputs["cotangent"]).map(|(a, b)| a * b).sum() };
    let close = |field: &str, expected: &[f64]| {
        let own = found.get(field).unwrap_or_else(|| panic!("{field}: {:?}", found.keys()));
        assert_close(&format!("{name}: {field}"), own, expected, 1e-8);
    };
    // The gradients of the sum of squares are those of the interpreter's numbers.
    let value = on::<f64>(model, function, &inputs, |_, x| x.to_vec());
    let forms: &[&str] = match function.is_sum {
        true => &["", "_jvp", "_gradient", "_hessian"],
        false => &["", "_jvp", "_vjp", "_jacobian", "_hessian"],
    };
    for form in forms {
        close(&format!("terms{form}.{}", if form.is_empty() { "" } else { "value" }), &value);
    }
    let fields: usize = forms
        .iter()
        .map(|form| match *form {
            "" => 1,
            "_jvp" => 2,
            "_hessian" => 1 + 6 + 21,
            _ => 7,
        })
        .sum();
    assert_eq!(found.len(), fields, "{name}: {:?}", found.keys());
    let mut change = vec![0.0; results];
    for variable in variables {
        let columns: Vec<Vec<f64>> =
            entries(variable).map(|entry| first(model, function, &inputs, entry)).collect();
        let by = variable.0;
        for (column, dx) in columns.iter().zip(&inputs[&*format!("tangent_{by}")]) {
            change.iter_mut().zip(column).for_each(|(sum, x)| *sum += x * dx);
        }
        let gradient: Vec<f64> = columns.iter().map(|column| weighted(column)).collect();
        match function.is_sum {
            true => close(&format!("terms_gradient.grad_{by}"), &gradient),
            false => {
                close(&format!("terms_vjp.grad_{by}"), &gradient);
                close(&format!("terms_jacobian.dvalue_d{by}"), &columns.concat());
            }
        }
        close(&format!("terms_hessian.grad_{by}"), &gradient);
    }
    close("terms_jvp.tangent_value", &change);
    for (i, rows) in variables.into_iter().enumerate() {
        for columns in &variables[i..] {
            let mut block = Vec::new();
            for b in entries(*columns) {
                for a in entries(rows) {
                    let entry = |pair| weighted(&second(model, function, &inputs, pair));
                    // Displacements of one rotation do not commute.
                    block.push(0.5 * (entry([a, b]) + entry([b, a])));
                }
            }
            close(&format!("terms_hessian.hess_{}_{}", rows.0, columns.0), &block);
        }
    }
}

#[test]
fn derivatives_are_those_of_dual_numbers() {
    for seed in 0..8 {
        let links = 1 + usize::try_from(seed % 4).expect("a digit");
        let model = random::mixed_zoo(seed, links);
        let function = Terms { is_sum: seed % 2 == 0 };
        let builder = Builder::new().model(model.clone());
        let builder = if seed % 3 == 0 { builder.runtime_gravity() } else { builder };
        compare(&format!("seed {seed}"), builder, &model, function, seed);
    }
}

#[test]
fn derivatives_of_floating_robots_are_those_of_dual_numbers() {
    for seed in 0..4 {
        let links = 1 + usize::try_from(seed).expect("a digit");
        let model = floated(&random::mixed_tree(seed, links), Random::new(seed).inertial());
        let function = Terms { is_sum: seed % 2 == 1 };
        let builder = Builder::new().model(model.clone());
        compare(&format!("floating, seed {seed}"), builder, &model, function, seed);
    }
}
