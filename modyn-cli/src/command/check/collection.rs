//! `modyn check --collection`: checks all descriptions in folders, and prints a table.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs;
use std::path::{Component, Path, PathBuf};

use modyn_codegen::diagnostics::{Code, Diagnostic, Diagnostics, Severity, sanitize_for_display};
use modyn_codegen::{Format, ReadOptions};
use serde_json::json;

use super::{Arguments, Outcome, check_one};
use crate::command::description::Description;
use crate::command::outcome::{Failure, to_stdout};
use crate::command::table::Table;
use crate::escape;

/// The extensions of files that may be descriptions.
const EXTENSIONS: [&str; 6] = ["urdf", "xacro", "xml", "mjcf", "sdf", "world"];

/// The root element of files that are made to be included.
const PART_ROOT: &str = "<mujocoinclude";

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Verdict {
    Accepted,
    /// Nothing moves, so that there are no equations of motion.
    Static,
    Refused,
    /// Refused by itself, and included by another file, whose verdict counts.
    Part,
}

impl Verdict {
    const ALL: [Self; 4] = [Self::Accepted, Self::Static, Self::Refused, Self::Part];

    fn name(self) -> &'static str {
        match self {
            Self::Accepted => "accepted",
            Self::Static => "static",
            Self::Refused => "refused",
            Self::Part => "part",
        }
    }
}

/// A description of the collection, with its verdict.
struct Entry {
    format: Format,
    outcome: Outcome,
    verdict: Verdict,
}

impl Entry {
    /// Returns the first error.
    fn error(&self) -> Option<&Diagnostic> {
        self.outcome.diagnostics.iter().find(|one| one.severity == Severity::Error)
    }
}

/// Checks all descriptions of the folders.
pub fn run(arguments: &Arguments, options: &ReadOptions) -> Result<(), Failure> {
    let mut files = Vec::new();
    for folder in &arguments.paths {
        if !folder.is_dir() {
            let name = sanitize_for_display(&folder.display().to_string());
            return Err(Failure::usage(format!("error: `{name}` is not a folder")));
        }
        files_in(folder, &mut files)?;
    }
    let mut entries = Vec::new();
    let mut included = BTreeSet::new();
    let mut others = 0;
    for path in files {
        let name = path.display().to_string();
        let Ok(description) = Description::open(&path) else {
            others += 1;
            continue;
        };
        included.extend(included_by(&path, &description.text));
        let format = Format::found(&description.text, &name);
        let is_made_part = description.text.contains(PART_ROOT);
        let format = format.filter(|format| !is_configuration(*format, &path, &description.text));
        let Some(format) = format.or(is_made_part.then_some(Format::Mjcf)) else {
            others += 1;
            continue;
        };
        let checked = check_one(description, options, arguments);
        // The text is kept for the display of single files alone.
        let outcome = Outcome { description: None, ..checked };
        let verdict = match () {
            () if outcome.usable => Verdict::Accepted,
            () if is_made_part => Verdict::Part,
            () if is_static(&outcome.diagnostics) => Verdict::Static,
            () => Verdict::Refused,
        };
        entries.push(Entry { format, outcome, verdict });
    }
    for entry in &mut entries {
        let is_included = included.iter().any(|file| is_file(&entry.outcome.name, file));
        if entry.verdict == Verdict::Refused && is_included {
            entry.verdict = Verdict::Part;
        }
    }
    to_stdout(&if arguments.json { as_json(&entries) } else { as_text(&entries, others) })?;
    let refused = entries.iter().any(|entry| entry.verdict == Verdict::Refused);
    if refused { Err(Failure::Reported) } else { Ok(()) }
}

/// Returns whether a file configures the program of a robot, and describes no robot, although its
/// root element is a URDF's, as the files of YARP do.
fn is_configuration(format: Format, path: &Path, text: &str) -> bool {
    let is_xml = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("xml"));
    format == Format::Urdf && is_xml && !text.contains("<link") && !text.contains("<joint")
}

/// Returns whether there is nothing that moves.
fn is_static(diagnostics: &Diagnostics) -> bool {
    diagnostics.iter().any(|one| matches!(one.code, Code::NoMovingJoint | Code::NoLink))
}

