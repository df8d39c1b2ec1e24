//! The table of quantities: what each function is called, takes and returns, and its graph.

use modyn_runtime::OperationCount;
use modyn_runtime::equations::ModulePartition;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::equations::kinematics::Axes;

use modyn_runtime::model::PARAMETERS_PER_LINK;

use super::Robot;
use super::frames::Frames;
use super::function::Parameter;
use super::shape::Shape;
use crate::expr::Graph;
use crate::functions::Function;
use crate::passes::{balance, optimize};
use crate::trace::{Limbs, Tracer};

/// A quantity's function: how it is called, and its graph.
pub(super) struct Quantity {
    pub function: Function,
    pub parameters: Vec<Parameter>,
    pub shape: Shape,
    /// Whether it depends on what is known at run time only, if there is such a thing.
    pub dynamic: bool,
    pub graphs: Graphs,
    /// The same with equal limbs side by side, if that is cheaper where there are vectors.
    pub abreast: Option<Graph>,
    /// The lines of its documentation.
    pub docs: &'static str,
}

/// What a function is written by.
pub(super) enum Graphs {
    /// Its graph.
    One(Graph),
    /// Those of functions of a link: see [`Frames::kernels`].
    ByLink(Vec<Graph>),
    /// Those of all links together, where some share code: see [`Frames::poses`].
    Poses(Box<[Graph; 2]>),
}

impl Graphs {
    /// All of them.
    pub fn all(&self) -> &[Graph] {
        match self {
            Self::One(graph) => std::slice::from_ref(graph),
            Self::ByLink(graphs) => graphs,
            Self::Poses(graphs) => &**graphs,
        }
    }

    /// The operations of a call: of a function of a link, for the most expensive one. `rows` links share code.
    pub fn count(&self, rows: usize) -> OperationCount {
        match self {
            Self::One(graph) => graph.count(),
            Self::ByLink(graphs) => {
                let counts = graphs.iter().map(Graph::count);
                counts.max_by_key(OperationCount::total).unwrap_or_default()
            }
            Self::Poses(graphs) => {
                let placed = std::iter::repeat_n(graphs[1].count(), rows);
                placed.chain([graphs[0].count()]).sum()
            }
        }
    }
}

/// What the graphs are traced from.
pub(super) struct Source<'a> {
    pub tracer: &'a Tracer<'a>,
    /// The same for functions of all links together: the other one may have none.
    pub all_links: &'a Tracer<'a>,
    /// The links, by the code that their functions have.
    pub frames: &'a Frames,
    /// Limbs that can be computed side by side: the ways to choose from.
    pub limbs: &'a [Limbs],
    /// The modules that forward dynamics with limbs side by side can be eliminated by.
    pub partitions: &'a [ModulePartition],
    /// Whether no limb moves another.
    pub independent: bool,
    /// Whether the text may use the runtime's vectors.
    pub vectors: bool,
    pub elimination: &'a Elimination,
    pub layout: &'a UduLayout,
    /// The factorization that derivatives are solved by.
    pub for_derivatives: &'a UduLayout,
    /// Forward dynamics is traced already, by the search for the cheapest modules.
    pub forward_dynamics: &'a Graph,
}

