//! Contacts of merged limbs: a contact with a lane for each limb.

use modyn_runtime::mechanism::{
    BodyFrame, ConstrainedFrames, ConstraintRow, Mechanism, MergedMechanism,
};
use modyn_runtime::spatial::{Pose, Vector3};

use super::{Lanes, LimbPacking, constant, pack};
use crate::graph::Expr;

/// The contacts of the merged robot, each by the robot's contact in each lane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::trace) struct ContactPacking(Vec<Lanes>);

impl LimbPacking {
    /// Returns whether each group of limbs is on one body, and no constraint is a loop: then the
    /// contacts can be merged.
    #[must_use]
    pub fn merges_contacts(&self, model: &Mechanism<f64>) -> bool {
        let on_one_body = |bodies_of_lanes: &Lanes| {
            let mut parents = bodies_of_lanes.iter().flatten().map(|&b| model.bodies[b].parent);
            let first = parents.next();
            parents.all(|parent| Some(parent) == first)
        };
        self.bodies.iter().filter(|merged| merged.first).all(|merged| on_one_body(&merged.of))
            && model.constraints.iter().all(|constraint| constraint.contact)
    }

    /// Returns the contacts of the merged robot. Contacts of one kind on equal bodies are merged,
    /// in their order on each body; a limb may have fewer.
    pub(in crate::trace) fn contacts(&self, model: &Mechanism<f64>) -> ContactPacking {
        let contacts = || model.constraints.iter().enumerate();
        let on = |body: Option<usize>, rows: usize| -> Vec<usize> {
            let carried =
                contacts().filter(|(_, c)| c.ends[1].body == body && c.rows.len() == rows);
            carried.map(|(c, _)| c).collect()
        };
        let mut kinds: Vec<usize> = contacts().map(|(_, contact)| contact.rows.len()).collect();
        kinds.sort_unstable();
        kinds.dedup();
        // Contacts of the world move nothing.
        let bodies = self.bodies.iter().map(|merged| merged.of.clone());
        let merged = kinds.iter().flat_map(|&rows| {
            let of_world = on(None, rows).into_iter().map(|c| vec![Some(c)]);
            let of_bodies = bodies.clone().flat_map(move |body_lanes| {
                let each: Vec<Vec<usize>> = body_lanes
                    .iter()
                    .map(|b| b.map_or_else(Vec::new, |b| on(Some(b), rows)))
                    .collect();
                let most = each.iter().map(Vec::len).max().unwrap_or(0);
                (0..most).map(move |k| each.iter().map(|of_lane| of_lane.get(k).copied()).collect())
            });
            of_world.chain(of_bodies).collect::<Vec<Lanes>>()
        });
        ContactPacking(merged.collect())
    }
}

impl ContactPacking {
    /// Returns the number of merged contacts.
    pub(in crate::trace) fn count(&self) -> usize {
        self.0.len()
    }

    /// Returns `merged`, the robot with merged limbs, with its contacts; `limbs` are the merged
    /// limbs of `model`.
    pub(in crate::trace) fn add_to(
        &self,
        merged: MergedMechanism<Expr>,
        limbs: &LimbPacking,
        model: &Mechanism<f64>,
    ) -> MergedMechanism<Expr> {
        let mut places = vec![(0, 0); model.constraints.len()];
        let frames = self.0.iter().enumerate().map(|(contact, lanes)| {
            for (lane, c) in lanes.iter().enumerate() {
                if let Some(c) = *c {
                    places[c] = (contact, lane);
                }
            }
            packed(lanes, limbs, model)
        });
        let contacts = frames.collect();
        merged.with_contacts(contacts, places)
    }

    /// Returns the numbers of the merged contacts, `count` numbers each, from the numbers of the
    /// robot's contacts. They are zero for a limb without the contact.
    pub(in crate::trace) fn numbers(&self, numbers: &[Expr], count: usize) -> Vec<Expr> {
        let number = |c: &Option<usize>, k| c.map_or(constant(0.0), |c| numbers[c * count + k]);
        let merged = self.0.iter();
        merged
            .flat_map(|lanes| (0..count).map(|k| pack(lanes.iter().map(|c| number(c, k)))))
            .collect()
    }

    /// Returns the numbers of the robot's contacts, `count` numbers each, from the numbers of the
    /// merged contacts.
    pub(in crate::trace) fn unpack(&self, packs: &[Expr], count: usize) -> Vec<Expr> {
        let robots = self.0.iter().flatten().flatten().count();
        let mut numbers = vec![constant(0.0); robots * count];
        for (lanes, packs) in self.0.iter().zip(packs.chunks(count)) {
            for (lane, c) in lanes.iter().enumerate() {
                let Some(c) = *c else { continue };
                for (number, pack) in numbers[c * count..][..count].iter_mut().zip(packs) {
                    *number = pack.extract_lane(lane);
                }
            }
        }
        numbers
    }
}

/// Returns a merged contact from its contact in each lane. A limb without the contact has the place
/// of another limb's.
fn packed(lanes: &Lanes, limbs: &LimbPacking, model: &Mechanism<f64>) -> ConstrainedFrames<Expr> {
    let present = lanes.iter().flatten().next().expect("a contact in some lane");
    let first = &model.constraints[*present];
    let each: Vec<&ConstrainedFrames<f64>> =
        lanes.iter().map(|c| c.map_or(first, |c| &model.constraints[c])).collect();
    let number = |get: &dyn Fn(&ConstrainedFrames<f64>) -> f64| {
        pack(each.iter().map(|contact| constant(get(contact))))
    };
    let on = first.ends[1].body;
    let body = on.and_then(|on| limbs.bodies.iter().position(|b| b.of.contains(&Some(on))));
    let rotation = [0, 1, 2].map(|i| [0, 1, 2].map(|j| number(&|c| c.ends[1].pose.rotation[i][j])));
    let translation = [0, 1, 2].map(|i| number(&|c| c.ends[1].pose.translation[i]));
    let cast = |row: &ConstraintRow<f64>| ConstraintRow {
        angular: row.angular,
        direction: Vector3(row.direction.0.map(constant)),
    };
    ConstrainedFrames {
        ends: [
            BodyFrame { body: None, pose: Pose::identity() },
            BodyFrame { body, pose: Pose { rotation, translation } },
        ],
        contact: true,
        hinge: None,
        rows: first.rows.iter().map(cast).collect(),
        free: first.free.iter().map(cast).collect(),
        length: number(&|contact| contact.length),
    }
}
