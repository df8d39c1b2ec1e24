//! The gripper: Tables 2 and 3, (A.19)-(A.22).

use std::f64::consts::FRAC_PI_2;

use modyn_runtime::Interpreter;

use crate::report::{Report, Table, fixed};
use crate::{dense, robots};

/// theta_11, theta_12, theta_22, theta_13 of (A.19).
pub const POSTURE: [f64; 4] = [0.0, 0.0, 0.0, FRAC_PI_2];

/// The accelerations of Table 3 as printed.
pub const PRINTED: [f64; 4] = [-145.6931, 268.0752, -163.1762, 145.6931];

/// The paper's results for the gripper in that posture, matrices by columns.
#[derive(Clone, Debug)]
pub struct Gripper {
    /// M, (A.19).
    pub mass_matrix: Vec<f64>,
    /// phi(0) of Table 3.
    pub phi: Vec<f64>,
    /// The accelerations of Table 3.
    pub qdd: Vec<f64>,
    /// U, (A.20).
    pub u: Vec<f64>,
    /// D, (A.20).
    pub d: Vec<f64>,
    /// U^-1, (A.21).
    pub u_inverse: Vec<f64>,
    /// D^-1, (A.21).
    pub d_inverse: Vec<f64>,
    /// M^-1, (A.22).
    pub inverse: Vec<f64>,
}

/// Computes the results.
///
/// # Panics
///
/// Never: the lengths are those of the gripper.
#[must_use]
pub fn gripper() -> Gripper {
    let mut interpreter = Interpreter::<f64>::new(robots::gripper());
    let (mut mass_matrix, mut phi, mut qdd) = (vec![0.0; 16], vec![0.0; 4], vec![0.0; 4]);
    let rest = [0.0; 4];
    interpreter.mass_matrix(&POSTURE, &mut mass_matrix).expect("lengths");
    interpreter.gravity_torques(&POSTURE, &mut phi).expect("lengths");
    phi.iter_mut().for_each(|x| *x = -*x);
    interpreter.forward_dynamics(&POSTURE, &rest, &rest, &mut qdd).expect("lengths");
    let brge = interpreter.brge(&POSTURE).expect("lengths");
    let (u, d, inverse) = (brge.u(), brge.d(), brge.inverse());
    let (u_inverse, d_inverse) = (brge.u_inverse(), brge.d_inverse());
    Gripper { mass_matrix, phi, qdd, u, d, u_inverse, d_inverse, inverse }
}

