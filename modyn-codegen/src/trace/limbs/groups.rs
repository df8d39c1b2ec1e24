//! Groups of equal limbs.

use std::ops::Range;

use modyn_runtime::joint::ElementaryJoint;
use modyn_runtime::mechanism::Mechanism;

/// The limits of merging.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimbLimits {
    /// The largest number of limbs that are merged.
    pub packed: usize,
    /// The largest number of limbs on different bodies that are merged.
    pub joined: usize,
    /// The largest number of joints by which a chain may be shorter than a chain that it is merged
    /// with.
    pub missing: usize,
}

/// Returns the first of the longest limbs.
pub(super) fn longest(limbs: &[Range<usize>]) -> &Range<usize> {
    let most = limbs.iter().map(ExactSizeIterator::len).max();
    limbs.iter().find(|limb| Some(limb.len()) == most).expect("some limbs")
}

/// Returns groups of equal limbs, each group on one body.
pub fn groups(model: &Mechanism<f64>, limits: &LimbLimits) -> Vec<Vec<Range<usize>>> {
    let mut groups = Vec::new();
    if !model.has_mimics() {
        find_among(model, &roots(model), limits, &mut groups);
    }
    groups.sort_by_key(|limbs: &Vec<Range<usize>>| limbs[0].start);
    groups
}

/// Merges groups of chains whose joint types agree up to the end of the shorter chain.
pub fn join(
    model: &Mechanism<f64>,
    groups: &[Vec<Range<usize>>],
    limits: &LimbLimits,
) -> Vec<Vec<Range<usize>>> {
    let mut joined: Vec<Vec<Range<usize>>> = Vec::new();
    let fits = |one: &[Range<usize>], other: &[Range<usize>]| {
        let a = chain_joints(model, longest(one));
        let b = chain_joints(model, longest(other));
        let Some(a) = a else { return false };
        let Some(b) = b else { return false };
        one.len() + other.len() <= limits.joined
            && a.len().abs_diff(b.len()) <= limits.missing
            && a.iter().zip(&b).all(|(a, b)| a == b)
    };
    for group in groups {
        match joined.iter_mut().find(|other| fits(other, group)) {
            Some(other) => other.extend_from_slice(group),
            None => joined.push(group.clone()),
        }
    }
    joined
}

/// Returns the joint types of a limb; `None` if it is no chain.
fn chain_joints(model: &Mechanism<f64>, limb: &Range<usize>) -> Option<Vec<ElementaryJoint>> {
    let follows = |i: usize| model.bodies[i].parent == Some(i - 1);
    let is_chain = limb.clone().skip(1).all(follows);
    is_chain.then(|| limb.clone().map(|i| model.bodies[i].elementary_joint).collect())
}

/// Returns the bodies on the world, each with its descendants.
fn roots(model: &Mechanism<f64>) -> Vec<Range<usize>> {
    children(model, None, 0..model.bodies.len())
}

/// Returns the children of `parent` among `range`, each with its descendants.
fn children(
    model: &Mechanism<f64>,
    parent: Option<usize>,
    range: Range<usize>,
) -> Vec<Range<usize>> {
    let starts: Vec<usize> = range.clone().filter(|&i| model.bodies[i].parent == parent).collect();
    let ends = starts.iter().skip(1).copied().chain([range.end]);
    starts.iter().zip(ends).map(|(&start, end)| start..end).collect()
}

/// Groups equal limbs among `limbs`, which have one parent, and continues inside the others.
fn find_among(
    model: &Mechanism<f64>,
    limbs: &[Range<usize>],
    limits: &LimbLimits,
    groups: &mut Vec<Vec<Range<usize>>>,
) {
    let mut rest = limbs.to_vec();
    while !rest.is_empty() {
        let limb = rest.remove(0);
        let shape = shape(model, &limb);
        let (equal, others): (Vec<_>, Vec<_>) = if shape.contains(&(ElementaryJoint::Floating, 0)) {
            (Vec::new(), rest)
        } else {
            rest.into_iter().partition(|other| self::shape(model, other) == shape)
        };
        rest = others;
        if equal.is_empty() {
            let inside = limb.start + 1..limb.end;
            find_among(model, &children(model, Some(limb.start), inside), limits, groups);
            continue;
        }
        let all = [vec![limb], equal].concat();
        // A remaining single limb is not merged.
        groups.extend(all.chunks(limits.packed).filter(|some| some.len() > 1).map(<[_]>::to_vec));
    }
}

/// Returns the joint types of a limb, and for each body the index of its parent in the limb (0 for
/// the first body).
fn shape(model: &Mechanism<f64>, limb: &Range<usize>) -> Vec<(ElementaryJoint, usize)> {
    let shape = |i: usize| {
        let parent = model.bodies[i].parent.and_then(|parent| parent.checked_sub(limb.start));
        (model.bodies[i].elementary_joint, parent.map_or(0, |parent| parent + 1))
    };
    limb.clone().map(shape).collect()
}
