//! The paper's gripper, to every printed digit: (A.19)-(A.22) and Table 3.

use std::path::Path;

use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::{Interpreter, UduFactorization};
use modyn_tests::close::assert_close;
use modyn_tests::dense::square;
use modyn_tests::golden;
use modyn_tests::quantities::Quantities;
use nalgebra::DMatrix;

/// theta_11, theta_12, theta_22, theta_13 of (A.19).
const Q: [f64; 4] = [0.0, 0.0, 0.0, std::f64::consts::FRAC_PI_2];
const REST: [f64; 4] = [0.0; 4];

fn gripper() -> Model {
    golden::model(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/gripper.urdf"))
}

fn factorized() -> UduFactorization {
    Interpreter::new(gripper()).factors(&Q)
}

/// The way in which a printed number was cut to its last digit.
#[derive(Clone, Copy)]
enum Cut {
    Rounded,
    Truncated,
}

/// Asserts that the entries of `columns`, divided by `unit`, print as the rows in `printed`; a dash stands for an entry
/// that the paper leaves out.
fn assert_prints(columns: &[f64], unit: f64, cut: Cut, printed: [&str; 4]) {
    let found = square(columns) / unit;
    for (i, row) in printed.iter().enumerate() {
        for (j, text) in row.split_whitespace().enumerate() {
            if text != "-" {
                assert_number(found[(i, j)], cut, text);
            }
        }
    }
}

fn assert_number(found: f64, cut: Cut, text: &str) {
    let printed: f64 = text.parse().expect("a number");
    let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let digit = 0.1_f64.powi(i32::try_from(decimals).expect("few digits"));
    let excess = if printed == 0.0 { found.abs() } else { (found - printed) * printed.signum() };
    let slack = 1e-9;
    let fits = match cut {
        Cut::Rounded => excess.abs() <= 0.5 * digit + slack,
        Cut::Truncated => excess >= -slack && excess < digit + slack,
    };
    assert!(fits, "{found} is not printed as {text}");
}

#[test]
fn modules_are_those_of_figure_1() {
    let model = gripper();
    let tree = ModuleTree::chains(&model);
    let names = |m: usize| -> Vec<&str> {
        tree.modules()[m].links.clone().map(|i| model.moving_links()[i].name.as_str()).collect()
    };
    assert_eq!(tree.modules().len(), 3);
    assert_eq!(names(0), ["link11"]);
    assert_eq!(names(1), ["link12", "link22"]);
    assert_eq!(names(2), ["link13"]);
    let parents: Vec<_> = tree.modules().iter().map(|module| module.parent).collect();
    assert_eq!(parents, [None, Some(0), Some(0)]);
    assert_eq!(tree.modules()[0].children, [1, 2]);
}

#[test]
fn mass_matrix_is_a19_and_table_3() {
    let mass_matrix = Interpreter::new(gripper()).dense_mass_matrix(&Q);
    let printed = [
        "113.3333 33.3333 9.1667 1.6667",
        "33.3333 13.3333 4.1667 0",
        "9.1667 4.1667 1.6667 0",
        "1.6667 0 0 1.6667",
    ];
    assert_prints(&mass_matrix, 1e-4, Cut::Rounded, printed);
    let [a, b, c, d] = [340.0 / 3.0, 100.0 / 3.0, 55.0 / 6.0, 5.0 / 3.0];
    let (e, f) = (40.0 / 3.0, 25.0 / 6.0);
    let exact = [a, b, c, d, b, e, f, 0.0, c, f, d, 0.0, d, 0.0, 0.0, d];
    assert_close("mass matrix * 1e4", &mass_matrix.map_to(1e4), &exact, 1e-14);
    let eigenvalues = square(&mass_matrix).symmetric_eigenvalues();
    let condition = eigenvalues.max() / eigenvalues.min();
    assert_number(condition, Cut::Rounded, "482");
    assert_number(condition, Cut::Rounded, "481.933");
}

trait MapTo {
    fn map_to(&self, factor: f64) -> Vec<f64>;
}

impl MapTo for Vec<f64> {
    fn map_to(&self, factor: f64) -> Vec<f64> {
        self.iter().map(|x| x * factor).collect()
    }
}

#[test]
fn u_and_d_are_a20() {
    let brge = factorized();
    let rest = ["0 1 0 0", "0 0 1 0", "0 0 0 1"];
    let u = brge.u();
    assert_prints(&u, 1.0, Cut::Truncated, ["1 3.571 -3.428 1", rest[0], rest[1], rest[2]]);
    let mut exact = DMatrix::identity(4, 4);
    exact.row_mut(0).copy_from_slice(&[1.0, 25.0 / 7.0, -24.0 / 7.0, 1.0]);
    assert_close("U", &u, exact.as_slice(), 1e-13);

    // The 1 that is printed in the first row's last column is a misprint.
    let printed = ["24.047 0 0 -", "0 13.333 4.166 0", "0 4.166 1.666 0", "0 0 0 1.666"];
    let d = brge.d();
    assert_prints(&d, 1e-4, Cut::Truncated, printed);
    let mut exact = DMatrix::zeros(4, 4);
    exact[(0, 0)] = 505.0 / 21.0;
    exact[(1, 1)] = 40.0 / 3.0;
    (exact[(1, 2)], exact[(2, 1)]) = (25.0 / 6.0, 25.0 / 6.0);
    (exact[(2, 2)], exact[(3, 3)]) = (5.0 / 3.0, 5.0 / 3.0);
    assert_close("D * 1e4", &d.map_to(1e4), exact.as_slice(), 1e-13);
}

#[test]
fn inverse_factors_are_a21() {
    let brge = factorized();
    let printed = ["1 -3.5714 3.4286 -1", "0 1 0 0", "0 0 1 0", "0 0 0 1"];
    assert_prints(&brge.u_inverse(), 1.0, Cut::Rounded, printed);

    let printed = ["0.0416 0 0 -", "0 0.3429 -0.8571 0", "0 -0.8571 2.7429 0", "0 0 0 0.6"];
    let d_inverse = brge.d_inverse();
    assert_prints(&d_inverse, 1e4, Cut::Rounded, printed);
    let mut exact = DMatrix::zeros(4, 4);
    exact[(0, 0)] = 21.0 / 505.0;
    exact[(1, 1)] = 12.0 / 35.0;
    (exact[(1, 2)], exact[(2, 1)]) = (-6.0 / 7.0, -6.0 / 7.0);
    (exact[(2, 2)], exact[(3, 3)]) = (96.0 / 35.0, 0.6);
    assert_close("D^-1 * 1e-4", &d_inverse.map_to(1e-4), exact.as_slice(), 1e-13);
}

#[test]
fn inverse_is_a22() {
    let printed = [
        "0.0416 -0.1485 0.1426 -0.0416",
        "-0.1485 0.8733 -1.3663 0.1485",
        "0.1426 -1.3663 3.2317 -0.1426",
        "-0.0416 0.1485 -0.1426 0.6416",
    ];
    let inverse = factorized().inverse();
    assert_prints(&inverse, 1e4, Cut::Rounded, printed);
    for (found, exact) in inverse.iter().zip(["0.041584", "-0.148515", "0.142574", "-0.041584"]) {
        assert_number(found * 1e-4, Cut::Rounded, exact);
    }
}

#[test]
fn solution_is_table_3() {
    let mut interpreter = Interpreter::new(gripper());
    let phi: Vec<f64> = interpreter.gravity(&Q).iter().map(|x| -x).collect();
    assert_close("phi(0)", &phi, &[-0.8829, -0.1962, -0.04905, 0.0], 1e-14);
    // The last number of the printed column, 0, is missing.
    for (&found, printed) in phi.iter().zip(["-0.8829", "-0.1962"]) {
        assert_number(found, Cut::Rounded, printed);
    }
    assert_number(phi[2], Cut::Rounded, "-0.0491");

    let brge = interpreter.factors(&Q);
    let solved = brge.solve(&phi).expect("four numbers");
    for qdd in [interpreter.qdd(&Q, &REST, &REST), solved] {
        let printed = ["-145.6931", "268.0752", "-163.1762", "145.6931"];
        let exact = ["-145.693069", "268.075248", "-163.176238", "145.693069"];
        for (&found, printed) in qdd.iter().zip(printed).chain(qdd.iter().zip(exact)) {
            assert_number(found, Cut::Rounded, printed);
        }
    }
}

#[test]
fn condition_numbers_of_the_pivots() {
    let brge = factorized();
    assert_eq!(brge.condition_number(0), Some(1.0));
    assert_eq!(brge.condition_number(2), Some(1.0));
    assert_eq!(brge.condition_number(3), None);
    // [[40/3, 25/6], [25/6, 5/3]]: half the trace 7.5, determinant 175/36.
    let root = (7.5_f64 * 7.5 - 175.0 / 36.0).sqrt();
    let expected = (7.5 + root) / (7.5 - root);
    let found = brge.condition_number(1).expect("module 2");
    assert_close("condition number", &[found], &[expected], 1e-12);
}

modyn::modyn! { Compiled = "../../../robots/gripper.urdf" }

/// The compiled gripper has the same numbers.
#[test]
fn the_compiled_gripper_has_the_same_numbers() {
    let interpreted = factorized();
    let compiled = Compiled::brge(&Q);
    let near = |name: &str, found: &[f64], expected: &[f64]| {
        let scale = expected.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() <= 1e-13 * scale, "{name}: {found}, {expected}");
        }
    };
    let mut interpreter = Interpreter::new(gripper());
    near(
        "mass matrix",
        Compiled::mass_matrix(&Q).as_flattened(),
        &interpreter.dense_mass_matrix(&Q),
    );
    near("U", compiled.u().as_flattened(), &interpreted.u());
    near("D", compiled.d().as_flattened(), &interpreted.d());
    near("U^-1", compiled.u_inverse().as_flattened(), &interpreted.u_inverse());
    near("D^-1", compiled.d_inverse().as_flattened(), &interpreted.d_inverse());
    near("I^-1", compiled.inverse().as_flattened(), &interpreted.inverse());
    let mut qdd = [0.0; 4];
    interpreter.forward_dynamics(&Q, &REST, &REST, &mut qdd).expect("four numbers");
    near("qdd", &Compiled::forward_dynamics(&Q, &REST, &REST), &qdd);
    let printed = [-145.6931, 268.0752, -163.1762, 145.6931];
    for (found, printed) in Compiled::forward_dynamics(&Q, &REST, &REST).iter().zip(printed) {
        assert!((found - printed).abs() < 5e-5, "{found} is not printed as {printed}");
    }
}
