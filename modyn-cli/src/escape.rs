//! What comes from a description may hold anything: here it is made harmless for where it goes.
//!
//! JSON is escaped by serde_json, quotes in CSV by csv, text in pictures by [`markup`]; for a terminal there is
//! `modyn_codegen::diagnostics::sanitize_for_display`.

/// As text or an attribute's value in SVG and HTML.
pub fn markup(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&#39;",
            // What XML cannot have at all.
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push('\u{fffd}'),
            _ => escaped.push(c),
        }
    }
    escaped
}

/// As a cell of a table: a spreadsheet takes what begins like a formula for one.
#[cfg(feature = "command")]
pub fn cell(text: &str) -> String {
    let text = modyn_codegen::diagnostics::sanitize_for_display(text);
    if text.starts_with(['=', '+', '-', '@']) { format!("'{text}") } else { text }
}

/// The text, with its middle left out if it is longer than `most` characters.
#[cfg(feature = "command")]
pub fn shortened(text: &str, most: usize) -> String {
    let characters: Vec<char> = text.chars().collect();
    if characters.len() <= most {
        return text.into();
    }
    let (head, tail) = (most.saturating_sub(1) / 2, most / 2);
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
    fn nothing_gets_out_of_where_it_stands() {
        assert_eq!(
            markup("<b a=\"1\" c='2'>&\u{1b}\n"),
            "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;\u{fffd}\u{fffd}"
        );
        #[cfg(feature = "command")]
        assert_eq!([cell("=1+1"), cell("a\r\nb")], ["'=1+1", "a\u{fffd}\u{fffd}b"]);
    }
}
