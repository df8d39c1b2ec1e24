//! The functions of a robot whose code is in an object file: calls of the object's functions, in
//! place of programs.
//!
//! The generated text has unsafe code: the calls. Each passes pointers to as many numbers as the
//! object's function reads or writes, on a processor that has the instructions.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::shape::Shape;
use super::{Quantity, Robot};
use crate::emit::MachineCode;
use crate::plan::Kernels;

/// The module of the object's functions in the text.
const OBJECT: &str = "__object";

impl Robot<'_> {
    /// Prints the private functions, which call the object's, and the check of the processor.
    pub(super) fn machine_functions(
        &self,
        text: &mut String,
        quantities: &[Quantity<'_>],
        code: &MachineCode,
    ) {
        let _ = writeln!(
            text,
            "#[cfg(not({}))]\n\
             ::core::compile_error!({:?});\n",
            code.target.cfg,
            format!("the machine code of `{}` was made for {}", self.name, code.target.words),
        );
        self.declarations(text, quantities, code);
        self.check_of_the_processor(text, code);
        for quantity in quantities {
            self.machine_function(text, quantity);
        }
    }

    /// Prints the declarations of the object's functions.
    fn declarations(&self, text: &mut String, quantities: &[Quantity<'_>], code: &MachineCode) {
        let float = self.options.scalar.name();
        let prefix = &code.prefix;
        let declarations = quantities.iter().map(|quantity| {
            let all = quantity.all_parameters();
            let parameters = all.iter().filter(|p| !p.shape.is_empty());
            let pointers = parameters.map(|p| format!("{}: *const {float}, ", p.name));
            let by_link = quantity.is_by_link();
            let link = if by_link { "link: ::core::ffi::c_uint, " } else { "" };
            let returned = if by_link { " -> ::core::ffi::c_int" } else { "" };
            let with = if quantity.runtime > 0 { "_with" } else { "" };
            format!(
                "#[link_name = \"{prefix}_{name}{with}\"]\n\
                 pub(super) fn {name}({}{link}out: *mut {float}){returned};\n",
                pointers.collect::<String>(),
                name = quantity.name,
            )
        });
        let _ = writeln!(
            text,
            "mod {OBJECT} {{\n\
             #[allow(unsafe_code)]\n\
             unsafe extern \"C\" {{\n\
             {}#[link_name = \"{prefix}_is_supported\"]\n\
             pub(super) safe fn __is_supported() -> ::core::ffi::c_int;\n}}\n}}\n",
            declarations.collect::<String>()
        );
    }

    /// Prints the function that every call of the object begins with.
    fn check_of_the_processor(&self, text: &mut String, code: &MachineCode) {
        let name = self.name;
        let needs =
            if code.needs.is_empty() { "those of every x86-64 processor" } else { code.needs };
        let _ = writeln!(
            text,
            "impl {name} {{\n\
             /// Returns whether this processor has the instructions of the machine code: {needs}. \
             All other functions that\n\
             /// compute panic without them.\n\
             #[must_use]\n\
             pub fn is_supported() -> bool {{\n    {OBJECT}::__is_supported() != 0\n}}\n}}\n"
        );
        if code.needs.is_empty() {
            text.push_str("#[inline(always)]\nfn __check_processor() {}\n\n");
            return;
        }
        let features: Vec<String> =
            code.features.iter().map(|feature| format!("target_feature = {feature:?}")).collect();
        let message = format!(
            "the machine code of `{name}` needs a processor with {}; compile the robot for a smaller instruction set",
            code.needs
        );
        let _ = writeln!(
            text,
            "/// Panics without the instructions; the first call asks the processor.\n\
             #[inline(always)]\n\
             fn __check_processor() {{\n\
             #[cfg(not(all({})))]\n\
             {{\n\
             use ::core::sync::atomic::{{AtomicBool, Ordering}};\n\
             static CHECKED: AtomicBool = AtomicBool::new(false);\n\
             #[cold]\n\
             #[inline(never)]\n\
             fn ask() {{\n\
             ::core::assert!({name}::is_supported(), {message:?});\n\
             CHECKED.store(true, Ordering::Relaxed);\n\
             }}\n\
             if !CHECKED.load(Ordering::Relaxed) {{\n\
             ask();\n\
             }}\n\
             }}\n\
             }}\n",
            features.join(", ")
        );
    }

    /// Prints a private function.
    fn machine_function(&self, text: &mut String, quantity: &Quantity<'_>) {
        let name = quantity.name;
        let float = self.options.scalar.name();
        let mut flat = String::new();
        let mut pointers = String::new();
        let parameters = quantity.all_parameters();
        for parameter in parameters.iter().filter(|p| !p.shape.is_empty()) {
            let argument = parameter.name;
            let len = parameter.shape.len();
            if parameter.shape.is_structured() {
                let mut writes = String::new();
                write_numbers(&mut writes, &parameter.shape, argument, "0", 0);
                let _ = write!(
                    flat,
                    "let mut {argument}_numbers: [{float}; {len}] = [0.0; {len}];\n\
                     {{\nlet to = &mut {argument}_numbers;\n{writes}}}\n"
                );
                let _ = write!(pointers, "{argument}_numbers.as_ptr(), ");
            } else {
                let _ = write!(pointers, "::core::ptr::from_ref({argument}).cast::<{float}>(), ");
            }
        }
        let mut typed: Vec<String> = parameters.iter().map(|p| p.typed(float)).collect();
        if quantity.is_by_link() {
            typed.push(format!("link: {}Link", self.name));
            pointers += "link as ::core::ffi::c_uint, ";
        }
        let returned = quantity.shape.type_of(float);
        let len = quantity.shape.len();
        let layouts = layouts(&quantity.shape, float);
        let _ = writeln!(
            text,
            "#[inline]\nfn {name}({}) -> {returned} {{\n{flat}__check_processor();",
            typed.join(", ")
        );
        let call = |out: &str| format!("let _ = {OBJECT}::{name}({pointers}{out});");
        let direct = format!(
            "let mut result = ::core::mem::MaybeUninit::<{returned}>::uninit();\n\
             // SAFETY: the object's function reads and writes as many numbers as the types have, \
             and writes all of the\n\
             // result. The processor has its instructions.\n\
             #[allow(unsafe_code)]\n\
             unsafe {{\n{}\nresult.assume_init()\n}}\n",
            call("result.as_mut_ptr().cast()")
        );
        if layouts.is_empty() {
            text.push_str(&direct);
        } else {
            // Rust may order the fields of a type in its own way; it does so rarely.
            let _ = write!(
                text,
                "const IN_ORDER: bool = {layouts};\n\
                 if IN_ORDER {{\n{direct}}} else {{\n\
                 let mut from: [{float}; {len}] = [0.0; {len}];\n\
                 // SAFETY: as above.\n\
                 #[allow(unsafe_code)]\n\
                 unsafe {{\n{}\n}}\n{}\n}}\n",
                call("from.as_mut_ptr()"),
                read_numbers(&quantity.shape, "0", 0),
            );
        }
        text.push_str("}\n\n");
    }
}

impl Quantity<'_> {
    fn is_by_link(&self) -> bool {
        matches!(self.kernels, Kernels::ByLink(_))
    }
}

