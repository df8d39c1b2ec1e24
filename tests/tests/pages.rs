//! The pages: every link leads to a file and a heading, the book lists every page, and the README has at most 120
//! lines.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The Markdown files and notebooks of the repository's root, of `docs/` and of the folders with a README of their own.
fn pages() -> Vec<PathBuf> {
    const FOLDERS: [&str; 10] = [
        "",
        "docs",
        "docs/internals",
        "docs/notebooks",
        "lab/benches/peers",
        "modyn-jit",
        "modyn-python",
        "playground",
        "robots",
        "tests/golden",
    ];
    let paths = FOLDERS.into_iter().flat_map(|folder| {
        let entries = fs::read_dir(root().join(folder)).expect("a folder");
        entries.map(|entry| entry.expect("an entry").path())
    });
    let is_page =
        |path: &PathBuf| path.extension().is_some_and(|ending| ending == "md" || ending == "ipynb");
    let mut pages: Vec<PathBuf> = paths.filter(is_page).collect();
    pages.sort();
    assert!(pages.len() > 20, "{pages:?}");
    pages
}

/// Returns the text of a page in Markdown: of a notebook, that of its cells of text.
fn text_of(page: &Path) -> String {
    let text = fs::read_to_string(page).expect("a page");
    if page.extension().is_some_and(|ending| ending == "md") {
        return text;
    }
    let notebook: serde_json::Value = serde_json::from_str(&text).expect("a notebook");
    let cells = notebook["cells"].as_array().expect("cells").iter();
    let cells = cells.filter(|cell| cell["cell_type"] == "markdown");
    let lines = cells.flat_map(|cell| cell["source"].as_array().expect("lines"));
    lines.map(|line| line.as_str().expect("a line")).collect()
}

/// The text without code: neither fenced blocks nor spans between backticks.
fn prose(text: &str) -> String {
    let mut prose = String::new();
    let mut fenced = false;
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            for (i, span) in line.split('`').enumerate() {
                prose += if i % 2 == 0 { span } else { "code" };
            }
            prose.push('\n');
        }
    }
    prose
}

/// The targets of inline links and images.
fn links(prose: &str) -> Vec<&str> {
    let ends = prose.match_indices("](").map(|(at, _)| &prose[at + 2..]);
    ends.filter_map(|rest| rest.split_once(')').map(|(target, _)| target)).collect()
}

/// Returns the anchors of a page's headings, as GitHub and mdBook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut fenced = false;
    let headings = text.lines().filter(|line| {
        fenced ^= line.trim_start().starts_with("```");
        !fenced && line.starts_with('#')
    });
    let anchor = |heading: &str| {
        let title = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = title.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let mut broken = Vec::new();
    for page in pages() {
        for link in links(&prose(&text_of(&page))) {
            if link.contains("://") || link.starts_with("mailto:") {
                continue;
            }
            let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
            let folder = page.parent().expect("a file is in a folder");
            let target = if path.is_empty() { page.clone() } else { folder.join(path) };
            let found = match fs::read_to_string(&target) {
                Ok(text) => anchor.is_empty() || anchors(&text).contains(anchor),
                Err(_) => target.exists() && anchor.is_empty(),
            };
            if !found {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn the_book_lists_every_page_once() {
    let docs = root().join("docs");
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).expect("the book's contents");
    let mut listed: Vec<&str> = links(&summary);
    listed.sort_unstable();
    let names = |folder: &str| -> Vec<String> {
        let entries = fs::read_dir(docs.join(folder)).expect("docs");
        let names = entries.map(|entry| entry.expect("an entry").file_name());
        let names = names.map(|name| name.into_string().expect("a name in UTF-8"));
        let pages = names.filter(|name| name.ends_with(".md") && name != "SUMMARY.md");
        pages.map(|name| format!("{folder}{name}")).collect()
    };
    let guides = names("");
    assert!(guides.len() <= 21, "{} pages for users", guides.len());
    let mut pages = [guides, names("internals/")].concat();
    pages.sort();
    assert_eq!(listed, pages);
}

#[test]
fn the_readme_is_short() {
    let readme = fs::read_to_string(root().join("README.md")).expect("the README");
    assert!(readme.lines().count() <= 120);
}

/// `CITATION.cff` has the version of the crates, and the changelog has a section for that version with the same date.
#[test]
fn the_version_is_described() {
    let read = |name: &str| fs::read_to_string(root().join(name)).expect("a file");
    let value = |text: &str, start: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(start));
        line.unwrap_or_else(|| panic!("no {start:?}")).trim().trim_matches('"').to_owned()
    };
    let version = value(&read("Cargo.toml"), "version =");
    let citation = read("CITATION.cff");
    assert_eq!(value(&citation, "version:"), version);
    let section = format!("## [{version}] - {}", value(&citation, "date-released:"));
    assert!(read("CHANGELOG.md").lines().any(|line| line == section), "no {section:?}");
}
