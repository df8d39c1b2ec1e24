//! Equal limbs in groups.

use std::ops::Range;

use modyn_codegen::ReadOptions;
use modyn_codegen::internals::{groups, join};
use modyn_codegen::trace::LimbLimits;
use modyn_runtime::mechanism::Mechanism;

const LIMITS: LimbLimits = LimbLimits { packed: 8, joined: 4, missing: 2 };

/// Returns a robot on the world from the parent, the axes and the number of copies of each limb. Bodies are numbered in
/// depth-first order, and each joint of a limb carries the next one.
fn robot(limbs: &[(&str, &[&str], usize)]) -> Mechanism<f64> {
    let mut text = String::from("<robot name=\"r\"><link name=\"world\"/>");
    let mut body = |name: &str, parent: &str, axis: &str| {
        text += &format!(
            "<joint name=\"j_{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{name}\"/>\
             <origin xyz=\"0.1 0.2 0.3\" rpy=\"0.4 0.5 0.6\"/><axis xyz=\"{axis}\"/></joint>\
             <link name=\"{name}\"><inertial><mass value=\"1\"/>\
             <inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
        );
    };
    body("trunk", "world", "0 0 1");
    body("torso", "trunk", "0 1 0");
    for (k, (parent, axes, copies)) in limbs.iter().enumerate() {
        for copy in 0..*copies {
            for (i, axis) in axes.iter().enumerate() {
                let before = format!("l{k}_{copy}_{}", i.wrapping_sub(1));
                body(&format!("l{k}_{copy}_{i}"), if i == 0 { parent } else { &before }, axis);
            }
        }
    }
    text += "</robot>";
    let read = modyn_codegen::read(&text, "r", &ReadOptions::default()).expect("a good robot");
    Mechanism::new(&read.model)
}

fn sizes(groups: &[Vec<Range<usize>>]) -> Vec<Vec<usize>> {
    groups.iter().map(|limbs| limbs.iter().map(ExactSizeIterator::len).collect()).collect()
}

#[test]
fn a_group_has_at_most_eight_limbs_and_at_least_two() {
    for (copies, expected) in
        [(1, vec![]), (2, vec![2]), (8, vec![8]), (9, vec![8]), (10, vec![8, 2])]
    {
        let groups = groups(&robot(&[("trunk", &["1 0 0", "0 1 0"], copies)]), &LIMITS);
        let found: Vec<usize> = groups.iter().map(Vec::len).collect();
        assert_eq!(found, expected, "{copies}");
    }
}

#[test]
fn limbs_of_other_trees_are_not_equal() {
    // Of the same joints: one chain of three bodies, and a body that carries two.
    let chain: &[&str] = &["1 0 0", "1 0 0", "1 0 0"];
    let forked = robot(&[("trunk", chain, 1), ("trunk", &["1 0 0"], 1), ("l1_0_0", &["1 0 0"], 2)]);
    assert_eq!(sizes(&groups(&forked, &LIMITS)), [[1, 1]], "the two bodies on the fork alone");
}

#[test]
fn chains_join_within_two_joints_and_four_limbs() {
    let axes: &[&str] = &["1 0 0", "0 1 0", "0 0 1", "1 0 0", "0 1 0", "0 0 1"];
    let joined = |low: (usize, usize), high: (usize, usize)| {
        let model = robot(&[("trunk", &axes[..low.0], low.1), ("torso", &axes[..high.0], high.1)]);
        sizes(&join(&model, &groups(&model, &LIMITS), &LIMITS))
    };
    assert_eq!(joined((3, 2), (3, 2)), [[3, 3, 3, 3]]);
    assert_eq!(joined((3, 2), (5, 2)), [[5, 5, 3, 3]]);
    assert_eq!(joined((5, 2), (3, 2)), [[3, 3, 5, 5]]);
    assert_eq!(joined((3, 2), (6, 2)), [[6, 6], [3, 3]], "three joints are missing");
    assert_eq!(joined((3, 3), (3, 2)), [vec![3, 3], vec![3, 3, 3]], "five limbs");
    assert_eq!(joined((3, 2), (3, 3)), [vec![3, 3, 3], vec![3, 3]], "five limbs");
}
