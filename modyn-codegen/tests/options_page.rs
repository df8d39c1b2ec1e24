//! The table of options, against everything that must know each: the builder, the first lines of generated files, the
//! page of the documentation and the macro's.

use std::fmt::Write as _;
use std::path::Path;

use modyn_codegen::Builder;
use modyn_codegen::options::{Entries, OPTIONS, OptionRow, Value};

/// The value of the row's example.
fn example(row: &OptionRow) -> Value {
    let text = row.is_text() && !row.is_list();
    if text { Value::text(row.example) } else { Value::parse(row.example).expect(row.name) }
}

/// The first lines of the file that a builder writes.
fn head(builder: &Builder) -> String {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("options_page");
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("robot.rs");
    builder.write(&file).unwrap_or_else(|errors| panic!("{errors}"));
    let text = std::fs::read_to_string(&file).expect("a file");
    let lines = text.lines().take_while(|line| line.starts_with("//"));
    lines.map(|line| line.to_owned() + "\n").collect()
}

/// An arm that fits the examples.
const ARM: &str = r#"<robot name="arm">
    <link name="base"><inertial><origin xyz="0 0 0.1"/><mass value="3"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="shoulder" type="continuous">
        <parent link="base"/><child link="upper_arm"/><axis xyz="0 1 0"/>
        <dynamics damping="0.1" friction="0.1"/>
    </joint>
    <link name="upper_arm"><inertial><origin xyz="0.1 0 0.2"/><mass value="2"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="elbow" type="continuous">
        <parent link="upper_arm"/><child link="forearm"/><origin xyz="0 0 0.5"/><axis xyz="0 1 0"/>
    </joint>
    <link name="forearm"><inertial><origin xyz="0 0.1 0.2"/><mass value="1"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="wrist" type="continuous">
        <parent link="forearm"/><child link="hand"/><origin xyz="0 0 0.4"/><axis xyz="1 0 0"/>
    </joint>
    <link name="hand"><inertial><origin xyz="0 0.1 0.1"/><mass value="1"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
"#;

/// The parts of a crank with a rod, for loops.
const CRANK: &str = r#"
    <joint name="turn" type="continuous">
        <parent link="base"/><child link="crank"/><origin xyz="1 0 0"/><axis xyz="0 1 0"/>
    </joint>
    <link name="crank"><inertial><origin xyz="0.2 0 0.1"/><mass value="1"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="push" type="continuous">
        <parent link="base"/><child link="rod"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    </joint>
    <link name="rod"><inertial><origin xyz="0.2 0 0.1"/><mass value="1"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
"#;

#[test]
fn a_generated_file_says_each_option() {
    for row in OPTIONS {
        let crank = if row.name == "loops" { CRANK } else { "" };
        let robot = format!("{ARM}{crank}</robot>");
        let plain = Builder::new().urdf_text(robot, "arm.urdf");
        let call = format!(".{}(", row.method);
        let without = head(&plain);
        assert!(!without.contains(&call), "{}: {without}", row.name);
        let with = head(&plain.set(row.name, &example(row)).expect(row.name));
        assert!(with.contains(&call), "{}: {with}", row.name);
    }
}

#[test]
fn a_value_of_another_form_is_refused() {
    for row in OPTIONS {
        let wrong = Value::parse("no(such, value)").expect("a value");
        let fault = Builder::new().set(row.name, &wrong).expect_err(row.name);
        assert!(fault.message.len() > 10, "{}: {}", row.name, fault.message);
    }
    assert!(Builder::new().set("colour", &Value::text("red")).is_err());
}

/// The table as Markdown: all of it, or the columns for the macro.
fn table(rows: impl Iterator<Item = &'static OptionRow>, whole: bool) -> String {
    let mut text = String::from("| option | values | default | meaning |");
    let (head, columns) = if whole { (" example | command line |", 6) } else { ("", 4) };
    let _ = writeln!(text, "{head}\n|{}", "---|".repeat(columns));
    for row in rows {
        let OptionRow { name, default, docs, .. } = row;
        // A bar in a table's cell has a backslash.
        let escaped = |text: &str| text.replace('|', "\\|");
        let form = if row.form == "links" { "[\"link\", ...]" } else { row.form };
        let _ = write!(text, "| `{name}` | `{}` | {default} | {} |", escaped(form), docs.trim());
        if whole {
            let long = name.replace('_', "-");
            let given = match (row.is_flag(), row.is_list()) {
                (true, _) => format!("`--{long}`"),
                (_, true) => format!("`--{long} ITEM`, several times"),
                _ => format!("`--{long} VALUE`"),
            };
            let _ = write!(text, " `{}` | {given} |", escaped(row.example));
        }
        text.push('\n');
    }
    text
}

/// The page.
fn page() -> String {
    let files = OPTIONS.iter().filter(|row| row.entries == Entries::Files);
    let files: Vec<String> = files.map(|row| format!("`{}`", row.name)).collect();
    format!(
        "# Options at each entry\n\n\
         Each option has one name at every entry: the macro (`modyn!(\"arm.urdf\", scalar = f32)`), the builder\n\
         (`Builder::new().scalar(FloatType::F32)`; `crate_` for `crate`, which is a keyword), the command line\n\
         (`--scalar f32`) and the first lines of generated files. Values have one syntax. On the command line outer\n\
         brackets and the quotes around plain names can be left out, and a flag has no value.\n\n\
         This page is made from the table in `modyn-codegen/src/options.rs`.\n\n{}\n\
         The macro does not have {}: it names the type as `pub(crate) Name = \"robot.urdf\"`, and writes no file.\n\n\
         The first lines of a file that `modyn generate` wrote say the options that it was made with. The\n\
         documentation of the generated type lists its scalar, functions, gravity, friction and run-time parameters;\n\
         its tables show the joints, links and modules that the other options lead to. C source is `Builder::generate_c` or `--target c`, and the\n\
         header of exported functions `Generated::c_header` or `--c-header`.\n",
        table(OPTIONS.iter(), true),
        files.join(", "),
    )
}

/// With the variable `UPDATE_SNAPSHOTS`, they are written.
#[test]
fn the_pages_have_the_table() {
    let of_macro = OPTIONS.iter().filter(|row| row.entries == Entries::All);
    for (path, text) in
        [("docs/options.md", page()), ("modyn-macro/options.md", table(of_macro, false))]
    {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
        if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
            std::fs::write(&file, &text).expect("writes");
        }
        let found = std::fs::read_to_string(&file).expect(path).replace("\r\n", "\n");
        assert_eq!(found, text, "{path}");
    }
}
