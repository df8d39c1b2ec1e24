//! The functions that `CasADi` loads: derivatives against differences of the functions, on mechanisms in general position
//! with spherical and floating joints, run-time inertias and payloads. `tests/casadi` compares with `CasADi` itself.

use std::path::Path;

use modyn_codegen::passes::optimize;
use modyn_codegen::plan::{CasadiFunction, CasadiMatrix, Choices, Plan};
use modyn_codegen::trace::{EntryDerivatives, Tracer};
use modyn_codegen::{Base, Builder, Emitted, FloatType, Function, ReadOptions, Target, read_urdf};
use modyn_runtime::Interpreter;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Model, ModuleTree};

fn text(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/golden");
    std::fs::read_to_string(folder.join(format!("{name}.urdf"))).expect("a robot")
}

fn model(name: &str, base: Base) -> Model {
    let options = ReadOptions { base, ..ReadOptions::default() };
    read_urdf(&text(name), name, &options).expect("a good robot").model
}

/// Returns numbers within -1..1 that do not repeat.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1 << 30) - 1.0
    }

    fn vector(&mut self, length: usize) -> Vec<f64> {
        (0..length).map(|_| self.next()).collect()
    }
}

/// Returns the entries of all matrices, dense and by columns, from the nonzeros.
fn dense(matrices: &[CasadiMatrix], nonzeros: &[f64]) -> Vec<Vec<f64>> {
    let mut next = nonzeros.iter();
    matrices
        .iter()
        .map(|matrix| {
            let mut entries = vec![0.0; matrix.entries()];
            for (column, rows) in matrix.nonzeros.iter().enumerate() {
                for row in rows {
                    entries[column * matrix.rows + row] = *next.next().expect("a nonzero");
                }
            }
            entries
        })
        .collect()
}

fn evaluate(function: &CasadiFunction, inputs: &[f64]) -> Vec<Vec<f64>> {
    dense(&function.outputs, &function.program.evaluate(inputs))
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64, place: &str) {
    assert_eq!(found.len(), expected.len(), "{place}");
    let scale = expected.iter().fold(1.0_f64, |scale, x| scale.max(x.abs()));
    for (k, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= tolerance * scale, "{place}, entry {k}: {a}, not {b}");
    }
}

/// Returns central differences of `f` with respect to the first `count` inputs: a column for each.
fn differences(f: impl Fn(&[f64]) -> Vec<f64>, x: &[f64], count: usize) -> Vec<Vec<f64>> {
    let step = 2e-6;
    (0..count)
        .map(|k| {
            let at = |sign: f64| {
                let mut x = x.to_vec();
                x[k] += sign * step;
                f(&x)
            };
            at(1.0).iter().zip(at(-1.0)).map(|(a, b)| (a - b) / (2.0 * step)).collect()
        })
        .collect()
}

/// Compares the derivatives of a function with differences, and with each other.
fn check(family: &[CasadiFunction], x: &[f64], numbers: &mut Numbers) {
    let [value, jacobian, forward, adjoint, second] = family else { panic!("a family of five") };
    let name = &value.name;
    for (prefix, function) in ["jac_", "fwd1_", "adj1_", "jac_adj1_"].iter().zip(&family[1..]) {
        assert_eq!((function.derivative, &function.name), (*prefix, name));
    }
    let all = |found: Vec<Vec<f64>>| found.concat();
    let y = all(evaluate(value, x));
    // Blocks of results by inputs, as one matrix: a column for each input.
    let blocks = |function: &CasadiFunction, given: &[f64], inputs: &[CasadiMatrix]| {
        let found = evaluate(function, given);
        let mut columns = vec![Vec::new(); inputs.iter().map(CasadiMatrix::entries).sum()];
        for (row, blocks) in found.chunks(inputs.len()).enumerate() {
            let mut first = 0;
            for (k, block) in blocks.iter().enumerate() {
                let matrix = &function.outputs[row * inputs.len() + k];
                for (column, entries) in block.chunks(matrix.rows).enumerate() {
                    columns[first + column].extend_from_slice(entries);
                }
                first += matrix.columns;
            }
        }
        columns
    };
    let matrix = blocks(jacobian, x, &value.inputs);
    let expected = differences(|x| all(evaluate(value, x)), x, x.len());
    for (k, (found, expected)) in matrix.iter().zip(&expected).enumerate() {
        assert_close(found, expected, 1e-6, &format!("jac_{name}, input {k}"));
    }

    let product = |vectors: &[Vec<f64>], weights: &[f64]| -> Vec<f64> {
        let mut sum = vec![0.0; vectors[0].len()];
        for (vector, weight) in vectors.iter().zip(weights) {
            sum.iter_mut().zip(vector).for_each(|(sum, x)| *sum += weight * x);
        }
        sum
    };
    let change = numbers.vector(x.len());
    let found = all(evaluate(forward, &[x, &change].concat()));
    assert_close(&found, &product(&matrix, &change), 1e-10, &format!("fwd1_{name}"));

    // Weights belong to the nonzeros of the results.
    let weights = numbers.vector(value.program.results.len());
    let spread = dense(&value.outputs, &weights).concat();
    assert_eq!(spread.len(), y.len());
    let given = [x, &weights].concat();
    let gradient = all(evaluate(adjoint, &given));
    let expected: Vec<f64> =
        matrix.iter().map(|column| column.iter().zip(&spread).map(|(a, b)| a * b).sum()).collect();
    assert_close(&gradient, &expected, 1e-10, &format!("adj1_{name}"));

    let outs: usize = value.outputs.len();
    let inputs: Vec<CasadiMatrix> = adjoint.inputs.clone();
    assert_eq!(inputs.len(), value.inputs.len() + 2 * outs);
    let matrix = blocks(second, &given, &inputs);
    let expected = differences(|x| all(evaluate(adjoint, x)), &given, x.len());
    for (k, (found, expected)) in matrix.iter().zip(&expected).enumerate() {
        assert_close(found, expected, 2e-6, &format!("jac_adj1_{name}, input {k}"));
    }
    // The derivative by the weights is the transposed Jacobian; that by the results, which are inputs, is zero.
    let rest = &matrix[x.len()..];
    let (by_results, by_weights) = rest.split_at(rest.len() / 2);
    assert!(by_results.iter().flatten().all(|entry| *entry == 0.0), "{name}");
    let unweighted = product(by_weights, &spread);
    assert_close(&unweighted, &gradient, 1e-10, &format!("jac_adj1_{name}, weights"));
}

