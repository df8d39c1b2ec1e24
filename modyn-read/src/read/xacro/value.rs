//! The values of expressions, with the texts that Python gives them.

mod dict;
mod set;

use std::cmp::Ordering;
use std::fmt::Write;
use std::rc::Rc;

use super::tree::Element;
pub use dict::DictEntries;
pub use set::Set;

/// The largest depth of lists, tuples and dictionaries in each other.
const MAX_DEPTH: usize = 100;

/// The largest amount of work: elements, attributes, operations, values that are printed or
/// compared in tens, and characters in hundreds.
pub const MAX_WORK: usize = 1_000_000;

/// The weight of the values that no expansion may print or compare.
const MAX_WEIGHT: usize = 10 * MAX_WORK;

/// A scope of properties by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScopeId(pub usize);

/// The values of a range, of a view of a dictionary or of an iterator.
#[derive(Clone, Debug)]
pub struct Sequence {
    pub kind: SequenceKind,
    pub items: Vec<Value>,
}

/// The type of a sequence that is no list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SequenceKind {
    /// The start, the end and the step.
    Range([i64; 3]),
    /// `dict_keys`, `dict_values` or `dict_items`.
    View(&'static str),
    /// The result of `map`, `zip` and others, which Python computes when it is iterated.
    Iterator,
}

/// A value.
#[derive(Clone, Debug)]
pub enum Value {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    Text(Rc<str>),
    List(Rc<Vec<Value>>),
    Tuple(Rc<Vec<Value>>),
    /// Keys and values, in the order in which they were added.
    Dict(Rc<Vec<(Value, Value)>>),
    Set(Rc<Set>),
    Sequence(Rc<Sequence>),
    /// A function by its name, such as `math.sin`.
    Function(&'static str),
    /// A method of a value.
    Method(Rc<(Value, Rc<str>)>),
    /// The functions whose names begin with this word.
    Module(&'static str),
    /// The properties of an include with a namespace.
    Scope(ScopeId),
    /// A block of XML.
    Block(Rc<Element>),
}

impl Value {
    /// Returns a text as a value.
    pub fn text(text: impl Into<Rc<str>>) -> Self {
        Self::Text(text.into())
    }

    /// Returns a list as a value.
    pub fn list(items: Vec<Self>) -> Self {
        Self::List(Rc::new(items))
    }

    /// Returns the set of values as a value.
    pub fn set(values: impl IntoIterator<Item = Self>) -> Result<Self, String> {
        Set::of(values).map(|set| Self::Set(Rc::new(set)))
    }

    /// Returns a range, a view or an iterator as a value.
    pub fn sequence(kind: SequenceKind, items: Vec<Self>) -> Self {
        Self::Sequence(Rc::new(Sequence { kind, items }))
    }

    /// Returns an iterator as a value.
    pub fn iterator(items: Vec<Self>) -> Self {
        Self::sequence(SequenceKind::Iterator, items)
    }

    /// Returns the set of a set, or of the keys or the items of a dictionary.
    pub fn as_set(&self) -> Option<Rc<Set>> {
        match self {
            Self::Set(set) => Some(set.clone()),
            Self::Sequence(view)
                if matches!(view.kind, SequenceKind::View("dict_keys" | "dict_items")) =>
            {
                Set::of(view.items.iter().cloned()).ok().map(Rc::new)
            }
            _ => None,
        }
    }

    /// Returns the number of a number or a truth value.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Bool(value) => Some(f64::from(u8::from(*value))),
            #[allow(clippy::cast_precision_loss)] // As Python does.
            Self::Int(value) => Some(*value as f64),
            Self::Float(value) => Some(*value),
            _ => None,
        }
    }

    /// Returns the integer of an integer or a truth value.
    pub fn integer(&self) -> Option<i64> {
        match self {
            Self::Bool(value) => Some(i64::from(*value)),
            Self::Int(value) => Some(*value),
            _ => None,
        }
    }

    /// Returns whether Python counts the value as true.
    pub fn is_true(&self) -> bool {
        match self {
            Self::None => false,
            Self::Bool(value) => *value,
            Self::Int(value) => *value != 0,
            Self::Float(value) => *value != 0.0,
            Self::Text(text) => !text.is_empty(),
            Self::List(items) | Self::Tuple(items) => !items.is_empty(),
            Self::Dict(entries) => !entries.is_empty(),
            Self::Set(set) => !set.values().is_empty(),
            Self::Sequence(sequence) => {
                sequence.kind == SequenceKind::Iterator || !sequence.items.is_empty()
            }
            _ => true,
        }
    }

