//! The stack and the code of a function with all functions that it calls.

use std::collections::{BTreeMap, BTreeSet};

use crate::disassembly::Function;

/// A function with all functions that it calls.
pub struct Walk {
    /// The deepest stack, bytes.
    pub stack: u64,
    /// Whether the compiler gave the frame's size for every function on the path.
    pub stack_known: bool,
    /// Bytes of code.
    pub flash: u64,
}

/// Follows all calls from `start`; returns an error for recursion and for calls whose target is unknown.
pub fn walk(functions: &BTreeMap<u64, Function>, start: u64) -> Result<Walk, String> {
    let mut seen = BTreeSet::new();
    let (stack, stack_known) = depth(functions, start, &mut Vec::new(), &mut seen)?;
    let flash = seen.iter().map(|address| functions[address].size).sum();
    Ok(Walk { stack, stack_known, flash })
}

fn depth(
    functions: &BTreeMap<u64, Function>,
    address: u64,
    path: &mut Vec<u64>,
    seen: &mut BTreeSet<u64>,
) -> Result<(u64, bool), String> {
    let Some((&start, function)) = functions.range(..=address).next_back() else {
        return Err(format!("a call of {address:#x}, where nothing is"));
    };
    if address >= start + function.size {
        return Err(format!("a call of {address:#x}, where nothing is"));
    }
    if path.contains(&start) {
        return Err(format!("recursion through {}", function.name));
    }
    if function.indirect {
        return Err(format!("{} calls through a register", function.name));
    }
    seen.insert(start);
    path.push(start);
    let (mut deepest, mut known) = (0, function.frame_known);
    for &callee in &function.calls {
        // A loop to the function's own first instruction is not a call.
        if callee == start && function.frame == 0 {
            continue;
        }
        let (stack, callee_known) = depth(functions, callee, path, seen)?;
        deepest = deepest.max(stack);
        known &= callee_known;
    }
    path.pop();
    Ok((function.frame + deepest, known))
}
