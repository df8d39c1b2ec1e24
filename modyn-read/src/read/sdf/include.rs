//! Reads the file of an `<include>`.

use std::io::Read as _;
use std::path::{Component, Path, PathBuf};

use roxmltree::Node;

use super::reader::{Reader, trimmed};
use super::world::{Overrides, WORLD};
use super::{LAST_VERSION, version};
use crate::diagnostics::{Code, Severity};
use crate::read::file::read_named;
use crate::read::xml::document;
use crate::read::xml::element::{Elements, attribute};

/// The largest number of included files.
const MAX_FILES: usize = 1000;

/// The environment variables with folders of models.
const MODEL_PATHS: [&str; 4] =
    ["SDF_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "GAZEBO_MODEL_PATH"];

/// An included file whose model is read next.
struct OpenFile {
    text: String,
    /// The offset of the text in the texts of all files.
    start: usize,
    folder: Option<PathBuf>,
    overrides: Overrides,
}

impl<'a> Reader<'a, '_, '_, '_> {
    /// Reads an `<include>` as a model of a scope.
    #[inline(never)]
    pub fn include(&mut self, node: Node<'a, '_>, scope: usize, depth: usize) {
        let Some(file) = self.open_file(node, scope) else { return };
        let outer = std::mem::replace(&mut self.files.folder, file.folder);
        self.included(&file.text, file.start, scope, depth, file.overrides);
        self.files.open.pop();
        self.files.folder = outer;
    }

    /// Opens the file of an `<include>`. Its models are read in the stack of
    /// [`include`](Self::include), so this function is not a part of it.
    #[inline(never)]
    fn open_file(&mut self, node: Node<'a, '_>, scope: usize) -> Option<OpenFile> {
        let at = self.xml.at(node);
        let known = ["uri", "name", "static", "pose", "placement_frame", "plugin"];
        self.warn_of_unknown(node, &known, None);
        let Some(uri) =
            self.xml.single(node, "uri", None).map(|uri| trimmed(self.xml.content(uri)))
        else {
            let message = "`<include>` has no `<uri>`";
            let help = "write `<uri>model://arm</uri>`";
            self.xml.report.error(Code::MissingElement, at, None, message, help);
            return None;
        };
        let has_pose = self.xml.named(node, "pose").next().is_some();
        let pose = self.pose(node, None);
        let name = self.xml.single(node, "name", None).map(|name| trimmed(self.xml.content(name)));
        let element = self.xml.single(node, "placement_frame", None);
        let placement = element.map(|name| trimmed(self.xml.content(name)));
        let merge = self.xml.optional(node, "merge");
        let overrides = Overrides {
            name: name.filter(|name| !name.text.is_empty()),
            pose: has_pose.then_some(pose),
            placement: placement.filter(|name| !name.text.is_empty()),
            is_static: self.flag(node, "static", None),
            merge: merge.and_then(|text| self.truth(text, "merge", None)) == Some(true),
        };
        let path = match self.file_of(&uri.text) {
            Ok(path) => path,
            Err(help) => {
                let message = format!("`{}` is included, but not found", uri.text);
                // The ground and the sun of a world are often installed with a simulator.
                let severity = if scope == WORLD { Severity::Warning } else { Severity::Error };
                self.xml.report.add(severity, Code::Include, uri.at, None, message, help);
                return None;
            }
        };
        let full = self.options.files.canonical(&path);
        let problem = if self.files.open.contains(&full) {
            Some("the file includes itself".to_string())
        } else if self.files.count >= MAX_FILES {
            Some(format!("more than {MAX_FILES} files are included"))
        } else {
            None
        };
        if let Some(message) = problem {
            let help = "check where the file comes from: each model should include its parts only";
            self.xml.report.error(Code::Include, uri.at, None, message, help);
            return None;
        }
        self.files.count += 1;
        let shown = path.display().to_string();
        let file = read_named(&self.options.files, &path, &shown, uri.at, self.xml.report);
        let (text, start) = file?;
        let text = document::within_limits(&text, start, self.xml.report)?;
        let folder = path.parent().map(Path::to_owned);
        self.files.open.push(full);
        Some(OpenFile { text, start, folder, overrides })
    }

    /// Reads the model of an included file, which starts at the offset `start`.
    fn included(
        &mut self,
        text: &str,
        start: usize,
        scope: usize,
        depth: usize,
        overrides: Overrides,
    ) {
        let text = document::with_prefixes_in_names(text);
        let Some(document) = document::parse(&text, start, "sdf", self.xml.report) else { return };
        let root = document.root_element();
        if root.tag_name().name() != "sdf" {
            let message = format!("the root element is `<{}>`", root.tag_name().name());
            let help = "only files whose root element is `<sdf version=\"...\">` can be included";
            self.xml.report.error(Code::NotSdf, start + root.range().start, None, message, help);
            return;
        }
        let Some(version) = version(root, start, self.xml.report) else { return };
        let xml = Elements { root, start, report: &mut *self.xml.report };
        let unread = std::mem::take(&mut self.unread);
        let world = &mut *self.world;
        let files = &mut *self.files;
        let options = self.options;
        let mut reader = Reader { xml, world, files, options, version, unread };
        let models: Vec<_> = reader.xml.named(root, "model").collect();
        match models[..] {
            [model] => {
                reader.model(model, scope, depth + 1, overrides);
            }
            // A light of a world.
            [] if scope == WORLD => {}
            _ => {
                let message = format!("the file has {} models beside each other", models.len());
                let help = "include a file with one `<model>` and no `<world>`";
                let at = reader.xml.at(root);
                reader.xml.report.error(Code::SdfModel, at, None, message, help);
            }
        }
        self.unread = reader.unread;
    }

    /// Returns the path of the file that a URI names.
    ///
    /// # Errors
    ///
    /// Returns what to do if there is no such file.
    pub fn file_of(&mut self, uri: &str) -> Result<PathBuf, String> {
        let store = &self.options.files;
        let Some(folder) = self.files.folder.clone() else {
            return Err(
                "give the path of this file instead of its text, so that others can be found"
                    .into(),
            );
        };
        let (scheme, rest) = uri.split_once("://").unwrap_or(("", uri));
        let beside = folder.join(rest);
        let path = match scheme {
            "" | "file" if !rest.is_empty() && store.exists(&beside) => beside,
            "" | "file" | "model" | "package" => self.model_path(rest).ok_or_else(|| {
                format!(
                    "files are looked for beside this file, in the folders around the first file, \
                     and in the folders of \
                     the variable {}",
                    MODEL_PATHS[..2].join(" or ")
                )
            })?,
            _ => return Err("download the model, and write `model://` and its name".into()),
        };
        let place = if store.is_folder(&path) && !store.is_file(&path) {
            self.file_in(&path)
        } else {
            path
        };
        if store.is_file(&place) {
            Ok(place)
        } else {
            Err(format!("there is no file `{}`", place.display()))
        }
    }

    /// Returns the path that starts with the name of a model; `None` if there is no such model.
    fn model_path(&self, path: &str) -> Option<PathBuf> {
        let first = self.files.first.as_deref()?;
        // Other parts would leave the folders that are searched.
        if !Path::new(path).components().all(|part| matches!(part, Component::Normal(_))) {
            return None;
        }
        let absolute = std::path::absolute(first).unwrap_or_else(|_| first.into());
        // The folders around the file, whose names may be part of the path.
        let around = absolute.ancestors().map(Path::to_owned);
        let values = MODEL_PATHS.iter().filter_map(std::env::var_os);
        let of_variables: Vec<PathBuf> =
            values.flat_map(|value| std::env::split_paths(&value).collect::<Vec<_>>()).collect();
        let mut places = around.chain(of_variables).map(|folder| folder.join(path));
        places.find(|place| self.options.files.exists(place))
    }

    /// Returns the file of the model in a folder: by `model.config` its newest version that is
    /// read, else `model.sdf`.
    fn file_in(&mut self, folder: &Path) -> PathBuf {
        let default = folder.join("model.sdf");
        let config = folder.join("model.config");
        let mut text = String::new();
        let read = self.options.files.open(&config);
        let Ok(_) = read.and_then(|(_, mut file)| file.read_to_string(&mut text)) else {
            return default;
        };
        self.xml.report.depends_on(config);
        let Ok(document) = roxmltree::Document::parse(&text) else { return default };
        let versions = document.root_element().children().filter(|node| node.has_tag_name("sdf"));
        let newest = versions
            .filter_map(|node| {
                let version =
                    attribute(node, "version").map_or("1.2", |version| version.text.trim());
                let (_, minor) = version.split_once('.')?;
                let minor: u32 = minor.parse().ok()?;
                Some((minor, node.text()?.trim())).filter(|_| minor <= LAST_VERSION)
            })
            .max_by_key(|(minor, _)| *minor);
        newest.map_or(default, |(_, file)| folder.join(file))
    }
}
