//! Programs compute the same as their graphs, and an invalid program is found before it is printed.

use std::collections::BTreeSet;

use modyn_codegen::graph::{Expr, Graph};
use modyn_codegen::passes::{balance, optimize};
use modyn_codegen::plan::{Choices, LIMB_LIMITS, Plan, Sizes};
use modyn_codegen::program::{
    Execution, Operand, ProductBlock, Products, Program, RowEquations, Source,
};
use modyn_codegen::trace::{DenseLoops, LimbPacking, Tracer};
use modyn_codegen::{
    Base, Builder, CodeForm, Contact, ContactKind, Function, LoopEnd, ReadOptions, read,
};
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::constraints::RowSystem;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::equations::kinematics::coordinates::normalize_configuration;
use modyn_runtime::equations::{ModulePartition, TimeStepInput};
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::{Interpreter, Scalar, StepOutputs};

fn robot(name: &str) -> Model {
    robot_on(name, Base::Fixed)
}

fn robot_on(name: &str, base: Base) -> Model {
    let path = format!("{}/../robots/{name}.urdf", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a robot");
    read(&text, name, &ReadOptions { base, ..ReadOptions::default() }).expect("good").model
}

/// Returns the limbs of a robot that share lanes in derivatives, if it has any.
fn limbs_of(mechanism: &Mechanism<f64>) -> Option<LimbPacking> {
    LimbPacking::find(mechanism, &LIMB_LIMITS).filter(|limbs| limbs.share_root_path(mechanism))
}

fn inputs(count: usize) -> Vec<f64> {
    (0..count).map(|i| libm::sin(1.7 * i as f64 + 0.3) * 1.4).collect()
}

/// Asserts that the program returns the same bits as the graph, for each target; this build fuses no product.
fn same(graph: &Graph, program: &Program) {
    assert_eq!(program.validate(), Ok(()));
    assert_eq!(program.to_string().parse(), Ok(program.clone()));
    let inputs = inputs(program.arguments);
    let (expected, found) = (graph.evaluate(&inputs), program.evaluate(&inputs));
    assert!(expected.iter().any(|x| *x != 0.0) && expected.iter().all(|x| x.is_finite()));
    for (expected, found) in expected.iter().zip(&found) {
        // A fused multiply-add rounds once.
        let fused = cfg!(any(target_feature = "fma", target_arch = "aarch64"));
        let tolerance = if fused { 1e-9 * (1.0 + expected.abs()) } else { 0.0 };
        assert!((expected - found).abs() <= tolerance, "{expected} {found}");
    }
    assert_eq!(found.len(), expected.len());
}

/// Derivatives and Hessians with products in loops, on scalars, columns in lanes and packed limbs.
#[test]
fn products_in_loops_agree_with_straight_line_code() {
    type Trace = fn(&Tracer<'_>, &UduLayout) -> Graph;
    let functions: [(usize, Trace); 2] = [
        (2, |tracer, layout| tracer.forward_dynamics_derivatives(layout)),
        (3, |tracer, layout| tracer.forward_dynamics_hessian(layout)),
    ];
    let products = DenseLoops { rows: None, products: true };
    for (name, base) in
        [("arm7", Base::Fixed), ("joint_zoo", Base::Fixed), ("quadruped", Base::Floating)]
    {
        let model = robot_on(name, base);
        let mechanism = Mechanism::new(&model);
        let layout = UduLayout::new(&mechanism, &ModuleTree::links(&model));
        let (tracer, n) = (Tracer::new(&mechanism), model.nv());
        let limbs = limbs_of(&mechanism);
        assert_eq!(limbs.is_some(), name == "quadruped");
        let packed = limbs.as_ref().map(|limbs| tracer.packed(limbs));
        for (vectors, trace) in functions {
            let arguments = model.nq() + vectors * n;
            let (inputs, expected) = (inputs(arguments), optimize(trace(&tracer, &layout)));
            let expected = expected.evaluate(&inputs);
            let scale = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let by_products = |tracer: &Tracer<'_>| trace(&tracer.with_loops(products), &layout);
            let scalar = optimize(by_products(&tracer));
            let simd = [tracer.column_lanes(4)].into_iter().chain(packed.clone());
            let simd = simd.map(|tracer| {
                (optimize(by_products(&tracer).with_zeros_of(&scalar)), Execution::Simd)
            });
            let on_scalars = [Execution::Scalar, Execution::Batch].map(|way| (scalar.clone(), way));
            for (graph, execution) in on_scalars.into_iter().chain(simd) {
                let program = Program::try_new(&graph, arguments, execution);
                let program = program.expect("valid");
                assert_eq!(program.to_string().parse(), Ok(program.clone()));
                let products = program.products.as_ref().expect("products");
                assert_eq!(products.in_place.is_some(), execution != Execution::Batch);
                let found = program.evaluate(&inputs);
                assert_eq!(found.len(), expected.len());
                for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    let error = (found - expected).abs();
                    assert!(error <= 1e-12 * scale, "{name}, {vectors}, {i}: {found} {expected}");
                }
            }
        }
    }
}

/// Derivatives of a step on scalars, columns in lanes and packed limbs.
#[test]
fn derivatives_of_steps_are_those_of_the_interpreter() {
    for (name, base) in
        [("arm7", Base::Fixed), ("joint_zoo", Base::Fixed), ("quadruped", Base::Floating)]
    {
        let model = robot_on(name, base);
        let mechanism = Mechanism::new(&model);
        let layout = UduLayout::new(&mechanism, &ModuleTree::links(&model));
        let (nq, n) = (model.nq(), model.nv());
        let mut inputs = inputs(nq + 2 * n + 1);
        normalize_configuration(&mechanism, &mut inputs[..nq]);
        let (mut expected, h) = (vec![0.0; nq + n + 6 * n * n], inputs[nq + 2 * n]);
        let (next, rest) = expected.split_at_mut(nq + n);
        let ((next_q, next_qd), (a, b)) = (next.split_at_mut(nq), rest.split_at_mut(4 * n * n));
        let outputs = StepOutputs { q: next_q, qd: next_qd, a, b };
        let (q, forces) = (&inputs[..nq], &inputs[nq + n..nq + 2 * n]);
        let input = TimeStepInput { q, qd: &inputs[nq..nq + n], tau: forces, dt: h };
        let mut interpreter = Interpreter::new(model.clone());
        interpreter.step_semi_implicit_derivatives(input, outputs).expect("lengths");
        let scale = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let agree = |found: Vec<f64>| {
            assert_eq!(found.len(), expected.len());
            for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                let error = (found - expected).abs();
                assert!(error <= 1e-12 * scale, "{name}, {i}: {found} {expected}");
            }
        };
        let tracer = Tracer::new(&mechanism);
        let limbs = limbs_of(&mechanism);
        assert_eq!(limbs.is_some(), name == "quadruped");
        let packed = limbs.as_ref().map(|limbs| tracer.packed(limbs));
        let scalar = optimize(tracer.step_semi_implicit_derivatives(&layout));
        agree(scalar.evaluate(&inputs));
        for tracer in [tracer.column_lanes(4)].into_iter().chain(packed) {
            let graph = optimize(tracer.step_semi_implicit_derivatives(&layout));
            agree(graph.evaluate(&inputs));
            let [in_lanes, on_scalars] = [&graph, &scalar].map(|graph| graph.count().total());
            assert!(in_lanes < on_scalars, "{name}: {in_lanes} {on_scalars}");
        }
    }
}