/// Writes the section of the page.
pub fn report(report: &mut Report) {
    let found = gripper();
    report.heading("The gripper: Tables 2 and 3, (A.19)-(A.22)");
    let model = robots::gripper();
    let rows = model.moving_links().iter().zip(["1^1", "1^2", "2^2", "1^3"]).map(|(link, name)| {
        let length = 2.0 * link.inertial.center_of_mass[0];
        let across = format!("{:.4e}", link.inertial.inertia[5]);
        vec![name.into(), fixed(length, 2), fixed(link.inertial.mass, 1), across]
    });
    report
        .text("Table 2, as robots/gripper.urdf has it (the paper prints 3.3333e-4 and 0.4167e-4):");
    report.table(Table::new(
        &["link", "length (m)", "mass (kg)", "Izz about its centre (kg m^2)"],
        rows.collect(),
    ));
    let matrix = |columns: &[f64], unit: f64, decimals: usize| -> Vec<String> {
        let row = |i: usize| {
            (0..4)
                .map(|j| fixed(columns[4 * j + i] / unit, decimals))
                .collect::<Vec<_>>()
                .join("  ")
        };
        (0..4).map(row).collect()
    };
    let named = [
        (
            "I * 1e4, (A.19)",
            matrix(&found.mass_matrix, 1e-4, 4),
            ["113.3333  33.3333  9.1667  1.6667", "sym  13.3333  4.1667  0", "1.6667  0", "1.6667"],
        ),
        (
            "U, (A.20)",
            matrix(&found.u, 1.0, 3),
            ["1  3.571  -3.428  1", "0  1  0  0", "0  0  1  0", "0  0  0  1"],
        ),
        (
            "D * 1e4, (A.20)",
            matrix(&found.d, 1e-4, 3),
            ["24.047  0  0  (1)", "0  13.333  4.166  0", "0  4.166  1.666  0", "0  0  0  1.666"],
        ),
        (
            "U^-1, (A.21)",
            matrix(&found.u_inverse, 1.0, 4),
            ["1  -3.5714  3.4286  -1", "0  1  0  0", "0  0  1  0", "0  0  0  1"],
        ),
        (
            "D^-1 * 1e-4, (A.21)",
            matrix(&found.d_inverse, 1e4, 4),
            ["0.0416  0  0  (1)", "0  0.3429  -0.8571  0", "0  -0.8571  2.7429  0", "0  0  0  0.6"],
        ),
        (
            "I^-1 * 1e-4, (A.22)",
            matrix(&found.inverse, 1e4, 4),
            [
                "0.0416  -0.1485  0.1426  -0.0416",
                "sym  0.8733  -1.3663  0.1485",
                "3.2317  -0.1426",
                "0.6416",
            ],
        ),
    ];
    let rows = named.into_iter().flat_map(|(name, ours, paper)| {
        let named = |i: usize| if i == 0 { name.to_owned() } else { String::new() };
        ours.into_iter()
            .zip(paper)
            .enumerate()
            .map(move |(i, (ours, paper))| vec![named(i), ours, paper.into()])
    });
    report.text(
        "Numbers in brackets belong to no column: the paper's columns run together there. (A.20) is truncated, not rounded.",
    );
    report.table(Table::new(&["matrix", "ours", "paper"], rows.collect()));
    let rows = (0..4).map(|i| {
        let phi = ["-0.8829", "-0.1962", "-0.0491", "(lost)"][i];
        vec![
            (i + 1).to_string(),
            fixed(found.phi[i], 4),
            phi.into(),
            fixed(found.qdd[i], 4),
            fixed(PRINTED[i], 4),
        ]
    });
    report.text("Table 3:");
    report.table(Table::new(
        &["i", "phi(0), ours (N m)", "paper", "qdd(0), ours (rad/s^2)", "paper"],
        rows.collect(),
    ));
    let condition = dense::condition_number(&found.mass_matrix);
    report.text(format!("Condition number of I(0): {condition:.3} (paper: 482)."));
}

#[cfg(test)]
mod tests {
    use super::{Gripper, PRINTED, gripper};
    use crate::dense::condition_number;

    fn assert_prints(columns: &[f64], unit: f64, printed: [[f64; 4]; 4]) {
        for (i, row) in printed.iter().enumerate() {
            for (j, printed) in row.iter().enumerate() {
                let found = columns[4 * j + i] / unit;
                assert!(
                    (found - printed).abs() <= 0.5e-4 + 1e-9,
                    "{found} is not printed as {printed}"
                );
            }
        }
    }

    #[test]
    fn printed_digits_are_found() {
        let Gripper { mass_matrix, phi, qdd, u_inverse, inverse, .. } = gripper();
        let a19 = [
            [113.3333, 33.3333, 9.1667, 1.6667],
            [33.3333, 13.3333, 4.1667, 0.0],
            [9.1667, 4.1667, 1.6667, 0.0],
            [1.6667, 0.0, 0.0, 1.6667],
        ];
        assert_prints(&mass_matrix, 1e-4, a19);
        let rest = [[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        assert_prints(&u_inverse, 1.0, [[1.0, -3.5714, 3.4286, -1.0], rest[0], rest[1], rest[2]]);
        let a22 = [
            [0.0416, -0.1485, 0.1426, -0.0416],
            [-0.1485, 0.8733, -1.3663, 0.1485],
            [0.1426, -1.3663, 3.2317, -0.1426],
            [-0.0416, 0.1485, -0.1426, 0.6416],
        ];
        assert_prints(&inverse, 1e4, a22);
        for (found, printed) in qdd.iter().zip(PRINTED) {
            assert!((found - printed).abs() <= 0.5e-4, "{found} is not printed as {printed}");
        }
        for (found, exact) in phi.iter().zip([-0.8829, -0.1962, -0.04905, 0.0]) {
            assert!((found - exact).abs() < 1e-15);
        }
        assert!((condition_number(&mass_matrix) - 481.933).abs() < 5e-4);
    }
}