    /// Returns the name of the type.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::None => "None",
            Self::Bool(_) => "a truth value",
            Self::Int(_) => "an integer",
            Self::Float(_) => "a number",
            Self::Text(_) => "a text",
            Self::List(_) => "a list",
            Self::Tuple(_) => "a tuple",
            Self::Dict(_) => "a dictionary",
            Self::Set(_) => "a set",
            Self::Sequence(sequence) => match sequence.kind {
                SequenceKind::Range(_) => "a range",
                SequenceKind::View(_) => "a view of a dictionary",
                SequenceKind::Iterator => "an iterator",
            },
            Self::Function(_) | Self::Method(_) => "a function",
            Self::Module(_) | Self::Scope(_) => "a namespace",
            Self::Block(_) => "a block",
        }
    }

    /// Returns whether the value contains others.
    pub fn is_collection(&self) -> bool {
        let is_list = matches!(self, Self::List(_) | Self::Tuple(_) | Self::Sequence(_));
        is_list || matches!(self, Self::Dict(_) | Self::Set(_))
    }

    /// Returns the work to print or to compare the value: the number of values in it, each as often
    /// as it is repeated, and its characters in tens. The count ends at [`MAX_WEIGHT`]. An error if
    /// the value is nested too deep for printing.
    pub fn weight(&self) -> Result<usize, String> {
        let mut weight = 0;
        let mut open = vec![(self, 0)];
        while let Some((value, depth)) = open.pop() {
            if depth > MAX_DEPTH {
                return Err(format!("a value is nested more than {MAX_DEPTH} deep"));
            }
            weight += 1;
            match value {
                Self::Text(text) => weight += text.len() / 10,
                Self::List(items) | Self::Tuple(items) => {
                    open.extend(items.iter().map(|item| (item, depth + 1)));
                }
                Self::Dict(entries) => {
                    let parts = entries.iter().flat_map(|(key, value)| [key, value]);
                    open.extend(parts.map(|part| (part, depth + 1)));
                }
                Self::Set(set) => {
                    open.extend(set.values().iter().map(|item| (item, depth + 1)));
                }
                Self::Sequence(sequence) => {
                    open.extend(sequence.items.iter().map(|item| (item, depth + 1)));
                }
                _ => {}
            }
            if weight > MAX_WEIGHT {
                break;
            }
        }
        Ok(weight)
    }

    /// Returns whether two values are equal.
    pub fn equals(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::None, Self::None) => true,
            (Self::Text(a), Self::Text(b)) => a == b,
            (Self::List(a), Self::List(b)) | (Self::Tuple(a), Self::Tuple(b)) => {
                a.len() == b.len() && a.iter().zip(b.iter()).all(|(a, b)| a.equals(b))
            }
            (Self::Dict(a), Self::Dict(b)) => dict::equal(a, b),
            (Self::Function(a), Self::Function(b)) => a == b,
            (Self::Sequence(a), Self::Sequence(b))
                if matches!((a.kind, b.kind), (SequenceKind::Range(_), SequenceKind::Range(_))) =>
            {
                Self::list(a.items.clone()).equals(&Self::list(b.items.clone()))
            }
            (Self::Set(_) | Self::Sequence(_), Self::Set(_) | Self::Sequence(_)) => {
                match (self.as_set(), other.as_set()) {
                    (Some(a), Some(b)) => a.equals(&b),
                    _ => false,
                }
            }
            _ => self.compare_numbers(other) == Some(Ordering::Equal),
        }
    }

    /// Returns the order of two values; `None` if they have none.
    pub fn compare(&self, other: &Self) -> Option<Ordering> {
        match (self, other) {
            (Self::Text(a), Self::Text(b)) => Some(a.cmp(b)),
            (Self::List(a), Self::List(b)) | (Self::Tuple(a), Self::Tuple(b)) => {
                let unequal = a.iter().zip(b.iter()).find(|(a, b)| !a.equals(b));
                unequal.map_or(Some(a.len().cmp(&b.len())), |(a, b)| a.compare(b))
            }
            _ => self.compare_numbers(other),
        }
    }

    /// Returns the order of two numbers, exactly also for an integer and a float.
    fn compare_numbers(&self, other: &Self) -> Option<Ordering> {
        match (self.integer(), other.integer()) {
            (Some(a), Some(b)) => Some(a.cmp(&b)),
            (Some(a), None) => compare_with_float(a, other.number()?),
            (None, Some(b)) => compare_with_float(b, self.number()?).map(Ordering::reverse),
            (None, None) => self.number()?.partial_cmp(&other.number()?),
        }
    }

    /// Returns the value of a key of a dictionary.
    pub fn entry(&self, key: &Self) -> Option<Self> {
        let Self::Dict(entries) = self else { return None };
        entries.iter().find(|(other, _)| other.equals(key)).map(|(_, value)| value.clone())
    }

    /// Returns the text, as Python's `str` writes it; an error if Python's text is not fixed.
    pub fn display(&self) -> Result<Rc<str>, String> {
        match self {
            Self::Text(text) => Ok(text.clone()),
            other => other.checked_repr().map(Into::into),
        }
    }

    /// Returns the text of a message, also of values whose text is not fixed in Python.
    pub fn message(&self) -> String {
        match self {
            Self::Text(text) => text.to_string(),
            other => other.repr(),
        }
    }

    /// Returns the text of `repr`; an error if Python's text is not fixed.
    pub fn checked_repr(&self) -> Result<String, String> {
        self.check_text()?;
        Ok(self.repr())
    }

    fn check_text(&self) -> Result<(), String> {
        match self {
            Self::List(items) | Self::Tuple(items) => items.iter().try_for_each(Self::check_text),
            Self::Dict(entries) => entries
                .iter()
                .try_for_each(|(key, value)| key.check_text().and_then(|()| value.check_text())),
            Self::Set(set) => set.ordered()?.iter().try_for_each(Self::check_text),
            Self::Sequence(sequence) if sequence.kind != SequenceKind::Iterator => {
                sequence.items.iter().try_for_each(Self::check_text)
            }
            Self::Sequence(_) => Err("an iterator has no text: write `list(...)` of it".into()),
            Self::Function(_) | Self::Method(_) => {
                Err("a function has no text: is a pair of parentheses missing?".into())
            }
            Self::Module(_) | Self::Scope(_) | Self::Block(_) => {
                Err(format!("{} has no text", self.kind()))
            }
            _ => Ok(()),
        }
    }

    /// Returns the text of an expression of this value, as Python's `repr` writes it.
    ///
    /// Values without such a text are described for messages.
    pub fn repr(&self) -> String {
        let joined = |items: &[Self]| items.iter().map(Self::repr).collect::<Vec<_>>().join(", ");
        match self {
            Self::None => "None".into(),
            Self::Bool(value) => if *value { "True" } else { "False" }.into(),
            Self::Int(value) => value.to_string(),
            Self::Float(value) => float(*value),
            Self::Text(text) => quoted(text),
            Self::List(items) => format!("[{}]", joined(items)),
            Self::Tuple(items) if items.len() == 1 => format!("({},)", items[0].repr()),
            Self::Tuple(items) => format!("({})", joined(items)),
            Self::Dict(entries) => {
                let entries = entries.iter().map(|(k, v)| format!("{}: {}", k.repr(), v.repr()));
                format!("{{{}}}", entries.collect::<Vec<_>>().join(", "))
            }
            Self::Set(set) if set.values().is_empty() => "set()".into(),
            Self::Set(set) => {
                let values = set.ordered().unwrap_or_else(|_| set.values().to_vec());
                format!("{{{}}}", joined(&values))
            }
            Self::Sequence(sequence) => match sequence.kind {
                SequenceKind::Range([from, to, 1]) => format!("range({from}, {to})"),
                SequenceKind::Range([from, to, step]) => format!("range({from}, {to}, {step})"),
                SequenceKind::View(name) => format!("{name}([{}])", joined(&sequence.items)),
                SequenceKind::Iterator => "<iterator>".into(),
            },
            Self::Function(name) | Self::Module(name) => format!("<{name}>"),
            Self::Method(method) => format!("<{}>", method.1),
            Self::Scope(_) => "<namespace>".into(),
            Self::Block(_) => "<block>".into(),
        }
    }
}

