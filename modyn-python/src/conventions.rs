//! States of other libraries: modyn's conversions of one joint, for the joints of many states.

use modyn_runtime::conventions::{mujoco, pinocchio};
use numpy::PyReadonlyArrayDyn;
use numpy::prelude::*;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{in_order, tuple};
use crate::memory::filled;

/// The rows of an argument with `N` columns.
struct Rows<'py, const N: usize>(PyReadonlyArrayDyn<'py, f64>);

impl<'py, const N: usize> Rows<'py, N> {
    /// Reads the argument `name` of `function`.
    fn read(function: &str, name: &str, object: &Bound<'py, PyAny>) -> PyResult<Self> {
        let array = in_order::<f64>(function, name, object)?;
        match array.shape() {
            [_, columns] if *columns == N => Ok(Self(array.try_readonly()?)),
            other => Err(PyValueError::new_err(format!(
                "`{name}` of `{function}` has the shape {}; expected (n, {N})",
                tuple(other)
            ))),
        }
    }

    fn as_slice(&self) -> PyResult<&[[f64; N]]> {
        Ok(self.0.as_slice()?.as_chunks().0)
    }
}

/// Returns an array of these rows.
fn array<'py, const N: usize>(
    py: Python<'py>,
    rows: impl ExactSizeIterator<Item = [f64; N]>,
) -> PyResult<Bound<'py, PyAny>> {
    let array = filled(py, &[rows.len(), N], false, |numbers| {
        let places = numbers.as_chunks_mut::<N>().0.iter_mut();
        places.zip(rows).for_each(|(place, row)| *place = row);
        Ok(())
    })?;
    Ok(array.into_any())
}

/// Defines the conversions of states, row by row.
macro_rules! conversions {
    ($($(#[$docs:meta])* $name:ident = $convert:path, ($($argument:ident: $n:literal),+);)*) => {$(
        $(#[$docs])*
        #[pyfunction]
        pub fn $name<'py>(
            py: Python<'py>,
            $($argument: &Bound<'py, PyAny>),+
        ) -> PyResult<Bound<'py, PyAny>> {
            let function = stringify!($name);
            $(let $argument = Rows::<$n>::read(function, stringify!($argument), $argument)?;)+
            $(let $argument = $argument.as_slice()?;)+
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

/// Returns Pinocchio's coordinates of an unbounded revolute joint, (n, 2), from angles, (n, 1).
#[pyfunction]
pub fn pinocchio_cos_sin<'py>(
    py: Python<'py>,
    angles: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let angles = Rows::<1>::read("pinocchio_cos_sin", "angles", angles)?;
    array(py, angles.as_slice()?.iter().map(|&[angle]| pinocchio::cos_sin_from_angle(angle)))
}

/// Returns the angles of an unbounded revolute joint, (n, 1), from Pinocchio's coordinates, (n, 2).
#[pyfunction]
pub fn pinocchio_angle<'py>(
    py: Python<'py>,
    cos_sin: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let cos_sin = Rows::<2>::read("pinocchio_angle", "cos_sin", cos_sin)?;
    array(py, cos_sin.as_slice()?.iter().map(|&both| [pinocchio::angle_from_cos_sin(both)]))
}
