//! The layout of arguments and results: scalars in a row, and how they are grouped. No language has a part in it.

/// A layout of scalars.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One scalar.
    Scalar,
    /// That many of the same, one after another.
    Array(Box<Shape>, usize),
    /// Named fields, one after another.
    Record(Record, Vec<(&'static str, Shape)>),
}

/// A group of fields that has a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Record {
    /// A quantity of the spatial algebra, by its name.
    Spatial(&'static str),
    /// A quantity of the runtime's root that is generic over the scalar alone, by its name.
    Plain(&'static str),
    /// The factors of the mass matrix.
    Factorization,
    /// Which contacts are active: a number for each, 1 if it is, else 0.
    Contacts,
    /// The results of a function that has several, or its settings, by name.
    Several(&'static str),
}

impl Shape {
    /// `n` of these.
    #[must_use]
    pub fn array(self, n: usize) -> Self {
        Self::Array(Box::new(self), n)
    }

    /// `n` scalars.
    #[must_use]
    pub fn vector(n: usize) -> Self {
        Self::Scalar.array(n)
    }

    /// A matrix by columns.
    #[must_use]
    pub fn matrix(columns: usize, rows: usize) -> Self {
        Self::vector(rows).array(columns)
    }

    /// Three components.
    #[must_use]
    pub fn vector3() -> Self {
        Self::Record(Record::Spatial("Vector3"), vec![("", Self::vector(3))])
    }

    /// A rotation by rows, then a translation.
    #[must_use]
    pub fn pose() -> Self {
        let fields = vec![("rotation", Self::matrix(3, 3)), ("translation", Self::vector(3))];
        Self::Record(Record::Spatial("Pose"), fields)
    }

    /// Angular, then linear components.
    #[must_use]
    pub fn twist() -> Self {
        Self::two("Twist", "angular", "linear")
    }

    /// Angular, then linear components.
    #[must_use]
    pub fn momentum() -> Self {
        Self::two("Momentum", "angular", "linear")
    }

    /// Moment, then force.
    #[must_use]
    pub fn wrench() -> Self {
        Self::two("Wrench", "moment", "force")
    }

    fn two(name: &'static str, first: &'static str, second: &'static str) -> Self {
        let fields = vec![(first, Self::vector3()), (second, Self::vector3())];
        Self::Record(Record::Spatial(name), fields)
    }

    /// The number of scalars.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Array(of, n) => of.len() * n,
            Self::Record(_, fields) => fields.iter().map(|(_, field)| field.len()).sum(),
        }
    }

    /// Whether there is no scalar.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The order of the scalars in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self {
            Self::Scalar => "a number".into(),
            Self::Array(of, n) if **of == Self::Scalar => format!("{n} numbers"),
            Self::Array(of, n) => format!("{n} times ({})", of.in_words()),
            Self::Record(_, fields) => {
                let named = |(name, shape): &(&str, Self)| match *name {
                    "" => shape.in_words(),
                    name => format!("{name}: {}", shape.in_words()),
                };
                fields.iter().map(named).collect::<Vec<_>>().join(", ")
            }
        }
    }
}

/// The sizes of a robot, on which layouts depend.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sizes {
    /// Coordinates.
    pub nq: usize,
    /// Degrees of freedom.
    pub nv: usize,
    /// Links of the description.
    pub links: usize,
    /// Links that move.
    pub moving: usize,
    /// Constraints: closed loops, then contacts.
    pub constraints: usize,
    /// Contacts.
    pub contacts: usize,
    /// Constraint rows, all contacts active.
    pub constraint_rows: usize,
    /// Numbers of the mass matrix's factors.
    pub factors: usize,
}

/// The layouts that the table of functions names.
#[rustfmt::skip]
pub(super) mod shapes {
    use modyn_runtime::model::PARAMETERS_PER_LINK;

    use super::{Record, Shape, Sizes};