/// Adds the files in `folder` and below it that may be descriptions, in the order of their names.
/// Hidden folders and links to folders are left out.
fn files_in(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), Failure> {
    let unreadable = |error| {
        let name = sanitize_for_display(&folder.display().to_string());
        Failure::usage(format!("error: the folder `{name}` cannot be read: {error}"))
    };
    let mut entries = fs::read_dir(folder)
        .and_then(Iterator::collect::<Result<Vec<_>, _>>)
        .map_err(unreadable)?;
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        let is_hidden = entry.file_name().as_encoded_bytes().starts_with(b".");
        let is_link = entry.file_type().is_ok_and(|kind| kind.is_symlink());
        let extension = path.extension().and_then(OsStr::to_str).unwrap_or_default();
        let is_named = EXTENSIONS.iter().any(|known| known.eq_ignore_ascii_case(extension));
        if path.is_dir() {
            if !is_hidden && !is_link {
                files_in(&path, files)?;
            }
        } else if is_named {
            files.push(path);
        }
    }
    Ok(())
}

/// Returns the files that a text includes: relative to its folder, or by the end of a path whose
/// start is a package.
fn included_by(path: &Path, text: &str) -> Vec<Included> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let starts = ["<include", "<xacro:include"];
    let tags = starts.iter().flat_map(|start| text.split(start).skip(1));
    let names = tags.filter_map(|rest| {
        let tag = &rest[..rest.find('>').unwrap_or(rest.len())];
        let (_, value) = tag.split_once("file=").or_else(|| tag.split_once("filename="))?;
        let quote = value.chars().next()?;
        value[1..].split(quote).next()
    });
    let included = names.map(|name| match name.rsplit_once([')', '}']) {
        Some((_, end)) => Included::End(end.trim_start_matches('/').into()),
        None => Included::Path(without_dots(&folder.join(name.trim().replace('\\', "/")))),
    });
    included.collect()
}

/// A file that another one includes.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Included {
    Path(PathBuf),
    /// The path ends so; its start is the folder of a package.
    End(PathBuf),
}

fn is_file(name: &str, file: &Included) -> bool {
    match file {
        Included::Path(path) => without_dots(Path::new(name)) == *path,
        Included::End(end) => !end.as_os_str().is_empty() && Path::new(name).ends_with(end),
    }
}

/// Returns a path without `.`, and without names before `..`.
fn without_dots(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut all, part| {
        let before = all.components().next_back();
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(before, Some(Component::Normal(_))) => {
                all.pop();
            }
            part => all.push(part),
        }
        all
    })
}

/// Returns for each format the number of files of each verdict.
fn totals(entries: &[Entry]) -> BTreeMap<&'static str, [usize; 4]> {
    let mut totals: BTreeMap<&str, [usize; 4]> = BTreeMap::new();
    for entry in entries {
        let counts = totals.entry(entry.format.name()).or_default();
        counts[entry.verdict as usize] += 1;
    }
    totals
}

fn as_text(entries: &[Entry], others: usize) -> String {
    let mut table = Table::new(&["file", "format", "verdict", "why"]);
    for entry in entries {
        let why = entry.error().map_or_else(String::new, |error| {
            let subject = error.subject.as_ref().map_or_else(String::new, |one| format!("{one}: "));
            format!("{}: {subject}{}", error.code.name(), error.message)
        });
        let [name, why] = [&entry.outcome.name, &why].map(|text| sanitize_for_display(text));
        let format = entry.format.name().into();
        let verdict = entry.verdict.name().into();
        table.row([name, format, verdict, why]);
    }
    let mut out = table.with_remarks().fitted();
    let mut sums = Table::new(&["format", "accepted", "static", "refused", "part"]);
    for (format, counts) in totals(entries) {
        let [accepted, fixed, refused, part] = counts.map(|count| count.to_string());
        sums.row([format.into(), accepted, fixed, refused, part]);
    }
    out += &format!("\n{}", sums.right_aligned_from(1).text());
    if others > 0 {
        let what = if others == 1 { "file is no description" } else { "files are no descriptions" };
        out += &format!("\n{others} other {what}.\n");
    }
    out
}

fn as_json(entries: &[Entry]) -> String {
    let files = entries.iter().map(|entry| {
        let mut file = entry.outcome.to_json();
        file["format"] = entry.format.name().into();
        file["verdict"] = entry.verdict.name().into();
        file
    });
    let totals = totals(entries).into_iter().map(|(format, counts)| {
        let counts = Verdict::ALL.iter().zip(counts).map(|(one, count)| (one.name(), count));
        (format, counts.collect::<BTreeMap<_, _>>())
    });
    let files = files.collect::<Vec<_>>();
    let totals = totals.collect::<BTreeMap<_, _>>();
    escape::json(&json!({ "files": files, "totals": totals }))
}
