//! Pages and files that are made: of the compiler's tables, and of the measured and counted tables
//! in `docs/data`.
//!
//! A file is made as a whole (`FILES`), or only between the marks `<!-- data: NAME -->` and
//! `<!-- end -->`. Measured tables come from the commands that their files name; each command
//! writes its file (`lab/record`).

mod chart;
mod data;
mod functions;
mod gallery;
mod measured;
mod operations;
mod options;
mod python;
mod rust;

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
const MARKED: [&str; 9] = [
    "README.md",
    "robots/README.md",
    "modyn-runtime/src/quantities/function.rs",
    "modyn-runtime/src/functions.rs",
    "modyn-runtime/src/robot/mod.rs",
    "tests/src/values.rs",
    "modyn-python/src/methods.rs",
    "modyn-python/python/modyn/_results.py",
    "modyn-python/python/modyn/_modyn.pyi",
];

/// The marks of texts that are made of the compiler's tables. The others show a file of
/// `docs/data`.
const MARKS: [(&str, Make); 20] = [
    ("calls-of-tests", rust::calls_of_tests),
    ("default-functions", rust::default_functions),
    ("default-functions-of-constraints", rust::default_functions_of_constraints),
    ("function-sentences", functions::sentences),
    ("function-table", functions::table),
    ("function-variants", rust::variants),
    ("functions-of-constraints-for-many-states", rust::functions_of_constraints_for_many_states),
    ("functions-of-many-states", rust::functions_of_many_states),
    ("functions-of-one-state", rust::functions_of_one_state),
    ("gallery", gallery::table_of_robots),
    ("option-table", options::whole),
    ("options-of-files", options::of_files),
    ("python-functions", python::method_stubs),
    ("python-methods", python::methods),
    ("python-options", python::option_stubs),
    ("python-results", python::results),
    ("robot-functions", rust::robot_functions),
    ("traits-of-constraints", rust::traits_of_constraints),
    ("traits-of-dynamics", rust::traits_of_dynamics),
    ("traits-of-kinematics", rust::traits_of_kinematics),
];

/// Returns the text of the mark `name`.
fn text_of(name: &str) -> String {
    let own = MARKS.iter().find(|(mark, _)| *mark == name).map(|(_, text)| text());
    own.or_else(|| operations::text_of(name))
        .or_else(|| measured::text_of(name))
        .unwrap_or_else(|| data::Data::load(name).shown())
}

/// Returns the path of a file of the repository.
pub(crate) fn root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// Returns the text of a file of the repository.
fn read(path: &str) -> String {
    let text = std::fs::read_to_string(root(path));
    text.unwrap_or_else(|error| panic!("{path}: {error}")).replace("\r\n", "\n")
}

/// Returns the paths of the files in a folder of the repository whose names end with `ending`, in
/// order.
fn files(folder: &str, ending: &str) -> BTreeSet<String> {
    let entries = std::fs::read_dir(root(folder)).unwrap_or_else(|e| panic!("{folder}: {e}"));
    let names = entries.map(|entry| entry.expect("an entry").file_name().into_string());
    let names = names.map(|name| name.expect("a name in Unicode"));
    names.filter(|name| name.ends_with(ending)).map(|name| format!("{folder}/{name}")).collect()
}

/// Writes each file that differs from the text that it should have, or with `check` writes nothing.
/// Returns the faults that remain.
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
        // A page shows a file of data, or links to it.
        let links = found.split("data/").filter_map(|rest| rest.split_once(".tsv)"));
        shown.extend(links.map(|(name, _)| name.to_owned()));
        faults.extend(compare(&path, &found, &filled(&path, &found, &mut shown)));
    }
    let of_data = files("docs/data", ".tsv");
    let names = of_data.iter().map(|path| &path["docs/data/".len()..path.len() - ".tsv".len()]);
    let forgotten = names.chain(MARKS.map(|(name, _)| name)).filter(|name| !shown.contains(*name));
    faults.extend(
        forgotten
            .map(|name| format!("no page links to `{name}` or has the mark `{BEGIN}{name} -->`")),
    );
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

/// Returns the text of a file without the texts between marks.
pub(crate) fn without_made_texts(text: &str) -> String {
    let mut parts = text.split(BEGIN);
    let first = parts.next();
    let others = parts.map(|part| part.split_once(END).map_or(part, |(_, after)| after));
    first.into_iter().chain(others).collect()
}

/// Returns the text of a file with the text of each mark, and adds the names of the marks to
/// `names`.
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

    /// Returns an attribute of a tag.
    fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
        tag.split_once(&format!(" {name}=\""))?.1.split('"').next()
    }

    /// Returns the luminance of a colour `#rrggbb`, from 0 of black to 1 of white.
    fn luminance(colour: &str) -> f64 {
        let number = u32::from_str_radix(colour.trim_start_matches('#'), 16).expect(colour);
        let linear = |shift: u32| {
            let part = f64::from(number >> shift & 0xff) / 255.0;
            if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(16) + 0.7152 * linear(8) + 0.0722 * linear(0)
    }

    #[test]
    fn figures_are_read_on_white_and_on_dark_grounds() {
        let folders = ["docs", "docs/figures", "docs/figures/robots"];
        let paths = folders.into_iter().flat_map(|folder| files(folder, ".svg"));
        let mut texts = 0;
        for path in paths {
            let figure = read(&path);
            let root = figure.split('>').next().expect("a tag");
            let (ink, width) = (attribute(root, "fill"), attribute(root, "width"));
            // A group that is moved has coordinates of its own.
            for part in figure.split("<g transform") {
                let mut boxes = Vec::new();
                for tag in part.split('<') {
                    let number = |name| attribute(tag, name).and_then(|x| x.parse::<f64>().ok());
                    let fill = attribute(tag, "fill").filter(|fill| *fill != "none");
                    if tag.starts_with("rect ") && fill.is_some() {
                        let is_ground = [width, Some("100%")].contains(&attribute(tag, "width"));
                        assert!(!is_ground, "{path} has a ground: {tag}");
                        let place = ["x", "y", "width", "height"].map(number);
                        boxes.push((place.map(|x| x.expect("a number")), fill));
                    } else if tag.starts_with("text ") {
                        let at = ["x", "y"].map(|name| number(name).expect("a number"));
                        let inside = |[x, y, width, height]: [f64; 4]| {
                            (x..x + width).contains(&at[0]) && (y..y + height).contains(&at[1])
                        };
                        let own = boxes.iter().rev().find(|(place, _)| inside(*place));
                        let grounds = match own {
                            Some((_, fill)) => [*fill; 2],
                            None => [Some("#ffffff"), Some("#0d1117")],
                        };
                        let of_text = luminance(fill.or(ink).unwrap_or("#000000"));
                        for ground in grounds.into_iter().flatten().map(luminance) {
                            let contrast =
                                (of_text.max(ground) + 0.05) / (of_text.min(ground) + 0.05);
                            assert!(
                                contrast > 3.0,
                                "{path} has a text that is hard to read: {tag}"
                            );
                        }
                        texts += 1;
                    }
                }
            }
        }
        assert!(texts > 300, "{texts}");
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
        assert_eq!(without_made_texts(page), "It is  and .\n");
    }
}
