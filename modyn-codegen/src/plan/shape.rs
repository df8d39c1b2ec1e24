//! The layout of arguments and results: a sequence of scalars and its grouping, independent of any language.

use modyn_runtime::model::Model;

/// A layout of scalars.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One scalar.
    Scalar,
    /// A number of equal layouts, one after the other, and their meaning.
    Array(Box<Shape>, usize, Elements),
    /// Named fields, one after the other.
    Record(Record, Vec<(&'static str, Shape)>),
}

/// The meaning of the elements of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Elements {
    /// One for each link, contact, component or the like.
    List,
    /// The columns of a matrix.
    Columns,
    /// The rows of a matrix.
    Rows,
}

/// A named group of fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Record {
    /// A spatial vector, by its name.
    Spatial(&'static str),
    /// A rotation and a translation.
    Pose,
    /// A type of the runtime's root that is generic over the scalar only, by its name.
    Plain(&'static str),
    /// The factors of the mass matrix.
    Factorization,
    /// The set of active contacts: a number for each contact, 1 if it is active, else 0.
    Contacts,
    /// The results of a function with several results, or its settings, by name. The type is generic over the different
    /// types of its fields.
    Several(&'static str),
    /// The results of a function with several results, by name. The type is generic over the type of each field.
    Each(&'static str),
    /// The results of a bundle, by the end of the type's name. The type belongs to the robot, and is generic over the
    /// scalar.
    Own(&'static str),
}

impl Record {
    /// Returns the name of the type of results with these fields; `None` for groups that are one array of numbers where a
    /// language has no types for them.
    #[must_use]
    pub fn result_type(self) -> Option<&'static str> {
        match self {
            Self::Spatial(_) | Self::Factorization | Self::Contacts => None,
            Self::Pose => Some("Pose"),
            Self::Plain(name) | Self::Several(name) | Self::Each(name) | Self::Own(name) => {
                Some(name)
            }
        }
    }
}

impl Shape {
    /// Returns the layout of a list of `n` of these.
    #[must_use]
    pub fn array(self, n: usize) -> Self {
        Self::Array(Box::new(self), n, Elements::List)
    }

    /// Returns the layout of a matrix that has `n` of these as columns.
    #[must_use]
    pub fn columns(self, n: usize) -> Self {
        Self::Array(Box::new(self), n, Elements::Columns)
    }

    /// Returns the layout of a matrix that has `n` of these as rows.
    #[must_use]
    pub fn rows(self, n: usize) -> Self {
        Self::Array(Box::new(self), n, Elements::Rows)
    }

    /// Returns the layout of `n` scalars.
    #[must_use]
    pub fn vector(n: usize) -> Self {
        Self::Scalar.array(n)
    }

    /// Returns the layout of a matrix by columns.
    #[must_use]
    pub fn matrix(columns: usize, rows: usize) -> Self {
        Self::vector(rows).columns(columns)
    }

    /// Returns the layout of three components.
    #[must_use]
    pub fn vector3() -> Self {
        Self::Record(Record::Spatial("Vector3"), vec![("", Self::vector(3))])
    }

    /// Returns the layout of a pose: a rotation by rows, then a translation.
    #[must_use]
    pub fn pose() -> Self {
        let fields = vec![("rotation", Self::vector(3).rows(3)), ("translation", Self::vector(3))];
        Self::Record(Record::Pose, fields)
    }

    /// Returns the layout of a twist: angular, then linear components.
    #[must_use]
    pub fn twist() -> Self {
        Self::pair_of_vectors("Twist", "angular", "linear")
    }

    /// Returns the layout of a momentum: angular, then linear components.
    #[must_use]
    pub fn momentum() -> Self {
        Self::pair_of_vectors("Momentum", "angular", "linear")
    }

    /// Returns the layout of a wrench: moment, then force.
    #[must_use]
    pub fn wrench() -> Self {
        Self::pair_of_vectors("Wrench", "moment", "force")
    }

    fn pair_of_vectors(name: &'static str, first: &'static str, second: &'static str) -> Self {
        let fields = vec![(first, Self::vector3()), (second, Self::vector3())];
        Self::Record(Record::Spatial(name), fields)
    }

    /// Returns the number of scalars.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Array(of, n, _) => of.len() * n,
            Self::Record(_, fields) => fields.iter().map(|(_, field)| field.len()).sum(),
        }
    }

    /// Returns whether the layout has no scalar.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns whether the layout is a vector: numbers, or a spatial vector.
    #[must_use]
    pub fn is_vector(&self) -> bool {
        match self {
            Self::Scalar => false,
            Self::Array(of, ..) => **of == Self::Scalar,
            Self::Record(record, _) => record.result_type().is_none(),
        }
    }

    /// Returns the order of the scalars in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self {
            Self::Scalar => "a number".into(),
            Self::Array(of, n, _) if **of == Self::Scalar => format!("{n} numbers"),
            Self::Array(of, n, _) => format!("{n} times ({})", of.in_words()),
            Self::Record(_, fields) => {
                let named = |(name, shape): &(&str, Self)| match *name {
                    "" => shape.in_words(),
                    name if matches!(shape, Self::Record(_, fields) if fields.len() > 1) => {
                        format!("{name}: ({})", shape.in_words())
                    }
                    name => format!("{name}: {}", shape.in_words()),
                };
                fields.iter().map(named).collect::<Vec<_>>().join(", ")
            }
        }
    }
}

