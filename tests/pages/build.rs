//! Copies the README and the pages of `docs/` for doc tests: paths of robots become absolute, since a reader runs the
//! examples in the root of the project.

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize()?;
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("no OUT_DIR")?);
    let mut pages = vec![root.join("README.md")];
    for folder in ["docs", "docs/internals"] {
        for entry in fs::read_dir(root.join(folder))? {
            pages.push(entry?.path());
        }
    }
    pages.retain(|page| page.extension().is_some_and(|extension| extension == "md"));
    pages.sort();

    println!("cargo::rerun-if-changed={}", root.join("docs").display());
    let robots = format!("\"{}/", root.join("robots").display());
    let mut modules = String::new();
    for page in pages {
        println!("cargo::rerun-if-changed={}", page.display());
        let name = page.file_stem().and_then(|name| name.to_str()).ok_or("a page's name")?;
        let mut text = fs::read_to_string(&page)?.replace("\"robots/", &robots);
        if name == "run-time" {
            text += &program(&text);
        }
        fs::write(out.join(name).with_extension("md"), text)?;
        let module = name.to_lowercase().replace('-', "_");
        writeln!(
            modules,
            "#[doc = include_str!(concat!(env!(\"OUT_DIR\"), \"/{name}.md\"))]\npub mod {module} {{}}"
        )?;
    }
    fs::write(out.join("pages.rs"), modules)?;
    Ok(())
}

/// Returns the blocks of a page that go on from one to the next, as one program. Files of other crates begin with their names.
fn program(page: &str) -> String {
    let blocks = page.split("```rust,ignore\n").skip(1);
    let blocks = blocks.filter_map(|rest| rest.split("```").next());
    let text: String = blocks.filter(|block| !block.starts_with("//")).collect();
    format!("\n```\n{text}\n# Ok::<(), Box<dyn std::error::Error>>(())\n```\n")
}
