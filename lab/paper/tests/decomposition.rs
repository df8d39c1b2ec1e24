//! The identities of the block decomposition, on random trees with joints of all types and rotors, partitioned into
//! chains, into links and at random.

use modyn_codegen::graph::{Expr, Graph};
use modyn_reproduce::{dense, robots};
use modyn_runtime::equations::{Workspace, paper::Decomposition, paper::Dense};
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::{DecompositionError, Interpreter};

/// The random robots of the main tests.
#[path = "../../../tests/src/random.rs"]
#[allow(dead_code)]
mod random;

type Matrix = Dense<f64>;

const SEEDS: u64 = 12;

/// The decomposition of a robot at a posture.
struct Case {
    interpreter: Interpreter<f64>,
    decomposition: Decomposition<f64>,
    q: Vec<f64>,
    name: String,
}

fn case(model: &Model, modules: ModuleTree, seed: u64) -> Option<Case> {
    let q = random::state(seed, model).q;
    let name = format!("{}, {} modules", model.name(), modules.modules().len());
    let mut interpreter =
        Interpreter::with_modules(model.clone(), modules).expect("its own modules");
    let decomposition = interpreter.decomposition(&q).ok()?;
    Some(Case { interpreter, decomposition, q, name })
}

/// Returns random robots, each with three partitions.
fn cases() -> Vec<Case> {
    let cut = |model: &Model, seed: u64| {
        let modules = random::modules(seed, model);
        [ModuleTree::chains(model), ModuleTree::links(model), modules]
    };
    let cases: Vec<Case> = (0..SEEDS)
        .flat_map(|seed| {
            let links = 2 + usize::try_from(seed % 9).expect("small");
            let models = [random::mixed_tree(seed, links), random::mixed_zoo(seed, links)];
            let of_one = |model: &Model| {
                cut(model, seed)
                    .map(|modules| case(model, modules, seed))
                    .into_iter()
                    .flatten()
                    .collect::<Vec<_>>()
            };
            models.iter().flat_map(of_one).collect::<Vec<_>>()
        })
        .collect();
    assert!(cases.len() > 45, "{} robots without mimics", cases.len());
    cases
}

/// Returns the largest magnitude of an entry; infinity if an entry is NaN.
fn largest(matrix: &Matrix) -> f64 {
    let size = |x: &f64| if x.is_nan() { f64::INFINITY } else { x.abs() };
    matrix.entries.iter().map(size).fold(0.0, f64::max)
}

#[track_caller]
fn assert_same(what: &str, case: &Case, found: &Matrix, expected: &Matrix) {
    assert_eq!((found.rows, found.columns), (expected.rows, expected.columns), "{what}");
    let difference = largest(&found.minus(expected));
    let scale = 1.0 + largest(expected);
    assert!(difference <= 1e-9 * scale, "{what}: {difference:e} of {scale:e} in {}", case.name);
}

/// Returns a square matrix from its columns.
fn columns(numbers: &[f64]) -> Matrix {
    let n = numbers.len().isqrt();
    Dense { rows: n, columns: n, entries: numbers.to_vec() }.transposed()
}

fn product<'a>(n: usize, matrices: impl IntoIterator<Item = Matrix> + 'a) -> Matrix {
    matrices.into_iter().fold(Dense::identity(n), |product, matrix| product.times(&matrix))
}

fn blocks(decomposition: &Decomposition<f64>) -> impl Iterator<Item = (usize, usize)> {
    let s = decomposition.modules();
    (0..s).flat_map(move |i| (0..s).map(move |j| (i, j)))
}

