//! C++17 with Eigen: a header with a class over the functions of C, and the two files of these.
//!
//! Arguments and results are matrices and vectors of fixed sizes. The results are written where they
//! are: types of the class have the layout of the numbers in C, and are not aligned to vectors.

use std::fmt::Write as _;

use super::{C, Item, Parameter, Programs, items};
use crate::emit::c_types::{CType, Fields, docs_of_field, docs_of_record};
use crate::emit::indices::{all_names, with_enumerations};
use crate::emit::{Backend, EmitOptions, File, PlannedRobot};
use crate::plan::{ArgumentKind, Elements, Shape};
use crate::program::Execution;

/// The back end.
pub(in crate::emit) struct Cpp;

impl Backend for Cpp {
    fn execution(&self, options: &EmitOptions) -> Execution {
        C.execution(options)
    }

    fn print(&self, robot: &PlannedRobot<'_>) -> Vec<File> {
        let class = Class::new(robot);
        let mut files = vec![File::new(format!("{}.hpp", robot.stem), class.print(robot))];
        files.extend(C.print(robot));
        files
    }

    fn with_origin(&self, text: &str, origin: &str) -> String {
        C.with_origin(text, origin)
    }
}

/// The keywords and words of C++ that names in snake case may be, without those of Rust.
const WORDS: [&str; 63] = [
    "alignas",
    "alignof",
    "and",
    "and_eq",
    "asm",
    "auto",
    "bitand",
    "bitor",
    "bool",
    "case",
    "catch",
    "char",
    "class",
    "compl",
    "concept",
    "consteval",
    "constexpr",
    "constinit",
    "decltype",
    "default",
    "delete",
    "double",
    "explicit",
    "export",
    "float",
    "friend",
    "goto",
    "inline",
    "int",
    "linux",
    "long",
    "mutable",
    "namespace",
    "new",
    "noexcept",
    "not",
    "not_eq",
    "nullptr",
    "operator",
    "or",
    "or_eq",
    "private",
    "protected",
    "public",
    "register",
    "requires",
    "short",
    "signed",
    "sizeof",
    "switch",
    "template",
    "this",
    "throw",
    "typedef",
    "typeid",
    "typename",
    "union",
    "unix",
    "unsigned",
    "using",
    "void",
    "volatile",
    "xor",
];

/// Prints the class of a robot.
struct Class {
    name: String,
    /// The prefix of names in C.
    prefix: String,
    /// The records that the class has as structs.
    defined: Vec<&'static str>,
    text: String,
}

/// An argument: its declaration, and what C receives.
struct Passed {
    declared: String,
    passed: String,
}

impl Class {
    fn new(robot: &PlannedRobot<'_>) -> Self {
        let name = robot.options.type_name(robot.model);
        Self { name, prefix: robot.prefix(), defined: Vec::new(), text: String::new() }
    }

    /// Returns the header.
    fn print(mut self, robot: &PlannedRobot<'_>) -> String {
        let items = items(robot.plan, &self.prefix);
        self.enumerations(robot);
        for item in &items {
            self.function(item);
        }
        self.default_settings();
        let Self { name, prefix, text, .. } = &self;
        let guard = format!("{}_HPP", prefix.to_uppercase());
        let upper = prefix.to_uppercase();
        let scalar = robot.options.scalar.in_c();
        format!(
            "/* Dynamics of a robot, compiled by modyn: C++17 over {stem}.h, with Eigen 3.3 or later. */\n\
             #ifndef {guard}\n#define {guard}\n\n\
             #include <array>\n#include <cstddef>\n\n#include <Eigen/Core>\n\n#include \"{stem}.h\"\n\n\
             /// The dynamics of the robot. SI units, radians; gravity {gravity:?} m/s^2 in world axes.\n\
             ///\n\
             /// Vectors are in the order of the description's joints, depth first. Quaternions are x, y, z, w. Twists and the\n\
             /// columns of Jacobians are angular, then linear; wrenches are the moment, then the force. The velocity of a floating\n\
             /// joint is linear, then angular, in the axes of its link. No function allocates memory or throws.\n\
             class {name} {{\npublic:\n    \
             using Scalar = {scalar};\n    \
             /// The number of coordinates.\n    static constexpr int nq = {upper}_NQ;\n    \
             /// The number of velocities: the degrees of freedom.\n    static constexpr int nv = {upper}_NV;\n    \
             /// The number of links.\n    static constexpr int links = {upper}_LINKS;\n\n    \
             template <int Rows, int Columns>\n    \
             using Matrix = Eigen::Matrix<Scalar, Rows, Columns, Eigen::DontAlign | (Rows == 1 && Columns != 1 ? Eigen::RowMajor : Eigen::ColMajor)>;\n    \
             template <int Size>\n    using Vector = Matrix<Size, 1>;\n    \
             using Rotation = Eigen::Matrix<Scalar, 3, 3, Eigen::DontAlign | Eigen::RowMajor>;\n    \
             /// An argument: a vector, a map, a segment or an expression of this size.\n    \
             template <int Size>\n    using VectorRef = Eigen::Ref<const Vector<Size>>;\n    \
             template <int Rows, int Columns>\n    \
             using MatrixRef = Eigen::Ref<const Matrix<Rows, Columns>, 0, Eigen::Stride<0, 0>>;\n\n\
             {text}\
             private:\n    template <std::size_t Size>\n    \
             static Vector<static_cast<int>(Size)> numbers(const std::array<bool, Size> &set) noexcept {{\n        \
             Vector<static_cast<int>(Size)> result;\n        \
             for (std::size_t i = 0; i < Size; ++i) result[static_cast<int>(i)] = set[i] ? Scalar(1) : Scalar(0);\n        \
             return result;\n    }}\n}};\n\n#endif\n",
            stem = robot.stem,
            gravity = robot.model.gravity(),
        )
    }

