//! Indentation by the depth of brackets.

/// Returns `text` indented by its brackets. Strings must end on the line they start on.
pub fn indented(text: &str) -> String {
    let mut depth = 0_usize;
    let mut out = String::with_capacity(text.len() * 5 / 4);
    for line in text.lines().map(str::trim) {
        let (closing, change) = brackets(line);
        if !line.is_empty() {
            out.extend(std::iter::repeat_n("    ", depth.saturating_sub(closing)));
            out.push_str(line);
        }
        out.push('\n');
        depth = depth.saturating_add_signed(change);
    }
    out
}

/// Returns the number of brackets that a line closes at its start, and the number of brackets that
/// it opens minus those that it closes.
fn brackets(line: &str) -> (usize, isize) {
    if line.starts_with("//") {
        return (0, 0);
    }
    let closing = line.chars().take_while(|c| matches!(c, ')' | ']' | '}')).count();
    let mut change = 0;
    let mut in_string = false;
    let mut escaped = false;
    for c in line.chars() {
        match c {
            _ if escaped => escaped = false,
            '\\' if in_string => escaped = true,
            '"' => in_string = !in_string,
            '(' | '[' | '{' if !in_string => change += 1,
            ')' | ']' | '}' if !in_string => change -= 1,
            _ => {}
        }
    }
    (closing, change)
}
