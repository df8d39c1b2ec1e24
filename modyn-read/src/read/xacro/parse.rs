//! The parser of expressions: Python's operators, calls, displays and comprehensions.

use std::rc::Rc;

use super::value::Value;

/// An expression.
#[derive(Clone, Debug)]
pub enum Expression {
    Constant(Value),
    Name(Rc<str>),
    Unary(&'static str, Box<Expression>),
    Binary(&'static str, Box<Expression>, Box<Expression>),
    /// A first operand, then operators with their operands: `a < b <= c`.
    Compare(Box<Expression>, Vec<(&'static str, Expression)>),
    And(Box<Expression>, Box<Expression>),
    Or(Box<Expression>, Box<Expression>),
    /// `then if condition else otherwise`: the condition is first.
    Choice(Box<[Expression; 3]>),
    Attribute(Box<Expression>, Rc<str>),
    Index(Box<Expression>, Box<Expression>),
    Slice(Box<Expression>, Box<[Option<Expression>; 3]>),
    /// A function, its arguments, and its named arguments.
    Call(Box<Expression>, Vec<Expression>, Vec<(Rc<str>, Expression)>),
    List(Vec<Expression>),
    Tuple(Vec<Expression>),
    Dict(Vec<(Expression, Expression)>),
    Set(Vec<Expression>),
    Comprehension(Box<Comprehension>),
}

/// A comprehension.
#[derive(Clone, Debug)]
pub struct Comprehension {
    pub form: Form,
    /// The element; in a dictionary, the key.
    pub item: Expression,
    /// The value, in a dictionary.
    pub value: Option<Expression>,
    pub first: Loop,
}

/// The result of a comprehension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    List,
    Set,
    Dict,
    /// In parentheses.
    Iterator,
}

/// The loop of a comprehension.
#[derive(Clone, Debug)]
pub struct Loop {
    pub names: Vec<Rc<str>>,
    pub over: Expression,
    pub conditions: Vec<Expression>,
    /// The inner loop.
    pub inner: Option<Box<Loop>>,
}

/// The largest depth of an expression.
const MAX_DEPTH: usize = 60;

/// The largest number of tokens of an expression; a sum of this many terms is nested as deep.
const MAX_TOKENS: usize = 1000;

/// Returns the expression of a text. An error is the reason in words.
pub fn parse(text: &str) -> Result<Expression, String> {
    let tokens = tokens(text)?;
    if tokens.len() > MAX_TOKENS {
        return Err(format!("the expression is longer than {MAX_TOKENS} words"));
    }
    let mut parser = Parser { tokens, at: 0, depth: 0 };
    let expression = parser.expressions()?;
    match parser.peek() {
        None => Ok(expression),
        Some(token) => Err(format!("unexpected {}", token.shown())),
    }
}

/// A token.
#[derive(Clone, Debug, PartialEq)]
enum Token {
    Name(Rc<str>),
    Int(i64),
    Float(f64),
    Text(Rc<str>),
    Symbol(&'static str),
}

impl Token {
    fn shown(&self) -> String {
        match self {
            Self::Name(name) => format!("`{name}`"),
            Self::Int(value) => format!("`{value}`"),
            Self::Float(value) => format!("`{value}`"),
            Self::Text(text) => format!("the text '{text}'"),
            Self::Symbol(symbol) => format!("`{symbol}`"),
        }
    }
}

/// The symbols, longer ones before their beginnings.
const SYMBOLS: &[&str] = &[
    "**", "//", "<<", ">>", "<=", ">=", "==", "!=", "+", "-", "*", "/", "%", "<", ">", "(", ")",
    "[", "]", "{", "}", ",", ":", ".", "|", "&", "^", "~", "=",
];

fn tokens(text: &str) -> Result<Vec<Token>, String> {
    let mut tokens = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = if first.is_ascii_digit()
            || first == '.' && rest[1..].starts_with(|c: char| c.is_ascii_digit())
        {
            let (token, length) = number(rest)?;
            tokens.push(token);
            length
        } else if first.is_alphabetic() || first == '_' {
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            if rest[end..].starts_with(['\'', '"']) {
                return Err("texts with a prefix are not supported".into());
            }
            tokens.push(Token::Name(rest[..end].into()));
            end
        } else if first == '\'' || first == '"' {
            let (text, length) = quoted(rest, first)?;
            // Adjacent texts are one.
            match tokens.last_mut() {
                Some(Token::Text(before)) => *before = format!("{before}{text}").into(),
                _ => tokens.push(Token::Text(text.into())),
            }
            length
        } else {
            let longest = SYMBOLS.iter().find(|symbol| rest.starts_with(**symbol));
            let symbol = longest.ok_or_else(|| format!("unexpected `{first}`"))?;
            tokens.push(Token::Symbol(symbol));
            symbol.len()
        };
        rest = rest[length..].trim_start();
    }
    Ok(tokens)
}

/// Returns the number at the start of a text, and its length.
fn number(text: &str) -> Result<(Token, usize), String> {
    let digits = |from: usize| {
        let is_digit = |c: char| c.is_ascii_digit() || c == '_';
        text[from..].find(|c| !is_digit(c)).map_or(text.len(), |end| from + end)
    };
    for (prefix, radix) in [("0x", 16), ("0X", 16), ("0b", 2), ("0o", 8)] {
        if let Some(rest) = text.strip_prefix(prefix) {
            let end = rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
            let number = i64::from_str_radix(&rest[..end], radix);
            let value = number.map_err(|_| format!("`{}` is not a number", &text[..2 + end]))?;
            return Ok((Token::Int(value), 2 + end));
        }
    }
    let mut end = digits(0);
    let mut is_float = false;
    if text[end..].starts_with('.') {
        is_float = true;
        end = digits(end + 1);
    }
    if let Some(after) = text[end..].strip_prefix(['e', 'E']) {
        let signed = usize::from(after.starts_with(['+', '-']));
        let start = end + 1 + signed;
        if text[start..].starts_with(|c: char| c.is_ascii_digit()) {
            is_float = true;
            end = digits(start);
        }
    }
    let letter = text[end..].chars().next().filter(|c| c.is_alphanumeric() || *c == '_');
    if let Some(letter) = letter {
        return Err(format!("`{}{letter}` is not a number", &text[..end]));
    }
    let plain = text[..end].replace('_', "");
    let token = if is_float {
        Token::Float(plain.parse().map_err(|_| format!("`{plain}` is not a number"))?)
    } else {
        Token::Int(plain.parse().map_err(|_| format!("the integer `{plain}` is too large"))?)
    };
    Ok((token, end))
}

/// Returns the text in quotes at the start of `text`, and the length with the quotes.
fn quoted(text: &str, quote: char) -> Result<(String, usize), String> {
    let mut out = String::new();
    let mut chars = text.char_indices().skip(1);
    while let Some((at, c)) = chars.next() {
        match c {
            c if c == quote => return Ok((out, at + 1)),
            '\\' => match chars.next().map(|(_, c)| c) {
                Some('n') => out.push('\n'),
                Some('t') => out.push('\t'),
                Some('r') => out.push('\r'),
                Some(c) if c.is_digit(8) || "abfvxNuU\n".contains(c) => {
                    return Err(format!("the escape `\\{}` is not supported", c.escape_default()));
                }
                Some(c) if c == '\\' || c == '\'' || c == '"' => out.push(c),
                other => {
                    out.push('\\');
                    out.extend(other);
                }
            },
            c => out.push(c),
        }
    }
    Err(format!("a text is not closed by {quote}"))
}

struct Parser {
    tokens: Vec<Token>,
    at: usize,
    depth: usize,
}

type Parsed = Result<Expression, String>;

/// The arguments of a call, and those with a name.
type Arguments = (Vec<Expression>, Vec<(Rc<str>, Expression)>);

impl Parser {
    fn peek(&self) -> Option<&Token> {
        self.tokens.get(self.at)
    }

    /// Takes this symbol, or this word.
    fn take(&mut self, wanted: &str) -> bool {
        let is_next = match self.peek() {
            Some(Token::Symbol(symbol)) => *symbol == wanted,
            Some(Token::Name(name)) => &**name == wanted,
            _ => false,
        };
        self.at += usize::from(is_next);
        is_next
    }

    fn expect(&mut self, wanted: &str) -> Result<(), String> {
        if self.take(wanted) {
            return Ok(());
        }
        let next = self.peek().map_or("the end".into(), Token::shown);
        Err(format!("expected `{wanted}`, found {next}"))
    }

    /// Takes the first of these symbols that is there.
    fn take_any(&mut self, wanted: &[&'static str]) -> Option<&'static str> {
        wanted.iter().copied().find(|symbol| self.take(symbol))
    }

    /// An expression, or several with commas between them, which are a tuple.
    fn expressions(&mut self) -> Parsed {
        let first = self.expression()?;
        if !matches!(self.peek(), Some(Token::Symbol(","))) {
            return Ok(first);
        }
        let mut items = vec![first];
        while self.take(",") {
            if matches!(self.peek(), None | Some(Token::Symbol(")" | "]"))) {
                break;
            }
            items.push(self.expression()?);
        }
        Ok(Expression::Tuple(items))
    }

    fn expression(&mut self) -> Parsed {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(format!("the expression is nested more than {MAX_DEPTH} deep"));
        }
        let then = self.or()?;
        let expression = if self.take("if") {
            let condition = self.or()?;
            self.expect("else")?;
            let otherwise = self.expression()?;
            Expression::Choice(Box::new([condition, then, otherwise]))
        } else {
            then
        };
        self.depth -= 1;
        Ok(expression)
    }

    fn or(&mut self) -> Parsed {
        let mut left = self.and()?;
        while self.take("or") {
            left = Expression::Or(Box::new(left), Box::new(self.and()?));
        }
        Ok(left)
    }

    fn and(&mut self) -> Parsed {
        let mut left = self.not()?;
        while self.take("and") {
            left = Expression::And(Box::new(left), Box::new(self.not()?));
        }
        Ok(left)
    }

    fn not(&mut self) -> Parsed {
        let mut count = 0;
        while self.take("not") {
            count += 1;
        }
        let inner = self.comparison()?;
        Ok((0..count.min(2 + count % 2))
            .fold(inner, |inner, _| Expression::Unary("not", Box::new(inner))))
    }

    fn comparison(&mut self) -> Parsed {
        let first = self.binary(0)?;
        let mut rest = Vec::new();
        loop {
            let operator = match self.take_any(&["<=", ">=", "==", "!=", "<", ">", "in", "is"]) {
                Some("is") if self.take("not") => "is not",
                Some(operator) => operator,
                None if self.peek() == Some(&Token::Name("not".into()))
                    && self.tokens.get(self.at + 1) == Some(&Token::Name("in".into())) =>
                {
                    self.at += 2;
                    "not in"
                }
                None => break,
            };
            rest.push((operator, self.binary(0)?));
        }
        Ok(if rest.is_empty() { first } else { Expression::Compare(Box::new(first), rest) })
    }

    /// Operators from the weakest to the strongest, all from left to right.
    fn binary(&mut self, level: usize) -> Parsed {
        const LEVELS: &[&[&str]] =
            &[&["|"], &["^"], &["&"], &["<<", ">>"], &["+", "-"], &["*", "//", "/", "%"]];
        let Some(operators) = LEVELS.get(level) else { return self.unary() };
        let mut left = self.binary(level + 1)?;
        while let Some(operator) = self.take_any(operators) {
            let right = self.binary(level + 1)?;
            left = Expression::Binary(operator, Box::new(left), Box::new(right));
        }
        Ok(left)
    }

    fn unary(&mut self) -> Parsed {
        let Some(operator) = self.take_any(&["-", "+", "~"]) else { return self.power() };
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(format!("the expression is nested more than {MAX_DEPTH} deep"));
        }
        let inner = self.unary()?;
        self.depth -= 1;
        Ok(Expression::Unary(operator, Box::new(inner)))
    }

    fn power(&mut self) -> Parsed {
        let base = self.postfix()?;
        if !self.take("**") {
            return Ok(base);
        }
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(format!("the expression is nested more than {MAX_DEPTH} deep"));
        }
        let exponent = self.unary()?;
        self.depth -= 1;
        Ok(Expression::Binary("**", Box::new(base), Box::new(exponent)))
    }

    fn postfix(&mut self) -> Parsed {
        let mut expression = self.atom()?;
        let mut count = 0;
        loop {
            count += 1;
            if count > MAX_DEPTH {
                return Err(format!("more than {MAX_DEPTH} calls and indices follow each other"));
            }
            if self.take(".") {
                let name = self.name()?;
                expression = Expression::Attribute(Box::new(expression), name);
            } else if self.take("(") {
                let (arguments, named) = self.arguments()?;
                expression = Expression::Call(Box::new(expression), arguments, named);
            } else if self.take("[") {
                expression = self.index(expression)?;
            } else {
                return Ok(expression);
            }
        }
    }

    fn name(&mut self) -> Result<Rc<str>, String> {
        let Some(Token::Name(name)) = self.peek() else { return Err("expected a name".into()) };
        let name = name.clone();
        self.at += 1;
        Ok(name)
    }

    fn arguments(&mut self) -> Result<Arguments, String> {
        let mut arguments = Vec::new();
        let mut named = Vec::new();
        while !self.take(")") {
            let is_named = matches!(self.peek(), Some(Token::Name(_)))
                && self.tokens.get(self.at + 1) == Some(&Token::Symbol("="));
            if is_named {
                let name = self.name()?;
                self.expect("=")?;
                named.push((name, self.expression()?));
            } else {
                let argument = self.expression()?;
                let is_loop = self.peek() == Some(&Token::Name("for".into()));
                arguments.push(if is_loop {
                    self.comprehension(Form::Iterator, argument, None)?
                } else {
                    argument
                });
            }
            if !self.take(",") {
                self.expect(")")?;
                break;
            }
        }
        Ok((arguments, named))
    }

    fn index(&mut self, object: Expression) -> Parsed {
        let mut parts = [None, None, None];
        let mut colons = 0;
        loop {
            if self.take(":") {
                colons += 1;
                if colons > 2 {
                    return Err("a slice has at most two colons".into());
                }
            } else if self.take("]") {
                break;
            } else if parts[colons].is_none() {
                parts[colons] = Some(self.expressions()?);
            } else {
                self.expect("]")?;
            }
        }
        if colons > 0 {
            return Ok(Expression::Slice(Box::new(object), Box::new(parts)));
        }
        let [Some(index), ..] = parts else { return Err("an index is missing in `[]`".into()) };
        Ok(Expression::Index(Box::new(object), Box::new(index)))
    }

    fn for_loop(&mut self) -> Result<Loop, String> {
        self.expect("for")?;
        let in_parentheses = self.take("(");
        let mut names = vec![self.name()?];
        while self.take(",") {
            names.push(self.name()?);
        }
        if in_parentheses {
            self.expect(")")?;
        }
        self.expect("in")?;
        let over = self.or()?;
        let mut conditions = Vec::new();
        while self.take("if") {
            conditions.push(self.or()?);
        }
        self.depth += 1;
        let is_nested = self.peek() == Some(&Token::Name("for".into())) && self.depth < MAX_DEPTH;
        let inner = if is_nested { Some(Box::new(self.for_loop()?)) } else { None };
        self.depth -= 1;
        Ok(Loop { names, over, conditions, inner })
    }

    fn atom(&mut self) -> Parsed {
        let Some(token) = self.peek().cloned() else {
            return Err("the expression is not complete".into());
        };
        self.at += 1;
        Ok(match token {
            Token::Int(value) => Expression::Constant(Value::Int(value)),
            Token::Float(value) => Expression::Constant(Value::Float(value)),
            Token::Text(text) => Expression::Constant(Value::Text(text)),
            Token::Name(name) => match &*name {
                "True" => Expression::Constant(Value::Bool(true)),
                "False" => Expression::Constant(Value::Bool(false)),
                "None" => Expression::Constant(Value::None),
                "lambda" | "for" | "if" | "else" | "in" | "is" | "and" | "or" | "yield" => {
                    return Err(format!("unexpected `{name}`"));
                }
                _ => Expression::Name(name),
            },
            Token::Symbol("(") => {
                if self.take(")") {
                    return Ok(Expression::Tuple(Vec::new()));
                }
                let inner = self.expressions()?;
                if self.peek() == Some(&Token::Name("for".into())) {
                    let comprehension = self.comprehension(Form::Iterator, inner, None)?;
                    self.expect(")")?;
                    return Ok(comprehension);
                }
                self.expect(")")?;
                inner
            }
            Token::Symbol("[") => self.list()?,
            Token::Symbol("{") => self.dict()?,
            other => return Err(format!("unexpected {}", other.shown())),
        })
    }

    fn comprehension(&mut self, form: Form, item: Expression, value: Option<Expression>) -> Parsed {
        let first = self.for_loop()?;
        Ok(Expression::Comprehension(Box::new(Comprehension { form, item, value, first })))
    }

    fn list(&mut self) -> Parsed {
        let mut items = Vec::new();
        while !self.take("]") {
            items.push(self.expression()?);
            if items.len() == 1 && self.peek() == Some(&Token::Name("for".into())) {
                let comprehension = self.comprehension(Form::List, items.remove(0), None)?;
                self.expect("]")?;
                return Ok(comprehension);
            }
            if !self.take(",") {
                self.expect("]")?;
                break;
            }
        }
        Ok(Expression::List(items))
    }

    /// The rest of a set after its first value.
    fn set(&mut self, first: Expression) -> Parsed {
        if self.peek() == Some(&Token::Name("for".into())) {
            let comprehension = self.comprehension(Form::Set, first, None)?;
            self.expect("}")?;
            return Ok(comprehension);
        }
        let mut items = vec![first];
        while !self.take("}") {
            self.expect(",")?;
            if self.take("}") {
                break;
            }
            items.push(self.expression()?);
        }
        Ok(Expression::Set(items))
    }

    /// A dictionary, or a set.
    fn dict(&mut self) -> Parsed {
        let mut entries = Vec::new();
        while !self.take("}") {
            let key = self.expression()?;
            let is_set = entries.is_empty() && self.peek() != Some(&Token::Symbol(":"));
            if is_set {
                return self.set(key);
            }
            self.expect(":")?;
            let value = self.expression()?;
            if entries.is_empty() && self.peek() == Some(&Token::Name("for".into())) {
                let comprehension = self.comprehension(Form::Dict, key, Some(value))?;
                self.expect("}")?;
                return Ok(comprehension);
            }
            entries.push((key, value));
            if !self.take(",") {
                self.expect("}")?;
                break;
            }
        }
        Ok(Expression::Dict(entries))
    }
}
