//! Limb packing: equal limbs as one limb of lanes, such as legs on a trunk, arms on a torso, fingers on a palm.
//!
//! Limbs are equal if they have the same joint types in the same tree; their numbers may differ. They are packed into one
//! limb with a lane for each: a body of the merged limb represents one body of each limb, and its numbers have a lane for
//! each. The same equations run on it. The forces of merged limbs on their parent are summed over the lanes
//! ([`MergedMechanism`]); the parent's motion is broadcast to them.
//!
//! Chains on different bodies can be merged, too (legs and arms). Each lane then has its own parent. Shorter chains are
//! extended by joints that move nothing.

mod coupled;

use std::iter;
use std::ops::Range;

use modyn_runtime::equations::ModulePartition;
use modyn_runtime::equations::factorization::ModuleBlock;
use modyn_runtime::joint::{ElementaryJoint, JointOffset};
use modyn_runtime::mechanism::{Body, Dof, LimbRoot, Mechanism, MergedMechanism};
use modyn_runtime::spatial::{AxisRotation, Pose, RigidInertia, Vector3};

use crate::graph::Expr;

/// The limits of merging.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimbLimits {
    /// The largest number of limbs that are merged.
    pub packed: usize,
    /// The largest number of limbs on different bodies that are merged.
    pub joined: usize,
    /// The largest number of joints by which a chain may be shorter than a chain that it is merged with.
    pub missing: usize,
}

/// The limbs of a robot that are merged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LimbPacking {
    /// The bodies of the merged robot.
    bodies: Vec<Merged>,
    /// For each degree of freedom of the merged robot: the entry of the robot's joint vectors in each lane, and the group of
    /// limbs that it belongs to.
    velocities: Vec<(Lanes, Option<usize>)>,
    /// For each degree of freedom of the merged robot: the root body of the tree in each lane.
    roots: Vec<Lanes>,
    /// For each coordinate of the merged robot: the robot's coordinate in each lane.
    coordinates: Vec<Lanes>,
}

/// The index in each lane; `None` after the end of a shorter limb.
type Lanes = Vec<Option<usize>>;

/// A body of the merged robot.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Merged {
    /// The bodies of the robot that it represents.
    of: Lanes,
    /// The body with the structure of all of them.
    representative: usize,
    /// Whether the bodies are the first bodies of limbs.
    first: bool,
}

impl LimbPacking {
    /// Returns the equal limbs on one body; `None` if there are none.
    #[must_use]
    pub fn find(model: &Mechanism<f64>, limits: &LimbLimits) -> Option<Self> {
        let groups = groups(model, limits);
        (!groups.is_empty()).then(|| Self::new(model, &groups))
    }

    /// Returns the equal limbs, also of chains on different bodies; `None` if no such chains are equal.
    #[must_use]
    pub fn joined(model: &Mechanism<f64>, limits: &LimbLimits) -> Option<Self> {
        let equal = groups(model, limits);
        let joined = join(model, &equal, limits);
        (joined.len() < equal.len()).then(|| Self::new(model, &joined))
    }

    /// Returns the candidates, equal limbs on one body first; with `join`, chains on different bodies are merged, too.
    #[must_use]
    pub fn candidates(model: &Mechanism<f64>, limits: &LimbLimits, join: bool) -> Vec<Self> {
        let joined = join.then(|| Self::joined(model, limits)).flatten();
        Self::find(model, limits).into_iter().chain(joined).collect()
    }

    /// Returns whether the parents of limbs are on one path to the root, so that the limbs' quantities can be transformed
    /// together.
    #[must_use]
    pub fn share_root_path(&self, model: &Mechanism<f64>) -> bool {
        let on_one_path = |of: &Lanes| {
            let parents: Vec<usize> =
                of.iter().flatten().filter_map(|&b| model.bodies[b].parent).collect();
            let Some(&last) = parents.iter().max() else { return true };
            let path: Vec<usize> =
                iter::successors(Some(last), |&body| model.bodies[body].parent).collect();
            parents.iter().all(|parent| path.contains(parent))
        };
        self.bodies.iter().filter(|merged| merged.first).all(|merged| on_one_path(&merged.of))
    }

