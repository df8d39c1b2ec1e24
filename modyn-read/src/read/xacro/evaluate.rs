//! Evaluates expressions as Python does, within limits: no code is run but the operators and
//! functions of the language.

use std::rc::Rc;

use super::functions;
use super::parse::{Comprehension, Expression, Form, Loop};
use super::value::{DictEntries, SequenceKind, Value};

/// The names of an expression, and the work that it may still do.
pub trait Names {
    /// Returns the value of a name; `None` if there is none.
    fn name(&mut self, name: &str) -> Result<Option<Value>, String>;

    /// Returns the value of a name in a namespace.
    fn name_in(&mut self, namespace: &Value, name: &str) -> Result<Option<Value>, String>;

    /// Calls a function that needs more than its arguments, such as `xacro.load_yaml`.
    fn call(&mut self, function: &str, arguments: &[Value]) -> Result<Value, String>;

    /// Counts work; an error if the description does too much of it.
    fn spend(&mut self, work: usize) -> Result<(), String>;

    /// Enters an operation in others, with the operations of the properties that it needs; an error
    /// if they are too many for the call stack.
    fn enter(&mut self) -> Result<(), String>;

    /// Leaves an operation.
    fn leave(&mut self);

    /// Returns advice for a name that is not there.
    fn similar(&self, name: &str) -> Option<String>;
}

type Evaluated = Result<Value, String>;

/// The largest length of a text or a list.
const MAX_LENGTH: usize = 1 << 20;

/// Returns the value of an expression. An error is the reason in words.
pub fn evaluate(expression: &Expression, names: &mut dyn Names) -> Evaluated {
    Evaluator { names, locals: Vec::new() }.value(expression)
}

struct Evaluator<'n> {
    names: &'n mut dyn Names,
    /// The names of comprehensions, the innermost last.
    locals: Vec<(Rc<str>, Value)>,
}