/// The sizes of a robot, which layouts depend on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sizes {
    /// The number of coordinates.
    pub nq: usize,
    /// The number of degrees of freedom.
    pub nv: usize,
    /// The number of links of the description.
    pub links: usize,
    /// The number of moving links.
    pub moving: usize,
    /// The number of constraints: closed loops and contacts.
    pub constraints: usize,
    /// The number of contacts.
    pub contacts: usize,
    /// The number of constraint rows, all contacts active.
    pub constraint_rows: usize,
    /// The number of entries of the mass matrix's factors.
    pub factors: usize,
}

impl Sizes {
    /// Returns the sizes of a model whose mass matrix has this number of factors.
    pub(crate) fn new(model: &Model, factors: usize) -> Self {
        Self {
            nq: model.nq(),
            nv: model.nv(),
            links: model.frames().len(),
            moving: model.links().len(),
            constraints: model.constraints(),
            contacts: model.contacts().len(),
            constraint_rows: model.constraint_rows(),
            factors,
        }
    }
}

/// The layouts in the table of functions.
#[rustfmt::skip]
pub(crate) mod shapes {
    use modyn_runtime::model::PARAMETERS_PER_LINK;

    use super::{Record, Shape, Sizes};

    pub fn scalar(_: &Sizes) -> Shape { Shape::Scalar }
    pub fn coordinates(s: &Sizes) -> Shape { Shape::vector(s.nq) }
    pub fn velocities(s: &Sizes) -> Shape { Shape::vector(s.nv) }
    pub fn state(s: &Sizes) -> Shape { Shape::vector(2 * s.nv) }
    pub fn square(s: &Sizes) -> Shape { Shape::matrix(s.nv, s.nv) }
    pub fn regressor(s: &Sizes) -> Shape { Shape::matrix(PARAMETERS_PER_LINK * s.moving, s.nv) }
    pub fn point(_: &Sizes) -> Shape { Shape::vector(3) }
    pub fn vectors3(s: &Sizes) -> Shape { Shape::vector3().columns(s.nv) }
    pub fn pose(_: &Sizes) -> Shape { Shape::pose() }
    pub fn poses(s: &Sizes) -> Shape { Shape::pose().array(s.links) }
    pub fn twist(_: &Sizes) -> Shape { Shape::twist() }
    pub fn twists(s: &Sizes) -> Shape { Shape::twist().columns(s.nv) }
    pub fn momentum(_: &Sizes) -> Shape { Shape::momentum() }
    pub fn momenta(s: &Sizes) -> Shape { Shape::momentum().columns(s.nv) }
    pub fn wrenches(s: &Sizes) -> Shape { Shape::wrench().array(s.links) }