fn contact(name: &str, kind: ContactKind, link: &str) -> Contact {
    let end = LoopEnd { link: link.into(), xyz: [0.01, 0.02, -0.03], rpy: [0.1, 0.2, 0.3] };
    Contact { name: name.into(), kind, end }
}

fn builder(name: &str) -> Builder {
    Builder::new().urdf(format!("{}/../robots/{name}.urdf", env!("CARGO_MANIFEST_DIR")))
}

/// Derivatives under constraints as products, on scalars and on vectors.
#[test]
fn products_under_constraints_agree_with_straight_line_code() {
    let feet = [
        contact("point", ContactKind::Point, "front_left_foot"),
        contact("sole", ContactKind::Surface, "hind_right_foot"),
    ];
    let legged = builder("quadruped").base(Base::Floating).contacts(feet);
    for (name, builder) in [("quadruped", legged), ("five_bar", builder("five_bar"))] {
        let builder = builder.functions([Function::RandomConfiguration]);
        let model = builder.generate().map_err(|error| error.to_string()).expect("good").model;
        let mechanism = Mechanism::new(&model);
        let layout = UduLayout::new(&mechanism, &ModuleTree::links(&model));
        let tracer = Tracer::new(&mechanism);
        let sizes = Sizes::new(&model, layout.size());
        let of = Function::ConstrainedForwardDynamicsDerivatives.row().arguments.iter();
        let lengths = of.map(|argument| argument.shape(&sizes).len());
        let arguments = lengths.sum();
        let mut inputs = inputs(arguments);
        // All contacts are active, and no row is taken for a dependent one by a large threshold.
        let state = model.nq() + 2 * model.nv();
        let settings = state + model.contacts().len();
        inputs[state..settings].fill(1.0);
        inputs[settings + 2..settings + 4].fill(1e-10);
        let graph = optimize(tracer.constrained_forward_dynamics_derivatives(&layout));
        let expected = graph.evaluate(&inputs);
        let scale = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        for (lanes, execution) in [(1, Execution::Scalar), (4, Execution::Simd)] {
            let loops = DenseLoops { rows: Some(arguments), products: true };
            let tracer = tracer.column_lanes(lanes).with_loops(loops);
            let graph = tracer.constrained_forward_dynamics_derivatives(&layout);
            // Some rows of a planar loop are dependent in all states.
            assert_eq!(graph.dense.rows.is_some(), name == "quadruped");
            let program = Program::try_new(&graph, arguments, execution).expect("valid");
            assert_eq!(program.to_string().parse(), Ok(program.clone()));
            let found = program.evaluate(&inputs);
            assert_eq!(found.len(), expected.len());
            for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                let error = (found - expected).abs();
                assert!(error <= 1e-9 * scale, "{name}, {i}: {found} {expected}");
            }
        }
    }
}

