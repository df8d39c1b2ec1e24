//! Identifiers of names.

use std::collections::HashSet;

use modyn_codegen::names::{snake, type_name, variants};

const ODD: &[&str] = &[
    "",
    " ",
    "self",
    "Self",
    "self_",
    "fn",
    "gen",
    "async",
    "_",
    "__",
    "1",
    "2-dof arm",
    "\u{e9}t\u{e9}",
    "\u{96c6}",
    "a/b.c-d",
    "r#fn",
    "\u{1f916}",
    "union",
    "crate",
    "super",
    "try",
    "x_",
    "_x",
    "dyn",
    "await",
    "a\nb",
];

#[test]
fn types_are_upper_camel_case() {
    for (name, expected) in [
        ("my-robot 2", "MyRobot2"),
        ("panda_link0", "PandaLink0"),
        ("FL_hip_joint", "FLHipJoint"),
        ("arm/left.wrist", "ArmLeftWrist"),
        ("2dof", "N2dof"),
        ("self", "Self_"),
        ("", "Unnamed"),
        ("joint_1_2", "Joint1_2"),
        ("joint_12", "Joint12"),
        ("\u{e9}paule", "Paule"),
    ] {
        assert_eq!(type_name(name), expected, "{name}");
    }
}

#[test]
fn functions_are_snake_case() {
    for (name, expected) in [
        ("MyRobot", "my_robot"),
        ("linkA.2", "link_a_2"),
        ("URDF-file", "urdf_file"),
        ("7th", "n_7th"),
        ("type", "type_"),
        ("--", "unnamed"),
    ] {
        assert_eq!(snake(name), expected, "{name}");
    }
}

#[test]
fn variants_are_unique_and_in_order() {
    assert_eq!(variants(&["a b", "a_b", "AB", "ab"]), ["AB", "AB_2", "AB_3", "Ab"]);
    // `a_2` is not `A_2`, but a name may equal a numbered identifier.
    assert_eq!(variants(&["x 1", "x_1", "x1_2"]), ["X1", "X1_3", "X1_2"]);
    assert_eq!(variants(&["x1_2", "x 1", "x_1"]), ["X1_2", "X1", "X1_3"]);
    assert_eq!(variants(&["self", "self"]), ["Self_", "Self_2"]);
    assert_eq!(variants(&["ALL", "all", "ALL"]), ["ALL_", "All", "ALL_2"]);
    let many = vec!["same"; 10_000];
    assert_eq!(variants(&many).iter().collect::<HashSet<_>>().len(), many.len());
    let odd = variants(ODD);
    assert_eq!(odd.iter().collect::<HashSet<_>>().len(), odd.len());
}

#[test]
fn everything_is_an_identifier() {
    let all = ODD.iter().flat_map(|name| [type_name(name), snake(name)]).chain(variants(ODD));
    for name in all {
        assert!(syn::parse_str::<syn::Ident>(&name).is_ok(), "{name:?}");
    }
}
