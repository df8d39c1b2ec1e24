//! The table of the functions in `CasADi`'s form.

use crate::plan::functions::Function;

/// The functions in `CasADi`'s form, with the names of their results.
///
/// Functions of derivatives are not among them, since `CasADi` has the derivatives of the functions themselves; nor are
/// functions whose results are no matrices of numbers of one state.
pub(super) const FUNCTIONS: &[(Function, &[&str])] = &[
    (Function::ForwardDynamics, &["qdd"]),
    (Function::InverseDynamics, &["tau"]),
    (Function::BiasForces, &["tau"]),
    (Function::GravityTorques, &["tau"]),
    (Function::MassMatrix, &["mass_matrix"]),
    (Function::CoriolisMatrix, &["coriolis_matrix"]),
    (Function::KineticEnergy, &["energy"]),
    (Function::PotentialEnergy, &["energy"]),
    (Function::ForwardDynamicsExternal, &["qdd"]),
    (Function::ForwardDynamicsExternalWorld, &["qdd"]),
    (Function::InverseDynamicsExternal, &["tau"]),
    (Function::InverseDynamicsExternalWorld, &["tau"]),
    (Function::StepSemiImplicit, &["q_next", "qd_next"]),
    (Function::StepRk4, &["q_next", "qd_next"]),
    (Function::CenterOfMass, &["position"]),
    (Function::CenterOfMassJacobian, &["jacobian"]),
    (Function::CentroidalMomentumMatrix, &["momentum_matrix"]),
    (Function::CentroidalMomentum, &["momentum"]),
    (Function::LinkPose, &["rotation", "translation"]),
    (Function::LinkVelocity, &["velocity"]),
    (Function::LocalLinkVelocity, &["velocity"]),
    (Function::LinkAcceleration, &["acceleration"]),
    (Function::LocalLinkAcceleration, &["acceleration"]),
    (Function::Jacobian, &["jacobian"]),
    (Function::LocalJacobian, &["jacobian"]),
    (Function::BiasAcceleration, &["acceleration"]),
    (Function::LocalBiasAcceleration, &["acceleration"]),
    (Function::Integrate, &["q_next"]),
    (Function::Difference, &["displacement"]),
    (Function::VelocityToQdot, &["qdot"]),
    (Function::Normalize, &["unit_q"]),
];

impl Function {
    /// Returns whether the function has a form for `CasADi`.
    #[must_use]
    pub fn is_for_casadi(self) -> bool {
        FUNCTIONS.iter().any(|(function, _)| *function == self)
    }
}

#[cfg(test)]
mod tests {
    use super::FUNCTIONS;
    use crate::plan::casadi::family::fields;
    use crate::plan::functions::Trace;
    use crate::plan::shape::{Shape, Sizes};

    /// `CasADi` refuses a function in which an input and a result have the same name.
    #[test]
    fn every_result_has_a_name_of_its_own() {
        let sizes = Sizes { nq: 7, nv: 6, links: 3, moving: 2, ..Sizes::default() };
        for (function, names) in FUNCTIONS {
            let row = function.row();
            assert!(!matches!(row.trace, Trace::Poses) && row.batch_of.is_none(), "{function:?}");
            assert_eq!(fields(&(row.result)(&sizes)).len(), names.len(), "{function:?}");
            let arguments = row.arguments.iter().map(|argument| argument.name);
            let all: Vec<&str> = arguments.chain(names.iter().copied()).collect();
            let mut different = all.clone();
            different.sort_unstable();
            different.dedup();
            assert_eq!(different.len(), all.len(), "{function:?}: {all:?}");
        }
        assert_eq!(fields(&Shape::pose()).len(), 2);
    }
}