    fn named_fields(name: &'static str, fields: Vec<(&'static str, Shape)>) -> Shape {
        Shape::Record(Record::Several(name), fields)
    }

    pub fn factors(s: &Sizes) -> Shape {
        Shape::Record(Record::Factorization, vec![("factors", Shape::vector(s.factors))])
    }

    pub fn contacts(s: &Sizes) -> Shape {
        Shape::Record(Record::Contacts, vec![("", Shape::vector(s.contacts))])
    }

    /// Returns the layout of the settings of constraints.
    pub fn settings(s: &Sizes) -> Shape {
        let scalars = |names: &[&'static str]| -> Vec<(&'static str, Shape)> {
            names.iter().map(|&name| (name, Shape::Scalar)).collect()
        };
        let target = [
            vec![("pose", Shape::pose()), ("velocity", Shape::twist())],
            scalars(&["tangential", "alpha", "beta", "compliance", "restitution", "weight"]),
        ];
        let target = Shape::Record(Record::Plain("ContactTarget"), target.concat());
        let mut fields = scalars(&["alpha", "beta", "tolerance", "rounding"]);
        fields.push(("contacts", target.array(s.contacts)));
        named_fields("ConstraintSettings", fields)
    }

    pub fn inverse_derivatives(s: &Sizes) -> Shape {
        named_fields("InverseDynamicsDerivatives", vec![("dq", square(s)), ("dqd", square(s))])
    }

    pub fn forward_derivatives(s: &Sizes) -> Shape {
        let matrices = ["dq", "dqd", "dtau"].map(|name| (name, square(s)));
        named_fields("ForwardDynamicsDerivatives", [vec![("qdd", velocities(s))], matrices.into()].concat())
    }

    pub fn generalized_forces(s: &Sizes) -> Shape {
        named_fields("GeneralizedForces", vec![("tau", velocities(s)), ("dq", square(s))])
    }

    pub fn centroidal_derivatives(s: &Sizes) -> Shape {
        let fields = vec![
            ("momentum", momentum(s)),
            ("rate", momentum(s)),
            ("momentum_dq", momenta(s)),
            ("rate_dq", momenta(s)),
            ("rate_dqd", momenta(s)),
        ];
        named_fields("CentroidalMomentumDerivatives", fields)
    }

    pub fn integrate_derivatives(s: &Sizes) -> Shape {
        named_fields("IntegrateDerivatives", vec![("dq", square(s)), ("dv", square(s))])
    }

    pub fn difference_derivatives(s: &Sizes) -> Shape {
        named_fields("DifferenceDerivatives", vec![("dfrom", square(s)), ("dto", square(s))])
    }

    fn vectors(name: &'static str, fields: &[&'static str], s: &Sizes) -> Shape {
        named_fields(name, fields.iter().map(|&field| (field, velocities(s))).collect())
    }

    pub fn inverse_vjp(s: &Sizes) -> Shape { vectors("InverseDynamicsVjp", &["tau", "dq", "dqd", "dqdd"], s) }
    pub fn inverse_jvp(s: &Sizes) -> Shape { vectors("InverseDynamicsJvp", &["tau", "dtau"], s) }
    pub fn forward_vjp(s: &Sizes) -> Shape { vectors("ForwardDynamicsVjp", &["qdd", "dq", "dqd", "dtau"], s) }
    pub fn forward_jvp(s: &Sizes) -> Shape { vectors("ForwardDynamicsJvp", &["qdd", "dqdd"], s) }

    fn hessian(name: &'static str, vectors: &[&'static str], matrices: &[&'static str], s: &Sizes) -> Shape {
        let vectors = vectors.iter().map(|&field| (field, velocities(s)));
        named_fields(name, vectors.chain(matrices.iter().map(|&field| (field, square(s)))).collect())
    }

    pub fn inverse_hessian(s: &Sizes) -> Shape {
        let matrices = ["dq_dq", "dq_dqd", "dqd_dqd", "dq_dqdd"];
        hessian("InverseDynamicsHessian", &["tau", "dq", "dqd", "dqdd"], &matrices, s)
    }

    pub fn forward_hessian(s: &Sizes) -> Shape {
        let matrices = ["dq_dq", "dq_dqd", "dqd_dqd", "dq_dtau"];
        hessian("ForwardDynamicsHessian", &["qdd", "dq", "dqd", "dtau"], &matrices, s)
    }

    pub fn step(s: &Sizes) -> Shape {
        Shape::Record(Record::Each("Step"), vec![("q", coordinates(s)), ("qd", velocities(s))])
    }

    pub fn step_derivatives(s: &Sizes) -> Shape {
        let matrices = [("a", Shape::matrix(2 * s.nv, 2 * s.nv)), ("b", Shape::matrix(s.nv, 2 * s.nv))];
        let state = [("q", coordinates(s)), ("qd", velocities(s))];
        Shape::Record(Record::Each("StepDerivatives"), [state, matrices].concat())
    }

    pub fn step_hessian(s: &Sizes) -> Shape {
        let fields = vec![
            ("q", coordinates(s)),
            ("qd", velocities(s)),
            ("dx", state(s)),
            ("dtau", velocities(s)),
            ("dx_dx", Shape::matrix(2 * s.nv, 2 * s.nv)),
            ("dx_dtau", Shape::matrix(s.nv, 2 * s.nv)),
            ("dtau_dtau", square(s)),
        ];
        Shape::Record(Record::Each("StepHessian"), fields)
    }

    pub fn constrained(s: &Sizes) -> Shape {
        let wrenches = Shape::wrench().array(s.constraints);
        let residuals = Shape::twist().array(s.constraints);
        let fields = vec![
            ("qdd", velocities(s)),
            ("wrenches", wrenches),
            ("residuals", residuals),
            ("rank", Shape::Scalar),
        ];
        named_fields("ConstrainedForwardDynamics", fields)
    }

    pub fn constraint_residual(s: &Sizes) -> Shape {
        let twists = || Shape::twist().array(s.constraints);
        named_fields("ConstraintResidual", vec![("displacements", twists()), ("velocities", twists())])
    }

    pub fn constrained_derivatives(s: &Sizes) -> Shape {
        let matrices = ["dq", "dqd", "dtau"].map(|name| (name, square(s)));
        let changes = || Shape::wrench().columns(s.nv).array(s.constraints);
        let changes = ["wrenches_dq", "wrenches_dqd", "wrenches_dtau"].map(|name| (name, changes()));
        let first = [("qdd", velocities(s)), ("wrenches", Shape::wrench().array(s.constraints))];
        let fields = [&first[..], &matrices, &changes, &[("rank", Shape::Scalar)]].concat();
        named_fields("ConstrainedForwardDynamicsDerivatives", fields)
    }

    pub fn constraint_wrenches(s: &Sizes) -> Shape { Shape::wrench().array(s.constraints) }

    pub fn constrained_hessian(s: &Sizes) -> Shape {
        let first = [("qdd", velocities(s)), ("wrenches", constraint_wrenches(s))];
        let vectors = ["dq", "dqd", "dtau"].map(|name| (name, velocities(s)));
        let matrices = ["dq_dq", "dq_dqd", "dqd_dqd", "dq_dtau"].map(|name| (name, square(s)));
        let fields = [&first[..], &vectors, &matrices, &[("rank", Shape::Scalar)]].concat();
        named_fields("ConstrainedForwardDynamicsHessian", fields)
    }

    pub fn contact_impulse(s: &Sizes) -> Shape {
        let impulses = Shape::wrench().array(s.constraints);
        let fields = vec![("qd", velocities(s)), ("impulses", impulses), ("rank", Shape::Scalar)];
        named_fields("ContactImpulse", fields)
    }

    pub fn constrained_torques(s: &Sizes) -> Shape {
        let wrenches = Shape::wrench().array(s.constraints);
        let fields = vec![("tau", velocities(s)), ("wrenches", wrenches), ("rank", Shape::Scalar)];
        named_fields("ConstrainedInverseDynamics", fields)
    }

    pub fn constraint_jacobian(s: &Sizes) -> Shape { twists(s).array(s.constraints) }
    pub fn constraint_twists(s: &Sizes) -> Shape { Shape::twist().array(s.constraints) }

    pub fn operational_inertia(s: &Sizes) -> Shape {
        let matrix = || Shape::matrix(s.constraint_rows, s.constraint_rows);
        let fields = vec![("inverse", matrix()), ("inertia", matrix()), ("rank", Shape::Scalar)];
        named_fields("OperationalInertia", fields)
    }

    pub fn constraint_projection(s: &Sizes) -> Shape {
        let fields = vec![("dq", velocities(s)), ("dqd", velocities(s)), ("rank", Shape::Scalar)];
        named_fields("ConstraintProjection", fields)
    }
}
