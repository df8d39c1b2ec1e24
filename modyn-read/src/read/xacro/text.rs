//! Evaluates texts with expressions, `${...}`, and substitutions, `$(...)`.

use std::path::Path;

use super::evaluate::{Names, evaluate};
use super::expand::{Expander, Fault, TOO_LONG};
use super::parse::parse;
use super::value::{ScopeId, SequenceKind, Value};
use super::yaml;
use crate::diagnostics::suggest;

/// A part of a text.
#[derive(Debug, PartialEq)]
enum Part<'t> {
    Plain(&'t str),
    /// The inside of `${...}`.
    Expression(&'t str),
    /// The inside of `$(...)`.
    Substitution(&'t str),
}

/// Returns the parts of a text. A dollar before `${` or `$(` takes their meaning away.
fn parts(text: &str) -> Result<Vec<Part<'_>>, Fault> {
    let mut parts = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find('$') {
        if at > 0 {
            parts.push(Part::Plain(&rest[..at]));
            rest = &rest[at..];
        }
        let after = rest.trim_start_matches('$');
        let dollars = rest.len() - after.len();
        let opens = after.starts_with(['{', '(']);
        if opens && dollars > 1 {
            parts.push(Part::Plain(&rest[1..=dollars]));
            rest = &after[1..];
        } else if opens {
            let close = if after.starts_with('{') { '}' } else { ')' };
            let Some(end) = after.find(close) else {
                let help = format!("close it by `{close}`, or write `$$` for a dollar");
                return Err(Fault::with_help(format!("`{rest}` is not closed"), help));
            };
            let inside = &after[1..end];
            parts.push(if close == '}' {
                Part::Expression(inside)
            } else {
                Part::Substitution(inside)
            });
            rest = &after[end + 1..];
        } else {
            let end = after.find('$').unwrap_or(after.len());
            parts.push(Part::Plain(&rest[..dollars + end]));
            rest = &after[end..];
        }
    }
    if !rest.is_empty() {
        parts.push(Part::Plain(rest));
    }
    Ok(parts)
}

impl Expander<'_, '_> {
    /// Returns the value of a text. One part alone keeps its type; several are a text.
    pub fn text(&mut self, text: &str, scope: ScopeId) -> Result<Value, Fault> {
        self.spend(1 + text.len() / 100)?;
        let mut values = Vec::new();
        for part in parts(text)? {
            values.push(match part {
                Part::Plain(plain) => Value::text(plain),
                Part::Expression(inside) => {
                    // A substitution can be part of an expression.
                    let inside = self.text(inside, scope)?.display()?;
                    self.expression(&inside, scope)?
                }
                Part::Substitution(inside) => {
                    let inside = self.text(inside, scope)?.display()?;
                    self.substitution(&inside, scope)?
                }
            });
        }
        if values.len() == 1 {
            return Ok(values.remove(0));
        }
        let texts = values.iter().map(Value::display).collect::<Result<Vec<_>, _>>()?;
        self.spend(texts.iter().map(|text| text.len()).sum::<usize>() / 100)?;
        Ok(Value::text(texts.concat()))
    }

    fn expression(&mut self, text: &str, scope: ScopeId) -> Result<Value, Fault> {
        let in_words = |reason: String| {
            let shown: String = text.trim().chars().take(80).collect();
            Fault::from(format!("`{shown}`: {reason}"))
        };
        let parsed = parse(text).map_err(in_words)?;
        let mut names = Scoped { expander: self, scope, fault: None };
        let evaluated = evaluate(&parsed, &mut names).and_then(|value| {
            names.spend(value.weight()? / 10)?;
            Ok(value)
        });
        match (evaluated, names.fault) {
            (Ok(Value::Sequence(result)), _) if result.kind == SequenceKind::Iterator => {
                Err(in_words("the result is an iterator: write `list(...)` of it".into()))
            }
            (Ok(value), _) => Ok(value),
            (Err(_), Some(fault)) => Err(fault),
            (Err(reason), None) => Err(in_words(reason)),
        }
    }

    /// Returns the value of `$(...)`.
    fn substitution(&mut self, text: &str, scope: ScopeId) -> Result<Value, Fault> {
        let text = text.trim();
        let (command, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let rest = rest.trim();
        let one = || {
            if rest.is_empty() || rest.contains(char::is_whitespace) {
                return Err(Fault::from(format!("`$({text})`: expected one name")));
            }
            Ok(rest)
        };
        match command {
            "find" => self.package(one()?).map(Value::text),
            "arg" => self.argument_value(one()?),
            "dirname" => {
                let folder = self.beside("");
                let base = self.options.folder.as_deref().unwrap_or(Path::new(""));
                Ok(Value::text(base.join(folder).display().to_string()))
            }
            "eval" => self.expression(rest, scope),
            "optenv" => {
                // Builds do not depend on the environment: the default counts.
                let default =
                    rest.split_once(char::is_whitespace).map_or("", |(_, default)| default);
                self.warn(&format!(
                    "`$({text})` is \"{default}\": variables of the environment are not read, so \
                     that every build is the same"
                ));
                Ok(Value::text(default.trim()))
            }
            "env" | "cwd" | "anon" => Err(Fault::with_help(
                format!("`$({text})` is not read, so that every build is the same"),
                "replace it by `$(arg name)`, and give its value by the option `xacro_args`",
            )),
            _ => Err(Fault::with_help(
                format!("`$({text})` is not known"),
                "there are `find`, `arg`, `eval`, `dirname` and `optenv`",
            )),
        }
    }

    /// Returns the value of an argument of the file.
    fn argument_value(&mut self, name: &str) -> Result<Value, Fault> {
        if let Some(value) = self.arguments.get(name) {
            return Ok(Value::Text(value.clone()));
        }
        let names = self.arguments.keys().map(|name| &**name);
        let meant = suggest(name, names).map(|meant| format!("; did you mean `{meant}`?"));
        Err(Fault::with_help(
            format!("the argument `{name}` has no value{}", meant.unwrap_or_default()),
            format!(
                "give it by the option `xacro_args = [\"{name}\": \"value\"]`, or write \
                 `<xacro:arg name=\"{name}\" default=\"...\"/>`"
            ),
        ))
    }

    /// Calls a function of the namespace `xacro`.
    fn call_function(&mut self, name: &str, arguments: &[Value]) -> Result<Value, Fault> {
        let text = |value: &Value| match value {
            Value::Text(text) => Ok(text.clone()),
            other => Err(Fault::from(format!("`{name}` of {}", other.kind()))),
        };
        let joined = || {
            let words: Vec<String> = arguments.iter().map(Value::message).collect();
            words.join(" ")
        };
        match (name, arguments) {
            ("xacro.load_yaml" | "xacro.load_json", [file]) => self.load_yaml(&text(file)?),
            ("xacro.arg", [name]) => self.argument_value(&text(name)?),
            ("xacro.abs_filename", [file]) => {
                let path = self.beside(&text(file)?);
                let base = self.options.folder.as_deref().unwrap_or(Path::new(""));
                Ok(Value::text(base.join(path).display().to_string()))
            }
            ("xacro.dotify", [value @ Value::Dict(_)]) => Ok(value.clone()),
            ("xacro.tokenize", [value]) => {
                let written = text(value)?;
                let words = written.split([',', ';', ' ']).filter(|word| !word.is_empty());
                Ok(Value::list(words.map(Value::text).collect()))
            }
            ("xacro.message" | "xacro.print_location", _) => Ok(Value::text("")),
            ("xacro.warning" | "xacro.error", _) => {
                let message = joined();
                self.warn(&message);
                Ok(Value::text(""))
            }
            ("xacro.fatal", _) => {
                Err(Fault::with_help(joined(), "the description itself refuses this"))
            }
            _ => Err(format!("`{name}` cannot be called so").into()),
        }
    }

    fn load_yaml(&mut self, file: &str) -> Result<Value, Fault> {
        let path = self.beside(file);
        let content = self.read_text(&path)?;
        self.spend(content.len() / 100)?;
        yaml::read(&content, &*self).map_err(|(line, reason)| {
            let is_too_long = reason == TOO_LONG;
            let reason = format!("{}:{line}: {reason}", path.display());
            if is_too_long {
                return reason.into();
            }
            let help = "the part of YAML that is read: mappings, lists, and scalars in one line";
            Fault::with_help(reason, help)
        })
    }
}

impl yaml::Host for Expander<'_, '_> {
    fn number(&self, expression: &str) -> Result<f64, String> {
        let parsed = parse(expression)?;
        let mut names = Constants { work: 0 };
        let value = evaluate(&parsed, &mut names)?;
        value.number().ok_or_else(|| format!("`{expression}` is not a number"))
    }

    fn spend(&self, work: usize) -> Result<(), String> {
        self.spend(work)
    }
}

/// The names of an expression in a scope.
struct Scoped<'s, 'e, 'r> {
    expander: &'s mut Expander<'e, 'r>,
    scope: ScopeId,
    /// The fault of a property or a function, which has its own words.
    fault: Option<Fault>,
}

impl Scoped<'_, '_, '_> {
    fn kept<T>(&mut self, result: Result<T, Fault>) -> Result<T, String> {
        result.map_err(|fault| {
            self.fault = Some(fault);
            String::new()
        })
    }
}

