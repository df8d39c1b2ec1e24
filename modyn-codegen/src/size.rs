//! The estimated size of a robot's text, computed before the text is made.

use modyn_runtime::model::{Model, ModuleTree};

use crate::diagnostics::{Code, Diagnostic};
use crate::plan::{Function, Lowering, Measures, estimated_length};

/// The largest number of bytes of generated text, by [`estimate`].
pub const MAX_BYTES: f64 = 32e6;

/// The length in bytes of a body's row in the tables of a loop over the bodies.
const BYTES_PER_ROW: f64 = 900.0;

/// The functions whose text is estimated.
#[derive(Clone, Copy)]
pub struct Selected<'a> {
    /// The functions by themselves.
    pub functions: &'a [Function],
    /// The functions in bundles, which are straight-line code.
    pub bundled: &'a [Function],
    /// Whether functions that are recursions over the bodies become loops.
    pub has_loops: bool,
}

impl<'a> Selected<'a> {
    /// Returns these functions as straight-line code, without bundles.
    pub fn straight(functions: &'a [Function]) -> Self {
        Self { functions, bundled: &[], has_loops: false }
    }
}

/// Returns the estimated size of a robot's text in bytes, and the sizes of its functions, the largest first.
pub fn estimate(
    model: &Model,
    modules: &ModuleTree,
    selected: Selected<'_>,
) -> (f64, Vec<(Function, f64)>) {
    let measures = Measures::new(model, modules);
    let of_kinds = measures.of_kinds();
    let straight = |f: Function| estimated_length(f, &measures);
    let alone = |f: Function| match Lowering::of(f).recursion {
        Some(_) if selected.has_loops && !model.has_mimics() => {
            estimated_length(f, &of_kinds) + BYTES_PER_ROW * measures.links
        }
        _ => straight(f),
    };
    let own = selected.functions.iter().map(|&f| (f, alone(f)));
    let bundled = selected.bundled.iter().map(|&f| (f, straight(f)));
    let mut sizes: Vec<_> =
        own.chain(bundled).filter(|(f, _)| f.fits(model.constraints())).collect();
    sizes.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    // Enums, names and tables have a line or two for each joint and link. The functions that are not there have one each.
    let tables = 35_000.0 + 500.0 * measures.links + 600.0 * measures.frames;
    (tables + sizes.iter().map(|(_, bytes)| bytes).sum::<f64>(), sizes)
}

/// Returns an error if the text of this robot would be too large.
pub fn too_large(
    model: &Model,
    modules: &ModuleTree,
    selected: Selected<'_>,
) -> Option<Diagnostic> {
    let (bytes, sizes) = estimate(model, modules, selected);
    if bytes <= MAX_BYTES {
        return None;
    }
    let megabytes = |bytes: f64| format!("{:.0} MB", bytes / 1e6);
    let largest = sizes.iter().take(3).filter(|(_, bytes)| *bytes > MAX_BYTES / 10.0);
    let largest: Vec<String> =
        largest.map(|(f, bytes)| format!("`{}` {}", f.name(), megabytes(*bytes))).collect();
    let largest =
        if largest.is_empty() { String::new() } else { format!(" ({})", largest.join(", ")) };
    let longest = modules.modules().iter().map(|module| &module.links).max_by_key(|l| l.len())?;
    let message = format!(
        "code for {} moving joints and {} links would be about {} of text{largest}, more than {}; the \
         longest module has {} links, from `{}` to `{}`",
        model.links().len(),
        model.frames().len(),
        megabytes(bytes),
        megabytes(MAX_BYTES),
        longest.len(),
        model.links()[longest.start].name,
        model.links()[longest.end - 1].name,
    );
    let by_links = ModuleTree::links(model);
    // As few functions as necessary, the largest first.
    let mut rest = bytes;
    let dropped = sizes.iter().take_while(|(_, bytes)| {
        let needed = rest > MAX_BYTES;
        rest -= bytes;
        needed
    });
    let dropped: Vec<String> =
        dropped.map(|(function, _)| format!("`{}`", function.name())).collect();
    let help = if estimate(model, &by_links, selected).0 <= MAX_BYTES {
        "divide it: `modules = links`; or use `modyn::Interpreter`, which has no such limit".into()
    } else if rest <= MAX_BYTES && dropped.len() <= 4 {
        format!(
            "leave {} out of the option `functions`; or use `modyn::Interpreter`, which has no such limit",
            dropped.join(", ")
        )
    } else {
        "use `modyn::Interpreter`, which has no such limit, or select fewer functions, or remove links that \
         nothing needs"
            .into()
    };
    Some(Diagnostic::error(Code::TooLarge, message).with_help(help))
}
