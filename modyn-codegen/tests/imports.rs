//! The modules of a crate import each other in one direction only, in each of its folders.
//!
//! A module and the modules inside of it are one: a child may use its parent's items. Comments, unit tests and the
//! tests' own modules do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The path of a module: the names from the crate's root to it.
type Place = Vec<String>;

/// For each folder the imports between its modules: for each module the siblings that it, or a module inside of it, uses.
type Imports = BTreeMap<Place, BTreeMap<String, BTreeSet<String>>>;

/// A name that a `use` brings into a module; `*` for all names.
struct Use {
    path: Vec<String>,
    name: String,
}

/// The modules of a crate.
#[derive(Default)]
struct Modules {
    tokens: BTreeMap<Place, Vec<String>>,
    uses: BTreeMap<Place, Vec<Use>>,
}

impl Modules {
    /// Returns the modules of these files: path without the ending, and text.
    fn new(files: impl IntoIterator<Item = (Place, String)>) -> Self {
        let mut modules = Self::default();
        for (mut place, text) in files {
            if matches!(place.last().map(String::as_str), Some("mod" | "lib" | "main")) {
                place.pop();
            }
            let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
            let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
            let tokens = tokens(&lines.collect::<Vec<_>>().join("\n"));
            let starts = tokens.iter().enumerate().filter(|(_, token)| *token == "use");
            let uses = starts.flat_map(|(i, _)| uses(&tokens, &mut (i + 1), &[])).collect();
            modules.uses.insert(place.clone(), uses);
            modules.tokens.insert(place, tokens);
        }
        modules
    }

    /// Returns the modules of the crate in this folder of sources.
    fn read(source: &Path) -> Self {
        let (mut files, mut folders) = (Vec::new(), vec![source.to_path_buf()]);
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).expect("a folder") {
                let path = entry.expect("an entry").path();
                if path.file_stem().is_some_and(|name| name == "tests") {
                    continue;
                } else if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|end| end == "rs") {
                    let inside = path.strip_prefix(source).expect("inside").with_extension("");
                    let place = inside.iter().map(|name| name.to_string_lossy().into()).collect();
                    files.push((place, std::fs::read_to_string(path).expect("a text")));
                }
            }
        }
        Self::new(files)
    }

    fn has(&self, place: &[String]) -> bool {
        self.tokens.keys().any(|known| known.starts_with(place))
    }

    /// Returns whether a module defines an item of this name itself.
    fn defines(&self, place: &[String], name: &str) -> bool {
        const KINDS: [&str; 7] = ["fn", "struct", "enum", "trait", "type", "const", "static"];
        let tokens = self.tokens.get(place).map_or(&[][..], Vec::as_slice);
        let is_item = |pair: &[String]| KINDS.contains(&&*pair[0]) && pair[1] == name;
        let is_macro = |three: &[String]| three[0] == "macro_rules" && three[2] == name;
        tokens.windows(2).any(is_item) || tokens.windows(3).any(is_macro)
    }

    /// Returns the module that defines the item at the end of `path`, as it is written in the module `from`; `None` for
    /// paths out of the crate. `depth` is the number of re-exports on the way.
    fn resolve(&self, from: &[String], path: &[String], depth: usize) -> Option<Place> {
        let (mut place, mut rest) = (from.to_vec(), path);
        match path.first().map(String::as_str) {
            Some("crate") => (place, rest) = (Place::new(), &path[1..]),
            Some("self") => rest = &path[1..],
            Some("super") => {
                while rest.first().is_some_and(|name| name == "super") {
                    place.pop();
                    rest = &rest[1..];
                }
            }
            Some(name) if self.has(&[from, &[name.into()]].concat()) => {}
            _ => return None,
        }
        while let Some(name) = rest.first() {
            let child = [&place[..], std::slice::from_ref(name)].concat();
            if self.has(&child) {
                (place, rest) = (child, &rest[1..]);
                continue;
            }
            let uses = || self.uses.get(&place).into_iter().flatten().filter(|_| depth < 9);
            if name == "*" || self.defines(&place, name) {
                break;
            }
            let mut named = uses().filter(|one| one.name == *name);
            let all = uses().filter(|one| one.name == "*");
            let found = named.find_map(|one| self.resolve(&place, &one.path, depth + 1));
            return found.or_else(|| {
                all.filter_map(|one| self.resolve(&place, &one.path, depth + 1))
                    .filter(|target| *target != place)
                    .find_map(|target| {
                        let inside = [vec!["self".to_string()], rest.to_vec()].concat();
                        self.resolve(&target, &inside, depth + 1)
                            .filter(|found| self.defines(found, name))
                    })
            });
        }
        Some(place)
    }

    /// Returns the imports between the modules of each folder.
    fn imports(&self) -> Imports {
        let mut imports = Imports::new();
        for (from, tokens) in &self.tokens {
            let starts = tokens.iter().enumerate().filter(|(i, token)| {
                let is_start = *i == 0 || tokens[i - 1] != "::";
                is_start && matches!(token.as_str(), "crate" | "super" | "self")
            });
            let inline = starts.flat_map(|(i, _)| uses(tokens, &mut i.clone(), &[]));
            let imported = self.uses[from].iter().map(|one| one.path.clone());
            for path in imported.chain(inline.map(|one| one.path)) {
                let Some(target) = self.resolve(from, &path, 0) else { continue };
                let common = from.iter().zip(&target).take_while(|(a, b)| a == b).count();
                // Otherwise one is inside the other.
                if let (Some(importer), Some(imported)) = (from.get(common), target.get(common)) {
                    let folder = imports.entry(from[..common].to_vec()).or_default();
                    folder.entry(importer.clone()).or_default().insert(imported.clone());
                }
            }
        }
        imports
    }
}