#[test]
fn module_twists_are_propagated() {
    for mut case in cases() {
        let Case { decomposition: d, interpreter, q, .. } = &mut case;
        let denoc = interpreter.denoc(q).expect("lengths");
        let (n_l, n_d) = (d.propagations(), d.all_joints());
        let n = n_l.times(&n_d);
        let qd = random::state(99, interpreter.model()).qd;
        let qd = Dense { rows: qd.len(), columns: 1, entries: qd };
        let twists = n.times(&qd);
        // (A.6): t_i = A_i,beta t_beta + N_i qd_i; the blocks of A give the sizes of rows.
        let mut row = 0;
        let mut starts = Vec::new();
        for i in 0..d.modules() {
            starts.push(row);
            row += d.joints(i).rows;
        }
        let twist = |i: usize| twists.block(starts[i]..starts[i] + d.joints(i).rows, 0..1);
        let mut propagated = Vec::new();
        for i in 0..d.modules() {
            let own = d.joints(i).times(&qd.block(d.entries(i), 0..1));
            let carried = d.parent(i).map(|parent| d.propagation(i, parent).times(&twist(parent)));
            propagated.push(carried.map_or(own.clone(), |carried| carried.plus(&own)));
        }
        // (A.9), (A.11): N_l = (1 - A)^-1 with A of the parents' blocks alone.
        let mut a = Dense::zero(n_l.rows, n_l.rows);
        for i in 0..d.modules() {
            if let Some(parent) = d.parent(i) {
                let block = d.propagation(i, parent);
                for row in 0..block.rows {
                    for column in 0..block.columns {
                        let at = (starts[i] + row) * n_l.rows + starts[parent] + column;
                        a.entries[at] = block.get(row, column).expect("inside");
                    }
                }
            }
        }
        let unity = Dense::identity(n_l.rows);
        let inverted = unity.minus(&a).times(&n_l);
        let link_level = denoc.propagation.times(&denoc.joints);
        for (i, propagated) in propagated.iter().enumerate() {
            assert_same(
                "(A.6)",
                &case,
                propagated,
                &twists.block(starts[i]..starts[i] + propagated.rows, 0..1),
            );
        }
        assert_same("(A.11)", &case, &inverted, &unity);
        assert_same("N_l N_d of modules and of links, (3)", &case, &n, &link_level);
    }
}

#[test]
fn propagations_follow_each_other() {
    for case in cases() {
        let d = &case.decomposition;
        for (j, i) in blocks(d) {
            for h in 0..d.modules() {
                if d.descends_from(j, h) && d.descends_from(h, i) {
                    let through = d.propagation(j, h).times(&d.propagation(h, i));
                    assert_same("A_j,i = A_j,h A_h,i", &case, &through, &d.propagation(j, i));
                }
            }
            if !d.descends_from(j, i) && i != j {
                assert_eq!(largest(&d.propagation(j, i)), 0.0, "(4)");
            }
        }
    }
}

#[test]
fn composite_modules_make_the_mass_matrix() {
    for mut case in cases() {
        let Case { decomposition: d, interpreter, q, .. } = &mut case;
        let n = interpreter.model().nv();
        let mut mass_matrix = vec![0.0; n * n];
        interpreter.mass_matrix(q, &mut mass_matrix).expect("lengths");
        let (n_l, n_d) = (d.propagations(), d.all_joints());
        // (5b), (6): the blocks are M_tilde_i A_i,j.
        let composites = d.masses().congruence(&n_l);
        let mut rotors = columns(&mass_matrix).minus(&composites.congruence(&n_d));
        for i in 0..n {
            let rotor = interpreter_rotor(interpreter.model(), i);
            rotors.entries[i * n + i] -= rotor;
        }
        let mut start = 0;
        let mut starts = Vec::new();
        for i in 0..d.modules() {
            starts.push(start);
            start += d.mass(i).rows;
        }
        let case = &case;
        let d = &case.decomposition;
        assert_same("(5a)", case, &rotors, &Dense::zero(n, n));
        for (i, j) in blocks(d).filter(|(i, j)| i >= j) {
            let found = composites.block(
                starts[i]..starts[i] + d.mass(i).rows,
                starts[j]..starts[j] + d.mass(j).rows,
            );
            assert_same("(6)", case, &found, &d.composite(i).times(&d.propagation(i, j)));
        }
        for i in 0..d.modules() {
            let all = (0..d.modules()).filter(|&j| d.descends_from(j, i));
            let sum =
                all.fold(d.mass(i), |sum, j| sum.plus(&d.mass(j).congruence(&d.propagation(j, i))));
            assert_same("(7) is (8)", case, &d.composite(i), &sum);
        }
        assert_same("(9), (10)", case, &d.mass_matrix(), &columns(&mass_matrix));
    }
}

