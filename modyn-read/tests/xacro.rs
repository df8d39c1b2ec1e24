//! xacro: the expanded text is the reference's (`xacro/golden.py`), errors name the xacro, and hostile files end.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use modyn_read::diagnostics::{Code, Diagnostics};
use modyn_read::{Package, ReadOptions, XacroArg, expand_xacro, read, read_file};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/xacro")
}

/// Returns the elements and texts of an XML, in the form of `golden.py`.
fn lines(node: roxmltree::Node<'_, '_>, depth: usize, out: &mut String) {
    let text = node.document().input_text();
    let word = |at: usize| {
        let rest = &text[at..];
        &rest[..rest.find(|c: char| c.is_whitespace() || "=/>".contains(c)).unwrap_or(rest.len())]
    };
    let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let quoted = |text: &str| {
        let text = plain(text).replace('\\', "\\\\");
        match (text.contains('\''), text.contains('"')) {
            (true, false) => format!("\"{text}\""),
            _ => format!("'{}'", text.replace('\'', "\\'")),
        }
    };
    let mut attributes: Vec<(&str, &str)> =
        node.attributes().map(|own| (word(own.range().start), own.value())).collect();
    attributes.sort_unstable();
    write!(out, "{depth} {}", word(node.range().start + 1)).expect("a string");
    for (name, value) in attributes {
        write!(out, " {name}={}", quoted(value)).expect("a string");
    }
    out.push('\n');
    for child in node.children() {
        match child.text().filter(|_| child.is_text()) {
            Some(text) if !plain(text).is_empty() => {
                writeln!(out, "{} {}", depth + 1, quoted(text)).expect("a string");
            }
            _ if child.is_element() => lines(child, depth + 1, out),
            _ => {}
        }
    }
}

#[test]
fn the_language_is_that_of_the_reference() {
    let path = folder().join("language.xacro");
    let text = std::fs::read_to_string(&path).expect("a file");
    let options = ReadOptions { folder: Some(folder()), ..ReadOptions::default() };
    let (expanded, warnings) = expand_xacro(&text, "language.xacro", &options).expect("valid");
    assert_eq!(warnings, []);
    let document = roxmltree::Document::parse(&expanded).expect("XML");
    let mut found = String::new();
    lines(document.root_element(), 0, &mut found);
    let wanted = std::fs::read_to_string(path.with_extension("golden")).expect("a file");
    for (found, wanted) in found.lines().zip(wanted.lines()) {
        assert_eq!(found, wanted);
    }
    assert_eq!(found.lines().count(), wanted.lines().count());
    assert!(wanted.lines().count() > 30);
}

