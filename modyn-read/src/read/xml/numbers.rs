//! Reads numbers strictly.
//!
//! `f64::from_str` accepts `nan` and `inf`, and turns `1e400` into infinity. urdf-rs skips words in
//! a list that are not numbers. Here a list must have exactly the required number of entries, all
//! finite.

use crate::diagnostics::Code;

/// The reason why a text is not a list of `N` finite numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadNumbers {
    pub code: Code,
    pub message: String,
    pub help: String,
}

/// Returns exactly `N` finite numbers, separated by white space.
pub fn numbers<const N: usize>(text: &str) -> Result<[f64; N], BadNumbers> {
    let mut values = [0.0; N];
    let mut count = 0;
    for word in text.split_ascii_whitespace() {
        let value = number(word)?;
        if let Some(place) = values.get_mut(count) {
            *place = value;
        }
        count += 1;
    }
    if count == N {
        return Ok(values);
    }
    let (s, are) = if N == 1 { ("", "is") } else { ("s", "are") };
    let amount = if count == 0 { "none".into() } else { count.to_string() };
    let help =
        format!("write exactly {N} number{s}{}", if N == 1 { "" } else { ", separated by spaces" });
    let message = format!(
        "{N} number{s} {are} needed, but there {} {amount} in \"{}\"",
        if count == 1 { "is" } else { "are" },
        truncate(text)
    );
    Err(BadNumbers { code: Code::NumberCount, message, help })
}

/// Returns one decimal number: an optional sign, digits with an optional point, an optional
/// exponent.
fn number(word: &str) -> Result<f64, BadNumbers> {
    let name = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
    let infinite = |message| BadNumbers {
        code: Code::NotFinite,
        message,
        help: "write a finite number".into(),
    };
    if matches!(name.as_str(), "nan" | "inf" | "infinity") {
        return Err(infinite(format!("`{}` is not finite", truncate(word))));
    }
    let decimal = word.bytes().all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b));
    match word.parse::<f64>() {
        Ok(value) if decimal && value.is_finite() => Ok(value),
        Ok(_) if decimal => {
            Err(infinite(format!("`{}` is too large for a 64-bit number", truncate(word))))
        }
        _ => Err(BadNumbers {
            code: Code::BadNumber,
            message: format!("`{}` is not a number", truncate(word)),
            help: if word.contains(',') {
                "write a point before decimals, and spaces (no commas) between numbers".into()
            } else {
                "write a decimal number such as `0.25` or `2.5e-1`".into()
            },
        }),
    }
}

/// Returns at most 60 characters of a text, for a message.
fn truncate(text: &str) -> String {
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.into(),
    }
}
