//! Every file in `bad/` is refused, and every file in `good/` is read, with exactly the diagnostics that are marked in
//! the file, on the line of the mark:
//!
//! `<!-- ERROR code: part of the text -->`, `<!-- WARNING code: part of the text -->`.
//!
//! `<!-- OPTIONS mimic = independent, unphysical_inertia = warn -->` sets options (also `base`, `friction`).
//!
//! Each file in `bad/` says how the help of its errors is followed: `<!-- FIX text -->` replaces the line that it is in (by
//! nothing if there is no text, by options if the text is `OPTIONS ..`), `<!-- NO FIX: reason -->` says why there is no
//! such text.

use std::{collections::BTreeSet, fs, path::Path};

use modyn_read::{
    Armature, Base, Format, JointFriction, Mimic, ReadOptions, Reading,
    diagnostics::{Code, Diagnostic, Diagnostics, Severity},
    joints_without_inertia, read_urdf,
};

/// Reads a file as the format of its extension, whatever its first element is.
fn read(text: &str, name: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    if name.ends_with(".sdf") {
        Format::Sdf.read(text, name, options)
    } else {
        read_urdf(text, name, options)
    }
}

/// The marks of a file.
#[derive(Debug)]
struct Mark {
    line: usize,
    severity: Severity,
    code: String,
    text: String,
}

fn marks(text: &str) -> Vec<Mark> {
    let mut marks = Vec::new();
    for (i, line) in text.lines().enumerate() {
        for comment in line.split("<!-- ").skip(1).filter_map(|rest| rest.split(" -->").next()) {
            let Some((word, rest)) = comment.split_once(' ') else { continue };
            let severity = match word {
                "ERROR" => Severity::Error,
                "WARNING" => Severity::Warning,
                _ => continue,
            };
            let (code, text) = rest.split_once(": ").expect("a mark has a code and a text");
            marks.push(Mark { line: i + 1, severity, code: code.into(), text: text.into() });
        }
    }
    marks
}

fn options(text: &str) -> ReadOptions {
    let mut options = ReadOptions::default();
    let Some(rest) = text.split("<!-- OPTIONS ").nth(1) else { return options };
    for option in rest.split(" -->").next().unwrap_or("").split(", ") {
        match option {
            "base = fixed" => options.base = Base::Fixed,
            "base = floating" => options.base = Base::Floating,
            "mimic = follow" => options.mimic = Mimic::Follow,
            "mimic = refuse" => options.mimic = Mimic::Refuse,
            "mimic = independent" => options.mimic = Mimic::Independent,
            "joint_friction = none" => options.joint_friction = Some(JointFriction::None),
            "joint_friction = viscous" => options.joint_friction = Some(JointFriction::Viscous),
            "unphysical_inertia = warn" => options.unphysical_inertia = Severity::Warning,
            other => panic!("no option `{other}`"),
        }
    }
    options
}

/// Runs all files of a folder; returns the codes that were reported.
fn run(folder: &str, refused: bool) -> BTreeSet<Code> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(folder);
    let mut files: Vec<_> =
        fs::read_dir(path).expect("folder").map(|e| e.expect("entry").path()).collect();
    files.sort();
    let mut seen = BTreeSet::new();
    let mut failures = Vec::new();
    let mut count = 0;
    for file in &files {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let text = fs::read_to_string(file).expect("UTF-8");
        let result = read(&text, &name, &options(&text));
        count += 1;
        let found: Vec<Diagnostic> = match result {
            Ok(reading) => {
                if refused {
                    failures.push(format!("{name}: was not refused"));
                }
                reading.warnings
            }
            Err(found) => {
                if !refused {
                    failures.push(format!("{name}: was refused"));
                }
                found.into_vec()
            }
        };
        let mut marks = marks(&text);
        for diagnostic in found {
            seen.insert(diagnostic.code);
            let shown = diagnostic.to_string();
            let line = diagnostic.position.map_or(0, |p| p.line);
            let fits = marks.iter().position(|mark| {
                mark.line == line
                    && mark.severity == diagnostic.severity
                    && mark.code == diagnostic.code.name()
                    && shown.contains(&mark.text)
            });
            match fits {
                Some(i) => drop(marks.remove(i)),
                None => failures.push(format!("not marked: {shown}")),
            }
            if diagnostic.help.as_deref().unwrap_or("").is_empty() {
                failures.push(format!("without help: {shown}"));
            }
        }
        failures.extend(marks.iter().map(|mark| format!("{name}: not reported: {mark:?}")));
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(count >= 20, "only {count} files were found in {folder}");
    seen
}