/// Writes files to a folder of their own, and returns the folder.
fn files(name: &str, files: &[(&str, &str)]) -> PathBuf {
    let root = std::env::temp_dir().join(format!("modyn-xacro-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&root);
    for (file, text) in files {
        let path = root.join(file);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    }
    root
}

const ROBOT: &str = r#"<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="arm">
  <xacro:arg name="mass" default="2"/>
  <xacro:include filename="$(find arm_description)/parts/rod.xacro"/>
  <link name="base"/>
  <xacro:rod name="upper" parent="base" mass="$(arg mass)"/>
  <xacro:rod name="lower" parent="upper" mass="0.5"/>
</robot>"#;

const ROD: &str = r#"<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="rod" params="name parent mass">
    <joint name="${name}_joint" type="continuous">
      <origin xyz="0 0 ${0.3 + 0.1}"/><parent link="${parent}"/><child link="${name}"/><axis xyz="0 1 0"/>
    </joint>
    <link name="${name}">
      <inertial><origin xyz="0 0 0.2"/>
        <mass value="${mass}"/>
        <xacro:cube size="${mass / 50}"/></inertial>
    </link>
  </xacro:macro>
  <xacro:macro name="cube" params="size">
    <inertia ixx="${size}" iyy="${size}" izz="${size}" ixy="0" ixz="0" iyz="0"/>
  </xacro:macro>
</robot>"#;

fn arm(name: &str) -> PathBuf {
    files(
        name,
        &[
            ("arm_description/package.xml", "<package/>"),
            ("arm_description/urdf/arm.urdf.xacro", ROBOT),
            ("arm_description/parts/rod.xacro", ROD),
        ],
    )
}

#[test]
fn a_file_with_includes_is_read_with_arguments() {
    let root = arm("read");
    let path = root.join("arm_description/urdf/arm.urdf.xacro");
    let reading = read_file(&path, &ReadOptions::default()).expect("valid");
    let mass = |i: usize| reading.model.moving_links()[i].inertial.mass;
    assert_eq!((mass(0), mass(1)), (2.0, 0.5));
    assert_eq!(reading.files.len(), 1, "{:?}", reading.files);
    assert!(reading.files[0].ends_with("parts/rod.xacro"));
    let options =
        ReadOptions { xacro_args: vec![XacroArg::new("mass", "7.25")], ..Default::default() };
    let heavy = read_file(&path, &options).expect("valid");
    assert_eq!(heavy.model.moving_links()[0].inertial.mass, 7.25);
    let _ = std::fs::remove_dir_all(root);
}

/// A package is also the folder of its name that contains the description, if no folder of its name has a `package.xml`.
#[test]
fn a_package_is_a_folder_above_the_description() {
    let parts = [
        ("parts/rod.xacro", ROD),
        ("arm_description/urdf/arm.urdf.xacro", ROBOT),
        ("arm_description/parts/rod.xacro", ROD),
    ];
    let root = files("above", &parts);
    let path = root.join("arm_description/urdf/arm.urdf.xacro");
    let options = ReadOptions::default();
    assert_eq!(read_file(&path, &options).expect("valid").model.nq(), 2);
    // A folder beside it is none without a `package.xml`.
    std::fs::create_dir_all(root.join("other")).expect("a folder");
    let beside = root.join("other/arm.urdf.xacro");
    std::fs::copy(&path, &beside).expect("a copy");
    let found = read_file(&beside, &options).expect_err("no package").to_string();
    assert!(found.contains("`arm_description` was not found"), "{found}");
    std::fs::write(root.join("arm_description/package.xml"), "<package/>").expect("a file");
    read_file(&beside, &options).expect("a package beside");
    let _ = std::fs::remove_dir_all(root);
}

/// A package has the name in its `package.xml`, whatever the name of its folder is, above the
/// description and beside it.
#[test]
fn a_package_has_the_name_in_its_file() {
    let named = |name: &str| {
        format!("<?xml version='1.0'?><package format='3'><name> {name}\n</name></package>")
    };
    let text = ROBOT.replace("$(find arm_description)", "$(find my_arm)");
    assert_ne!(text, ROBOT);
    let parts = [
        ("checkout/package.xml", &*named("my_arm")),
        ("checkout/urdf/arm.urdf.xacro", &text),
        ("checkout/parts/rod.xacro", ROD),
        ("other/urdf/arm.urdf.xacro", &text),
        ("my_arm/package.xml", &named("someone_elses_arm")),
    ];
    let root = files("named", &parts);
    let coordinates = |path: &str| {
        read_file(root.join(path), &ReadOptions::default()).map(|reading| reading.model.nq())
    };
    for path in ["checkout/urdf/arm.urdf.xacro", "other/urdf/arm.urdf.xacro"] {
        assert_eq!(coordinates(path).expect("a package"), 2, "{path}");
    }
    std::fs::write(root.join("checkout/package.xml"), named("arm")).expect("a file");
    let found = coordinates("other/urdf/arm.urdf.xacro").expect_err("no package").to_string();
    assert!(found.contains("`my_arm` was not found"), "{found}");
    let _ = std::fs::remove_dir_all(root);
}

/// Both the error of the URDF and that of an expression are at the xacro's line, with the calls that led there.
#[test]
fn errors_name_the_line_of_the_xacro_and_the_calls() {
    let root = arm("errors");
    let folder = root.join("arm_description/urdf");
    let errors = |text: &str, mass: &str| -> Diagnostics {
        let options = ReadOptions {
            folder: Some(folder.clone()),
            xacro_args: vec![XacroArg::new("mass", mass)],
            ..ReadOptions::default()
        };
        read(text, "arm.urdf.xacro", &options).expect_err("wrong")
    };
    let found = errors(ROBOT, "-2");
    let first = found.iter().find(|one| one.code == Code::NegativeMass).expect("reported");
    assert!(first.file.as_deref().is_some_and(|file| file.ends_with("parts/rod.xacro")));
    assert_eq!(first.position.map(|at| (at.line, at.column)), Some((8, 15)));
    assert_eq!(first.notes, ["in the macro `rod`, called at arm.urdf.xacro:5:3"]);
    let found = errors(ROBOT, "heavy");
    let first = &found.as_slice()[0];
    assert_eq!(first.code, Code::Xacro);
    assert!(first.message.contains("`/` of a text and an integer"), "{}", first.message);
    assert_eq!(first.position.map(|at| at.line), Some(9));
    let found =
        errors(&ROBOT.replace("xacro:rod name=\"lower\"", "xacro:rood name=\"lower\""), "1");
    let shown = found.to_string();
    assert!(
        shown.contains("arm.urdf.xacro:6:3: error[xacro]: there is no macro `rood`"),
        "{shown}"
    );
    assert!(shown.contains("did you mean `xacro:rod`?"), "{shown}");
    let found = errors(&ROBOT.replace("mass=\"0.5\"", "mas=\"0.5\""), "1");
    assert!(found.to_string().contains("did you mean `mass`?"), "{found}");
    let _ = std::fs::remove_dir_all(root);
}

/// Returns the errors of a text without a folder.
fn refused(inside: &str) -> String {
    let text =
        format!("<robot xmlns:xacro='http://www.ros.org/wiki/xacro' name='r'>{inside}</robot>");
    let found = expand_xacro(&text, "r.xacro", &ReadOptions::default());
    found.expect_err("refused").to_string()
}

#[test]
fn the_environment_and_other_code_are_not_read() {
    assert!(refused("<a b='$(env HOME)'/>").contains("every build is the same"));
    assert!(refused("<a b='$(cwd)'/>").contains("every build is the same"));
    assert!(refused("<a b=\"${__import__('os')}\"/>").contains("`__import__` is not defined"));
    assert!(refused("<a b=\"${open('/etc/passwd')}\"/>").contains("`open` is not defined"));
    assert!(refused("<a b=\"${''.__class__}\"/>").contains("has no `__class__`"));
    assert!(refused("<a b=\"${(lambda x: x)(1)}\"/>").contains("unexpected `lambda`"));
    assert!(refused("<xacro:include filename='a.xacro'/>").contains("a text without a folder"));
    assert!(refused("<a b='$(find ../..)'/>").contains("was not found"));
    let text = "<robot name='r'><a b='$(optenv HOME none)'/></robot>";
    let (expanded, warnings) =
        expand_xacro(text, "r.xacro", &ReadOptions::default()).expect("a default");
    assert!(expanded.contains("b=\"none\""), "{expanded}");
    assert_eq!(warnings[0].code, Code::XacroWarning);
}

#[test]
fn hostile_files_end() {
    let repeated = |count: usize| {
        let mut text = String::from("<xacro:macro name='m0' params=''><a/></xacro:macro>");
        for i in 1..count {
            let before = i - 1;
            let calls = format!("<xacro:m{before}/>").repeat(10);
            write!(text, "<xacro:macro name='m{i}' params=''>{calls}</xacro:macro>")
                .expect("a string");
        }
        text + &format!("<xacro:m{}/>", count - 1)
    };
    assert!(refused(&repeated(20)).contains("takes too long"));
    let recursive = "<xacro:macro name='m' params=''><xacro:m/></xacro:macro><xacro:m/>";
    assert!(refused(recursive).contains("more than 60 deep"));
    let doubled: String = (1..60)
        .map(|i| format!("<xacro:property name='p{i}' value='${{p{}}}${{p{}}}'/>", i - 1, i - 1))
        .collect();
    let laughs = format!("<xacro:property name='p0' value='ha'/>{doubled}<a b='${{p59}}'/>");
    assert!(refused(&laughs).contains("takes too long"));
    assert!(refused("<a b=\"${'x' * 10 ** 12}\"/>").contains("longer than"));
    assert!(refused("<a b='${[0] * 999999999}'/>").contains("longer than"));
    assert!(refused("<a b='${10 ** 10 ** 10}'/>").contains("too large"));
    assert!(
        refused("<a b='${len([x for x in range(90000) for y in range(90000)])}'/>")
            .contains("too long")
    );
    assert!(refused(&format!("<a b='${{{}1}}'/>", "(".repeat(500))).contains("nested more than"));
    assert!(refused(&format!("<a b='${{{}1}}'/>", "1+".repeat(5000))).contains("longer than"));
    assert!(refused(&format!("<a b='${{{}1}}'/>", "-".repeat(500))).contains("nested more than"));
    assert!(refused("<xacro:property name='a' value='${b}'/><xacro:property name='b' value='${a}'/><c d='${a}'/>").contains("defined by itself"));
    let deep = format!("{}{}", "<a>".repeat(900), "</a>".repeat(900));
    assert!(refused(&deep).contains("nested more than"));
    let elements = "<xacro:element xacro:name='xacro:element' xacro:name2=''/>";
    assert!(refused(elements).contains("the attribute `xacro:name`"), "{}", refused(elements));
    let root = files(
        "cycle",
        &[("a.xacro", "<robot xmlns:xacro='x'><xacro:include filename='a.xacro'/></robot>")],
    );
    let options = ReadOptions { folder: Some(root.clone()), ..ReadOptions::default() };
    let text = std::fs::read_to_string(root.join("a.xacro")).expect("a file");
    let found = expand_xacro(&text, "a.xacro", &options).expect_err("a cycle");
    assert!(found.to_string().contains("more than 60 deep"), "{found}");
    let _ = std::fs::remove_dir_all(root);
}

/// Values share their parts, so that a few lines are values of any size: all that prints or compares
/// them is counted before it is done.
#[test]
fn repeated_values_end() {
    let too_long = "takes too long: more than a million operations";
    // `a` has ten values, `b` a hundred, ...
    let mut aliases = String::from("a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n");
    for (name, before) in ('b'..='u').zip('a'..) {
        writeln!(aliases, "{name}: &{name} [{}]", vec![format!("*{before}"); 10].join(", "))
            .expect("a string");
    }
    let found = yaml("aliases", &aliases);
    assert!(found.contains("a.yaml:7") && found.contains(too_long), "{found}");
    assert!(found.contains("aliases of YAML shorter"), "{found}");
    // So do mappings, merges and lists of lines.
    let merges = "a: &a {x: 1}\nb: &b\n- *a\n- *a\nc: {<<: *a, y: *b, z: *b}\n";
    assert!(yaml("merges", merges).contains("{'a': {'x': 1}"));
    let in_lines = "a: &a\n  - 1\n".to_owned()
        + &('b'..='u')
            .zip('a'..)
            .map(|(name, before)| {
                format!("{name}: &{name}\n") + &format!("  - *{before}\n").repeat(10)
            })
            .collect::<String>();
    assert!(yaml("lines", &in_lines).contains(too_long));
    let property =
        |name: &str, value: &str| format!("<xacro:property name='{name}' value='{value}'/>");
    let doubled: String =
        (1..60).map(|i| property(&format!("p{i}"), &format!("${{[p{0}, p{0}]}}", i - 1))).collect();
    let doubled = property("p0", "${[1]}") + &doubled;
    // Within an expression no property is between the lists.
    let nested = (0..40).fold(String::from("[0]"), |list, _| format!("[[y, y] for y in [{list}]]"));
    for expression in [
        "p59",
        "p59 == p59",
        "str(p59)",
        "len(p59)",
        "p59 in [p59]",
        "sorted([p59, p59])",
        "'%s' % p59",
        "dict(a=p59)",
    ] {
        let text = format!("{doubled}<a b=\"${{{expression}}}\"/>");
        assert!(refused(&text).contains(too_long), "{expression}: {}", refused(&text));
    }
    for expression in
        ["N", "str(N)", "N == N", "N in [N]", "max(N, N)", "len(str(N))", "[N].index(N)"]
    {
        let text = format!("<a b='${{{}}}'/>", expression.replace('N', &nested));
        assert!(refused(&text).contains(too_long), "{expression}: {}", refused(&text));
    }
    // Keys are not looked for among all others.
    assert_eq!(value("${len(dict((i, i) for i in range(100000)))}"), "100000");
    let keys: String = (0..50_000).map(|i| format!("k{i}: 1\n")).collect();
    assert!(yaml("keys", &keys).contains("'k49999': 1"));
    // A value in itself, as often as the file says.
    let deeper = "<xacro:property name='x' value='${[x]}' lazy_eval='false'/>".repeat(5000);
    let deeper = property("x", "1") + &deeper + "<a b='${x}'/>";
    assert!(refused(&deeper).contains("a value is nested more than 100 deep"));
}

#[test]
fn packages_are_those_of_the_option_first() {
    let root = arm("packages");
    let parts = root.join("elsewhere/parts");
    std::fs::create_dir_all(&parts).expect("a folder");
    std::fs::write(parts.join("rod.xacro"), ROD.replace("0.3 + 0.1", "5")).expect("a file");
    let given = Package::new("arm_description", root.join("elsewhere").display().to_string());
    let folder = Some(root.join("arm_description/urdf"));
    for (packages, z) in [(vec![], 0.4), (vec![given], 5.0)] {
        let options = ReadOptions { folder: folder.clone(), packages, ..ReadOptions::default() };
        let model = read(ROBOT, "arm.xacro", &options).expect("valid").model;
        assert_eq!(model.moving_links()[1].joint.origin.translation, [0.0, 0.0, z]);
    }
    let _ = std::fs::remove_dir_all(root);
}

/// Returns the value of an expression, as text.
fn value(expression: &str) -> String {
    let text = format!("<robot name='r'><a b=\"{expression}\"/></robot>");
    let found = expand_xacro(&text, "r.xacro", &ReadOptions::default());
    let (expanded, _) = found.unwrap_or_else(|found| panic!("{expression}: {found}"));
    attribute(&expanded)
}

/// Returns the attribute `b` of the first element.
fn attribute(expanded: &str) -> String {
    let document = roxmltree::Document::parse(expanded).expect("XML");
    let element = document.root_element().first_element_child().expect("an element");
    element.attribute("b").expect("an attribute").into()
}

#[test]
fn numbers_have_the_texts_of_python() {
    for (expression, text) in [
        ("-0.0", "-0.0"),
        ("0.1 + 0.2", "0.30000000000000004"),
        ("1e-4", "0.0001"),
        ("1.5e-5", "1.5e-05"),
        ("1e15", "1000000000000000.0"),
        ("1e16", "1e+16"),
        ("1.25e-100", "1.25e-100"),
        ("-inf", "-inf"),
        ("[1, True, None, (2.0,)]", "[1, True, None, (2.0,)]"),
    ] {
        assert_eq!(value(&format!("${{{expression}}}")), text);
    }
    assert_eq!(value("a$${b} $c$$d"), "a${b} $c$$d");
}

/// Expressions of Python that are refused here, with the reasons.
const REFUSED: &[(&str, &str)] = &[
    ("(-8.0) ** (1 / 3)", "a root of a negative number"),
    ("[1] is [1]", "write `==`"),
    ("1.5 is 1.5", "write `==`"),
    ("'\\x41'", "the escape `\\x` is not supported"),
    ("python.set([100, 8, 1])", "write `python.sorted(...)`"),
    ("python.set([1]).add(2)", "a set has no `add`"),
    ("python.frozenset([1])", "no `frozenset`"),
    ("dict(a=1) | dict(b=2)", "of dictionaries is not supported"),
    ("python.isinstance(1, int)", "no `isinstance`"),
    ("python.hash(1)", "no `hash`"),
    ("python.complex(1, 2)", "no `complex`"),
    ("round(1234.5, -2)", "not between 0 and 300"),
    ("math.factorial(5)", "no `factorial`"),
    ("math.gcd(4, 6)", "no `gcd`"),
    ("'%g' % 0.1", "the format `g`"),
    ("'%x' % 255", "the format `x`"),
    ("'%-5s|' % 'a'", "the format `-5s`"),
    ("'%05s' % 'a'", "the format `05s`"),
    ("'%.2s' % 'abc'", "the format `.2s`"),
    ("'%.3d' % 7", "the format `.3d`"),
    ("'%+d' % 5", "the format `+d`"),
    ("'%f' % math.inf", "the format `f`"),
    ("f'a'", "texts with a prefix are not supported"),
    ("r'a'", "texts with a prefix are not supported"),
    ("'a,b,c'.split(',', 1)", "`split` of a text cannot be called"),
    ("'abc'.endswith(('c', 'd'))", "`endswith` of a text cannot be called"),
    ("'a'.isalpha()", "no `isalpha`"),
    ("'abc'.partition('b')", "no `partition`"),
    ("[1].append(2)", "no `append`"),
];

/// Expressions whose last digit depends on the C library below Python.
const LAST_DIGIT: &[&str] = &["math.exp(1)", "math.cbrt(27)"];

/// `xacro/expressions.golden` has the results of `xacro` 2.1.1 (`xacro/golden.py`).
#[test]
fn expressions_have_the_results_of_the_reference_or_are_refused() {
    let golden = include_str!("xacro/expressions.golden");
    let mut wrong = Vec::new();
    for line in golden.lines() {
        let (expression, wanted) = line.split_once('\t').expect("an expression and its result");
        let escaped = expression.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        let text = format!("<robot name='r'><a b=\"${{{escaped}}}\"/></robot>");
        let expanded = expand_xacro(&text, "r.xacro", &ReadOptions::default());
        let reason = REFUSED.iter().find(|(refused, _)| *refused == expression);
        match (expanded, wanted.strip_prefix('='), reason) {
            (Ok((expanded, _)), Some(wanted), None) => {
                let result = attribute(&expanded).replace('\t', "\\t").replace('\n', "\\n");
                let close = || {
                    let [a, b] =
                        [&result, wanted].map(|text| text.parse::<f64>().expect("a number"));
                    (a - b).abs() <= f64::EPSILON * b.abs()
                };
                let agrees = result == wanted || LAST_DIGIT.contains(&expression) && close();
                if !agrees {
                    wrong.push(format!("{expression}: {result}, wanted {wanted}"));
                }
            }
            (Err(_), None, None) => {}
            (Err(errors), Some(_), Some((_, reason))) if errors.to_string().contains(reason) => {}
            (Ok((expanded, _)), ..) => {
                wrong.push(format!("{expression}: {}, wanted {line}", attribute(&expanded)));
            }
            (Err(errors), ..) => wrong.push(format!("{line}: {errors}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn wrong_expressions_are_refused() {
    for (expression, reason) in [
        ("1000\u{e9}.0", "`1000\u{e9}` is not a number"),
        ("a b", "unexpected `b`"),
        ("(1", "expected `)`, found the end"),
        ("'a", "a text is not closed by '"),
        ("f'a'", "texts with a prefix are not supported"),
        ("99999999999999999999", "the integer `99999999999999999999` is too large"),
        ("1 if 2", "expected `else`, found the end"),
        ("[1, 2", "expected `]`, found the end"),
        ("", "the expression is not complete"),
        ("1 / 0", "division by zero"),
        ("acos(2)", "`math.acos` of 2.0 is not defined"),
        ("[1][1]", "there is no item 1 of 1"),
        ("1 < 'a'", "of an integer and a text"),
    ] {
        let found = refused(&format!("<a b=\"${{{}}}\"/>", expression.replace('<', "&lt;")));
        assert!(found.contains(reason), "{expression}: {found}");
    }
}

/// Returns the value of a YAML, as text, or the error.
fn yaml(name: &str, content: &str) -> String {
    let root = files(name, &[("a.yaml", content)]);
    let options = ReadOptions { folder: Some(root.clone()), ..ReadOptions::default() };
    let text = "<robot name='r'><a>${xacro.load_yaml('a.yaml')}</a></robot>";
    let found = expand_xacro(text, "r.xacro", &options);
    let _ = std::fs::remove_dir_all(root);
    match found {
        Ok((expanded, _)) => {
            let document = roxmltree::Document::parse(&expanded).expect("XML");
            document
                .root_element()
                .first_element_child()
                .and_then(|a| a.text())
                .unwrap_or("")
                .into()
        }
        Err(found) => found.to_string(),
    }
}

/// The expected texts are those of Python's reader of YAML.
#[test]
fn yaml_has_the_types_of_yaml() {
    for (content, shown) in [
        (
            "a: 1\nb: [1.5, x, {y: 2, z: 'q'}] # c\n\nc:\n  d: yes\n  e:\n  - 010\n  - - 1\n    - 2\n  - f: 1\n    g: ~\n",
            "{'a': 1, 'b': [1.5, 'x', {'y': 2, 'z': 'q'}], 'c': {'d': True, 'e': [8, [1, 2], {'f': 1, 'g': None}]}}",
        ),
        (
            "x: 1e3\ny: 1.0e+3\nz: .5\nw: 1:2\nv: 0x1F",
            "{'x': '1e3', 'y': 1000.0, 'z': 0.5, 'w': '1:2', 'v': 31}",
        ),
        ("a: \"b # c\"\n'd e': [1,\n  2]", "{'a': 'b # c', 'd e': [1, 2]}"),
        ("{\"a\": [true, null], \"b\": \"\\\"\"}", "{'a': [True, None], 'b': '\"'}"),
        ("limit: !degrees  180.0", "{'limit': 3.141592653589793}"),
        ("# nothing\n", "None"),
        (
            "a: &x\n  b: 1\nc: *x\nd:\n  <<: *x\n  e: 2\nf: &y 3\ng: [*y]",
            "{'a': {'b': 1}, 'c': {'b': 1}, 'd': {'b': 1, 'e': 2}, 'f': 3, 'g': [3]}",
        ),
    ] {
        assert_eq!(yaml("yaml", content), shown);
    }
    for (content, reason) in [
        ("a: 1\nb: *x", "a.yaml:2: there is no `&x`"),
        ("a: |\n  text", "a.yaml:1: `|` is not supported"),
        ("a: 1\n  b: 2", "a.yaml:2: this line does not belong"),
        ("a: [1, 2", "expected `,` or `]`"),
        (&"[".repeat(1000), "nested more than"),
        (&"- ".repeat(1000), "nested more than"),
        ("a: !unknown 1", "the tag `!unknown`"),
    ] {
        let found = yaml("bad-yaml", content);
        assert!(found.contains(reason), "{content}: {found}");
    }
}
