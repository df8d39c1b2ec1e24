//! The folder of results: plots as SVG, and a page in HTML and Markdown that shows them.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::plot::Chart;

/// The error of writing the report.
pub type Failure = Box<dyn std::error::Error>;

/// A table.
#[derive(Clone, Debug)]
pub struct Table {
    /// The titles of the columns.
    pub head: Vec<String>,
    /// The rows, each with a cell for each column.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Returns a table with these titles and rows.
    #[must_use]
    pub fn new<H: ToString>(head: &[H], rows: Vec<Vec<String>>) -> Self {
        Self { head: head.iter().map(H::to_string).collect(), rows }
    }

    /// Returns the text of a file of `docs/data`: the command, the titles and the rows, with tabs between cells.
    #[must_use]
    pub fn data(&self) -> String {
        let mut text = String::from(
            "# command: UPDATE_SNAPSHOTS=1 cargo test --manifest-path lab/Cargo.toml data::\n",
        );
        for row in std::iter::once(&self.head).chain(&self.rows) {
            _ = writeln!(text, "{}", row.join("\t"));
        }
        text
    }
}

/// An element of the page.
enum Item {
    Heading(String),
    Text(String),
    Table(Table),
    Plot { file: String, title: String },
    Link { file: String, title: String },
}

/// The page.
pub struct Report {
    folder: PathBuf,
    items: Vec<Item>,
}

impl Report {
    /// Returns an empty page in that folder, which is made if it does not exist.
    ///
    /// # Errors
    ///
    /// If the folder cannot be made.
    pub fn new(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        Ok(Self { folder: folder.into(), items: Vec::new() })
    }

    /// Adds a heading.
    pub fn heading(&mut self, text: &str) {
        self.items.push(Item::Heading(text.into()));
    }

    /// Adds a paragraph.
    pub fn text(&mut self, text: impl Into<String>) {
        self.items.push(Item::Text(text.into()));
    }

    /// Adds a table.
    pub fn table(&mut self, table: Table) {
        self.items.push(Item::Table(table));
    }

    /// Adds a plot, and writes it to a file of this name.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn plot(&mut self, file: &str, chart: &Chart<'_>) -> Result<(), Failure> {
        chart.write(&self.folder.join(file))?;
        self.items.push(Item::Plot { file: file.into(), title: chart.title.into() });
        Ok(())
    }

    /// Adds another file, and a link to it.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn file(&mut self, file: &str, title: &str, content: &str) -> io::Result<()> {
        fs::write(self.folder.join(file), content)?;
        self.items.push(Item::Link { file: file.into(), title: title.into() });
        Ok(())
    }

    /// Writes the page, and returns the path of its HTML file.
    ///
    /// # Errors
    ///
    /// If a file cannot be written.
    pub fn write(&self) -> io::Result<PathBuf> {
        fs::write(self.folder.join("index.md"), self.markdown())?;
        let page = self.folder.join("index.html");
        fs::write(&page, self.html())?;
        Ok(page)
    }

    fn markdown(&self) -> String {
        let mut out = String::from("# The paper, reproduced\n");
        for item in &self.items {
            out.push('\n');
            let row = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
            match item {
                Item::Heading(text) => _ = writeln!(out, "## {text}"),
                Item::Text(text) => _ = writeln!(out, "{text}"),
                Item::Table(Table { head, rows }) => {
                    out += &row(head);
                    out += &row(&vec!["---".to_owned(); head.len()]);
                    rows.iter().for_each(|cells| out += &row(cells));
                }
                Item::Plot { file, title } => _ = writeln!(out, "![{title}]({file})"),
                Item::Link { file, title } => _ = writeln!(out, "[{title}]({file})"),
            }
        }
        out
    }

    fn html(&self) -> String {
        let mut out = String::from(
            "<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>The paper, reproduced</title>\n\
             <style>body{font-family:sans-serif;max-width:60em;margin:2em auto;padding:0 1em}\
             table{border-collapse:collapse;margin:1em 0}td,th{border:1px solid #aaa;padding:.2em .6em;\
             text-align:right;white-space:pre-wrap}td:first-child,th:first-child{text-align:left}img{max-width:100%}</style>\n\
             <h1>The paper, reproduced</h1>\n",
        );
        let escape = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
        for item in &self.items {
            let row = |cells: &[String], tag: &str| {
                let cells = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell)));
                format!("<tr>{}</tr>\n", cells.collect::<String>())
            };
            match item {
                Item::Heading(text) => _ = writeln!(out, "<h2>{}</h2>", escape(text)),
                Item::Text(text) => _ = writeln!(out, "<p>{}</p>", escape(text)),
                Item::Table(Table { head, rows }) => {
                    let rows: String = rows.iter().map(|cells| row(cells, "td")).collect();
                    _ = writeln!(out, "<table>\n{}{rows}</table>", row(head, "th"));
                }
                Item::Plot { file, title } => {
                    _ = writeln!(out, "<p><img src=\"{file}\" alt=\"{}\"></p>", escape(title));
                }
                Item::Link { file, title } => {
                    _ = writeln!(out, "<p><a href=\"{file}\">{}</a></p>", escape(title));
                }
            }
        }
        out + "</html>\n"
    }
}

/// Returns a number with this number of decimals.
#[must_use]
pub fn fixed(x: f64, decimals: usize) -> String {
    // Zero has no minus sign.
    let text = format!("{x:.decimals$}");
    if text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.')) {
        text.trim_start_matches('-').into()
    } else {
        text
    }
}

/// Returns a number with three digits and its power of ten.
#[must_use]
pub fn power(x: f64) -> String {
    format!("{x:.2e}")
}
