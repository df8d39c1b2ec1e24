//! The table of the functions in `CasADi`'s form.

use crate::plan::functions::Function;

/// The functions in `CasADi`'s form.
///
/// Functions of derivatives are not among them, since `CasADi` has the derivatives of the functions themselves; nor are
/// functions whose results are no matrices of numbers of one state.
pub const FUNCTIONS: &[Function] = &[
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::BiasForces,
    Function::GravityTorques,
    Function::MassMatrix,
    Function::CoriolisMatrix,
    Function::KineticEnergy,
    Function::PotentialEnergy,
    Function::ForwardDynamicsExternal,
    Function::ForwardDynamicsExternalWorld,
    Function::InverseDynamicsExternal,
    Function::InverseDynamicsExternalWorld,
    Function::StepSemiImplicit,
    Function::StepRk4,
    Function::StepImplicitMidpoint,
    Function::CenterOfMass,
    Function::CenterOfMassJacobian,
    Function::CentroidalMomentumMatrix,
    Function::CentroidalMomentum,
    Function::CentroidalMomentumRate,
    Function::LinkPose,
    Function::LinkVelocity,
    Function::LocalLinkVelocity,
    Function::LinkAcceleration,
    Function::LocalLinkAcceleration,
    Function::Jacobian,
    Function::LocalJacobian,
    Function::BiasAcceleration,
    Function::LocalBiasAcceleration,
    Function::Integrate,
    Function::Difference,
    Function::VelocityToQdot,
    Function::Normalize,
];

impl Function {
    /// Returns whether the function has a form for `CasADi`.
    #[must_use]
    pub fn is_for_casadi(self) -> bool {
        FUNCTIONS.contains(&self)
    }
}
