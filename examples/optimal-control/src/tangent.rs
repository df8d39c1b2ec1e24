//! States of a robot in tangent space: q as a displacement, then qd.

use modyn::na::{DMatrix, DVector};
use modyn::simulate::State;
use modyn::{Array as _, Robot, functions};

/// Returns the displacement that leads from one state to the other, 2 nv entries: that of the coordinates, then the
/// change of the velocities.
pub(crate) fn difference<R>(from: &State<R>, to: &State<R>) -> DVector<f64>
where
    R: Robot + functions::Difference,
{
    let dq = R::difference(&from.q, &to.q);
    let dqd = to.qd.as_ref().iter().zip(from.qd.as_ref()).map(|(to, from)| to - from);
    DVector::from_iterator(2 * R::NV, dq.as_ref().iter().copied().chain(dqd))
}

/// Returns the matrix of these columns.
pub(crate) fn matrix<C: AsRef<[f64]>>(columns: &[C]) -> DMatrix<f64> {
    let rows = columns.first().map_or(0, |column| column.as_ref().len());
    DMatrix::from_fn(rows, columns.len(), |i, j| columns[j].as_ref()[i])
}

/// Returns the coordinates with those beyond the limits of the description moved to the limits.
pub(crate) fn within_limits<R: Robot>(q: &R::Q<f64>) -> R::Q<f64> {
    let limits = R::LIMITS;
    R::Q::<f64>::from_fn(|i| q.as_ref()[i].clamp(limits.lower[i], limits.upper[i]))
}