/// Vectors of rows cover their blocks, and have no rows that the matrices lack.
#[test]
fn vectors_of_rows_are_within_their_matrices() {
    for size in 4..=45 {
        for (start, end) in (0..size).flat_map(|s| (s + 1..=size).map(move |end| (s, end))) {
            let block = ProductBlock { columns: 0..1, rows: start..end, terms: Vec::new() };
            let vectors = block.vectors(size);
            let rows = vectors.iter().flat_map(|&(first, count)| first..first + 4 * count);
            let rows: BTreeSet<usize> = rows.collect();
            assert!((start..end).all(|row| rows.contains(&row)), "{size}: {block:?}");
            assert!(rows.last().is_some_and(|&last| last < size), "{size}: {block:?}");
        }
    }
}

/// Matrices that are not whole, products of no results, and other blocks and places than those of their numbers.
#[test]
fn invalid_products_are_found() {
    let model = robot("arm6");
    let mechanism = Mechanism::new(&model);
    let layout = UduLayout::new(&mechanism, &ModuleTree::links(&model));
    let tracer = Tracer::new(&mechanism).with_loops(DenseLoops { rows: None, products: true });
    let graph = tracer.forward_dynamics_derivatives(&layout);
    let program = Program::try_new(&graph, 18, Execution::Scalar).expect("valid");
    let rule = |change: fn(&mut Products)| {
        let mut program = program.clone();
        change(program.products.as_mut().expect("products"));
        program.validate().expect_err("invalid").rule
    };
    let whole = "the matrices of products are whole";
    assert_eq!(rule(|products| products.entries.truncate(99)), whole);
    assert_eq!(rule(|products| products.targets.clear()), whole);
    let results = "the rows of products are added to results";
    assert_eq!(rule(|products| products.targets[0][0].first = 200), results);
    assert_eq!(rule(|products| products.targets[0][0].rows.end = 7), results);
    assert_eq!(rule(|products| products.targets[0][0].by_column = usize::MAX), results);
    let blocks = "the blocks of products are their matrices' nonzeros";
    assert_eq!(rule(|products| products.blocks[0].rows.end = 7), blocks);
    assert_eq!(rule(|products| products.blocks.push(products.blocks[0].clone())), blocks);
    let place = "matrices that are results are in place";
    assert_eq!(rule(|products| products.in_place = Some(0)), place);
    assert_eq!(rule(|products| products.targets[1][0].first += 1), place);
}

