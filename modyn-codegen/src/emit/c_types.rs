//! Arguments and results as types of C: structs for records, arrays of numbers for everything else.
//!
//! A struct has the numbers of its layout in their order, so it can be read as an array of numbers.

use std::fmt::Write as _;

use crate::names;
use crate::plan::{Elements, Record, Shape};

/// Prints the structs of a header.
pub(super) struct CTypes {
    prefix: String,
    number: &'static str,
    defined: Vec<String>,
}

/// How C has a layout.
#[derive(Clone, Copy)]
pub(super) enum CType<'a> {
    /// An array of numbers.
    Numbers,
    /// A struct.
    Struct(Fields<'a>),
    /// An array of this many structs.
    Structs(Fields<'a>, usize),
}

/// The record of a struct.
#[derive(Clone, Copy)]
pub(super) struct Fields<'a> {
    record: Record,
    fields: &'a [(&'static str, Shape)],
}

impl<'a> CType<'a> {
    /// Returns the type of a layout. Lists of records are structs; matrices whose columns are
    /// records are numbers, as all matrices are.
    pub(super) fn new(shape: &'a Shape) -> Self {
        match shape {
            Shape::Record(record, fields) if !shape.is_empty() => match record {
                Record::Factorization | Record::Contacts | Record::Spatial("Vector3") => {
                    Self::Numbers
                }
                _ => Self::Struct(Fields { record: *record, fields }),
            },
            Shape::Array(element, count, Elements::List) if *count > 0 => {
                match Self::new(element) {
                    Self::Struct(fields) => Self::Structs(fields, *count),
                    _ => Self::Numbers,
                }
            }
            _ => Self::Numbers,
        }
    }

    /// Returns whether it is a struct, or an array of structs.
    pub(super) fn is_struct(self) -> bool {
        !matches!(self, Self::Numbers)
    }
}

impl Fields<'_> {
    /// Returns the name of the type. The results of fused functions and of users' functions have
    /// names of their own, since a user may name them as any other record.
    pub(super) fn type_name(self) -> String {
        match self.record {
            Record::Spatial(name) => name.into(),
            Record::Fused(name) => format!("{name}Results"),
            record => record.result_type().unwrap_or("Numbers").into(),
        }
    }

    /// Returns the name of the record in snake case.
    pub(super) fn name(self) -> String {
        names::snake(&self.type_name())
    }

    /// Returns the fields that have numbers: C has no arrays of no numbers.
    pub(super) fn nonempty(&self) -> impl Iterator<Item = &(&'static str, Shape)> {
        self.fields.iter().filter(|(_, shape)| !shape.is_empty())
    }
}

impl CTypes {
    /// Returns a printer of structs over numbers of this type.
    pub(super) fn new(prefix: &str, number: &'static str) -> Self {
        Self { prefix: prefix.into(), number, defined: Vec::new() }
    }

