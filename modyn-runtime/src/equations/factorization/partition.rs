//! The modules that an elimination works by, laid out for it.

use alloc::vec::Vec;
use core::ops::Range;

use crate::Scalar;
use crate::mechanism::Mechanism;
use crate::model::ModuleTree;

/// A module, with where its block pivot lies in a packed array.
#[derive(Clone, Debug)]
pub struct ModuleBlock {
    /// Its bodies.
    pub bodies: Range<usize>,
    /// Their degrees of freedom.
    pub dofs: Range<usize>,
    /// Where its pivot block starts: `dofs.len()` squared numbers, by rows.
    pub pivot: usize,
    /// Whether other modules hang on it.
    pub has_children: bool,
}

/// A partition into modules, parents before children, with room for their pivots.
#[derive(Clone, Debug)]
pub struct ModulePartition {
    /// The modules.
    pub blocks: Vec<ModuleBlock>,
    /// How many numbers all pivot blocks hold together.
    pub pivots: usize,
}

impl ModulePartition {
    /// The modules of a model, which they fit.
    #[must_use]
    pub fn new<S>(model: &Mechanism<S>, modules: &ModuleTree) -> Self {
        let mut pivots = 0;
        let blocks = modules.modules().iter().map(|module| {
            let bodies = bodies(model, &module.links);
            let dofs = model.bodies[bodies.start].dofs.start..model.bodies[bodies.end - 1].dofs.end;
            let pivot = pivots;
            pivots += dofs.len() * dofs.len();
            ModuleBlock { bodies, dofs, pivot, has_children: !module.children.is_empty() }
        });
        Self { blocks: blocks.collect(), pivots }
    }
}

/// The bodies of these links, which are in a row.
fn bodies<S>(model: &Mechanism<S>, links: &Range<usize>) -> Range<usize> {
    let start = links.start.checked_sub(1).map_or(0, |before| model.links[before] + 1);
    start..model.links[links.end - 1] + 1
}

/// V of a split block.
pub(in crate::equations) fn factor<'a, S: Scalar>(
    block: &ModuleBlock,
    pivots: &'a [S],
) -> impl Fn(usize, usize) -> S + Copy + 'a {
    let (start, size) = (block.pivot, block.dofs.len());
    move |row, column| pivots[start + row * size + column]
}
