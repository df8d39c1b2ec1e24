//! The form of the generated text: the same bytes on every host, no code that can panic or allocate, no `unsafe`, no
//! block too long for rustc, and names in string literals only.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use modyn_codegen::{Builder, FloatType, Function, Generated, ModuleChoice};
use modyn_tests::fleet::Spec;
use syn::visit::{self, Visit};

/// The largest number of statements in a block and in a function: the limits of `modyn-codegen/src/program/outline.rs`,
/// and a few statements around them (names of parameters, calls of chunks).
const BLOCK: usize = 260;
const FUNCTION: usize = 3100;

fn robots() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots");
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut robots: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    robots.retain(|path| path.extension().is_some_and(|extension| extension == "urdf"));
    robots.sort();
    assert!(robots.len() >= 6, "{robots:?}");
    robots
}

fn compiled(path: &Path) -> Generated {
    Builder::new().urdf(path).generate().expect("a good robot")
}

/// Returns the generated texts with the default functions, and what is in them.
fn plain() -> &'static [(PathBuf, String, Findings)] {
    static ONCE: OnceLock<Vec<(PathBuf, String, Findings)>> = OnceLock::new();
    ONCE.get_or_init(|| {
        let found = |path: PathBuf| {
            let text = compiled(&path).text;
            let findings = Findings::of(&text);
            (path, text, findings)
        };
        robots().into_iter().map(found).collect()
    })
}

/// Returns the generated texts with all functions of one state and run-time parameters, of robots up to this number of
/// degrees of freedom. The limit is there because the compiler runs unoptimised in this test.
fn complete(path: &Path, most: usize) -> Option<Generated> {
    let plain = Builder::new().urdf(path).runtime_gravity();
    let model = compiled(path).model;
    let last = model.links().iter().rev().find(|link| link.moving_link.is_some())?;
    let builder =
        plain.runtime_inertia([&last.name]).payload([&last.name]).functions(Spec::all_functions());
    (model.nv() <= most).then(|| builder.generate().expect("a good robot"))
}

/// Returns all texts together, with options that change the text.
fn everything() -> String {
    let mut all = String::new();
    for path in robots() {
        all += &compiled(&path).text;
        all.extend(complete(&path, 5).map(|complete| complete.text));
        let others = Builder::new().urdf(&path).scalar(FloatType::F32).modules(ModuleChoice::Links);
        all += &others.gravity([0.1, 0.2, 0.3]).generate().expect("a good robot").text;
    }
    all
}

/// Returns all texts, generated once.
fn shared() -> &'static str {
    static ONCE: OnceLock<String> = OnceLock::new();
    ONCE.get_or_init(everything)
}

const WRITE_TO: &str = "MODYN_TEST_WRITE_TO";

/// Writes the texts, only in the process that the next test starts.
#[test]
fn writes_everything() {
    if let Some(path) = std::env::var_os(WRITE_TO) {
        std::fs::write(path, everything()).expect("a file");
    }
}

#[test]
fn the_same_bytes_twice_and_in_every_process() {
    let all = shared();
    // Another thread has new thread-locals, which another robot used before.
    let later = || {
        compiled(&robots()[1]);
        everything()
    };
    let other = std::thread::spawn(later).join().expect("no panic");
    assert!(all == other, "two runs differ");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("everything.rs");
    let own = std::env::current_exe().expect("a path");
    let mut command = Command::new(own);
    command.args(["--exact", "output::writes_everything"]).env_clear().env(WRITE_TO, &path);
    // The working directory, the language and the clock must not matter.
    command.current_dir(std::env::temp_dir()).env("LC_ALL", "de_DE.UTF-8").env("TZ", "Asia/Tokyo");
    assert!(command.status().expect("it starts").success());
    assert!(std::fs::read_to_string(&path).expect("a file") == all, "two processes differ");
}

/// The elements of a text.
#[derive(Default)]
struct Findings {
    identifiers: BTreeSet<String>,
    strings: BTreeSet<String>,
    docs: String,
    longest_block: usize,
    longest_function: usize,
    statements: usize,
    /// Whether an index is not a literal.
    indexing: usize,
    loops: usize,
}

impl Findings {
    fn of(text: &str) -> Self {
        let mut findings = Self::default();
        findings.visit_file(&syn::parse_file(text).expect("Rust"));
        findings
    }
}