    /// Returns the type of numbers.
    pub(super) fn number(&self) -> &'static str {
        self.number
    }

    /// Returns the definitions of the structs that a layout needs and the header does not have.
    pub(super) fn definitions(&mut self, shape: &Shape) -> String {
        let (CType::Struct(fields) | CType::Structs(fields, _)) = CType::new(shape) else {
            return String::new();
        };
        let name = fields.name();
        if self.defined.contains(&name) {
            return String::new();
        }
        let mut text: String =
            fields.nonempty().map(|(_, field)| self.definitions(field)).collect();
        let prefix = &self.prefix;
        let number = self.number;
        if let Some(docs) = docs_of_record(&name) {
            let _ = writeln!(text, "/* {docs} */");
        }
        text += "typedef struct {\n";
        for (field, shape) in fields.nonempty() {
            let docs = docs_of_field(&name, field).map(String::from).or_else(|| size(shape));
            let comment = docs.map_or(String::new(), |docs| format!(" /* {docs} */"));
            let _ = writeln!(text, "    {};{comment}", self.variable(field, shape));
        }
        let is_array =
            format!("sizeof({prefix}_{name}_t) == {} * sizeof({number})", shape_of(fields).len());
        let _ = writeln!(
            text,
            "}} {prefix}_{name}_t;\ntypedef char {prefix}_{name}_is_an_array[{is_array} ? 1 : -1];\n"
        );
        self.defined.push(name);
        text
    }

    /// Returns the declaration of a parameter: a pointer to a struct, or an array. `size` returns the
    /// text of the length of an array.
    pub(super) fn parameter(
        &self,
        name: &str,
        shape: &Shape,
        size: impl Fn(usize) -> String,
    ) -> String {
        match CType::new(shape) {
            CType::Struct(fields) => format!("{} *{name}", self.name(fields)),
            CType::Structs(fields, n) => format!("{} {name}[{}]", self.name(fields), size(n)),
            CType::Numbers => format!("{} {name}[{}]", self.number, size(shape.len())),
        }
    }

    fn name(&self, fields: Fields<'_>) -> String {
        format!("{}_{}_t", self.prefix, fields.name())
    }

    /// Returns the declaration of a field or a variable.
    pub(super) fn variable(&self, name: &str, shape: &Shape) -> String {
        match CType::new(shape) {
            CType::Struct(fields) => format!("{} {name}", self.name(fields)),
            CType::Structs(fields, count) => format!("{} {name}[{count}]", self.name(fields)),
            CType::Numbers => {
                let counts = dimensions(shape).into_iter().map(|count| format!("[{count}]"));
                format!("{} {name}{}", self.number, counts.collect::<String>())
            }
        }
    }
}

/// Returns a value from the next numbers.
pub(super) fn value(shape: &Shape, numbers: &mut impl Iterator<Item = String>) -> String {
    match CType::new(shape) {
        CType::Numbers => braced(&dimensions(shape), numbers),
        CType::Struct(fields) => {
            in_braces(fields.nonempty().map(|(_, field)| value(field, numbers)).collect())
        }
        CType::Structs(fields, count) => {
            let element = shape_of(fields);
            in_braces((0..count).map(|_| value(&element, numbers)).collect())
        }
    }
}

/// Returns an array of the next numbers.
fn braced(dimensions: &[usize], numbers: &mut impl Iterator<Item = String>) -> String {
    match dimensions.split_first() {
        None => numbers.next().unwrap_or_default(),
        Some((&count, others)) => in_braces((0..count).map(|_| braced(others, numbers)).collect()),
    }
}

fn in_braces(values: Vec<String>) -> String {
    format!("{{ {} }}", values.join(", "))
}

/// Returns the layout of one struct.
fn shape_of(fields: Fields<'_>) -> Shape {
    Shape::Record(fields.record, fields.fields.to_vec())
}

/// Returns the dimensions of an array of numbers. A matrix is one array, column after column, as
/// libraries of linear algebra want it; a rotation has two dimensions.
fn dimensions(shape: &Shape) -> Vec<usize> {
    match shape {
        Shape::Scalar => Vec::new(),
        Shape::Array(_, _, Elements::Columns) | Shape::Record(..) => vec![shape.len()],
        Shape::Array(element, count, _) => [vec![*count], dimensions(element)].concat(),
    }
}

/// Returns what a struct is.
pub(super) fn docs_of_record(name: &str) -> Option<&'static str> {
    Some(match name {
        "pose" => "A pose: the rotation, and the translation, m.",
        "twist" => {
            "A velocity (m/s, rad/s), an acceleration or a displacement: its linear and its angular part."
        }
        "momentum" => "A momentum: its linear part, N s, and its angular part, N m s.",
        "wrench" => "A force, N, and a moment, N m.",
        "contact_target" => {
            "What a contact holds its link's frame to, and the properties of the contact."
        }
        "contact_surface" => "The plane that a shape touches, and the softness of the contact.",
        "constraint_settings" => "The settings of constraints, with the target of each contact.",
        "step_settings" => {
            "The settings of steps, with the surface of each shape that touches the ground."
        }
        _ => return None,
    })
}

