//! The Python package: a method, a type of results and a stub for each function of the table, and a
//! stub of each option.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use modyn_codegen::Function;
use modyn_codegen::options::{Entries, OPTIONS, OptionRow, Stage, Value};
use modyn_codegen::plan::{Elements, Record, Row, Shape, Sizes};

/// Sizes that are numbers of their own, so that the lengths of axes name them.
pub(super) const SIZES: Sizes = Sizes {
    nq: 1009,
    nv: 1013,
    links: 1019,
    moving: 1021,
    quaternions: 1087,
    constraints: 1031,
    contacts: 1033,
    constraint_rows: 1039,
    factors: 1049,
    touching_shapes: 1051,
    touching_points: 1061,
    controls: 1063,
    activations: 1069,
};

/// Returns the name of the length of an axis.
fn length(n: usize) -> String {
    let sizes = [
        (SIZES.nq, "nq"),
        (SIZES.nv, "nv"),
        (2 * SIZES.nv, "2 nv"),
        (2 * SIZES.nv + SIZES.activations, "2 nv + activations"),
        (SIZES.links, "links"),
        (SIZES.quaternions, "quaternions"),
        (10 * SIZES.moving, "10 moving links"),
        (SIZES.constraints, "constraints"),
        (SIZES.contacts, "contacts"),
        (3 * SIZES.contacts, "3 contacts"),
        (SIZES.touching_shapes, "touching shapes"),
        (SIZES.touching_points, "touching points"),
        (SIZES.controls, "controls"),
        (SIZES.activations, "activations"),
        (SIZES.constraint_rows, "constraint rows"),
    ];
    let named = sizes.iter().find(|(size, _)| *size == n);
    named.map_or_else(|| n.to_string(), |(_, name)| (*name).to_owned())
}

/// Returns a shape as Python writes it.
fn tuple(axes: &[usize]) -> String {
    match axes {
        [] => "a number".into(),
        [one] => format!("({},)", length(*one)),
        _ => {
            let axes: Vec<String> = axes.iter().map(|&n| length(n)).collect();
            format!("({})", axes.join(", "))
        }
    }
}

/// Returns the axes of an argument.
fn argument(name: &str, shape: &Shape) -> String {
    match (name, shape) {
        ("settings", _) => {
            "`ConstraintSettings`, by default with the ground at z = 0 under all contacts".into()
        }
        ("step_settings", _) => {
            "`StepSettings`, by default the result of `step_settings()`".into()
        }
        ("warm_start" | "applied", _) => "(nv,), by default zeros".into(),
        ("act_cotangent" | "tangent_act", _) => "(activations,), by default zeros".into(),
        ("act", _) => "(activations,), which a robot without activations leaves out".into(),
        ("active", _) => {
            "the names of the active contacts, or (contacts,), 1 for each active one, else 0; by default all are".into()
        }
        (_, Shape::Scalar) => "a number".into(),
        (_, Shape::Array(inner, n, _)) if **inner != Shape::Scalar => {
            tuple(&[*n, inner.len()]) + components(inner)
        }
        _ => tuple(&[shape.len()]),
    }
}

/// Returns the order of the components of a shape's spatial vectors, after a comma.
fn components(shape: &Shape) -> &'static str {
    match shape {
        Shape::Scalar => "",
        Shape::Array(inner, ..) => components(inner),
        Shape::Record(Record::Spatial("Twist" | "Momentum"), _) => {
            ", linear before angular components"
        }
        Shape::Record(Record::Spatial("Wrench"), _) => ", forces before moments",
        Shape::Record(_, fields) => {
            let all = fields.iter().map(|(_, field)| components(field));
            all.max_by_key(|text| text.len()).unwrap_or_default()
        }
    }
}