/// Loops are taken where there are many products, and where the user chooses the shortest code. They compute what the
/// interpreter computes.
#[test]
fn plans_take_products_in_loops_for_long_or_short_code() {
    let planned = |model: &Model, code: CodeForm, execution: Execution| {
        let functions = vec![Function::ForwardDynamicsDerivatives];
        let choices = Choices { functions, code, ..Choices::default() };
        Plan::new(model, &ModuleTree::links(model), &choices, execution).expect("short")
    };
    let (arm, quadruped) = (robot("arm6"), robot_on("quadruped", Base::Floating));
    let mut expected = vec![0.0; 18 + 3 * 18 * 18];
    let mut inputs = inputs(19 + 2 * 18);
    inputs[3..7].copy_from_slice(&[0.1, -0.5, 0.7, 0.5]);
    let arguments = [&inputs[..19], &inputs[19..37], &inputs[37..]];
    Interpreter::new(quadruped.clone())
        .evaluate(Function::ForwardDynamicsDerivatives, &arguments, 0, &mut expected)
        .expect("lengths");
    let scale = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    for code in [CodeForm::Unrolled, CodeForm::Auto, CodeForm::Looped] {
        let plan = planned(&quadruped, code, Execution::Simd);
        let (scalar, simd) = plan.functions[0].kernels.straight().expect("straight-line code");
        assert!(simd.widths().len() > 1);
        for program in [scalar, simd] {
            assert_eq!(program.products.is_some(), code != CodeForm::Unrolled);
            for (found, expected) in program.evaluate(&inputs).iter().zip(&expected) {
                assert!((found - expected).abs() <= 1e-12 * scale, "{found} {expected}");
            }
        }
        assert_eq!(plan.loops().len(), usize::from(code != CodeForm::Unrolled));
    }
    // An arm has few products, and some back ends have no loops.
    for (model, code, execution, loops) in [
        (arm, CodeForm::Auto, Execution::Simd, false),
        (quadruped.clone(), CodeForm::Auto, Execution::Scalar, true),
        (quadruped.clone(), CodeForm::Looped, Execution::Scalar, true),
        (quadruped, CodeForm::Looped, Execution::Threads, false),
    ] {
        let plan = planned(&model, code, execution);
        let (scalar, _) = plan.functions[0].kernels.straight().expect("straight-line code");
        assert_eq!(scalar.products.is_some(), loops, "{code:?} {execution:?}");
    }
}

/// Derivatives, which are split into chunks, and forward dynamics.
#[test]
fn programs_on_scalars_agree_with_graphs() {
    let mut cut = 0;
    for name in ["arm6", "arm7", "joint_zoo", "quadruped"] {
        let model = robot(name);
        let mechanism = Mechanism::new(&model);
        let tracer = Tracer::new(&mechanism);
        let layout = UduLayout::new(&mechanism, &ModuleTree::links(&model));
        let graph = optimize(tracer.forward_dynamics_derivatives(&layout));
        for target in [Execution::Scalar, Execution::Batch] {
            let program = Program::new(&graph, model.nq() + 2 * model.nv(), target);
            cut += usize::from(program.chunks.len() > 1);
            assert_eq!(program.operations_per_call(), graph.count(), "{name}");
            same(&graph, &program);
        }
        let graph = balance(&optimize(tracer.inverse_dynamics()));
        same(&graph, &Program::new(&graph, model.nq() + 2 * model.nv(), Execution::Scalar));
    }
    assert!(cut >= 4, "{cut} programs were cut");
}

