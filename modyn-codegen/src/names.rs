//! The conversion of names in the description to Rust identifiers.
//!
//! URDF allows any text as a name; names with dots, dashes and slashes are common.
//!
//! 1. A name is split into words at every character that is not an ASCII letter or digit.
//! 2. A type or an enum variant ([`type_name`], [`variants`]) is the words in upper camel case.
//!    Only the first letter of each word is changed: `my-robot 2` is `MyRobot2`, `fr3_linkA` is
//!    `Fr3LinkA`. Between a digit and a digit of the next word an underscore remains: `joint_1_2`
//!    is `Joint1_2`, not `Joint12`.
//! 3. A function or a variable ([`snake`]) is the words in lower case, separated by underscores. An
//!    upper-case letter after a lower-case letter or a digit starts a new word: `linkA.2` is
//!    `link_a_2`.
//! 4. An identifier that would start with a digit is prefixed with `N` (`n_` in snake case). A name
//!    without words is `Unnamed` (`unnamed`). A keyword gets a trailing underscore; so does a
//!    variant `ALL`, since the generated enums have a constant of that name.
//! 5. Among [`variants`], a name whose identifier is taken gets `_2`, `_3` and so on: the first
//!    identifier that no other name has by rules 1 to 4. Names are handled in order.

use std::collections::HashSet;

/// Returns the name of a type, in upper camel case.
#[must_use]
pub fn type_name(name: &str) -> String {
    let mut result = String::with_capacity(name.len());
    for word in words(name) {
        let mut letters = word.chars();
        let Some(first) = letters.next() else {
            continue;
        };
        if first.is_ascii_digit() && result.ends_with(|c: char| c.is_ascii_digit()) {
            result.push('_');
        }
        result.push(first.to_ascii_uppercase());
        result.push_str(letters.as_str());
    }
    identifier(result, "N", "Unnamed")
}

/// Returns the name of a type that only the generated text uses. No robot's type can have it:
/// [`type_name`] never starts with an underscore.
pub(crate) fn helper_type(name: &str) -> String {
    format!("__{}", type_name(name))
}

/// Returns the variants of an enum with one variant for each name, in order; all are different.
#[must_use]
pub fn variants(names: &[&str]) -> Vec<String> {
    let variant = |name: &&str| match type_name(name) {
        all if all == "ALL" => "ALL_".into(),
        other => other,
    };
    let plain: Vec<String> = names.iter().map(variant).collect();
    // An identifier that a name has by itself is never used as the numbered identifier of another
    // name.
    let reserved: HashSet<&str> = plain.iter().map(String::as_str).collect();
    let mut taken: HashSet<String> = HashSet::new();
    // The next number for each name, so that a thousand equal names take a thousand steps, not a
    // million.
    let mut next: std::collections::HashMap<&str, usize> = std::collections::HashMap::new();
    let mut variants = Vec::with_capacity(names.len());
    for name in &plain {
        let mut variant = name.clone();
        if taken.contains(name) {
            let number = next.entry(name).or_insert(2);
            loop {
                // `Self_` is numbered `Self_2`, not `Self__2`, which is not camel case.
                variant = format!("{}_{number}", name.trim_end_matches('_'));
                *number += 1;
                if !reserved.contains(variant.as_str()) && !taken.contains(&variant) {
                    break;
                }
            }
        }
        taken.insert(variant.clone());
        variants.push(variant);
    }
    variants
}

/// Returns the attribute of a type with these names of the type and its variants: rustc expects no
/// underscore in them, except between digits.
#[must_use]
pub(crate) fn camel_case_lint<'n>(mut names: impl Iterator<Item = &'n str>) -> &'static str {
    let is_odd = |name: &str| {
        let parts: Vec<&str> = name.trim_matches('_').split('_').collect();
        let is_digit = |letter: Option<char>| letter.is_some_and(|letter| letter.is_ascii_digit());
        parts
            .windows(2)
            .any(|pair| !is_digit(pair[0].chars().next_back()) || !is_digit(pair[1].chars().next()))
    };
    if names.any(is_odd) { "#[allow(non_camel_case_types)]\n" } else { "" }
}

