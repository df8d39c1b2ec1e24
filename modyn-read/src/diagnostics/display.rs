//! Names of a description in messages: lists of them, and names made safe to display, since they may
//! contain any character.

/// The number of joints or links that a message names.
const MAX_NAMES: usize = 4;

/// Returns `text` on one line, with invisible characters replaced. A line break would end a
/// comment, a control character could command a terminal, and rustc rejects characters that change
/// the direction of text.
#[must_use]
pub fn sanitize_for_display(text: &str) -> String {
    text.replace(is_unprintable, "\u{fffd}")
}

/// Returns whether a character controls a terminal, or is invisible.
#[must_use]
pub fn is_unprintable(c: char) -> bool {
    c.is_control() || is_invisible(c)
}

/// Returns whether a character is invisible: marks of direction, joiners, separators of lines.
fn is_invisible(c: char) -> bool {
    matches!(c,
        '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
        | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

/// Returns names in words: "link `a`", "links `a`, `b`", "links `a`, `b`, `c`, `d` and 3 more".
#[must_use]
pub fn listed<'n>(what: &str, names: impl Iterator<Item = &'n str>) -> String {
    let names: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    let shown = names[..names.len().min(MAX_NAMES)].join(", ");
    match names.len() {
        1 => format!("{what} {shown}"),
        count if count > MAX_NAMES => format!("{what}s {shown} and {} more", count - MAX_NAMES),
        _ => format!("{what}s {shown}"),
    }
}