    /// Prints the enumerations. Those of entries of arrays are numbers.
    fn enumerations(&mut self, robot: &PlannedRobot<'_>) {
        for named in all_names(robot.model) {
            let upper = format!("{}_{}", self.prefix, named.kind).to_uppercase();
            let of_c = named.identifiers(&[]);
            let rows = named.identifiers(&WORDS).into_iter().zip(of_c);
            let rows: Vec<String> = rows
                .map(|(name, of_c)| format!("{name} = {upper}_{}", of_c.to_uppercase()))
                .collect();
            let rows = rows.join(",\n        ");
            let kind = capitalized(named.kind);
            let (head, end) = match named.kind {
                "link" => (format!("enum class {kind} : unsigned {{"), "};"),
                _ => (format!("struct {kind} {{ enum : int {{"), "}; };"),
            };
            let _ = writeln!(
                self.text,
                "    /// {}.\n    {head}\n        {rows}\n    {end}\n",
                named.docs
            );
        }
    }

    /// Prints the functions of an item.
    fn function(&mut self, item: &Item<'_>) {
        let shapes = item.parameters.iter().map(|parameter| &parameter.shape);
        for shape in shapes.chain([item.result]) {
            self.define(shape);
        }
        let by_link = matches!(item.programs, Programs::ByLink(_));
        let docs = with_enumerations(item.docs, capitalized).replace('\n', "\n    /// ");
        let result = self.type_of(item.result);
        let out = match (CType::new(item.result), item.result) {
            (CType::Struct(fields), _) => self.in_c("", fields, "&out"),
            (CType::Structs(fields, _), _) => self.in_c("", fields, "out.data()"),
            (_, Shape::Scalar) => "&out".into(),
            _ if result.starts_with("std::array") => "out[0].data()".into(),
            _ => "out.data()".into(),
        };
        let method = item.name.strip_prefix(&format!("{}_", self.prefix)).unwrap_or(&item.name);
        let all = item.parameters.len();
        let described = all - usize::from(item.with_parameters);
        let with = item.with_parameters.then_some((all, "_with"));
        for (count, with) in [(described, "")].into_iter().chain(with) {
            let parameters = item.parameters[..count].iter().map(|p| self.passed(p));
            let link = by_link.then(|| Passed {
                declared: "Link link".into(),
                passed: "static_cast<unsigned>(link)".into(),
            });
            let arguments: Vec<Passed> = parameters.chain(link).collect();
            let declared: Vec<&str> = arguments.iter().map(|a| &*a.declared).collect();
            let passed: String = arguments.iter().map(|a| format!("{}, ", a.passed)).collect();
            let name = &item.name;
            let _ = writeln!(
                self.text,
                "    /// {docs}\n    static {result} {method}({}) noexcept {{\n        {result} out;\n        \
                 {name}{with}({passed}{out});\n        return out;\n    }}\n",
                declared.join(", ")
            );
        }
    }

