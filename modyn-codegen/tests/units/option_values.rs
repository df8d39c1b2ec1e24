//! Values of options as text.

use modyn_codegen::options::{Value, ValueKind};

fn shown(text: &str) -> String {
    fn show(value: &Value) -> String {
        let all = |values: &[Value]| values.iter().map(show).collect::<Vec<_>>().join(" ");
        match &value.kind {
            ValueKind::Number(x) => format!("{x}"),
            ValueKind::Word(word) => word.clone(),
            ValueKind::Text(text) => format!("{text:?}"),
            ValueKind::List(values) => format!("[{}]", all(values)),
            ValueKind::Call(word, values) => format!("{word}({})", all(values)),
            ValueKind::Pair(name, value) => format!("{}={}", show(name), show(value)),
        }
    }
    Value::parse(text).map_or_else(|f| format!("{}: {}", f.at, f.message), |v| show(&v))
}

#[test]
fn values_are_read() {
    for (text, expected) in [
        ("f32", "f32"),
        ("0, 0,-9.81", "[0 0 -9.81]"),
        ("[0.0, 1e-3,]", "[0 0.001]"),
        ("::modyn::a", "::modyn::a"),
        ("pub(crate)", "pub(crate)"),
        (r#"[["a", "b\"c"], ["d"]]"#, r#"[["a" "b\"c"] ["d"]]"#),
        (r#""elbow": (1e-4, 100)"#, r#""elbow"=[0.0001 100]"#),
        ("smooth=0.1", "smooth=0.1"),
        ("pin: revolute(a, [1,2,3], axis = [0,1,0])", "pin=revolute(a [1 2 3] axis=[0 1 0])"),
        ("left/hand.2", "left/hand.2"),
        ("", "0: expected a value"),
        ("a b", "2: expected `,`"),
        ("[a", "2: expected `]`"),
        ("(a]", "2: expected `,`"),
        ("a,,b", "2: expected a value"),
        ("1e400", "inf"),
        ("nan", "nan"),
        ("\"a", "0: the quotes are not closed"),
    ] {
        assert_eq!(shown(text), expected, "{text}");
    }
    assert!(shown(&"[".repeat(100_000)).contains("brackets are open"));
}

#[test]
fn values_in_python() {
    for (text, expected) in [
        ("true", "True"),
        ("[0, 0, -1.62]", "[0, 0, -1.62]"),
        (r#"["elbow": (1e-4, 100)]"#, r#"{"elbow": [0.0001, 100]}"#),
        (
            r#"[both: (mass_matrix, jacobian("hand"))]"#,
            r#"{"both": ["mass_matrix", ("jacobian", "hand")]}"#,
        ),
        (
            r#"["pin": revolute("rod", [1, 0, 0], axis = [0, 1, 0])]"#,
            r#"{"pin": ("revolute", "rod", [1, 0, 0], {"axis": [0, 1, 0]})}"#,
        ),
    ] {
        assert_eq!(Value::parse(text).expect("a value").in_python(), expected);
    }
}