impl Visit<'_> for Findings {
    fn visit_ident(&mut self, ident: &syn::Ident) {
        self.identifiers.insert(ident.to_string());
    }

    fn visit_lit_str(&mut self, literal: &syn::LitStr) {
        self.strings.insert(literal.value());
    }

    fn visit_attribute(&mut self, attribute: &syn::Attribute) {
        if let syn::Meta::NameValue(syn::MetaNameValue {
            value: syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(doc), .. }),
            ..
        }) = &attribute.meta
        {
            self.docs += &doc.value();
            self.docs.push('\n');
        }
    }

    fn visit_macro(&mut self, called: &syn::Macro) {
        panic!("a macro is called: {:?}", called.path.segments.last().map(|s| s.ident.to_string()));
    }

    fn visit_item_fn(&mut self, function: &syn::ItemFn) {
        let before = std::mem::take(&mut self.statements);
        visit::visit_item_fn(self, function);
        self.longest_function = self.longest_function.max(self.statements);
        self.statements += before;
    }

    fn visit_block(&mut self, block: &syn::Block) {
        self.longest_block = self.longest_block.max(block.stmts.len());
        self.statements += block.stmts.len();
        visit::visit_block(self, block);
    }

    fn visit_expr_index(&mut self, index: &syn::ExprIndex) {
        // rustc checks a literal index of an array at compile time.
        self.indexing += usize::from(!matches!(*index.index, syn::Expr::Lit(_)));
        visit::visit_expr_index(self, index);
    }

    fn visit_expr(&mut self, expr: &syn::Expr) {
        use syn::Expr::{ForLoop, Loop, Unsafe, While};
        assert!(!matches!(expr, Unsafe(_)), "unsafe");
        self.loops += usize::from(matches!(expr, ForLoop(_) | Loop(_) | While(_)));
        visit::visit_expr(self, expr);
    }
}

#[test]
fn nothing_panics_allocates_or_is_unsafe() {
    let complete = |path: PathBuf| {
        let text = complete(&path, 6)?.text;
        let findings = Findings::of(&text);
        Some((path, text, findings))
    };
    let complete: Vec<_> = robots().into_iter().filter_map(complete).collect();
    assert!(complete.len() >= 4, "{}", complete.len());
    for (path, text, Findings { identifiers, indexing, loops, .. }) in
        plain().iter().chain(&complete)
    {
        // The solver of a step has a bounded number of iterations.
        let of_solvers = text.matches("for _ in 0..").count();
        assert_eq!((*indexing, *loops), (0, of_solvers), "{}", path.display());
        for word in [
            "unsafe",
            "std",
            "alloc",
            "panic",
            "unwrap",
            "expect",
            "assert",
            "unreachable",
            "todo",
            "vec",
            "Vec",
            "Box",
            "String",
            "format",
            "transmute",
            "dyn",
        ] {
            assert!(!identifiers.contains(word), "{}: `{word}`", path.display());
        }
        // The word is also found where it is not an identifier, such as in `unsafe fn`.
        let code: String =
            text.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
        for part in ["unsafe", "std::", "alloc", "panic", "unwrap"] {
            assert!(!code.contains(part), "{}: `{part}`", path.display());
        }
    }
}

#[test]
fn nothing_is_too_long_for_rustc() {
    let mut longest = (0, 0);
    for (path, _, found) in plain() {
        longest = (longest.0.max(found.longest_block), longest.1.max(found.longest_function));
        assert!(found.longest_block <= BLOCK, "{}: {}", path.display(), found.longest_block);
        assert!(
            found.longest_function <= FUNCTION,
            "{}: {}",
            path.display(),
            found.longest_function
        );
    }
    // The largest robot reaches the limits, so the test of them is not empty.
    assert!(longest.0 > 200 && longest.1 > 1000, "{longest:?}");
}

#[test]
fn no_path_of_this_host_is_in_the_text() {
    let all = shared();
    for path in [env!("CARGO_MANIFEST_DIR"), env!("CARGO_TARGET_TMPDIR"), "robots/", ".urdf"] {
        assert!(!all.contains(path), "{path}");
    }
}

/// Returns the names of the functions of a generated text, with private functions, without those that cannot be called.
fn functions(text: &str) -> BTreeSet<String> {
    struct Functions(BTreeSet<String>);
    impl Visit<'_> for Functions {
        fn visit_signature(&mut self, signature: &syn::Signature) {
            // The stand-in for a function that the robot does not have returns nothing.
            let returned = &signature.output;
            if !matches!(returned, syn::ReturnType::Type(_, to) if matches!(**to, syn::Type::Never(_)))
            {
                self.0.insert(signature.ident.to_string());
            }
        }
    }
    let mut functions = Functions(BTreeSet::new());
    functions.visit_file(&syn::parse_file(text).expect("Rust"));
    functions.0
}