/// Returns the rotor's inertia at entry `v`.
fn interpreter_rotor(model: &Model, v: usize) -> f64 {
    let link =
        (0..model.moving_links().len()).find(|&i| model.v_range(i).contains(&v)).expect("a joint");
    model.moving_links()[link].joint.dynamics.armature
}

#[test]
fn elementary_matrices_annihilate_block_columns() {
    for case in cases() {
        let d = &case.decomposition;
        let (n, s) = (d.mass_matrix().rows, d.modules());
        assert_same("I^(s+1) is I", &case, &d.eliminated(s), &d.mass_matrix());
        for j in 0..s {
            // (36)-(38), (40).
            let product = d.ebutm(j).times(&d.ebutm_inverse(j));
            assert_same("(40)", &case, &product, &Dense::identity(n));
            let left = d.eliminated(j);
            let above = left.block(0..d.entries(j).start, d.entries(j));
            assert_same("annihilated", &case, &above, &Dense::zero(above.rows, above.columns));
            // The block pivot equals the diagonal block before the elimination.
            let before = d.eliminated(j + 1);
            let pivot = before.block(d.entries(j), d.entries(j));
            assert_same("pivot, (46)", &case, d.pivot(j), &pivot);
            for i in (0..j).filter(|&i| d.descends_from(j, i)) {
                let entry = before.block(d.entries(i), d.entries(j));
                assert_same("U_i,j I_hat_j", &case, &d.u_block(i, j).times(d.pivot(j)), &entry);
            }
        }
        for j in 1..s {
            // (41): all products with the column vanish.
            let sum = d.ebutm_inverse(j).plus(&d.ebutm_inverse(j - 1)).minus(&Dense::identity(n));
            let product = d.ebutm_inverse(j).times(&d.ebutm_inverse(j - 1));
            assert_same("(41)", &case, &product, &sum);
            // (51): without the inverses one product remains.
            let (before, column) = (d.u_column(j - 1), d.u_column(j));
            let left = if d.descends_from(j, j - 1) {
                column.minus(&before.times(&d.u_block(j - 1, j)))
            } else {
                column
            };
            let by = |column: &Matrix, j: usize| column.times(&d.unit_column(j).transposed());
            let expected = Dense::identity(n).minus(&by(&before, j - 1)).minus(&by(&left, j));
            assert_same("(51)", &case, &d.ebutm(j - 1).times(&d.ebutm(j)), &expected);
        }
        // (35), (33): the result is lower triangular, D U^T.
        assert_same("(33), (35)", &case, &d.eliminated(1), &d.d().times(&d.u().transposed()));
    }
}

#[test]
fn u_is_the_product_of_inverse_elementary_matrices() {
    for case in cases() {
        let d = &case.decomposition;
        let (n, s) = (d.mass_matrix().rows, d.modules());
        let chain = product(n, (1..s).rev().map(|j| d.ebutm_inverse(j)));
        assert_same("(39), (43)", &case, &chain, &d.u());
        let sum = (1..s).fold(Dense::identity(n), |sum, j| {
            sum.plus(&d.u_column(j).times(&d.unit_column(j).transposed()))
        });
        assert_same("(42)", &case, &sum, &d.u());
        let (u, diagonal) = (d.u(), d.d());
        assert_same("(44)", &case, &u.times(&diagonal).times(&u.transposed()), &d.mass_matrix());
    }
}

