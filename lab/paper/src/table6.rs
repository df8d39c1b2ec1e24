//! Table 6 as printed: qdd = I^-1 phi for given phi, one degree of freedom after the other.
//!
//! It uses modyn's frames and spatial algebra, but not its elimination. So it is an independent check of the interpreter,
//! and gives the tables a BRGE-A in the paper's order of operations. Several degrees of freedom of one body come one after
//! the other, without a link in between (A = 1). Modules are consecutive passes of the same two loops, inter- and
//! intra-modular, so the partition does not change the result.

use modyn_runtime::Scalar;
use modyn_runtime::joint::JointTransform;
use modyn_runtime::mechanism::{Dof, Mechanism};
use modyn_runtime::model::Model;
use modyn_runtime::spatial::{ArticulatedInertia, Twist, Wrench};

/// The values of a degree of freedom that the first sweep keeps.
#[derive(Clone, Copy, Debug)]
struct Pivot<S> {
    /// psi: the wrench of a unit motion over m_hat.
    psi: Wrench<S>,
    /// phi_tilde.
    torque: S,
}

/// The contribution of a body to its parent: the articulated inertia M_hat_kk and the wrench eta.
#[derive(Clone, Copy, Debug)]
pub struct Left<S> {
    inertia: ArticulatedInertia<S>,
    wrench: Wrench<S>,
}

/// The recursion for one model without mimic joints.
#[derive(Clone, Debug)]
pub struct Table6<S> {
    model: Mechanism<S>,
}

/// Consecutive bodies at a posture, with the results of the sweeps: a part of the robot that can be computed
/// separately.
#[derive(Clone, Debug)]
pub struct Part<S> {
    first: usize,
    motions: Vec<JointTransform<S>>,
    inertias: Vec<ArticulatedInertia<S>>,
    wrenches: Vec<Wrench<S>>,
    twists: Vec<Twist<S>>,
    pivots: Vec<Pivot<S>>,
}

impl<S: Scalar> Table6<S> {
    /// Returns the recursion for `model`.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        assert!(!model.has_mimics(), "Table 6 knows no joints that follow others");
        Self { model: Mechanism::new(model).cast() }
    }

    /// Returns the bodies.
    #[must_use]
    pub fn bodies(&self) -> usize {
        self.model.bodies.len()
    }

    /// Returns the memory for the bodies in this range.
    #[must_use]
    pub fn part(&self, bodies: core::ops::Range<usize>) -> Part<S> {
        let dofs = self.model.bodies[bodies.clone()].iter().map(|body| body.dofs.len()).sum();
        let pivot = Pivot { psi: Wrench::zero(), torque: S::zero() };
        Part {
            first: bodies.start,
            motions: vec![JointTransform::Prismatic(S::zero()); bodies.len()],
            inertias: self.model.bodies[bodies.clone()]
                .iter()
                .map(|b| b.inertia.articulated())
                .collect(),
            wrenches: vec![Wrench::zero(); bodies.len()],
            twists: vec![Twist::zero(); bodies.len()],
            pivots: vec![pivot; dofs],
        }
    }

    /// The columns "Initialization" and "Find phi_hat and phi_tilde" for one part: rootward, up to the contribution of
    /// its first body to the parent, which is outside; `children` are the contributions of other parts to the bodies of
    /// this part.
    #[allow(clippy::needless_pass_by_value)]
    pub fn eliminate(
        &self,
        part: &mut Part<S>,
        (q, phi): (&[S], &[S]),
        children: &[(usize, Left<S>)],
    ) -> Option<Left<S>> {
        let first = part.first;
        let dofs = self.model.bodies[first].dofs.start;
        for (k, body) in self.model.bodies[first..][..part.motions.len()].iter().enumerate() {
            part.motions[k] = body.motion(q);
            part.inertias[k] = body.inertia.articulated();
            part.wrenches[k] = Wrench::zero();
        }
        for &(body, left) in children {
            part.add(body - first, left);
        }
        for k in (0..part.motions.len()).rev() {
            let body = &self.model.bodies[first + k];
            for (d, dof) in body.dofs.clone().zip(self.model.dofs_of(first + k)).rev() {
                // function_1
                let psi_hat = part.inertias[k].column(dof.component);
                let mut m_hat = psi_hat.components()[dof.component];
                if let Some(armature) = dof.armature {
                    m_hat = m_hat + armature;
                }
                let psi = Wrench::from_components(psi_hat.components().map(|x| x / m_hat));
                let phi_hat = phi[dof.v] - part.wrenches[k].components()[dof.component];
                part.pivots[d - dofs] = Pivot { psi, torque: phi_hat / m_hat };
                // function_2
                let (hat, over) = (psi_hat.components(), psi.components());
                let before = part.inertias[k];
                part.inertias[k] =
                    ArticulatedInertia::from_fn(|i, j| before.entry(i, j) - hat[i] * over[j]);
                part.wrenches[k] +=
                    Wrench::from_components(psi.components().map(|psi| psi * phi_hat));
            }
            let (motion, inertia) = (&part.motions[k], part.inertias[k]);
            let left = Left {
                inertia: body.articulated_to_parent(motion, &inertia),
                wrench: body.wrench_to_parent(motion, part.wrenches[k]),
            };
            match body.parent.map(|parent| parent.checked_sub(first)) {
                Some(Some(parent)) => part.add(parent, left),
                Some(None) => return Some(left),
                None => {}
            }
        }
        None
    }

    /// The column "Find theta_ddot" for one part: outward, from the twist of the parent body outside of it.
    pub fn accelerate(
        &self,
        part: &mut Part<S>,
        carrier: Option<Twist<S>>,
        mut qdd: impl FnMut(&Dof<S>, S),
    ) {
        let dofs = self.model.bodies[part.first].dofs.start;
        for k in 0..part.motions.len() {
            let body = &self.model.bodies[part.first + k];
            let carrier = match body.parent.map(|parent| parent.checked_sub(part.first)) {
                Some(Some(parent)) => Some(part.twists[parent]),
                Some(None) => carrier,
                None => None,
            };
            // function_3
            let mut mu = carrier
                .map_or_else(Twist::zero, |twist| body.twist_to_child(&part.motions[k], twist))
                .components();
            for (d, dof) in body.dofs.clone().zip(self.model.dofs_of(part.first + k)) {
                let Pivot { psi, torque } = part.pivots[d - dofs];
                let torques = psi.components().into_iter().zip(mu).map(|(psi, mu)| psi * mu);
                let acceleration = torques.fold(torque, |sum, torque| sum - torque);
                mu[dof.component] = mu[dof.component] + acceleration;
                qdd(dof, acceleration);
            }
            part.twists[k] = Twist::from_components(mu);
        }
    }

    /// Returns the accelerations qdd = I(q)^-1 phi.
    #[must_use]
    pub fn solve(&self, q: &[S], phi: &[S]) -> Vec<S> {
        let mut part = self.part(0..self.bodies());
        self.eliminate(&mut part, (q, phi), &[]);
        let mut qdd = vec![S::zero(); phi.len()];
        self.accelerate(&mut part, None, |dof, acceleration| qdd[dof.v] = acceleration);
        qdd
    }
}

impl<S: Scalar> Part<S> {
    fn add(&mut self, k: usize, left: Left<S>) {
        self.inertias[k] = self.inertias[k] + left.inertia;
        self.wrenches[k] += left.wrench;
    }

    /// Returns the twist of a body of this part.
    #[must_use]
    pub fn twist(&self, body: usize) -> Twist<S> {
        self.twists[body - self.first]
    }
}