/// An array or a named tuple of a result.
#[derive(Clone)]
enum Layout {
    Array(Vec<usize>),
    Tuple(&'static str, Fields),
}

/// Returns the layout of a result after the axes `outer`.
fn layout(shape: &Shape, outer: &[usize]) -> Layout {
    let array = |axes: &[usize]| Layout::Array([outer, axes].concat());
    match shape {
        Shape::Scalar => array(&[]),
        Shape::Array(inner, n, _) if **inner == Shape::Scalar => array(&[*n]),
        Shape::Array(inner, n, Elements::Columns) if inner.is_vector() => array(&[inner.len(), *n]),
        Shape::Array(inner, n, _) if inner.is_vector() => array(&[*n, inner.len()]),
        Shape::Array(inner, n, _) => layout(inner, &[outer, &[*n]].concat()),
        Shape::Record(record, fields) => match record.result_type() {
            None => array(&[shape.len()]),
            Some(name) => {
                let field = |(field, shape): &(&'static str, Shape)| (*field, layout(shape, outer));
                Layout::Tuple(name, fields.iter().map(field).collect())
            }
        },
    }
}

/// Returns the layout of a function's result.
fn result(row: &Row) -> Layout {
    layout(&(row.result)(&SIZES), &[])
}

/// Returns the functions that are methods of their own.
fn functions() -> impl Iterator<Item = (usize, Function, Row)> {
    let all = Function::ALL.iter().copied().enumerate().map(|(i, f)| (i, f, f.row()));
    // `brge` returns an object with the operations of its factors.
    all.filter(|(_, function, row)| row.batch_of.is_none() && *function != Function::Brge)
}

/// Returns the documentation of a function in Python's terms.
fn docs(row: &Row) -> String {
    let mut text = row.docs.to_owned();
    for part in [", each an array of columns", ", an array of columns", ", arrays of columns"] {
        text = text.replace(part, "");
    }
    text = text.replace(" Both matrices are arrays of columns; each", " Each");
    text = text.replace("The blocks of the Hessian are arrays of columns; the", "The");
    let constants = [
        "LINK_NAMES",
        "LOOP_CONSTRAINT_NAMES",
        "CONTACT_NAMES",
        "CONTROL_NAMES",
        "ACTIVATION_NAMES",
        "PARAMETERS",
    ];
    for name in constants {
        text = text.replace(&format!("`{name}`"), &format!("`{}`", name.to_lowercase()));
    }
    text.replace("`from`", "`from_`").replace("`step_settings`", "`settings`")
}

/// Returns the documentation with the shapes of arguments and results, in lines.
fn documentation(row: &Row) -> Vec<String> {
    let mut lines = wrap(&docs(row), 92);
    lines.push(String::new());
    let mut arguments: Vec<String> = (row.arguments.iter())
        .map(|own| format!("`{}`: {}", python(own.name), argument(own.name, &own.shape(&SIZES))))
        .collect();
    if row.by_link {
        arguments.push("`link`: the name of a link, or its index in `link_names`".into());
    }
    let result = match result(row) {
        Layout::Array(axes) => tuple(&axes),
        Layout::Tuple(name, fields) => {
            format!("`{name}`: {}", fields_with_shapes(&fields).join(", "))
        }
    };
    let result = result + components(&(row.result)(&SIZES));
    lines.extend(wrap(&format!("Arguments: {}.", arguments.join("; ")), 92));
    lines.extend(wrap(
        &format!("Result: {result}. Several states have one more axis, the first."),
        92,
    ));
    lines
}

/// Returns the fields of a result, each with the lengths of its axes.
fn fields_with_shapes(fields: &Fields) -> Vec<String> {
    let field = |(field, layout): &(&str, Layout)| match layout {
        Layout::Array(axes) => format!("`{field}` {}", tuple(axes)),
        Layout::Tuple(..) => format!("`{field}`"),
    };
    fields.iter().map(field).collect()
}

/// Returns the shape of a function's result, or each field with its shape.
pub(super) fn results_of(row: &Row) -> Vec<String> {
    match result(row) {
        _ if row.function == Function::Brge => vec!["factors".into()],
        Layout::Array(axes) => vec![tuple(&axes)],
        Layout::Tuple(_, fields) => fields_with_shapes(&fields),
    }
}

/// Returns a text in lines of at most this length.
pub(super) fn wrap(text: &str, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.len() + 1 + word.len() <= most => *line += &format!(" {word}"),
            _ => lines.push(word.into()),
        }
    }
    lines
}

/// Returns the name of an argument in Python, where `from` is a keyword, and each function has one
/// kind of settings.
fn python(name: &str) -> &str {
    match name {
        "from" => "from_",
        "step_settings" => "settings",
        name => name,
    }
}

/// Returns whether an argument has a default.
fn is_optional(name: &str) -> bool {
    let optional =
        ["active", "settings", "warm_start", "act", "act_cotangent", "tangent_act", "applied"];
    optional.contains(&name)
}

/// Returns the methods in Rust.
pub(super) fn methods() -> String {
    let mut text = String::new();
    for (index, function, row) in functions() {
        for line in documentation(&row) {
            let _ = writeln!(text, "{}", format!("    /// {line}").trim_end());
        }
        let (mut signature, mut types, mut given) = (String::new(), String::new(), Vec::new());
        for name in row.arguments.iter().map(|own| python(own.name)) {
            let (default, kind, value) = match is_optional(name) {
                true => ("=None", "Argument<'_, 'py>", name.to_owned()),
                false => ("", "&Bound<'py, PyAny>", format!("Some({name})")),
            };
            signature += &format!("{name}{default}, ");
            types += &format!("{name}: {kind},\n        ");
            given.push(value);
        }
        let mut link = "None";
        if row.by_link {
            signature += "link, ";
            types += "link: &Bound<'py, PyAny>,\n        ";
            link = "Some(link)";
        }
        let _ = writeln!(
            text,
            "    #[pyo3(signature = ({signature}*, out=None))]\n    \
             fn {}<'py>(\n        &self,\n        py: Python<'py>,\n        {types}\
             out: Argument<'_, 'py>,\n    ) -> PyResult<Bound<'py, PyAny>> {{\n        \
             self.call(py, {index}, &[{}], {link}, out)\n    }}\n",
            function.name(),
            given.join(", "),
        );
    }
    text.trim_end().to_owned() + "\n"
}

