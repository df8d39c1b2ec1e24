//! Makes names of a description safe to display; they may contain any character.

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
