//! The robot with merged limbs: bodies, degrees of freedom and modules, whose numbers have a lane for each limb.

use std::ops::Range;

use modyn_runtime::equations::ModulePartition;
use modyn_runtime::equations::factorization::ModuleBlock;
use modyn_runtime::joint::JointOffset;
use modyn_runtime::mechanism::{Body, Dof, LimbRoot, Mechanism, MergedMechanism};
use modyn_runtime::spatial::{AxisRotation, DhTransform, Pose, RigidInertia, Vector3};

use super::{Lanes, LimbPacking, Merged, constant, pack};
use crate::graph::Expr;

impl LimbPacking {
    /// Returns the robot with merged limbs.
    pub(in crate::trace) fn merged(
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
        placement: DhTransform {
            azimuth: rotations(|body| body.placement.azimuth),
            translation: Vector3(
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