#[test]
fn packed_and_repeated_programs_agree_with_graphs() {
    for name in ["quadruped", "humanoid"] {
        let model = robot(name);
        let mechanism = Mechanism::new(&model);
        let tracer = Tracer::new(&mechanism);
        let partition = ModulePartition::new(&mechanism, &ModuleTree::links(&model));
        for limbs in LimbPacking::candidates(&mechanism, &LIMB_LIMITS, true) {
            let elimination = Elimination::Recursive(limbs.partition(&partition));
            let graph = optimize(tracer.packed(&limbs).forward_dynamics(&elimination));
            let count = model.nq() + 2 * model.nv();
            let simd = Program::try_new(&graph, count, Execution::Simd).expect("valid");
            assert!(simd.widths().len() > 1, "{name}");
            same(&graph, &simd);
            let repeated = Program::repeated(&graph, count).expect("valid");
            assert_eq!(repeated.loops().count(), repeated.statements.len(), "{name}");
            assert!(repeated.tables.iter().any(|table| table.rows.len() > 1), "{name}");
            let (each, all) = (repeated.static_operations(), repeated.operations_per_call());
            assert!(each.total() < all.total(), "{name}");
            same(&graph, &repeated);
        }
    }
}

/// Heron's rule in a loop that ends early, for two numbers of a loop around it, and the sum of both roots.
const ROOTS: &str = "program scalar, 3 arguments
table
row ; 0, 0
row ; 1, 1
table
row 0.5;
row 0.5;
row 0.5;
row 0.5;
row 0.5;
row 0.5;
row 0.5;
row 0.5;
routine 1 constants
program scalar, 3 arguments
x0 = reciprocal(a2)
x1 = fused(a1 * x0 + a2)
x2 = a0 * x1
x3 = x2 - a2
x4 = abs(x3)
x5 = -1e-9 + x4
results x2, -x5
end
routine 0 constants
program scalar, 1 arguments
results 1.0, a0, -1.0
end
x0 = a0 + a1
x1 = loops 3, 2, 1x2
store 0[2] = x0
for 0
call 1 (a[1+0.0]) -> 0[0], 0[1], 2[1]
for 1 until 2[1]
call 0 (0[1], 0[0]) -> 0[0], 2[1]
end
call 1 (0[0]) -> 2[0], 1[0+0.1], 2[1]
call 1 (0[0]) -> 2[0], +0[2], 2[1]
end
end 1[0], 1[1], 0[2]
results x1, x1.1, x1.2
";

#[test]
fn loops_carry_numbers_and_end_early() {
    let program: Program = ROOTS.parse().expect("a program");
    assert_eq!(program.to_string(), ROOTS);
    let [a, b, sum] = program.evaluate(&[0.5_f64, 2.0, 9.0])[..] else { panic!("three results") };
    for (found, expected) in [(a, 2_f64.sqrt()), (b, 3.0), (sum, 2.5 + 2_f64.sqrt() + 3.0)] {
        assert!((found - expected).abs() < 1e-8, "{found} {expected}");
    }
    // The square root of NaN does not end the loop, and is NaN.
    assert!(program.evaluate(&[0.0, f64::NAN, 9.0])[0].is_nan());
    for (line, wrong, rule) in [
        ("for 1 until 2[1]", "for 2 until 2[1]", "a loop has a table"),
        ("for 1 until 2[1]", "for 1 until 2[2]", "an entry of an array is within the array"),
        ("call 1 (a[1+0.0])", "call 1 (a[2+0.0])", "an entry of an array is within the array"),
        ("call 1 (a[1+0.0])", "call 1 (a[1+1.0])", "an entry of an array is within the array"),
        ("call 1 (a[1+0.0])", "call 2 (a[1+0.0])", "a routine that is called exists"),
        ("call 1 (a[1+0.0])", "call 1 (a[1+0.0], a[0])", "a routine has as many arguments"),
        ("row ; 1, 1", "row ; 1, 1, 1", "the rows of a table have the same lengths"),
    ] {
        let wrong = ROOTS.replacen(line, wrong, 1).parse::<Program>().expect_err("invalid");
        assert!(wrong.message.contains(rule), "{line}: {wrong}");
    }
}

