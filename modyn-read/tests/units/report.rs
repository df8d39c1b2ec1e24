//! Places of diagnostics in several files.

use modyn_read::diagnostics::Code;
use modyn_read::internals::Report;

#[test]
fn a_place_is_in_its_own_file() {
    for (offset, file, line, column) in [
        (0, "main.xml", 1, 1),
        (2, "main.xml", 2, 1),
        (3, "main.xml", 2, 2),
        (4, "empty.xml", 1, 1),
        (5, "part.xml", 1, 1),
        (8, "part.xml", 2, 3),
    ] {
        let mut report = Report::new("a\nb", "main.xml");
        assert_eq!(
            [report.add_file("empty.xml", ""), report.add_file("part.xml", "\n  c")],
            [4, 5]
        );
        report.error(Code::Option, offset, None, "m", "h");
        let found = report.finish();
        let position = found[0].position.map(|at| (at.line, at.column));
        assert_eq!((found[0].file.as_deref(), position), (Some(file), Some((line, column))));
    }
    let mut report = Report::new("", "main.xml");
    report.error(Code::Option, None, None, "m", "h");
    assert_eq!(report.finish()[0].file.as_deref(), Some("main.xml"));
}