impl Evaluator<'_> {
    fn value(&mut self, expression: &Expression) -> Evaluated {
        self.names.spend(1)?;
        self.names.enter()?;
        let value = self.operation(expression)?;
        self.names.leave();
        Ok(value)
    }

    fn operation(&mut self, expression: &Expression) -> Evaluated {
        Ok(match expression {
            Expression::Constant(value) => value.clone(),
            Expression::Name(name) => self.name(name)?,
            Expression::Unary(operator, inner) => unary(operator, &self.value(inner)?)?,
            Expression::Binary(operator, left, right) => {
                let left = self.value(left)?;
                let right = self.value(right)?;
                self.binary(operator, &left, &right)?
            }
            Expression::Compare(first, rest) => {
                let mut left = self.value(first)?;
                for (operator, right) in rest {
                    let right = self.value(right)?;
                    self.weigh_comparison(&left, &right)?;
                    if !compare(operator, &left, &right)? {
                        return Ok(Value::Bool(false));
                    }
                    left = right;
                }
                Value::Bool(true)
            }
            Expression::And(left, right) => {
                let left = self.value(left)?;
                if left.is_true() { self.value(right)? } else { left }
            }
            Expression::Or(left, right) => {
                let left = self.value(left)?;
                if left.is_true() { left } else { self.value(right)? }
            }
            Expression::Choice(parts) => {
                let [condition, then, otherwise] = &**parts;
                let chosen = if self.value(condition)?.is_true() { then } else { otherwise };
                self.value(chosen)?
            }
            Expression::Attribute(object, name) => {
                let value = self.value(object)?;
                self.attribute(&value, name)?
            }
            Expression::Index(object, index) => {
                let value = self.value(object)?;
                let index = self.value(index)?;
                self.weigh(&index)?;
                self.names.spend(functions::length(&value) / 100)?;
                item(&value, &index)?
            }
            Expression::Slice(object, parts) => {
                let object = self.value(object)?;
                let mut bounds = [None; 3];
                for (bound, part) in bounds.iter_mut().zip(&**parts) {
                    let Some(part) = part else { continue };
                    let value = self.value(part)?;
                    *bound = Some(value.integer().ok_or("the bounds of a slice are integers")?);
                }
                slice(&object, bounds)?
            }
            Expression::Call(function, arguments, named) => {
                let function = self.value(function)?;
                let mut values = Vec::new();
                for argument in arguments {
                    values.push(self.value(argument)?);
                }
                let mut keywords = Vec::new();
                for (name, argument) in named {
                    keywords.push((name.clone(), self.value(argument)?));
                }
                self.call(&function, values, keywords)?
            }
            Expression::List(items) => Value::list(self.values(items)?),
            Expression::Tuple(items) => Value::Tuple(Rc::new(self.values(items)?)),
            Expression::Dict(entries) => {
                let mut dictionary = DictEntries::default();
                for (key, value) in entries {
                    let key = self.value(key)?;
                    self.weigh(&key)?;
                    dictionary.set(key, self.value(value)?)?;
                }
                dictionary.dict()
            }
            Expression::Set(items) => {
                let items = self.values(items)?;
                self.set(items)?
            }
            Expression::Comprehension(comprehension) => {
                let mut out = Vec::new();
                self.comprehension(comprehension, &comprehension.first, &mut out)?;
                let items = out.iter().map(|(item, _)| item.clone());
                match comprehension.form {
                    Form::List => Value::list(items.collect()),
                    Form::Iterator => Value::iterator(items.collect()),
                    Form::Set => self.set(items.collect())?,
                    Form::Dict => {
                        for (key, _) in &out {
                            self.weigh(key)?;
                        }
                        DictEntries::of(out)?.dict()
                    }
                }
            }
        })
    }

    fn values(&mut self, items: &[Expression]) -> Result<Vec<Value>, String> {
        items.iter().map(|item| self.value(item)).collect()
    }

    fn name(&mut self, name: &Rc<str>) -> Evaluated {
        if let Some((_, value)) = self.locals.iter().rev().find(|(local, _)| local == name) {
            return Ok(value.clone());
        }
        if let Some(value) = self.names.name(name)? {
            return Ok(value);
        }
        functions::global(name).ok_or_else(|| match self.names.similar(name) {
            Some(similar) => format!("the name `{name}` is not defined; did you mean `{similar}`?"),
            None => format!("the name `{name}` is not defined"),
        })
    }

    fn attribute(&mut self, object: &Value, name: &Rc<str>) -> Evaluated {
        let member = match object {
            Value::Module(module) => functions::member(module, name),
            Value::Scope(_) => self.names.name_in(object, name)?,
            _ if functions::is_method(object, name) => {
                Some(Value::Method(Rc::new((object.clone(), name.clone()))))
            }
            Value::Dict(_) => object.entry(&Value::Text(name.clone())),
            _ => None,
        };
        member.ok_or_else(|| format!("{} has no `{name}`", object.kind()))
    }

    fn call(
        &mut self,
        function: &Value,
        arguments: Vec<Value>,
        named: Vec<(Rc<str>, Value)>,
    ) -> Evaluated {
        let work: usize = arguments.iter().map(functions::length).sum();
        self.names.spend(1 + work)?;
        if let Value::Method(method) = function {
            self.names.spend(functions::length(&method.0) / 100)?;
        }
        self.weigh_call(function, &arguments)?;
        match function {
            Value::Function("dict") => functions::dict(&arguments, named),
            Value::Function(name @ ("map" | "filter")) => {
                let [function, over] = arguments.as_slice() else {
                    return Err(format!("`{name}` has a function and a list"));
                };
                let mut results = Vec::new();
                for item in functions::items(over)? {
                    let is_identity = *name == "filter" && matches!(function, Value::None);
                    let result = if is_identity {
                        item.clone()
                    } else {
                        self.call(function, vec![item.clone()], Vec::new())?
                    };
                    if *name == "map" {
                        results.push(result);
                    } else if result.is_true() {
                        results.push(item);
                    }
                }
                Ok(Value::iterator(results))
            }
            Value::Function("divmod") => {
                let [left, right] = arguments.as_slice() else {
                    return Err("`divmod` has two numbers".into());
                };
                let results = [arithmetic("//", left, right)?, arithmetic("%", left, right)?];
                let parts = results.into_iter().flatten().collect::<Vec<_>>();
                if parts.len() < 2 {
                    return Err(format!("`divmod` of {} and {}", left.kind(), right.kind()));
                }
                Ok(Value::Tuple(Rc::new(parts)))
            }
            Value::Function("sorted") if !named.is_empty() => functions::sorted(&arguments, &named),
            Value::Function(name) if name.starts_with("xacro.") => {
                self.names.call(name, &arguments)
            }
            _ if !named.is_empty() => {
                Err(format!("the named argument `{}` is not supported", named[0].0))
            }
            Value::Function(name) => functions::call(name, &arguments),
            Value::Method(method) => functions::call_method(&method.0, &method.1, &arguments),
            other => Err(format!("{} is not a function", other.kind())),
        }
    }

    fn comprehension(
        &mut self,
        comprehension: &Comprehension,
        clause: &Loop,
        out: &mut Vec<(Value, Value)>,
    ) -> Result<(), String> {
        let over = self.value(&clause.over)?;
        for element in functions::items(&over)? {
            self.names.spend(1)?;
            let before = self.locals.len();
            match clause.names.as_slice() {
                [name] => self.locals.push((name.clone(), element)),
                names => {
                    let parts = functions::items(&element)?;
                    if parts.len() != names.len() {
                        return Err(format!("{} names, but {} values", names.len(), parts.len()));
                    }
                    self.locals.extend(names.iter().cloned().zip(parts));
                }
            }
            let mut holds = true;
            for condition in &clause.conditions {
                holds = holds && self.value(condition)?.is_true();
            }
            if holds {
                match &clause.inner {
                    Some(inner) => self.comprehension(comprehension, inner, out)?,
                    None => {
                        let key = self.value(&comprehension.item)?;
                        let expression = comprehension.value.as_ref();
                        let value =
                            expression.map_or(Ok(Value::None), |value| self.value(value))?;
                        out.push((key, value));
                    }
                }
            }
            self.locals.truncate(before);
        }
        Ok(())
    }

    fn binary(&mut self, operator: &str, left: &Value, right: &Value) -> Evaluated {
        if let Some(result) = arithmetic(operator, left, right)? {
            return Ok(result);
        }
        let result = match (operator, left, right) {
            ("+", Value::Text(a), Value::Text(b)) => {
                self.names.spend(a.len() + b.len())?;
                Value::text(format!("{a}{b}"))
            }
            ("+", Value::List(a), Value::List(b)) => {
                self.names.spend(a.len() + b.len())?;
                Value::list(a.iter().chain(b.iter()).cloned().collect())
            }
            ("+", Value::Tuple(a), Value::Tuple(b)) => {
                self.names.spend(a.len() + b.len())?;
                Value::Tuple(Rc::new(a.iter().chain(b.iter()).cloned().collect()))
            }
            ("*", Value::Text(_) | Value::List(_) | Value::Tuple(_), count) => {
                self.repeated(left, count)?
            }
            ("*", count, Value::Text(_) | Value::List(_) | Value::Tuple(_)) => {
                self.repeated(right, count)?
            }
            ("%", Value::Text(format), values) => {
                self.weigh(values)?;
                functions::percent(format, values)?
            }
            ("|" | "&" | "^", Value::Dict(_), Value::Dict(_)) => {
                return Err(format!("`{operator}` of dictionaries is not supported"));
            }
            _ => {
                if let (Some(a), Some(b)) = (left.as_set(), right.as_set())
                    && let Some(combined) = a.combined(operator, &b)
                {
                    self.names.spend(a.values().len() + b.values().len())?;
                    self.weigh(left)?;
                    self.weigh(right)?;
                    return combined.map(|set| Value::Set(Rc::new(set)));
                }
                return Err(format!("`{operator}` of {} and {}", left.kind(), right.kind()));
            }
        };
        if functions::length(&result) > MAX_LENGTH {
            return Err(format!("a value is longer than {MAX_LENGTH}"));
        }
        Ok(result)
    }

    /// Counts the work to print or compare a value.
    fn weigh(&mut self, value: &Value) -> Result<(), String> {
        self.names.spend(value.weight()? / 10)
    }

    /// Counts the work to compare two values, or to look for one in the other.
    fn weigh_comparison(&mut self, left: &Value, right: &Value) -> Result<(), String> {
        self.names.spend((functions::length(left) + functions::length(right)) / 100)?;
        if left.is_collection() && right.is_collection() {
            self.weigh(left)?;
            self.weigh(right)?;
        }
        Ok(())
    }

    /// Counts the work of a function that prints or compares its arguments or its value.
    fn weigh_call(&mut self, function: &Value, arguments: &[Value]) -> Result<(), String> {
        match function {
            Value::Function(name) if functions::is_shallow(name) => return Ok(()),
            Value::Method(method) if !matches!(method.0, Value::Dict(_)) => {
                self.weigh(&method.0)?
            }
            _ => {}
        }
        arguments.iter().try_for_each(|argument| self.weigh(argument))
    }

    /// Returns a set, whose values are compared by their texts.
    fn set(&mut self, values: Vec<Value>) -> Evaluated {
        values.iter().try_for_each(|value| self.weigh(value))?;
        Value::set(values)
    }

    fn repeated(&mut self, value: &Value, count: &Value) -> Evaluated {
        let integer = count.integer().ok_or("`*` of a text or a list needs an integer")?;
        let count = usize::try_from(integer).unwrap_or(0);
        let length = functions::length(value).max(1).saturating_mul(count);
        if length > MAX_LENGTH {
            return Err(format!("a value is longer than {MAX_LENGTH}"));
        }
        self.names.spend(length)?;
        let many =
            |items: &[Value]| items.iter().cycle().take(items.len() * count).cloned().collect();
        Ok(match value {
            Value::Text(text) => Value::text(text.repeat(count)),
            Value::List(items) => Value::list(many(items)),
            Value::Tuple(items) => Value::Tuple(Rc::new(many(items))),
            other => other.clone(),
        })
    }
}

