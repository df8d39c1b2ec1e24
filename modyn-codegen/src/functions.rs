//! The functions that a generated robot can have, and which it has by default.

use crate::urdf::nearest::nearest;

macro_rules! functions {
    ($($(#[$docs:meta])* $variant:ident $name:literal;)*) => {
        /// A function of generated robots.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum Function {
            $($(#[$docs])* $variant,)*
        }

        impl Function {
            /// All, in the order in which they stand in the text.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// What it is called.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

functions! {
    /// Accelerations under torques.
    ForwardDynamics "forward_dynamics";
    /// Torques of accelerations.
    InverseDynamics "inverse_dynamics";
    /// Coriolis, centrifugal and gravity torques.
    BiasForces "bias_forces";
    /// Torques at rest.
    GravityTorques "gravity_torques";
    /// The generalized inertia matrix.
    MassMatrix "mass_matrix";
    /// The generalized inertia matrix as U D U^T by modules.
    Brge "brge";
    /// Kinetic energy.
    KineticEnergy "kinetic_energy";
    /// Potential energy.
    PotentialEnergy "potential_energy";
    /// Forward dynamics with wrenches on links, in the links' axes.
    ForwardDynamicsExternal "forward_dynamics_external";
    /// Forward dynamics with wrenches on links, in the world's axes.
    ForwardDynamicsExternalWorld "forward_dynamics_external_world";
    /// Inverse dynamics with wrenches on links, in the links' axes.
    InverseDynamicsExternal "inverse_dynamics_external";
    /// Inverse dynamics with wrenches on links, in the world's axes.
    InverseDynamicsExternalWorld "inverse_dynamics_external_world";
    /// Derivatives of inverse dynamics.
    InverseDynamicsDerivatives "inverse_dynamics_derivatives";
    /// Derivatives of forward dynamics.
    ForwardDynamicsDerivatives "forward_dynamics_derivatives";
    /// Forward dynamics with the loops closed.
    ConstrainedForwardDynamics "constrained_forward_dynamics";
    /// How well the loops are closed.
    ConstraintResidual "constraint_residual";
    /// The step that closes them.
    ProjectConstraints "project_constraints";
    /// The regressor of inverse dynamics.
    Regressor "regressor";
    /// The centre of mass.
    CenterOfMass "center_of_mass";
    /// The derivative of the centre of mass.
    CenterOfMassJacobian "center_of_mass_jacobian";
    /// The centroidal momentum matrix.
    CentroidalMomentumMatrix "centroidal_momentum_matrix";
    /// The momentum about the centre of mass.
    CentroidalMomentum "centroidal_momentum";
    /// Poses of all links.
    LinkPoses "link_poses";
    /// The pose of a link.
    LinkPose "link_pose";
    /// The velocity of a link, in world axes.
    LinkVelocity "link_velocity";
    /// The velocity of a link, in its own axes.
    LocalLinkVelocity "local_link_velocity";
    /// The acceleration of a link, in world axes.
    LinkAcceleration "link_acceleration";
    /// The acceleration of a link, in its own axes.
    LocalLinkAcceleration "local_link_acceleration";
    /// The Jacobian of a link, in world axes.
    Jacobian "jacobian";
    /// The Jacobian of a link, in its own axes.
    LocalJacobian "local_jacobian";
    /// The time derivative of the Jacobian times the velocities.
    JacobianRate "jacobian_rate";
    /// The time derivative of the local Jacobian times the velocities.
    LocalJacobianRate "local_jacobian_rate";
    /// Coordinates behind a displacement.
    Integrate "integrate";
    /// The displacement between coordinates.
    Difference "difference";
    /// Rates of the coordinates.
    CoordinateRates "coordinate_rates";
    /// Quaternions brought to unit length.
    Normalize "normalize";
    /// Coordinates within the limits.
    Random "random";
    /// `forward_dynamics` of many states at a time.
    ForwardDynamicsBatch "forward_dynamics_batch";
    /// `inverse_dynamics` of many states at a time.
    InverseDynamicsBatch "inverse_dynamics_batch";
    /// `bias_forces` of many states at a time.
    BiasForcesBatch "bias_forces_batch";
    /// `gravity_torques` of many states at a time.
    GravityTorquesBatch "gravity_torques_batch";
    /// `mass_matrix` of many states at a time.
    MassMatrixBatch "mass_matrix_batch";
    /// `kinetic_energy` of many states at a time.
    KineticEnergyBatch "kinetic_energy_batch";
    /// `potential_energy` of many states at a time.
    PotentialEnergyBatch "potential_energy_batch";
    /// `brge` of many states at a time.
    BrgeBatch "brge_batch";
    /// `inverse_dynamics_derivatives` of many states at a time.
    InverseDynamicsDerivativesBatch "inverse_dynamics_derivatives_batch";
    /// `forward_dynamics_derivatives` of many states at a time.
    ForwardDynamicsDerivativesBatch "forward_dynamics_derivatives_batch";
}

impl Function {
    /// Those that a robot has unless others are chosen; one without loops has none about loops.
    pub const DEFAULT: &[Self] = &[
        Self::ForwardDynamics,
        Self::InverseDynamics,
        Self::BiasForces,
        Self::GravityTorques,
        Self::MassMatrix,
        Self::Brge,
        Self::KineticEnergy,
        Self::PotentialEnergy,
        Self::ConstrainedForwardDynamics,
        Self::ConstraintResidual,
        Self::ProjectConstraints,
        Self::CenterOfMass,
        Self::LinkPoses,
        Self::LinkPose,
        Self::Jacobian,
        Self::Integrate,
        Self::Difference,
        Self::CoordinateRates,
        Self::Normalize,
        Self::Random,
    ];

    /// The function that this one computes of many states at a time.
    #[must_use]
    pub const fn batched(self) -> Option<Self> {
        Some(match self {
            Self::ForwardDynamicsBatch => Self::ForwardDynamics,
            Self::InverseDynamicsBatch => Self::InverseDynamics,
            Self::BiasForcesBatch => Self::BiasForces,
            Self::GravityTorquesBatch => Self::GravityTorques,
            Self::MassMatrixBatch => Self::MassMatrix,
            Self::KineticEnergyBatch => Self::KineticEnergy,
            Self::PotentialEnergyBatch => Self::PotentialEnergy,
            Self::BrgeBatch => Self::Brge,
            Self::InverseDynamicsDerivativesBatch => Self::InverseDynamicsDerivatives,
            Self::ForwardDynamicsDerivativesBatch => Self::ForwardDynamicsDerivatives,
            _ => return None,
        })
    }

    /// The Rust functions that it becomes, by name, each with the number of its arguments (those of the
    /// robot's run-time parameters aside).
    pub(crate) fn signatures(self) -> Vec<(String, usize)> {
        let inputs = match self.batched().unwrap_or(self) {
            Self::GravityTorques
            | Self::MassMatrix
            | Self::Brge
            | Self::PotentialEnergy
            | Self::CenterOfMass
            | Self::CenterOfMassJacobian
            | Self::CentroidalMomentumMatrix
            | Self::LinkPoses
            | Self::Normalize
            | Self::Random => 1,
            Self::BiasForces
            | Self::KineticEnergy
            | Self::ConstraintResidual
            | Self::CentroidalMomentum
            | Self::LinkPose
            | Self::Jacobian
            | Self::LocalJacobian
            | Self::Integrate
            | Self::Difference
            | Self::CoordinateRates => 2,
            Self::ForwardDynamicsExternal
            | Self::ForwardDynamicsExternalWorld
            | Self::InverseDynamicsExternal
            | Self::InverseDynamicsExternalWorld
            | Self::ConstrainedForwardDynamics
            | Self::LinkAcceleration
            | Self::LocalLinkAcceleration => 4,
            _ => 3,
        };
        let Some(one) = self.batched() else { return vec![(self.name().into(), inputs)] };
        // Over slices for each coordinate, each result is an argument; over slices of states they are one.
        let outputs = match one {
            Self::InverseDynamicsDerivatives => 2,
            Self::ForwardDynamicsDerivatives => 4,
            _ => 1,
        };
        let name = one.name();
        vec![(format!("{name}_batch"), inputs + outputs), (format!("{name}_each"), inputs + 1)]
    }

    /// Whether it is about closed loops, so that only robots with some have it.
    #[must_use]
    pub const fn is_of_loops(self) -> bool {
        matches!(
            self,
            Self::ConstrainedForwardDynamics | Self::ConstraintResidual | Self::ProjectConstraints
        )
    }

    /// Whether run-time parameters (gravity, inertias, payloads) can matter to it.
    #[must_use]
    pub const fn depends_on_parameters(self) -> bool {
        !matches!(
            self,
            Self::ConstraintResidual
                | Self::LinkPoses
                | Self::LinkPose
                | Self::LinkVelocity
                | Self::LocalLinkVelocity
                | Self::LinkAcceleration
                | Self::LocalLinkAcceleration
                | Self::Jacobian
                | Self::LocalJacobian
                | Self::JacobianRate
                | Self::LocalJacobianRate
                | Self::Integrate
                | Self::Difference
                | Self::CoordinateRates
                | Self::Normalize
                | Self::Random
        )
    }

    /// The function of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|function| function.name() == name)
    }

    /// A message that there is no function of this name: with the one that was probably meant, else with all
    /// names, as the macro and the command line have them.
    #[must_use]
    pub fn unknown(name: &str) -> String {
        let names = || ["default", "all"].into_iter().chain(Self::ALL.iter().map(|one| one.name()));
        match nearest(name, names()) {
            Some(meant) => format!("there is no function `{name}`; did you mean `{meant}`?"),
            None => {
                let names: Vec<&str> = names().collect();
                format!("there is no function `{name}`; there are: {}", names.join(", "))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Function;

    #[test]
    fn a_function_is_suggested() {
        let said = Function::unknown("mas_matrix");
        assert_eq!(said, "there is no function `mas_matrix`; did you mean `mass_matrix`?");
        assert!(Function::unknown("foo").contains("there are: default, all, forward_dynamics, "));
    }
}
