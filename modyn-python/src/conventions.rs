//! States of other libraries: modyn's conversions of one joint, for the joints of many states.

use modyn_runtime::ContactTarget;
use modyn_runtime::conventions::{mujoco, pinocchio};
use numpy::prelude::*;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Returns the rows of an array with this number of columns.
fn rows<'a, const N: usize>(array: &'a PyReadonlyArray2<'_, f64>) -> PyResult<&'a [[f64; N]]> {
    let wrong = || PyValueError::new_err(format!("the array must have {N} columns, in C order"));
    let is_in_order = array.shape()[1] == N && array.is_c_contiguous();
    if !is_in_order {
        return Err(wrong());
    }
    let (rows, []) = array.as_slice()?.as_chunks::<N>() else { return Err(wrong()) };
    Ok(rows)
}

/// Returns an array of these rows.
fn array<'py, const N: usize>(
    py: Python<'py>,
    rows: impl Iterator<Item = [f64; N]>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows: Vec<[f64; N]> = rows.collect();
    PyArray1::from_slice(py, rows.as_flattened()).reshape([rows.len(), N])
}

/// Defines the conversions of states, row by row.
macro_rules! conversions {
    ($($(#[$docs:meta])* $name:ident = $convert:path, ($($argument:ident: $n:literal),+);)*) => {$(
        $(#[$docs])*
        #[pyfunction]
        pub fn $name<'py>(
            py: Python<'py>,
            $($argument: PyReadonlyArray2<'py, f64>),+
        ) -> PyResult<Bound<'py, PyArray2<f64>>> {
            $(let $argument = rows::<$n>(&$argument)?;)+
            let lengths = [$($argument.len()),+];
            if lengths.iter().any(|&length| length != lengths[0]) {
                return Err(PyValueError::new_err("the arrays have different numbers of states"));
            }
            array(py, (0..lengths[0]).map(|i| $convert($($argument[i]),+)))
        }
    )*};
}

conversions! {
    /// Returns MuJoCo's `qpos` of a free joint, (n, 7).
    mujoco_to_qpos = mujoco::to_qpos, (q: 7);
    /// Returns the coordinates of a floating joint, (n, 7), from MuJoCo's `qpos`.
    mujoco_from_qpos = mujoco::from_qpos, (qpos: 7);
    /// Returns MuJoCo's `qvel` of a free joint, (n, 6); also its forces from modyn's.
    mujoco_to_qvel = mujoco::to_qvel, (q: 7, qd: 6);
    /// Returns the velocities of a floating joint, (n, 6), from MuJoCo's `qvel`; also the forces.
    mujoco_from_qvel = mujoco::from_qvel, (q: 7, qvel: 6);
    /// Returns MuJoCo's `qacc` of a free joint, (n, 6).
    mujoco_to_qacc = mujoco::to_qacc, (q: 7, qd: 6, qdd: 6);
    /// Returns the accelerations of a floating joint, (n, 6), from MuJoCo's `qacc`.
    mujoco_from_qacc = mujoco::from_qacc, (q: 7, qd: 6, qacc: 6);
}

/// Returns `alpha`, `beta` and `compliance` of a contact with MuJoCo's `solref`, an impedance, and a mobility (1/kg).
#[pyfunction]
pub fn mujoco_contact(solref: [f64; 2], impedance: f64, mobility: f64) -> (f64, f64, f64) {
    let target = ContactTarget::<f64>::GROUND.compliant(solref, impedance, mobility);
    (target.alpha, target.beta, target.compliance)
}

/// Returns Pinocchio's coordinates of an unbounded revolute joint, (n, 2), from angles, (n,).
#[pyfunction]
pub fn pinocchio_cos_sin<'py>(
    py: Python<'py>,
    angles: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    array(py, angles.as_slice()?.iter().map(|&angle| pinocchio::cos_sin_from_angle(angle)))
}

/// Returns the angles of an unbounded revolute joint, (n,), from Pinocchio's coordinates, (n, 2).
#[pyfunction]
pub fn pinocchio_angle<'py>(
    py: Python<'py>,
    cos_sin: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let angles = rows::<2>(&cos_sin)?.iter().map(|&both| pinocchio::angle_from_cos_sin(both));
    Ok(PyArray1::from_iter(py, angles))
}
