//! Cycles of joints.

use modyn_read::internals::cycles;

#[test]
fn each_is_found_once() {
    let next = [Some(3), None, Some(2), Some(5), Some(0), Some(4), Some(3), Some(1)];
    assert_eq!(cycles(&next), [vec![0, 3, 5, 4], vec![2]]);
    assert_eq!(cycles(&[]), Vec::<Vec<usize>>::new());
}
