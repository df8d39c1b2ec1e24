//! Python's dictionaries.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::rc::Rc;

use super::{Value, set};

/// The entries of a dictionary: each key once, in the order in which the keys were added.
#[derive(Default)]
pub struct DictEntries {
    entries: Vec<(Value, Value)>,
    /// The places of the keys, by texts that are the same for equal values.
    places: HashMap<String, usize>,
}

impl DictEntries {
    /// Returns these entries; an error if a value can be no key.
    pub fn of(entries: impl IntoIterator<Item = (Value, Value)>) -> Result<Self, String> {
        let mut all = Self::default();
        entries.into_iter().try_for_each(|(key, value)| all.set(key, value))?;
        Ok(all)
    }

    /// Sets the value of a key; an error if it can be no key.
    pub fn set(&mut self, key: Value, value: Value) -> Result<(), String> {
        if let Some(place) = self.place(&key)? {
            self.entries[place].1 = value;
        } else {
            self.entries.push((key, value));
        }
        Ok(())
    }

    /// Adds the entry unless the key is known; an error if it can be no key.
    pub fn add(&mut self, key: Value, value: Value) -> Result<(), String> {
        if self.place(&key)?.is_none() {
            self.entries.push((key, value));
        }
        Ok(())
    }

    /// Returns the dictionary.
    pub fn dict(self) -> Value {
        Value::Dict(Rc::new(self.entries))
    }

    /// Returns the place of a key; `None` for a new key, which then has the next place.
    fn place(&mut self, key: &Value) -> Result<Option<usize>, String> {
        if matches!(key, Value::Float(x) if x.is_nan()) {
            // It equals no key, not even itself.
            return Ok(None);
        }
        let kind = key.kind();
        let text = set::key(key).map_err(|_| format!("{kind} cannot be a key of a dictionary"))?;
        Ok(match self.places.entry(text) {
            Entry::Occupied(place) => Some(*place.get()),
            Entry::Vacant(place) => {
                place.insert(self.entries.len());
                None
            }
        })
    }
}

/// Returns whether two dictionaries have the same keys with equal values.
pub fn equal(one: &[(Value, Value)], other: &[(Value, Value)]) -> bool {
    let entries = other.iter().filter_map(|(key, value)| Some((set::key(key).ok()?, value)));
    let values: HashMap<String, &Value> = entries.collect();
    let is_in_other = |(key, value): &(Value, Value)| {
        let same = set::key(key).ok().and_then(|key| values.get(&key).copied());
        same.is_some_and(|same| same.equals(value))
    };
    one.len() == other.len() && one.iter().all(is_in_other)
}