#[test]
fn the_inverse_is_that_of_the_blocks() {
    for case in cases() {
        let d = &case.decomposition;
        let (n, s) = (d.mass_matrix().rows, d.modules());
        let (u, inverse) = (d.u(), d.u_inverse());
        assert_same("(54)", &case, &u.times(&inverse), &Dense::identity(n));
        let chain = product(n, (1..s).map(|j| d.ebutm(j)));
        assert_same("(52)", &case, &chain, &inverse);
        assert_same("D D^-1", &case, &d.d().times(&d.d_inverse()), &Dense::identity(n));
        let mass_matrix_inverse = inverse.transposed().times(&d.d_inverse()).times(&inverse);
        let unity = d.mass_matrix().times(&mass_matrix_inverse);
        let difference = largest(&unity.minus(&Dense::identity(n)));
        let condition = dense::condition_number(&d.mass_matrix().entries);
        assert!(difference < 1e-12 * condition, "(50): {difference:e} in {}", case.name);
        // (53), with signs that agree with (52): column j is -(U'_j + sum of column h times U_h,j).
        for j in 0..s {
            let before = (0..j).filter(|&h| d.descends_from(j, h)).fold(d.u_column(j), |sum, h| {
                let mut column = inverse.block(0..n, d.entries(h));
                for (k, row) in d.entries(h).enumerate() {
                    column.entries[row * column.columns + k] = 0.0;
                }
                sum.plus(&column.times(&d.u_block(h, j)))
            });
            let found = inverse.block(0..d.entries(j).start, d.entries(j));
            let zero = Dense::zero(before.rows, before.columns);
            let expected = zero.minus(&before).block(0..d.entries(j).start, 0..before.columns);
            assert_same("(53)", &case, &found, &expected);
        }
    }
}

#[test]
fn articulated_propagation_passes_the_modules_between() {
    let mut between = 0;
    for case in cases() {
        let d = &case.decomposition;
        for (j, i) in blocks(d).filter(|&(j, i)| d.descends_from(j, i)) {
            if d.parent(j) == Some(i) {
                assert_same("(57)", &case, &d.articulated_propagation(j, i), &d.propagation(j, i));
            }
            for h in (0..d.modules()).filter(|&h| d.descends_from(j, h) && d.descends_from(h, i)) {
                // (56), by any module between the two.
                let through = d.articulated_propagation(j, h).times(&d.phi(h).transposed());
                let found = through.times(&d.articulated_propagation(h, i));
                assert_same("(56)", &case, &found, &d.articulated_propagation(j, i));
                between += 1;
            }
        }
    }
    assert!(between > 100, "{between} modules between two others");
}

#[test]
fn three_modules_in_a_row_are_appendix_a3() {
    let model = random::chain(5, 6);
    let name = |i: usize| model.moving_links()[i].name.as_str();
    let list: Vec<Vec<&str>> =
        [0..1, 1..4, 4..6].map(|r: std::ops::Range<usize>| r.map(name).collect()).into();
    let case = case(&model, ModuleTree::from_names(&model, &list).expect("modules"), 5)
        .expect("no mimics");
    let d = &case.decomposition;
    assert_same("(A.14)", &case, &d.ebutm(1).times(&d.ebutm(2)), &d.u_inverse());
    let between = d.propagation(2, 1).times(&d.phi(1).transposed()).times(&d.propagation(1, 0));
    assert_same("(A.18)", &case, &d.articulated_propagation(2, 0), &between);
    let expected = d.u_block(0, 1).times(&d.u_block(1, 2)).minus(&d.u_block(0, 2));
    assert_same("(A.16), (A.17)", &case, &d.u_inverse_block(0, 2), &expected);
}

#[test]
fn articulated_modules_are_composites_after_elimination() {
    for case in cases() {
        let d = &case.decomposition;
        for i in 0..d.modules() {
            let children = (0..d.modules()).filter(|&j| d.parent(j) == Some(i));
            let sum = children.clone().fold(d.mass(i), |sum, j| {
                let left = d.phi(j).times(d.articulated(j));
                sum.plus(&left.congruence(&d.propagation(j, i)))
            });
            assert_same("(48)", &case, d.articulated(i), &sum);
            assert_same("(47)", &case, d.psi(i), &d.articulated(i).times(&d.joints(i)));
            if children.count() == 0 {
                assert_same(
                    "a terminal module, (8), (48)",
                    &case,
                    d.articulated(i),
                    &d.composite(i),
                );
            }
            // (49): Phi M_hat is symmetric, and the result does not depend on the motion of the module's joints, except
            // through the rotors.
            let left = d.phi(i).times(d.articulated(i));
            assert_same("Phi M_hat", &case, &left, &left.transposed());
            let (joints, own) = (d.joints(i), d.entries(i));
            let rotors = d.pivot(i).minus(&joints.transposed().times(d.psi(i)));
            let inverse = d.d_inverse();
            let entries = own.clone().flat_map(|row| own.clone().map(move |column| (row, column)));
            let entries = entries.map(|(i, j)| inverse.get(i, j).expect("an entry")).collect();
            let inverse = Dense { rows: own.len(), columns: own.len(), entries };
            let held = d.psi(i).times(&inverse).times(&rotors);
            assert_same("Phi M_hat N", &case, &left.times(&joints), &held);
        }
    }
}