fn unary(operator: &str, value: &Value) -> Evaluated {
    let wrong = || format!("`{operator}` of {}", value.kind());
    Ok(match (operator, value) {
        ("not", _) => Value::Bool(!value.is_true()),
        ("-", Value::Float(x)) => Value::Float(-x),
        ("-", _) => {
            let negated = value.integer().ok_or_else(wrong)?.checked_neg();
            Value::Int(negated.ok_or(TOO_LARGE)?)
        }
        ("+", Value::Float(x)) => Value::Float(*x),
        ("+", _) => Value::Int(value.integer().ok_or_else(wrong)?),
        _ => Value::Int(!value.integer().ok_or_else(wrong)?),
    })
}

const TOO_LARGE: &str = "an integer is too large";
const BY_ZERO: &str = "division by zero";

/// Returns the result of numbers; `None` if one of them is no number.
fn arithmetic(operator: &str, left: &Value, right: &Value) -> Result<Option<Value>, String> {
    if let (Value::Bool(a), Value::Bool(b)) = (left, right) {
        match operator {
            "&" => return Ok(Some(Value::Bool(a & b))),
            "|" => return Ok(Some(Value::Bool(a | b))),
            "^" => return Ok(Some(Value::Bool(a ^ b))),
            _ => {}
        }
    }
    if let (Some(a), Some(b)) = (left.integer(), right.integer()) {
        let exact = match operator {
            "+" => a.checked_add(b),
            "-" => a.checked_sub(b),
            "*" => a.checked_mul(b),
            "//" | "%" if b == 0 => return Err(BY_ZERO.into()),
            "//" => a.checked_div_euclid(b).map(|q| {
                // Euclid's remainder is positive, Python's has the sign of the divisor.
                if b < 0 && a.rem_euclid(b) != 0 { q - 1 } else { q }
            }),
            "%" => a.checked_rem_euclid(b).map(|r| if b < 0 && r != 0 { r + b } else { r }),
            "**" if b >= 0 => u32::try_from(b).ok().and_then(|b| a.checked_pow(b)),
            "&" => Some(a & b),
            "|" => Some(a | b),
            "^" => Some(a ^ b),
            "<<" => u32::try_from(b).ok().filter(|b| *b < 63).and_then(|b| a.checked_mul(1 << b)),
            ">>" if b >= 0 => Some(a >> b.min(63)),
            _ => return float_arithmetic(operator, left, right),
        };
        return exact.map(|value| Some(Value::Int(value))).ok_or_else(|| TOO_LARGE.into());
    }
    float_arithmetic(operator, left, right)
}

