//! The layout of arguments and results: a sequence of scalars and its grouping, independent of any
//! language.

use alloc::{boxed::Box, format, string::String, vec, vec::Vec};

use crate::model::Model;

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
    OfScalar(&'static str),
    /// The factors of the mass matrix.
    Factorization,
    /// The set of active contacts: a number for each contact, 1 if it is active, else 0.
    Contacts,
    /// The results of a function with several results, or its settings, by name. The type is
    /// generic over the different types of its fields.
    ResultsByType(&'static str),
    /// The results of a function with several results, by name. The type is generic over the type
    /// of each field.
    ResultsByField(&'static str),
    /// The results of a fused function, by the end of the type's name. The type belongs to the
    /// robot, and is generic over the scalar.
    Fused(&'static str),
}

impl Record {
    /// Returns the name of the type of results with these fields; `None` for groups that are one
    /// array of numbers where a language has no types for them.
    #[must_use]
    pub fn result_type(self) -> Option<&'static str> {
        match self {
            Self::Spatial(_) | Self::Factorization | Self::Contacts => None,
            Self::Pose => Some("Pose"),
            Self::OfScalar(name)
            | Self::ResultsByType(name)
            | Self::ResultsByField(name)
            | Self::Fused(name) => Some(name),
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

    /// Returns the layout of a twist: linear, then angular components.
    #[must_use]
    pub fn twist() -> Self {
        Self::pair_of_vectors("Twist", "linear", "angular")
    }

    /// Returns the layout of a momentum: linear, then angular components.
    #[must_use]
    pub fn momentum() -> Self {
        Self::pair_of_vectors("Momentum", "linear", "angular")
    }

    /// Returns the layout of a wrench: force, then moment.
    #[must_use]
    pub fn wrench() -> Self {
        Self::pair_of_vectors("Wrench", "force", "moment")
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
            Self::Array(element, n, _) => element.len() * n,
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
            Self::Array(element, ..) => **element == Self::Scalar,
            Self::Record(record, _) => record.result_type().is_none(),
        }
    }

    /// Returns the order of the scalars in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self {
            Self::Scalar => "a number".into(),
            Self::Array(element, n, _) if **element == Self::Scalar => format!("{n} numbers"),
            Self::Array(element, n, _) => format!("{n} times ({})", element.in_words()),
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
    /// The number of quaternions in the coordinates.
    pub quaternions: usize,
    /// The number of constraints: closed loops and contacts.
    pub constraints: usize,
    /// The number of contacts.
    pub contacts: usize,
    /// The number of constraint rows, all contacts active.
    pub constraint_rows: usize,
    /// The number of shapes that touch the ground in a step.
    pub touching_shapes: usize,
    /// The number of points of these shapes that can touch it at the same time.
    pub touching_points: usize,
    /// The number of controls: of actuators.
    pub controls: usize,
    /// The number of activations.
    pub activations: usize,
    /// The number of entries of the mass matrix's factors.
    pub factors: usize,
}

impl Sizes {
    /// Returns the sizes of a model whose mass matrix has this number of factors.
    #[must_use]
    pub fn new(model: &Model, factors: usize) -> Self {
        let shapes = model.touching_shapes();
        Self {
            nq: model.nq(),
            nv: model.nv(),
            links: model.links().len(),
            moving: model.moving_links().len(),
            quaternions: model.quaternions().count(),
            constraints: model.constraints(),
            contacts: model.contacts().len(),
            constraint_rows: model.constraint_rows(),
            touching_shapes: shapes.len(),
            touching_points: shapes.iter().map(|shape| shape.shape.points()).sum(),
            controls: model.actuation().actuators.len(),
            activations: model.actuation().states(),
            factors,
        }
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use crate::{ConstraintSettings, ContactTarget};

    use super::{Shape, Sizes};
    use crate::quantities::shapes;

    /// The runtime reads settings from numbers in the order of the layout.
    #[test]
    fn settings_have_the_order_of_the_runtime() {
        let sizes = Sizes { contacts: 2, touching_shapes: 2, ..Sizes::default() };
        let Shape::Record(_, mut settings) = shapes::settings(&sizes) else { panic!() };
        let Some(("targets", Shape::Array(target, 2, _))) = settings.pop() else { panic!() };
        let Shape::Record(_, target) = *target else { panic!() };

        let numbers = core::array::from_fn(|k| 2.0 + k as f64);
        let without_targets = ConstraintSettings::from_numbers(numbers, ());
        assert_eq!(without_targets.numbers(), numbers);
        let value = |name| match name {
            "alpha" => without_targets.alpha,
            "beta" => without_targets.beta,
            "tolerance" => without_targets.tolerance,
            "rounding" => without_targets.rounding,
            _ => panic!("{name}"),
        };
        assert!(settings.iter().map(|(name, _)| value(name)).eq(numbers));
        assert!(settings.iter().all(|(_, shape)| *shape == Shape::Scalar));

        let numbers = core::array::from_fn(|k| 7.0 + k as f64);
        let parsed_target = ContactTarget::from_numbers(numbers);
        assert_eq!(parsed_target.numbers(), numbers);
        let values = |(name, shape): &(&str, Shape)| {
            let scalar = |value| (Shape::Scalar, vec![value]);
            let (expected, values) = match *name {
                "pose" => {
                    let rotation = parsed_target.pose.rotation.as_flattened();
                    (Shape::pose(), [rotation, &parsed_target.pose.translation].concat())
                }
                "velocity" => (Shape::twist(), parsed_target.velocity.components().to_vec()),
                "tangential" => scalar(parsed_target.tangential),
                "alpha" => scalar(parsed_target.alpha),
                "beta" => scalar(parsed_target.beta),
                "compliance" => scalar(parsed_target.compliance),
                "restitution" => scalar(parsed_target.restitution),
                "weight" => scalar(parsed_target.weight),
                _ => panic!("{name}"),
            };
            assert_eq!(*shape, expected, "{name}");
            values
        };
        assert!(target.iter().flat_map(values).eq(numbers));
    }
}