    fn new(model: &Mechanism<f64>, groups: &[Vec<Range<usize>>]) -> Self {
        let mut bodies = Vec::new();
        let (mut velocities, mut coordinates) = (Vec::new(), Vec::new());
        let mut roots = Vec::new();
        let mut root_of: Vec<usize> = Vec::new();
        for (i, body) in model.bodies.iter().enumerate() {
            root_of.push(body.parent.map_or(i, |parent| root_of[parent]));
        }
        let mut add = |merged: Merged, group| {
            let body = &model.bodies[merged.representative];
            let lanes = |number: &dyn Fn(&Body<f64>) -> usize| {
                merged.of.iter().map(|of| of.map(|b| number(&model.bodies[b]))).collect()
            };
            for k in 0..body.dofs.len() {
                velocities.push((lanes(&|body| model.dofs[body.dofs.start + k].v), group));
                roots.push(merged.of.iter().map(|of| of.map(|b| root_of[b])).collect());
            }
            coordinates.extend((0..body.elementary_joint.nq()).map(|k| lanes(&|body| body.q + k)));
            bodies.push(merged);
        };
        for i in 0..model.bodies.len() {
            let Some(g) = groups.iter().position(|g| g.iter().any(|limb| limb.contains(&i))) else {
                add(Merged { of: vec![Some(i)], representative: i, first: false }, None);
                continue;
            };
            // The merged limb takes the place of the last limb, after all parents.
            let limbs = &groups[g];
            if limbs.iter().map(|limb| limb.start).max() != Some(i) {
                continue;
            }
            let longest = longest(limbs);
            for place in 0..longest.len() {
                let of = limbs.iter().map(|limb| limb.clone().nth(place)).collect();
                add(
                    Merged { of, representative: longest.start + place, first: place == 0 },
                    Some(g),
                );
            }
        }
        Self { bodies, velocities, roots, coordinates }
    }

    /// Returns whether no limb moves another: all are attached to the world.
    #[must_use]
    pub fn independent(&self, model: &Mechanism<f64>) -> bool {
        let first = self.bodies.iter().filter(|merged| merged.first);
        first
            .flat_map(|merged| merged.of.iter().flatten())
            .all(|&b| model.bodies[b].parent.is_none())
    }

    /// Returns the robot with merged limbs.
    pub(super) fn merged(
        &self,
        model: &Mechanism<f64>,
        gravity: Vector3<Expr>,
    ) -> MergedMechanism<Expr> {
        let mut merged = model.cast();
        let new = |old: usize| self.bodies.iter().position(|body| body.of.contains(&Some(old)));
        let (mut q, mut dofs, mut roots) = (0, Vec::new(), Vec::new());
        let mut bodies = Vec::with_capacity(self.bodies.len());
        for Merged { of, representative, first } in &self.bodies {
            let representative = &model.bodies[*representative];
            let nothing = RigidInertia::zero();
            let missing =
                Body { inertia: nothing, base_inertia: nothing, ..representative.clone() };
            let each: Vec<&Body<f64>> =
                of.iter().map(|b| b.map_or(&missing, |b| &model.bodies[b])).collect();
            let start = dofs.len();
            for k in 0..representative.dofs.len() {
                let representative = &model.dofs[representative.dofs.start + k];
                // A joint with a rotor only, which has no effect on other joints.
                let missing =
                    Dof { armature: Some(1.0), damping: None, friction: None, ..*representative };
                let dof = |b: usize| &model.dofs[model.bodies[b].dofs.start + k];
                let each: Vec<&Dof<f64>> = of.iter().map(|b| b.map_or(&missing, dof)).collect();
                dofs.push(Dof {
                    body: bodies.len(),
                    v: dofs.len(),
                    component: representative.component,
                    multiplier: None,
                    armature: optional(&each, |dof| dof.armature),
                    damping: optional(&each, |dof| dof.damping),
                    friction: optional(&each, |dof| dof.friction),
                });
            }
            let mut body = packed_body(&each, start..dofs.len(), q);
            q += body.elementary_joint.nq();
            body.parent = representative.parent.and_then(new);
            roots.push(first.then(|| {
                let mut parents: Lanes = each.iter().map(|b| b.parent.and_then(new)).collect();
                if parents.iter().all(|&parent| parent == parents[0]) {
                    parents.clear();
                } else {
                    body.parent = parents.iter().copied().max().flatten();
                }
                LimbRoot { limbs: each.len(), parents }
            }));
            bodies.push(body);
        }
        (merged.bodies, merged.nq, merged.nv, merged.dofs) = (bodies, q, dofs.len(), dofs);
        merged.gravity = gravity;
        MergedMechanism::new(merged, roots)
    }

