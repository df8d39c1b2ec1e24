//! Python's sets.

use std::collections::HashSet;

use super::Value;

/// A set: values that differ, in the order in which they were added.
#[derive(Clone, Debug, Default)]
pub struct Set {
    values: Vec<Value>,
    /// The keys of the values: equal values have equal keys.
    keys: HashSet<String>,
}

impl Set {
    /// Returns the set of these values; an error if one of them cannot be in a set.
    pub fn of(values: impl IntoIterator<Item = Value>) -> Result<Self, String> {
        let mut set = Self::default();
        for value in values {
            if set.keys.insert(key(&value)?) {
                set.values.push(value);
            }
        }
        Ok(set)
    }

    /// Returns the values, in the order in which they were added.
    pub fn values(&self) -> &[Value] {
        &self.values
    }

    /// Returns whether the set has a value; an error if the value can be in no set.
    pub fn contains(&self, value: &Value) -> Result<bool, String> {
        Ok(self.keys.contains(&key(value)?))
    }

    /// Returns whether each value of this set is in the other set.
    pub fn is_subset(&self, other: &Self) -> bool {
        self.keys.is_subset(&other.keys)
    }

    /// Returns whether the sets have the same values.
    pub fn equals(&self, other: &Self) -> bool {
        self.keys == other.keys
    }

    /// Returns whether the sets have no common value.
    pub fn is_disjoint(&self, other: &Self) -> bool {
        self.keys.is_disjoint(&other.keys)
    }

    /// Returns the result of `|`, `&`, `-` or `^`; `None` for other operators.
    pub fn combined(&self, operator: &str, other: &Self) -> Option<Result<Self, String>> {
        let those_in = |set: &Self, others: &Self, wanted: bool| -> Vec<Value> {
            let is_in = |value: &&Value| key(value).is_ok_and(|key| others.keys.contains(&key));
            set.values.iter().filter(|value| is_in(value) == wanted).cloned().collect()
        };
        let values = match operator {
            "|" => self.values.iter().chain(&other.values).cloned().collect(),
            "&" => those_in(self, other, true),
            "-" => those_in(self, other, false),
            "^" => [those_in(self, other, false), those_in(other, self, false)].concat(),
            _ => return None,
        };
        Some(Self::of(values))
    }

    /// Returns the result of `<`, `<=`, `>` or `>=`; `None` for other operators.
    pub fn compared(&self, operator: &str, other: &Self) -> Option<bool> {
        Some(match operator {
            "<=" => self.is_subset(other),
            "<" => self.is_subset(other) && !self.equals(other),
            ">=" => other.is_subset(self),
            ">" => other.is_subset(self) && !self.equals(other),
            _ => return None,
        })
    }

    /// Returns the values in the order of Python.
    ///
    /// The order of texts changes from run to run of Python: it is the order of addition here. The
    /// integers from 0 to 7 ascend. Other values have an order that follows from Python's memory:
    /// an error.
    pub fn ordered(&self) -> Result<Vec<Value>, String> {
        let mut values = self.values.clone();
        let is_text = |value: &Value| matches!(value, Value::Text(_));
        if values.len() < 2 || values.iter().any(is_text) {
            return Ok(values);
        }
        let is_small = |value: &Value| value.integer().is_some_and(|value| (0..8).contains(&value));
        if values.iter().all(is_small) {
            values.sort_by_key(Value::integer);
            return Ok(values);
        }
        Err("a set has no order: write `python.sorted(...)` of it".into())
    }
}

/// Returns a text that is the same for equal values; an error if the value cannot be in a set.
pub fn key(value: &Value) -> Result<String, String> {
    match value {
        Value::Bool(_) | Value::Int(_) => Ok(value.integer().unwrap_or_default().to_string()),
        #[allow(clippy::cast_possible_truncation)] // The range is checked.
        Value::Float(x) if x.fract() == 0.0 && x.abs() < 1e38 => Ok((*x as i128).to_string()),
        Value::Float(x) if !x.is_nan() => Ok(value.repr()),
        Value::None | Value::Text(_) | Value::Function(_) => Ok(value.repr()),
        Value::Tuple(items) => {
            let keys = items.iter().map(key).collect::<Result<Vec<_>, _>>()?;
            Ok(format!("({})", keys.join(",")))
        }
        other => Err(format!("{} cannot be in a set", other.kind())),
    }
}
