//! The earlier names of options and of their values, for errors that say the present names.

use modyn_read::diagnostics::suggest;

/// The options that had another name: that name, and the present one.
const OPTION_NAMES: &[(&str, &str)] = &[
    ("bundles", "fused"),
    ("friction", "joint_friction"),
    ("share", "share_limbs"),
    ("unread_forces", "unsupported_forces"),
];

/// The words of values that had another name: that name, and the present one.
const WORDS: &[(&str, &str)] = &[("described", "auto"), ("fast", "unrolled"), ("small", "looped")];

fn present(table: &[(&str, &'static str)], earlier: &str) -> Option<&'static str> {
    table.iter().find(|(name, _)| *name == earlier).map(|(_, now)| *now)
}

/// Returns the present name of an option with this earlier name.
#[must_use]
pub fn renamed_option(earlier: &str) -> Option<&'static str> {
    present(OPTION_NAMES, earlier)
}

/// Returns the present word for an earlier one.
pub(super) fn renamed_word(earlier: &str) -> Option<&'static str> {
    present(WORDS, earlier)
}

/// Returns the message that no option has this name; `known` are the options that there are.
#[must_use]
pub fn unknown_option(name: &str, known: &[&str]) -> String {
    let now = renamed_option(name).filter(|now| known.contains(now));
    let help = match (now, suggest(name, known.iter().copied())) {
        (Some(now), _) => return format!("the option `{name}` is named `{now}` now"),
        (None, Some(meant)) => format!("did you mean `{meant}`?"),
        (None, None) => format!("there are: {}", known.join(", ")),
    };
    format!("there is no option `{name}`; {help}")
}
