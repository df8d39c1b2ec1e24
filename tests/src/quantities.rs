//! The quantities of an interpreter as returned values, for tests that may allocate.

use modyn_runtime::equations::constraints::ConstrainedCotangent;
use modyn_runtime::equations::derivatives::CentroidalOutputs;
use modyn_runtime::equations::{ForwardInput, Motion};
use modyn_runtime::spatial::{Momentum, Pose, Wrench};
use modyn_runtime::{
    ConstrainedHessianOutputs, ConstraintSettings, ContactTarget, Forces, Interpreter, Scalar,
    UduFactorization,
};

/// The interpreter's methods with their results as return values; each panics if a length is wrong.
#[allow(missing_docs)]
pub trait Quantities<S> {
    fn qdd(&mut self, q: &[S], qd: &[S], tau: &[S]) -> Vec<S>;
    fn tau(&mut self, q: &[S], qd: &[S], qdd: &[S]) -> Vec<S>;
    fn qdd_under(&mut self, q: &[S], qd: &[S], tau: &[S], forces: Forces<'_, S>) -> Vec<S>;
    fn tau_under(&mut self, q: &[S], qd: &[S], qdd: &[S], forces: Forces<'_, S>) -> Vec<S>;
    fn bias(&mut self, q: &[S], qd: &[S]) -> Vec<S>;
    fn gravity(&mut self, q: &[S]) -> Vec<S>;
    /// By columns.
    fn dense_mass_matrix(&mut self, q: &[S]) -> Vec<S>;
    fn kinetic(&mut self, q: &[S], qd: &[S]) -> S;
    fn potential(&mut self, q: &[S]) -> S;
    fn poses(&mut self, q: &[S]) -> Vec<Pose<S>>;
    fn factors(&self, q: &[S]) -> UduFactorization<S>;
    /// The centroidal momentum and its rate, then their derivatives: of the momentum by q, of the rate by q and by qd.
    fn centroidal_derivatives(&mut self, motion: Motion<'_, S>) -> Vec<S>;
    /// The accelerations, the wrenches, the gradients, the blocks of the Hessian and the rank.
    fn constrained_hessian(
        &mut self,
        state: [&[S]; 3],
        weights: ConstrainedCotangent<'_, S>,
        active: &[bool],
        settings: &ConstraintSettings<S, Vec<ContactTarget<S>>>,
    ) -> Vec<S>;
}

const LENGTHS: &str = "the lengths are right";

impl<S: Scalar> Quantities<S> for Interpreter<S> {
    fn qdd(&mut self, q: &[S], qd: &[S], tau: &[S]) -> Vec<S> {
        let mut qdd = vec![S::zero(); self.model().nv()];
        self.forward_dynamics(q, qd, tau, &mut qdd).expect(LENGTHS);
        qdd
    }

    fn tau(&mut self, q: &[S], qd: &[S], qdd: &[S]) -> Vec<S> {
        let mut tau = vec![S::zero(); self.model().nv()];
        self.inverse_dynamics(q, qd, qdd, &mut tau).expect(LENGTHS);
        tau
    }

    fn qdd_under(&mut self, q: &[S], qd: &[S], tau: &[S], forces: Forces<'_, S>) -> Vec<S> {
        let mut qdd = vec![S::zero(); self.model().nv()];
        self.forward_dynamics_external(q, qd, tau, forces, &mut qdd).expect(LENGTHS);
        qdd
    }

    fn tau_under(&mut self, q: &[S], qd: &[S], qdd: &[S], forces: Forces<'_, S>) -> Vec<S> {
        let mut tau = vec![S::zero(); self.model().nv()];
        self.inverse_dynamics_external(q, qd, qdd, forces, &mut tau).expect(LENGTHS);
        tau
    }

    fn bias(&mut self, q: &[S], qd: &[S]) -> Vec<S> {
        let mut tau = vec![S::zero(); self.model().nv()];
        self.bias_forces(q, qd, &mut tau).expect(LENGTHS);
        tau
    }

    fn gravity(&mut self, q: &[S]) -> Vec<S> {
        let mut tau = vec![S::zero(); self.model().nv()];
        self.gravity_torques(q, &mut tau).expect(LENGTHS);
        tau
    }

    fn dense_mass_matrix(&mut self, q: &[S]) -> Vec<S> {
        let mut columns = vec![S::zero(); self.model().nv() * self.model().nv()];
        self.mass_matrix(q, &mut columns).expect(LENGTHS);
        columns
    }

    fn kinetic(&mut self, q: &[S], qd: &[S]) -> S {
        self.kinetic_energy(q, qd).expect(LENGTHS)
    }

    fn potential(&mut self, q: &[S]) -> S {
        self.potential_energy(q).expect(LENGTHS)
    }

    fn poses(&mut self, q: &[S]) -> Vec<Pose<S>> {
        let mut poses = vec![Pose::identity(); self.model().links().len()];
        self.link_poses(q, &mut poses).expect(LENGTHS);
        poses
    }

    fn factors(&self, q: &[S]) -> UduFactorization<S> {
        self.brge(q).expect(LENGTHS)
    }

    fn centroidal_derivatives(&mut self, motion: Motion<'_, S>) -> Vec<S> {
        let mut values = [Momentum::zero(); 2];
        let mut columns = [0; 3].map(|_| vec![Momentum::zero(); self.model().nv()]);
        let ([momentum, rate], [dmomentum_dq, drate_dq, drate_dqd]) = (&mut values, &mut columns);
        let outputs = CentroidalOutputs { momentum, rate, dmomentum_dq, drate_dq, drate_dqd };
        self.centroidal_momentum_derivatives(motion, outputs).expect(LENGTHS);
        values.iter().chain(columns.iter().flatten()).flat_map(Momentum::components).collect()
    }

    fn constrained_hessian(
        &mut self,
        [q, qd, tau]: [&[S]; 3],
        weights: ConstrainedCotangent<'_, S>,
        active: &[bool],
        settings: &ConstraintSettings<S, Vec<ContactTarget<S>>>,
    ) -> Vec<S> {
        let n = self.model().nv();
        let mut wrenches = vec![Wrench::zero(); self.model().constraints()];
        let mut vectors = [0; 4].map(|_| vec![S::zero(); n]);
        let mut matrices = [0; 4].map(|_| vec![S::zero(); n * n]);
        let [qdd, dq, dqd, dtau] = vectors.each_mut().map(Vec::as_mut_slice);
        let outputs = ConstrainedHessianOutputs {
            qdd,
            wrenches: &mut wrenches,
            gradients: [dq, dqd, dtau],
            hessian: matrices.each_mut().map(Vec::as_mut_slice),
        };
        let input = ForwardInput { q, qd, tau };
        let rank = self
            .constrained_forward_dynamics_hessian(input, weights, active, settings, outputs)
            .expect(LENGTHS);
        let wrenches: Vec<S> = wrenches.iter().flat_map(Wrench::components).collect();
        let [qdd, gradients @ ..] = vectors;
        [qdd, wrenches, gradients.concat(), matrices.concat(), vec![rank]].concat()
    }
}

/// Returns the twelve numbers of a pose: the rotation by rows, then the translation.
#[must_use]
pub fn numbers<S: Scalar>(pose: &Pose<S>) -> Vec<S> {
    [pose.rotation.concat(), pose.translation.to_vec()].concat()
}
