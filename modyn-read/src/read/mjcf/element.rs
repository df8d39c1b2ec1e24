//! The elements of a model, with the elements of included files in place of each `<include>`.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use roxmltree::Node;

use crate::description::FileStore;
use crate::diagnostics::{Code, Report};
use crate::read::file::read_named;
use crate::read::xml;
use crate::work::counted;

/// The largest nesting depth: deeper trees could overflow the call stack of a recursive reader.
pub const MAX_DEPTH: usize = 100;

/// An element with the elements in it.
pub struct Element {
    pub name: String,
    /// The byte offset.
    pub at: usize,
    pub attributes: Vec<Attribute>,
    pub children: Vec<Element>,
}

/// An attribute of an element.
pub struct Attribute {
    pub name: String,
    pub value: String,
    /// The byte offset.
    pub at: usize,
    /// The byte offset of the value.
    pub value_at: usize,
    /// Whether the value has no entities, so that the offset of a part of it is that in the file.
    pub literal: bool,
}

impl Element {
    /// Returns the attribute of this name.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        counted(self.attributes.iter()).find(|attribute| attribute.name == name)
    }

    /// Returns the text of an attribute.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.attribute(name).map(|attribute| attribute.value.as_str())
    }

    /// Returns the children of this name.
    pub fn named<'e>(&'e self, name: &'e str) -> impl Iterator<Item = &'e Element> {
        counted(self.children.iter()).filter(move |child| child.name == name)
    }

    /// Returns the grandchildren in all children of this name: a section may be repeated.
    pub fn in_sections<'e>(&'e self, name: &'e str) -> impl Iterator<Item = &'e Element> {
        self.named(name).flat_map(|section| counted(section.children.iter()))
    }
}

/// A file of a model: its place on the disk and in diagnostics.
pub struct File<'p> {
    /// The folder; `None` if no other file is read.
    pub folder: Option<&'p Path>,
    /// The file's name in diagnostics.
    pub shown: &'p str,
    /// The place from which files are read.
    pub store: &'p FileStore,
}

/// Reads elements from the text of a model's main file, and from the files that it includes.
pub struct Elements<'r, 'f> {
    /// The folder of the main file, in which other files are looked for first.
    folder: Option<PathBuf>,
    /// The files that were included: a file can be included once.
    included: BTreeSet<PathBuf>,
    /// The start of each included file and its folder.
    folders: Vec<(usize, PathBuf)>,
    store: &'r FileStore,
    report: &'r mut Report<'f>,
}

impl<'r, 'f> Elements<'r, 'f> {
    /// Returns the root element of the main file, whose text starts at offset `start`, and the
    /// start and the folder of each included file; `None` with an error in the report.
    pub fn read(
        text: &str,
        start: usize,
        file: &File<'r>,
        report: &'r mut Report<'f>,
    ) -> Option<(Element, Vec<(usize, PathBuf)>)> {
        let folder = file.folder.map(Path::to_owned);
        let included = BTreeSet::new();
        let folders = Vec::new();
        let mut elements = Elements { folder, included, folders, store: file.store, report };
        let root = elements.document(text, start, file, 0)?;
        Some((root, elements.folders))
    }

    fn document(&mut self, text: &str, start: usize, file: &File, depth: usize) -> Option<Element> {
        let text = xml::document::within_limits(text, start, self.report)?;
        let document = xml::document::parse(&text, start, "mujoco", self.report)?;
        self.element(document.root_element(), &text, start, file, depth)
    }

    /// Returns an element; `None` with an error in the report.
    fn element(
        &mut self,
        node: Node,
        text: &str,
        start: usize,
        file: &File,
        depth: usize,
    ) -> Option<Element> {
        let at = start + node.range().start;
        if depth > MAX_DEPTH {
            let message = format!("elements are nested more than {MAX_DEPTH} deep");
            let help = "make the tree less deep, or use URDF for long chains";
            self.report.error(Code::NotRead, at, None, message, help);
            return None;
        }
        let attribute = |attribute: roxmltree::Attribute| Attribute {
            name: attribute.name().into(),
            value: attribute.value().into(),
            at: start + attribute.range().start,
            value_at: start + attribute.range_value().start,
            literal: text[attribute.range_value()] == *attribute.value(),
        };
        let mut element = Element {
            name: node.tag_name().name().into(),
            at,
            attributes: node.attributes().map(attribute).collect(),
            children: Vec::new(),
        };
        for child in xml::element::children(node).filter(Node::is_element) {
            let child = self.element(child, text, start, file, depth + 1)?;
            if child.name == "include" {
                element.children.extend(self.include(&child, file, depth)?);
            } else {
                element.children.push(child);
            }
        }
        Some(element)
    }

    /// Returns the elements of an included file; `None` with an error in the report.
    fn include(&mut self, include: &Element, file: &File, depth: usize) -> Option<Vec<Element>> {
        let mut error = |message: String, help: &str| {
            self.report.error(Code::Include, include.at, None, message, help);
            None
        };
        let name = include.text("file").map(str::trim).filter(|name| !name.is_empty());
        let Some(name) = name else {
            return error("`<include>` has no `file`".into(), "write `<include file=\"...\"/>`");
        };
        if !include.children.is_empty() {
            return error(
                "`<include>` has elements in it".into(),
                "write `<include file=\"...\"/>`",
            );
        }
        let path = path_of(name);
        if path.is_absolute() {
            let help = "write a path relative to the folder of the model";
            return error(format!("the path `{name}` of an included file is absolute"), help);
        }
        let Some(main) = &self.folder else {
            let help = "read the model from a file, or set its folder: `Builder::folder`, `ReadOptions::folder`";
            return error(
                format!("`{name}` is not read, since the folder of this text is unknown"),
                help,
            );
        };
        // MuJoCo looks in the folder of the main file first, then beside the file that has the
        // `<include>`.
        let beside = file.folder.unwrap_or(main);
        let place = [main.join(&path), beside.join(&path)];
        let existing = place.iter().find(|place| self.store.is_file(place)).unwrap_or(&place[1]);
        let place = self.store.named(normalized(existing));
        if !self.included.insert(place.clone()) {
            let help = "include each file once; what several parts need belongs into a class or a model for `<attach>`";
            return error(format!("`{name}` is included twice"), help);
        }
        let parent = Path::new(file.shown).parent().unwrap_or(Path::new(""));
        let shown = normalized(&parent.join(&path)).display().to_string();
        let (text, start) = read_named(self.store, &place, &shown, include.at, self.report)?;
        self.folders.push((start, place.parent().map(Path::to_owned).unwrap_or_default()));
        let file = File { folder: place.parent(), shown: &shown, store: self.store };
        // The root of an included file has any name, and its children take the place of
        // `<include>`.
        let root = self.document(&text, start, &file, depth)?;
        Some(root.children)
    }
}

/// Returns a path of a description, which may have separators of Windows.
pub fn path_of(text: &str) -> PathBuf {
    PathBuf::from(text.trim().replace('\\', "/"))
}

/// Returns a path without `.` and without names before `..`.
pub fn normalized(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(normal.components().next_back(), Some(Component::Normal(_))) =>
            {
                normal.pop();
            }
            other => normal.push(other),
        }
    }
    normal
}

/// Returns the name of a file without its folder and its extension.
pub fn stem(file: &str) -> String {
    path_of(file).file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}
