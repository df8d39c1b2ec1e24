//! The macro of modyn; use it through the crate `modyn`.

mod input;
mod locate;

use modyn_codegen::error::Diagnostics;
use proc_macro::TokenStream;

use input::Input;

/// Compiles a robot description to a type, here.
///
/// ```ignore
/// modyn::modyn!("robots/gripper.urdf");
/// modyn::modyn! { pub(crate) Arm = "robots/arm7.urdf", gravity = [0.0, 0.0, 0.0] }
/// ```
///
/// The path is relative to this source file or, if it is not there, to the folder of the crate's
/// `Cargo.toml`. Without a name, the type is `pub` and named after the robot.
///
/// | option | values | default |
/// |---|---|---|
/// | `gravity` | `[x, y, z]`, m/s^2 in world axes | `[0.0, 0.0, -9.81]` |
/// | `modules` | `chains`, `links`, or a list of lists of link names, each from its parent outwards | `chains` |
/// | `scalar` | `f64`, `f32`: of the type's own functions | `f64` |
/// | `base` | `fixed` | `fixed` |
/// | `mimic` | `refuse`, `independent`: joints that mimic another one | `refuse` |
/// | `unphysical_inertia` | `error`, `warn` | `error` |
/// | `crate` | the path of `modyn`, where it was renamed | `::modyn` |
#[proc_macro]
pub fn modyn(input: TokenStream) -> TokenStream {
    let Input { path, span, builder } = match syn::parse::<Input>(input) {
        Ok(input) => input,
        Err(error) => return error.into_compile_error().into(),
    };
    let error = |errors: &Diagnostics| -> TokenStream {
        syn::Error::new(span, errors.to_string()).into_compile_error().into()
    };
    let found = match locate::locate(&path, span) {
        Ok(found) => found,
        Err(errors) => return error(&errors),
    };
    match builder.urdf_text(found.text, path).generate() {
        Ok(generated) => {
            // The compiler's own lexer is much faster than building tokens one by one in a macro,
            // which runs unoptimised.
            let text = format!("{}{}", generated.text, found.tracking);
            text.parse().unwrap_or_else(|_| {
                syn::Error::new(span, "modyn wrote text that is no Rust; please report this")
                    .into_compile_error()
                    .into()
            })
        }
        Err(errors) => error(&errors),
    }
}