#[test]
fn texts_of_programs_are_as_documented() {
    let text = "program scalar, 3 arguments\nx0 = sin_cos(a0)\nx1 = x0.1 * a1\n\
                x2 = fused(-[x0 * a2] + x1)\nresults x2, -x1\n";
    let program: Program = text.parse().expect("a program");
    assert_eq!(program.to_string(), text);
    let (sine, cosine) = (libm::sin(0.3), libm::cos(0.3));
    let found = program.evaluate(&[0.3, 2.0, 5.0]);
    assert!((found[0] - (2.0 * cosine - 5.0 * sine)).abs() < 1e-15 && found[1] == -2.0 * cosine);
}

#[test]
fn texts_that_are_no_programs_are_refused_at_their_line() {
    for (text, line, message) in [
        ("", 1, "the text ends"),
        ("program scalar, x arguments", 1, "does not begin a program"),
        ("program scalar, 1 arguments\nx0 = a0 ? a0\nresults x0", 2, "no operation"),
        ("program scalar, 1 arguments\nx1 = a0 + a0\nresults x0", 2, "the next one is `x0`"),
        ("program scalar, 1 arguments\nx0 = x0 + a0\nresults x0", 2, "no statement before"),
        ("program scalar, 1 arguments\nx0 = fused(a0)\nresults x0", 2, "no fused sum"),
        ("program scalar, 1 arguments\nx0 = a0 + a1\nresults x0", 3, "arguments are counted"),
        ("program scalar, 1 arguments\nx0<4> = pack(a0, a0)\nresults a0", 3, "operands have"),
        ("program scalar, 1 arguments\nresults a0\nx0 = a0 + a0", 3, "ended with"),
    ] {
        let error = text.parse::<Program>().expect_err(text);
        assert!(error.line == line && error.message.contains(message), "{text}\n{error}");
    }
}

/// Each kind of operation, including those that few robots' equations contain.
#[test]
fn every_operation_is_lowered() {
    let graph = Graph::trace(|| {
        let x: Vec<Expr> = (0..6).map(Expr::input).collect();
        let (s, c) = x[0].sin_cos();
        let (late, _) = (s * x[1]).sin_cos();
        let packed = Expr::pack(&[x[1], -x[2], x[3] * x[4], Expr::from_f64(0.5)]);
        let lanes = packed * x[5] - packed * packed;
        vec![
            x[1] * x[2] - x[3] * x[4],
            -(x[1] * x[2]) - x[3],
            late.atan2(c),
            (x[0] * x[0] + x[1] * x[1]).sqrt().ln(),
            (-x[3]).abs().max(x[2]),
            x[1].select_nonnegative(-x[2], x[3]),
            lanes.extract_lane(1) + lanes.extract_lane(3).recip(),
            Expr::from_f64(2.5),
            x[4],
            -x[5],
        ]
    });
    same(&graph, &Program::new(&graph, 6, Execution::Simd));
}

