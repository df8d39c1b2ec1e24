//! Reads the YAML of `xacro.load_yaml`: mappings, lists and scalars as robot files have them, and
//! JSON.
//!
//! Texts of several lines, anchors in brackets and several documents are refused with their line.
//! Scalars have the types of YAML 1.1, as Python's reader gives them. `!degrees`, `!radians` and
//! the units of length are numbers or expressions.

use std::collections::BTreeMap;

use super::value::{DictEntries, Value};
use crate::work;

/// The largest depth of a document.
const MAX_DEPTH: usize = 60;

/// The units that numbers may have, with their factors.
const UNITS: &[(&str, f64)] = &[
    ("!radians", 1.0),
    ("!degrees", std::f64::consts::PI / 180.0),
    ("!meters", 1.0),
    ("!millimeters", 0.001),
    ("!foot", 0.3048),
    ("!inches", 0.0254),
];

/// The program that reads a YAML.
pub trait Host {
    /// Returns the number of an expression, which has a unit.
    fn number(&self, expression: &str) -> Result<f64, String>;

    /// Counts work; an error if there is too much.
    fn spend(&self, work: usize) -> Result<(), String>;
}

/// Returns the value of a text. An error is a line, counted from 1, and the reason in words.
pub fn read(text: &str, host: &dyn Host) -> Result<Value, (usize, String)> {
    let mut lines = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let content = without_comment(line);
        let trimmed = content.trim();
        if trimmed.is_empty() || trimmed == "---" || trimmed.starts_with('%') {
            continue;
        }
        if trimmed == "..." {
            break;
        }
        let indent = content.len() - content.trim_start_matches(' ').len();
        if content[indent..].starts_with('\t') {
            return Err((i + 1, "a tab cannot indent".into()));
        }
        work::count(1);
        lines.push(Line { number: i + 1, indent, text: trimmed.into() });
    }
    let mut reader = Reader { lines, at: 0, anchors: BTreeMap::new(), host };
    if reader.lines.is_empty() {
        return Ok(Value::None);
    }
    let indent = reader.lines[0].indent;
    let value = reader.block(indent, 0)?;
    match reader.lines.get(reader.at) {
        None => Ok(value),
        Some(line) => Err((line.number, "this line does not belong to what precedes it".into())),
    }
}

/// Returns a line up to its comment.
fn without_comment(line: &str) -> &str {
    let mut quote = None;
    let mut before = ' ';
    for (at, c) in line.char_indices() {
        match quote {
            None if c == '#' && before.is_whitespace() => return &line[..at],
            None if (c == '"' || c == '\'') && " [{,:(".contains(before) => quote = Some(c),
            Some(open) if c == open => quote = None,
            _ => {}
        }
        before = c;
    }
    line
}

struct Line {
    number: usize,
    indent: usize,
    text: String,
}

struct Reader<'e> {
    lines: Vec<Line>,
    at: usize,
    /// The values with names, `&name`, which `*name` repeats.
    anchors: BTreeMap<String, Value>,
    host: &'e dyn Host,
}

type Read = Result<Value, (usize, String)>;

