//! The values of options as text, the same in the macro, on the command line and in tests.
//!
//! ```text
//! value = number | word | "text" | [value, ...] | (value, ...) | word(value, ...) | name: value | name = value
//! ```
//!
//! A word is a name or a path without quotes. Several values with commas between them are a list.

/// An error in the value of an option.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OptionError {
    /// The place in the text, in bytes.
    pub at: usize,
    /// The error, and the form that the value should have.
    pub message: String,
    /// Whether the message is that form, in the syntax of option values alone.
    pub is_form: bool,
}

impl OptionError {
    pub(super) fn new(at: usize, message: impl Into<String>) -> Self {
        Self { at, message: message.into(), is_form: false }
    }

    /// Returns the error that a value has another form than `expected`, which is in the syntax of
    /// option values.
    pub(super) fn form(at: usize, expected: impl Into<String>) -> Self {
        Self { at, message: expected.into(), is_form: true }
    }
}

/// The value of an option, with its place in the text.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// The place in the text, in bytes.
    pub at: usize,
    /// The value.
    pub kind: ValueKind,
}

/// A value of an option.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueKind {
    /// A number.
    Number(f64),
    /// A name or a path without quotes.
    Word(String),
    /// A text in quotes.
    Text(String),
    /// Values in brackets or parentheses.
    List(Vec<Value>),
    /// A word with arguments.
    Call(String, Vec<Value>),
    /// A name with a value.
    Pair(Box<Value>, Box<Value>),
}

impl Value {
    /// The value that `text` is, as it stands.
    #[must_use]
    pub fn text(text: impl Into<String>) -> Self {
        Self { at: 0, kind: ValueKind::Text(text.into()) }
    }

    /// The value that is written in `text`.
    ///
    /// # Errors
    ///
    /// If `text` is not a value, or more than one that commas separate.
    pub fn parse(text: &str) -> Result<Self, OptionError> {
        let mut parser = Parser { text, at: 0, depth: 0 };
        let mut values = parser.values(None)?;
        match values.len() {
            0 => Err(OptionError::new(text.len(), "expected a value")),
            1 => Ok(values.remove(0)),
            _ => Ok(Self { at: 0, kind: ValueKind::List(values) }),
        }
    }

    /// Returns the value as a keyword argument of the Python package: pairs are a dictionary, and a
    /// word with arguments is a tuple that begins with the word.
    #[must_use]
    pub fn in_python(&self) -> String {
        let all = |values: &mut dyn Iterator<Item = &Self>| -> String {
            values.map(Self::in_python).collect::<Vec<_>>().join(", ")
        };
        let is_pair = |value: &&Self| matches!(value.kind, ValueKind::Pair(..));
        match &self.kind {
            ValueKind::Number(x) => x.to_string(),
            ValueKind::Word(word) => match word.as_str() {
                "true" => "True".into(),
                "false" => "False".into(),
                word => format!("{word:?}"),
            },
            ValueKind::Text(text) => format!("{text:?}"),
            ValueKind::List(values) if !values.is_empty() && values.iter().all(|v| is_pair(&v)) => {
                format!("{{{}}}", all(&mut values.iter()))
            }
            ValueKind::List(values) => format!("[{}]", all(&mut values.iter())),
            ValueKind::Call(word, values) => {
                let mut parts = vec![format!("{word:?}")];
                parts.extend(values.iter().filter(|value| !is_pair(value)).map(Self::in_python));
                if values.iter().any(|value| is_pair(&value)) {
                    parts.push(format!("{{{}}}", all(&mut values.iter().filter(is_pair))));
                }
                format!("({})", parts.join(", "))
            }
            ValueKind::Pair(name, value) => format!("{}: {}", name.in_python(), value.in_python()),
        }
    }

    /// The items of a list; a single value is a list of one.
    #[must_use]
    pub fn items(&self) -> &[Self] {
        match &self.kind {
            ValueKind::List(items) => items,
            _ => std::slice::from_ref(self),
        }
    }
}

/// The largest number of brackets that are open at the same time.
const MAX_DEPTH: usize = 20;

