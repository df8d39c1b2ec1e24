//! The macro of modyn; use it through the crate `modyn`.

mod input;
mod locate;

use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

use modyn_codegen::diagnostics::{Diagnostic, Diagnostics, Severity};
use proc_macro::TokenStream;
use syn::{Error, Result};

use input::Input;

/// Compiles a robot description to a type, here.
///
/// ```ignore
/// modyn::modyn!("robots/gripper.urdf");
/// modyn::modyn! { pub(crate) Arm = "robots/arm7.urdf", gravity = [0.0, 0.0, 0.0] }
/// ```
///
/// The path is relative to this source file or, if it is not there, to the folder of the crate's
/// `Cargo.toml`. It is a URDF or, with the feature `mjcf`, a `MuJoCo` model; the file's first element says which. Without a
/// name, the type is `pub` and named after the robot. What is odd in the
/// description, but no error, is printed during the build and stands in the type's documentation.
///
/// | option | values | default |
/// |---|---|---|
/// | `gravity` | `[x, y, z]`, m/s^2 in world axes; or `runtime`: one of the type's `Params` | `[0.0, 0.0, -9.81]` |
/// | `runtime_inertia` | names of links whose own inertia can be replaced at run time, in `Params` | `[]` |
/// | `payload` | names of links to which an inertia can be added at run time, in `Params`; by default none is | `[]` |
/// | `functions` | a list of functions' names, in which `default` may stand; `all` | `default` |
/// | `modules` | `chains`, `links`, or a list of lists of link names, each from its parent outwards | `chains` |
/// | `scalar` | `f64`, `f32`: of the type's own functions | `f64` |
/// | `base` | `fixed`, `floating` | `fixed` |
/// | `mimic` | `follow`, `independent`, `refuse`: joints that mimic another one | `follow` |
/// | `rotors` | `["joint": (inertia, gear_ratio), ...]`, kg m^2 | the description's |
/// | `friction` | `none`, `viscous`, `coulomb`, `smooth(velocity)`: which of the description's damping and friction acts | `none`, with a warning if there are some |
/// | `loops` | `["name": spherical("link", [x, y, z], "link", [x, y, z]), ...]`, or `fixed`, `revolute`, `continuous`, `prismatic`: loop joints | the description's |
/// | `contacts` | `["name": point("link"), "name": surface("link", [x, y, z], [roll, pitch, yaw]), ...]`: frames of links that may touch the world | none |
/// | `share` | `true`, `false`: equal limbs through one function | `false` |
/// | `unphysical_inertia` | `error`, `warn` | `error` |
/// | `crate` | the path of `modyn`, where it was renamed | `::modyn` |
///
/// Names of the description become identifiers word by word, words being runs of ASCII letters and
/// digits: `my-robot 2` is the type `MyRobot2`, the joint `arm/left.wrist` the variant
/// `ArmLeftWrist`. An underscore stays between two digits (`Joint1_2`), `N` comes before a leading
/// digit, an underscore behind a keyword (`Self_`), and a variant that is taken gets `_2`, `_3` and so
/// on, in the order of the joints or links. A type `Robot` collides with `use modyn::Robot`: give it
/// a name then.
#[proc_macro]
pub fn modyn(input: TokenStream) -> TokenStream {
    syn::parse(input).and_then(compile).unwrap_or_else(|error| error.into_compile_error().into())
}

fn compile(Input { path, span, builder }: Input) -> Result<TokenStream> {
    let error = |message: &dyn Display| Error::new(span, message);
    let bug = |what| error(&format!("modyn {what}; please report this, with the description"));
    let refused = |found: Diagnostics| {
        let (errors, warnings): (Vec<_>, Vec<_>) =
            found.into_iter().partition(|one| one.severity == Severity::Error);
        warn(warnings);
        // Rustc writes `error: ` before each, and an editor lists each.
        let mut errors = errors.iter().map(|one| error(&one.without_severity()));
        let first = errors.next().unwrap_or_else(|| bug("refused a description without a reason"));
        errors.take(Diagnostics::SHOWN - 1).fold(first, |mut all, one| {
            all.combine(one);
            all
        })
    };
    let compiled = catch_unwind(AssertUnwindSafe(|| {
        let (builder, tracking) = match locate::locate(&path, span) {
            Ok(found) => (builder.text(found.text, &path), found.tracking),
            // What is wrong with the options is said along with it.
            Err(why) => (builder.unread(why), String::new()),
        };
        Ok((builder.generate()?, tracking))
    }));
    let (generated, tracking) = compiled.map_err(|_| bug("panicked"))?.map_err(refused)?;
    warn(generated.warnings);
    // The compiler's own lexer is much faster than building tokens one by one in a macro, which
    // runs unoptimised.
    let text = generated.text + &tracking;
    text.parse().map_err(|_| bug("wrote what is no Rust"))
}

/// Prints warnings: all that a macro can do on stable Rust. Cargo repeats them, as it does rustc's.
fn warn(warnings: Vec<Diagnostic>) {
    if !warnings.is_empty() {
        eprintln!("{}", Diagnostics::new(warnings));
    }
}
