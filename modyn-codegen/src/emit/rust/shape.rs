//! The arguments and results of functions, as Rust types, values and patterns over a list of
//! scalars.

/// A Rust type composed of scalars.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Scalar,
    /// An array of equal elements.
    Array(Box<Shape>, usize),
    /// A structure of the runtime or of the text itself.
    Struct {
        path: String,
        /// The generic arguments, with `{t}` for the scalar.
        arguments: String,
        /// The fields with their names; a field of a tuple has none.
        fields: Vec<(&'static str, Shape)>,
    },
}

impl Shape {
    pub(super) fn array(self, n: usize) -> Self {
        Self::Array(Box::new(self), n)
    }

    pub(super) fn vector(n: usize) -> Self {
        Self::Scalar.array(n)
    }

    /// Returns the Rust type of a planned shape; `robot` is the name of the robot's type.
    pub(super) fn new(shape: &crate::plan::Shape, robot: &str) -> Self {
        use crate::plan::{Record, Shape as Planned};
        let (record, fields) = match shape {
            Planned::Scalar => return Self::Scalar,
            Planned::Array(element, n, _) => return Self::new(element, robot).array(*n),
            Planned::Record(record, fields) => (record, fields),
        };
        let fields: Vec<(&'static str, Self)> =
            fields.iter().map(|(name, field)| (*name, Self::new(field, robot))).collect();
        let (path, arguments) = match record {
            Record::Spatial(name) => (format!("__modyn::spatial::{name}"), "{t}".into()),
            Record::Pose => ("__modyn::spatial::Pose".into(), "{t}".into()),
            Record::OfScalar(name) => (format!("__modyn::{name}"), "{t}".into()),
            // Private functions have an array of numbers.
            Record::Contacts => {
                return fields.into_iter().map(|(_, field)| field).next().unwrap_or(Self::Scalar);
            }
            Record::Factorization => (format!("{robot}UduFactorization"), "{t}".into()),
            Record::Fused(name) => (format!("{robot}{name}"), "{t}".into()),
            Record::ResultsByField(name) => {
                let types: Vec<String> =
                    fields.iter().map(|(_, field)| field.type_of("{t}")).collect();
                (format!("__modyn::{name}"), types.join(", "))
            }
            Record::ResultsByType(name) => {
                let mut types: Vec<String> = Vec::new();
                for (_, field) in &fields {
                    let field = field.type_of("{t}");
                    if !types.contains(&field) {
                        types.push(field);
                    }
                }
                (format!("__modyn::{name}"), types.join(", "))
            }
        };
        Self::Struct { path, arguments, fields }
    }

    /// Returns the number of scalars.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Array(element, n) => element.len() * n,
            Self::Struct { fields, .. } => fields.iter().map(|(_, field)| field.len()).sum(),
        }
    }

    /// Returns the Rust type over scalar `t`.
    pub(super) fn type_of(&self, t: &str) -> String {
        match self {
            Self::Scalar => t.into(),
            Self::Array(element, n) => format!("[{}; {n}]", element.type_of(t)),
            Self::Struct { path, arguments, .. } => {
                format!("{path}<{}>", arguments.replace("{t}", t))
            }
        }
    }

    /// Returns the value (or pattern) from the texts of all its scalars.
    pub(super) fn value(&self, scalars: &[String]) -> String {
        match self {
            Self::Scalar => scalars.concat(),
            Self::Array(element, _) if matches!(**element, Self::Scalar) => {
                format!("[{}]", scalars.join(", "))
            }
            Self::Array(element, n) => {
                let lines: Vec<String> = (0..*n)
                    .map(|i| {
                        format!(
                            "        {},\n",
                            element.value(&scalars[i * element.len()..][..element.len()])
                        )
                    })
                    .collect();
                format!("[\n{}    ]", lines.concat())
            }
            Self::Struct { path, fields, .. } => {
                let mut rest = scalars;
                let fields: Vec<String> = fields
                    .iter()
                    .map(|(name, field)| {
                        let (numbers, after) = rest.split_at(field.len());
                        rest = after;
                        let value = field.value(numbers);
                        if name.is_empty() { value } else { format!("{name}: {value}") }
                    })
                    .collect();
                if let Self::Struct { fields: named, .. } = self
                    && named.iter().all(|(name, _)| name.is_empty())
                {
                    format!("{path}({})", fields.join(", "))
                } else {
                    format!("{path} {{ {} }}", fields.join(", "))
                }
            }
        }
    }
}