    /// Returns a partition of the robot as a partition of the merged robot. The longest limb's modules are taken. Modules
    /// must not extend from the trunk into limbs.
    #[must_use]
    pub fn partition(&self, of: &ModulePartition) -> ModulePartition {
        let mut blocks: Vec<ModuleBlock> = of
            .blocks
            .iter()
            .filter_map(|block| {
                let start =
                    self.bodies.iter().position(|b| b.representative == block.bodies.start)?;
                Some(ModuleBlock { bodies: start..start + block.bodies.len(), ..block.clone() })
            })
            .collect();
        blocks.sort_by_key(|block| block.bodies.start);
        let (mut dofs, mut pivots) = (0, 0);
        for block in &mut blocks {
            let size = block.dofs.len();
            (block.dofs, block.pivot) = (dofs..dofs + size, pivots);
            dofs += size;
            pivots += size * size;
        }
        ModulePartition { blocks, pivots }
    }

    /// Returns the coordinates of the merged robot.
    pub(super) fn coordinates(&self, q: &[Expr]) -> Vec<Expr> {
        self.coordinates.iter().map(|of| lanes_of(of, q)).collect()
    }

    /// Returns a joint vector of the merged robot.
    pub(super) fn vector(&self, x: &[Expr]) -> Vec<Expr> {
        self.velocities.iter().map(|(of, _)| lanes_of(of, x)).collect()
    }

    /// Returns the robot's joint vector, from a joint vector of the merged robot.
    pub(super) fn unpack_vector(&self, x: &[Expr], nv: usize) -> Vec<Expr> {
        let mut unpacked = vec![constant(0.0); nv];
        for (&x, (of, _)) in x.iter().zip(&self.velocities) {
            for (lane, i) in of.iter().enumerate() {
                if let Some(i) = *i {
                    unpacked[i] = x.extract_lane(lane);
                }
            }
        }
        unpacked
    }

    /// Returns the robot's matrix by columns, from a matrix of the merged robot. Entries between different limbs are zero.
    pub(super) fn unpack_matrix(&self, columns: &[Expr], nv: usize) -> Vec<Expr> {
        let n = self.velocities.len();
        let mut unpacked = vec![constant(0.0); nv * nv];
        for (c, (column, of)) in self.velocities.iter().enumerate() {
            for (r, (row, other)) in self.velocities.iter().enumerate() {
                if of.is_some() && other.is_some() && of != other {
                    continue;
                }
                for lane in 0..column.len().max(row.len()) {
                    let at = |of: &Lanes| of[lane.min(of.len() - 1)];
                    // Trees with different root bodies do not couple.
                    if at(&self.roots[c]) != at(&self.roots[r]) {
                        continue;
                    }
                    if let (Some(column), Some(row)) = (at(column), at(row)) {
                        unpacked[column * nv + row] = columns[c * n + r].extract_lane(lane);
                    }
                }
            }
        }
        unpacked
    }
}