#[test]
fn the_interpreter_has_the_same_factors() {
    for case in cases() {
        let d = &case.decomposition;
        let brge = case.interpreter.brge(&case.q).expect("lengths");
        let named = [
            ("U", brge.u(), d.u()),
            ("D", brge.d(), d.d()),
            ("U^-1", brge.u_inverse(), d.u_inverse()),
        ];
        for (what, numbers, expected) in named {
            assert_same(what, &case, &columns(&numbers), &expected);
        }
        // (60): the three steps.
        let phi = random::state(7, case.interpreter.model()).tau;
        let column = Dense { rows: phi.len(), columns: 1, entries: phi.clone() };
        let hat = d.u_inverse().times(&column);
        let tilde = d.d_inverse().times(&hat);
        let qdd = d.u_inverse().transposed().times(&tilde);
        let solved = brge.solve(&phi).expect("lengths");
        let difference: Vec<f64> = solved.iter().zip(&qdd.entries).map(|(a, b)| a - b).collect();
        assert!(dense::norm(&difference) <= 1e-8 * dense::norm(&solved), "(60) in {}", case.name);
    }
}

/// With one link a module the matrices are the 6x6 matrices of the articulated-body algorithm (Featherstone 2008, sect.
/// 7.3), computed here a second time link by link.
#[test]
fn one_link_a_module_is_the_articulated_body_inertia() {
    for seed in 0..SEEDS {
        let model = random::mixed_tree(seed, 8);
        let case = case(&model, ModuleTree::links(&model), seed).expect("no mimics");
        let d = &case.decomposition;
        let mut inertias: Vec<Matrix> = (0..8).map(|i| d.mass(i)).collect();
        for i in (0..8).rev() {
            assert_same("articulated-body inertia", &case, d.articulated(i), &inertias[i]);
            let Some(parent) = model.moving_links()[i].parent else { continue };
            let axis = d.joints(i);
            let force = inertias[i].times(&axis);
            let hold = axis.transposed().times(&force).entries[0];
            let taken = force.times(&force.transposed());
            let mut left = inertias[i].clone();
            left.entries.iter_mut().zip(&taken.entries).for_each(|(x, taken)| *x -= taken / hold);
            let carried = left.congruence(&d.propagation(i, parent));
            inertias[parent] = inertias[parent].plus(&carried);
        }
    }
}

/// Table 6 as printed compared with the interpreter, which uses another elimination.
#[test]
fn table_6_is_the_recursion_on_any_tree() {
    for seed in 0..4 * SEEDS {
        let links = 1 + usize::try_from(seed % 14).expect("small");
        let zoo = random::mixed_zoo(seed, links);
        let model = if zoo.has_mimics() { random::mixed_tree(seed, links) } else { zoo };
        let random::State { q, tau, .. } = random::state(seed, &model);
        let found = modyn_reproduce::table6::Table6::<f64>::new(&model).solve(&q, &tau);
        let expected = Interpreter::<f64>::new(model).brge(&q).and_then(|brge| brge.solve(&tau));
        let expected = expected.expect("lengths");
        let difference: Vec<f64> = found.iter().zip(&expected).map(|(a, b)| a - b).collect();
        assert!(dense::norm(&difference) <= 1e-8 * dense::norm(&expected), "seed {seed}");
    }
}

