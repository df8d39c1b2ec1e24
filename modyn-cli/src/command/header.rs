//! The header of the functions for C.

use std::path::Path;

use modyn_codegen::FloatType;

use crate::command::outcome::Failure;

/// Made by cbindgen from the generated file, with assertions that sizes are the C compiler's too.
pub fn text(source: &Path, prefix: &str, float: FloatType) -> Result<String, Failure> {
    let upper = prefix.to_uppercase();
    let (c, size) = match float {
        FloatType::F64 => ("double", 8),
        FloatType::F32 => ("float", 4),
    };
    let sizes = format!(
        "#ifdef __cplusplus\n#define {upper}_ASSERT static_assert\n#else\n\
         #define {upper}_ASSERT _Static_assert\n#endif\n\
         {upper}_ASSERT(sizeof({c}) == {size}, \"{c}\");\n\
         {upper}_ASSERT(sizeof({c}[{upper}_NV]) == {size} * {upper}_NV, \"arrays without gaps\");"
    );
    let config = cbindgen::Config {
        language: cbindgen::Language::C,
        include_guard: Some(format!("{upper}_H")),
        cpp_compat: true,
        usize_is_size_t: true,
        ..cbindgen::Config::default()
    };
    let builder = cbindgen::Builder::new().with_config(config).with_trailer(sizes);
    let bindings = builder.with_src(source).generate().map_err(|error| {
        Failure::usage(format!("error: cbindgen cannot make the header: {error}"))
    })?;
    let mut header = Vec::new();
    bindings.write(&mut header);
    String::from_utf8(header)
        .map_err(|error| Failure::usage(format!("error: cbindgen wrote what is no text: {error}")))
}