impl Reader<'_> {
    /// Reads the mapping, list or scalar whose lines have this indent.
    fn block(&mut self, indent: usize, depth: usize) -> Read {
        let number = self.lines[self.at].number;
        if depth > MAX_DEPTH {
            return Err((number, format!("it is nested more than {MAX_DEPTH} deep")));
        }
        let text = &self.lines[self.at].text;
        if is_item(text) {
            return self.items(indent, depth);
        }
        if text.starts_with(['[', '{']) || key_of(text).is_none() {
            let text = self.joined();
            return self.inline(&text, number);
        }
        self.mapping(indent, depth)
    }

    /// Takes a line, and further lines as long as its brackets are open.
    fn joined(&mut self) -> String {
        let mut text = self.lines[self.at].text.clone();
        self.at += 1;
        if !text.starts_with(['[', '{']) {
            return text;
        }
        let mut brackets = Brackets::default();
        brackets.take(&text);
        while brackets.open > 0 && self.at < self.lines.len() {
            let line = &self.lines[self.at].text;
            brackets.take(" ");
            brackets.take(line);
            text += " ";
            text += line;
            self.at += 1;
        }
        text
    }

    fn items(&mut self, indent: usize, depth: usize) -> Read {
        let mut items = Vec::new();
        while let Some(line) = self.lines.get_mut(self.at) {
            if line.indent != indent || !is_item(&line.text) {
                break;
            }
            let (anchor, rest) = anchor(line.text[1..].trim_start());
            let value = if rest.is_empty() {
                self.at += 1;
                self.nested(indent + 1, depth)?
            } else {
                // The rest of the line is the first line of the item.
                line.indent += line.text.len() - rest.len();
                line.text = rest;
                let inner = line.indent;
                self.block(inner, depth + 1)?
            };
            items.push(self.named(anchor, value));
        }
        Ok(Value::list(items))
    }

    fn mapping(&mut self, indent: usize, depth: usize) -> Read {
        let mut entries = DictEntries::default();
        while let Some(line) = self.lines.get(self.at) {
            let number = line.number;
            if line.indent != indent || is_item(&line.text) {
                break;
            }
            let Some((key, rest)) = key_of(&line.text) else {
                return Err((number, "expected `key: value`".into()));
            };
            let key = key.to_owned();
            let (anchor, rest) = anchor(rest);
            let key = self.scalar(&key, number)?;
            let given = if rest.is_empty() {
                self.at += 1;
                // The items of a list may have the indent of their key.
                let next = self.lines.get(self.at);
                let list = next.is_some_and(|line| line.indent == indent && is_item(&line.text));
                if list { self.items(indent, depth + 1)? } else { self.nested(indent + 1, depth)? }
            } else {
                self.lines[self.at].text = rest;
                let text = self.joined();
                self.inline(&text, number)?
            };
            let value = self.named(anchor, given);
            if let (Value::Text(merge), Value::Dict(others)) = (&key, &value)
                && &**merge == "<<"
            {
                self.spend(others.len() / 100, number)?;
                for (name, value) in others.iter() {
                    let added = entries.add(name.clone(), value.clone());
                    added.map_err(|reason| (number, reason))?;
                }
                continue;
            }
            // The last of equal keys counts.
            entries.set(key, value).map_err(|reason| (number, reason))?;
        }
        Ok(entries.dict())
    }

    /// Returns the value, which `*name` then repeats.
    fn named(&mut self, anchor: Option<String>, value: Value) -> Value {
        self.anchors.extend(anchor.map(|name| (name, value.clone())));
        value
    }

    /// Reads the lines that are indented at least so far; `None` if there are none.
    fn nested(&mut self, least: usize, depth: usize) -> Read {
        match self.lines.get(self.at).map(|line| line.indent) {
            Some(indent) if indent >= least => self.block(indent, depth + 1),
            _ => Ok(Value::None),
        }
    }

    /// Reads a value that is written in a line.
    fn inline(&mut self, text: &str, number: usize) -> Read {
        let mut flow = Flow { rest: text, number, depth: 0, reader: self };
        let value = flow.value("")?;
        let rest = flow.rest.trim();
        if rest.is_empty() {
            return Ok(value);
        }
        Err((number, format!("`{rest}` follows a value")))
    }

    /// Counts work in a line; an error if there is too much.
    fn spend(&self, work: usize, number: usize) -> Result<(), (usize, String)> {
        self.host.spend(work).map_err(|reason| (number, reason))
    }

    /// Returns the value of a scalar without quotes, or with them.
    fn scalar(&mut self, text: &str, number: usize) -> Read {
        let text = text.trim();
        if text.starts_with('!') {
            let (tag, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
            let Some((_, factor)) = UNITS.iter().find(|(name, _)| *name == tag) else {
                return Err((number, format!("the tag `{tag}` is not known")));
            };
            let value = self.host.number(rest.trim()).map_err(|reason| (number, reason))?;
            return Ok(Value::Float(value * factor));
        }
        if let Some(name) = text.strip_prefix('*') {
            let Some(value) = self.anchors.get(name).cloned() else {
                return Err((number, format!("there is no `&{name}` before this")));
            };
            // The values of an alias count each time, as in all that prints them.
            let weight = value.weight().map_err(|reason| (number, reason))?;
            self.spend(weight / 10, number)?;
            return Ok(value);
        }
        if text.starts_with(['&', '|', '>', '@', '`']) {
            let message = format!("`{text}` is not supported: write the value itself, in one line");
            return Err((number, message));
        }
        for quote in ['"', '\''] {
            let inner = text.strip_prefix(quote).and_then(|rest| rest.strip_suffix(quote));
            if let Some(inner) = inner.filter(|_| text.len() > 1) {
                return Ok(Value::text(unquoted(inner, quote)));
            }
        }
        Ok(plain(text))
    }
}

