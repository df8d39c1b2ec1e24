//! The same calls over nalgebra's types (feature `nalgebra`).

use core::marker::PhantomData;

use nalgebra::{Isometry3, Matrix3, Rotation3, SMatrix, SVector, Translation3, UnitQuaternion};

use crate::robot::{Factorization, Robot};
use crate::spatial::Pose;

/// A generated robot's functions over `SVector`, `SMatrix` and `Isometry3`:
/// `Nalgebra::<Gripper>::forward_dynamics(&q, &qd, &tau)`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nalgebra<R>(PhantomData<R>);

type Vector<const N: usize> = SVector<f64, N>;

fn array<const N: usize>(vector: &Vector<N>) -> &[f64; N] {
    let [column] = &vector.data.0;
    column
}

impl<R: Robot> Nalgebra<R> {
    /// Joint accelerations under the joint torques `tau`.
    #[must_use]
    pub fn forward_dynamics<const NQ: usize, const NV: usize>(
        q: &Vector<NQ>,
        qd: &Vector<NV>,
        tau: &Vector<NV>,
    ) -> Vector<NV>
    where
        R: Robot<Q<f64> = [f64; NQ], V<f64> = [f64; NV]>,
    {
        R::forward_dynamics::<f64>(array(q), array(qd), array(tau)).into()
    }

    /// Joint torques of the accelerations `qdd`.
    #[must_use]
    pub fn inverse_dynamics<const NQ: usize, const NV: usize>(
        q: &Vector<NQ>,
        qd: &Vector<NV>,
        qdd: &Vector<NV>,
    ) -> Vector<NV>
    where
        R: Robot<Q<f64> = [f64; NQ], V<f64> = [f64; NV]>,
    {
        R::inverse_dynamics::<f64>(array(q), array(qd), array(qdd)).into()
    }

    /// Coriolis, centrifugal and gravity torques.
    #[must_use]
    pub fn bias_forces<const NQ: usize, const NV: usize>(
        q: &Vector<NQ>,
        qd: &Vector<NV>,
    ) -> Vector<NV>
    where
        R: Robot<Q<f64> = [f64; NQ], V<f64> = [f64; NV]>,
    {
        R::bias_forces::<f64>(array(q), array(qd)).into()
    }

    /// Joint torques that hold the robot still.
    #[must_use]
    pub fn gravity_torques<const NQ: usize, const NV: usize>(q: &Vector<NQ>) -> Vector<NV>
    where
        R: Robot<Q<f64> = [f64; NQ], V<f64> = [f64; NV]>,
    {
        R::gravity_torques::<f64>(array(q)).into()
    }

    /// The generalized inertia matrix.
    #[must_use]
    pub fn mass_matrix<const NQ: usize, const NV: usize>(q: &Vector<NQ>) -> SMatrix<f64, NV, NV>
    where
        R: Robot<Q<f64> = [f64; NQ], V<f64> = [f64; NV], M<f64> = [[f64; NV]; NV]>,
    {
        R::mass_matrix::<f64>(array(q)).into()
    }

    /// The generalized inertia matrix as U D U^T by modules; its matrices convert with `.into()`.
    #[must_use]
    pub fn brge<const NQ: usize>(q: &Vector<NQ>) -> R::Brge<f64>
    where
        R: Robot<Q<f64> = [f64; NQ]>,
    {
        R::brge::<f64>(array(q))
    }

    /// The x with I(q) x = `rhs`.
    #[must_use]
    pub fn solve<const NQ: usize, const NV: usize>(q: &Vector<NQ>, rhs: &Vector<NV>) -> Vector<NV>
    where
        R: Robot<Q<f64> = [f64; NQ], V<f64> = [f64; NV]>,
    {
        R::brge::<f64>(array(q)).solve(array(rhs)).into()
    }

    /// Kinetic energy, J.
    #[must_use]
    pub fn kinetic_energy<const NQ: usize, const NV: usize>(q: &Vector<NQ>, qd: &Vector<NV>) -> f64
    where
        R: Robot<Q<f64> = [f64; NQ], V<f64> = [f64; NV]>,
    {
        R::kinetic_energy::<f64>(array(q), array(qd))
    }

    /// Potential energy under gravity, J.
    #[must_use]
    pub fn potential_energy<const NQ: usize>(q: &Vector<NQ>) -> f64
    where
        R: Robot<Q<f64> = [f64; NQ]>,
    {
        R::potential_energy::<f64>(array(q))
    }

    /// The poses of all links in the world.
    #[must_use]
    pub fn link_poses<const NQ: usize, const LINKS: usize>(
        q: &Vector<NQ>,
    ) -> [Isometry3<f64>; LINKS]
    where
        R: Robot<Q<f64> = [f64; NQ], Poses<f64> = [Pose<f64>; LINKS]>,
    {
        R::link_poses::<f64>(array(q)).map(Isometry3::from)
    }
}

impl From<Pose<f64>> for Isometry3<f64> {
    fn from(pose: Pose<f64>) -> Self {
        let rows = Matrix3::from(pose.rotation).transpose();
        let rotation =
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rows));
        Self::from_parts(Translation3::from(pose.translation), rotation)
    }
}
