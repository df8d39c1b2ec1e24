//! The data of a function: its constants, and the stores of its results.

use crate::values::{Definition, Value, Values};

/// Values, each with the offset at which it is stored in the results.
pub(super) type Stores = Vec<(Value, u32)>;

/// Returns the stores of results: first vectors whose lanes are consecutive results, then all
/// others.
pub(super) fn stores(values: &Values, size: usize) -> (Stores, Stores) {
    let mut runs = Vec::new();
    let mut single = Vec::new();
    let mut distance = 0;
    let mut k = 0;
    while k < values.results.len() {
        let result = values.results[k];
        let (stored, count) = match values.definitions[result as usize] {
            Definition::Lane(vector, 0) => {
                let lanes = usize::from(values.lanes[vector as usize]);
                let run = values.results[k..].iter().take(lanes).enumerate();
                let whole = run.clone().count() == lanes
                    && run.clone().all(|(lane, &result)| {
                        values.definitions[result as usize] == Definition::Lane(vector, lane as u8)
                    });
                if whole { (vector, lanes) } else { (result, 1) }
            }
            _ => (result, 1),
        };
        if stored == result { &mut single } else { &mut runs }.push((stored, distance));
        distance += values.results[k..k + count]
            .iter()
            .map(|&result| (usize::from(values.lanes[result as usize]) * size) as u32)
            .sum::<u32>();
        k += count;
    }
    (runs, single)
}

/// Returns the bytes of the constants, and the offset of each. The constants that are used most are
/// first: they have short displacements.
pub(super) fn pool(values: &Values, size: usize) -> (Vec<u8>, Vec<u32>) {
    let mut uses = vec![0_usize; values.pool.len()];
    let reads = values.steps.iter().flat_map(|step| values.reads(step));
    for value in reads.chain(values.results.iter().copied()) {
        if let Definition::Constant(place) = values.definitions[value as usize] {
            uses[place as usize] += 1;
        }
    }
    let mut order: Vec<usize> = (0..uses.len()).filter(|&place| uses[place] > 0).collect();
    order.sort_by_key(|&place| (std::cmp::Reverse(uses[place]), place));
    let mut bytes = Vec::new();
    let mut at = vec![0; uses.len()];
    for place in order {
        let constant = &values.pool[place];
        let length = constant.len() * size;
        bytes.resize(bytes.len().next_multiple_of(length), 0);
        at[place] = bytes.len() as u32;
        for bits in constant {
            bytes.extend_from_slice(&bits.to_le_bytes()[..size]);
        }
    }
    (bytes, at)
}