#[test]
fn a_robot_has_the_functions_that_were_asked_for() {
    let gripper = robots().into_iter().find(|path| path.ends_with("gripper.urdf"));
    let builder = Builder::new().urdf(gripper.expect("a gripper"));
    // Batches are tested in `batch.rs`.
    let all: Vec<Function> = Spec::all_functions().collect();
    for asked in [
        &[Function::ForwardDynamics][..],
        &[Function::Regressor, Function::LinkVelocity, Function::LinkVelocity],
        &[],
        Function::DEFAULT,
        &all,
    ] {
        let generated = builder.clone().functions(asked.iter().copied()).generate();
        let generated = generated.expect("a good robot");
        let found = functions(&generated.text);
        for function in &all {
            let name = function.name();
            // The gripper has no constraints.
            let expected = asked.contains(function) && function.row().is_general();
            assert_eq!(found.contains(name), expected, "{name}");
            let constant = format!("pub const {}_OPERATIONS:", name.to_uppercase());
            assert_eq!(generated.text.contains(&constant), expected, "{name}");
        }
        assert_eq!(
            generated.text.contains("GripperUduFactorization<"),
            asked.contains(&Function::Brge)
        );
        let announced = generated.operations.iter().map(|(name, _)| *name);
        let expected = all.iter().filter(|f| asked.contains(f) && f.row().is_general());
        let expected = expected.map(|f| f.name());
        assert!(announced.eq(expected));
    }
}

const ODD: &[&str] = &[
    "quote \" and \"# and \"##",
    "line\nbreak\r\nand\ttab\u{b}\u{85}\u{2028}\u{2029}",
    "*/ comment /* // ///",
    "fn",
    "Self",
    "self",
    "r#type",
    "\\ \\\" \\u{41} {} {{}} {0}",
    "\u{e9}t\u{e9} \u{96c6} \u{1f916} \u{202e}rtl",
    "`code` | [link](x) <b> ``` #",
    "' '\\'' b'",
    "}; compile_error!(\"no\"); const _: () = {",
    "#[doc = \"",
    "0",
    "-",
    "_",
    "\u{0301}",
    "a\u{0}b",
    INVISIBLE,
];

/// Characters that rustc denies in comments and literals, and other invisible characters.
const INVISIBLE: &str = "a\u{61c}\u{200b}\u{200d}\u{200e}\u{200f}\u{2028}\u{2029}\u{202a}\u{202b}\u{202c}\u{202d}\u{202e}\
                         \u{2060}\u{2066}\u{2067}\u{2068}\u{2069}\u{feff}\u{ad}b";

/// Returns a chain whose robot, joints and links have these names.
fn chain(robot: &str, names: &[String]) -> modyn_runtime::model::Model {
    // XML cannot contain some of them, but a model can.
    let mut urdf = String::from("<robot name=\"0\"><link name=\"root\"/>");
    for i in 0..names.len() {
        let parent = i.checked_sub(1).map_or("root".into(), |p| format!("l{p}"));
        urdf += &format!(
            "<joint name=\"j{i}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"l{i}\"/>\
             <axis xyz=\"0 {} {}\"/></joint><link name=\"l{i}\"><inertial><origin xyz=\"0.5 0 0\"/>\
             <mass value=\"1\"/><inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>\
             </inertial></link>",
            i % 2,
            (i + 1) % 2,
        );
    }
    urdf += "</robot>";
    let escape = |name: &str| name.chars().map(|c| format!("&#{};", c as u32)).collect::<String>();
    let mut urdf = urdf.replacen("name=\"0\"", &format!("name=\"{}\"", escape(robot)), 1);
    for (i, name) in names.iter().enumerate().rev() {
        let name = escape(name);
        urdf = urdf.replace(&format!("\"l{i}\""), &format!("\"{name}\""));
        urdf = urdf.replace(&format!("name=\"j{i}\""), &format!("name=\"{name}\""));
    }
    let read = modyn_codegen::read(&urdf, "odd.urdf", &Default::default());
    read.expect("odd, but good").model
}

#[test]
fn names_are_nothing_but_strings() {
    // XML has no NUL.
    let names: Vec<String> = ODD.iter().map(|name| name.replace(['\0', '\u{b}'], "?")).collect();
    for robot in &names {
        // First all names together, then each of them as the name of a robot with one joint.
        let links = if *robot == names[0] { &names[..] } else { &names[..1] };
        let model = chain(robot, links);
        let generated = Builder::new().model(model).generate().expect("a good robot");
        let hidden =
            generated.text.chars().find(|&c| c != 'a' && c != 'b' && INVISIBLE.contains(c));
        assert_eq!(hidden, None, "{robot:?}");
        let found = Findings::of(&generated.text);
        for name in links.iter().chain([robot]) {
            assert!(found.strings.contains(name), "{name:?} is kept");
        }
        let plain = chain("plain", &(0..links.len()).map(|i| format!("x{i}")).collect::<Vec<_>>());
        let builder = Builder::new().model(plain).type_name(&generated.type_name);
        let plain = Findings::of(&builder.generate().expect("a good robot").text);
        // The text is the same except for the variants of the enums, which consist of letters, digits and underscores.
        let others: Vec<_> = found.identifiers.difference(&plain.identifiers).collect();
        assert!(others.len() <= 2 * links.len() + 1, "{others:?}");
        for other in others {
            assert!(other.chars().all(|c| c == '_' || c.is_ascii_alphanumeric()), "{other}");
        }
        assert_eq!(found.docs.lines().count(), plain.docs.lines().count(), "{robot:?}");
    }
}