/// Returns the text in quotes.
fn unquoted(inner: &str, quote: char) -> String {
    if quote == '\'' {
        return inner.replace("''", "'");
    }
    let mut out = String::new();
    let mut chars = inner.chars();
    while let Some(c) = chars.next() {
        match (c, if c == '\\' { chars.next() } else { None }) {
            (_, Some('n')) => out.push('\n'),
            (_, Some('t')) => out.push('\t'),
            (_, Some(c)) => out.push(c),
            (c, None) => out.push(c),
        }
    }
    out
}

/// Returns the value of a scalar without quotes, as YAML 1.1 has it.
fn plain(text: &str) -> Value {
    match text {
        "" | "~" | "null" | "Null" | "NULL" => return Value::None,
        "true" | "True" | "TRUE" | "yes" | "Yes" | "YES" | "on" | "On" | "ON" => {
            return Value::Bool(true);
        }
        "false" | "False" | "FALSE" | "no" | "No" | "NO" | "off" | "Off" | "OFF" => {
            return Value::Bool(false);
        }
        ".inf" | "+.inf" | ".Inf" | ".INF" => return Value::Float(f64::INFINITY),
        "-.inf" | "-.Inf" | "-.INF" => return Value::Float(f64::NEG_INFINITY),
        ".nan" | ".NaN" | ".NAN" => return Value::Float(f64::NAN),
        _ => {}
    }
    let unsigned = text.trim_start_matches(['+', '-']);
    if text.len() - unsigned.len() <= 1
        && unsigned.starts_with(|c: char| c.is_ascii_digit() || c == '.')
    {
        let digits = text.replace('_', "");
        let is_decimal = unsigned.bytes().all(|b| b.is_ascii_digit() || b == b'_');
        let is_octal = is_decimal && unsigned.len() > 1 && unsigned.starts_with('0');
        if let Some(hex) = unsigned.strip_prefix("0x")
            && let Ok(value) = i64::from_str_radix(hex, 16)
        {
            return Value::Int(if text.starts_with('-') { -value } else { value });
        }
        if is_octal {
            if let Ok(value) = i64::from_str_radix(&unsigned.replace('_', ""), 8) {
                return Value::Int(if text.starts_with('-') { -value } else { value });
            }
        } else if is_decimal && let Ok(value) = digits.parse() {
            return Value::Int(value);
        }
        // A number has a point, and its exponent a sign.
        let is_float = unsigned.contains('.')
            && (text == unsigned || !unsigned.starts_with('.'))
            && unsigned.split_once(['e', 'E']).is_none_or(|(_, e)| e.starts_with(['+', '-']))
            && unsigned.bytes().all(|b| b.is_ascii_digit() || b"._eE+-".contains(&b));
        if is_float && let Ok(value) = digits.parse() {
            return Value::Float(value);
        }
    }
    Value::text(text)
}

