//! The syntax of options that are copied into Rust and C: visibilities, paths, prefixes.

use crate::names;

/// Returns whether a text is a prefix of names in C.
pub(super) fn is_c_prefix(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Returns whether a text is a visibility in Rust; nothing is private.
pub fn is_visibility(text: &str) -> bool {
    let text = text.trim();
    let Some(rest) = text.strip_prefix("pub").map(str::trim) else { return text.is_empty() };
    let inside = rest.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).map(str::trim);
    match inside {
        None => rest.is_empty(),
        Some("crate" | "super" | "self") => true,
        // The path of a visibility must be an enclosing module.
        Some(inside) => inside.strip_prefix("in ").is_some_and(|path| {
            let first = path.trim().split("::").next().unwrap_or_default();
            is_path_keyword(first.trim()) && is_path(&format!("{path}::name"))
        }),
    }
}

/// Returns whether a text is the path of a module that `use .. as` accepts.
pub fn is_path(text: &str) -> bool {
    let text = text.trim();
    let (global, path) = text.strip_prefix("::").map_or((false, text), |path| (true, path));
    let segments: Vec<&str> = path.split("::").map(str::trim).collect();
    // `self` and `super` alone cannot be imported.
    let Some((last, before)) = segments.split_last() else { return false };
    let mut keywords = before.iter().take_while(|segment| is_path_keyword(segment)).count();
    if *last == "crate" && before.is_empty() {
        keywords = 1;
    }
    let (keywords, names) = segments.split_at(keywords);
    let keywords = keywords.iter().enumerate().all(|(i, keyword)| *keyword == "super" || i == 0);
    keywords
        && (!global || !is_path_keyword(segments[0]))
        && names.iter().all(|name| is_identifier(name))
}

/// Returns whether a segment of a path is a keyword that leads to a module.
fn is_path_keyword(segment: &str) -> bool {
    matches!(segment, "crate" | "self" | "super")
}

/// Returns whether a text is an identifier in every edition, possibly a raw one.
fn is_identifier(text: &str) -> bool {
    let name = text.strip_prefix("r#").unwrap_or(text);
    let mut letters = name.chars();
    let first = letters.next().is_some_and(|c| c == '_' || unicode_ident::is_xid_start(c));
    let keyword = match text.strip_prefix("r#") {
        Some(raw) => matches!(raw, "crate" | "self" | "super" | "Self"),
        None => names::KEYWORDS.contains(&name),
    };
    first && letters.all(unicode_ident::is_xid_continue) && name != "_" && !keyword
}
