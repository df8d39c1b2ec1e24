//! The functions of expressions: the functions of Python and of its module `math` that xacro has,
//! and the methods of values.

use std::cmp::Ordering;
use std::f64::consts::{E, PI, TAU};
use std::rc::Rc;

use super::value::{DictEntries, SequenceKind, Set, Value, float};

type Called = Result<Value, String>;

/// A function of one number, by its name.
type Unary = (&'static str, fn(f64) -> f64);

/// A function of two numbers, by its name.
type Binary = (&'static str, fn(f64, f64) -> f64);

/// Functions of one number.
const UNARY: &[Unary] = &[
    ("math.acos", libm::acos),
    ("math.acosh", libm::acosh),
    ("math.asin", libm::asin),
    ("math.asinh", libm::asinh),
    ("math.atan", libm::atan),
    ("math.atanh", libm::atanh),
    ("math.cbrt", libm::cbrt),
    ("math.cos", libm::cos),
    ("math.cosh", libm::cosh),
    ("math.degrees", |x| x * (180.0 / PI)),
    ("math.exp", libm::exp),
    ("math.expm1", libm::expm1),
    ("math.fabs", f64::abs),
    ("math.log10", libm::log10),
    ("math.log1p", libm::log1p),
    ("math.log2", libm::log2),
    ("math.radians", |x| x * (PI / 180.0)),
    ("math.sin", libm::sin),
    ("math.sinh", libm::sinh),
    ("math.sqrt", libm::sqrt),
    ("math.tan", libm::tan),
    ("math.tanh", libm::tanh),
];

/// Functions of two numbers.
const BINARY: &[Binary] = &[
    ("math.atan2", libm::atan2),
    ("math.copysign", libm::copysign),
    ("math.fmod", libm::fmod),
    ("math.pow", libm::pow),
];

/// Functions with other arguments or results.
const OTHER: &[&str] = &[
    "math.ceil",
    "math.floor",
    "math.trunc",
    "math.hypot",
    "math.log",
    "math.fsum",
    "math.isnan",
    "math.isinf",
    "math.isfinite",
    "math.isclose",
    "math.prod",
    "abs",
    "all",
    "any",
    "bool",
    "dict",
    "divmod",
    "enumerate",
    "filter",
    "float",
    "int",
    "len",
    "list",
    "map",
    "max",
    "min",
    "ord",
    "range",
    "repr",
    "reversed",
    "round",
    "set",
    "sorted",
    "str",
    "sum",
    "tuple",
    "zip",
    "xacro.load_yaml",
    "xacro.load_json",
    "xacro.arg",
    "xacro.abs_filename",
    "xacro.dotify",
    "xacro.message",
    "xacro.warning",
    "xacro.error",
    "xacro.fatal",
    "xacro.print_location",
    "xacro.tokenize",
];

/// The functions of Python that have no name of their own, but one in the namespace `python`.
const IN_PYTHON: &[&str] = &[
    "abs",
    "all",
    "any",
    "divmod",
    "enumerate",
    "filter",
    "ord",
    "repr",
    "reversed",
    "set",
    "sum",
    "tuple",
    "zip",
];

/// Returns whether a function neither prints nor compares the values in its arguments.
pub fn is_shallow(name: &str) -> bool {
    let shallow = [
        "all",
        "any",
        "bool",
        "dict",
        "enumerate",
        "filter",
        "len",
        "list",
        "map",
        "reversed",
        "tuple",
        "xacro.dotify",
        "zip",
    ];
    shallow.contains(&name)
}

/// Returns the function of this full name.
fn function(name: &str) -> Option<Value> {
    let names = UNARY.iter().map(|(name, _)| *name).chain(BINARY.iter().map(|(name, _)| *name));
    let function = names.chain(OTHER.iter().copied()).find(|other| *other == name)?;
    Some(Value::Function(function))
}

/// Returns the value of a name that every expression has.
pub fn global(name: &str) -> Option<Value> {
    match name {
        "math" => Some(Value::Module("math")),
        "python" => Some(Value::Module("python")),
        "xacro" => Some(Value::Module("xacro")),
        "load_yaml" | "abs_filename" | "dotify" => function(&format!("xacro.{name}")),
        _ if IN_PYTHON.contains(&name) => None,
        _ if name.contains('.') => None,
        _ => function(name).or_else(|| member("math", name)),
    }
}

/// Returns a member of `math`, `python` or `xacro`.
pub fn member(module: &str, name: &str) -> Option<Value> {
    match (module, name) {
        ("math", "pi") => Some(Value::Float(PI)),
        ("math", "e") => Some(Value::Float(E)),
        ("math", "tau") => Some(Value::Float(TAU)),
        ("math", "inf") => Some(Value::Float(f64::INFINITY)),
        ("math", "nan") => Some(Value::Float(f64::NAN)),
        ("python", "True") => Some(Value::Bool(true)),
        ("python", "False") => Some(Value::Bool(false)),
        ("python", _) if !name.contains('.') => function(name),
        ("python", _) => None,
        _ => function(&format!("{module}.{name}")),
    }
}

/// Returns the number of items, or of characters.
pub fn length(value: &Value) -> usize {
    match value {
        Value::Text(text) => text.chars().count(),
        Value::List(items) | Value::Tuple(items) => items.len(),
        Value::Dict(entries) => entries.len(),
        Value::Set(set) => set.values().len(),
        Value::Sequence(sequence) => sequence.items.len(),
        _ => 0,
    }
}

/// Returns the items in any order, for results that do not depend on it.
fn members(value: &Value) -> Result<Vec<Value>, String> {
    match value {
        Value::Set(set) => Ok(set.values().to_vec()),
        other => items(other),
    }
}

/// Returns the items of a list, a set or an iterator, the characters of a text, or the keys of a
/// dictionary, in the order of Python.
pub fn items(value: &Value) -> Result<Vec<Value>, String> {
    match value {
        Value::List(items) | Value::Tuple(items) => Ok(items.to_vec()),
        Value::Text(text) => Ok(text.chars().map(|c| Value::text(String::from(c))).collect()),
        Value::Dict(entries) => Ok(entries.iter().map(|(key, _)| key.clone()).collect()),
        Value::Set(set) => set.ordered(),
        Value::Sequence(sequence) => Ok(sequence.items.clone()),
        other => Err(format!("{} has no items", other.kind())),
    }
}

fn number(value: &Value) -> Result<f64, String> {
    value.number().ok_or_else(|| format!("expected a number, found {}", value.kind()))
}

/// Returns the integer of a number without its fraction.
fn truncated(value: f64) -> Called {
    #[allow(clippy::cast_possible_truncation)] // The range is checked.
    if value.abs() < 9.0e18 {
        Ok(Value::Int(value as i64))
    } else {
        Err("an integer is too large".into())
    }
}

/// Calls a function without named arguments.
pub fn call(name: &str, arguments: &[Value]) -> Called {
    if let Some((_, function)) = UNARY.iter().find(|(function_name, _)| *function_name == name) {
        let [x] = arguments else { return Err(format!("`{name}` has one argument")) };
        let x = number(x)?;
        let result = function(x);
        if result.is_nan() && !x.is_nan() || result.is_infinite() && x.is_finite() {
            return Err(format!("`{name}` of {} is not defined", float(x)));
        }
        return Ok(Value::Float(result));
    }
    if let Some((_, function)) = BINARY.iter().find(|(function_name, _)| *function_name == name) {
        let [x, y] = arguments else { return Err(format!("`{name}` has two arguments")) };
        let result = function(number(x)?, number(y)?);
        if !result.is_finite() {
            return Err(format!("`{name}` of {} and {} is not defined", x.repr(), y.repr()));
        }
        return Ok(Value::Float(result));
    }
    if name.starts_with("math.") {
        return call_math(name, arguments);
    }
    match (name, arguments) {
        ("ord", [Value::Text(text)]) if text.chars().count() == 1 => {
            let code = text.chars().next().map_or(0, u32::from);
            Ok(Value::Int(i64::from(code)))
        }
        ("abs", [Value::Float(x)]) => Ok(Value::Float(x.abs())),
        ("abs", [x]) => {
            let x = x.integer().ok_or_else(|| format!("`abs` of {}", x.kind()))?;
            x.checked_abs().map(Value::Int).ok_or_else(|| "an integer is too large".into())
        }
        ("all", [all]) => Ok(Value::Bool(members(all)?.iter().all(Value::is_true))),
        ("any", [all]) => Ok(Value::Bool(members(all)?.iter().any(Value::is_true))),
        ("bool", []) => Ok(Value::Bool(false)),
        ("bool", [x]) => Ok(Value::Bool(x.is_true())),
        ("float", [x]) => to_float(x),
        ("int", [x]) => to_int(x),
        ("int", [Value::Text(text), base]) => {
            let integer = base.integer().and_then(|base| u32::try_from(base).ok());
            let base =
                integer.filter(|base| (2..=36).contains(base)).ok_or("the base is not 2 to 36")?;
            let digits = text.trim();
            let prefixed = digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X"));
            let digits = prefixed
                .filter(|digits| base == 16 && !digits.starts_with(['+', '-']))
                .unwrap_or(digits);
            let value = i64::from_str_radix(digits, base);
            value.map(Value::Int).map_err(|_| format!("'{text}' is not an integer"))
        }
        ("len", [Value::Sequence(sequence)]) if sequence.kind == SequenceKind::Iterator => {
            Err("an iterator has no length: write `len(list(...))`".into())
        }
        (
            "len",
            [
                Value::Text(_)
                | Value::List(_)
                | Value::Tuple(_)
                | Value::Dict(_)
                | Value::Set(_)
                | Value::Sequence(_),
            ],
        ) => Ok(Value::Int(i64::try_from(length(&arguments[0])).unwrap_or(i64::MAX))),
        ("list", []) => Ok(Value::list(Vec::new())),
        ("list", [all]) => items(all).map(Value::list),
        ("tuple", []) => Ok(Value::Tuple(Rc::default())),
        ("tuple", [all]) => items(all).map(|items| Value::Tuple(Rc::new(items))),
        ("set", []) => Value::set([]),
        ("set", [all]) => Value::set(members(all)?),
        ("max", _) => extreme(arguments, Ordering::Greater),
        ("min", _) => extreme(arguments, Ordering::Less),
        ("range", _) => range(arguments),
        ("repr", [x]) => x.checked_repr().map(Value::text),
        ("reversed", [all]) => {
            if matches!(all, Value::Set(_)) || all.kind() == "an iterator" {
                return Err(format!("`reversed` of {}", all.kind()));
            }
            let mut all = items(all)?;
            all.reverse();
            Ok(Value::iterator(all))
        }
        ("round", [x]) => match x {
            Value::Float(x) => truncated(libm::rint(*x)),
            other => to_int(other),
        },
        ("round", [x, digits]) => {
            let digits = digits.integer().ok_or("the number of digits is an integer")?;
            rounded(x, digits)
        }
        ("sorted", [_]) => sorted(arguments, &[]),
        ("str", []) => Ok(Value::text("")),
        ("str", [x]) => x.display().map(Value::Text),
        ("sum", [all]) => {
            let numbers = members(all)?;
            let is_exact = numbers.iter().all(|number| number.integer().is_some());
            sum(&if is_exact { numbers } else { items(all)? })
        }
        ("enumerate", [all]) => {
            let numbered = items(all)?.into_iter().zip(0_i64..);
            let pairs = numbered.map(|(item, i)| Value::Tuple(Rc::new(vec![Value::Int(i), item])));
            Ok(Value::iterator(pairs.collect()))
        }
        ("zip", lists) => {
            let lists = lists.iter().map(items).collect::<Result<Vec<_>, _>>()?;
            let count = lists.iter().map(Vec::len).min().unwrap_or(0);
            let row = |i: usize| lists.iter().map(|list| list[i].clone()).collect();
            Ok(Value::iterator((0..count).map(|i| Value::Tuple(Rc::new(row(i)))).collect()))
        }
        _ => Err(wrong_arguments(name, arguments)),
    }
}

/// Calls a function of `math` with other arguments or results than numbers.
fn call_math(name: &str, arguments: &[Value]) -> Called {
    match (name, arguments) {
        ("math.ceil", [x]) => truncated(number(x)?.ceil()),
        ("math.floor", [x]) => truncated(number(x)?.floor()),
        ("math.trunc", [x]) => truncated(number(x)?.trunc()),
        ("math.log", [x]) if number(x)? > 0.0 => Ok(Value::Float(libm::log(number(x)?))),
        ("math.log", [x, base]) if number(x)? > 0.0 && number(base)? > 0.0 => {
            Ok(Value::Float(libm::log(number(x)?) / libm::log(number(base)?)))
        }
        ("math.hypot", [x, y]) => Ok(Value::Float(libm::hypot(number(x)?, number(y)?))),
        ("math.isnan", [x]) => Ok(Value::Bool(number(x)?.is_nan())),
        ("math.isinf", [x]) => Ok(Value::Bool(number(x)?.is_infinite())),
        ("math.isfinite", [x]) => Ok(Value::Bool(number(x)?.is_finite())),
        ("math.fsum", [all]) => {
            let numbers = members(all)?.iter().map(number).collect::<Result<Vec<_>, _>>()?;
            exact_sum(&numbers).map(Value::Float)
        }
        ("math.isclose", [a, b]) => {
            let a = number(a)?;
            let b = number(b)?;
            let scale = a.abs().max(b.abs());
            Ok(Value::Bool(a == b || scale.is_finite() && (a - b).abs() <= 1e-9 * scale))
        }
        ("math.prod", [all]) => product(&items(all)?),
        _ => Err(wrong_arguments(name, arguments)),
    }
}

fn wrong_arguments(name: &str, arguments: &[Value]) -> String {
    let kinds: Vec<&str> = arguments.iter().map(Value::kind).collect();
    format!("`{name}` cannot be called with ({})", kinds.join(", "))
}

/// Returns the dictionary of entries, of pairs, and of named arguments.
pub fn dict(arguments: &[Value], named: Vec<(Rc<str>, Value)>) -> Called {
    let pairs: Vec<(Value, Value)> = match arguments {
        [] => Vec::new(),
        [Value::Dict(entries)] => entries.to_vec(),
        [pairs] => {
            let pair = |pair: Value| match items(&pair)?.as_slice() {
                [key, value] => Ok((key.clone(), value.clone())),
                _ => Err(String::from("`dict` of a list needs pairs")),
            };
            items(pairs)?.into_iter().map(pair).collect::<Result<_, _>>()?
        }
        _ => return Err("`dict` has at most one argument without a name".into()),
    };
    let mut entries = DictEntries::of(pairs)?;
    named.into_iter().try_for_each(|(name, value)| entries.set(Value::Text(name), value))?;
    Ok(entries.dict())
}

/// Returns the items in order.
pub fn sorted(arguments: &[Value], named: &[(Rc<str>, Value)]) -> Called {
    let [all] = arguments else { return Err("`sorted` has one list".into()) };
    let mut all = members(all)?;
    let comparable = all.windows(2).all(|pair| pair[0].compare(&pair[1]).is_some());
    if !comparable {
        return Err("`sorted` of values without an order".into());
    }
    all.sort_by(|a, b| a.compare(b).unwrap_or(Ordering::Equal));
    match named {
        [] => {}
        [(name, reverse)] if &**name == "reverse" => {
            if reverse.is_true() {
                all.reverse();
            }
        }
        [(name, _), ..] => return Err(format!("the named argument `{name}` is not supported")),
    }
    Ok(Value::list(all))
}

fn to_float(x: &Value) -> Called {
    if let Value::Text(text) = x {
        return match literal_float(text) {
            Some(value) => Ok(Value::Float(value)),
            None => Err(format!("'{text}' is not a number")),
        };
    }
    number(x).map(Value::Float)
}

fn to_int(x: &Value) -> Called {
    match x {
        Value::Float(x) => truncated(x.trunc()),
        Value::Text(text) => match literal_int(text) {
            Some(value) => Ok(Value::Int(value)),
            None => Err(format!("'{text}' is not an integer")),
        },
        other => {
            other.integer().map(Value::Int).ok_or_else(|| format!("`int` of {}", other.kind()))
        }
    }
}

/// Returns the integer of a text, as Python's `int` reads it.
pub fn literal_int(text: &str) -> Option<i64> {
    let text = text.trim();
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    let plain = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
    if plain { text.parse().ok() } else { None }
}

/// Returns the number of a text, as Python's `float` reads it.
pub fn literal_float(text: &str) -> Option<f64> {
    // Rust reads the same forms, of which Python has `infinity`, `inf` and `nan` as well.
    text.trim().parse().ok()
}

fn extreme(arguments: &[Value], wanted: Ordering) -> Called {
    let given = match arguments {
        [all] => members(all)?,
        several => several.to_vec(),
    };
    let mut all = given.into_iter();
    let mut best = all.next().ok_or("`min` and `max` need a value")?;
    for item in all {
        let compared = item.compare(&best);
        let order =
            compared.ok_or_else(|| format!("{} and {} have no order", item.kind(), best.kind()))?;
        if order == wanted {
            best = item;
        }
    }
    Ok(best)
}

/// The largest number of values of a range.
const MAX_RANGE: i64 = 100_000;

fn range(arguments: &[Value]) -> Called {
    let integers: Option<Vec<i64>> = arguments.iter().map(Value::integer).collect();
    let (from, to, step) = match integers.as_deref() {
        Some([to]) => (0, *to, 1),
        Some([from, to]) => (*from, *to, 1),
        Some([from, to, step]) if *step != 0 => (*from, *to, *step),
        _ => return Err("`range` has one to three integers".into()),
    };
    let distance = i128::from(to) - i128::from(from);
    if distance / i128::from(step) > i128::from(MAX_RANGE) {
        return Err(format!("a range has at most {MAX_RANGE} values"));
    }
    let mut values = Vec::new();
    let mut at = from;
    while if step > 0 { at < to } else { at > to } {
        values.push(Value::Int(at));
        let Some(next) = at.checked_add(step) else { break };
        at = next;
    }
    Ok(Value::sequence(SequenceKind::Range([from, to, step]), values))
}

fn rounded(x: &Value, digits: i64) -> Called {
    if let Value::Int(_) | Value::Bool(_) = x
        && digits >= 0
    {
        return to_int(x);
    }
    let x = number(x)?;
    let Some(digits) = usize::try_from(digits).ok().filter(|digits| *digits < 300) else {
        return Err("the number of digits is not between 0 and 300".into());
    };
    // The text is exact, and its last digit is rounded to even, as Python's.
    format!("{x:.digits$}").parse().map(Value::Float).map_err(|_| "a number is not finite".into())
}

fn product(all: &[Value]) -> Called {
    let mut exact = Some(1_i64);
    let mut product = 1.0;
    let mut is_integer = true;
    for item in all {
        is_integer = is_integer && item.integer().is_some();
        exact = exact.and_then(|product| product.checked_mul(item.integer()?));
        product *= number(item)?;
    }
    if is_integer {
        return exact.map(Value::Int).ok_or_else(|| "an integer is too large".into());
    }
    Ok(Value::Float(product))
}

/// Returns the sum of numbers, rounded once: Shewchuk's sum of parts that do not overlap.
fn exact_sum(numbers: &[f64]) -> Result<f64, String> {
    let mut parts: Vec<f64> = Vec::new();
    for number in numbers {
        let mut sum = *number;
        let mut kept = Vec::new();
        for part in parts {
            let (large, small) = if sum.abs() < part.abs() { (part, sum) } else { (sum, part) };
            sum = large + small;
            let rest = small - (sum - large);
            if rest != 0.0 {
                kept.push(rest);
            }
        }
        kept.push(sum);
        parts = kept;
    }
    let Some(mut sum) = parts.pop() else { return Ok(0.0) };
    let mut rest = 0.0;
    while let Some(part) = parts.pop() {
        let before = sum;
        sum = before + part;
        rest = part - (sum - before);
        if rest != 0.0 {
            break;
        }
    }
    // Half of the last digit is rounded by the part below it.
    if parts.last().is_some_and(|part| (*part < 0.0) == (rest < 0.0)) {
        let twice = rest * 2.0;
        let rounded = sum + twice;
        if (rounded - sum).to_bits() == twice.to_bits() {
            sum = rounded;
        }
    }
    if sum.is_finite() { Ok(sum) } else { Err("`math.fsum` of these numbers is not finite".into()) }
}

fn sum(all: &[Value]) -> Called {
    let mut exact = Some(0_i64);
    let mut sum = 0.0;
    for item in all {
        exact = exact.and_then(|sum| sum.checked_add(item.integer()?));
        sum += number(item)?;
    }
    Ok(exact.map_or(Value::Float(sum), Value::Int))
}

/// The methods of texts, lists and dictionaries.
const TEXT_METHODS: &[&str] = &[
    "lower",
    "upper",
    "strip",
    "lstrip",
    "rstrip",
    "split",
    "replace",
    "startswith",
    "endswith",
    "join",
    "find",
    "count",
    "title",
    "capitalize",
    "index",
    "isdigit",
    "zfill",
];
const SET_METHODS: &[&str] = &[
    "copy",
    "union",
    "intersection",
    "difference",
    "symmetric_difference",
    "issubset",
    "issuperset",
    "isdisjoint",
];
const LIST_METHODS: &[&str] = &["index", "count"];
const DICT_METHODS: &[&str] = &["get", "keys", "values", "items"];

/// Returns whether a value has a method of this name.
pub fn is_method(value: &Value, name: &str) -> bool {
    let methods = match value {
        Value::Text(_) => TEXT_METHODS,
        Value::List(_) | Value::Tuple(_) => LIST_METHODS,
        Value::Dict(_) => DICT_METHODS,
        Value::Set(_) => SET_METHODS,
        _ => return false,
    };
    methods.contains(&name)
}

/// Calls a method.
pub fn call_method(object: &Value, name: &str, arguments: &[Value]) -> Called {
    let wrong = || {
        let kinds: Vec<&str> = arguments.iter().map(Value::kind).collect();
        format!("`{name}` of {} cannot be called with ({})", object.kind(), kinds.join(", "))
    };
    match object {
        Value::Text(text) => text_method(text, name, arguments).unwrap_or_else(|| Err(wrong())),
        Value::Dict(entries) => match (name, arguments) {
            ("get", [key]) => Ok(object.entry(key).unwrap_or(Value::None)),
            ("get", [key, default]) => Ok(object.entry(key).unwrap_or_else(|| default.clone())),
            ("keys", []) => items(object).map(|keys| view("dict_keys", keys)),
            ("values", []) => {
                let values = entries.iter().map(|(_, value)| value.clone());
                Ok(view("dict_values", values.collect()))
            }
            ("items", []) => {
                let pair = |(key, value): &(Value, Value)| {
                    Value::Tuple(Rc::new(vec![key.clone(), value.clone()]))
                };
                Ok(view("dict_items", entries.iter().map(pair).collect()))
            }
            _ => Err(wrong()),
        },
        Value::Set(set) => set_method(set, name, arguments)?.ok_or_else(wrong),
        Value::List(all) | Value::Tuple(all) => {
            let [item] = arguments else { return Err(wrong()) };
            let position = match name {
                "index" => all.iter().position(|element| element.equals(item)),
                _ => Some(all.iter().filter(|element| element.equals(item)).count()),
            };
            let number = position.and_then(|number| i64::try_from(number).ok());
            number.map(Value::Int).ok_or_else(|| format!("{} is not in the list", item.repr()))
        }
        _ => Err(wrong()),
    }
}

fn view(kind: &'static str, items: Vec<Value>) -> Value {
    Value::sequence(SequenceKind::View(kind), items)
}

/// Calls a method of a set; `None` if it has other arguments.
fn set_method(set: &Rc<Set>, name: &str, arguments: &[Value]) -> Result<Option<Value>, String> {
    let mut others = Vec::new();
    for argument in arguments {
        others.push(Set::of(members(argument)?)?);
    }
    Ok(match (name, others.as_slice()) {
        ("copy", []) => Some(Value::Set(set.clone())),
        ("issubset", [other]) => Some(Value::Bool(set.is_subset(other))),
        ("issuperset", [other]) => Some(Value::Bool(other.is_subset(set))),
        ("isdisjoint", [other]) => Some(Value::Bool(set.is_disjoint(other))),
        ("union" | "intersection" | "difference", _) | ("symmetric_difference", [_]) => {
            let operator = match name {
                "union" => "|",
                "intersection" => "&",
                "difference" => "-",
                _ => "^",
            };
            let mut result = Set::clone(set);
            for other in &others {
                if let Some(combined) = result.combined(operator, other) {
                    result = combined?;
                }
            }
            Some(Value::Set(Rc::new(result)))
        }
        _ => None,
    })
}

/// Returns a text in which each word begins with a capital letter.
fn title(text: &str) -> String {
    let mut out = String::new();
    let mut is_in_word = false;
    for c in text.chars() {
        if is_in_word {
            out.extend(c.to_lowercase())
        } else {
            out.extend(c.to_uppercase())
        }
        is_in_word = c.is_alphabetic();
    }
    out
}

fn text_method(text: &Rc<str>, name: &str, arguments: &[Value]) -> Option<Called> {
    let texts: Option<Vec<&str>> = arguments
        .iter()
        .map(|argument| if let Value::Text(text) = argument { Some(&**text) } else { None })
        .collect();
    let result = match (name, texts.as_deref()) {
        ("lower", Some([])) => Value::text(text.to_lowercase()),
        ("upper", Some([])) => Value::text(text.to_uppercase()),
        ("strip", Some([])) => Value::text(text.trim()),
        ("lstrip", Some([])) => Value::text(text.trim_start()),
        ("rstrip", Some([])) => Value::text(text.trim_end()),
        ("strip", Some([set])) => Value::text(text.trim_matches(|c| set.contains(c))),
        ("lstrip", Some([set])) => Value::text(text.trim_start_matches(|c| set.contains(c))),
        ("rstrip", Some([set])) => Value::text(text.trim_end_matches(|c| set.contains(c))),
        ("split", Some([])) => Value::list(text.split_whitespace().map(Value::text).collect()),
        ("split", Some([by])) if !by.is_empty() => {
            Value::list(text.split(by).map(Value::text).collect())
        }
        ("replace", Some([from, to])) => {
            if text.len().saturating_mul(to.len().max(1)) > 1 << 20 {
                return Some(Err("a text is too long".into()));
            }
            Value::text(text.replace(from, to))
        }
        ("startswith", Some([start])) => Value::Bool(text.starts_with(start)),
        ("endswith", Some([end])) => Value::Bool(text.ends_with(end)),
        ("find", Some([part])) => {
            let at = text.find(part).map(|at| text[..at].chars().count());
            Value::Int(at.and_then(|at| i64::try_from(at).ok()).unwrap_or(-1))
        }
        ("index", Some([part])) => {
            let Some(at) = text.find(part) else {
                return Some(Err(format!("'{part}' is not in '{text}'")));
            };
            Value::Int(i64::try_from(text[..at].chars().count()).unwrap_or(i64::MAX))
        }
        ("title", Some([])) => Value::text(title(text)),
        ("zfill", _) => {
            let width = match arguments {
                [width] => usize::try_from(width.integer()?).unwrap_or(0),
                _ => return None,
            };
            if width > 1 << 20 {
                return Some(Err("a text is too long".into()));
            }
            let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
            let sign = &text[..text.len() - digits.len()];
            let count = width.saturating_sub(text.chars().count());
            Value::text(format!("{sign}{}{digits}", "0".repeat(count)))
        }
        ("count", Some([part])) if !part.is_empty() => {
            Value::Int(i64::try_from(text.matches(part).count()).unwrap_or(i64::MAX))
        }
        ("isdigit", Some([])) => {
            Value::Bool(!text.is_empty() && text.chars().all(|c| c.is_ascii_digit()))
        }
        ("capitalize", Some([])) => {
            let mut chars = text.chars();
            let first: String = chars.next().into_iter().flat_map(char::to_uppercase).collect();
            Value::text(first + &chars.as_str().to_lowercase())
        }
        ("join", _) => {
            let [all] = arguments else { return None };
            let all = match items(all) {
                Ok(all) => all,
                Err(reason) => return Some(Err(reason)),
            };
            let length: usize = all.iter().map(|item| length(item) + text.len()).sum();
            if length > 1 << 20 {
                return Some(Err("a text is too long".into()));
            }
            let parts = all.iter().map(Value::display).collect::<Result<Vec<_>, _>>();
            match parts {
                Ok(parts) => Value::text(parts.join(text)),
                Err(reason) => return Some(Err(reason)),
            }
        }
        _ => return None,
    };
    Some(Ok(result))
}

/// Returns a number with an exponent of at least two digits.
fn exponential(value: f64, precision: usize) -> String {
    let text = format!("{value:.precision$e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let size = exponent.trim_start_matches('-');
    let sign = if exponent.starts_with('-') { '-' } else { '+' };
    format!("{digits}e{sign}{size:0>2}")
}

/// Returns a value in a format such as `.3f`, `d` or `03d`.
fn formatted(value: &Value, spec: &str) -> Result<String, String> {
    let wrong = || format!("the format `{spec}` of {} is not supported", value.kind());
    if spec.is_empty() {
        return value.display().map(|text| text.to_string());
    }
    let (digits, kind) = match spec.chars().next_back() {
        Some(kind) if kind.is_ascii_alphabetic() => (&spec[..spec.len() - 1], kind),
        _ => (spec, 's'),
    };
    let (width, precision) = digits.split_once('.').unwrap_or((digits, ""));
    let zeros = width.starts_with('0');
    let parsed = |text: &str, default: usize| {
        if text.is_empty() { Ok(default) } else { text.parse().map_err(|_| wrong()) }
    };
    let width = parsed(width, 0)?;
    let precision = parsed(precision, 6)?;
    if width > 100 || precision > 100 {
        return Err(wrong());
    }
    // Python fills a text with spaces, and gives other meanings to the precision of these kinds.
    let is_plain = !spec.contains('.');
    let text = match kind {
        'f' | 'e' if !number(value)?.is_finite() => return Err(wrong()),
        'f' => format!("{:.precision$}", number(value)?),
        'e' => exponential(number(value)?, precision),
        'd' | 's' if !is_plain => return Err(wrong()),
        's' if zeros => return Err(wrong()),
        'd' => value.integer().ok_or_else(wrong)?.to_string(),
        's' => value.display()?.to_string(),
        _ => return Err(wrong()),
    };
    Ok(match (zeros, kind) {
        (true, _) => match text.strip_prefix('-') {
            Some(digits) => format!("-{digits:0>width$}", width = width.saturating_sub(1)),
            None => format!("{text:0>width$}"),
        },
        (false, _) => format!("{text:>width$}"),
    })
}

/// Returns a text with `%s`, `%d` and `%.3f` replaced.
pub fn percent(text: &str, values: &Value) -> Called {
    let values = match values {
        Value::Tuple(values) => values.to_vec(),
        one => vec![one.clone()],
    };
    let mut out = String::new();
    let mut rest = text;
    let mut values = values.iter();
    while let Some(at) = rest.find('%') {
        out += &rest[..at];
        let after = &rest[at + 1..];
        let letter = after.find(|c: char| c.is_ascii_alphabetic() || c == '%');
        let end = letter.ok_or("a `%` in the text has no format")?;
        if &after[end..=end] == "%" {
            out.push('%');
        } else {
            let next = values.next().ok_or("`%` has too few values")?;
            let value = match (&after[end..=end], next) {
                ("d" | "i", Value::Float(x)) => &truncated(x.trunc())?,
                _ => next,
            };
            out += &formatted(value, &after[..=end].replace('i', "d"))?;
        }
        rest = &after[end + 1..];
    }
    match values.next() {
        Some(_) => Err("`%` has too many values".into()),
        None => Ok(Value::text(out + rest)),
    }
}