const FUNCTIONS: [Function; 9] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::MassMatrix,
    Function::PotentialEnergy,
    Function::StepSemiImplicit,
    Function::LinkPose,
    Function::Integrate,
    Function::Difference,
    Function::VelocityToQdot,
];

fn compare(model: &Model, gravity: bool, inertias: &[usize], payload: &[usize]) {
    let choices = Choices {
        functions: FUNCTIONS.to_vec(),
        runtime_gravity: gravity,
        runtime_inertia: inertias.to_vec(),
        payload: payload.to_vec(),
        ..Choices::default()
    };
    let plan = Plan::for_casadi(model, &ModuleTree::links(model), &choices);
    let plan = plan.expect("short").casadi;
    assert_eq!(plan.without_hessian, [""; 0]);
    let mut numbers = Numbers(7);
    for family in plan.functions.chunks(5) {
        let mut x = Vec::new();
        for input in &family[0].inputs {
            let mut entries = numbers.vector(input.len());
            match &*input.name {
                "dt" => entries[0] = 0.03,
                // Gravity, then masses, centres of mass and inertias, which rigid bodies can have.
                "params" => {
                    let first = if gravity { 3 } else { 0 };
                    for inertial in entries[first..].chunks_mut(10) {
                        inertial[0] += 2.0;
                        inertial[4..].iter_mut().for_each(|x| *x *= 0.1);
                        for k in [4, 7, 9] {
                            inertial[k] += 1.0;
                        }
                    }
                }
                _ => {}
            }
            x.extend(entries);
        }
        check(family, &x, &mut numbers);
    }
    assert!(plan.functions.len() >= 5 * FUNCTIONS.len());
}

#[test]
fn derivatives_are_those_of_the_functions() {
    compare(&model("ur5", Base::Fixed), true, &[6], &[8]);
}

#[test]
fn quaternions_are_differentiated_by_all_four_entries() {
    compare(&model("joints_spherical", Base::Fixed), false, &[], &[]);
}

#[test]
fn a_pose_in_the_middle_of_a_tree_is_differentiated() {
    compare(&model("joints_floating", Base::Fixed), false, &[], &[2]);
}

/// The values are those of the interpreter, at quaternions of length 1.
#[test]
fn quaternions_have_any_length() {
    let model = model("double_pendulum", Base::Floating);
    let choices = Choices { functions: [Function::ForwardDynamics].to_vec(), ..Choices::default() };
    let plan = Plan::for_casadi(&model, &ModuleTree::links(&model), &choices);
    let plan = plan.expect("short").casadi;
    let mut numbers = Numbers(3);
    let x = numbers.vector(model.nq() + 2 * model.nv());
    let mut interpreter = Interpreter::new(model.clone());
    let mut q = x[..model.nq()].to_vec();
    let length = q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!((length - 1.0).abs() > 0.1);
    q[3..7].iter_mut().for_each(|x| *x /= length);
    let (qd, tau) = x[model.nq()..].split_at(model.nv());
    let mut qdd = vec![0.0; model.nv()];
    interpreter.forward_dynamics(&q, qd, tau, &mut qdd).expect("the lengths fit");
    assert_close(&evaluate(&plan.functions[0], &x).concat(), &qdd, 1e-12, "forward dynamics");
    let nothing = evaluate(&plan.functions[0], &vec![0.0; x.len()]).concat();
    assert!(nothing.iter().all(|qdd| qdd.is_finite()), "the identity: {nothing:?}");
}

