//! The header of the functions for C, valid in C99 and C++, without warnings under `-pedantic`.

use std::fmt::Write as _;

use super::Robot;
use super::c_functions::in_c;
use super::quantity::Quantity;
use crate::emit::c::CONVENTIONS;
use crate::emit::c_types::{CType, CTypes};
use crate::emit::coordinates_in_c;
use crate::emit::indices::{comment, in_header, indices};
use crate::plan::{Kernels, Shape};

impl Robot<'_> {
    /// Returns the header with `prefix_function` for each of the `quantities` that C can call.
    pub(super) fn c_header(&self, prefix: &str, quantities: &[Quantity<'_>]) -> String {
        let upper = prefix.to_uppercase();
        let (number, size) = match self.options.scalar {
            super::FloatType::F64 => ("double", 8),
            super::FloatType::F32 => ("float", 4),
        };
        let quantities: Vec<&Quantity<'_>> = quantities.iter().filter(|q| in_c(q)).collect();
        let of_links = quantities.iter().any(|q| matches!(q.kernels, Kernels::ByLink(_)));
        let mut text = format!(
            "/* Functions of the robot {}, compiled by modyn.\n   {CONVENTIONS} */\n\n\
             #ifndef {upper}_H\n#define {upper}_H\n\n",
            comment(self.model.name()),
        );
        if of_links {
            text += "#include <stdbool.h>\n#include <stddef.h>\n\n";
        }
        let _ = writeln!(
            text,
            "/* {} */\n#define {upper}_NQ {}\n\
             /* The length of the velocity vector. */\n#define {upper}_NV {}\n\
             /* The number of links. */\n#define {upper}_LINKS {}\n\n\
             /* An array of at least n numbers, or a pointer to its first one. Compilers warn of shorter arrays. */\n\
             #if defined(__STDC_VERSION__) && !defined(_MSC_VER)\n\
             #define {upper}_AT_LEAST(n) static n\n#else\n#define {upper}_AT_LEAST(n)\n#endif\n\n\
             /* Numbers are of {} bits. */\n\
             typedef char {prefix}_has_numbers_of_{}_bits[sizeof({number}) == {size} ? 1 : -1];\n",
            coordinates_in_c(self.model),
            self.model.nq(),
            self.model.nv(),
            self.model.links().len(),
            8 * size,
            8 * size,
        );
        text.push('\n');
        text += &indices(self.model, prefix);
        text += "#ifdef __cplusplus\nextern \"C\" {\n#endif\n";
        let mut types = CTypes::new(prefix, number);
        for quantity in quantities {
            declaration(&mut text, quantity, &mut types, prefix);
        }
        text += "\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n";
        text
    }
}

/// Prints the declaration of a function.
fn declaration(text: &mut String, quantity: &Quantity<'_>, types: &mut CTypes, prefix: &str) {
    let function = quantity.name;
    let by_link = matches!(quantity.kernels, Kernels::ByLink(_));
    let upper = prefix.to_uppercase();
    let number = types.number();
    let shapes = quantity.arguments.iter().map(|(_, shape)| shape).chain([quantity.result]);
    let definitions: String = shapes.map(|shape| types.definitions(shape)).collect();
    if !definitions.is_empty() {
        let _ = write!(text, "\n{}", definitions.trim_end_matches('\n'));
        text.push('\n');
    }
    let parameter = |name: &str, shape: &Shape| {
        types.parameter(name, shape, |n| format!("{upper}_AT_LEAST({n})"))
    };
    let nonempty = quantity.arguments.iter().filter(|(_, shape)| !shape.is_empty());
    let mut parameters: Vec<String> = nonempty
        .map(|(argument, shape)| format!("const {}", parameter(argument.name, shape)))
        .collect();
    if by_link {
        parameters.push("size_t link".into());
    }
    let returned = match (quantity.result, by_link) {
        (Shape::Scalar, _) => number,
        (_, true) => "bool",
        (_, false) => "void",
    };
    let own_docs = in_header(quantity.docs, prefix);
    let mut docs: Vec<String> = own_docs.lines().map(str::to_owned).collect();
    if by_link {
        docs.push(format!(
            "`link` is one of `enum {prefix}_link`; returns false, and writes nothing, if there is no such link."
        ));
    }
    if returned != number {
        parameters.push(parameter("out", quantity.result));
        if !CType::new(quantity.result).is_struct() {
            docs.push(format!("The layout of `out`: {}.", quantity.result.in_words()));
        }
    }
    let _ = writeln!(
        text,
        "\n/* {} */\n{returned} {prefix}_{function}({});",
        docs.join("\n * "),
        parameters.join(", ")
    );
}
