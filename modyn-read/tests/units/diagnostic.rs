//! How diagnostics read, and their order.

use modyn_read::diagnostics::{Code, Diagnostic, Diagnostics, Position, Severity, Subject};

fn negative_mass() -> Diagnostic {
    Diagnostic::error(Code::NegativeMass, "the mass is -1 kg")
        .in_file("robots/foo.urdf")
        .at(Position { line: 12, column: 7 })
        .with_subject(Subject::Link("arm".into()))
        .with_help("write a mass of at least 0")
}

#[test]
fn a_diagnostic_reads_as_compilers_do() {
    let diagnostic = negative_mass();
    assert_eq!(
        diagnostic.to_string(),
        "robots/foo.urdf:12:7: error[negative-mass]: link `arm`: the mass is -1 kg\n  help: write a mass of at least 0"
    );
    let missing = Diagnostic::missing_file("a.urdf", &["src/a.urdf", "a.urdf"]).to_string();
    assert!(missing.starts_with(
        "error[missing-file]: `a.urdf` does not exist; tried `src/a.urdf`, `a.urdf`\n"
    ));
    assert!(missing.contains("source file"), "{missing}");
    // A build script has a single place to look.
    let missing = Diagnostic::missing_file("a.urdf", &["a.urdf"]).to_string();
    assert!(!missing.contains("source file") && missing.contains("Cargo.toml"), "{missing}");
}

/// Rustc and `main` write `error: ` before a text.
#[test]
fn error_is_said_once() {
    let diagnostic = negative_mass();
    assert_eq!(
        diagnostic.without_severity().to_string(),
        "robots/foo.urdf:12:7: link `arm`: the mass is -1 kg [negative-mass]\nhelp: write a mass of at least 0"
    );
    let gravity = Diagnostic::error(Code::Gravity, "it is not finite");
    assert_eq!(gravity.without_severity().to_string(), "it is not finite [gravity]");
    let warning = Diagnostic::new(Severity::Warning, Code::Mimic, "odd");
    let all = Diagnostics::new(vec![warning, gravity.clone(), gravity]);
    let shown = format!("Error: {all:?}");
    assert!(shown.starts_with("Error: 2 errors, 1 warning\nerror[gravity]: it is"), "{shown}");
}

#[test]
fn errors_come_first_then_by_position() {
    let at = |severity, line| {
        Diagnostic::new(severity, Code::Mimic, "").at(Position { line, column: 1 })
    };
    let all = Diagnostics::new(vec![
        at(Severity::Warning, 1),
        at(Severity::Error, 3),
        at(Severity::Error, 2),
    ]);
    let lines: Vec<_> = all.iter().map(|d| d.position.map(|p| p.line)).collect();
    assert_eq!(lines, [Some(2), Some(3), Some(1)]);
    assert!(all.has_errors());
}

#[test]
fn the_displayed_text_is_bounded() {
    let shown =
        |count| Diagnostics::new(vec![Diagnostic::error(Code::Mimic, ""); count]).to_string();
    assert_eq!(shown(100).lines().count(), 100);
    assert_eq!(shown(102).lines().count(), 101);
    assert!(shown(102).ends_with("\n... and 2 more"));
}

/// The page of the crate shows the errors that its example prints.
#[test]
fn the_page_shows_the_errors_of_its_example() {
    let page = include_str!("../../README.md").replace("\r\n", "\n");
    let urdf = page.split("r#\"").nth(1).and_then(|rest| rest.split("\"#").next()).expect("a URDF");
    let wrong = urdf.replace("0 1 0", "0 one 0").replace(r#"mass value="1""#, r#"mass value="-1""#);
    let errors =
        modyn_read::read(&wrong, "pendulum.urdf", &Default::default()).expect_err("two errors");
    assert!(page.contains(&format!("```text\n{errors}\n```")), "{errors}");
}
