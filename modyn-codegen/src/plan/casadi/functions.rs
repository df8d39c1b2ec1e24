//! The table of the functions in `CasADi`'s form.

use crate::plan::functions::Function;

/// The functions in `CasADi`'s form.
///
/// Functions of derivatives are not among them, since `CasADi` has the derivatives of the functions themselves; nor are
/// functions whose results are no matrices of numbers of one state.
pub(super) const FUNCTIONS: &[Function] = &[
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

#[cfg(test)]
mod tests {
    use super::FUNCTIONS;
    use crate::plan::Function;
    use crate::plan::casadi::family::results;
    use crate::plan::functions::Trace;
    use crate::plan::shape::Sizes;

    /// `CasADi` refuses a function in which an input and a result have the same name.
    #[test]
    fn every_result_has_a_name_of_its_own() {
        let sizes = Sizes { nq: 7, nv: 6, links: 3, moving: 2, ..Sizes::default() };
        for function in FUNCTIONS {
            let row = function.row();
            assert!(!matches!(row.trace, Trace::Poses) && row.batch_of.is_none(), "{function:?}");
            let arguments = row.arguments.iter().map(|argument| argument.name.to_string());
            let results = results(*function, &sizes).into_iter().map(|(name, _)| name);
            let all: Vec<String> = arguments.chain(results).collect();
            let mut different = all.clone();
            different.sort_unstable();
            different.dedup();
            assert_eq!(different.len(), all.len(), "{function:?}: {all:?}");
        }
        let names = |function| results(function, &sizes).into_iter().map(|(name, _)| name);
        assert!(names(Function::StepRk4).eq(["q_next", "qd_next"]));
        assert!(names(Function::StepImplicitMidpoint).eq(["q_next", "qd_next"]));
        assert!(names(Function::LinkPose).eq(["rotation", "translation"]));
        assert!(names(Function::ForwardDynamics).eq(["qdd"]));
    }
}
