//! The pages of `docs/` as modules for rustdoc.

use std::fmt::Write as _;
use std::path::Path;
use std::{fs, io};

/// Returns a module for each Markdown page of a folder, documented by the page.
pub(crate) fn modules(folder: &Path) -> io::Result<String> {
    let mut pages = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let stem = path.file_stem().and_then(|stem| stem.to_str());
        if let (Some(stem), Some("md")) = (stem, path.extension().and_then(|end| end.to_str())) {
            pages.push((module_name(stem), path.clone()));
        }
    }
    pages.sort();
    let mut modules = String::new();
    for (name, path) in pages.iter().filter(|(name, _)| name != "summary") {
        let text = linked(&fs::read_to_string(path)?);
        let _ = writeln!(modules, "#[doc = {text:?}] pub mod {name} {{}}");
    }
    Ok(modules)
}

fn module_name(stem: &str) -> String {
    stem.to_lowercase().replace('-', "_")
}

/// Returns a page whose links to other pages lead to their modules. Links to other files of the
/// repository become text.
fn linked(page: &str) -> String {
    let mut out = String::with_capacity(page.len());
    let mut rest = page;
    while let Some((before, (target, after))) =
        rest.split_once("](").and_then(|(before, link)| Some((before, link.split_once(')')?)))
    {
        out += before;
        let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
        let is_local = !target.starts_with('#') && !target.contains("://") && !target.contains(' ');
        if let Some(stem) = path.strip_suffix(".md").filter(|stem| is_local && !stem.contains('/'))
        {
            let hash = if anchor.is_empty() { "" } else { "#" };
            let _ = write!(out, "](../{}/index.html{hash}{anchor})", module_name(stem));
        } else if let Some(open) =
            out.rfind('[').filter(|_| is_local && target.contains(['/', '.']))
        {
            let image = out[..open].ends_with('!');
            out.replace_range(open - usize::from(image)..=open, "");
            let _ = write!(out, " (`{target}`)");
        } else {
            let _ = write!(out, "]({target})");
        }
        rest = after;
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::linked;

    #[test]
    fn links_lead_to_modules() {
        let page = "See [a](coming-from.md), [b](contacts.md#rank), [c](https://x.org/y.md), [d](#e),\n\
                    [e](../robots/arm6.urdf) and ![f](figures/g.svg).";
        let expected = "See [a](../coming_from/index.html), [b](../contacts/index.html#rank), \
                        [c](https://x.org/y.md), [d](#e),\ne (`../robots/arm6.urdf`) and f (`figures/g.svg`).";
        assert_eq!(linked(page), expected);
    }
}