    /// Prints the settings by default.
    fn default_settings(&mut self) {
        for (record, name) in [("StepSettings", "step"), ("ConstraintSettings", "constraint")] {
            if !self.defined.contains(&record) {
                continue;
            }
            let prefix = &self.prefix;
            let _ = writeln!(
                self.text,
                "    /// Returns the settings by default, for the ground of the description.\n    \
                 static {record} default_{name}_settings() noexcept {{\n        \
                 return reinterpret_cast<const {record} &>({prefix}_default_{name}_settings);\n    }}\n"
            );
        }
    }

    /// Defines the structs of a layout.
    fn define(&mut self, shape: &Shape) {
        let (CType::Struct(fields) | CType::Structs(fields, _)) = CType::new(shape) else { return };
        let name = fields.type_name();
        if self.defined.contains(&name) {
            return;
        }
        for (_, field) in fields.nonempty() {
            self.define(field);
        }
        let record = fields.name();
        let docs = match &*record {
            "pose" => Some("A pose: the rotation, and the translation, m."),
            record => docs_of_record(record),
        };
        if let Some(docs) = docs {
            let _ = writeln!(self.text, "    /// {docs}");
        }
        let _ = writeln!(self.text, "    struct {name} {{");
        for (field, shape) in fields.nonempty() {
            let docs = docs_of_field(&record, field);
            let docs = docs.map_or(String::new(), |docs| format!(" // {docs}"));
            let _ = writeln!(self.text, "        {} {field};{docs}", self.type_of(shape));
        }
        let of_c = format!("{}_{record}_t", self.prefix);
        let _ = writeln!(
            self.text,
            "    }};\n    static_assert(sizeof({name}) == sizeof({of_c}), \"the layout of C\");\n"
        );
        self.defined.push(name);
    }

    /// Returns a pointer to structs of the class as one to those of C.
    fn in_c(&self, qualifier: &str, fields: Fields<'_>, pointer: &str) -> String {
        let prefix = &self.prefix;
        format!("reinterpret_cast<{qualifier}{prefix}_{}_t *>({pointer})", fields.name())
    }

    /// Returns the type of a layout.
    fn type_of(&self, shape: &Shape) -> String {
        match (CType::new(shape), shape) {
            (CType::Struct(fields), _) => fields.type_name().into(),
            (CType::Structs(fields, count), _) => {
                format!("std::array<{}, {count}>", fields.type_name())
            }
            (_, Shape::Scalar) => "Scalar".into(),
            (_, Shape::Record(..)) => format!("Vector<{}>", shape.len()),
            (_, Shape::Array(element, count, elements)) => match (&**element, elements) {
                (Shape::Scalar, _) => format!("Vector<{count}>"),
                (_, Elements::Rows) => "Rotation".into(),
                (_, Elements::Columns) => format!("Matrix<{}, {count}>", element.len()),
                (Shape::Record(..), Elements::List) => {
                    format!("Matrix<{}, {count}>", element.len())
                }
                (_, Elements::List) => format!("std::array<{}, {count}>", self.type_of(element)),
            },
        }
    }

    fn passed(&self, parameter: &Parameter) -> Passed {
        let Parameter { array, shape, kind } = parameter;
        let name = &array.name;
        let own = self.type_of(shape);
        match (CType::new(shape), shape) {
            _ if *kind == Some(ArgumentKind::Contacts) => Passed {
                declared: format!("const std::array<bool, {}> &{name}", shape.len()),
                passed: format!("numbers({name}).data()"),
            },
            (CType::Struct(fields), _) => Passed {
                declared: format!("const {own} &{name}"),
                passed: self.in_c("const ", fields, &format!("&{name}")),
            },
            (CType::Structs(fields, _), _) => Passed {
                declared: format!("const {own} &{name}"),
                passed: self.in_c("const ", fields, &format!("{name}.data()")),
            },
            (_, Shape::Scalar) => {
                Passed { declared: format!("Scalar {name}"), passed: format!("&{name}") }
            }
            _ => Passed {
                declared: format!("const {} &{name}", own.replacen('<', "Ref<", 1)),
                passed: format!("{name}.data()"),
            },
        }
    }
}

fn capitalized(word: &str) -> String {
    let (first, others) = word.split_at(1);
    first.to_uppercase() + others
}
