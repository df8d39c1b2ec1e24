//! The functions that are compared: the call of the generated code, and that of the interpreter.

use modyn_codegen::Function;
use modyn_codegen::plan::Argument;
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

impl State {
    /// Returns the numbers of an argument of a function, by the argument's name.
    pub fn argument(&self, name: &str) -> &[f64] {
        match field(name) {
            "q" => &self.q,
            "qd" => &self.qd,
            _ => &self.u,
        }
    }
}

/// Returns the field of a state that has the numbers of an argument, by the argument's name.
fn field(name: &str) -> &'static str {
    match name {
        "q" => "q",
        "qd" | "v" => "qd",
        _ => "u",
    }
}

/// A function that is compared.
pub struct Quantity {
    pub function: Function,
    /// Whether it divides by the mass matrix.
    pub solves: bool,
    /// The call in Rust, of the type `Robot` at the state `s`.
    pub call: String,
    /// The call of the interpreter, which appends the numbers of the result.
    pub interpret: Interpret,
}

impl Quantity {
    /// Returns whether machine code has no result to compare: its factors of the mass matrix solve nothing by themselves.
    pub fn needs_rustc(&self) -> bool {
        self.function == Function::Brge
    }
}

type Interpret = fn(&mut Interpreter<f64>, &State, &mut Vec<f64>) -> Result<(), ShapeError>;

/// Appends `count` numbers, and returns them.
fn extend_by(out: &mut Vec<f64>, count: usize) -> &mut [f64] {
    let start = out.len();
    out.resize(start + count, 0.0);
    &mut out[start..]
}

/// Returns the functions that can be compared, in the order of the compiler's table: those of one state that have arrays
/// of numbers as arguments, and whose results [`interpret`] can lay out.
pub fn quantities() -> impl Iterator<Item = Quantity> {
    Function::ALL.iter().filter_map(|&function| {
        let interpret = interpret(function)?;
        let solves = matches!(
            function,
            Function::ForwardDynamics | Function::Brge | Function::ForwardDynamicsDerivatives
        );
        Some(Quantity { function, solves, call: call(function), interpret })
    })
}

/// Returns the call in Rust.
fn call(function: Function) -> String {
    let argument = |argument: &Argument| format!("&s.{}", field(argument.name));
    let arguments: Vec<String> = function.row().arguments.iter().map(argument).collect();
    // Factors have another order in the interpreter, so a solution is compared.
    let then = if function == Function::Brge { ".solve(&s.u)" } else { "" };
    format!("{}({}){then}", function.name(), arguments.join(", "))
}

/// Returns the call of the interpreter, which appends the numbers of the result.
fn interpret(function: Function) -> Option<Interpret> {
    let interpret: Interpret = match function {
        Function::ForwardDynamics => |i, s, out| {
            let n = s.qd.len();
            i.forward_dynamics(&s.q, &s.qd, &s.u, extend_by(out, n))
        },
        Function::InverseDynamics => |i, s, out| {
            let n = s.qd.len();
            i.inverse_dynamics(&s.q, &s.qd, &s.u, extend_by(out, n))
        },
        Function::BiasForces => |i, s, out| {
            let n = s.qd.len();
            i.bias_forces(&s.q, &s.qd, extend_by(out, n))
        },
        Function::GravityTorques => |i, s, out| {
            let n = s.qd.len();
            i.gravity_torques(&s.q, extend_by(out, n))
        },
        Function::MassMatrix => |i, s, out| {
            let n = s.qd.len();
            i.mass_matrix(&s.q, extend_by(out, n * n))
        },
        Function::Brge => |i, s, out| {
            out.extend(i.brge(&s.q)?.solve(&s.u)?);
            Ok(())
        },
        Function::KineticEnergy => |i, s, out| {
            out.push(i.kinetic_energy(&s.q, &s.qd)?);
            Ok(())
        },
        Function::PotentialEnergy => |i, s, out| {
            out.push(i.potential_energy(&s.q)?);
            Ok(())
        },
        Function::InverseDynamicsDerivatives => |i, s, out| {
            let n = s.qd.len();
            let (dq, dqd) = extend_by(out, 2 * n * n).split_at_mut(n * n);
            i.inverse_dynamics_derivatives(&s.q, &s.qd, &s.u, dq, dqd)
        },
        Function::ForwardDynamicsDerivatives => |i, s, out| {
            let n = s.qd.len();
            let (qdd, rest) = extend_by(out, n + 3 * n * n).split_at_mut(n);
            let (dqdd_dq, rest) = rest.split_at_mut(n * n);
            let (dqdd_dqd, dqdd_dtau) = rest.split_at_mut(n * n);
            let outputs = ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau };
            i.forward_dynamics_derivatives(&s.q, &s.qd, &s.u, outputs)
        },
        Function::CenterOfMass => |i, s, out| {
            out.extend(i.center_of_mass(&s.q)?);
            Ok(())
        },
        Function::LinkPoses => |i, s, out| {
            let mut poses = vec![Pose::identity(); i.model().frames().len()];
            i.link_poses(&s.q, &mut poses)?;
            for pose in poses {
                out.extend(pose.rotation.as_flattened());
                out.extend(pose.translation);
            }
            Ok(())
        },
        Function::Integrate => |i, s, out| {
            let n = s.q.len();
            i.integrate(&s.q, &s.qd, extend_by(out, n))
        },
        Function::VelocityToQdot => |i, s, out| {
            let n = s.q.len();
            i.velocity_to_qdot(&s.q, &s.qd, extend_by(out, n))
        },
        _ => return None,
    };
    Some(interpret)
}

#[cfg(test)]
mod tests {
    use modyn_codegen::Function;

    use super::{call, quantities};

    #[test]
    fn calls_have_the_arguments_of_the_table() {
        assert_eq!(call(Function::ForwardDynamics), "forward_dynamics(&s.q, &s.qd, &s.u)");
        assert_eq!(call(Function::Integrate), "integrate(&s.q, &s.qd)");
        assert_eq!(call(Function::Brge), "brge(&s.q).solve(&s.u)");
        let default = Function::DEFAULT.iter().filter(|function| !function.row().of_constraints);
        let compared: Vec<Function> = quantities().map(|quantity| quantity.function).collect();
        let left: Vec<&Function> = default.filter(|one| !compared.contains(one)).collect();
        let expected = [
            Function::LinkPose,
            Function::Jacobian,
            Function::Difference,
            Function::Normalize,
            Function::Random,
        ];
        assert_eq!(left, expected.iter().collect::<Vec<_>>());
    }
}
