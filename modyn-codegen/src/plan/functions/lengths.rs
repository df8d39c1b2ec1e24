//! The estimated length of a function's text in bytes. The factors were fitted to chains and trees of 6 to 48 joints in general
//! position.

use modyn_runtime::quantities::Function;

use crate::plan::Measures;

/// Returns the estimated length of the derivatives of constrained forward dynamics.
fn constrained_derivatives(m: &Measures) -> f64 {
    1400.0 * m.depths
        + 800.0 * m.squares
        + 90.0 * m.nv.powi(3)
        + 9000.0 * m.reach
        + 5000.0 * m.row_reach
        + 120.0 * m.constraint_rows * m.entries
        + 500.0 * m.constraint_rows.powi(2) * m.nv
}

/// Returns the estimated length of the text of a function.
pub(crate) fn estimated_length(function: Function, m: &Measures) -> f64 {
    match function {
        Function::ForwardDynamics => 14_000.0 * m.carried + 600.0 * m.links,
        Function::InverseDynamics => 8000.0 * m.carried + 600.0 * m.links,
        Function::BiasForces => 8000.0 * m.carried + 600.0 * m.links,
        Function::GravityTorques => 900.0 * m.links,
        Function::MassMatrix => 1400.0 * m.depths + 10.0 * m.entries,
        Function::CoriolisMatrix => 3000.0 * (m.depths + m.carried) + 60.0 * m.entries,
        Function::Brge => {
            1000.0 * m.depths + 130.0 * m.squares + 40.0 * m.entries + 25.0 * m.pivots
        }
        Function::KineticEnergy => 1800.0 * m.carried + 100.0 * m.links,
        Function::PotentialEnergy => 500.0 * m.links,
        Function::ForwardDynamicsExternal => 14_000.0 * m.carried + 1500.0 * m.frames,
        Function::ForwardDynamicsExternalWorld => 14_000.0 * m.carried + 1500.0 * m.frames,
        Function::InverseDynamicsExternal => 6000.0 * m.carried + 1500.0 * m.frames,
        Function::InverseDynamicsExternalWorld => 6000.0 * m.carried + 1500.0 * m.frames,
        Function::GeneralizedForces => 900.0 * m.depths + 60.0 * m.entries + 1500.0 * m.frames,
        Function::GeneralizedForcesWorld => {
            1500.0 * m.depths + 2000.0 * m.links + 60.0 * m.entries + 1500.0 * m.frames
        }
        Function::InverseDynamicsDerivatives => 5000.0 * (m.depths + m.carried) + 100.0 * m.entries,
        Function::ForwardDynamicsDerivatives => {
            5000.0 * m.depths + 600.0 * m.squares + 100.0 * m.entries
        }
        Function::InverseDynamicsVjp => 24_000.0 * m.carried + 1800.0 * m.links,
        Function::InverseDynamicsJvp => 24_000.0 * m.carried + 1800.0 * m.links,
        Function::ForwardDynamicsVjp => 40_000.0 * m.carried + 3000.0 * m.links,
        Function::ForwardDynamicsJvp => 40_000.0 * m.carried + 3000.0 * m.links,
        Function::InverseDynamicsHessian => 18_000.0 * m.depths + 150.0 * m.entries,
        Function::ForwardDynamicsHessian => {
            18_000.0 * m.depths + 1800.0 * m.squares + 150.0 * m.entries
        }
        Function::StepSemiImplicit => 14_000.0 * m.carried + 800.0 * m.links,
        Function::StepSemiImplicitDerivatives => {
            5000.0 * m.depths + 600.0 * m.squares + 350.0 * m.entries
        }
        Function::StepSemiImplicitHessian => {
            18_000.0 * m.depths + 1800.0 * m.squares + 500.0 * m.entries
        }
        Function::StepRk4 => 56_000.0 * m.carried + 3200.0 * m.links,
        Function::StepRk4Derivatives => {
            // Four times the derivatives of forward dynamics, and products of matrices, which a floating base makes dense.
            20_000.0 * m.depths
                + 8400.0 * m.squares
                + 1400.0 * m.entries
                + 1250.0 * m.bases * m.entries * m.nv
        }
        Function::StepImplicitMidpoint => {
            5000.0 * (m.depths + m.carried)
                + 40_000.0 * m.carried
                + 600.0 * m.squares
                + 100.0 * m.entries
        }
        Function::StepImplicitMidpointDerivatives => {
            10_000.0 * (m.depths + m.carried)
                + 40_000.0 * m.carried
                + 1200.0 * m.squares
                + 400.0 * m.entries
        }
        Function::ConstrainedForwardDynamics => {
            1200.0 * m.depths
                + 70.0 * m.squares
                + 30.0 * m.entries
                + 850.0 * m.reach
                + 2200.0 * m.row_reach
                + 15.0 * m.constraint_rows.powi(2) * m.nv
                + 60.0 * m.constraint_rows.powi(3)
        }
        Function::ConstraintResidual => 400.0 * m.reach + 300.0 * m.row_reach,
        Function::ProjectConstraints => {
            140.0 * m.squares
                + 850.0 * m.reach
                + 1800.0 * m.row_reach
                + 35.0 * m.constraint_rows.powi(2) * m.nv
                + 50.0 * m.constraint_rows.powi(3)
        }
        Function::ConstrainedForwardDynamicsDerivatives => constrained_derivatives(m),
        Function::ConstrainedForwardDynamicsHessian => {
            constrained_derivatives(m) + 18_000.0 * m.depths + 300.0 * m.entries
        }
        Function::ContactImpulse => {
            140.0 * m.squares
                + 850.0 * m.reach
                + 1800.0 * m.row_reach
                + 35.0 * m.constraint_rows.powi(2) * m.nv
                + 50.0 * m.constraint_rows.powi(3)
        }
        Function::ConstrainedInverseDynamics => {
            3300.0 * m.carried + 57_000.0 * m.bases.powi(2) + 300.0 * m.reach + 150.0 * m.row_reach
        }
        Function::ConstraintJacobian => 1200.0 * m.reach + 45.0 * m.row_reach,
        Function::ConstraintBiasAcceleration => 800.0 * m.reach + 50.0 * m.row_reach,
        Function::OperationalInertia => {
            140.0 * m.squares
                + 950.0 * m.reach
                + 1200.0 * m.row_reach
                + 55.0 * m.constraint_rows.powi(2) * m.nv
                + 170.0 * m.constraint_rows.powi(3)
        }
        Function::Regressor => 2200.0 * m.depths + 120.0 * m.squares + 60.0 * m.entries,
        Function::CenterOfMass => 600.0 * m.links,
        Function::CenterOfMassJacobian => 1200.0 * m.links,
        Function::CentroidalMomentumMatrix => 4000.0 * m.links,
        Function::CentroidalMomentum => 3200.0 * m.links,
        Function::CentroidalMomentumRate => 6400.0 * m.links,
        Function::CentroidalMomentumDerivatives => 24_000.0 * m.links,
        Function::LinkPoses => 1500.0 * (m.links + m.frames - m.rows) + 250.0 * m.rows,
        Function::LinkPose => m.of_links(1400.0, 600.0),
        Function::LinkVelocity => m.of_links(1300.0, 300.0),
        Function::LocalLinkVelocity => m.of_links(1300.0, 300.0),
        Function::LinkAcceleration => m.of_links(2100.0, 300.0),
        Function::LocalLinkAcceleration => m.of_links(2100.0, 300.0),
        Function::Jacobian => m.of_links(1600.0, 150.0 * m.nv),
        Function::LocalJacobian => m.of_links(1600.0, 150.0 * m.nv),
        Function::JacobianTimeDerivative => m.of_links(4500.0, 150.0 * m.nv),
        Function::LocalJacobianTimeDerivative => m.of_links(4500.0, 150.0 * m.nv),
        Function::BiasAcceleration => m.of_links(1900.0, 300.0),
        Function::LocalBiasAcceleration => m.of_links(1900.0, 300.0),
        Function::Integrate => 100.0 * m.links,
        Function::Difference => 100.0 * m.links,
        Function::IntegrateDerivatives => 100.0 * m.links + 30.0 * m.nv.powi(2),
        Function::DifferenceDerivatives => 100.0 * m.links + 30.0 * m.nv.powi(2),
        Function::VelocityToQdot => 100.0 * m.links,
        Function::Normalize => 100.0 * m.links,
        Function::Random => 200.0 * m.links,
        other => estimated_length(other.batched().unwrap_or(Function::ForwardDynamics), m),
    }
}