/// Returns the numbers of rows and columns of a matrix, or of each matrix of an array.
fn size(shape: &Shape) -> Option<String> {
    match shape {
        Shape::Array(column, columns, Elements::Columns) => {
            Some(format!("{} x {columns}, by columns", column.len()))
        }
        Shape::Array(row, rows, Elements::Rows) => Some(format!("{rows} x {}, by rows", row.len())),
        Shape::Array(matrix, ..) => size(matrix),
        _ => None,
    }
}

/// Returns what a field is, with its units.
pub(super) fn docs_of_field(record: &str, field: &str) -> Option<&'static str> {
    Some(match (record, field) {
        ("contact_target", "pose") => "in the world; the ground is its xy plane, z the normal",
        ("contact_target", "velocity") => "of the ground, in world axes",
        ("contact_target", "tangential") => {
            "the factor of displacements in the plane: 0 for a plane, 1 for a frame"
        }
        ("contact_target" | "constraint_settings", "alpha") => "damping, 1/s",
        ("contact_target" | "constraint_settings", "beta") => "stiffness, 1/s",
        ("contact_target", "compliance") => "1/kg; 0 for a rigid contact",
        ("contact_target", "restitution") => "the speed after an impact divided by that before it",
        ("contact_target", "weight") => "in the distribution of the load by inverse dynamics",
        ("constraint_settings", "tolerance") => {
            "the squared angular error of the mechanism's axes, rad^2"
        }
        ("constraint_settings", "rounding") => "the part of a mobility that rounding may leave",
        ("contact_surface", "plane") => "in the world; z is the normal",
        ("contact_surface", "radius") => "of a sphere, a capsule or round edges, m",
        ("contact_surface", "friction") => "the coefficient of sliding friction",
        ("contact_surface", "torsional_friction" | "rolling_friction") => "m",
        ("contact_surface", "margin") => "the distance from which on the contact acts, m",
        ("contact_surface", "solref") => {
            "time constant, s, and damping ratio; or minus stiffness and damping"
        }
        ("contact_surface", "solimp") => {
            "impedance at the surface and at the width; width, m; midpoint"
        }
        (_, "q") => "coordinates: m, rad, quaternions",
        (_, "qd") => "velocities: m/s, rad/s",
        (_, "qdd") => "accelerations: m/s^2, rad/s^2",
        (_, "tau") => "joint forces: N, N m",
        (_, "act") => "activations",
        (_, "step_q") => "m, rad",
        (_, "step_qd") => "m/s, rad/s",
        (_, "wrenches") => "on the link of each constraint",
        (_, "impulses") => "on the link of each constraint, N s, N m s",
        (_, "residuals") => "the unmet acceleration of each constraint, m/s^2, rad/s^2",
        (_, "displacements") => "of each constraint, m, rad",
        (_, "velocities") => "of each constraint, m/s, rad/s",
        (_, "rate") => "the rate of the momentum, N, N m",
        (_, "forces") => {
            "at each point, along the x and y axes of its plane, then along the normal, N"
        }
        (_, "residual") => "relative to the largest force",
        (_, "iterations") => "their number",
        ("constraint_settings", "targets") => "in the order of the contacts",
        ("step_settings", "surfaces") => "in the order of the shapes that touch the ground",
        (_, "rank") => "the number of independent rows of the active constraints",
        ("step_settings", "tolerance") => "the residual at which the solver stops",
        ("step_settings", "impratio") => {
            "how many times stiffer friction is than the normal direction"
        }
        ("step_settings", "coulomb") => "the share of Coulomb's law in sliding, 0 to 1",
        _ => return None,
    })
}