    pub fn scalar(_: &Sizes) -> Shape { Shape::Scalar }
    pub fn coordinates(s: &Sizes) -> Shape { Shape::vector(s.nq) }
    pub fn velocities(s: &Sizes) -> Shape { Shape::vector(s.nv) }
    pub fn square(s: &Sizes) -> Shape { Shape::matrix(s.nv, s.nv) }
    pub fn regressor(s: &Sizes) -> Shape { Shape::matrix(PARAMETERS_PER_LINK * s.moving, s.nv) }
    pub fn point(_: &Sizes) -> Shape { Shape::vector(3) }
    pub fn vectors3(s: &Sizes) -> Shape { Shape::vector3().array(s.nv) }
    pub fn pose(_: &Sizes) -> Shape { Shape::pose() }
    pub fn poses(s: &Sizes) -> Shape { Shape::pose().array(s.links) }
    pub fn twist(_: &Sizes) -> Shape { Shape::twist() }
    pub fn twists(s: &Sizes) -> Shape { Shape::twist().array(s.nv) }
    pub fn momentum(_: &Sizes) -> Shape { Shape::momentum() }
    pub fn momenta(s: &Sizes) -> Shape { Shape::momentum().array(s.nv) }
    pub fn wrenches(s: &Sizes) -> Shape { Shape::wrench().array(s.links) }

    fn several(name: &'static str, fields: Vec<(&'static str, Shape)>) -> Shape {
        Shape::Record(Record::Several(name), fields)
    }

    pub fn factors(s: &Sizes) -> Shape {
        Shape::Record(Record::Factorization, vec![("factors", Shape::vector(s.factors))])
    }

    pub fn contacts(s: &Sizes) -> Shape {
        Shape::Record(Record::Contacts, vec![("", Shape::vector(s.contacts))])
    }

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
        several("ConstraintSettings", fields)
    }

    pub fn inverse_derivatives(s: &Sizes) -> Shape {
        several("InverseDynamicsDerivatives", vec![("dq", square(s)), ("dqd", square(s))])
    }

    pub fn forward_derivatives(s: &Sizes) -> Shape {
        let matrices = ["dq", "dqd", "dtau"].map(|name| (name, square(s)));
        several("ForwardDynamicsDerivatives", [vec![("qdd", velocities(s))], matrices.into()].concat())
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
        several("ConstrainedForwardDynamics", fields)
    }

    pub fn constraint_residual(s: &Sizes) -> Shape {
        let twists = || Shape::twist().array(s.constraints);
        several("ConstraintResidual", vec![("displacements", twists()), ("velocities", twists())])
    }

    pub fn constrained_derivatives(s: &Sizes) -> Shape {
        let matrices = ["dq", "dqd", "dtau"].map(|name| (name, square(s)));
        let changes = || Shape::wrench().array(s.nv).array(s.constraints);
        let changes = ["wrenches_dq", "wrenches_dqd", "wrenches_dtau"].map(|name| (name, changes()));
        let first = [("qdd", velocities(s)), ("wrenches", Shape::wrench().array(s.constraints))];
        let fields = [&first[..], &matrices, &changes, &[("rank", Shape::Scalar)]].concat();
        several("ConstrainedForwardDynamicsDerivatives", fields)
    }

    pub fn contact_impulse(s: &Sizes) -> Shape {
        let impulses = Shape::wrench().array(s.constraints);
        let fields = vec![("qd", velocities(s)), ("impulses", impulses), ("rank", Shape::Scalar)];
        several("ContactImpulse", fields)
    }

    pub fn constrained_torques(s: &Sizes) -> Shape {
        let wrenches = Shape::wrench().array(s.constraints);
        let fields = vec![("tau", velocities(s)), ("wrenches", wrenches), ("rank", Shape::Scalar)];
        several("ConstrainedInverseDynamics", fields)
    }

    pub fn constraint_jacobian(s: &Sizes) -> Shape { twists(s).array(s.constraints) }
    pub fn constraint_twists(s: &Sizes) -> Shape { Shape::twist().array(s.constraints) }

    pub fn operational_inertia(s: &Sizes) -> Shape {
        let matrix = || Shape::matrix(s.constraint_rows, s.constraint_rows);
        let fields = vec![("inverse", matrix()), ("inertia", matrix()), ("rank", Shape::Scalar)];
        several("OperationalInertia", fields)
    }

    pub fn constraint_projection(s: &Sizes) -> Shape {
        let fields = vec![("dq", velocities(s)), ("dqd", velocities(s)), ("rank", Shape::Scalar)];
        several("ConstraintProjection", fields)
    }
}
