//! The files of a model: its main file, and the files of models that it attaches.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use super::check::check;
use super::classes::Classes;
use super::element::{Element, Elements, File, normalized, path_of, stem};
use super::settings::Settings;
use crate::description::{FileStore, ReadOptions};
use crate::diagnostics::{Code, Report};
use crate::read::file::read_named;

/// The elements of a model, read from its file.
pub struct Source {
    pub root: Element,
    /// The folder of the file; `None` if no other file is read.
    pub folder: Option<PathBuf>,
    /// The place from which other files are read.
    pub store: FileStore,
    /// The names of the models that it can attach, and their indices.
    models: BTreeMap<String, usize>,
    /// The start of each included file and its folder.
    folders: Vec<(usize, PathBuf)>,
}

impl Source {
    /// Returns the folder of the included file that has the element at this place; `None` for the
    /// main file.
    pub fn include_folder(&self, at: usize) -> Option<&Path> {
        let before = self.folders.partition_point(|(start, _)| *start <= at);
        self.folders[..before].last().map(|(_, folder)| folder.as_path())
    }
}

/// The largest number of models.
const MAX_MODELS: usize = 1000;

/// Returns the model of the text, whose file has the name `shown`, and all models that it can
/// attach, in any order; `None` with an error in the report.
pub fn read(
    text: &str,
    options: &ReadOptions,
    shown: &str,
    report: &mut Report<'_>,
) -> Option<Vec<Source>> {
    let folder = options.folder.as_deref();
    let store = &options.files;
    let (root, folders) = Elements::read(text, 0, &File { folder, shown, store }, report)?;
    let mut files = vec![(shown.to_owned(), None)];
    let mut sources = vec![source(root, folders, folder, store)];
    let mut next = 0;
    while next < sources.len() {
        for (name, file, at) in assets(&sources[next], report) {
            let Some(folder) = sources[next].folder.clone() else {
                let message = format!(
                    "`{}` is not read, since the folder of this text is unknown",
                    file.display()
                );
                let help = "read the model from a file, or set its folder: `Builder::folder`, `ReadOptions::folder`";
                report.error(Code::Include, at, None, message, help);
                continue;
            };
            let place = store.named(normalized(&folder.join(&file)));
            let known = files.iter().position(|(_, path)| path.as_ref() == Some(&place));
            let index = match known {
                Some(index) => index,
                None if files.len() == MAX_MODELS => {
                    let help = "attach fewer models";
                    report.error(
                        Code::Excessive,
                        at,
                        None,
                        format!("more than {MAX_MODELS} models"),
                        help,
                    );
                    return None;
                }
                None => {
                    let parent =
                        Path::new(&files[next].0).parent().unwrap_or(Path::new("")).join(&file);
                    let shown = normalized(&parent).display().to_string();
                    let (text, start) = read_named(store, &place, &shown, at, report)?;
                    let file = File { folder: place.parent(), shown: &shown, store };
                    let (root, folders) = Elements::read(&text, start, &file, report)?;
                    sources.push(source(root, folders, place.parent(), store));
                    files.push((shown, Some(place)));
                    sources.len() - 1
                }
            };
            let own_name = sources[index].root.text("model").map(str::to_owned);
            let name = name.or(own_name).unwrap_or_default();
            sources[next].models.insert(name, index);
        }
        next += 1;
    }
    Some(sources)
}

fn source(
    root: Element,
    folders: Vec<(usize, PathBuf)>,
    folder: Option<&Path>,
    store: &FileStore,
) -> Source {
    let folder = folder.map(Path::to_owned);
    let store = store.clone();
    Source { root, folder, store, models: BTreeMap::new(), folders }
}

/// Returns the name, the file relative to the folder, and the place of each model that a model can
/// attach.
fn assets(source: &Source, report: &mut Report<'_>) -> Vec<(Option<String>, PathBuf, usize)> {
    let compiler = |name| source.root.named("compiler").filter_map(|one| one.text(name)).last();
    let folder = path_of(compiler("assetdir").unwrap_or(""));
    let models = source.root.in_sections("asset").filter(|asset| asset.name == "model");
    let asset = |model: &Element| {
        let file = model.text("file").map(path_of).filter(|file| file.is_relative());
        if file.is_none() {
            let help =
                "write `<model file=\"...\"/>` with a path relative to the folder of the model";
            report.error(Code::Include, model.at, None, "a model has no relative `file`", help);
        }
        Some((model.text("name").map(str::to_owned), folder.join(file?), model.at))
    };
    models.filter_map(asset).collect()
}

/// A model with its classes and settings.
pub struct Model<'e> {
    pub source: &'e Source,
    pub classes: Classes<'e>,
    pub settings: Settings<'e>,
    /// The places of elements with errors, which are in the report.
    unsound: BTreeSet<usize>,
    /// The elements of `<asset>` by their kind and name.
    assets: HashMap<(&'e str, String), &'e Element>,
}

impl<'e> Model<'e> {
    /// Returns the model of a source, whose errors are in the report.
    pub fn new(source: &'e Source, report: &mut Report<'_>) -> Self {
        let mut unsound = BTreeSet::new();
        check(&source.root, &mut unsound, report);
        let classes = Classes::new(&source.root, report);
        let settings = Settings::new(&source.root, report);
        let mut assets = HashMap::new();
        for asset in source.root.in_sections("asset") {
            let stem = || asset.text("file").map(stem);
            if let Some(name) = asset.text("name").map(str::to_owned).or_else(stem) {
                // The first of equal names counts.
                assets.entry((asset.name.as_str(), name)).or_insert(asset);
            }
        }
        Self { source, classes, settings, unsound, assets }
    }

    /// Returns whether the elements have no errors.
    pub fn is_sound(&self, elements: &[&Element]) -> bool {
        elements.iter().all(|element| !self.unsound.contains(&element.at))
    }

    /// Returns the element of `<asset>` of a kind, such as `mesh`, by its name or else by the name
    /// of its file.
    pub fn asset(&self, kind: &'e str, name: &str) -> Option<&'e Element> {
        self.assets.get(&(kind, name.to_owned())).copied()
    }

    /// Returns the index of the model that is attached by this name.
    pub fn attached(&self, name: &str) -> Option<usize> {
        self.source.models.get(name).copied()
    }
}
