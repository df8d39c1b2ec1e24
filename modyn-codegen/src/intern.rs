//! Texts that are stored until the process ends.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

/// Returns the text, stored until the process ends, each text once. So plans hold names of options
/// as they hold names of the table of functions.
pub(crate) fn intern(text: &str) -> &'static str {
    static TEXTS: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut texts = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = texts.get(text) {
        return known;
    }
    let stored: &'static str = Box::leak(text.into());
    texts.insert(stored);
    stored
}
