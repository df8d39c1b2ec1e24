//! Changes of run-time parameters.

use modyn_runtime::{Inertial, Interpreter};

/// A change of a robot's run-time parameters.
#[derive(Clone, Debug)]
pub enum Change {
    /// Gravity in world axes, m/s^2.
    Gravity([f64; 3]),
    /// The inertia of a link itself.
    Inertia(String, Inertial),
    /// The inertia of a link's payload.
    Payload(String, Inertial),
}

impl Change {
    /// Returns the message that the robot does not have this parameter.
    pub fn missing(&self) -> String {
        let (subject, option) = match self {
            Self::Gravity(_) => ("gravity is a constant".into(), "runtime_gravity=True".into()),
            Self::Inertia(link, _) => (
                format!("link `{link}` has no run-time inertia"),
                format!("runtime_inertia=[{link:?}]"),
            ),
            Self::Payload(link, _) => {
                (format!("link `{link}` has no payload"), format!("payload=[{link:?}]"))
            }
        };
        format!("{subject}; load the robot with {option}")
    }

    /// Makes the change in an interpreter.
    ///
    /// # Errors
    ///
    /// If gravity is not finite, no rigid body has the inertia, or the robot has no such link.
    pub fn set(&self, interpreter: &mut Interpreter<f64>) -> Result<(), String> {
        let frame = |interpreter: &Interpreter<f64>, link: &str| {
            interpreter.model().link_index(link).ok_or_else(|| self.missing())
        };
        match self {
            Self::Gravity(gravity) if gravity.iter().all(|x| x.is_finite()) => {
                interpreter.set_gravity(*gravity);
                Ok(())
            }
            Self::Gravity(_) => Err("gravity has three finite components, m/s^2".into()),
            Self::Inertia(link, inertial) => interpreter
                .set_inertial(frame(interpreter, link)?, inertial)
                .map_err(|error| error.to_string()),
            Self::Payload(link, inertial) => interpreter
                .set_payload(frame(interpreter, link)?, inertial)
                .map_err(|error| error.to_string()),
        }
    }
}