/// Returns the words and symbols of a text.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut last = ' ';
    for c in text.chars() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        match tokens.last_mut() {
            Some(token) if is_word(c) && is_word(last) || (c == ':' && token == ":") => {
                token.push(c);
            }
            _ if c.is_whitespace() => {}
            _ => tokens.push(c.into()),
        }
        last = c;
    }
    tokens
}

/// Returns the paths of the tree that starts at `at`, with `prefix` before each, and moves `at` to its end.
fn uses(tokens: &[String], at: &mut usize, prefix: &[String]) -> Vec<Use> {
    let token = |at: usize| tokens.get(at).map_or("", String::as_str);
    let mut path = prefix.to_vec();
    loop {
        match token(*at) {
            "{" => {
                let mut all = Vec::new();
                while matches!(token(*at), "{" | ",") {
                    *at += 1;
                    if token(*at) != "}" {
                        all.extend(uses(tokens, at, &path));
                    }
                }
                *at += 1;
                return all;
            }
            word if word == "*" || word.starts_with(|c: char| c.is_alphabetic() || c == '_') => {
                path.push(word.into());
                *at += 1;
            }
            _ => break,
        }
        if token(*at) != "::" {
            break;
        }
        *at += 1;
    }
    // `a::{self}` is the module `a`.
    path.pop_if(|name| name == "self" && !prefix.is_empty());
    let mut name = path.last().cloned().unwrap_or_default();
    if token(*at) == "as" {
        name = token(*at + 1).into();
        *at += 2;
    }
    vec![Use { path, name }]
}

/// Returns the modules that import themselves by way of siblings: each as its path.
fn in_circles(imports: &Imports) -> Vec<String> {
    let mut found = Vec::new();
    for (folder, siblings) in imports {
        for module in siblings.keys() {
            let (mut reached, mut open) = (BTreeSet::new(), vec![module]);
            while let Some(next) = open.pop() {
                let targets = siblings.get(next).into_iter().flatten();
                open.extend(targets.filter(|target| reached.insert(*target)));
            }
            if reached.contains(module) {
                found.push([&folder[..], std::slice::from_ref(module)].concat().join("/"));
            }
        }
    }
    found
}

/// Returns the imports of a crate beside this one.
fn imports_of(name: &str) -> Imports {
    Modules::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).join("src"))
        .imports()
}

#[test]
fn no_modules_import_each_other() {
    // An import of each crate shows that imports are found, also through re-exports.
    let crates = [
        ("modyn-read", "", "assemble", "check"),
        ("modyn-read", "read", "mjcf", "xml"),
        ("modyn-codegen", "", "builder", "emit"),
        ("modyn-codegen", "plan", "packing", "fused"),
        ("modyn-runtime", "", "equations", "mechanism"),
        ("modyn-runtime", "scalar", "portable", "traits"),
        ("modyn-jit", "", "compiled", "call"),
        ("modyn-cli", "", "command", "escape"),
        ("modyn-gpu", "", "array", "processor"),
        ("modyn-python", "", "function", "change"),
    ];
    for (name, folder, importer, imported) in crates {
        let imports = imports_of(name);
        let place: Place = folder.split('/').filter(|s| !s.is_empty()).map(Into::into).collect();
        assert!(imports[&place][importer].contains(imported), "{name}: {imports:#?}");
        assert_eq!(in_circles(&imports), [""; 0], "{name}: {imports:#?}");
    }
}

#[test]
fn a_circle_is_found() {
    let file = |path: &str, text: &str| {
        let place = path.split('/').map(Into::into).collect::<Place>();
        (place, text.to_string())
    };
    let files = [
        file("lib", "mod a; mod b; pub use a::A; pub use b::B;"),
        file("a", "use crate::{B, b::{self, D as E}}; pub struct A;"),
        file("b/mod", "mod c; mod d; mod e; pub use c::*; pub use d::D;"),
        file("b/c", "pub struct B; fn f() { super::d::g() }"),
        file("b/d", "use super::B; pub struct D; pub fn g() {}"),
        // Neither the parent's items nor a name that differs from a module's are imports of siblings.
        file(
            "b/e",
            "use super::{h, D}; use crate::A; #[cfg(test)]\nmod tests { use super::super::d; }",
        ),
    ];
    let imports = Modules::new(files).imports();
    let siblings = |place: &[&str]| {
        let place: Place = place.iter().map(|&name| name.into()).collect();
        imports[&place]
            .iter()
            .map(|(from, to)| (from.as_str(), to.iter().map(String::as_str)))
            .map(|(from, to)| format!("{from} > {}", to.collect::<Vec<_>>().join(" ")))
            .collect::<Vec<_>>()
    };
    assert_eq!(siblings(&[]), ["a > b", "b > a"]);
    assert_eq!(siblings(&["b"]), ["c > d", "d > c", "e > d"]);
    assert_eq!(in_circles(&imports), ["a", "b", "b/c", "b/d"]);
}