impl Robot<'_> {
    /// The quantity that a function computes.
    #[allow(clippy::too_many_lines)] // A table.
    pub(super) fn quantity(&self, function: Function, source: &Source<'_>) -> Quantity {
        let Source {
            tracer,
            all_links,
            elimination,
            layout,
            for_derivatives,
            forward_dynamics,
            ..
        } = source;
        let (nq, nv, links) = (self.model.nq(), self.model.nv(), self.model.frames().len());
        let q = || Parameter::new("q", Shape::vector(nq));
        let v = |name| Parameter::new(name, Shape::vector(nv));
        let loop_constraints = self.model.loop_constraints().len();
        let settings = || Parameter::new("settings", Shape::constraint_settings());
        let forces = || Parameter::new("forces", Shape::wrench().array(links));
        let one = |graph| Graphs::One(optimize(graph));
        let by_link = |graph: &dyn Fn(&Tracer<'_>) -> Graph| {
            Graphs::ByLink(source.frames.kernels(|tracer| optimize(graph(tracer))))
        };
        let vector = || Shape::vector(nv);
        let square = || Shape::matrix(nv, nv);
        let (parameters, shape, graphs, docs) = match function {
            Function::ForwardDynamics | Function::ForwardDynamicsBatch => (
                vec![q(), v("qd"), v("tau")],
                vector(),
                Graphs::One((*forward_dynamics).clone()),
                "Joint accelerations (rad/s^2 or m/s^2) at coordinates `q` and velocities `qd` under the joint\n\
                 torques or forces `tau` (N m or N), gravity included: block reverse Gaussian elimination of the\n\
                 generalized inertia matrix by inter- and intra-modular recursion.",
            ),
            Function::InverseDynamics | Function::InverseDynamicsBatch => (
                vec![q(), v("qd"), v("qdd")],
                vector(),
                one(tracer.inverse_dynamics()),
                "Joint torques or forces (N m or N) of the accelerations `qdd` at coordinates `q` and velocities\n\
                 `qd`, gravity included: recursive Newton-Euler.",
            ),
            Function::BiasForces | Function::BiasForcesBatch => (
                vec![q(), v("qd")],
                vector(),
                one(tracer.bias_forces()),
                "Coriolis, centrifugal and gravity torques: inverse dynamics without acceleration.",
            ),
            Function::GravityTorques | Function::GravityTorquesBatch => (
                vec![q()],
                vector(),
                one(tracer.gravity_torques()),
                "Joint torques that hold the robot still at `q`.",
            ),
            Function::MassMatrix | Function::MassMatrixBatch => (
                vec![q()],
                Shape::matrix(nv, nv),
                one(tracer.mass_matrix()),
                "The generalized inertia matrix at `q`, an array of columns: by composite modules.",
            ),
            Function::Brge | Function::BrgeBatch => (
                vec![q()],
                Shape::Struct {
                    path: format!("{}Brge", self.name),
                    arguments: "{t}".into(),
                    fields: vec![("factors", Shape::vector(layout.size()))],
                },
                one(tracer.brge(layout)),
                "The generalized inertia matrix at `q` as U D U^T by kinematic modules: block reverse\n\
                 Gaussian elimination.",
            ),
            Function::KineticEnergy | Function::KineticEnergyBatch => (
                vec![q(), v("qd")],
                Shape::Scalar,
                one(tracer.kinetic_energy()),
                "Kinetic energy of the moving links (and rotors), J.",
            ),
            Function::PotentialEnergy | Function::PotentialEnergyBatch => (
                vec![q()],
                Shape::Scalar,
                one(tracer.potential_energy()),
                "Potential energy of the moving links under gravity, J; zero at the world's origin.",
            ),
            Function::ForwardDynamicsExternal => (
                vec![q(), v("qd"), v("tau"), forces()],
                vector(),
                one(all_links.forward_dynamics_external(elimination, Axes::Link)),
                "Forward dynamics with a wrench on each link (in the order of `LINK_NAMES`) at the link's\n\
                 origin in its own axes.",
            ),
            Function::ForwardDynamicsExternalWorld => (
                vec![q(), v("qd"), v("tau"), forces()],
                vector(),
                one(all_links.forward_dynamics_external(elimination, Axes::World)),
                "Forward dynamics with a wrench on each link (in the order of `LINK_NAMES`) at the link's\n\
                 origin in the world's axes.",
            ),
            Function::InverseDynamicsExternal => (
                vec![q(), v("qd"), v("qdd"), forces()],
                vector(),
                one(all_links.inverse_dynamics_external(Axes::Link)),
                "Inverse dynamics with a wrench on each link (in the order of `LINK_NAMES`) at the link's\n\
                 origin in its own axes.",
            ),
            Function::InverseDynamicsExternalWorld => (
                vec![q(), v("qd"), v("qdd"), forces()],
                vector(),
                one(all_links.inverse_dynamics_external(Axes::World)),
                "Inverse dynamics with a wrench on each link (in the order of `LINK_NAMES`) at the link's\n\
                 origin in the world's axes.",
            ),
            Function::LinkPoses => (
                vec![q()],
                Shape::pose().array(links),
                if source.frames.any_shared() {
                    Graphs::Poses(Box::new(source.frames.poses().map(optimize)))
                } else {
                    one(all_links.link_poses())
                },
                "The poses in the world of all links of the description, fixed ones too, in the order of\n\
                 `LINK_NAMES`.",
            ),
            Function::InverseDynamicsDerivatives | Function::InverseDynamicsDerivativesBatch => (
                vec![q(), v("qd"), v("qdd")],
                Shape::Struct {
                    path: "__modyn::InverseDynamicsDerivatives".into(),
                    arguments: square().type_of("{t}"),
                    fields: vec![("dq", square()), ("dqd", square())],
                },
                one(tracer.inverse_dynamics_derivatives()),
                "The derivatives of the inverse dynamics by `q` (in tangent space) and `qd`, each an array of\n\
                 columns; the one by `qdd` is the mass matrix.",
            ),
            Function::ForwardDynamicsDerivatives | Function::ForwardDynamicsDerivativesBatch => (
                vec![q(), v("qd"), v("tau")],
                Shape::Struct {
                    path: "__modyn::ForwardDynamicsDerivatives".into(),
                    arguments: format!("{}, {}", vector().type_of("{t}"), square().type_of("{t}")),
                    fields: vec![
                        ("qdd", vector()),
                        ("dq", square()),
                        ("dqd", square()),
                        ("dtau", square()),
                    ],
                },
                one(tracer.forward_dynamics_derivatives(for_derivatives)),
                "The derivatives of the forward dynamics by `q` (in tangent space), `qd` and `tau`, each an\n\
                 array of columns, with the accelerations.",
            ),
            Function::ConstrainedForwardDynamics => (
                vec![q(), v("qd"), v("tau"), settings()],
                Shape::Struct {
                    path: "__modyn::ConstrainedForwardDynamics".into(),
                    arguments: format!(
                        "{}, {}, {}, {{t}}",
                        vector().type_of("{t}"),
                        Shape::wrench().array(loop_constraints).type_of("{t}"),
                        Shape::twist().array(loop_constraints).type_of("{t}")
                    ),
                    fields: vec![
                        ("qdd", vector()),
                        ("wrenches", Shape::wrench().array(loop_constraints)),
                        ("residuals", Shape::twist().array(loop_constraints)),
                        ("rank", Shape::Scalar),
                    ],
                },
                one(tracer.constrained_forward_dynamics(layout)),
                "Joint accelerations under the joint torques or forces `tau` with the loops closed; for each loop\n\
                 constraint (in the order of `LOOP_CONSTRAINT_NAMES`) the wrench on its second link and the part\n\
                 of its acceleration that could not be met, at the second frame's origin in the first frame's\n\
                 axes; and the number of independent constraint rows. Redundant constraints share their forces.",
            ),
            Function::ConstraintResidual => (
                vec![q(), v("qd")],
                Shape::Struct {
                    path: "__modyn::ConstraintResidual".into(),
                    arguments: Shape::twist().array(loop_constraints).type_of("{t}"),
                    fields: vec![
                        ("displacements", Shape::twist().array(loop_constraints)),
                        ("velocities", Shape::twist().array(loop_constraints)),
                    ],
                },
                one(tracer.constraint_residual()),
                "How far the second frame of each loop constraint is displaced from the first, and its relative\n\
                 velocity, in the first frame's axes, without the free directions. Rotations are given by their\n\
                 axes times the sines of their angles.",
            ),
            Function::ProjectConstraints => (
                vec![q(), v("qd"), settings()],
                Shape::Struct {
                    path: "__modyn::ConstraintProjection".into(),
                    arguments: format!("{}, {{t}}", vector().type_of("{t}")),
                    fields: vec![("dq", vector()), ("dqd", vector()), ("rank", Shape::Scalar)],
                },
                one(tracer.project_constraints(layout)),
                "The smallest step (in the metric of the mass matrix) that, to first order, closes the loops at\n\
                 `q`, the smallest change of `qd` that keeps them closed, and the number of independent\n\
                 constraint rows. Of `settings`, `alpha` and `beta` do not matter.",
            ),
            Function::Regressor => (
                vec![q(), v("qd"), v("qdd")],
                Shape::matrix(PARAMETERS_PER_LINK * self.model.links().len(), nv),
                one(tracer.regressor()),
                "The regressor Y of the inverse dynamics, an array of columns: tau = Y pi (rotors and friction\n\
                 apart), where pi holds ten numbers a moving link: mass, mass times centre of mass x, y, z, and\n\
                 Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the link's origin in its own axes (`PARAMETERS`).",
            ),
            Function::CenterOfMass => (
                vec![q()],
                Shape::vector(3),
                one(tracer.center_of_mass()),
                "The centre of mass of the moving links in the world, m.",
            ),
            Function::CenterOfMassJacobian => (
                vec![q()],
                Shape::vector3().array(nv),
                one(tracer.center_of_mass_jacobian()),
                "The derivative of the centre of mass, an array of columns: its velocity is this times `qd`.",
            ),
            Function::CentroidalMomentumMatrix => (
                vec![q()],
                Shape::momentum().array(nv),
                one(tracer.centroidal_momentum_matrix()),
                "The centroidal momentum matrix, an array of columns: this times `qd` is the momentum about the\n\
                 centre of mass, in world axes.",
            ),
            Function::CentroidalMomentum => (
                vec![q(), v("qd")],
                Shape::momentum(),
                one(tracer.centroidal_momentum()),
                "The momentum of the moving links about their centre of mass, in world axes.",
            ),
            Function::LinkPose => (
                vec![q()],
                Shape::pose(),
                by_link(&|tracer| tracer.link_pose(0)),
                "The pose of a link in the world; computes its chain alone.",
            ),
            Function::LinkVelocity => (
                vec![q(), v("qd")],
                Shape::twist(),
                by_link(&|tracer| tracer.link_velocity(0, Axes::World)),
                "The velocity of a link's origin (m/s) and its angular velocity (rad/s), in world axes;\n\
                 computes its chain alone.",
            ),
            Function::LocalLinkVelocity => (
                vec![q(), v("qd")],
                Shape::twist(),
                by_link(&|tracer| tracer.link_velocity(0, Axes::Link)),
                "The velocity of a link's origin (m/s) and its angular velocity (rad/s), in its own axes;\n\
                 computes its chain alone.",
            ),
            Function::LinkAcceleration => (
                vec![q(), v("qd"), v("qdd")],
                Shape::twist(),
                by_link(&|tracer| tracer.link_acceleration(0, Axes::World)),
                "The (classical) acceleration of a link's origin (m/s^2), gravity left out, and its angular\n\
                 acceleration (rad/s^2), in world axes; computes its chain alone.",
            ),
            Function::LocalLinkAcceleration => (
                vec![q(), v("qd"), v("qdd")],
                Shape::twist(),
                by_link(&|tracer| tracer.link_acceleration(0, Axes::Link)),
                "The (classical) acceleration of a link's origin (m/s^2), gravity left out, and its angular\n\
                 acceleration (rad/s^2), in its own axes; computes its chain alone.",
            ),
            Function::Jacobian => (
                vec![q()],
                Shape::twist().array(nv),
                by_link(&|tracer| tracer.jacobian(0, Axes::World)),
                "The Jacobian of a link, an array of columns: this times `qd` is its velocity at its origin, in\n\
                 world axes; computes its chain alone.",
            ),
            Function::LocalJacobian => (
                vec![q()],
                Shape::twist().array(nv),
                by_link(&|tracer| tracer.jacobian(0, Axes::Link)),
                "The Jacobian of a link, an array of columns: this times `qd` is its velocity at its origin, in\n\
                 its own axes; computes its chain alone.",
            ),
            Function::JacobianRate => (
                vec![q(), v("qd")],
                Shape::twist(),
                by_link(&|tracer| tracer.jacobian_rate(0, Axes::World)),
                "The time derivative of `jacobian`, times `qd`: the link's (classical) acceleration without\n\
                 joint accelerations, in world axes; computes its chain alone.",
            ),
            Function::LocalJacobianRate => (
                vec![q(), v("qd")],
                Shape::twist(),
                by_link(&|tracer| tracer.jacobian_rate(0, Axes::Link)),
                "The time derivative of `local_jacobian`, times `qd`: the rates of the components of the link's\n\
                 velocity in its own axes; computes its chain alone.",
            ),
            Function::Integrate => (
                vec![q(), v("v")],
                Shape::vector(nq),
                one(tracer.integrate()),
                "The coordinates behind a displacement `v` (a velocity times a time) from `q`.",
            ),
            Function::Difference => (
                vec![
                    Parameter::new("from", Shape::vector(nq)),
                    Parameter::new("to", Shape::vector(nq)),
                ],
                vector(),
                one(tracer.difference()),
                "The displacement that leads from one to the other, by `integrate`: the shortest rotations;\n\
                 angles of single joints are not wrapped.",
            ),
            Function::CoordinateRates => (
                vec![q(), v("qd")],
                Shape::vector(nq),
                one(tracer.coordinate_rates()),
                "The rates of the coordinates: dq/dt.",
            ),
            Function::Normalize => (
                vec![q()],
                Shape::vector(nq),
                one(tracer.normalize()),
                "The same coordinates, quaternions brought to unit length.",
            ),
            Function::Random => (
                vec![Parameter::new("uniforms", Shape::vector(tracer.uniforms()))],
                Shape::vector(nq),
                one(tracer.random()),
                "Coordinates within the joints' limits from numbers in [0, 1), evenly spread: angles without\n\
                 limits in [-pi, pi), displacements without limits in [-1, 1), rotations of any direction.",
            ),
        };
        let graphs = match graphs {
            // A long function keeps all units busy, whatever waits for what.
            Graphs::One(graph) if graph.count().total() <= MOST_BALANCED => {
                Graphs::One(balance(&graph))
            }
            other => other,
        };
        let dynamic = function.depends_on_parameters();
        let abreast = match &graphs {
            Graphs::One(graph) => abreast(function, source, graph),
            Graphs::ByLink(_) | Graphs::Poses(_) => None,
        };
        Quantity { function, parameters, shape, dynamic, graphs, abreast, docs }
    }
}

