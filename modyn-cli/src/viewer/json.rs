//! The data of a page: JSON that can be within an element of HTML.

use modyn_read::diagnostics::is_unprintable;

use crate::escape::json_character;

/// Writes a list of items.
pub fn list<T>(
    out: &mut String,
    items: impl IntoIterator<Item = T>,
    mut write: impl FnMut(&mut String, T),
) {
    out.push('[');
    for (i, item) in items.into_iter().enumerate() {
        if i > 0 {
            out.push(',');
        }
        write(out, item);
    }
    out.push(']');
}

/// Writes a list of numbers.
pub fn numbers<'n>(out: &mut String, numbers: impl IntoIterator<Item = &'n f64>) {
    list(out, numbers, |out, &x| number(out, x));
}

/// Writes a number with six digits; `null` for a number that is not finite.
pub fn number(out: &mut String, x: f64) {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    if !rounded.is_finite() {
        *out += "null";
    } else if rounded == 0.0 {
        *out += "0";
    } else {
        let text = format!("{rounded:?}");
        *out += text.strip_suffix(".0").unwrap_or(&text);
    }
}

/// Writes a text. `<` is escaped, so that no text ends the element, and characters that control a
/// terminal or are invisible are escaped, too.
pub fn text(out: &mut String, text: &str) {
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => *out += "\\\"",
            '\\' => *out += "\\\\",
            c if c == '<' || is_unprintable(c) => json_character(out, c),
            c => out.push(c),
        }
    }
    out.push('"');
}

/// Writes `"name":`, after a comma unless it is the first of an object.
pub fn key(out: &mut String, name: &str) {
    if !out.ends_with('{') {
        out.push(',');
    }
    text(out, name);
    out.push(':');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_digits() {
        let cases = [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (-0.123_456_789, "-0.123457"),
            (1e-9, "1e-9"),
            (1.5e9, "1500000000"),
            (f64::NAN, "null"),
            (f64::INFINITY, "null"),
        ];
        for (x, expected) in cases {
            let mut out = String::new();
            number(&mut out, x);
            assert_eq!(out, expected);
        }
    }

    #[test]
    fn texts_stay_within_their_element() {
        let mut out = String::new();
        text(&mut out, "</script>\"\\\n\u{2028}é");
        assert_eq!(out, "\"\\u003c/script>\\\"\\\\\\u000a\\u2028é\"");
    }
}