/// A forearm does not depend on the second of two arms.
#[test]
fn patterns_have_the_zeros_of_the_structure() {
    let model = model("solo12", Base::Fixed);
    let choices = Choices {
        functions: [Function::ForwardDynamics, Function::MassMatrix].to_vec(),
        ..Choices::default()
    };
    let plan = Plan::for_casadi(&model, &ModuleTree::links(&model), &choices);
    let plan = plan.expect("short").casadi;
    // Four legs of three joints: blocks on the diagonal.
    let blocks = |matrix: &CasadiMatrix| {
        for (column, rows) in matrix.nonzeros.iter().enumerate() {
            assert!(rows.iter().all(|row| row / 3 == column / 3), "{}", matrix.name);
        }
        matrix.len()
    };
    let [jacobian, mass] = ["jac_solo_forward_dynamics", "solo_mass_matrix"].map(|name| {
        let mut all = plan.functions.iter();
        all.find(|one| one.full_name("solo") == name).expect("it is there")
    });
    assert!(jacobian.outputs.iter().map(blocks).all(|nonzeros| (28..=36).contains(&nonzeros)));
    let mass = &mass.outputs[0];
    assert!((28..=36).contains(&blocks(mass)));
    let pattern = mass.compressed_columns();
    assert_eq!(pattern[..3], [12, 12, 0]);
    assert_eq!(pattern[14], mass.len());
    assert_eq!(pattern.len(), 2 + 13 + mass.len());
}

#[test]
fn other_options_are_refused_or_warned_of() {
    let builder = || Builder::new().urdf_text(text("double_pendulum"), "double_pendulum.urdf");
    let refused = |builder: Builder| {
        builder.emit(Target::Casadi).map(|_| ()).expect_err("refused").to_string()
    };
    let single = refused(builder().scalar(FloatType::F32));
    assert!(single.contains("`CasADi` computes in double precision"), "{single}");
    let fused = modyn_codegen::FusedFunction::new("both")
        .function(Function::MassMatrix)
        .function(Function::BiasForces);
    let fused = refused(builder().fused([fused]).gravity([f64::NAN; 3]));
    assert!(fused.contains("fused") && fused.contains("gravity"), "{fused}");

    let functions = [Function::ForwardDynamics, Function::Regressor];
    let names = |emitted: &Emitted| -> Vec<String> {
        let functions = emitted.plan.casadi.functions.iter();
        functions.map(|function| function.full_name(&emitted.prefix)).collect()
    };
    let emit = |builder: Builder| builder.emit(Target::Casadi).expect("good");
    let source = emit(builder().functions(functions));
    assert!(
        source.warnings.iter().any(|warning| warning.message.contains("`regressor` has no form"))
    );
    let name = "double_pendulum_forward_dynamics";
    let expected =
        ["", "jac_", "fwd1_", "adj1_", "jac_adj1_"].map(|prefix| format!("{prefix}{name}"));
    assert_eq!(names(&source), expected);
    assert_eq!(source.files, emit(builder().functions(functions)).files);
    let all = emit(builder().functions(Function::ALL.to_vec()));
    assert!(names(&all).len() > 100);
    assert!(all.warnings.iter().all(|one| !one.message.contains("no form")));
}

#[test]
fn long_second_derivatives_are_left_out_with_a_warning() {
    let functions = [Function::StepSemiImplicit, Function::StepRk4];
    let builder = Builder::new().urdf_text(text("panda"), "panda.urdf").type_name("Panda");
    let source = builder.functions(functions).emit(Target::Casadi).expect("good");
    let casadi = &source.plan.casadi;
    assert_eq!(casadi.without_hessian, ["step_rk4"]);
    let of = |name: &str| casadi.functions.iter().filter(|one| one.name == name).count();
    assert_eq!((of("step_semi_implicit"), of("step_rk4")), (5, 4));
    assert!(!source.text().contains("jac_adj1_panda_step_rk4"));
    let said = "`panda_step_rk4` has no second derivatives: their code would be too long";
    assert_eq!(source.warnings.iter().filter(|warning| warning.message == said).count(), 1);
}

#[test]
fn second_derivatives_are_left_out_above_their_limit() {
    let model = model("ur5", Base::Fixed);
    let (mechanism, modules) = (Mechanism::new(&model), ModuleTree::links(&model));
    let (tracer, layout) = (Tracer::new(&mechanism), UduLayout::new(&mechanism, &modules));
    let forward = optimize(tracer.forward_dynamics(&Elimination::new(&mechanism, &modules)));
    let by_entries: [&dyn Fn(usize) -> EntryDerivatives; 2] =
        [&|limit| tracer.forward_dynamics_by_entries(&forward, &layout, limit), &|limit| {
            tracer.inverse_dynamics_by_entries(limit)
        }];
    for derivatives in by_entries {
        let operations = derivatives(usize::MAX).hessian.expect("no limit").count().total();
        let within = derivatives(operations).hessian.expect("at the limit");
        assert_eq!(within.count().total(), operations);
        assert!(derivatives(operations - 1).hessian.is_none());
    }
}