fn float_arithmetic(operator: &str, left: &Value, right: &Value) -> Result<Option<Value>, String> {
    let Some(a) = left.number() else { return Ok(None) };
    let Some(b) = right.number() else { return Ok(None) };
    if matches!(operator, "/" | "//" | "%") && b == 0.0 {
        return Err(BY_ZERO.into());
    }
    let result = match operator {
        "+" => a + b,
        "-" => a - b,
        "*" => a * b,
        "/" => a / b,
        "//" => ((a - python_remainder(a, b)) / b).round(),
        "%" => python_remainder(a, b),
        "**" if a == 0.0 && b < 0.0 => return Err(BY_ZERO.into()),
        "**" if a < 0.0 && b.fract() != 0.0 => return Err("a root of a negative number".into()),
        "**" => {
            let power = libm::pow(a, b);
            if power.is_infinite() && a.is_finite() && b.is_finite() {
                return Err("a power is too large".into());
            }
            power
        }
        _ => return Ok(None),
    };
    Ok(Some(Value::Float(result)))
}

/// Returns the remainder with the sign of the divisor.
fn python_remainder(a: f64, b: f64) -> f64 {
    let remainder = a % b;
    if remainder == 0.0 {
        return remainder.copysign(b);
    }
    if (remainder < 0.0) != (b < 0.0) { remainder + b } else { remainder }
}

