//! Counts of habits that make lines hard to read, in the code of the library. Texts that `cargo
//! xtask pages` writes between marks are not counted.
//!
//! `xtask/style.tsv` has the largest number that each may have. A smaller number is entered there
//! by `cargo xtask style --write`.

use std::fs;
use std::path::{Path, PathBuf};

use crate::pages;
use syn::visit::{self, Visit};
use syn::{Block, Expr, FnArg, Ident, Pat, PatIdent, Signature, Stmt, Type};

/// The folders of the library's code, without tests.
const FOLDERS: &[&str] = &[
    "src",
    "modyn-cli/src",
    "modyn-codegen/src",
    "modyn-gpu/src",
    "modyn-jit/src",
    "modyn-macro/src",
    "modyn-python/src",
    "modyn-read/src",
    "modyn-runtime/src",
    "playground/src",
];

/// The most values that a call may have without counting.
const MAX_VALUES: usize = 6;

/// The longest line.
const MAX_COLUMNS: usize = 120;

/// Names of bindings that do not say a role.
const VAGUE: [&str; 3] = ["own", "found", "of"];

/// The counts, by their names in `style.tsv`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Counts {
    /// Functions with more than [`MAX_VALUES`] values in a call; the values of a tuple count one by
    /// one.
    long_calls: usize,
    /// Parameters that are tuple patterns.
    tuple_parameters: usize,
    /// Bindings of tuples to tuples: `let (a, b) = (x, y)`.
    tuple_bindings: usize,
    /// Names that are bound again in the next statement.
    shadowed_at_once: usize,
    /// Lines beyond [`MAX_COLUMNS`].
    long_lines: usize,
    /// Bindings with [`VAGUE`] names.
    vague_names: usize,
    /// Lines of comments with "those of" or "that of".
    pronouns: usize,
}

impl Counts {
    /// Returns the counts with their names.
    fn rows(&self) -> [(&'static str, usize); 7] {
        [
            ("functions with more than six values in a call", self.long_calls),
            ("parameters that are tuple patterns", self.tuple_parameters),
            ("bindings of tuples to tuples", self.tuple_bindings),
            ("names bound again in the next statement", self.shadowed_at_once),
            ("lines over 120 columns", self.long_lines),
            ("bindings named own, found or of", self.vague_names),
            ("comment lines with `those of` or `that of`", self.pronouns),
        ]
    }

    /// Adds the counts of a file's text.
    fn add_text(&mut self, path: &Path, text: &str) {
        self.long_lines += text.lines().filter(|line| line.chars().count() > MAX_COLUMNS).count();
        let comments = text.lines().filter_map(|line| line.split_once("//"));
        let has_pronoun =
            |comment: &str| comment.contains("those of") || comment.contains("that of");
        self.pronouns += comments.filter(|(_, comment)| has_pronoun(comment)).count();
        let file =
            syn::parse_file(text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        self.visit_file(&file);
    }
}

/// Returns the number of values of a type: a tuple has those of its parts.
fn values(kind: &Type) -> usize {
    match kind {
        Type::Tuple(tuple) if !tuple.elems.is_empty() => tuple.elems.iter().map(values).sum(),
        _ => 1,
    }
}

/// Returns the pattern without its type.
fn untyped(pattern: &Pat) -> &Pat {
    match pattern {
        Pat::Type(typed) => &typed.pat,
        _ => pattern,
    }
}

/// Returns the name that a statement binds, if it binds one.
fn bound_name(statement: &Stmt) -> Option<&Ident> {
    let Stmt::Local(local) = statement else { return None };
    match untyped(&local.pat) {
        Pat::Ident(PatIdent { ident, .. }) => Some(ident),
        _ => None,
    }
}

impl<'ast> Visit<'ast> for Counts {
    fn visit_signature(&mut self, signature: &'ast Signature) {
        let mut count = 0;
        for input in &signature.inputs {
            let FnArg::Typed(parameter) = input else { continue };
            count += values(&parameter.ty);
            self.tuple_parameters += usize::from(matches!(*parameter.pat, Pat::Tuple(_)));
        }
        self.long_calls += usize::from(count > MAX_VALUES);
        visit::visit_signature(self, signature);
    }

    fn visit_block(&mut self, block: &'ast Block) {
        for statement in &block.stmts {
            let Stmt::Local(local) = statement else { continue };
            let is_tuple =
                local.init.as_ref().is_some_and(|init| matches!(*init.expr, Expr::Tuple(_)));
            let binds_tuple = matches!(untyped(&local.pat), Pat::Tuple(_));
            self.tuple_bindings += usize::from(is_tuple && binds_tuple);
        }
        let pairs = block.stmts.windows(2);
        let is_same = |pair: &&[Stmt]| {
            let names = [bound_name(&pair[0]), bound_name(&pair[1])];
            names[0].is_some() && names[0] == names[1]
        };
        self.shadowed_at_once += pairs.filter(is_same).count();
        visit::visit_block(self, block);
    }

    fn visit_pat_ident(&mut self, pattern: &'ast PatIdent) {
        self.vague_names += usize::from(VAGUE.iter().any(|name| pattern.ident == name));
        visit::visit_pat_ident(self, pattern);
    }
}

fn rust_files(folder: &Path, files: &mut Vec<PathBuf>) {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> =
        entries.map(|entry| entry.expect("an entry of a folder").path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            rust_files(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// Returns the faults: each count that is larger than its number in `style.tsv`, or smaller unless
/// it is written there.
pub fn run(write: bool) -> Vec<String> {
    let mut files = Vec::new();
    for folder in FOLDERS {
        rust_files(&pages::root(folder), &mut files);
    }
    let mut counts = Counts::default();
    for path in &files {
        let text = fs::read_to_string(path).expect("a text");
        counts.add_text(path, &pages::without_made_texts(&text));
    }
    let table = pages::root("xtask/style.tsv");
    let lines = counts.rows().map(|(name, count)| format!("{count}\t{name}\n"));
    if write {
        fs::write(&table, lines.concat()).expect("the table can be written");
        return Vec::new();
    }
    let frozen = fs::read_to_string(&table).expect("xtask/style.tsv");
    let of = |line: &str| line.split_once('\t').and_then(|(count, _)| count.parse::<usize>().ok());
    let limits = frozen.lines().map(|line| of(line).expect("a number and a name"));
    let faults = counts.rows().into_iter().zip(limits).filter_map(|((name, count), limit)| {
        let advice = match count.cmp(&limit) {
            std::cmp::Ordering::Equal => return None,
            std::cmp::Ordering::Less => {
                "run `cargo xtask style --write` to keep the smaller number"
            }
            std::cmp::Ordering::Greater => "write the new lines without it",
        };
        Some(format!("{name}: {count}, was {limit}: {advice}"))
    });
    faults.collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::Counts;

    #[test]
    fn the_library_has_no_more_of_these_lines_than_before() {
        assert_eq!(super::run(false), Vec::<String>::new());
    }

    #[test]
    fn each_habit_is_counted() {
        let text = "// Those that of of those of a parent.\n\
            fn long((a, b): (u8, (u8, u8)), c: u8, d: u8, e: u8, f: u8) {\n\
                let (x, y) = (a, b);\n\
                let own = x;\n\
                let own = own + y.0;\n\
            }\n";
        let mut counts = Counts::default();
        counts.add_text(Path::new("text"), &format!("{text}// {}\n", "x".repeat(118)));
        let all = [1, 1, 1, 1, 1, 2, 1];
        assert_eq!(counts.rows().map(|(_, count)| count), all);
    }
}