/// Returns the first of the longest limbs.
fn longest(limbs: &[Range<usize>]) -> &Range<usize> {
    let most = limbs.iter().map(ExactSizeIterator::len).max();
    limbs.iter().find(|limb| Some(limb.len()) == most).expect("some limbs")
}

/// Returns groups of equal limbs, each group on one body.
fn groups(model: &Mechanism<f64>, limits: &LimbLimits) -> Vec<Vec<Range<usize>>> {
    let mut groups = Vec::new();
    if !model.has_mimics() {
        find_among(model, &roots(model), limits, &mut groups);
    }
    groups.sort_by_key(|limbs: &Vec<Range<usize>>| limbs[0].start);
    groups
}

/// Merges groups of chains whose joint types agree up to the end of the shorter chain.
fn join(
    model: &Mechanism<f64>,
    groups: &[Vec<Range<usize>>],
    limits: &LimbLimits,
) -> Vec<Vec<Range<usize>>> {
    let mut joined: Vec<Vec<Range<usize>>> = Vec::new();
    let fits = |one: &[Range<usize>], other: &[Range<usize>]| {
        let (a, b) = (chain_joints(model, longest(one)), chain_joints(model, longest(other)));
        let (Some(a), Some(b)) = (a, b) else { return false };
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

/// Returns the joint types of a limb, and for each body the index of its parent in the limb (0 for the first body).
fn shape(model: &Mechanism<f64>, limb: &Range<usize>) -> Vec<(ElementaryJoint, usize)> {
    let of = |i: usize| {
        let parent = model.bodies[i].parent.and_then(|parent| parent.checked_sub(limb.start));
        (model.bodies[i].elementary_joint, parent.map_or(0, |parent| parent + 1))
    };
    limb.clone().map(of).collect()
}

fn constant(value: f64) -> Expr {
    <Expr as modyn_runtime::Scalar>::from_f64(value)
}

/// Returns the pack of the entries of `x` that belong to these lanes.
fn lanes_of(lanes: &Lanes, x: &[Expr]) -> Expr {
    pack(lanes.iter().map(|i| i.map_or(constant(0.0), |i| x[i])))
}

fn pack(numbers: impl Iterator<Item = Expr>) -> Expr {
    Expr::pack(&numbers.collect::<Vec<_>>())
}

/// Returns packs of constants; `each` lists the constants of an item.
fn numbers<T>(items: &[&T], each: impl Fn(&T, &mut dyn FnMut(f64))) -> impl Iterator<Item = Expr> {
    let lists: Vec<Vec<f64>> = items
        .iter()
        .map(|item| {
            let mut list = Vec::new();
            each(item, &mut |x| list.push(x));
            list
        })
        .collect();
    (0..lists[0].len()).map(move |n| pack(lists.iter().map(|list| constant(list[n]))))
}

/// Returns the pack of a number that some items lack; their lanes are zero.
fn optional(dofs: &[&Dof<f64>], of: impl Fn(&Dof<f64>) -> Option<f64>) -> Option<Expr> {
    let has = dofs.iter().any(|dof| of(dof).is_some());
    has.then(|| pack(dofs.iter().map(|dof| constant(of(dof).unwrap_or(0.0)))))
}

/// Returns bodies as one body of lanes.
fn packed_body(each: &[&Body<f64>], dofs: Range<usize>, q: usize) -> Body<Expr> {
    let first = each[0];
    let rotations = |of: fn(&Body<f64>) -> AxisRotation<f64>| {
        packed_rotation(&each.iter().map(|body| of(body)).collect::<Vec<_>>())
    };
    let mut translations = numbers(each, |b, f| b.placement.translation.0.into_iter().for_each(f));
    let mut inertias = numbers(each, |b, f| _ = b.inertia.map(f));
    let mut base_inertias = numbers(each, |b, f| _ = b.base_inertia.map(f));
    let next = "as many for each body";
    Body {
        parent: None,
        elementary_joint: first.elementary_joint,
        q,
        mimic: None,
        dofs,
        offset: packed_offset(&each.iter().map(|body| body.offset).collect::<Vec<_>>()),
        placement: modyn_runtime::spatial::DhTransform {
            azimuth: rotations(|body| body.placement.azimuth),
            translation: modyn_runtime::spatial::Vector3(
                first.placement.translation.0.map(|_| translations.next().expect(next)),
            ),
            tilt: rotations(|body| body.placement.tilt),
        },
        link: Pose::identity(),
        inertia: first.inertia.map(|_| inertias.next().expect(next)),
        base_inertia: first.base_inertia.map(|_| base_inertias.next().expect(next)),
    }
}

/// Returns rotations as one rotation of lanes; free of operations if all are the same quarter turn.
fn packed_rotation(rotations: &[AxisRotation<f64>]) -> AxisRotation<Expr> {
    if let (AxisRotation::Quarters(n), true) =
        (rotations[0], rotations.iter().all(|rotation| *rotation == rotations[0]))
    {
        return AxisRotation::Quarters(n);
    }
    let direction = |rotation: &AxisRotation<f64>| match *rotation {
        AxisRotation::Angle { cos, sin } => (cos, sin),
        AxisRotation::Quarters(n) => {
            [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][usize::from(n % 4)]
        }
    };
    AxisRotation::Angle {
        cos: pack(rotations.iter().map(|rotation| constant(direction(rotation).0))),
        sin: pack(rotations.iter().map(|rotation| constant(direction(rotation).1))),
    }
}

/// Returns offsets as one offset of lanes.
fn packed_offset(offsets: &[JointOffset<f64>]) -> JointOffset<Expr> {
    if let (JointOffset::Quarters(n), true) =
        (offsets[0], offsets.iter().all(|offset| *offset == offsets[0]))
    {
        return JointOffset::Quarters(n);
    }
    let angle = |offset: &JointOffset<f64>| match *offset {
        JointOffset::Angle(angle) => angle,
        JointOffset::Quarters(n) => f64::from(n) * std::f64::consts::FRAC_PI_2,
    };
    JointOffset::Angle(pack(offsets.iter().map(|offset| constant(angle(offset)))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::ReadOptions;

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
        let read = crate::read(&text, "r", &ReadOptions::default()).expect("a good robot");
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
        let forked =
            robot(&[("trunk", chain, 1), ("trunk", &["1 0 0"], 1), ("l1_0_0", &["1 0 0"], 2)]);
        assert_eq!(sizes(&groups(&forked, &LIMITS)), [[1, 1]], "the two bodies on the fork alone");
    }

    #[test]
    fn chains_join_within_two_joints_and_four_limbs() {
        let axes: &[&str] = &["1 0 0", "0 1 0", "0 0 1", "1 0 0", "0 1 0", "0 0 1"];
        let joined = |low: (usize, usize), high: (usize, usize)| {
            let model =
                robot(&[("trunk", &axes[..low.0], low.1), ("torso", &axes[..high.0], high.1)]);
            sizes(&join(&model, &groups(&model, &LIMITS), &LIMITS))
        };
        assert_eq!(joined((3, 2), (3, 2)), [[3, 3, 3, 3]]);
        assert_eq!(joined((3, 2), (5, 2)), [[5, 5, 3, 3]]);
        assert_eq!(joined((5, 2), (3, 2)), [[3, 3, 5, 5]]);
        assert_eq!(joined((3, 2), (6, 2)), [[6, 6], [3, 3]], "three joints are missing");
        assert_eq!(joined((3, 3), (3, 2)), [vec![3, 3], vec![3, 3, 3]], "five limbs");
        assert_eq!(joined((3, 2), (3, 3)), [vec![3, 3, 3], vec![3, 3]], "five limbs");
    }
}
