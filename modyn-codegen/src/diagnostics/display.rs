//! Text of a description where others read it: names may hold anything.

/// `text` in one line, and as it looks: a line break would end a comment, a control character command
/// a terminal, and rustc denies characters that change the direction of what follows them.
#[must_use]
pub fn sanitize_for_display(text: &str) -> String {
    text.replace(|c: char| c.is_control() || is_invisible(c), "\u{fffd}")
}

/// Characters that show nothing themselves: marks of direction, joiners, separators of lines.
fn is_invisible(c: char) -> bool {
    matches!(c,
        '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
        | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}
