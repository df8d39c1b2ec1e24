//! The functions that are compared: the call of the generated code, and that of the interpreter.

use modyn_codegen::Function;
use modyn_runtime::equations::derivatives::ForwardDerivatives;
use modyn_runtime::spatial::Pose;
use modyn_runtime::{Interpreter, ShapeError};

/// The arguments of functions.
pub struct State {
    pub q: Vec<f64>,
    pub qd: Vec<f64>,
    /// Torques, accelerations or a right-hand side.
    pub u: Vec<f64>,
}

/// A function that is compared.
pub struct Quantity {
    pub function: Function,
    /// Whether it divides by the mass matrix.
    pub solves: bool,
    /// The call in Rust, of the type `Robot` at the state `s`.
    pub call: &'static str,
    /// The call of the interpreter, which appends the numbers of the result.
    pub interpret: Interpret,
}

type Interpret = fn(&mut Interpreter<f64>, &State, &mut Vec<f64>) -> Result<(), ShapeError>;

const fn quantity(
    function: Function,
    solves: bool,
    call: &'static str,
    interpret: Interpret,
) -> Quantity {
    Quantity { function, solves, call, interpret }
}

/// Appends `count` numbers, and returns them.
fn extend_by(out: &mut Vec<f64>, count: usize) -> &mut [f64] {
    let start = out.len();
    out.resize(start + count, 0.0);
    &mut out[start..]
}

/// All functions that can be compared.
pub const QUANTITIES: &[Quantity] = &[
    quantity(
        Function::ForwardDynamics,
        true,
        "forward_dynamics(&s.q, &s.qd, &s.u)",
        |i, s, out| {
            let n = s.qd.len();
            i.forward_dynamics(&s.q, &s.qd, &s.u, extend_by(out, n))
        },
    ),
    quantity(
        Function::InverseDynamics,
        false,
        "inverse_dynamics(&s.q, &s.qd, &s.u)",
        |i, s, out| {
            let n = s.qd.len();
            i.inverse_dynamics(&s.q, &s.qd, &s.u, extend_by(out, n))
        },
    ),
    quantity(Function::BiasForces, false, "bias_forces(&s.q, &s.qd)", |i, s, out| {
        let n = s.qd.len();
        i.bias_forces(&s.q, &s.qd, extend_by(out, n))
    }),
    quantity(Function::GravityTorques, false, "gravity_torques(&s.q)", |i, s, out| {
        let n = s.qd.len();
        i.gravity_torques(&s.q, extend_by(out, n))
    }),
    quantity(Function::MassMatrix, false, "mass_matrix(&s.q)", |i, s, out| {
        let n = s.qd.len();
        i.mass_matrix(&s.q, extend_by(out, n * n))
    }),
    quantity(Function::Brge, true, "brge(&s.q).solve(&s.u)", |i, s, out| {
        out.extend(i.brge(&s.q)?.solve(&s.u)?);
        Ok(())
    }),
    quantity(Function::KineticEnergy, false, "kinetic_energy(&s.q, &s.qd)", |i, s, out| {
        out.push(i.kinetic_energy(&s.q, &s.qd)?);
        Ok(())
    }),
    quantity(Function::PotentialEnergy, false, "potential_energy(&s.q)", |i, s, out| {
        out.push(i.potential_energy(&s.q)?);
        Ok(())
    }),
    quantity(
        Function::InverseDynamicsDerivatives,
        false,
        "inverse_dynamics_derivatives(&s.q, &s.qd, &s.u)",
        |i, s, out| {
            let n = s.qd.len();
            let (dq, dqd) = extend_by(out, 2 * n * n).split_at_mut(n * n);
            i.inverse_dynamics_derivatives(&s.q, &s.qd, &s.u, dq, dqd)
        },
    ),
    quantity(
        Function::ForwardDynamicsDerivatives,
        true,
        "forward_dynamics_derivatives(&s.q, &s.qd, &s.u)",
        |i, s, out| {
            let n = s.qd.len();
            let (qdd, rest) = extend_by(out, n + 3 * n * n).split_at_mut(n);
            let (dqdd_dq, rest) = rest.split_at_mut(n * n);
            let (dqdd_dqd, dqdd_dtau) = rest.split_at_mut(n * n);
            let outputs = ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau };
            i.forward_dynamics_derivatives(&s.q, &s.qd, &s.u, outputs)
        },
    ),
    quantity(Function::CenterOfMass, false, "center_of_mass(&s.q)", |i, s, out| {
        out.extend(i.center_of_mass(&s.q)?);
        Ok(())
    }),
    quantity(Function::LinkPoses, false, "link_poses(&s.q)", |i, s, out| {
        let mut poses = vec![Pose::identity(); i.model().frames().len()];
        i.link_poses(&s.q, &mut poses)?;
        for pose in poses {
            out.extend(pose.rotation.as_flattened());
            out.extend(pose.translation);
        }
        Ok(())
    }),
    quantity(Function::Integrate, false, "integrate(&s.q, &s.qd)", |i, s, out| {
        let n = s.q.len();
        i.integrate(&s.q, &s.qd, extend_by(out, n))
    }),
    quantity(Function::VelocityToQdot, false, "velocity_to_qdot(&s.q, &s.qd)", |i, s, out| {
        let n = s.q.len();
        i.velocity_to_qdot(&s.q, &s.qd, extend_by(out, n))
    }),
];
