//! Changes of run-time parameters.

use modyn_runtime::Inertial;

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
}