/// The same matrices on the compiler's expressions: their symbolic form.
#[test]
fn the_matrices_are_symbolic_too() {
    for model in [robots::gripper(), random::chain(3, 3)] {
        let modules = ModuleTree::links(&model);
        let case = case(&model, modules.clone(), 3).expect("no mimics");
        let d = &case.decomposition;
        let graph = Graph::trace(|| {
            let mechanism = Mechanism::new(&model).cast::<Expr>();
            let q: Vec<Expr> = (0..model.nq()).map(Expr::input).collect();
            let workspace = &mut Workspace::new(&mechanism);
            let d = Decomposition::new(&mechanism, &modules, &q, workspace).expect("no mimics");
            let matrices =
                [d.u(), d.d(), d.articulated(0).clone(), d.articulated_propagation(2, 0)];
            matrices.into_iter().flat_map(|matrix| matrix.entries).collect()
        });
        let found = graph.evaluate(&case.q);
        let matrices = [d.u(), d.d(), d.articulated(0).clone(), d.articulated_propagation(2, 0)];
        let expected: Vec<f64> = matrices.into_iter().flat_map(|matrix| matrix.entries).collect();
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() <= 1e-12 * (1.0 + expected.abs()));
        }
        // Entries that are the same in all postures are constants.
        let known = graph.outputs.iter().filter(|&&id| graph.value(id).is_some()).count();
        assert!(known > 0 && known < expected.len(), "{known} of {}", expected.len());
    }
}

#[test]
fn the_gripper_is_eliminated_in_two_stages() {
    let model = robots::gripper();
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    let q = modyn_reproduce::gripper::POSTURE.to_vec();
    let decomposition = interpreter.decomposition(&q).expect("lengths");
    let case = Case { interpreter, decomposition, q, name: "gripper".into() };
    let d = &case.decomposition;
    let (mass_matrix, third, second) = (d.mass_matrix(), d.eliminated(2), d.eliminated(1));
    let block = |matrix: &Matrix, i: usize, j: usize| matrix.block(d.entries(i), d.entries(j));
    // (11), (12): blocks of the modules' own matrices.
    for (i, j) in [(0, 0), (1, 0), (1, 1), (2, 0), (2, 2)] {
        let wrench = d.composite(i).times(&d.propagation(i, j)).times(&d.joints(j));
        let expected = d.joints(i).transposed().times(&wrench);
        assert_same("(11)", &case, &block(&mass_matrix, i, j), &expected);
    }
    for (module, single) in [(0, true), (1, false), (2, true)] {
        let (within, alone) = (d.propagation_within(module), d.joint_motion_propagation(module));
        assert_same("(12)", &case, &d.joints(module), &within.times(&alone));
        assert_eq!(d.joints(module).rows, if single { 6 } else { 12 });
    }
    let links = d.mass(1);
    for (row, column) in [(0, 6), (6, 0)] {
        assert_eq!(largest(&links.block(row..row + 6, column..column + 6)), 0.0, "(14)");
    }
    // (12)-(14): the composites of terminal modules are the modules themselves.
    for module in [1, 2] {
        assert_same("(13)", &case, &d.composite(module), &d.mass(module));
    }
    let sum = [1, 2]
        .iter()
        .fold(d.mass(0), |sum, &j| sum.plus(&d.mass(j).congruence(&d.propagation(j, 0))));
    assert_same("(13)", &case, &d.composite(0), &sum);
    // (15), (18)-(22): module 3 does not change module 2.
    assert_eq!(largest(&block(&mass_matrix, 1, 2)), 0.0, "(11)");
    assert_same("(19)", &case, &block(&third, 1, 1), &block(&mass_matrix, 1, 1));
    assert_same(
        "(20)",
        &case,
        &block(&third, 1, 0),
        &d.psi(1).transposed().times(&d.propagation(1, 0)).times(&d.joints(0)),
    );
    assert_same("(21)", &case, &block(&third, 0, 1), &block(&mass_matrix, 0, 1));
    let left = d.mass(0).plus(&d.mass(1).congruence(&d.propagation(1, 0)));
    let left = left.plus(&d.phi(2).times(&d.mass(2)).congruence(&d.propagation(2, 0)));
    assert_same("(23)", &case, &block(&third, 0, 0), &left.congruence(&d.joints(0)));
    // (25)-(29).
    assert_same("(27)", &case, &block(&second, 0, 0), &d.articulated(0).congruence(&d.joints(0)));
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        assert!(largest(&block(&second, i, j)) < 1e-17, "(29)");
    }
    let upper = |i: usize, j: usize| d.u_block(i, j);
    assert_same("(17), (25)", &case, &d.ebutm(1).times(&d.ebutm(2)).times(&mass_matrix), &second);
    assert_same("(18)", &case, &upper(0, 2).times(d.pivot(2)), &block(&mass_matrix, 0, 2));
    assert_same(
        "(22)",
        &case,
        &block(&third, 0, 0),
        &block(&mass_matrix, 0, 0).minus(&upper(0, 2).times(&block(&mass_matrix, 2, 0))),
    );
    assert_same("(26)", &case, &upper(0, 1).times(&block(&third, 1, 1)), &block(&third, 0, 1));
    let taken = d.psi(2).times(&d.joints(2).transposed());
    let unity = Dense::identity(6).minus(&d.phi(2));
    let held = d.pivot(2).get(0, 0).expect("one joint");
    assert_same(
        "(24)",
        &case,
        &Dense { entries: unity.entries.iter().map(|x| x * held).collect(), ..unity },
        &taken,
    );
    let sum = [1, 2].iter().fold(d.mass(0), |sum, &j| {
        sum.plus(&d.phi(j).times(d.articulated(j)).congruence(&d.propagation(j, 0)))
    });
    assert_same("(28)", &case, d.articulated(0), &sum);
    let inverses = d.ebutm_inverse(2).times(&d.ebutm_inverse(1));
    assert_same("(31), (32)", &case, &inverses.times(&second), &mass_matrix);
    assert_same("(33)", &case, &d.u().times(&second), &mass_matrix);
    assert_same("(34)", &case, &d.d().congruence(&d.u().transposed()), &mass_matrix);
    for j in [1, 2] {
        assert_same("(30)", &case, &d.articulated(j).congruence(&d.joints(j)), d.pivot(j));
        let zero = Dense::zero(1, d.entries(j).len());
        assert_same("(58)", &case, &block(&d.u_inverse(), 0, j), &zero.minus(&upper(0, j)));
    }
    // (59): both are children of module 1.
    for j in [1, 2] {
        assert_same("(59)", &case, &d.articulated_propagation(j, 0), &d.propagation(j, 0));
    }
}

