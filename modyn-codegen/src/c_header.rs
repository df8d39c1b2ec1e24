//! The header of exported C functions, from the text that has them: the emitter writes a constant and a signature on
//! one line each, and no other parameter types than those here.

use std::fmt::Write as _;

use crate::FloatType;

/// The C header of a generated text with [`c_functions`](crate::Builder::c_functions) of that prefix: lengths as macros,
/// functions with their documentation, and assertions on the size of the C compiler's numbers. For C11 and C++11.
#[must_use]
pub fn c_header(text: &str, prefix: &str, float: FloatType) -> String {
    let upper = prefix.to_uppercase();
    let (constant, function) =
        (format!("pub const {upper}_"), format!("pub extern \"C\" fn {prefix}_"));
    let (mut constants, mut functions) = (String::new(), String::new());
    let mut docs: Vec<&str> = Vec::new();
    for line in text.lines().map(str::trim_start) {
        if let Some(doc) = line.strip_prefix("///") {
            docs.push(doc);
            continue;
        }
        if line.starts_with("#[") {
            continue;
        }
        if line.starts_with(&constant) {
            if let Some(define) = define(line) {
                let _ = write!(constants, "{}{define}\n\n", comment(&docs));
            }
        } else if line.starts_with(&function)
            && let Some(prototype) = prototype(line)
        {
            let _ = write!(functions, "{}{prototype}\n\n", comment(&docs));
        }
        docs.clear();
    }
    let (c, size) = match float {
        FloatType::F64 => ("double", 8),
        FloatType::F32 => ("float", 4),
    };
    format!(
        "#ifndef {upper}_H\n#define {upper}_H\n\n#include <stdbool.h>\n#include <stddef.h>\n\n{constants}\
         #ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n{functions}\
         #ifdef __cplusplus\n}}\n#define {upper}_ASSERT static_assert\n#else\n\
         #define {upper}_ASSERT _Static_assert\n#endif\n\
         {upper}_ASSERT(sizeof({c}) == {size}, \"{c}\");\n\
         {upper}_ASSERT(sizeof({c}[{upper}_NV]) == {size} * {upper}_NV, \"arrays without gaps\");\n\n\
         #endif /* {upper}_H */\n"
    )
}

/// The comment of an item's documentation.
fn comment(docs: &[&str]) -> String {
    if docs.is_empty() {
        return String::new();
    }
    // The documentation shows names of the description, which must not end the comment.
    let lines: String =
        docs.iter().map(|doc| format!(" *{}\n", doc.replace("*/", "* /"))).collect();
    format!("/**\n{lines} */\n")
}

/// `#define NAME 7` of `pub const NAME: usize = 7;`
fn define(line: &str) -> Option<String> {
    let (name, value) = line.strip_prefix("pub const ")?.split_once(": usize = ")?;
    Some(format!("#define {name} {}", value.strip_suffix(';')?))
}

/// The prototype of `pub extern "C" fn name(parameters) -> type {`, its parameters in lines where it is long.
fn prototype(line: &str) -> Option<String> {
    let (name, rest) = line.strip_prefix("pub extern \"C\" fn ")?.split_once('(')?;
    let (parameters, end) = rest.split_once(')')?;
    let returned = match end.strip_suffix('{')?.trim().strip_prefix("-> ") {
        Some(of) => c_type(of)?,
        None => "void",
    };
    let parameters = parameters.split(", ").filter(|parameter| !parameter.is_empty()).map(declared);
    let parameters: Vec<String> = parameters.collect::<Option<_>>()?;
    let start = format!("{returned} {name}(");
    let whole = format!("{start}{});", parameters.join(", "));
    if whole.len() <= 100 {
        return Some(whole);
    }
    let separator = format!(",\n{}", " ".repeat(start.len()));
    Some(format!("{start}{});", parameters.join(&separator)))
}

/// A parameter: `q: &[f64; 7]` is `const double (*q)[7]`.
fn declared(parameter: &str) -> Option<String> {
    let (name, of) = parameter.split_once(": ")?;
    let (constant, array) = match (of.strip_prefix("&mut ["), of.strip_prefix("&[")) {
        (Some(array), _) => ("", array),
        (None, Some(array)) => ("const ", array),
        (None, None) => return Some(format!("{} {name}", c_type(of)?)),
    };
    let (of, length) = array.strip_suffix(']')?.split_once("; ")?;
    Some(format!("{constant}{} (*{name})[{length}]", c_type(of)?))
}

fn c_type(name: &str) -> Option<&'static str> {
    match name {
        "f64" => Some("double"),
        "f32" => Some("float"),
        "usize" => Some("size_t"),
        "bool" => Some("bool"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::c_header;
    use crate::{FloatType, Function};

    #[test]
    fn functions_and_their_comments() {
        let text = "/// Length.\npub const ARM_NV: usize = 2;\n/// Not C's.\npub fn other() {}\n\n/// Poses */ of\n///\n\
                    /// a link.\n#[unsafe(no_mangle)]\npub extern \"C\" fn arm_pose(q: &[f64; 2], link: usize, \
                    out: &mut [f64; 12]) -> bool {\ntrue\n}\n/// Energy.\npub extern \"C\" fn \
                    arm_energy(q: &[f64; 2]) -> f64 {\n";
        let header = c_header(text, "arm", FloatType::F64);
        let expected = "#define ARM_NV 2\n";
        assert!(header.contains(&format!("/**\n * Length.\n */\n{expected}")), "{header}");
        let pose = "/**\n * Poses * / of\n *\n * a link.\n */\n\
                    bool arm_pose(const double (*q)[2], size_t link, double (*out)[12]);\n";
        assert!(header.contains(pose), "{header}");
        assert!(header.contains("double arm_energy(const double (*q)[2]);\n"), "{header}");
        assert!(!header.contains("other") && !header.contains("Not C's"), "{header}");
    }

    /// Every function that is exported is in the header, for both scalars and robots of all joint types.
    #[test]
    fn nothing_is_left_out() {
        for (float, scalar) in [(FloatType::F64, "double"), (FloatType::F32, "float")] {
            let robot = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/joint_zoo.urdf");
            let functions = Function::ALL.iter().copied().filter(|f| f.batched().is_none());
            let builder = crate::Builder::new().urdf(robot).float(float).functions(functions);
            let text = builder.c_functions("zoo").generate().expect("a good robot").text;
            let exported = text.matches("pub extern \"C\" fn zoo_").count();
            let header = c_header(&text, "zoo", float);
            assert!(exported > 20 && header.matches(" zoo_").count() == exported, "{header}");
            assert_eq!(header.matches("#define ZOO_").count(), 3 + 1 + 2, "{header}");
            assert!(header.contains(&format!("const {scalar} (*q)[")), "{header}");
        }
    }
}
