//! C++17 with Eigen: a header with a class over the functions of C, and the two files of C.
//!
//! Arguments and results are matrices and vectors of fixed sizes. The results are written where they
//! are: types of the class have the layout of the numbers in C, and are not aligned to vectors.

use std::fmt::Write as _;

use super::rollout::RolloutArguments;
use super::{Array, C, Item, Parameter, Programs, items};
use crate::emit::c_types::{CType, Fields, docs_of_field, docs_of_record};
use crate::emit::indices::{all_names, with_enumerations};
use crate::emit::{Backend, EmitOptions, File, PlannedRobot};
use crate::names::CPP_WORDS;
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

/// The members of each class, and the library: no class has their names.
const MEMBERS: [&str; 17] = [
    "Activation",
    "Columns",
    "Contact",
    "Control",
    "Eigen",
    "Link",
    "Loop",
    "Matrix",
    "MatrixRef",
    "Q",
    "Rotation",
    "RowMatrix",
    "Scalar",
    "Shape",
    "V",
    "Vector",
    "VectorRef",
];

/// Prints the class of a robot.
struct Class {
    name: String,
    /// The prefix of names in C.
    prefix: String,
    /// The records that the class has as structs.
    defined: Vec<String>,
    text: String,
}

/// The declaration of an argument, and the text that passes the argument to C.
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
            if let Some(name) = &item.rollout {
                self.rollout(name, item);
            }
        }
        self.default_settings();
        if MEMBERS.contains(&&*self.name) || self.defined.contains(&self.name) {
            self.name += "Robot";
        }
        let gravity = format!("{:?}", robot.model.gravity());
        let words = [
            ("STEM", robot.stem),
            ("UPPER", &self.prefix.to_uppercase()),
            ("GRAVITY", &gravity),
            ("CLASS", &self.name),
            ("REAL", robot.options.scalar.in_c()),
            ("MEMBERS", &self.text),
        ];
        let head = include_str!("class.hpp").to_owned();
        words.iter().fold(head, |text, (word, value)| text.replace(&format!("@{word}@"), value))
    }

    /// Prints the enumerations. The entries of arrays are numbers.
    fn enumerations(&mut self, robot: &PlannedRobot<'_>) {
        for named in all_names(robot.model) {
            let upper = format!("{}_{}", self.prefix, named.kind).to_uppercase();
            let of_c = named.identifiers(&[]);
            let names = named.identifiers(CPP_WORDS).into_iter().zip(of_c);
            let rows: Vec<String> = names
                .map(|(name, of_c)| format!("        {name} = {upper}_{}", of_c.to_uppercase()))
                .collect();
            let kind = capitalized(named.kind);
            let (head, end) = match named.kind {
                "link" => (format!("enum class {kind} : unsigned {{"), "};"),
                _ => (format!("struct {kind} {{ enum : int {{"), "}; };"),
            };
            let _ = writeln!(
                self.text,
                "    /// {}.\n    {head}\n{}\n    {end}\n",
                named.docs,
                rows.join(",\n")
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
        let called = item.name.strip_prefix(&format!("{}_", self.prefix)).unwrap_or(&item.name);
        let is_taken =
            CPP_WORDS.contains(&called) || ["nq", "nv", "links", "numbers"].contains(&called);
        let method = format!("{called}{}", if is_taken { "_" } else { "" });
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
            let head = format!("static {result} {method}({})", declared.join(", "));
            let call = format!("{}{with}({passed}{out});", item.name);
            let _ = writeln!(
                self.text,
                "    /// {docs}\n    {head} noexcept {{\n        {result} out;\n        {call}\n        \
                 return out;\n    }}\n"
            );
        }
    }

    /// Prints the function `name`, which moves a state by the steps of an item.
    fn rollout(&mut self, name: &str, step: &Item<'_>) {
        let RolloutArguments { planned, numbers, shared, moved } = RolloutArguments::new(step);
        let mut declared = format!("const Columns<{}> &controls", planned.array.len);
        let mut passed = String::from("static_cast<unsigned>(controls.cols()), controls.data()");
        for argument in shared.into_iter().map(|parameter| self.passed(parameter)) {
            let _ = write!(declared, ", {}", argument.declared);
            let _ = write!(passed, ", {}", argument.passed);
        }
        for parameter in moved {
            let Array { name, len } = &parameter.array;
            let _ = write!(declared, ", Eigen::Ref<Vector<{len}>> {name}");
            let _ = write!(passed, ", {name}.data()");
        }
        let prefix = format!("{}_", self.prefix);
        let without_prefix = |name: &str| name.strip_prefix(&prefix).unwrap_or(name).to_owned();
        let _ = writeln!(
            self.text,
            "    /// Moves the state `q`, `qd` by a step of `{}` for each column of `controls`, its {numbers}.\n    \
             /// `trajectory` has room for q and qd after each step, nq + nv numbers, or is null.\n    \
             static void {}({declared}, Scalar *trajectory = nullptr) noexcept {{\n        \
             {name}({passed}, trajectory);\n    }}\n",
            without_prefix(&step.name),
            without_prefix(name),
        );
    }

    /// Prints the settings by default.
    fn default_settings(&mut self) {
        for (record, name) in [("StepSettings", "step"), ("ConstraintSettings", "constraint")] {
            if !self.defined.iter().any(|defined| defined == record) {
                continue;
            }
            let prefix = &self.prefix;
            let _ = writeln!(
                self.text,
                "    /// Returns the settings by default, for the ground of the description.\n    \
                 static {record} default_{name}_settings() noexcept {{\n        \
                 {record} settings;\n        \
                 const auto &constants = {prefix}_default_{name}_settings;\n        \
                 std::memcpy(static_cast<void *>(&settings), &constants, sizeof settings);\n        \
                 return settings;\n    }}\n"
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
        if let Some(docs) = docs_of_record(&record) {
            let _ = writeln!(self.text, "    /// {docs}");
        }
        let _ = writeln!(self.text, "    struct {name} {{");
        for (field, shape) in fields.nonempty() {
            let docs =
                docs_of_field(&record, field).map_or(String::new(), |docs| format!(" // {docs}"));
            let _ = writeln!(self.text, "        {} {field};{docs}", self.type_of(shape));
        }
        let of_c = format!("{}_{record}_t", self.prefix);
        let _ = writeln!(
            self.text,
            "    }};\n    static_assert(sizeof({name}) == sizeof({of_c}), \"the layout of C\");\n"
        );
        self.defined.push(name);
    }

    /// Returns a pointer to structs of the class as a pointer to structs of C.
    fn in_c(&self, qualifier: &str, fields: Fields<'_>, pointer: &str) -> String {
        let prefix = &self.prefix;
        format!("reinterpret_cast<{qualifier}{prefix}_{}_t *>({pointer})", fields.name())
    }

    /// Returns the type of a layout.
    fn type_of(&self, shape: &Shape) -> String {
        match (CType::new(shape), shape) {
            (CType::Struct(fields), _) => fields.type_name(),
            (CType::Structs(fields, count), _) => {
                format!("std::array<{}, {count}>", fields.type_name())
            }
            (_, Shape::Scalar) => "Scalar".into(),
            (_, Shape::Record(..)) => format!("Vector<{}>", shape.len()),
            (_, Shape::Array(element, count, elements)) => match (&**element, elements) {
                (Shape::Scalar, _) => format!("Vector<{count}>"),
                (row, Elements::Rows) if (row.len(), *count) == (3, 3) => "Rotation".into(),
                (row, Elements::Rows) => format!("RowMatrix<{count}, {}>", row.len()),
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
        let class_type = self.type_of(shape);
        match (CType::new(shape), shape) {
            _ if *kind == Some(ArgumentKind::ActiveContacts) => Passed {
                declared: format!("const std::array<bool, {}> &{name}", shape.len()),
                passed: format!("numbers({name}).data()"),
            },
            (CType::Struct(fields), _) => Passed {
                declared: format!("const {class_type} &{name}"),
                passed: self.in_c("const ", fields, &format!("&{name}")),
            },
            (CType::Structs(fields, _), _) => Passed {
                declared: format!("const {class_type} &{name}"),
                passed: self.in_c("const ", fields, &format!("{name}.data()")),
            },
            (_, Shape::Scalar) => {
                Passed { declared: format!("Scalar {name}"), passed: format!("&{name}") }
            }
            _ => Passed {
                declared: format!("const {} &{name}", class_type.replacen('<', "Ref<", 1)),
                passed: format!("{name}.data()"),
            },
        }
    }
}

fn capitalized(word: &str) -> String {
    let (first, others) = word.split_at(1);
    first.to_uppercase() + others
}
