//! The entries of the mass matrix and of its factors U and D that are zero at all coordinates.

use modyn_runtime::Interpreter;
use modyn_runtime::model::{Model, ModuleTree};

use crate::command::outcome::Failure;
use crate::command::random::Random;

/// At how many states it is looked: an entry that is zero at all of them is zero.
const STATES: usize = 4;

/// The largest robot that it is found and drawn for.
const MOST_VELOCITIES: usize = 400;

/// By columns: whether an entry is not zero.
pub struct Sparsity {
    /// Rows and columns.
    pub n: usize,
    /// Of the mass matrix.
    pub mass_matrix: Vec<bool>,
    /// Of U.
    pub u: Vec<bool>,
    /// Of D.
    pub d: Vec<bool>,
}

impl Sparsity {
    /// Of this robot, by these modules.
    pub fn of(model: &Model, modules: &ModuleTree) -> Result<Self, Failure> {
        let n = model.nv();
        if n > MOST_VELOCITIES {
            let why = format!("error: a robot of {n} velocities is too large to draw");
            return Err(Failure::usage(format!("{why}; {MOST_VELOCITIES} are the most")));
        }
        let wrong = |error: &dyn std::fmt::Display| Failure::usage(format!("error: {error}"));
        let interpreter = Interpreter::<f64>::with_modules(model.clone(), modules.clone());
        let mut interpreter = interpreter.map_err(|error| wrong(&error))?;
        let mut found = Self { n, mass_matrix: vec![], u: vec![], d: vec![] };
        let mut q = vec![0.0; model.nq()];
        let mut matrix = vec![0.0; n * n];
        let mut random = Random::new(0);
        for _ in 0..STATES {
            interpreter.random(|| random.uniform(), &mut q).map_err(|error| wrong(&error))?;
            interpreter.mass_matrix(&q, &mut matrix).map_err(|error| wrong(&error))?;
            let factors = interpreter.brge(&q).map_err(|error| wrong(&error))?;
            mark(&mut found.mass_matrix, &matrix);
            mark(&mut found.u, &factors.u());
            mark(&mut found.d, &factors.d());
        }
        Ok(found)
    }
}

/// Adds what is not zero, beside rounding.
fn mark(pattern: &mut Vec<bool>, matrix: &[f64]) {
    let largest = matrix.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    pattern.resize(matrix.len(), false);
    for (marked, x) in pattern.iter_mut().zip(matrix) {
        *marked |= x.abs() > 1e-13 * largest;
    }
}
