//! The robot with merged limbs: bodies, degrees of freedom and modules, whose numbers have a lane
//! for each limb.

use modyn_runtime::equations::ModulePartition;
use modyn_runtime::equations::factorization::ModuleBlock;
use modyn_runtime::mechanism::{Body, Dof, LimbRoot, Mechanism, MergedMechanism};
use modyn_runtime::spatial::{RigidInertia, Vector3};

use super::{Lanes, LimbPacking, Merged, constant, pack};
use crate::graph::Expr;
use crate::trace::merge::{merged_body, optional};

impl LimbPacking {
    /// Returns the robot with merged limbs.
    pub(in crate::trace) fn merged(
        &self,
        model: &Mechanism<f64>,
        gravity: Vector3<Expr>,
    ) -> MergedMechanism<Expr> {
        let lanes = |numbers: &[f64]| pack(numbers.iter().map(|&x| constant(x)));
        let mut merged = model.cast();
        let new = |old: usize| self.bodies.iter().position(|body| body.of.contains(&Some(old)));
        let mut q = 0;
        let mut dofs = Vec::new();
        let mut roots = Vec::new();
        let mut bodies = Vec::with_capacity(self.bodies.len());
        for Merged { of: merged_bodies, representative, first } in &self.bodies {
            let representative = &model.bodies[*representative];
            let nothing = RigidInertia::zero();
            let missing = Body {
                inertia: nothing,
                base_inertia: nothing,
                spring: None,
                ..representative.clone()
            };
            let each: Vec<&Body<f64>> =
                merged_bodies.iter().map(|b| b.map_or(&missing, |b| &model.bodies[b])).collect();
            let start = dofs.len();
            for k in 0..representative.dofs.len() {
                let representative = &model.dofs[representative.dofs.start + k];
                // A joint with a rotor only, which has no effect on other joints.
                let missing =
                    Dof { armature: Some(1.0), damping: None, friction: None, ..*representative };
                let dof = |b: usize| &model.dofs[model.bodies[b].dofs.start + k];
                let each: Vec<&Dof<f64>> =
                    merged_bodies.iter().map(|b| b.map_or(&missing, dof)).collect();
                dofs.push(Dof {
                    body: bodies.len(),
                    v: dofs.len(),
                    component: representative.component,
                    multiplier: None,
                    armature: optional(&each, |dof| dof.armature, &lanes),
                    damping: optional(&each, |dof| dof.damping, &lanes),
                    friction: optional(&each, |dof| dof.friction, &lanes),
                });
            }
            let mut body = merged_body(&each, start..dofs.len(), q, &lanes);
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

    /// Returns a partition of the robot as a partition of the merged robot. The longest limb's
    /// modules are taken. Modules must not extend from the trunk into limbs.
    #[must_use]
    pub fn partition(&self, partition: &ModulePartition) -> ModulePartition {
        let mut blocks: Vec<ModuleBlock> = partition
            .blocks
            .iter()
            .filter_map(|block| {
                let start =
                    self.bodies.iter().position(|b| b.representative == block.bodies.start)?;
                Some(ModuleBlock { bodies: start..start + block.bodies.len(), ..block.clone() })
            })
            .collect();
        blocks.sort_by_key(|block| block.bodies.start);
        let mut dofs = 0;
        let mut pivots = 0;
        for block in &mut blocks {
            let size = block.dofs.len();
            (block.dofs, block.pivot) = (dofs..dofs + size, pivots);
            dofs += size;
            pivots += size * size;
        }
        ModulePartition { blocks, pivots }
    }
}
