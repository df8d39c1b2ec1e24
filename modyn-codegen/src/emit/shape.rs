//! What functions take and return, as types, values and patterns over a list of scalars.

/// A type made of scalars.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Scalar,
    /// That many of the same.
    Array(Box<Shape>, usize),
    /// A structure of the runtime or of the text itself.
    Struct {
        path: String,
        /// Its generic arguments, with `{t}` for the scalar.
        arguments: String,
        /// By name; one without a name is a tuple's.
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

    /// By columns.
    pub(super) fn matrix(columns: usize, rows: usize) -> Self {
        Self::vector(rows).array(columns)
    }

    /// A structure of the runtime that is generic over the scalar.
    fn spatial(name: &str, fields: Vec<(&'static str, Self)>) -> Self {
        Self::Struct { path: format!("__modyn::spatial::{name}"), arguments: "{t}".into(), fields }
    }

    pub(super) fn vector3() -> Self {
        Self::spatial("Vector3", vec![("", Self::vector(3))])
    }

    pub(super) fn pose() -> Self {
        let fields = vec![("rotation", Self::matrix(3, 3)), ("translation", Self::vector(3))];
        Self::spatial("Pose", fields)
    }

    pub(super) fn twist() -> Self {
        Self::spatial("Twist", vec![("angular", Self::vector3()), ("linear", Self::vector3())])
    }

    pub(super) fn momentum() -> Self {
        Self::spatial("Momentum", vec![("angular", Self::vector3()), ("linear", Self::vector3())])
    }

    pub(super) fn wrench() -> Self {
        Self::spatial("Wrench", vec![("moment", Self::vector3()), ("force", Self::vector3())])
    }

    pub(super) fn constraint_settings() -> Self {
        let fields = ["alpha", "beta", "tolerance", "rounding"].map(|name| (name, Self::Scalar));
        Self::Struct {
            path: "__modyn::ConstraintSettings".into(),
            arguments: "{t}".into(),
            fields: fields.into(),
        }
    }

    /// How many scalars it holds.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Array(of, n) => of.len() * n,
            Self::Struct { fields, .. } => fields.iter().map(|(_, field)| field.len()).sum(),
        }
    }

    /// The Rust type over scalar `t`.
    pub(super) fn type_of(&self, t: &str) -> String {
        match self {
            Self::Scalar => t.into(),
            Self::Array(of, n) => format!("[{}; {n}]", of.type_of(t)),
            Self::Struct { path, arguments, .. } => {
                format!("{path}<{}>", arguments.replace("{t}", t))
            }
        }
    }

    /// The value (or pattern) from the texts of its scalars, as many as it holds.
    pub(super) fn value(&self, scalars: &[String]) -> String {
        match self {
            Self::Scalar => scalars.concat(),
            Self::Array(of, _) if matches!(**of, Self::Scalar) => {
                format!("[{}]", scalars.join(", "))
            }
            Self::Array(of, n) => {
                let lines: Vec<String> = (0..*n)
                    .map(|i| {
                        format!("        {},\n", of.value(&scalars[i * of.len()..][..of.len()]))
                    })
                    .collect();
                format!("[\n{}    ]", lines.concat())
            }
            Self::Struct { path, fields, .. } => {
                let mut rest = scalars;
                let fields: Vec<String> = fields
                    .iter()
                    .map(|(name, field)| {
                        let (own, behind) = rest.split_at(field.len());
                        rest = behind;
                        let value = field.value(own);
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
