//! Keyword arguments as options: values of Python as values of modyn's option table.

use modyn_codegen::options::{
    Entries, OPTIONS, OptionError, OptionRow, OptionValue, Stage, Value, ValueKind, unknown_option,
};
use modyn_codegen::{Builder, FloatType, FusedFunction, ModuleChoice};
use modyn_runtime::model::{Model, ModuleTree};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyString, PyTuple, PyType};

/// The options about code that have no meaning for machine code.
const OF_TEXT: &[&str] = &["functions", "share_limbs", "embed_model", "code", "crate"];

/// Returns the options that `load` takes.
pub fn rows() -> impl Iterator<Item = &'static OptionRow> {
    OPTIONS.iter().filter(|row| {
        row.entries == Entries::All && (row.stage == Stage::Reading || !OF_TEXT.contains(&row.name))
    })
}

/// Returns the builder with these options.
///
/// # Errors
///
/// `TypeError` if there is no such option, `ValueError` if its value has another form.
pub fn apply(mut builder: Builder, options: &Bound<'_, PyDict>) -> PyResult<Builder> {
    for (name, value) in options {
        let name: String = name.extract()?;
        let Some(row) = rows().find(|row| row.name == name) else {
            let known: Vec<&str> = rows().map(|row| row.name).collect();
            return Err(PyTypeError::new_err(unknown_option(&name, &known)));
        };
        if value.is_none() {
            continue;
        }
        // A path is a text, too.
        let value = plain(&value).unwrap_or(value);
        let is_text = value.is_instance_of::<PyString>();
        let value = match value.cast::<PyString>() {
            Ok(text) if row.is_text() => Value::text(text.to_cow()?),
            _ => parsed(&name, &value)?,
        };
        builder = builder.set(&name, &value).map_err(|fault| wrong(row, is_text, fault))?;
    }
    Ok(builder)
}

/// Returns the row of an option in Python.
fn row(name: &str) -> &'static OptionRow {
    rows().find(|row| row.name == name).expect("an option of `load`")
}

/// Returns the exception of a value with a fault. It shows the value as Python writes it, unless
/// the value was a text in the syntax of the command line.
fn wrong(row: &OptionRow, is_text: bool, fault: OptionError) -> PyErr {
    let OptionRow { name, form, docs, .. } = row;
    let OptionError { message, is_form, .. } = fault;
    let example = example(row);
    PyValueError::new_err(match (is_form, is_text) {
        (true, true) => format!("option `{name}`: {message}; its form is {form}"),
        (true, false) => {
            format!("option `{name}`: the value has another form than in {name}={example}.{docs}")
        }
        (false, _) => format!("option `{name}`: {message}; for example {name}={example}"),
    })
}

/// Returns a value of an option as Python has it.
pub fn example(row: &OptionRow) -> String {
    Value::parse(row.example).map_or_else(|_| row.example.into(), |value| value.in_python())
}

/// Returns the fused functions of the option `fused`.
///
/// # Errors
///
/// `ValueError` if the value has another form, or a fused function cannot have a function.
pub fn fused(wanted: &Bound<'_, PyAny>) -> PyResult<Vec<FusedFunction>> {
    let value = parsed("fused", wanted)?;
    let fused = value.items().iter().map(FusedFunction::read);
    let is_text = wanted.is_instance_of::<PyString>();
    fused.collect::<Result<_, _>>().map_err(|fault| wrong(row("fused"), is_text, fault))
}

/// Returns the scalar of the option `scalar`.
///
/// # Errors
///
/// `ValueError` if it is no scalar.
pub fn scalar(options: &Bound<'_, PyDict>) -> PyResult<FloatType> {
    let wanted = options.get_item("scalar")?.filter(|wanted| !wanted.is_none());
    let scalar = wanted.map(|wanted| {
        FloatType::read(&parsed("scalar", &wanted)?)
            .map_err(|fault| PyValueError::new_err(format!("option `scalar`: {}", fault.message)))
    });
    Ok(scalar.transpose()?.unwrap_or_default())
}