/// The fields of a named tuple.
type Fields = Vec<(&'static str, Layout)>;

/// Returns the named tuples of results by name.
fn tuples() -> BTreeMap<&'static str, Fields> {
    fn add(layout: Layout, all: &mut BTreeMap<&'static str, Fields>) {
        let Layout::Tuple(name, fields) = layout else { return };
        fields.iter().for_each(|(_, inner)| add(inner.clone(), all));
        all.entry(name).or_insert(fields);
    }
    let mut all = BTreeMap::new();
    functions().for_each(|(_, _, row)| add(result(&row), &mut all));
    all
}

/// Returns the types of results in Python.
pub(super) fn results() -> String {
    let names: String = tuples().keys().map(|name| format!("    \"{name}\",\n")).collect();
    let mut text = format!("__all__ = [\n{names}]\n");
    for (name, fields) in tuples() {
        let is_result = |row: &Row| matches!(result(row), Layout::Tuple(own, _) if own == name);
        let functions = functions().filter(|(_, _, row)| is_result(row));
        let functions: Vec<String> = functions.map(|(_, f, _)| format!("`{}`", f.name())).collect();
        let of = match functions.is_empty() {
            true => String::new(),
            false => format!(" of {}", functions.join(", ")),
        };
        let _ = writeln!(text, "\n\nclass {name}(NamedTuple):\n    \"\"\"The result{of}.\"\"\"\n");
        for (field, layout) in &fields {
            let (class, shape) = match layout {
                Layout::Array(axes) => ("NDArray[Any]", tuple(axes)),
                Layout::Tuple(name, _) => (*name, (*name).to_owned()),
            };
            let _ = writeln!(text, "    {field}: {class}\n    \"\"\"{shape}\"\"\"");
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    text
}

/// Returns the options that `load` takes.
fn options() -> impl Iterator<Item = &'static OptionRow> {
    let of_text = ["functions", "share_limbs", "embed_model", "code", "crate"];
    OPTIONS.iter().filter(move |row| {
        row.entries == Entries::All && (row.stage == Stage::Reading || !of_text.contains(&row.name))
    })
}

/// Returns the type of an option in Python.
fn option_type(row: &OptionRow) -> &'static str {
    match row.form {
        "[x, y, z]" => "Sequence[float]",
        "true | false" => "bool",
        "links" => "Sequence[str]",
        form if form.starts_with("[\"") => "Mapping[str, Any] | str",
        form if form.contains("plane(") => "str | tuple[Any, ...]",
        form if form.contains("smooth(") => "str | tuple[str, float]",
        form if form.contains("[[") => "str | Sequence[Sequence[str]]",
        _ => "str",
    }
}

/// Returns the keyword arguments of `load` in the stub.
pub(super) fn option_stubs() -> String {
    let mut text = String::new();
    for row in options() {
        let value = Value::parse(row.example).expect("an example is a value");
        let default = match Value::parse(row.default.trim_matches('`')) {
            Ok(value) if row.is_flag() => format!("`{}`", value.in_python()),
            _ => row.default.into(),
        };
        let example = value.in_python();
        let docs = format!("{} Default: {default}. For example: `{example}`.", row.docs.trim());
        let _ = writeln!(text, "    {}: {} | None", row.name, option_type(row));
        let lines = wrap(&docs, 108);
        let _ = writeln!(text, "    \"\"\"{}\"\"\"", lines.join("\n    "));
    }
    text
}

/// Returns the methods in the stub.
pub(super) fn method_stubs() -> String {
    let mut text = String::new();
    for (_, function, row) in functions() {
        let mut arguments: Vec<String> = (row.arguments.iter())
            .map(|own| match own.name {
                "settings" => "settings: ConstraintSettings | ArrayLike | None = None".into(),
                "step_settings" => "settings: StepSettings | ArrayLike | None = None".into(),
                name if is_optional(name) => format!("{name}: ArrayLike | None = None"),
                name => format!("{}: ArrayLike", python(name)),
            })
            .collect();
        if row.by_link {
            arguments.push("link: str | int".into());
        }
        let result = match result(&row) {
            Layout::Tuple(name, _) => name.to_owned(),
            Layout::Array(axes) if axes.is_empty() => "float | Array".into(),
            Layout::Array(_) => "Array".into(),
        };
        let out = if result.ends_with("Array") { "Array" } else { &result };
        let _ = writeln!(
            text,
            "    def {}(\n        self, {}, *, out: {out} | None = None\n    ) -> {result}:",
            function.name(),
            arguments.join(", "),
        );
        let lines = documentation(&row);
        let _ = writeln!(text, "        \"\"\"{}", lines[0]);
        for line in &lines[1..] {
            let _ = writeln!(text, "{}", format!("        {line}").trim_end());
        }
        text += "        \"\"\"\n";
    }
    text
}
