//! Pages and files that are made: of the compiler's tables, and of the measured and counted tables in `docs/data`.
//!
//! A file is made as a whole (`FILES`), or only between the marks `<!-- data: NAME -->` and `<!-- end -->`. Measured tables come
//! from the commands that their files name; each command writes its file (`lab/record`).

mod chart;
mod data;
mod errors;
mod functions;
mod gallery;
mod measured;
mod operations;
mod options;
mod python;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Makes a text.
type Make = fn() -> String;

/// The files that are made as a whole, before the pages that show them.
const FILES: [(&str, Make); 3] = [
    ("docs/data/operations.tsv", operations::counted),
    ("docs/figures/speed.svg", chart::speed),
    ("modyn-macro/options.md", options::of_macro),
];

/// The files with marks, besides the pages of `docs` and `docs/internals`.
const MARKED: [&str; 4] = [
    "README.md",
    "modyn-python/src/methods.rs",
    "modyn-python/python/modyn/_results.py",
    "modyn-python/python/modyn/_modyn.pyi",
];

/// The marks of texts that are made of the compiler's tables. The others show a file of `docs/data`.
const MARKS: [(&str, Make); 9] = [
    ("error-list", errors::list),
    ("function-table", functions::table),
    ("gallery", gallery::table_of_robots),
    ("option-table", options::whole),
    ("options-of-files", options::of_files),
    ("python-functions", python::method_stubs),
    ("python-methods", python::methods),
    ("python-options", python::option_stubs),
    ("python-results", python::results),
];

/// Returns the text of the mark `name`.
fn text_of(name: &str) -> String {
    let own = MARKS.iter().find(|(mark, _)| *mark == name).map(|(_, text)| text());
    own.or_else(|| operations::text_of(name))
        .or_else(|| measured::text_of(name))
        .unwrap_or_else(|| data::Data::load(name).shown())
}

/// Returns the path of a file of the repository.
fn root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// Returns the text of a file of the repository.
fn read(path: &str) -> String {
    let text = std::fs::read_to_string(root(path));
    text.unwrap_or_else(|error| panic!("{path}: {error}")).replace("\r\n", "\n")
}

/// Returns the paths of the files in a folder of the repository whose names end with `ending`, in order.
fn files(folder: &str, ending: &str) -> BTreeSet<String> {
    let entries = std::fs::read_dir(root(folder)).unwrap_or_else(|e| panic!("{folder}: {e}"));
    let names = entries.map(|entry| entry.expect("an entry").file_name().into_string());
    let names = names.map(|name| name.expect("a name in Unicode"));
    names.filter(|name| name.ends_with(ending)).map(|name| format!("{folder}/{name}")).collect()
}

/// Writes each file that differs from the text that it should have, or with `check` writes nothing. Returns the faults that
/// remain.
pub fn run(check: bool) -> Vec<String> {
    let (mut faults, mut shown) = (Vec::new(), BTreeSet::new());
    let compare = |path: &str, found: &str, expected: &str| {
        if found != expected && !check {
            std::fs::write(root(path), expected).unwrap_or_else(|e| panic!("{path}: {e}"));
        }
        (found != expected && check).then(|| difference(path, found, expected))
    };
    for (path, text) in FILES {
        let found = if root(path).exists() { read(path) } else { String::new() };
        faults.extend(compare(path, &found, &text()));
    }
    // Pages show these files.
    if !faults.is_empty() {
        return faults;
    }
    let pages = ["docs", "docs/internals"].into_iter().flat_map(|folder| files(folder, ".md"));
    for path in MARKED.into_iter().map(String::from).chain(pages) {
        let found = read(&path);
        faults.extend(compare(&path, &found, &filled(&path, &found, &mut shown)));
    }
    let of_data = files("docs/data", ".tsv");
    let names = of_data.iter().map(|path| &path["docs/data/".len()..path.len() - ".tsv".len()]);
    let forgotten = names.chain(MARKS.map(|(name, _)| name)).filter(|name| !shown.contains(*name));
    faults.extend(forgotten.map(|name| format!("no page has the mark `{BEGIN}{name} -->`")));
    faults
}

/// Says where a file first differs from the text that it should have.
fn difference(path: &str, found: &str, expected: &str) -> String {
    let ended = std::iter::repeat("(end of the file)");
    let (found, made) = (found.split('\n').chain(ended.clone()), expected.split('\n').chain(ended));
    let mut lines = found.zip(made).zip(1..);
    let ((found, made), line) = lines.find(|((a, b), _)| a != b).expect("the texts differ");
    format!(
        "{path}:{line} is not as it is made; `cargo xtask pages` writes it\n  found: {found}\n  made:  {made}"
    )
}

const BEGIN: &str = "<!-- data: ";
const END: &str = "<!-- end -->";

/// Returns the text of a file with the text of each mark, and adds the names of the marks to `names`.
fn filled(path: &str, text: &str, names: &mut BTreeSet<String>) -> String {
    let (mut out, mut rest) = (String::new(), text);
    while let Some((before, after)) = rest.split_once(BEGIN) {
        let mark =
            after.split_once(" -->").and_then(|(name, after)| Some((name, after.split_once(END)?)));
        let (name, (old, after)) = mark.unwrap_or_else(|| panic!("{path}: a mark has no end"));
        out += before;
        // The beginning of the line, such as a comment's sign in Python.
        let start = out[out.rfind('\n').map_or(0, |at| at + 1)..].to_owned();
        out += &[BEGIN, name, " -->"].concat();
        if old.starts_with('\n') {
            out += &["\n", &text_of(name), &start].concat();
        } else {
            // A comment at the beginning of a line would end the paragraph.
            assert!(!start.trim().is_empty(), "{path}: {name} begins a line within a sentence");
            out += &text_of(name);
        }
        out += END;
        names.insert(name.into());
        rest = after;
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_are_up_to_date() {
        let faults = run(true);
        assert!(faults.is_empty(), "{}", faults.join("\n"));
    }

    #[test]
    fn a_difference_is_at_its_line() {
        let cases =
            [("a\nb\n", "a\nc\n", 2), ("a\n", "a", 2), ("", "a\n", 1), ("a\nb\n", "a\n", 2)];
        for (found, expected, line) in cases {
            let fault = difference("page.md", found, expected);
            assert!(fault.starts_with(&format!("page.md:{line} ")), "{fault}");
        }
    }

    #[test]
    fn text_between_marks_is_replaced() {
        let number = text_of("batched-ur5");
        let page = "It is <!-- data: batched-ur5 -->\nold\n<!-- end --> and <!-- data: batched-ur5 -->old<!-- end -->.\n";
        let expected =
            page.replacen("old\n", &format!("{number}It is "), 1).replace("old", &number);
        assert_eq!(filled("page.md", page, &mut BTreeSet::new()), expected);
    }
}
