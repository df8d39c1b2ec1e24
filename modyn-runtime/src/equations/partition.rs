//! The modules that an elimination works by, laid out for it.

use alloc::vec::Vec;
use core::ops::Range;

use crate::model::ModuleTree;

/// A module, with where its block pivot lies in a packed array.
#[derive(Clone, Debug)]
pub struct Block {
    /// Its links.
    pub links: Range<usize>,
    /// Where its pivot block starts: `links.len()` squared numbers, by rows.
    pub pivot: usize,
    /// Whether other modules hang on it.
    pub has_children: bool,
}

/// A partition into modules, parents before children, with room for their pivots.
#[derive(Clone, Debug)]
pub struct Partition {
    /// The modules.
    pub blocks: Vec<Block>,
    /// How many numbers all pivot blocks hold together.
    pub pivots: usize,
}

impl Partition {
    /// No module, for quantities that eliminate nothing.
    #[must_use]
    pub fn empty() -> Self {
        Self { blocks: Vec::new(), pivots: 0 }
    }
}

impl From<&ModuleTree> for Partition {
    fn from(modules: &ModuleTree) -> Self {
        let mut pivots = 0;
        let blocks = modules.modules().iter().map(|module| {
            let pivot = pivots;
            pivots += module.links.len() * module.links.len();
            Block { links: module.links.clone(), pivot, has_children: !module.children.is_empty() }
        });
        Self { blocks: blocks.collect(), pivots }
    }
}
