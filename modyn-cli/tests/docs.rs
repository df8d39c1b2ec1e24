//! The commands of the documentation run as they are printed.
#![cfg(feature = "command")]

use crate::common;

use std::path::{Path, PathBuf};

use common::{command, root, run};

/// Returns the commands `modyn` of a page, without comments: the lines of its command blocks, and the
/// commands in its sentences that name a robot of the repository.
fn commands(page: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (number, part) in page.split("```").enumerate() {
        if number % 2 == 0 {
            let spans =
                quoted(part).map(|span| span.split_whitespace().collect::<Vec<_>>().join(" "));
            found.extend(spans.filter(|span| span.contains("robots/")));
        } else if let Some(block) = part.strip_prefix("console\n") {
            let block = block.replace("\\\n", " ");
            let lines = block.lines().map(|line| line.split(" #").next().unwrap_or_default());
            found.extend(lines.map(|line| line.trim().to_owned()));
        }
    }
    found.retain(|line| line.starts_with("modyn "));
    found
}

/// Returns the arguments of a command, as a shell splits them.
fn arguments(line: &str) -> Vec<&str> {
    let mut words = Vec::new();
    for (number, part) in line.split('\'').enumerate() {
        match number % 2 {
            0 => words.extend(part.split_whitespace()),
            _ => words.push(part),
        }
    }
    words.split_off(1)
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
    pages.extend(guides());
    let mut count = 0;
    for page in &pages {
        for line in commands(&std::fs::read_to_string(page).expect("a page")) {
            let mut arguments = arguments(&line);
            if let Some(at) = arguments.iter().position(|one| *one == "robots/*.urdf") {
                // A shell would do the same.
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

/// Returns the pages of `docs` and `docs/internals`.
fn guides() -> Vec<PathBuf> {
    let folders = ["docs", "docs/internals"].map(|folder| root().join(folder));
    let entries = folders.into_iter().flat_map(|folder| std::fs::read_dir(folder).expect("docs"));
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths.filter(|path| path.extension().is_some_and(|end| end == "md")).collect()
}

/// The first block of `language` in a page from `start` on.
fn block<'a>(page: &'a str, start: &str, language: &str) -> &'a str {
    let (_, rest) = page.split_once(start).unwrap_or_else(|| panic!("no {start:?}"));
    let (_, rest) = rest.split_once(&format!("```{language}\n")).expect("a block");
    rest.split_once("```").expect("its end").0
}

/// The C program of the firmware guide prints what the page says.
#[test]
fn the_c_program_runs() {
    let page = std::fs::read_to_string(root().join("docs/firmware.md")).expect("a page");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("robots")).expect("a folder");
    let robot = "robots/arm7.urdf";
    std::fs::copy(root().join(robot), folder.path().join(robot)).expect("a copy");
    let generate =
        block(&page, "## In C", "console").split_whitespace().skip(1).collect::<Vec<_>>();
    let mut generate = command(&generate);
    generate.current_dir(folder.path());
    assert_eq!(run(generate).code, 0);
    std::fs::write(folder.path().join("main.c"), block(&page, "## In C", "c")).expect("writes");
    let build = block(&page, "```c\n", "console");
    let mut build_and_run = std::process::Command::new("sh");
    build_and_run.args(["-c", &format!("set -e; {build}")]).current_dir(folder.path());
    let output = build_and_run.output().expect("a shell");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(text(&output.stdout), block(&page, "```c\n", "text"));
}

/// Returns the texts in backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// Adds the paths of the files in a folder and its subfolders, without those of builds.
fn collect_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if !path.is_dir() {
            files.push(path);
        } else if !path.ends_with("target") {
            collect_files(&path, files);
        }
    }
}

#[test]
fn the_page_on_extending_names_existing_places() {
    let page = std::fs::read_to_string(root().join("docs/internals/extending.md")).expect("a page");
    let mut rows = 0;
    for line in page.lines().filter(|line| line.starts_with("| `")) {
        let (_, rest) = line.split_once("| ").expect("a row");
        let (file, what) = rest.split_once(" | ").expect("two cells");
        let path = quoted(file).next().expect("a file");
        let text = std::fs::read_to_string(root().join(path)).unwrap_or_else(|_| panic!("{path}"));
        for word in quoted(what) {
            // Names of folders and files exist; other words occur in the file.
            let found = text.contains(word) || root().join(word).exists();
            assert!(found || ["bad", "good"].contains(&word), "{path} has no {word}");
        }
        rows += 1;
    }
    assert!(rows > 30, "{rows}");
    // The target of each link exists.
    let others = ["README.md", "ARCHITECTURE.md"].map(|page| root().join(page));
    for page in others.into_iter().chain(guides()) {
        let text = std::fs::read_to_string(&page).expect("a page");
        let folder = page.parent().expect("a folder").to_owned();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = link.split('#').next().unwrap_or_default();
            if !link.contains("://") && !file.is_empty() && !file.contains(char::is_whitespace) {
                assert!(folder.join(file).exists(), "{}: {link}", page.display());
            }
        }
    }
}

#[test]
fn the_map_of_the_code_names_existing_places() {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("a page");
    let mut folders: Vec<PathBuf> = Vec::new();
    let mut places = 0;
    for line in block(&page, "## Where things are", "text").lines() {
        let text = line.trim_start();
        let depth = (line.len() - text.len()) / 2;
        // Further lines of a description are indented by more than any place.
        if depth > 2 {
            continue;
        }
        let name = text.split(' ').next().expect("a name");
        folders.truncate(depth);
        let folder = folders.last().cloned().unwrap_or_else(root);
        let mut candidates = [folder.join(name), folder.join("src").join(name)].into_iter();
        folders.push(candidates.find(|path| path.exists()).unwrap_or_else(|| panic!("{line}")));
        places += 1;
    }
    assert!(places > 30, "{places}");
    let mut files = Vec::new();
    let crates = ["cli", "codegen", "gpu", "jit", "macro", "python", "read", "runtime"];
    let crates = crates.map(|name| root().join(format!("modyn-{name}")));
    let others = ["src", "lab", "playground", "tests"].map(|name| root().join(name));
    for folder in crates.iter().chain(&others) {
        collect_files(folder, &mut files);
    }
    let words = page.split(|c: char| !c.is_alphanumeric() && !"_-./".contains(c));
    for word in words.filter(|word| word.ends_with(".rs")) {
        assert!(files.iter().any(|file| file.ends_with(word)), "there is no file {word}");
    }
}
