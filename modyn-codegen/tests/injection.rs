//! Names are data. With any names, the generated text is that of the same robot with plain names, except for strings,
//! documentation and the variants of enums.

use modyn_codegen::names;
use modyn_codegen::{Builder, Function};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use proptest::prelude::*;

/// Returns a name as references to characters.
fn encoded(name: &str) -> String {
    name.chars().map(|c| format!("&#{};", u32::from(c))).collect()
}

/// Returns a robot with two joints; the warning about an axis is part of the documentation.
fn urdf(names: [&str; 6]) -> String {
    let [robot, base, link, joint, tip, wrist] = names.map(encoded);
    let inertial = "<inertial><origin xyz='0.5 0 0'/><mass value='1'/>\
                    <inertia ixx='0.1' iyy='0.1' izz='0.1' ixy='0' ixz='0' iyz='0'/></inertial>";
    format!(
        "<robot name='{robot}'><link name='{base}'/>\
         <joint name='{joint}' type='revolute'><parent link='{base}'/><child link='{link}'/><axis xyz='0 2 0'/></joint>\
         <link name='{link}'>{inertial}</link>\
         <joint name='{wrist}' type='prismatic'><parent link='{link}'/><child link='{tip}'/><axis xyz='0 0 3'/></joint>\
         <link name='{tip}'>{inertial}</link></robot>"
    )
}

/// Returns the tokens: a string as one symbol, documentation line by line, an identifier from a name as another symbol.
fn skeleton(text: &str, variants: &[String]) -> Vec<String> {
    fn walk(tokens: TokenStream, variants: &[String], found: &mut Vec<String>) {
        for token in tokens {
            match token {
                TokenTree::Group(group) => {
                    let (open, close) = match group.delimiter() {
                        Delimiter::Parenthesis => ("(", ")"),
                        Delimiter::Brace => ("{", "}"),
                        Delimiter::Bracket => ("[", "]"),
                        Delimiter::None => ("", ""),
                    };
                    found.push(open.into());
                    walk(group.stream(), variants, found);
                    found.push(close.into());
                }
                TokenTree::Literal(literal)
                    if literal.to_string().starts_with(['"', 'r', 'b', 'c']) =>
                {
                    found.push("string".into());
                }
                TokenTree::Ident(ident) if variants.contains(&ident.to_string()) => {
                    found.push("name".into())
                }
                other => found.push(other.to_string()),
            }
        }
    }
    let mut found = Vec::new();
    walk(text.parse().expect("tokens"), variants, &mut found);
    found
}

/// Returns the lines of the documentation that start or end a code block; rustdoc would run such a block.
fn fences(text: &str) -> Vec<&str> {
    text.lines()
        .map(str::trim_start)
        .filter_map(|line| line.strip_prefix("///"))
        .map(str::trim_start)
        .filter(|line| line.starts_with("```") || line.starts_with("~~~"))
        .collect()
}

fn compiled(named: [&str; 6], self_contained: bool) -> (String, Vec<String>) {
    let functions =
        [Function::ForwardDynamics, Function::Jacobian, Function::LinkPoses, Function::Regressor];
    let mut builder = Builder::new().urdf_text(urdf(named), "robot.urdf").functions(functions);
    builder = builder
        .type_name("Named")
        .payload([named[2], named[4]])
        .runtime_inertia([named[2], named[4]])
        .c_functions("named");
    if self_contained {
        builder = builder.self_contained();
    }
    let generated = builder.generate().unwrap_or_else(|errors| panic!("{errors}"));
    let [_, base, link, joint, tip, wrist] = named;
    let mut variants = names::variants(&[base, link, tip]);
    variants.extend(names::variants(&[joint, wrist]));
    for field in names::fields(&[link, tip], &[]) {
        for function in ["inertia_of", "set_inertia_of", "payload_of", "set_payload_of"] {
            variants.push(format!("{function}_{field}"));
        }
    }
    (generated.text, variants)
}

const PLAIN: [&str; 6] = ["r0", "b0", "l0", "j0", "t0", "w0"];

fn check(named: [&str; 6], self_contained: bool) {
    let (text, variants) = compiled(named, self_contained);
    syn::parse_file(&text).expect("Rust");
    // The plain text may use the name of a variant for something else, such as `q`.
    let (plain, mut all) = compiled(PLAIN, self_contained);
    all.extend(variants);
    assert_eq!(skeleton(&text, &all), skeleton(&plain, &all), "{named:?}");
    assert_eq!(fences(&text), fences(&plain), "{named:?}");
    let seen = |c: &char| (c.is_control() && *c != '\n') || ('\u{202a}'..='\u{202e}').contains(c);
    assert_eq!(text.chars().find(seen), None, "{named:?}");
}

/// A warning quotes names of the description, and rustdoc runs code blocks in backticks.
#[test]
fn documentation_runs_nothing() {
    for name in [
        "x\n```\n\n```\nstd::process::exit(1);\n```\n",
        "x\n~~~\n",
        "x\n```text",
        "```",
        "x\r```\r",
    ] {
        check([name, "b", name, name, "t", "w"], false);
    }
}

/// Returns the names of all items inside of the block of generated functions.
fn helpers(text: &str) -> Vec<String> {
    let name = |item: &syn::Item| match item {
        syn::Item::Struct(item) => Some(item.ident.to_string()),
        syn::Item::Enum(item) => Some(item.ident.to_string()),
        syn::Item::Trait(item) => Some(item.ident.to_string()),
        syn::Item::Type(item) => Some(item.ident.to_string()),
        syn::Item::Static(item) => Some(item.ident.to_string()),
        syn::Item::Const(item) => Some(item.ident.to_string()),
        syn::Item::Fn(item) => Some(item.sig.ident.to_string()),
        syn::Item::Mod(item) => Some(item.ident.to_string()),
        _ => None,
    };
    let items = syn::parse_file(text).expect("Rust").items;
    let blocks = items.iter().filter_map(|item| match item {
        syn::Item::Const(item) if item.ident == "_" => match &*item.expr {
            syn::Expr::Block(block) => Some(block.block.stmts.clone()),
            _ => None,
        },
        _ => None,
    });
    let inside = blocks.flatten().filter_map(|statement| match statement {
        syn::Stmt::Item(item) => name(&item),
        _ => None,
    });
    inside.collect()
}