#[test]
fn broken_programs_are_found() {
    let model = robot("arm7");
    let mechanism = Mechanism::new(&model);
    let layout = UduLayout::new(&mechanism, &ModuleTree::links(&model));
    let graph = optimize(Tracer::new(&mechanism).forward_dynamics_derivatives(&layout));
    let good = Program::new(&graph, model.nq() + 2 * model.nv(), Execution::Scalar);
    let broken = |change: fn(&mut Program)| {
        let mut program = good.clone();
        change(&mut program);
        program.validate().expect_err("broken").rule
    };
    let last = |p: &mut Program| p.statements.len() - 1;
    assert_eq!(good.validate(), Ok(()));
    let order = broken(|p| p.statements.reverse());
    assert!(
        ["a value is computed before it is read", "a result that is read is used"].contains(&order)
    );
    assert_eq!(broken(|p| p.arguments = 1), "arguments are counted");
    assert_eq!(broken(|p| p.results[0].source = Source::Argument(999)), "arguments are counted");
    assert_eq!(broken(|p| p.results[0].lanes = 4), "results are scalars");
    assert_eq!(broken(|p| p.first_stores.push(0)), "each result is stored once");
    assert_eq!(
        broken(|p| p.chunks[0].live_out.clear()),
        "a value that crosses a cut is named there"
    );
    assert_eq!(
        broken(|p| p.chunks[1].live_in.clear()),
        "a value that crosses a cut is named there"
    );
    assert_eq!(
        broken(|p| p.chunks[0].statements.end -= 1),
        "chunks are all statements in their order"
    );
    assert_eq!(
        broken(|p| p.chunks[0].scopes.truncate(1)),
        "scopes are all statements of their chunk"
    );
    let lanes = broken(|p| p.statements[0].lanes = 4);
    assert_eq!(lanes, "operands have the lanes of the operation");
    let mut unused = good.clone();
    let end = last(&mut unused);
    unused.statements[end].used.clear();
    let rule = unused.validate().expect_err("broken").rule;
    assert_eq!(rule, "a statement knows which of its results are used, and one is");
    let early = broken(|p| p.statements[0].last_use = 0);
    assert_eq!(early, "no statement reads a value after its last use");
}

/// Machine code of many rows has no equations apart: rows of any rank are counted among a robot's operations then.
#[test]
fn machine_code_of_many_rows_has_them_in_its_program() {
    for (surfaces, apart) in [(2, true), (9, false)] {
        let names: Vec<String> = (0..surfaces).map(|i| format!("c{i}")).collect();
        let contacts = names.iter().map(|name| contact(name, ContactKind::Surface, "lower"));
        let robot = builder("double_pendulum").contacts(contacts);
        let planning = robot.functions([Function::ImpactDynamics]).plan().expect("good");
        let (scalar, _) = planning.plan.functions[0].kernels.straight().expect("one program");
        assert_eq!(scalar.has_row_equations(), apart, "{surfaces}");
    }
}

/// Equations of rows are the program that back ends print of them, also in the signs of zeros: of an inactive contact before rows that depend
/// on each other.
#[test]
fn row_equations_are_their_program() {
    let operand = |number| Operand { source: Source::Argument(number), negated: false, lanes: 1 };
    for side in [1.5, -1.5] {
        let blocks = vec![1, 1, 1];
        let numbers = [0.0, 0.0, 2.0, 0.0, 2.0, 2.0, -0.0, side, side, 1.0, 1.0, 1.0, 1e-10, 1e-10];
        let operands = (0..=numbers.len()).map(operand).collect();
        let equations = RowEquations { blocks: blocks.clone(), sides: 1, operands };
        let program = equations.program();
        let [matrix, sides, scales, tolerances] =
            [0..6, 6..9, 9..12, 12..14].map(|of| numbers[of].to_vec());
        let tolerances = [tolerances[0], tolerances[1]];
        let system = RowSystem { blocks, matrix, sides, scales, tolerances };
        let bits =
            |numbers: Vec<f64>| -> Vec<u64> { numbers.into_iter().map(f64::to_bits).collect() };
        assert_eq!(bits(system.solve()), bits(program.evaluate(&numbers)), "{side}");
    }
}
