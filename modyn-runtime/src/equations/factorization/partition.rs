//! The partition of an elimination into modules.

use alloc::vec::Vec;
use core::ops::Range;

use crate::Scalar;
use crate::mechanism::Mechanism;
use crate::model::ModuleTree;

/// A module, and the place of its pivot block in a packed array.
#[derive(Clone, Debug)]
pub struct ModuleBlock {
    /// The module's bodies.
    pub bodies: Range<usize>,
    /// The degrees of freedom of the module's bodies.
    pub dofs: Range<usize>,
    /// The start of the pivot block: `dofs.len()` squared entries, by rows.
    pub pivot: usize,
    /// Whether the module has child modules.
    pub has_children: bool,
}

/// A partition into modules, parents before children, and the size of all pivot blocks.
#[derive(Clone, Debug)]
pub struct ModulePartition {
    /// The modules.
    pub blocks: Vec<ModuleBlock>,
    /// The number of entries of all pivot blocks.
    pub pivots: usize,
}

impl ModulePartition {
    /// Returns the partition of a model by `modules`, which must fit the model.
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

/// Returns the bodies of a range of links.
fn bodies<S>(model: &Mechanism<S>, links: &Range<usize>) -> Range<usize> {
    let start = links.start.checked_sub(1).map_or(0, |before| model.links[before] + 1);
    start..model.links[links.end - 1] + 1
}

/// Returns V of a factorized block, as a function of row and column.
pub(in crate::equations) fn factor<'a, S: Scalar>(
    block: &ModuleBlock,
    pivots: &'a [S],
) -> impl Fn(usize, usize) -> S + Copy + 'a {
    let start = block.pivot;
    let size = block.dofs.len();
    move |row, column| pivots[start + row * size + column]
}
