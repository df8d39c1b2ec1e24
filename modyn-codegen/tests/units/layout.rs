//! Indentation of generated text.

use modyn_codegen::internals::indented;

#[test]
fn lines_are_indented_by_their_brackets() {
    let text = "fn f() {\nlet x = [\n\"(\\\"[\",\n];\n// }\n}\n\nstruct S;\n";
    let expected =
        "fn f() {\n    let x = [\n        \"(\\\"[\",\n    ];\n    // }\n}\n\nstruct S;\n";
    assert_eq!(indented(text), expected);
}