struct Parser<'t> {
    text: &'t str,
    at: usize,
    depth: usize,
}

impl Parser<'_> {
    /// The next character that is not white space, which stays.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    /// Whether `wanted` came next, which is then read.
    fn take(&mut self, wanted: char) -> bool {
        let is_next = self.peek() == Some(wanted);
        if is_next {
            self.at += wanted.len_utf8();
        }
        is_next
    }

    /// Values with commas between them, perhaps one after the last, up to `end`.
    fn values(&mut self, end: Option<char>) -> Result<Vec<Value>, OptionError> {
        let mut values = Vec::new();
        loop {
            match (self.peek(), end) {
                (None, None) => return Ok(values),
                (None, Some(end)) => {
                    return Err(OptionError::new(self.at, format!("expected `{end}`")));
                }
                (next, end) if next == end => {
                    self.at += 1;
                    return Ok(values);
                }
                _ => values.push(self.pair()?),
            }
            let next = self.peek();
            if next.is_some() && next != end && !self.take(',') {
                return Err(OptionError::new(self.at, "expected `,`"));
            }
        }
    }

    /// A value, or a name with a value.
    fn pair(&mut self) -> Result<Value, OptionError> {
        let first = self.value()?;
        let named = matches!(first.kind, ValueKind::Word(_) | ValueKind::Text(_));
        if named && (self.take(':') || self.take('=')) {
            let at = first.at;
            let value = self.value()?;
            return Ok(Value { at, kind: ValueKind::Pair(Box::new(first), Box::new(value)) });
        }
        Ok(first)
    }

    fn value(&mut self) -> Result<Value, OptionError> {
        let next = self.peek();
        let at = self.at;
        let kind = match next {
            Some('"') => ValueKind::Text(self.quoted()?),
            Some('[') => ValueKind::List(self.group(']')?),
            Some('(') => ValueKind::List(self.group(')')?),
            _ => self.word()?,
        };
        Ok(Value { at, kind })
    }

    /// The values after an opening bracket, up to `end`.
    fn group(&mut self, end: char) -> Result<Vec<Value>, OptionError> {
        if self.depth == MAX_DEPTH {
            return Err(OptionError::new(
                self.at,
                format!("more than {MAX_DEPTH} brackets are open"),
            ));
        }
        (self.at, self.depth) = (self.at + 1, self.depth + 1);
        let values = self.values(Some(end))?;
        self.depth -= 1;
        Ok(values)
    }

    /// Returns the text in quotes. Quotes and backslashes of the text are escaped by a backslash.
    fn quoted(&mut self) -> Result<String, OptionError> {
        let start = self.at;
        let mut text = String::new();
        let mut characters = self.text[start + 1..].char_indices();
        while let Some((i, c)) = characters.next() {
            match c {
                '"' => {
                    self.at = start + i + 2;
                    return Ok(text);
                }
                '\\' => text.extend(characters.next().map(|(_, escaped)| escaped)),
                c => text.push(c),
            }
        }
        Err(OptionError::new(start, "the quotes are not closed"))
    }

    /// A word, a word with arguments, or a number.
    fn word(&mut self) -> Result<ValueKind, OptionError> {
        let rest = &self.text[self.at..];
        let mut length = 0;
        while let Some(next) = rest[length..].chars().next() {
            match next {
                // In paths; a single one follows a name.
                ':' if rest[length..].starts_with("::") => length += 2,
                ':' | '=' | ',' | '[' | ']' | '(' | ')' | '"' => break,
                c if c.is_whitespace() => break,
                c => length += c.len_utf8(),
            }
        }
        let at = self.at;
        let word = &rest[..length];
        if word.is_empty() {
            return Err(OptionError::new(at, "expected a value"));
        }
        self.at += length;
        if word.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.'))
            && let Ok(number) = word.parse::<f64>()
        {
            return Ok(ValueKind::Number(number));
        }
        if self.text[self.at..].starts_with('(') {
            return Ok(ValueKind::Call(word.into(), self.group(')')?));
        }
        Ok(ValueKind::Word(word.into()))
    }
}
