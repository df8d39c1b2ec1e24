//! The cost of reaching a target: written once, over any scalar. The build script compiles it with its derivatives.

use modyn_codegen::{Interpreter, Scalar, UserArgument, UserError, UserFunction};

/// The squared distance from a link's origin to a target, and a small cost of velocities.
pub struct ReachCost {
    /// The name of the link.
    pub link: &'static str,
}

impl UserFunction<4> for ReachCost {
    fn docs(&self) -> String {
        "Returns the cost of reaching: the squared distance (m^2) from the arm's tip to `target` (m, world axes),\n\
         and `weight` times the square of the tip's velocity (m^2/s^2)."
            .into()
    }

    fn arguments(&self) -> [UserArgument; 4] {
        // Derivatives are with respect to `q` and `qd`; `target` and `weight` are constants of them.
        [
            UserArgument::Q,
            UserArgument::QD,
            UserArgument::numbers("target", 3),
            UserArgument::number("weight"),
        ]
    }

    fn evaluate<S: Scalar>(
        &self,
        robot: &mut Interpreter<S>,
        [q, qd, target, weight]: [&[S]; 4],
    ) -> Result<Vec<S>, UserError> {
        let link = robot.model().link_index(self.link).ok_or("the robot has no such link")?;
        let tip = robot.link_pose(q, link)?.translation;
        let velocity = robot.link_velocity(q, qd, link)?.linear.0;
        let mut cost = S::zero();
        for k in 0..3 {
            let distance = tip[k] - target[k];
            cost = cost + distance * distance + weight[0] * velocity[k] * velocity[k];
        }
        Ok(vec![cost])
    }
}