#[test]
fn twists_of_neighbouring_links_are_appendix_a1() {
    let model = robots::gripper();
    let modules = ModuleTree::links(&model);
    let mut interpreter =
        Interpreter::<f64>::with_modules(model, modules).expect("its own modules");
    let d = interpreter.decomposition(&[0.0; 4]).expect("lengths");
    // At zero all axes are parallel, as in the paper: A = [1, a x; 0, 1] with the linear part first, a from
    // link 1^2 back to 1^1, which is 0.1 m along x, and p = [0; e].
    let a = d.propagation(1, 0);
    for i in 0..6 {
        for j in 0..6 {
            let expected = match (i, j) {
                _ if i == j => 1.0,
                (1, 5) => 0.1,
                (2, 4) => -0.1,
                _ => 0.0,
            };
            let found = a.get(i, j).expect("inside");
            assert!((found - expected).abs() < 1e-15, "(A.2), row {i}, column {j}: {found}");
        }
    }
    let axis = d.joint_motion_propagation(1);
    for (found, expected) in axis.entries.iter().zip([0.0, 0.0, 0.0, 0.0, -1.0, 0.0]) {
        assert!((found - expected).abs() < 1e-15, "(A.2)");
    }
}

#[test]
fn a_model_with_mimics_is_refused() {
    let zoo = (0..50).map(|seed| random::zoo(seed, 8)).find(Model::has_mimics).expect("a mimic");
    let q = random::state(1, &zoo).q;
    let mut interpreter = Interpreter::<f64>::new(zoo);
    assert_eq!(interpreter.decomposition(&q).err(), Some(DecompositionError::Mimics));
    let mut gripper = Interpreter::<f64>::new(robots::gripper());
    assert!(matches!(gripper.decomposition(&[0.0]), Err(DecompositionError::Shape(_))));
}