/// Returns the order of an integer and a float, without rounding the integer.
fn compare_with_float(integer: i64, float: f64) -> Option<Ordering> {
    #[allow(clippy::cast_possible_truncation)] // Floats beyond 128 bits become the largest integer.
    let floor = float.floor() as i128;
    let fraction = || if float > float.floor() { Ordering::Less } else { Ordering::Equal };
    (!float.is_nan()).then(|| i128::from(integer).cmp(&floor).then_with(fraction))
}

/// Returns a text in quotes, as Python writes it.
fn quoted(text: &str) -> String {
    let quote = if text.contains('\'') && !text.contains('"') { '"' } else { '\'' };
    let mut out = String::from(quote);
    for c in text.chars() {
        match c {
            '\n' => out += "\\n",
            '\t' => out += "\\t",
            '\r' => out += "\\r",
            '\\' => out += "\\\\",
            c if c == quote => out.extend(['\\', c]),
            c => out.push(c),
        }
    }
    out.push(quote);
    out
}

/// Returns the shortest text that reads back as this number, in the form of Python: an exponent
/// from 1e16 on and below 1e-4.
pub fn float(value: f64) -> String {
    if value.is_nan() {
        return "nan".into();
    }
    if value.is_infinite() {
        return if value > 0.0 { "inf" } else { "-inf" }.into();
    }
    let shortest = format!("{value:e}");
    let (digits, exponent) = shortest.split_once('e').unwrap_or((&shortest, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..16).contains(&exponent) {
        let plain = format!("{value}");
        return if plain.contains('.') { plain } else { plain + ".0" };
    }
    let mut out = String::from(digits);
    let sign = if exponent < 0 { '-' } else { '+' };
    // Writing to a string cannot fail.
    let _ = write!(out, "e{sign}{:02}", exponent.abs());
    out
}
