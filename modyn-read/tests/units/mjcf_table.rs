//! The table of MJCF knows each element and attribute of MuJoCo's schema, `mjcf/schema.tsv`, which
//! `mjcf/schema.py` writes.

use modyn_read::internals::{Treatment, row};

/// Returns whether the table knows an attribute of an element, whose contents are not looked at if
/// the element is harmless or refused.
fn knows(parent: &str, element: &str, attribute: &str) -> bool {
    match row(parent, element).map(|row| row.treatment) {
        None => false,
        Some(Treatment::Harmless | Treatment::Refused(_)) => true,
        Some(Treatment::Read(read, harmless)) => {
            harmless == "*"
                || read.iter().any(|(name, _)| *name == attribute)
                || harmless.split_ascii_whitespace().any(|name| name == attribute)
        }
    }
}

/// Returns whether the contents of an element are looked at.
fn is_open(parent: &str, element: &str) -> bool {
    row(parent, element).is_none_or(|row| matches!(row.treatment, Treatment::Read(..)))
}

#[test]
fn the_table_knows_the_schema_of_mujoco() {
    let schema = include_str!("../mjcf/schema.tsv");
    let (mut unknown, mut count) = (Vec::new(), 0);
    for line in schema.lines().filter(|line| !line.starts_with('#')) {
        let (path, attributes) = line.split_once('\t').expect("an element and its attributes");
        // The schema has the contents of `worldbody` and `body` once.
        let path = path.replace("mujoco/body", "worldbody/body");
        let path: Vec<&str> = path.split('/').collect();
        let [around @ .., parent, element] = &path[..] else { continue };
        let outer: Vec<&str> = around.iter().chain([parent]).copied().collect();
        if outer.windows(2).all(|pair| is_open(pair[0], pair[1])) {
            for attribute in attributes.split(' ').filter(|name| !name.is_empty()) {
                count += 1;
                if !knows(parent, element, attribute) {
                    unknown.push(format!("{}: {attribute}", path.join("/")));
                }
            }
            if row(parent, element).is_none() {
                unknown.push(path.join("/"));
            }
        }
    }
    assert!(count > 500, "{count}");
    assert!(unknown.is_empty(), "{unknown:#?}");
}
