//! The cycles of a function from indices to indices.

/// Every cycle, in the order of the walk, beginning with its smallest index. Each place is left
/// once, so it takes linear time.
pub fn cycles(next: &[Option<usize>]) -> Vec<Vec<usize>> {
    // By place: the walk that came here first. Every walk goes on until known ground.
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
        // On a cycle if this very walk has been here, and gone on.
        if let Some(begin) = path.iter().position(|&place| place == at) {
            let mut cycle = path.split_off(begin);
            let first = (0..cycle.len()).min_by_key(|&i| cycle[i]).unwrap_or(0);
            cycle.rotate_left(first);
            cycles.push(cycle);
        }
    }
    cycles
}

#[cfg(test)]
mod tests {
    use super::cycles;

    #[test]
    fn each_is_found_once() {
        let next = [Some(3), None, Some(2), Some(5), Some(0), Some(4), Some(3), Some(1)];
        assert_eq!(cycles(&next), [vec![0, 3, 5, 4], vec![2]]);
        assert_eq!(cycles(&[]), Vec::<Vec<usize>>::new());
    }
}
