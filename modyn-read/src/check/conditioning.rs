//! Checks whether single precision suffices for a robot's dynamics.

use modyn_runtime::equations::kinematics::coordinates;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::Model;
use modyn_runtime::{Interpreter, Portable, Scalar as _, jacobi};

use super::singular::singular_joints;
use crate::diagnostics::{Code, Diagnostic, Severity, Subject};

/// The number of states at which the condition number is computed.
const STATES: u32 = 8;

/// The largest number of velocities: the eigenvalues take time cubic in it.
const MAX_VELOCITIES: usize = 100;

/// The largest condition number at which single precision, with its 24 bits, is certain to keep two
/// digits.
pub const MAX_CONDITION_F32: f64 = 1e5;

/// Returns the largest condition number (2-norm) of the mass matrix at a few states spread over the
/// joints' ranges. The matrix is scaled to a diagonal of ones. `None` for a robot that is too
/// large, or has joints that move no inertia.
///
/// Elimination does not depend on the units of the joints, nor on the ratio of a shoulder's and a
/// wrist's inertia. The scaled matrix therefore bounds its errors, not the matrix itself (Higham
/// 2002, "Accuracy and Stability of Numerical Algorithms", sect. 10.1).
#[must_use]
pub fn condition_number(model: &Model) -> Option<f64> {
    let nv = model.nv();
    if nv > MAX_VELOCITIES || !singular_joints(model).is_empty() {
        return None;
    }
    let described = Mechanism::new(model);
    // The warning is part of the generated text, which must be the same on every host.
    let mechanism = described.cast::<Portable>();
    let mut interpreter = Interpreter::<Portable>::new(model.clone());
    let mut q = vec![Portable(0.0); model.nq()];
    let mut matrix = vec![Portable(0.0); nv * nv];
    let mut worst = 1.0_f64;
    let mut number = 0.0_f64;
    let mut uniform = || {
        // Multiples of the golden ratio are evenly distributed.
        number = (number + 0.618_033_988_749_894_9).fract();
        Portable(number)
    };
    for _ in 0..STATES {
        coordinates::random(&mechanism, &mut uniform, &mut q);
        interpreter.mass_matrix(&q, &mut matrix).ok()?;
        let scale: Vec<Portable> = (0..nv).map(|i| matrix[i * (nv + 1)].sqrt().recip()).collect();
        for (j, column) in matrix.chunks_mut(nv).enumerate() {
            column.iter_mut().zip(&scale).for_each(|(x, &s)| *x = *x * s * scale[j]);
        }
        worst = worst.max(jacobi::condition_number(&mut matrix, nv).0);
    }
    Some(worst)
}

/// Returns a warning if single precision may not suffice for the robot's dynamics.
#[must_use]
pub fn warning(model: &Model) -> Option<Diagnostic> {
    let number = condition_number(model).filter(|&number| number > MAX_CONDITION_F32)?;
    let message = format!(
        "single precision may keep no digits of the accelerations: the condition number of the \
         mass matrix (scaled to a diagonal of ones) reaches {number:.1e}"
    );
    let help = "use f64, or compare with it at states that matter: the number bounds what is lost, \
                which can be far less; often a link is very light beside what hangs on it";
    let warning = Diagnostic::new(Severity::Warning, Code::IllConditioned, message);
    Some(warning.with_subject(Subject::Robot(model.name().into())).with_help(help))
}