fn compare(operator: &str, left: &Value, right: &Value) -> Result<bool, String> {
    if let (Some(a), Some(b)) = (left.as_set(), right.as_set())
        && let Some(holds) = a.compared(operator, &b)
    {
        return Ok(holds);
    }
    Ok(match operator {
        "==" => left.equals(right),
        "!=" => !left.equals(right),
        "is" => is(left, right)?,
        "is not" => !is(left, right)?,
        "in" => contains(left, right)?,
        "not in" => !contains(left, right)?,
        _ => {
            let is_text = |value: &Value| matches!(value, Value::Text(_));
            let comparable = is_text(left) == is_text(right);
            let order = left.compare(right);
            if order.is_none()
                && (!comparable || left.number().is_none() || right.number().is_none())
            {
                return Err(format!("`{operator}` of {} and {}", left.kind(), right.kind()));
            }
            order.is_some_and(|order| match operator {
                "<" => order.is_lt(),
                "<=" => order.is_le(),
                ">" => order.is_gt(),
                _ => order.is_ge(),
            })
        }
    })
}

/// Returns whether two values are one object of Python; an error if that follows from its memory.
fn is(left: &Value, right: &Value) -> Result<bool, String> {
    match (left, right) {
        (Value::None, Value::None) => Ok(true),
        (Value::Bool(a), Value::Bool(b)) => Ok(a == b),
        // Python has one object for each of these integers.
        (Value::Int(a), Value::Int(b)) if a != b || (-5..=256).contains(a) => Ok(a == b),
        _ if left.kind() != right.kind() => Ok(false),
        (Value::Float(_), Value::Float(_)) => Err(IS_OF_OBJECTS.into()),
        _ if left.equals(right) => Err(IS_OF_OBJECTS.into()),
        _ => Ok(false),
    }
}