#[test]
fn bad_files_are_refused_with_exactly_the_marked_diagnostics() {
    let seen = run("bad", true);
    // Files with warnings are in `good`; no file reports these codes.
    let elsewhere = [
        Code::MissingFile,
        Code::Gravity,
        Code::InvalidModel,
        Code::InvalidProgram,
        Code::Modules,
        Code::RuntimeInertia,
        Code::Payload,
        Code::TooLarge,
        Code::TypeName,
        Code::Option,
        Code::Output,
        Code::IllConditioned,
        Code::InvertedLimits,
        Code::Include,
        Code::MissingLimit,
        Code::NegativeLimit,
        Code::EmptyRange,
        Code::ZeroLimit,
        Code::LimitUnit,
        Code::LengthUnit,
        Code::InactiveFriction,
        Code::ImplausibleMass,
        Code::NotMjcf,
        Code::NotText,
        Code::XacroWarning,
        Code::MimicMultiplier,
        Code::Inexpressible,
    ];
    let missing: Vec<_> =
        Code::ALL.iter().filter(|code| !seen.contains(code) && !elsewhere.contains(code)).collect();
    assert!(missing.is_empty(), "no file in bad/ for {missing:?}");
}

/// Returns the text after the help was followed; `None` if the file says that this is not a change of the text.
fn fixed(text: &str) -> Option<String> {
    let fix = |line: &str| {
        let (_, rest) = line.split_once("<!-- FIX")?;
        let new = rest.split("-->").next().unwrap_or("").trim();
        Some(if new.starts_with("OPTIONS") { format!("<!-- {new} -->") } else { new.into() })
    };
    let lines: Vec<String> =
        text.lines().map(|line| fix(line).unwrap_or_else(|| line.into())).collect();
    (!text.contains("<!-- NO FIX: ")).then(|| lines.join("\n"))
}

#[test]
fn errors_are_gone_after_their_help_was_followed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad");
    let mut failures = Vec::new();
    let mut count = 0;
    for entry in fs::read_dir(folder).expect("folder") {
        let file = entry.expect("entry").path();
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let text = fs::read_to_string(&file).expect("UTF-8");
        let Some(fixed) = fixed(&text) else { continue };
        count += 1;
        assert_ne!(fixed, text.lines().collect::<Vec<_>>().join("\n"), "{name}: no mark `FIX`");
        let Err(found) = read(&fixed, &name, &options(&fixed)) else { continue };
        // A text without joints is no robot, only the errors that it is about must be gone.
        let codes: Vec<String> = marks(&text).into_iter().map(|mark| mark.code).collect();
        let is_robot = text.contains("<joint");
        failures.extend(
            found
                .into_vec()
                .into_iter()
                .filter(|one| one.severity == Severity::Error)
                .filter(|one| is_robot || codes.iter().any(|code| code == one.code.name()))
                .map(|one| format!("{name}: {one}")),
        );
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(count >= 50, "only {count} files have a mark `FIX`");
}

