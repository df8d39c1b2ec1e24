//! Generated files in the source tree: written with a comment about their origin, and checked
//! later.

use std::fmt::Write as _;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use modyn_read::Format;
use modyn_read::diagnostics::{Code, Diagnostic, Diagnostics};

use super::source::{Source, resolve_path};
use super::{Builder, Generated};
use crate::emit::{File, Target};
use crate::output::{ORIGIN, Replaces, check_place, has_content, write_file};

/// Files with their texts.
type PathsAndTexts = Vec<(PathBuf, String)>;

impl Builder {
    /// Compiles to the file `path`, to be kept in the source tree.
    ///
    /// Its first lines name the version of modyn, the description and the options, and say how to
    /// generate it again. The text does not depend on the machine or the date. An up-to-date file
    /// is not written.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options, or that the file cannot be written:
    /// it is an input, or modyn did not write the file that is there.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<Generated, Diagnostics> {
        let path = path.as_ref();
        let generated = self.generate()?;
        self.write_generated(path, &self.file_text(&generated))?;
        Ok(generated)
    }

    /// Returns whether the file `path` differs from the text that [`write`](Self::write) would
    /// write: the description, the options or modyn have changed, or the file was edited.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options.
    pub fn is_stale(&self, path: impl AsRef<Path>) -> Result<bool, Diagnostics> {
        let generated = self.generate()?;
        Ok(!has_content(path.as_ref(), self.file_text(&generated).as_bytes()))
    }

    /// Compiles to files of a language: the main one is `path`, the others are beside it. For
    /// MATLAB `path` is the folder of a package (`+arm`). Returns the warnings. Up-to-date files
    /// are not written. Their first line names the version of modyn and a hash of the description.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options, or that a file cannot be written.
    pub fn write_as(
        &self,
        target: Target,
        path: impl AsRef<Path>,
    ) -> Result<Vec<Diagnostic>, Diagnostics> {
        let (files, warnings) = self.files_to_write(target, path.as_ref())?;
        let inputs = self.read_files();
        for (path, _) in &files {
            check_place(path, &inputs, Replaces::Written)
                .map_err(|reason| write_error(path, &reason))?;
        }
        for (path, text) in files {
            let folder = path.parent().map_or(Ok(()), std::fs::create_dir_all);
            folder.map_err(|reason| write_error(&path, &reason))?;
            self.write_generated(&path, &text)?;
        }
        Ok(warnings)
    }

    /// Writes a generated file, unless it is up to date.
    fn write_generated(&self, path: &Path, text: &str) -> Result<(), Diagnostics> {
        if has_content(path, text.as_bytes()) {
            return Ok(());
        }
        let written = write_file(path, text.as_bytes(), &self.read_files(), Replaces::Written);
        written.map_err(|reason| write_error(path, &reason))
    }

    /// Returns the files that the robot is read from.
    fn read_files(&self) -> Vec<PathBuf> {
        let description = match &self.source {
            Source::File(path) => Some(resolve_path(path)),
            Source::Text { file, .. } => Some(PathBuf::from(file)),
            Source::Model(_) | Source::None | Source::Unread(_) => None,
        };
        let others = self.read().map_or(Vec::new(), |reading| reading.files);
        description.into_iter().chain(others).collect()
    }

    /// Returns whether the files differ from the texts that [`write_as`](Self::write_as) would
    /// write.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options.
    pub fn is_stale_as(&self, target: Target, path: impl AsRef<Path>) -> Result<bool, Diagnostics> {
        let (files, _) = self.files_to_write(target, path.as_ref())?;
        Ok(!files.iter().all(|(path, text)| has_content(path, text.as_bytes())))
    }

    /// Returns the paths and texts of the files of a language, and the warnings.
    fn files_to_write(
        &self,
        target: Target,
        path: &Path,
    ) -> Result<(PathsAndTexts, Vec<Diagnostic>), Diagnostics> {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let file_stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let stem = file_stem.trim_start_matches('+');
        let emitted = self.emit_as(target, Some(stem))?;
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
        if name != emitted.output() || !stem.chars().all(plain) {
            let title = target.title();
            let output = emitted.output();
            let message = format!("`{}` is not the name of {title} files", path.display());
            let help = format!(
                "use ASCII letters, digits, dashes and underscores, such as `{}`",
                output.replacen(stem, "arm", 1)
            );
            return Err(Diagnostic::error(Code::Output, message).with_help(help).into());
        }
        let origin = format!(
            "{ORIGIN} {} (`modyn generate --target {}`); description FNV-1a {:016x}. Do not edit.",
            env!("CARGO_PKG_VERSION"),
            target.name(),
            self.description_hash(),
        );
        let file = |file: File| {
            let text = target.backend().with_origin(&file.text, &origin);
            (path.with_file_name(file.name), text)
        };
        Ok((emitted.files.into_iter().map(file).collect(), emitted.warnings))
    }

    /// Returns the text of the file, with its comment.
    fn file_text(&self, generated: &Generated) -> String {
        let mut text = format!(
            "// {ORIGIN} {} from the robot description {:?} (FNV-1a {:016x}). Do not edit.\n\
             // Its module is made again by `modyn generate` with the same options, or \
             by\n//\n//     modyn_codegen::Builder::new()\n",
            env!("CARGO_PKG_VERSION"),
            generated.model.name(),
            self.description_hash(),
        );
        for call in self.calls() {
            let _ = writeln!(text, "//         .{call}");
        }
        text += "//         .write(path)?;\n//\n// and checked by its `--check`, or `.is_stale(path)`.\n\n";
        text + &generated.text
    }

    /// Returns the calls of the builder that set options other than the defaults.
    fn calls(&self) -> Vec<String> {
        let mut calls = Vec::new();
        let mut call = |text: String| calls.push(text);
        match &self.source {
            // The text must not depend on the folder of the file.
            Source::File(path) => {
                let name = if path.is_absolute() {
                    path.file_name().unwrap_or_default().to_string_lossy()
                } else {
                    path.to_string_lossy()
                };
                call(format!("{}({name:?})", self.format.map_or("file", Format::name)));
            }
            Source::Text { file, .. } => {
                let prefix =
                    self.format.map_or(String::new(), |format| format!("{}_", format.name()));
                call(format!("{prefix}text(text, {file:?})"));
            }
            _ => call("model(model)".into()),
        }
        calls.extend(self.options.calls());
        // A line break in a name must not end the comment.
        calls.iter().map(|text| text.replace(char::is_control, " ")).collect()
    }

    /// Returns a hash of the description and of the other files that it names.
    fn description_hash(&self) -> u64 {
        let text = match &self.source {
            Source::File(path) => std::fs::read_to_string(resolve_path(path)).unwrap_or_default(),
            Source::Text { text, .. } => text.clone(),
            Source::Model(model) => format!("{model:?}"),
            Source::None | Source::Unread(_) => String::new(),
        };
        let read_files = self.read().map_or(Vec::new(), |reading| reading.files);
        let others = read_files.iter().flat_map(|path| std::fs::read(path).unwrap_or_default());
        // Line endings depend on the checkout.
        text.bytes()
            .chain(others)
            .filter(|&byte| byte != b'\r')
            .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            })
    }
}

/// Returns the error of a file that cannot be written.
fn write_error(path: &Path, reason: &std::io::Error) -> Diagnostics {
    let message = format!("`{}` cannot be written: {reason}", path.display());
    let help = match reason.kind() {
        ErrorKind::AlreadyExists => "give the path of a new file, or of one that modyn wrote",
        _ => "give a path in a folder that exists and can be written to",
    };
    Diagnostic::error(Code::Output, message).with_help(help).into()
}