/// Returns the name of an anchor, `&name`, and the text after it.
fn anchor(text: &str) -> (Option<String>, String) {
    let Some(rest) = text.strip_prefix('&') else { return (None, text.into()) };
    let (name, rest) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
    (Some(name.into()), rest.trim_start().into())
}

/// Returns whether a line is an item of a list.
fn is_item(text: &str) -> bool {
    text == "-" || text.starts_with("- ")
}

/// Returns the key of a line and the text after it.
fn key_of(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| *c == '"' || *c == '\'');
    let from = match quote {
        Some(quote) => 2 + text[1..].find(quote)?,
        None => 0,
    };
    let mut search = from;
    loop {
        let at = search + text.get(search..)?.find(':')?;
        let rest = &text[at + 1..];
        if rest.is_empty() || rest.starts_with([' ', '\t']) {
            return Some((&text[..at], rest.trim()));
        }
        search = at + 1;
    }
}

/// The brackets and the quote that are open after a part of a text.
#[derive(Default)]
struct Brackets {
    open: i32,
    quote: Option<char>,
    escaped: bool,
}

impl Brackets {
    /// Counts the brackets of the next part of the text.
    fn take(&mut self, text: &str) {
        for c in text.chars() {
            match (self.quote, c) {
                (None, '[' | '{') => self.open += 1,
                (None, ']' | '}') => self.open -= 1,
                (None, '"' | '\'') => self.quote = Some(c),
                (Some(open), c) if open == c && !self.escaped => self.quote = None,
                _ => {}
            }
            self.escaped = c == '\\' && self.quote == Some('"') && !self.escaped;
        }
    }
}

/// Lists and mappings in brackets.
struct Flow<'t, 'r, 'e> {
    rest: &'t str,
    number: usize,
    depth: usize,
    reader: &'r mut Reader<'e>,
}

impl<'t> Flow<'t, '_, '_> {
    fn skip(&mut self) {
        self.rest = self.rest.trim_start();
    }

    fn take(&mut self, wanted: char) -> bool {
        self.skip();
        let rest = self.rest.strip_prefix(wanted);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    /// Reads a value, which ends before one of these characters.
    fn value(&mut self, ends: &str) -> Read {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err((self.number, format!("it is nested more than {MAX_DEPTH} deep")));
        }
        let value = if self.take('[') {
            let mut items = Vec::new();
            while !self.take(']') {
                items.push(self.value(",]")?);
                self.separator(']')?;
            }
            Value::list(items)
        } else if self.take('{') {
            let mut entries = DictEntries::default();
            while !self.take('}') {
                let key = self.value(":,}")?;
                let value = if self.take(':') { self.value(",}")? } else { Value::None };
                entries.set(key, value).map_err(|reason| (self.number, reason))?;
                self.separator('}')?;
            }
            entries.dict()
        } else {
            let text = self.word(ends);
            self.reader.scalar(text, self.number)?
        };
        self.depth -= 1;
        Ok(value)
    }

    fn separator(&mut self, end: char) -> Result<(), (usize, String)> {
        if self.take(',') || self.rest.starts_with(end) {
            return Ok(());
        }
        let next = self.rest.chars().next().map_or("the end".into(), |c| format!("`{c}`"));
        Err((self.number, format!("expected `,` or `{end}`, found {next}")))
    }

    /// Takes the text of a scalar.
    fn word(&mut self, ends: &str) -> &'t str {
        self.skip();
        let quote = self.rest.chars().next().filter(|c| *c == '"' || *c == '\'');
        let end = match quote {
            Some(quote) => {
                let inner = self.rest[1..].char_indices();
                let mut escaped = false;
                let mut close = inner.skip_while(|(_, c)| {
                    let is_end = *c == quote && !escaped;
                    escaped = *c == '\\' && quote == '"' && !escaped;
                    !is_end
                });
                close.next().map_or(self.rest.len(), |(at, _)| at + 2)
            }
            None => self.rest.find(|c| ends.contains(c)).unwrap_or(self.rest.len()),
        };
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        word
    }
}
