//! The factorization of the mass matrix by kinematic modules, with the operations of its factors.

use modyn_codegen::Function;
use modyn_runtime::UduFactorization;
use numpy::PyArray1;
use numpy::prelude::*;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::Given;
use crate::robot::Robot;

/// The factorization U D U^T of a mass matrix by kinematic modules, of one state.
#[pyclass(frozen, module = "modyn")]
pub struct Factorization {
    factors: UduFactorization<f64>,
    nv: usize,
}

impl Factorization {
    /// Returns a matrix from its columns.
    fn matrix<'py>(&self, py: Python<'py>, columns: Vec<f64>) -> PyResult<Bound<'py, PyAny>> {
        Ok(PyArray1::from_vec(py, columns).reshape([self.nv, self.nv])?.transpose()?.into_any())
    }
}

#[pymethods]
impl Factorization {
    /// Returns the block upper triangular U, (nv, nv).
    fn u<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.matrix(py, self.factors.u())
    }

    /// Returns the block diagonal D, (nv, nv).
    fn d<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.matrix(py, self.factors.d())
    }

    /// Returns the inverse of U, (nv, nv).
    fn u_inverse<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.matrix(py, self.factors.u_inverse())
    }

    /// Returns the inverse of D, (nv, nv).
    fn d_inverse<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.matrix(py, self.factors.d_inverse())
    }

    /// Returns the inverse of the mass matrix, (nv, nv).
    fn inverse<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.matrix(py, self.factors.inverse())
    }

    /// Returns the natural logarithm of the mass matrix's determinant.
    fn log_determinant(&self) -> f64 {
        self.factors.log_determinant()
    }

    /// Returns the solution x, (nv,), of M x = `rhs` with the mass matrix M; `rhs` is (nv,).
    fn solve<'py>(
        &self,
        py: Python<'py>,
        rhs: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let rhs = Given::<f64>::read("solve", "rhs", &[self.nv], rhs)?;
        let x = self.factors.solve(rhs.as_slice()?);
        x.map(|x| PyArray1::from_vec(py, x))
            .map_err(|error| PyValueError::new_err(error.to_string()))
    }
}

#[pymethods]
impl Robot {
    /// Returns the factorization U D U^T of the mass matrix at `q`, (nq,), by kinematic modules, by
    /// block reverse Gaussian elimination. The option `modules` selects the modules. The factors
    /// are in `float64` for every robot.
    fn brge(&self, q: &Bound<'_, PyAny>) -> PyResult<Factorization> {
        self.check_has(Function::Brge)?;
        let q = Given::<f64>::read("brge", "q", &[self.model().nq()], q)?;
        let factorized = self.interpreter()?.brge(q.as_slice()?);
        let factors = factorized.map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(Factorization { factors, nv: self.model().nv() })
    }
}
