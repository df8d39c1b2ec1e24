//! The modules of the compiler and of the runtime import each other in one direction only.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

type Imports = BTreeMap<String, BTreeSet<String>>;

/// Returns the top-level modules that each top-level module of a crate imports. Names that `lib.rs` re-exports belong to
/// the module that they come from. Comments and unit tests do not count.
fn imports(source: &Path) -> Imports {
    let root = std::fs::read_to_string(source.join("lib.rs")).expect("lib.rs");
    let entries = std::fs::read_dir(source).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").path());
    let modules: BTreeSet<String> =
        names.map(|path| path.file_stem().expect("a name").to_string_lossy().into()).collect();
    let mut exported: BTreeMap<&str, &str> = BTreeMap::new();
    for statement in root.split(';').filter_map(|part| part.split_once("pub use ")) {
        let path = statement.1.trim_start_matches("crate::");
        let module = path.split("::").next().unwrap_or_default();
        exported.extend(words(path).map(|name| (name, module)));
    }
    let mut imports = Imports::new();
    let mut folders = vec![source.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            if path.extension().is_none_or(|end| end != "rs") {
                continue;
            }
            let inside = path.strip_prefix(source).expect("inside");
            let first = inside.components().next().expect("a name").as_os_str().to_string_lossy();
            let module = first.trim_end_matches(".rs").to_string();
            let text = std::fs::read_to_string(&path).expect("a text");
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
            let code: Vec<&str> = lines.collect();
            for path in code.join("\n").split("crate::").skip(1) {
                let group = path.strip_prefix('{').and_then(|rest| rest.split('}').next());
                let names: Vec<&str> = match group {
                    Some(group) => group.split(',').filter_map(|one| words(one).next()).collect(),
                    None => words(path).next().into_iter().collect(),
                };
                for name in names {
                    let target =
                        if modules.contains(name) { Some(&name) } else { exported.get(name) };
                    if let Some(target) = target.filter(|target| **target != module) {
                        imports.entry(module.clone()).or_default().insert((*target).to_string());
                    }
                }
            }
        }
    }
    imports.remove("lib");
    imports
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

/// Returns the modules that can be reached from `module`.
fn reached(imports: &Imports, module: &str) -> BTreeSet<String> {
    let (mut reached, mut open) = (BTreeSet::new(), vec![module.to_string()]);
    while let Some(next) = open.pop() {
        for target in imports.get(&next).into_iter().flatten() {
            if reached.insert(target.clone()) {
                open.push(target.clone());
            }
        }
    }
    reached
}

/// Returns the modules that import themselves by way of others.
fn in_circles(imports: &Imports) -> Vec<&str> {
    let modules = imports.keys().filter(|module| reached(imports, module).contains(*module));
    modules.map(String::as_str).collect()
}

#[test]
fn no_modules_import_each_other() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let compiler = imports(&root.join("src"));
    assert!(compiler.len() > 10 && compiler["builder"].contains("emit"), "{compiler:?}");
    assert_eq!(in_circles(&compiler), [""; 0], "{compiler:?}");
    let runtime = imports(&root.join("../modyn-runtime/src"));
    assert!(runtime.len() > 10 && runtime["equations"].contains("mechanism"), "{runtime:?}");
    assert_eq!(in_circles(&runtime), [""; 0], "{runtime:?}");
}

#[test]
fn a_circle_is_found() {
    let one = |from: &str, to: &str| (from.to_string(), BTreeSet::from([to.to_string()]));
    let circle = Imports::from([one("a", "b"), one("b", "c"), one("c", "a"), one("d", "a")]);
    assert_eq!(in_circles(&circle), ["a", "b", "c"]);
}
