//! Whole functions compute the bits of their program's evaluation with all instruction sets of
//! x86-64, also those that the host lacks: they are emulated. They read only their arguments and
//! constants, and write only their results and their frame. On aarch64 its own functions run
//! instead.

use modyn_codegen::graph::{Expr, Graph};
use modyn_codegen::program::{Execution, Program};
use modyn_codegen::{Base, ContactKind, Function};
use modyn_runtime::Scalar;
use modyn_tests::conformance::{contact, robot};
use modyn_tests::random::{Random, seeds};

use super::emulator::{ATAN2, Emulator, LOGARITHM, REDUCE};
use super::{Fuse, evaluate, numbers, plan, split};
use crate::assembly::Assembly;
use crate::helper::{Helpers, Linkage};
use crate::instruction_set::InstructionSet;
use crate::machine::Pages;

/// Compares a program with one instruction set, for one state or with a state in each lane.
fn compare<F: Fuse>(
    program: &Program,
    arrays: &[usize],
    instruction_set: InstructionSet,
    batch: bool,
    state: &[F],
) {
    let helpers = match instruction_set.architecture() {
        "x86_64" => Helpers { reduce: REDUCE, atan2: ATAN2, logarithm: LOGARITHM },
        _ => Helpers::new::<F>(),
    };
    let mut assembly = Assembly::<F>::new(instruction_set, batch, Linkage::Addresses(helpers));
    let (code, _) = assembly.append(program, arrays, batch, None);
    assert_eq!(assembly.kernels.len(), 1 + usize::from(program.has_row_equations()), "forms");
    let lanes = if batch { instruction_set.vector(true) / size_of::<F>() } else { 1 };
    // The lanes differ: the numbers of one state, rotated.
    let states: Vec<Vec<F>> = (0..lanes)
        .map(|lane| {
            let mut state = state.to_vec();
            let by = lane % state.len().max(1);
            state.rotate_left(by);
            state
        })
        .collect();
    let flat: Vec<F> = (0..state.len()).flat_map(|i| states.iter().map(move |s| s[i])).collect();
    let given = split(&flat, &code.arguments);
    let results = if instruction_set.architecture() == "x86_64" {
        Emulator::default().run(&assembly.code, code.entry, &given, code.results)
    } else {
        let pages = Pages::new(&assembly.code).expect("executable memory");
        let mut numbers = vec![F::from_f64(f64::NAN); code.results];
        code.call(&pages, &given, &mut numbers);
        numbers
    };
    for (lane, state) in states.iter().enumerate() {
        let expected = evaluate(program, instruction_set, state);
        for (i, expected) in expected.iter().enumerate() {
            let number = results[i * lanes + lane];
            assert!(number.is_same(*expected), "{instruction_set:?} {i}: {number:?} {expected:?}");
        }
    }
}

/// Returns the instruction sets that are emulated; on aarch64 the host's instruction sets, whose
/// functions run.
fn instruction_sets() -> impl Iterator<Item = InstructionSet> {
    let host = InstructionSet::detect().map(InstructionSet::architecture);
    let architecture = if host == Some("aarch64") { "aarch64" } else { "x86_64" };
    InstructionSet::ALL.into_iter().filter(move |set| set.architecture() == architecture)
}

fn all_levels<F: Fuse>(scalar: &Program, simd: &Program, arrays: &[usize], state: &[F]) {
    for instruction_set in instruction_sets() {
        compare(simd, arrays, instruction_set, false, state);
        compare(scalar, arrays, instruction_set, true, state);
    }
}

/// Robots with packed limbs, loops, spherical joints and long functions.
#[test]
fn robots() {
    let functions = [
        Function::ForwardDynamics,
        Function::ForwardDynamicsDerivatives,
        Function::Difference,
        Function::RandomConfiguration,
    ];
    for name in ["arm6", "joint_zoo", "quadruped", "gripper"] {
        let planning = plan(name, &functions);
        for planned in &planning.plan.functions {
            let Some((scalar, simd)) = planned.kernels.straight() else { continue };
            let arrays = planned.lengths();
            let count = arrays.iter().sum();
            for scale in [1.5, 3e5] {
                all_levels::<f64>(scalar, simd, &arrays, &numbers(1, count, scale));
                all_levels::<f32>(scalar, simd, &arrays, &numbers(2, count, scale));
            }
        }
    }
}

/// Contacts whose rows are dependent where two points of one link are active: the guards find these
/// states.
#[test]
fn contacts() {
    let feet = [
        contact("right", ContactKind::Point, "hind_right_foot", [0.03, -0.01, 0.02]),
        contact("toe", ContactKind::Point, "front_left_foot", [0.0, 0.01, -0.02]),
        contact("heel", ContactKind::Point, "front_left_foot", [0.03, -0.01, 0.02]),
    ];
    let functions = [Function::ConstrainedForwardDynamics, Function::ImpactDynamics];
    let builder = robot("quadruped").base(Base::Floating).contacts(feet).functions(functions);
    for planned in &builder.plan().expect("good").plan.functions {
        let (scalar, simd) = planned.kernels.straight().expect("one program");
        assert!(scalar.has_row_equations());
        let arrays = planned.lengths();
        let mut state = numbers(1, arrays.iter().sum(), 1.0);
        // The contacts follow the other arguments; then the settings.
        let first = arrays[..planned.arguments.len() - 2].iter().sum::<usize>();
        for active in [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]] {
            state[first..first + 3].copy_from_slice(&active);
            all_levels::<f64>(scalar, simd, &arrays, &state);
            let state: Vec<f32> = state.iter().map(|&x: &f64| x as f32).collect();
            all_levels::<f32>(scalar, simd, &arrays, &state);
        }
    }
}