const IS_OF_OBJECTS: &str =
    "`is` of equal values depends on Python's memory: write `==`, or `!=` for `is not`";

fn contains(item: &Value, all: &Value) -> Result<bool, String> {
    match (item, all) {
        (Value::Text(part), Value::Text(whole)) => Ok(whole.contains(&**part)),
        (_, Value::Text(_)) => Err(format!("`in` of {} and a text", item.kind())),
        (_, Value::Set(set)) => set.contains(item),
        _ => Ok(functions::items(all)?.iter().any(|element| element.equals(item))),
    }
}

/// Returns the item of a list, a text or a dictionary.
fn item(value: &Value, index: &Value) -> Evaluated {
    if let Value::Dict(_) = value {
        let missing = || format!("the dictionary has no key {}", index.repr());
        return value.entry(index).ok_or_else(missing);
    }
    let items = match value {
        Value::List(items) | Value::Tuple(items) => Some(items.clone()),
        Value::Sequence(range) if matches!(range.kind, SequenceKind::Range(_)) => {
            Some(Rc::new(range.items.clone()))
        }
        Value::Text(_) => None,
        other => return Err(format!("{} has no index", other.kind())),
    };
    let index = index.integer().ok_or_else(|| format!("{} is not an index", index.repr()))?;
    let length = functions::length(value);
    let counted = if index < 0 {
        usize::try_from(index.unsigned_abs()).ok().and_then(|back| length.checked_sub(back))
    } else {
        usize::try_from(index).ok().filter(|place| *place < length)
    };
    let place = counted.ok_or_else(|| format!("there is no item {index} of {length}"))?;
    Ok(match (items, value) {
        (Some(items), _) => items[place].clone(),
        (None, Value::Text(text)) => {
            Value::text(text.chars().nth(place).map(String::from).unwrap_or_default())
        }
        _ => Value::None,
    })
}

/// Returns the items from the first bound to the second, with the third as the step.
fn slice(value: &Value, [from, to, step]: [Option<i64>; 3]) -> Evaluated {
    let step = step.unwrap_or(1);
    if step == 0 {
        return Err("the step of a slice is not 0".into());
    }
    let characters: Vec<Value>;
    let items: &[Value] = match value {
        Value::List(items) | Value::Tuple(items) => items,
        Value::Text(text) => {
            characters = text.chars().map(|c| Value::text(String::from(c))).collect();
            &characters
        }
        other => return Err(format!("{} has no items", other.kind())),
    };
    let length = i64::try_from(items.len()).unwrap_or(i64::MAX);
    let (least, most) = if step > 0 { (0, length) } else { (-1, length - 1) };
    let bound = |bound: Option<i64>, default: i64| {
        bound.map_or(default, |at| {
            (if at < 0 { at.saturating_add(length) } else { at }).clamp(least, most)
        })
    };
    let (from, to) = if step > 0 {
        (bound(from, 0), bound(to, length))
    } else {
        (bound(from, length - 1), bound(to, -1))
    };
    let mut selected = Vec::new();
    let mut at = from;
    while if step > 0 { at < to } else { at > to } {
        selected.extend(usize::try_from(at).ok().and_then(|at| items.get(at)).cloned());
        at = at.saturating_add(step);
    }
    Ok(match value {
        Value::Text(_) => {
            let characters = selected.iter().map(Value::display).collect::<Result<Vec<_>, _>>()?;
            Value::text(characters.concat())
        }
        Value::Tuple(_) => Value::Tuple(Rc::new(selected)),
        _ => Value::list(selected),
    })
}
