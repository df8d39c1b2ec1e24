//! The table of quantities: what each function is called, takes and returns, and its graph.

use modyn_runtime::model::Model;

use super::function::Shape;
use crate::expr::Graph;
use crate::passes::optimize;
use crate::trace::Tracer;

/// A quantity's function: its graph, and how it is called.
pub(super) struct Quantity {
    pub name: &'static str,
    pub parameters: &'static [&'static str],
    pub shape: Shape,
    pub graph: Graph,
    /// The lines of its documentation.
    pub docs: &'static str,
}

/// All quantities but the factorization; forward dynamics is traced already.
pub(super) fn quantities(
    model: &Model,
    tracer: &Tracer<'_>,
    forward_dynamics: Graph,
) -> Vec<Quantity> {
    let n = model.nv();
    let quantity =
        |name, parameters, shape, graph, docs| Quantity { name, parameters, shape, graph, docs };
    vec![
        quantity(
            "forward_dynamics",
            &["q", "qd", "tau"],
            Shape::Vector(n),
            forward_dynamics,
            "Joint accelerations (rad/s^2 or m/s^2) at coordinates `q` and velocities `qd` under the joint\n\
             torques or forces `tau` (N m or N), gravity included: block reverse Gaussian elimination of the\n\
             generalized inertia matrix by inter- and intra-modular recursion.",
        ),
        quantity(
            "inverse_dynamics",
            &["q", "qd", "qdd"],
            Shape::Vector(n),
            optimize(tracer.inverse_dynamics()),
            "Joint torques or forces (N m or N) of the accelerations `qdd` at coordinates `q` and velocities\n\
             `qd`, gravity included: recursive Newton-Euler.",
        ),
        quantity(
            "bias_forces",
            &["q", "qd"],
            Shape::Vector(n),
            optimize(tracer.bias_forces()),
            "Coriolis, centrifugal and gravity torques: inverse dynamics without acceleration.",
        ),
        quantity(
            "gravity_torques",
            &["q"],
            Shape::Vector(n),
            optimize(tracer.gravity_torques()),
            "Joint torques that hold the robot still at `q`.",
        ),
        quantity(
            "mass_matrix",
            &["q"],
            Shape::Matrix(n, n),
            optimize(tracer.mass_matrix()),
            "The generalized inertia matrix at `q`, an array of columns: by composite modules.",
        ),
        quantity(
            "kinetic_energy",
            &["q", "qd"],
            Shape::Scalar,
            optimize(tracer.kinetic_energy()),
            "Kinetic energy of the moving links, J.",
        ),
        quantity(
            "potential_energy",
            &["q"],
            Shape::Scalar,
            optimize(tracer.potential_energy()),
            "Potential energy of the moving links under gravity, J; zero at the world's origin.",
        ),
        quantity(
            "link_poses",
            &["q"],
            Shape::Poses(model.frames().len()),
            optimize(tracer.link_poses()),
            "The poses in the world of all links of the description, fixed ones too, in the order of\n\
             `LINK_NAMES`.",
        ),
    ]
}

impl Quantity {
    /// The parameters with their types.
    pub fn typed(&self, n: usize, scalar: &str) -> String {
        let typed: Vec<String> =
            self.parameters.iter().map(|name| format!("{name}: &[{scalar}; {n}]")).collect();
        typed.join(", ")
    }
}