/// The function on vectors, if that pays: with limbs side by side if that takes clearly fewer operations
/// than `alone`; else as it is, for products fused into sums where the processor has that and the program
/// does not count on it.
fn abreast(function: Function, source: &Source<'_>, alone: &Graph) -> Option<Graph> {
    let count = |graph: &Graph| graph.count().total();
    let limbs = source.limbs.iter().flat_map(|limbs| side_by_side(function, source, limbs));
    let columns = columns_side_by_side(function, source).filter(|_| count(alone) <= MOST_COLUMNS);
    let graphs = limbs.chain(columns);
    let cheapest = graphs.map(|graph| balance(&optimize(graph))).min_by_key(count);
    let pays = |graph: &Graph| count(graph) * 5 < count(alone) * 4;
    if let Some(graph) = cheapest.filter(pays) {
        return Some(graph);
    }
    let often = matches!(
        function,
        Function::ForwardDynamics
            | Function::InverseDynamics
            | Function::BiasForces
            | Function::MassMatrix
            | Function::ForwardDynamicsDerivatives
            | Function::InverseDynamicsDerivatives
    );
    (source.vectors && often && DISPATCHED.contains(&count(alone))).then(|| alone.clone())
}

/// Most operations of a function, limbs one after the other, that waits for its longest way.
const MOST_BALANCED: usize = 2000;

