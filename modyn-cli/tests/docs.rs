//! The commands that the documentation shows, run as they stand there.
#![cfg(feature = "command")]

mod common;

use std::path::Path;

use common::{command, root, run};

/// The lines of all blocks of commands in a page that begin with `modyn`, without remarks.
fn commands(page: &str) -> Vec<String> {
    let mut found = Vec::new();
    for block in page.split("```console\n").skip(1) {
        let block = block.split("```").next().unwrap_or_default().replace("\\\n", " ");
        let lines = block.lines().map(|line| line.split(" #").next().unwrap_or_default().trim());
        found.extend(lines.filter(|line| line.starts_with("modyn ")).map(String::from));
    }
    found
}

#[test]
fn commands_in_the_documentation_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let robots = folder.path().join("robots");
    std::fs::create_dir(&robots).expect("a folder");
    std::fs::create_dir(folder.path().join("src")).expect("a folder");
    let mut names = Vec::new();
    for entry in std::fs::read_dir(root().join("robots")).expect("robots") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        std::fs::copy(&path, robots.join(&name)).expect("a copy");
        names.push(format!("robots/{name}"));
    }
    let mut pages = vec![root().join("README.md")];
    let docs = std::fs::read_dir(root().join("docs")).expect("docs");
    let docs = docs.map(|entry| entry.expect("an entry").path());
    pages.extend(docs.filter(|path| path.extension().is_some_and(|end| end == "md")));
    let mut count = 0;
    for page in &pages {
        for line in commands(&std::fs::read_to_string(page).expect("a page")) {
            let mut arguments: Vec<&str> = line.split_whitespace().skip(1).collect();
            if let Some(at) = arguments.iter().position(|one| *one == "robots/*.urdf") {
                // As a shell does.
                let urdf =
                    |one: &&String| Path::new(one).extension().is_some_and(|end| end == "urdf");
                arguments.splice(at..=at, names.iter().filter(urdf).map(String::as_str));
            }
            let mut shown = command(&arguments);
            shown.current_dir(folder.path());
            let found = run(shown);
            assert_eq!(found.code, 0, "{}: {line}\n{}{}", page.display(), found.out, found.err);
            count += 1;
        }
    }
    assert!(count >= 15, "only {count} commands were found");
}