impl Names for Scoped<'_, '_, '_> {
    fn name(&mut self, name: &str) -> Result<Option<Value>, String> {
        let looked_up = self.expander.lookup(self.scope, name);
        let value = self.kept(looked_up)?;
        let namespace = || self.expander.scopes.namespace(self.scope, name).map(Value::Scope);
        Ok(value.or_else(namespace))
    }

    fn name_in(&mut self, namespace: &Value, name: &str) -> Result<Option<Value>, String> {
        let Value::Scope(scope) = namespace else { return Ok(None) };
        let looked_up = self.expander.lookup(*scope, name);
        let value = self.kept(looked_up)?;
        Ok(value.or_else(|| self.expander.scopes.namespace(*scope, name).map(Value::Scope)))
    }

    fn call(&mut self, function: &str, arguments: &[Value]) -> Result<Value, String> {
        let result = self.expander.call_function(function, arguments);
        self.kept(result)
    }

    fn spend(&mut self, work: usize) -> Result<(), String> {
        self.expander.spend(work)
    }

    fn enter(&mut self) -> Result<(), String> {
        self.expander.enter()
    }

    fn leave(&mut self) {
        self.expander.leave();
    }

    fn similar(&self, name: &str) -> Option<String> {
        suggest(name, self.expander.scopes.property_names(self.scope)).map(Into::into)
    }
}

/// Only the names of Python and `math`, for numbers of YAML.
struct Constants {
    work: usize,
}

impl Names for Constants {
    fn name(&mut self, _: &str) -> Result<Option<Value>, String> {
        Ok(None)
    }

    fn name_in(&mut self, _: &Value, _: &str) -> Result<Option<Value>, String> {
        Ok(None)
    }

    fn call(&mut self, function: &str, _: &[Value]) -> Result<Value, String> {
        Err(format!("`{function}` cannot be called here"))
    }

    fn spend(&mut self, work: usize) -> Result<(), String> {
        self.work += work;
        if self.work > 10_000 { Err("the number takes too long".into()) } else { Ok(()) }
    }

    // The depth of one expression is the depth of its text.
    fn enter(&mut self) -> Result<(), String> {
        Ok(())
    }

    fn leave(&mut self) {}

    fn similar(&self, _: &str) -> Option<String> {
        None
    }
}