/// A helper type of the generated text would hide a robot's type with the same name; the names are disjoint.
#[test]
fn no_helper_is_called_as_a_robot_can_be() {
    let robot = |name: &str| format!("{}/../robots/{name}.urdf", env!("CARGO_MANIFEST_DIR"));
    let mut kinds = [0; 4];
    for (name, share) in [("quadruped", true), ("arm6", false)] {
        let builder = Builder::new().urdf(robot(name)).functions(Function::ALL.iter().copied());
        let builder = if share { builder.share_limbs() } else { builder };
        let found = helpers(&builder.generate().expect("good").text);
        for helper in &found {
            // The type of a robot is named by `type_name`.
            assert_ne!(names::type_name(helper), *helper);
        }
        let kind = |end: &str| found.iter().filter(|helper| helper.contains(end)).count();
        let counts = ["Kernel", "SimdTask", "Chunk", "_TABLE_"].map(kind);
        kinds.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
    }
    assert!(kinds.iter().all(|&count| count > 0), "{kinds:?}");
}

/// Names that are also in the prelude, in the text's generic parameters, or in the file's module.
#[test]
fn robots_may_have_names_that_the_text_uses() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("mentioned");
    std::fs::create_dir_all(&folder).expect("a folder");
    let rustc = std::env::var_os("RUSTC").unwrap_or("rustc".into());
    let mut root = String::from("#![no_std]\n#![deny(warnings)]\n");
    for name in
        ["T", "V", "Some", "Option", "Default", "Copy", "Scalar", "Runtime", "Into", "Payload"]
    {
        let functions = [
            Function::ForwardDynamics,
            Function::Brge,
            Function::LinkPose,
            Function::RandomConfiguration,
        ];
        let builder = Builder::new().urdf_text(urdf(PLAIN), "robot.urdf").functions(functions);
        let builder = builder.type_name(name).self_contained().c_functions(names::snake(name));
        let builder = builder.payload(["l0"]).runtime_gravity();
        let file = folder.join(format!("{}.rs", names::snake(name)));
        std::fs::write(&file, builder.generate().expect("good").text).expect("writes");
        root += &format!("pub mod {};\n", names::snake(name));
    }
    std::fs::write(folder.join("lib.rs"), root).expect("writes");
    let mut command = std::process::Command::new(rustc);
    command.current_dir(&folder).args(["--edition=2024", "--crate-type=lib", "--emit=metadata"]);
    let output = command.arg("lib.rs").output().expect("rustc runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Parts of names that have a meaning in a place that a name could reach.
const PARTS: &[&str] = &[
    "\"",
    "'",
    "\\",
    "`",
    "```",
    "\n",
    "\r",
    "\t",
    "*/",
    "/*",
    "//",
    "///",
    "//!",
    "#[doc",
    "]",
    "{",
    "}",
    "{}",
    "(",
    ")",
    ";",
    "#",
    "\"#",
    "r#",
    "fn",
    "self",
    "Self",
    "crate",
    "super",
    "ALL",
    "unsafe",
    "q",
    "qd",
    "gravity",
    "f64",
    "0",
    "1",
    "_",
    " ",
    "-",
    "$x",
    "!",
    "<script>",
    "</",
    "&",
    "|",
    "\u{202e}",
    "\u{2028}",
    "\u{feff}",
    "\u{85}",
    "\u{e9}",
    "\u{96c6}",
    "\u{1f916}",
    "\u{0301}",
    "\u{200b}",
    "\u{9b}",
    "compile_error!(\"\")",
    "include!(\"/etc/passwd\")",
];

/// Returns any name: parts and letters; the number makes the names distinct.
fn name(number: usize) -> impl Strategy<Value = String> {
    let part = prop_oneof![
        4 => prop::sample::select(PARTS).prop_map(String::from),
        1 => any::<char>().prop_filter("XML has them", |&c| c >= ' ' && !matches!(c, '\u{fffe}' | '\u{ffff}')).prop_map(String::from),
    ];
    let name = prop::collection::vec(part, 0..8)
        .prop_map(move |parts| format!("{}{number}", parts.concat()));
    // xacro's expressions are refused.
    name.prop_filter("not xacro's", |name| !name.contains("${") && !name.contains("$("))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn names_are_data(
        robot in name(0), base in name(1), link in name(2), joint in name(3), tip in name(4), wrist in name(5),
        self_contained in any::<bool>(),
    ) {
        check([&robot, &base, &link, &joint, &tip, &wrist], self_contained);
    }
}

/// The generated text repeats a long name a few times.
#[test]
fn long_names_are_not_multiplied() {
    let name = "\u{202e}\"x".repeat(20_000);
    let [_, others @ ..] = PLAIN;
    let names: Vec<&str> = std::iter::once(&*name).chain(others).collect();
    let text = urdf(names.try_into().expect("six names"));
    let builder = Builder::new().urdf_text(text, "robot.urdf").functions([]);
    let generated = builder.generate().expect("a robot with a long name");
    assert_eq!(generated.model.name(), name);
    assert!(generated.text.len() < 20 * name.len(), "{}", generated.text.len());
    assert!(!generated.text.contains('\u{202e}'));
}
