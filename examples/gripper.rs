//! The gripper of the paper (Shah, Saha and Dutt): module tree, mass matrix, its factorization by modules, and
//! accelerations, each beside the paper's printed numbers.

use core::f64::consts::FRAC_PI_2;

modyn::modyn!("robots/gripper.urdf");

/// Prints a matrix, given by columns, with a title.
fn print(name: &str, columns: &[[f64; 4]; 4]) {
    println!("\n{name}");
    for row in 0..4 {
        let entries: Vec<String> =
            columns.iter().map(|column| format!("{:>12.6}", column[row])).collect();
        println!("  {}", entries.join(""));
    }
}

/// Prints a matrix beside the paper's matrix, with `digits` decimals.
fn compare(name: &str, columns: &[[f64; 4]; 4], scale: f64, printed: &str) {
    print(name, &columns.map(|column| column.map(|x| x * scale)));
    println!("  the paper prints\n    {}", printed.replace('\n', "\n    "));
}

fn main() {
    println!("{}: {} joints", Gripper::NAME, Gripper::NV);
    for (m, module) in Gripper::MODULES.iter().enumerate() {
        let parent = module.parent.map_or_else(|| "the base".into(), |p| format!("M{}", p + 1));
        println!("  M{} on {parent}: links {}", m + 1, module.links.join(", "));
    }

    let q = [0.0, 0.0, 0.0, FRAC_PI_2];
    let rest = [0.0; 4];

    compare(
        "mass matrix I, times 1e4 (A.19)",
        &Gripper::mass_matrix(&q),
        1e4,
        "113.3333  33.3333   9.1667   1.6667\n\
         \x20         13.3333   4.1667   0\n\
         \x20                   1.6667   0\n\
         \x20                            1.6667",
    );
    let brge = Gripper::brge(&q);
    compare("U (A.20)", &brge.u(), 1.0, "first row: 1  3.571  -3.428  1");
    compare("D, times 1e4 (A.20)", &brge.d(), 1e4, "24.047; 13.333, 4.166; 4.166, 1.666; 1.666");
    compare("U^-1 (A.21)", &brge.u_inverse(), 1.0, "first row: 1  -3.5714  3.4286  -1");
    compare(
        "D^-1, times 1e-4 (A.21)",
        &brge.d_inverse(),
        1e-4,
        "0.0416; 0.3429, -0.8571; -0.8571, 2.7429; 0.6",
    );
    compare(
        "I^-1, times 1e-4 (A.22)",
        &brge.inverse(),
        1e-4,
        "0.0416  -0.1485   0.1426  -0.0416\n\
         \x20         0.8733  -1.3663   0.1485\n\
         \x20                   3.2317  -0.1426\n\
         \x20                            0.6416",
    );
    println!("\ncondition numbers of the modules' pivot blocks: {:.4?}", brge.condition_numbers());
    println!("log determinant of I: {:.6}", brge.log_determinant());

    let bias = Gripper::bias_forces(&q, &rest);
    println!("\nphi(0), at rest under gravity: {:.4?}", bias.map(|x| -x));
    println!("  Table 3 prints               [-0.8829, -0.1962, -0.0491, 0]");
    let qdd = Gripper::forward_dynamics(&q, &rest, &rest);
    println!("accelerations:                 {qdd:.4?}");
    println!("  Table 3 prints               [-145.6931, 268.0752, -163.1762, 145.6931]");

    println!("\noperations");
    println!("  forward dynamics  {}", Gripper::FORWARD_DYNAMICS_OPERATIONS);
    println!("  inverse dynamics  {}", Gripper::INVERSE_DYNAMICS_OPERATIONS);
    println!("  mass matrix       {}", Gripper::MASS_MATRIX_OPERATIONS);
    println!("  factorization     {}", Gripper::BRGE_OPERATIONS);
}