/// Random programs of all operations, with vectors of all lengths, many values alive at once, signs
/// and constants.
fn random_program(seed: u64, inputs: usize) -> Program {
    let mut random = Random::new(seed);
    let graph = Graph::trace(|| {
        // Expressions, each with its number of lanes.
        let mut values: Vec<(usize, Expr)> = (0..inputs).map(|i| (1, Expr::input(i))).collect();
        for _ in 0..random.below(200) + 20 {
            let lanes = [1, 2, 4, 8][random.below(4)];
            let mut pick = || {
                let fits = values.iter().filter(|(n, _)| *n == 1 || *n == lanes);
                let of_lanes: Vec<(usize, Expr)> = fits.copied().collect();
                let (lanes, x) = of_lanes[random.below(of_lanes.len())];
                match random.below(8) {
                    0 => (lanes, -x),
                    1 => (1, Expr::from_f64([1.0, -0.5, 0.0, 3.25, -2.0][random.below(5)])),
                    _ => (lanes, x),
                }
            };
            let picked = [(); 4].map(|()| pick());
            let [a, b, c, d] = picked.map(|(_, x)| x);
            let (operands, result) = match random.below(16) {
                0 | 1 => (2, a + b),
                2 | 3 => (2, a - b),
                4 => (2, a * b),
                5 | 6 => (3, a * b + c),
                7 => (3, a * b - c),
                8 => (3, c - a * b),
                9 => (4, a * b - c * d),
                10 => (2, a.sin_cos().0 * b.sin_cos().1),
                11 => (3, a.select_nonnegative(b, c)),
                12 => (2, a.abs().max(b)),
                13 => (1, a.recip()),
                14 => (1, a.abs().sqrt()),
                _ if random.chance(0.3) => (3, a.atan2(b) + c.abs().ln()),
                _ => {
                    let scalars: Vec<Expr> =
                        values.iter().filter(|(n, _)| *n == 1).map(|(_, x)| *x).collect();
                    let count = [2, 4, 8][random.below(3)];
                    let packed: Vec<Expr> =
                        (0..count).map(|_| scalars[random.below(scalars.len())]).collect();
                    values.push((count, Expr::pack(&packed)));
                    continue;
                }
            };
            let lanes = picked[..operands].iter().map(|(lanes, _)| *lanes).max().unwrap_or(1);
            values.push((lanes, result));
            if lanes > 1 && random.chance(0.3) {
                values.push((1, result.extract_lane(random.below(lanes))));
            }
        }
        let last = values.iter().rev().take(60);
        last.flat_map(|&(lanes, x)| {
            (0..lanes).map(move |k| if lanes > 1 { x.extract_lane(k) } else { x })
        })
        .collect()
    });
    Program::new(&graph, inputs, Execution::Simd)
}

#[test]
fn random_programs() {
    let mut results = 0;
    let seeds = seeds(60);
    let programs = usize::try_from(seeds.end - seeds.start).expect("few seeds");
    for seed in seeds {
        // Few arrays of arguments, or as many as a function can have.
        let arrays = if seed % 2 == 0 { &[7, 5, 2][..] } else { &[2, 1, 3, 1, 1, 2, 1, 3] };
        let count = arrays.iter().sum();
        let program = random_program(seed, count);
        results += program.results.len();
        for instruction_set in instruction_sets() {
            compare::<f64>(&program, arrays, instruction_set, false, &numbers(seed, count, 3.0));
            compare::<f32>(&program, arrays, instruction_set, false, &numbers(seed, count, 3.0));
            if program.widths().len() == 1 {
                compare::<f64>(&program, arrays, instruction_set, true, &numbers(seed, count, 1e6));
            }
        }
    }
    assert!(results > 50 * programs, "{results}");
}

/// Arguments, results and a stack frame that are longer than the offsets of instructions reach.
#[test]
fn long_functions() {
    const COUNT: usize = 9000;
    let graph = Graph::trace(|| {
        let sums: Vec<Expr> =
            (0..COUNT).map(|i| Expr::input(i) + Expr::input((i + 7) % COUNT)).collect();
        let total = sums.iter().fold(Expr::from_f64(0.5), |total, &sum| total * sum + sum);
        sums.iter().map(|&sum| sum * total.recip()).collect()
    });
    let program = Program::new(&graph, COUNT, Execution::Simd);
    for instruction_set in instruction_sets() {
        for batch in [false, true] {
            compare::<f64>(&program, &[COUNT], instruction_set, batch, &numbers(1, COUNT, 1.5));
        }
    }
}
