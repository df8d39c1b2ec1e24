//! The functions that controllers and estimators use most, over nalgebra's types (feature `nalgebra`).
//!
//! For all other functions, nalgebra's vectors convert to arrays and back with `.into()`.

use core::marker::PhantomData;

use nalgebra::{
    Isometry3, Matrix3, RealField, Rotation3, SMatrix, SVector, Translation3, UnitQuaternion,
};

use crate::results::{
    ConstrainedForwardDynamics, ConstraintProjection, ConstraintResidual,
    ForwardDynamicsDerivatives, InverseDynamicsDerivatives,
};
use crate::robot::{Constrained, Factorization, Robot, Settings};
use crate::spatial::{Pose, Twist, Vector3};
use crate::{Scalar, functions};

/// The most used functions of a generated robot over `SVector`, `SMatrix` and `Isometry3`:
/// `Nalgebra::<Gripper>::forward_dynamics(&q, &qd, &tau)`.
///
/// The scalar is `f64` by default: `Nalgebra::<Gripper, f32>` uses `f32`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nalgebra<R, T = f64>(PhantomData<(R, T)>);

fn array<T, const N: usize>(vector: &SVector<T, N>) -> &[T; N] {
    let [column] = &vector.data.0;
    column
}

impl<R: Robot, T: Scalar + RealField> Nalgebra<R, T> {
    /// Returns the joint accelerations under the joint forces `tau`.
    #[must_use]
    pub fn forward_dynamics<const NQ: usize, const NV: usize>(
        q: &SVector<T, NQ>,
        qd: &SVector<T, NV>,
        tau: &SVector<T, NV>,
    ) -> SVector<T, NV>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV]> + functions::ForwardDynamics,
    {
        R::forward_dynamics::<T>(array(q), array(qd), array(tau)).into()
    }

    /// Returns the joint forces of the accelerations `qdd`.
    #[must_use]
    pub fn inverse_dynamics<const NQ: usize, const NV: usize>(
        q: &SVector<T, NQ>,
        qd: &SVector<T, NV>,
        qdd: &SVector<T, NV>,
    ) -> SVector<T, NV>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV]> + functions::InverseDynamics,
    {
        R::inverse_dynamics::<T>(array(q), array(qd), array(qdd)).into()
    }

    /// Returns the bias forces: Coriolis, centrifugal and gravity forces.
    #[must_use]
    pub fn bias_forces<const NQ: usize, const NV: usize>(
        q: &SVector<T, NQ>,
        qd: &SVector<T, NV>,
    ) -> SVector<T, NV>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV]> + functions::BiasForces,
    {
        R::bias_forces::<T>(array(q), array(qd)).into()
    }

    /// Returns the joint forces that balance gravity.
    #[must_use]
    pub fn gravity_torques<const NQ: usize, const NV: usize>(q: &SVector<T, NQ>) -> SVector<T, NV>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV]> + functions::GravityTorques,
    {
        R::gravity_torques::<T>(array(q)).into()
    }

    /// Returns the mass matrix.
    #[must_use]
    pub fn mass_matrix<const NQ: usize, const NV: usize>(q: &SVector<T, NQ>) -> SMatrix<T, NV, NV>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV], M<T> = [[T; NV]; NV]> + functions::MassMatrix,
    {
        R::mass_matrix::<T>(array(q)).into()
    }

    /// Returns the factorization U D U^T of the mass matrix by modules; its matrices convert with `.into()`.
    #[must_use]
    pub fn brge<const NQ: usize>(q: &SVector<T, NQ>) -> R::UduFactorization<T>
    where
        R: Robot<Q<T> = [T; NQ]> + functions::Brge,
    {
        R::brge::<T>(array(q))
    }

    /// Returns the solution x of M(q) x = `rhs` with the mass matrix M.
    #[must_use]
    pub fn solve<const NQ: usize, const NV: usize>(
        q: &SVector<T, NQ>,
        rhs: &SVector<T, NV>,
    ) -> SVector<T, NV>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV]> + functions::Brge,
    {
        R::brge::<T>(array(q)).solve(array(rhs)).into()
    }

    /// Returns the kinetic energy, J.
    #[must_use]
    pub fn kinetic_energy<const NQ: usize, const NV: usize>(
        q: &SVector<T, NQ>,
        qd: &SVector<T, NV>,
    ) -> T
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV]> + functions::KineticEnergy,
    {
        R::kinetic_energy::<T>(array(q), array(qd))
    }

    /// Returns the potential energy under gravity, J.
    #[must_use]
    pub fn potential_energy<const NQ: usize>(q: &SVector<T, NQ>) -> T
    where
        R: Robot<Q<T> = [T; NQ]> + functions::PotentialEnergy,
    {
        R::potential_energy::<T>(array(q))
    }

    /// Returns the poses of all links in the world.
    #[must_use]
    pub fn link_poses<const NQ: usize, const LINKS: usize>(
        q: &SVector<T, NQ>,
    ) -> [Isometry3<T>; LINKS]
    where
        R: Robot<Q<T> = [T; NQ], PerLink<Pose<T>> = [Pose<T>; LINKS]> + functions::LinkPoses,
    {
        R::link_poses::<T>(array(q)).map(Isometry3::from)
    }

    /// Returns the derivatives of inverse dynamics with respect to `q` (in tangent space) and `qd`.
    #[must_use]
    pub fn inverse_dynamics_derivatives<const NQ: usize, const NV: usize>(
        q: &SVector<T, NQ>,
        qd: &SVector<T, NV>,
        qdd: &SVector<T, NV>,
    ) -> InverseDynamicsDerivatives<SMatrix<T, NV, NV>>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV], M<T> = [[T; NV]; NV]>
            + functions::InverseDynamicsDerivatives,
    {
        let found = R::inverse_dynamics_derivatives::<T>(array(q), array(qd), array(qdd));
        InverseDynamicsDerivatives { dq: found.dq.into(), dqd: found.dqd.into() }
    }

    /// Returns the derivatives of forward dynamics with respect to `q` (in tangent space), `qd` and `tau`.
    #[must_use]
    pub fn forward_dynamics_derivatives<const NQ: usize, const NV: usize>(
        q: &SVector<T, NQ>,
        qd: &SVector<T, NV>,
        tau: &SVector<T, NV>,
    ) -> ForwardDynamicsDerivatives<SVector<T, NV>, SMatrix<T, NV, NV>>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV], M<T> = [[T; NV]; NV]>
            + functions::ForwardDynamicsDerivatives,
    {
        let found = R::forward_dynamics_derivatives::<T>(array(q), array(qd), array(tau));
        ForwardDynamicsDerivatives {
            qdd: found.qdd.into(),
            dq: found.dq.into(),
            dqd: found.dqd.into(),
            dtau: found.dtau.into(),
        }
    }

    /// Returns the joint accelerations under the joint forces `tau` with the loops closed and the active
    /// contacts held, the constraint wrenches, the residuals and the rank.
    #[must_use]
    pub fn constrained_forward_dynamics<const NQ: usize, const NV: usize>(
        q: &SVector<T, NQ>,
        qd: &SVector<T, NV>,
        tau: &SVector<T, NV>,
        contacts: R::Contacts,
        settings: &Settings<R, T>,
    ) -> Constrained<R, SVector<T, NV>, T>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV]> + functions::ConstrainedForwardDynamics,
    {
        let (q, qd, tau) = (array(q), array(qd), array(tau));
        let found = R::constrained_forward_dynamics::<T>(q, qd, tau, contacts, settings);
        let ConstrainedForwardDynamics { qdd, wrenches, residuals, rank } = found;
        ConstrainedForwardDynamics { qdd: qdd.into(), wrenches, residuals, rank }
    }

    /// Returns the displacement and the relative velocity of each loop constraint.
    #[must_use]
    pub fn constraint_residual<const NQ: usize, const NV: usize>(
        q: &SVector<T, NQ>,
        qd: &SVector<T, NV>,
        settings: &Settings<R, T>,
    ) -> ConstraintResidual<R::PerConstraint<Twist<T>>>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV]> + functions::ConstraintResidual,
    {
        R::constraint_residual::<T>(array(q), array(qd), settings)
    }

    /// Returns the step that closes the loops, the change of velocities that keeps them closed, and the rank.
    #[must_use]
    pub fn project_constraints<const NQ: usize, const NV: usize>(
        q: &SVector<T, NQ>,
        qd: &SVector<T, NV>,
        contacts: R::Contacts,
        settings: &Settings<R, T>,
    ) -> ConstraintProjection<SVector<T, NV>, T>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV]> + functions::ProjectConstraints,
    {
        let found = R::project_constraints::<T>(array(q), array(qd), contacts, settings);
        ConstraintProjection { dq: found.dq.into(), dqd: found.dqd.into(), rank: found.rank }
    }

    /// Returns the pose of a link in the world.
    #[must_use]
    pub fn link_pose<const NQ: usize>(q: &SVector<T, NQ>, link: R::Link) -> Isometry3<T>
    where
        R: Robot<Q<T> = [T; NQ]> + functions::LinkPose,
    {
        R::link_pose::<T>(array(q), link).into()
    }

    /// Returns a link's Jacobian at its origin in world axes: six rows, linear before angular, as in most libraries
    /// that use nalgebra.
    #[must_use]
    pub fn jacobian<const NQ: usize, const NV: usize>(
        q: &SVector<T, NQ>,
        link: R::Link,
    ) -> SMatrix<T, 6, NV>
    where
        R: Robot<Q<T> = [T; NQ], PerVelocity<Twist<T>> = [Twist<T>; NV]> + functions::Jacobian,
    {
        let columns = R::jacobian::<T>(array(q), link);
        SMatrix::from(columns.map(|Twist { angular: Vector3(w), linear: Vector3(v) }| {
            [v[0], v[1], v[2], w[0], w[1], w[2]]
        }))
    }

    /// Returns the centre of mass of the moving links in world axes, m.
    #[must_use]
    pub fn center_of_mass<const NQ: usize>(q: &SVector<T, NQ>) -> SVector<T, 3>
    where
        R: Robot<Q<T> = [T; NQ]> + functions::CenterOfMass,
    {
        R::center_of_mass::<T>(array(q)).into()
    }

    /// Returns the coordinates after the displacement `v` from `q`.
    #[must_use]
    pub fn integrate<const NQ: usize, const NV: usize>(
        q: &SVector<T, NQ>,
        v: &SVector<T, NV>,
    ) -> SVector<T, NQ>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV]> + functions::Integrate,
    {
        R::integrate::<T>(array(q), array(v)).into()
    }

    /// Returns the displacement that leads from one configuration to the other.
    #[must_use]
    pub fn difference<const NQ: usize, const NV: usize>(
        from: &SVector<T, NQ>,
        to: &SVector<T, NQ>,
    ) -> SVector<T, NV>
    where
        R: Robot<Q<T> = [T; NQ], V<T> = [T; NV]> + functions::Difference,
    {
        R::difference::<T>(array(from), array(to)).into()
    }
}

impl<T: RealField> From<Pose<T>> for Isometry3<T> {
    fn from(pose: Pose<T>) -> Self {
        let rows = Matrix3::from(pose.rotation).transpose();
        let rotation =
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rows));
        Self::from_parts(Translation3::from(pose.translation), rotation)
    }
}
