//! The values of expressions, with the texts that Python gives them.

use std::cmp::Ordering;
use std::fmt::Write;
use std::rc::Rc;

use super::tree::Element;

/// A scope of properties by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScopeId(pub usize);

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
            Self::Function(_) | Self::Method(_) => "a function",
            Self::Module(_) | Self::Scope(_) => "a namespace",
            Self::Block(_) => "a block",
        }
    }

    /// Returns whether two values are equal.
    pub fn equals(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::None, Self::None) => true,
            (Self::Text(a), Self::Text(b)) => a == b,
            (Self::List(a), Self::List(b)) | (Self::Tuple(a), Self::Tuple(b)) => {
                a.len() == b.len() && a.iter().zip(b.iter()).all(|(a, b)| a.equals(b))
            }
            (Self::Dict(a), Self::Dict(b)) => {
                a.len() == b.len()
                    && a.iter().all(|(key, value)| {
                        other.entry(key).is_some_and(|found| found.equals(value))
                    })
            }
            (Self::Function(a), Self::Function(b)) => a == b,
            _ => match (self.number(), other.number()) {
                (Some(a), Some(b)) => a == b,
                _ => false,
            },
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
            (Self::Int(a), Self::Int(b)) => Some(a.cmp(b)),
            _ => self.number()?.partial_cmp(&other.number()?),
        }
    }

    /// Returns the value of a key of a dictionary.
    pub fn entry(&self, key: &Self) -> Option<Self> {
        let Self::Dict(entries) = self else { return None };
        entries.iter().find(|(own, _)| own.equals(key)).map(|(_, value)| value.clone())
    }

    /// Returns the text, as Python's `str` writes it.
    pub fn display(&self) -> Rc<str> {
        match self {
            Self::Text(text) => text.clone(),
            other => other.repr().into(),
        }
    }

    /// Returns the text of an expression of this value, as Python's `repr` writes it.
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
            Self::Function(name) | Self::Module(name) => format!("<{name}>"),
            Self::Method(method) => format!("<{}>", method.1),
            Self::Scope(_) => "<namespace>".into(),
            Self::Block(_) => "<block>".into(),
        }
    }
}

/// Returns a text in quotes, as Python writes it.
fn quoted(text: &str) -> String {
    let quote = if text.contains('\'') && !text.contains('"') { '"' } else { '\'' };
    let mut out = String::from(quote);
    for c in text.chars() {
        match c {
            '\n' => out += "\\n",
            '\t' => out += "\\t",
            '\\' => out += "\\\\",
            c if c == quote => out.extend(['\\', c]),
            c => out.push(c),
        }
    }
    out.push(quote);
    out
}

/// Returns the shortest text that reads back as this number, in the form of Python: an exponent from 1e16 on and below 1e-4.
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