/// Returns the names of fields in snake case, in the order of `names`; all are different, and none
/// is `reserved`.
#[must_use]
pub fn fields(names: &[&str], reserved: &[&str]) -> Vec<String> {
    let mut taken: HashSet<String> = reserved.iter().map(|&name| name.into()).collect();
    let mut field = |name: &&str| {
        let plain = snake(name);
        let numbered = (2..).map(|number| format!("{plain}_{number}"));
        let mut all = std::iter::once(plain.clone()).chain(numbered);
        let free = all.find(|name| !taken.contains(name)).unwrap_or(plain.clone());
        taken.insert(free.clone());
        free
    };
    names.iter().map(&mut field).collect()
}

/// Returns the name of a function or a variable, in snake case.
#[must_use]
pub fn snake(name: &str) -> String {
    let mut result = String::with_capacity(name.len() + 4);
    for word in words(name) {
        if !result.is_empty() {
            result.push('_');
        }
        let mut before = ' ';
        for letter in word.chars() {
            if letter.is_ascii_uppercase()
                && (before.is_ascii_lowercase() || before.is_ascii_digit())
            {
                result.push('_');
            }
            result.push(letter.to_ascii_lowercase());
            before = letter;
        }
    }
    identifier(result, "n_", "unnamed")
}

/// Rust's keywords, strict and reserved, up to edition 2024.
pub const KEYWORDS: &[&str] = &[
    "Self", "abstract", "as", "async", "await", "become", "box", "break", "const", "continue",
    "crate", "do", "dyn", "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if",
    "impl", "in", "let", "loop", "macro", "match", "mod", "move", "mut", "override", "priv", "pub",
    "ref", "return", "self", "static", "struct", "super", "trait", "true", "try", "type", "typeof",
    "unsafe", "unsized", "use", "virtual", "where", "while", "yield",
];

/// The keywords and macros of C and C++ that are names in snake case, and no keywords of Rust.
pub(crate) const CPP_WORDS: &[&str] = &[
    "alignas",
    "alignof",
    "and",
    "and_eq",
    "asm",
    "assert",
    "auto",
    "bitand",
    "bitor",
    "bool",
    "case",
    "catch",
    "char",
    "char16_t",
    "char32_t",
    "char8_t",
    "class",
    "co_await",
    "co_return",
    "co_yield",
    "compl",
    "concept",
    "const_cast",
    "consteval",
    "constexpr",
    "constinit",
    "decltype",
    "default",
    "delete",
    "double",
    "dynamic_cast",
    "errno",
    "explicit",
    "export",
    "float",
    "friend",
    "goto",
    "inline",
    "int",
    "linux",
    "long",
    "mutable",
    "namespace",
    "new",
    "noexcept",
    "not",
    "not_eq",
    "nullptr",
    "operator",
    "or",
    "or_eq",
    "private",
    "protected",
    "public",
    "register",
    "reinterpret_cast",
    "requires",
    "restrict",
    "short",
    "signed",
    "sizeof",
    "static_assert",
    "static_cast",
    "stderr",
    "stdin",
    "stdout",
    "switch",
    "template",
    "this",
    "thread_local",
    "throw",
    "typedef",
    "typeid",
    "typename",
    "union",
    "unix",
    "unsigned",
    "using",
    "void",
    "volatile",
    "wchar_t",
    "xor",
    "xor_eq",
];

fn words(name: &str) -> impl Iterator<Item = &str> {
    name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty())
}

/// Returns an identifier for a text of ASCII letters, digits and underscores.
fn identifier(mut text: String, before_digit: &str, unnamed: &str) -> String {
    if text.is_empty() {
        text.push_str(unnamed);
    }
    if text.starts_with(|c: char| c.is_ascii_digit()) {
        text.insert_str(0, before_digit);
    }
    if KEYWORDS.contains(&text.as_str()) {
        text.push('_');
    }
    text
}