impl Shape {
    /// Returns whether the layout has types other than arrays.
    fn is_structured(&self) -> bool {
        match self {
            Self::Scalar => false,
            Self::Array(element, _) => element.is_structured(),
            Self::Struct { .. } => true,
        }
    }
}

/// Prints the statements that write the numbers of `value` into the slice `to`, from index `at` on.
fn write_numbers(text: &mut String, shape: &Shape, value: &str, at: &str, depth: usize) {
    let _ = match shape {
        Shape::Scalar => writeln!(text, "to[{at}] = {value};"),
        Shape::Array(element, n) if matches!(**element, Shape::Scalar) => {
            writeln!(text, "to[{at}..][..{n}].copy_from_slice(&{value}[..]);")
        }
        Shape::Array(element, _) => {
            let i = format!("i{depth}");
            let x = format!("x{depth}");
            let _ = writeln!(text, "for ({i}, {x}) in {value}.iter().enumerate() {{");
            let inner = format!("{at} + {} * {i}", element.len());
            let value = if matches!(**element, Shape::Scalar) { format!("*{x}") } else { x };
            write_numbers(text, element, &value, &inner, depth + 1);
            writeln!(text, "}}")
        }
        Shape::Struct { fields, .. } => {
            let mut offset = 0;
            for (k, (name, field)) in fields.iter().enumerate() {
                let value = format!("{value}.{}", member(name, k));
                write_numbers(text, field, &value, &format!("{at} + {offset}"), depth);
                offset += field.len();
            }
            Ok(())
        }
    };
}

/// Returns the expression of a value whose numbers are in the array `from`, from index `at` on.
fn read_numbers(shape: &Shape, at: &str, depth: usize) -> String {
    match shape {
        Shape::Scalar => format!("from[{at}]"),
        Shape::Array(element, _) => {
            let inner =
                read_numbers(element, &format!("{at} + {} * i{depth}", element.len()), depth + 1);
            format!("::core::array::from_fn(|i{depth}| {inner})")
        }
        Shape::Struct { path, fields, .. } => {
            let mut offset = 0;
            let fields = fields.iter().enumerate().map(|(k, (name, field))| {
                let value = read_numbers(field, &format!("{at} + {offset}"), depth);
                offset += field.len();
                format!("{}: {value}", member(name, k))
            });
            format!("{path} {{ {} }}", fields.collect::<Vec<_>>().join(", "))
        }
    }
}

/// Returns the condition under which the fields of all types of a layout are in its order; empty if
/// it has arrays only.
fn layouts(shape: &Shape, float: &str) -> String {
    let mut conditions = BTreeSet::new();
    collect_layouts(shape, float, &mut conditions);
    conditions.into_iter().collect::<Vec<_>>().join("\n    && ")
}

fn collect_layouts(shape: &Shape, float: &str, conditions: &mut BTreeSet<String>) {
    match shape {
        Shape::Scalar => {}
        Shape::Array(element, _) => collect_layouts(element, float, conditions),
        Shape::Struct { fields, .. } => {
            let kind = shape.type_of(float);
            let number = format!("::core::mem::size_of::<{float}>()");
            let len = shape.len();
            conditions.insert(format!("::core::mem::size_of::<{kind}>() == {len} * {number}"));
            let mut offset = 0;
            for (k, (name, field)) in fields.iter().enumerate() {
                conditions.insert(format!(
                    "::core::mem::offset_of!({kind}, {}) == {offset} * {number}",
                    member(name, k)
                ));
                offset += field.len();
                collect_layouts(field, float, conditions);
            }
        }
    }
}

/// Returns the name of a field; fields of tuples are numbered.
fn member(name: &str, number: usize) -> String {
    if name.is_empty() { number.to_string() } else { name.into() }
}
