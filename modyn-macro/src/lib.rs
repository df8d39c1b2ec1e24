//! The macro of modyn; use it through the crate `modyn`.

mod guides;
mod input;
mod locate;

use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

use modyn_codegen::diagnostics::{Diagnostic, Diagnostics, Severity};
use proc_macro::TokenStream;
use syn::{Error, Result};

use input::Input;

/// Compiles a robot description to a type in this place.
///
/// ```ignore
/// modyn::modyn!("robots/gripper.urdf");
/// modyn::modyn! { pub(crate) Arm = "robots/arm7.urdf", gravity = [0.0, 0.0, 0.0] }
/// ```
///
/// The path is relative to this source file, or else to the folder of the crate's `Cargo.toml`. The
/// file is a URDF, a xacro, an SDF or a `MuJoCo` model; its first element decides. Without a name,
/// the type is `pub` and named after the robot. Errors are compile errors. Warnings about the
/// description are printed during the build, and are part of the type's documentation.
///
#[doc = include_str!("../options.md")]
///
/// Names of the description become identifiers word by word; a word consists of ASCII letters and
/// digits. `my-robot 2` becomes the type `MyRobot2`, the joint `arm/left.wrist` the variant
/// `ArmLeftWrist`. An underscore remains between two digits (`Joint1_2`), a leading digit is
/// prefixed with `N`, and a keyword gets a trailing underscore (`Self_`). A variant that is taken
/// gets `_2`, `_3` and so on, in the order of the joints or links. A type named `Robot` collides
/// with `use modyn::Robot`: give such a robot another name.
#[proc_macro]
pub fn modyn(input: TokenStream) -> TokenStream {
    syn::parse(input).and_then(compile).unwrap_or_else(|error| error.into_compile_error().into())
}

/// Modules for the pages of `docs/`, for the documentation of the crate `modyn`.
#[doc(hidden)]
#[proc_macro]
pub fn guides(_: TokenStream) -> TokenStream {
    let root = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default();
    let read = guides::modules(&std::path::Path::new(&root).join("docs"));
    let modules = read.unwrap_or_else(|error| format!("compile_error!({:?});", error.to_string()));
    modules.parse().unwrap_or_default()
}

fn compile(Input { path, span, builder }: Input) -> Result<TokenStream> {
    let error = |message: &dyn Display| Error::new(span, message);
    let bug = |what| error(&format!("modyn {what}; please report this, with the description"));
    let refused = |diagnostics: Diagnostics| {
        let (errors, warnings): (Vec<_>, Vec<_>) =
            diagnostics.into_iter().partition(|one| one.severity == Severity::Error);
        warn(warnings);
        // Rustc writes `error: ` before each error, and an editor lists each.
        let mut errors = errors.iter().map(|one| error(&one.without_severity()));
        let first = errors.next().unwrap_or_else(|| bug("refused a description without a reason"));
        errors.take(Diagnostics::SHOWN - 1).fold(first, |mut all, one| {
            all.combine(one);
            all
        })
    };
    let compiled = catch_unwind(AssertUnwindSafe(|| {
        let (builder, tracking) = match locate::locate(&path, span) {
            Ok(input) => (builder.text(input.text, &path).folder(input.folder), input.tracking),
            // The errors of the options are reported, too.
            Err(why) => (builder.failed_to_read(why), String::new()),
        };
        Ok((builder.generate()?, tracking))
    }));
    let (generated, tracking) = compiled.map_err(|_| bug("panicked"))?.map_err(refused)?;
    warn(generated.warnings);
    // rustc's lexer is much faster than building tokens one by one in a macro, which runs
    // unoptimised.
    let others = generated.files.iter().map(|file| locate::tracking(file));
    let text = others.fold(generated.text + &tracking, |text, other| text + &other);
    text.parse().map_err(|_| bug("wrote text that is not Rust"))
}

/// Prints warnings to standard error, since macros cannot emit warnings on stable Rust. Cargo
/// repeats them.
fn warn(warnings: Vec<Diagnostic>) {
    if !warnings.is_empty() {
        eprintln!("{}", Diagnostics::new(warnings));
    }
}
