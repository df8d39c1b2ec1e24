//! The cycles of a function from indices to indices.

/// Returns all cycles, in the order of the walk; each starts with its smallest index. Takes linear
/// time: each index is left once.
pub fn cycles(next: &[Option<usize>]) -> Vec<Vec<usize>> {
    // For each index, the walk that reached it first. A walk ends at an index that was reached
    // before.
    let mut walked = vec![usize::MAX; next.len()];
    let mut cycles = Vec::new();
    for start in 0..next.len() {
        let mut at = start;
        let mut path = Vec::new();
        while walked[at] == usize::MAX {
            walked[at] = start;
            let Some(next) = next[at] else { break };
            path.push(at);
            at = next;
        }
        // An index that this walk itself has reached before is on a cycle.
        if let Some(begin) = path.iter().position(|&place| place == at) {
            let mut cycle = path.split_off(begin);
            let first = (0..cycle.len()).min_by_key(|&i| cycle[i]).unwrap_or(0);
            cycle.rotate_left(first);
            cycles.push(cycle);
        }
    }
    cycles
}
