//! Compilation in a build script.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use modyn_read::PACKAGE_PATHS;
use modyn_read::diagnostics::{Code, Diagnostic, Diagnostics};

use super::source::{Source, resolve_path};
use super::{Builder, Generated};
use crate::names;

impl Builder {
    /// Compiles to `OUT_DIR` from a build script, for `modyn::include_model!`. Cargo runs the
    /// script again when the description changes, and shows the warnings.
    ///
    /// The name for `include_model!` is derived from the type, if a name was
    /// [given](Self::type_name) (`LeftArm` is `include_model!(left_arm)`), else from the
    /// description's file (`my-robot.urdf` is `include_model!(my_robot)`).
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options, or that a file cannot be written.
    pub fn compile(&self) -> Result<Generated, Diagnostics> {
        self.rerun_if_changed();
        let generated = self.generate()?;
        self.rerun_if_others_changed(&generated.files);
        self.write_to_out_dir(&generated.type_name, &generated.text, &generated.warnings)?;
        Ok(generated)
    }

    /// Makes Cargo run the build script again when the description's file changes, also if it is
    /// missing.
    pub fn rerun_if_changed(&self) {
        if let Source::File(path) = &self.source {
            println!("cargo::rerun-if-changed={}", resolve_path(path).display());
        }
    }

    /// Makes Cargo run the build script again when one of the other files changes that the
    /// description names ([`Generated::files`]), or a variable that names the folders of packages.
    pub fn rerun_if_others_changed(&self, files: &[PathBuf]) {
        for file in files {
            println!("cargo::rerun-if-changed={}", file.display());
        }
        for variable in PACKAGE_PATHS.iter().filter(|_| !files.is_empty()) {
            println!("cargo::rerun-if-env-changed={variable}");
        }
    }

    /// Writes a robot's text to `OUT_DIR` from a build script, for `modyn::include_model!`, and
    /// shows the warnings. Returns the name for `include_model!`. [`compile`](Self::compile) does
    /// this with the text of [`generate`](Self::generate); build scripts with another back end do
    /// it with their own.
    ///
    /// # Errors
    ///
    /// If the script is no build script, another robot has the name, or the file cannot be written.
    pub fn write_to_out_dir(
        &self,
        type_name: &str,
        text: &str,
        warnings: &[Diagnostic],
    ) -> Result<String, Diagnostics> {
        let error = |message: String, help: &str| {
            Diagnostics::from(Diagnostic::error(Code::Output, message).with_help(help))
        };
        let folder = std::env::var_os("OUT_DIR").ok_or_else(|| {
            error("OUT_DIR is not set: `compile` is for build scripts".into(), "call `generate`")
        })?;
        let stem = match (&self.options.code.type_name, &self.source) {
            (None, Source::File(path)) => path.file_stem().map(|stem| stem.to_string_lossy()),
            _ => None,
        };
        let name = names::snake(stem.as_deref().unwrap_or(type_name));
        let file = Path::new(&folder).join(format!("{name}.rs"));
        // The files that this process, a build script, has written: a robot must not overwrite
        // another.
        static WRITTEN: Mutex<BTreeMap<PathBuf, String>> = Mutex::new(BTreeMap::new());
        let mut written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
        let earlier = written.entry(file.clone()).or_insert_with(|| text.to_owned());
        if *earlier != *text {
            let message = format!("two robots would be `include_model!({name})`");
            return Err(error(message, "give one of them a `type_name`"));
        }
        std::fs::write(&file, text).map_err(|reason| {
            let message = format!("`{}` cannot be written: {reason}", file.display());
            error(message, "OUT_DIR must be a writable folder")
        })?;
        let shown = warnings.iter().take(Diagnostics::SHOWN);
        let more = Diagnostics::count_hidden(warnings.len());
        for warning in shown.map(ToString::to_string).chain(more) {
            println!("cargo::warning={}", warning.replace(char::is_control, " "));
        }
        Ok(name)
    }
}
