//! Finds the entries of the mass matrix and of its factors U and D that are zero at all
//! coordinates.

use modyn_runtime::Interpreter;
use modyn_runtime::model::{Model, ModuleTree};

use crate::random::Random;

/// The number of random states; an entry that is zero at all of them counts as zero.
const STATES: usize = 4;

/// The largest number of velocities for which the pattern is computed and drawn.
const MAX_VELOCITIES: usize = 400;

/// The sparsity patterns by columns: whether an entry is nonzero.
pub struct Sparsity {
    /// The number of rows and columns.
    pub n: usize,
    /// The pattern of the mass matrix.
    pub mass_matrix: Vec<bool>,
    /// The pattern of U.
    pub u: Vec<bool>,
    /// The pattern of D.
    pub d: Vec<bool>,
}

impl Sparsity {
    /// Returns the patterns of a robot with these modules.
    ///
    /// # Errors
    ///
    /// If the robot is too large to draw, or the modules belong to another robot.
    pub fn of(model: &Model, modules: &ModuleTree) -> Result<Self, String> {
        let n = model.nv();
        if n > MAX_VELOCITIES {
            let why = format!("a robot of {n} velocities is too large to draw");
            return Err(format!("{why}; {MAX_VELOCITIES} are the most"));
        }
        let wrong = |error: &dyn std::fmt::Display| error.to_string();
        let created = Interpreter::<f64>::with_modules(model.clone(), modules.clone());
        let mut interpreter = created.map_err(|error| wrong(&error))?;
        let mut sparsity = Self { n, mass_matrix: vec![], u: vec![], d: vec![] };
        let mut q = vec![0.0; model.nq()];
        let mut matrix = vec![0.0; n * n];
        let mut random = Random::new(0);
        for _ in 0..STATES {
            interpreter
                .random_configuration(|| random.uniform(), &mut q)
                .map_err(|error| wrong(&error))?;
            interpreter.mass_matrix(&q, &mut matrix).map_err(|error| wrong(&error))?;
            let factors = interpreter.brge(&q).map_err(|error| wrong(&error))?;
            mark(&mut sparsity.mass_matrix, &matrix);
            mark(&mut sparsity.u, &factors.u());
            mark(&mut sparsity.d, &factors.d());
        }
        Ok(sparsity)
    }
}

/// Adds the entries that are not zero within rounding.
fn mark(pattern: &mut Vec<bool>, matrix: &[f64]) {
    let largest = matrix.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    pattern.resize(matrix.len(), false);
    for (marked, x) in pattern.iter_mut().zip(matrix) {
        *marked |= x.abs() > 1e-13 * largest;
    }
}