/// Most operations of derivatives, column by column, that are compiled with columns side by side, too.
const MOST_COLUMNS: usize = 20_000;

/// Operations of functions that are compiled for several instruction sets even if nothing stands side by
/// side: fewer take no longer than finding out, more cost the compiler more than they are worth.
const DISPATCHED: std::ops::Range<usize> = 100..5000;

/// The graph with columns side by side.
fn columns_side_by_side(function: Function, source: &Source<'_>) -> Option<Graph> {
    let tracer = source.tracer.column_lanes();
    match function {
        _ if !source.vectors => None,
        Function::InverseDynamicsDerivatives => Some(tracer.inverse_dynamics_derivatives()),
        Function::ForwardDynamicsDerivatives => {
            Some(tracer.forward_dynamics_derivatives(source.for_derivatives))
        }
        _ => None,
    }
}

/// The graphs with these limbs side by side, among which the cheapest is the one.
fn side_by_side(function: Function, source: &Source<'_>, limbs: &Limbs) -> Vec<Graph> {
    let tracer = source.tracer.abreast(limbs);
    vec![match function {
        Function::ForwardDynamics => {
            let by = |partition| Elimination::Recursive(limbs.partition(partition));
            return source.partitions.iter().map(|p| tracer.forward_dynamics(&by(p))).collect();
        }
        Function::InverseDynamics => tracer.inverse_dynamics(),
        Function::BiasForces => tracer.bias_forces(),
        Function::GravityTorques => tracer.gravity_torques(),
        // What is carried on from limbs to the root has one way to go.
        _ if !limbs.on_one_way(tracer.model()) => return Vec::new(),
        Function::MassMatrix => tracer.mass_matrix(),
        // Where limbs move each other, derivatives are written on vectors alone.
        Function::InverseDynamicsDerivatives | Function::ForwardDynamicsDerivatives
            if !(source.vectors || source.independent) =>
        {
            return Vec::new();
        }
        Function::InverseDynamicsDerivatives => tracer.inverse_dynamics_derivatives(),
        Function::ForwardDynamicsDerivatives => {
            tracer.forward_dynamics_derivatives(source.for_derivatives)
        }
        _ => return Vec::new(),
    }]
}
