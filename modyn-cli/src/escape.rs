//! Escapes names of a description, which may contain any character, for the format of the output.
//!
//! [`json`] escapes in JSON what serde_json leaves, csv escapes quotes in CSV, and [`markup`]
//! escapes text in pictures. For terminals there is
//! `modyn_read::diagnostics::sanitize_for_display`.

use modyn_read::diagnostics::is_unprintable;

/// Returns text, or an attribute's value, escaped for SVG and HTML.
pub fn markup(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&#39;",
            // Characters that XML forbids.
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push('\u{fffd}'),
            c if is_unprintable(c) => escaped += &format!("&#{};", u32::from(c)),
            _ => escaped.push(c),
        }
    }
    escaped
}

/// Returns JSON in lines. Characters that control a terminal or are invisible are escaped, too.
#[cfg(feature = "command")]
pub fn json(value: &serde_json::Value) -> String {
    let mut escaped = String::new();
    for c in format!("{value:#}\n").chars() {
        if c == '\n' || !is_unprintable(c) {
            escaped.push(c);
        } else {
            json_character(&mut escaped, c);
        }
    }
    escaped
}

/// Writes a character within a string of JSON by its number.
pub fn json_character(out: &mut String, c: char) {
    for unit in c.encode_utf16(&mut [0; 2]) {
        *out += &format!("\\u{unit:04x}");
    }
}

/// Returns a cell of a table; a spreadsheet would take text that starts like a formula for one.
#[cfg(feature = "command")]
pub fn cell(text: &str) -> String {
    let text = modyn_read::diagnostics::sanitize_for_display(text);
    if text.starts_with(['=', '+', '-', '@']) { format!("'{text}") } else { text }
}

/// Returns the text; characters in the middle are left out if it is longer than `most`.
#[cfg(feature = "picture")]
pub fn shortened(text: &str, most: usize) -> String {
    let characters: Vec<char> = text.chars().collect();
    if characters.len() <= most {
        return text.into();
    }
    let head = most.saturating_sub(1) / 2;
    let tail = most / 2;
    let part = |range: &[char]| range.iter().collect::<String>();
    format!("{}…{}", part(&characters[..head]), part(&characters[characters.len() - tail..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(feature = "command")]
    fn long_names_lose_their_middle() {
        assert_eq!(shortened("abcdefgh", 5), "ab…gh");
        assert_eq!(shortened("abc", 5), "abc");
    }

    #[test]
    fn special_characters_are_escaped() {
        assert_eq!(
            markup("<b a=\"1\" c='2'>&\u{1b}\n\u{202e}"),
            "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;\u{fffd}\u{fffd}&#8238;"
        );
        #[cfg(feature = "command")]
        assert_eq!([cell("=1+1"), cell("a\r\nb")], ["'=1+1", "a\u{fffd}\u{fffd}b"]);
        #[cfg(feature = "command")]
        assert_eq!(
            json(&serde_json::json!(["\u{9b}2J\u{202e}\u{e0001}é"])),
            "[\n  \"\\u009b2J\\u202e\\udb40\\udc01é\"\n]\n"
        );
    }
}