/// Returns the kinematic modules of the option `modules`.
///
/// # Errors
///
/// `ValueError` if they are no modules of the robot.
pub fn modules(options: &Bound<'_, PyDict>, model: &Model) -> PyResult<ModuleTree> {
    let wrong = |message: &str| PyValueError::new_err(format!("option `modules`: {message}"));
    let wanted = options.get_item("modules")?.filter(|wanted| !wanted.is_none());
    let parsed = match &wanted {
        Some(wanted) => ModuleChoice::read(&parsed("modules", wanted)?),
        None => Ok(ModuleChoice::Chains),
    };
    let choice = parsed.map_err(|fault| wrong(&fault.message))?;
    match choice {
        ModuleChoice::Links => Ok(ModuleTree::links(model)),
        ModuleChoice::List(names) => ModuleTree::from_names(model, &names).map_err(|errors| {
            let all: Vec<String> = errors.iter().map(ToString::to_string).collect();
            wrong(&all.join("; "))
        }),
        _ => Ok(ModuleTree::chains(model)),
    }
}

/// Returns the value of an option: a text is in the syntax of the command line.
fn parsed(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Value> {
    let example = || rows().find(|row| row.name == name).map(example).unwrap_or_default();
    let wrong = |message: &str| {
        PyValueError::new_err(format!(
            "option `{name}`: {message}; for example {name}={}",
            example()
        ))
    };
    match object.cast::<PyString>() {
        Ok(text) => Value::parse(&text.to_cow()?).map_err(|fault| {
            let text = text.to_string_lossy();
            wrong(&format!("{text:?} has another form: {}", fault.message))
        }),
        Err(_) => value(object).ok_or_else(|| {
            let repr = object.repr().map(|repr| repr.to_string()).unwrap_or_default();
            let short: String = repr.chars().take(MAX_SHOWN).collect();
            wrong(&format!("{short} has another type"))
        }),
    }
}

/// The characters of a value that a message shows.
const MAX_SHOWN: usize = 80;

/// Returns the object of Python that an object of NumPy or of the file system stands for: a number,
/// the name of a scalar, a path.
fn plain<'py>(object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let py = object.py();
    let numpy = py.import("numpy")?;
    if object.is_instance(&numpy.getattr("generic")?)? {
        return object.call_method0("item");
    }
    if object.is_instance_of::<PyType>() || object.is_instance(&numpy.getattr("dtype")?)? {
        let name: String = numpy.call_method1("dtype", (object,))?.getattr("name")?.extract()?;
        return Ok(PyString::new(py, &name.replace("float", "f")).into_any());
    }
    if object.hasattr("__fspath__")? {
        return py.import("os")?.call_method1("fsdecode", (object,));
    }
    Ok(object.clone())
}

/// Returns the value of an object: a dictionary is a list of pairs, and a tuple that begins with a
/// text is a call.
fn value(object: &Bound<'_, PyAny>) -> Option<Value> {
    let object = &plain(object).ok()?;
    let kind = if let Ok(flag) = object.cast::<PyBool>() {
        ValueKind::Word(flag.is_true().to_string())
    } else if let Ok(text) = object.cast::<PyString>() {
        ValueKind::Word(text.to_cow().ok()?.into_owned())
    } else if let Ok(number) = object.extract::<f64>() {
        ValueKind::Number(number)
    } else if let Ok(pairs) = object.cast::<PyDict>() {
        ValueKind::List(self::pairs(pairs)?)
    } else if let Some((name, arguments)) = call(object) {
        ValueKind::Call(name, arguments?)
    } else {
        let items = object.try_iter().ok()?;
        ValueKind::List(items.map(|item| value(&item.ok()?)).collect::<Option<_>>()?)
    };
    Some(Value { at: 0, kind })
}

fn pairs(pairs: &Bound<'_, PyDict>) -> Option<Vec<Value>> {
    let pair = |(name, object): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let pair = ValueKind::Pair(Box::new(value(&name)?), Box::new(value(&object)?));
        Some(Value { at: 0, kind: pair })
    };
    pairs.iter().map(pair).collect()
}

/// Returns the name and the arguments of a tuple that begins with a text; the pairs of a dictionary
/// are arguments.
fn call(object: &Bound<'_, PyAny>) -> Option<(String, Option<Vec<Value>>)> {
    let items = object.cast::<PyTuple>().ok()?;
    let first = items.get_item(0).ok()?;
    let name = first.cast::<PyString>().ok()?.to_cow().ok()?.into_owned();
    let rest = PyList::new(object.py(), items.iter().skip(1)).ok()?;
    let argument = |item: Bound<'_, PyAny>| match item.cast::<PyDict>() {
        Ok(named) => pairs(named),
        Err(_) => Some(vec![value(&item)?]),
    };
    let arguments = rest.iter().map(argument).collect::<Option<Vec<_>>>();
    Some((name, arguments.map(|arguments| arguments.concat())))
}