/// Warnings about limits and lengths are gone after their help was followed.
#[test]
fn limits_are_those_of_a_robot_after_their_help_was_followed() {
    let mut text = include_str!("good/limits_of_no_robot.urdf").to_owned();
    for (wrong, right) in [
        ("<limit effort=\"1\"", "<limit lower=\"-1\" upper=\"1\" effort=\"1\""),
        ("<limit effort=\"0\" velocity=\"0\"/>", "<limit lower=\"0\" upper=\"0.4\"/>"),
        (
            "lower=\"-180\" upper=\"180\" effort=\"1\" velocity=\"0\"",
            "lower=\"-3.14\" upper=\"3.14\"",
        ),
        ("xyz=\"350 0 0\"", "xyz=\"0.35 0 0\""),
        ("upper=\"40\"", "upper=\"0.04\""),
    ] {
        assert!(text.contains(wrong), "{wrong}");
        text = text.replace(wrong, right);
    }
    let found = read(&text, "r.urdf", &ReadOptions::default()).expect("a robot").warnings;
    assert_eq!(found, []);
}

/// A robot without inertia has dynamics once each joint has the armature that the help proposes.
#[test]
fn armatures_stand_in_for_missing_inertia() {
    let text = include_str!("good/kinematics_only.urdf");
    let found = read(text, "r.urdf", &ReadOptions::default()).expect("kinematics").warnings;
    let help = found[0].help.as_deref().unwrap_or_default();
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(help.contains("`armature`: `[\"shoulder\": 1, ...]`"), "{help}");
    let armature = ["shoulder", "wrist"].map(|joint| Armature::new(joint, 1.0)).to_vec();
    let options = ReadOptions { armature, ..ReadOptions::default() };
    let model = read(text, "r.urdf", &options).expect("armatures").model;
    assert!(joints_without_inertia(&model).is_empty());
}

#[test]
fn good_files_are_read_with_exactly_the_marked_warnings() {
    let seen = run("good", false);
    for code in [
        Code::InvertedLimits,
        Code::MimicTarget,
        Code::MimicMultiplier,
        Code::AxisLength,
        Code::Include,
        Code::MissingLimit,
        Code::NegativeLimit,
        Code::InactiveFriction,
        Code::MissingInertial,
        Code::ImplausibleMass,
        Code::RepeatedElement,
        Code::UnknownParent,
        Code::KinematicsOnly,
    ] {
        assert!(seen.contains(&code), "no file in good/ for {code}");
    }
}

#[test]
fn every_code_has_a_cause_and_a_remedy() {
    for code in Code::ALL {
        for text in [code.cause(), code.remedy()] {
            assert!(
                text.len() > 10 && text.ends_with('.') && text == text.trim(),
                "{code}: {text:?}"
            );
        }
        assert_eq!(Code::from_name(code.name()), Some(*code));
    }
    assert_eq!(Code::from_name("no-such-code"), None);
}

/// Links are point masses beside the size of the robot, however large it is.
#[test]
fn implausible_masses_are_found_in_robots_of_any_size() {
    let robot = |size: f64, radius: f64| {
        let (mass, moment) = (1e6 * size.powi(3), 1e6 * size.powi(3) * radius * radius);
        format!(
            "<robot name='r'><link name='base'/><link name='upper'/><link name='fore'><inertial><mass value='{mass:e}'/>
             <inertia ixx='{moment:e}' iyy='{moment:e}' izz='{moment:e}' ixy='0' ixz='0' iyz='0'/></inertial></link>
             <joint name='a' type='continuous'><parent link='base'/><child link='upper'/></joint>
             <joint name='b' type='continuous'><origin xyz='{size:e} 0 0'/><axis xyz='0 1 0'/><parent link='upper'/>
             <child link='fore'/></joint></robot>"
        )
    };
    for size in [1e-6, 1e-3, 1.0, 1e3] {
        for (radius, is_found) in [(1e-2, true), (1e-8, false)] {
            let reading = read(&robot(size, radius * size), "r.urdf", &ReadOptions::default());
            let reading = reading.unwrap_or_else(|found| panic!("{size}: {found}"));
            let found =
                reading.warnings.iter().any(|warning| warning.code == Code::ImplausibleMass);
            assert_eq!(found, is_found, "size {size}, radius {radius}");
        }
    }
}
