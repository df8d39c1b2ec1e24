//! Shapes of merged limbs that touch the ground: a shape with a lane for each limb.

use modyn_runtime::ContactSurface;
use modyn_runtime::equations::soft_constraints::{ContactParameters, SoftModel};
use modyn_runtime::model::ContactShape;
use modyn_runtime::spatial::Pose;

use super::{Lanes, LimbPacking, constant, pack};
use crate::graph::Expr;

/// The shapes of the merged robot that touch the ground.
pub(in crate::trace) struct TouchingPacking<'a> {
    soft: &'a SoftModel<f64>,
    merged: Vec<MergedShape>,
}

/// A shape of the merged robot.
struct MergedShape {
    /// The merged body.
    body: usize,
    /// The robot's shape in each lane.
    lanes: Lanes,
}

/// The properties that the shapes in the lanes of one shape have in common.
#[derive(PartialEq)]
struct Common {
    kind: core::mem::Discriminant<ContactShape<f64>>,
    points: usize,
    components: usize,
    power: u32,
}

impl Common {
    fn of(shape: &ContactParameters<f64>) -> Self {
        Self {
            kind: core::mem::discriminant(&shape.shape),
            points: shape.shape.points(),
            components: shape.components.count(),
            power: shape.power,
        }
    }
}

impl LimbPacking {
    /// Returns whether the curves of impedance of the joints in the lanes of each merged joint have
    /// one power.
    #[must_use]
    pub fn merges_joints(&self, soft: &SoftModel<f64>) -> bool {
        self.velocities().all(|(lanes, _)| {
            let joints = lanes.iter().flatten().filter_map(|&dof| soft.joints[dof].as_ref());
            let mut powers = joints.map(|joint| {
                let stops = &joint.stops;
                [stops.limit, stops.friction].map(|softness| softness.impedance.power)
            });
            let first = powers.next();
            powers.all(|power| Some(power) == first)
        })
    }

    /// Returns the shapes of the merged robot. Shapes of one kind on equal bodies are merged, in
    /// their order on each body; a limb may have fewer.
    pub(in crate::trace) fn touching<'a>(&self, soft: &'a SoftModel<f64>) -> TouchingPacking<'a> {
        let mut kinds: Vec<Common> = Vec::new();
        for shape in soft.contacts.iter().map(Common::of) {
            if !kinds.contains(&shape) {
                kinds.push(shape);
            }
        }
        let on = |body: usize, kind: &Common| -> Vec<usize> {
            let shapes = soft.contacts.iter().enumerate();
            let carried =
                shapes.filter(|(_, shape)| shape.body == body && Common::of(shape) == *kind);
            carried.map(|(shape, _)| shape).collect()
        };
        let mut merged = Vec::new();
        for kind in &kinds {
            for (body, bodies) in self.bodies.iter().enumerate() {
                let lanes = bodies.of.iter();
                let shapes: Vec<Vec<usize>> =
                    lanes.map(|lane| lane.map_or_else(Vec::new, |lane| on(lane, kind))).collect();
                let most = shapes.iter().map(Vec::len).max().unwrap_or(0);
                merged.extend((0..most).map(|k| MergedShape {
                    body,
                    lanes: shapes.iter().map(|lane| lane.get(k).copied()).collect(),
                }));
            }
        }
        TouchingPacking { soft, merged }
    }
}

impl TouchingPacking<'_> {
    /// Returns which lanes each row of the shapes has.
    pub(in crate::trace) fn rows(&self) -> impl Iterator<Item = Vec<bool>> {
        self.merged.iter().flat_map(|merged| {
            let shape = self.first(merged);
            let lanes: Vec<bool> = merged.lanes.iter().map(Option::is_some).collect();
            vec![lanes; shape.shape.points() * shape.components.count()]
        })
    }

    /// Returns the parameters of the merged shapes. A limb without the shape has the one of another.
    pub(in crate::trace) fn parameters(&self) -> Vec<ContactParameters<Expr>> {
        let merged = self.merged.iter();
        merged.map(|merged| self.parameters_of(merged)).collect()
    }

    fn parameters_of(&self, merged: &MergedShape) -> ContactParameters<Expr> {
        let first = self.first(merged);
        let each: Vec<&ContactParameters<f64>> = (merged.lanes.iter())
            .map(|lane| lane.map_or(first, |lane| &self.soft.contacts[lane]))
            .collect();
        let packed = |get: &dyn Fn(&ContactParameters<f64>) -> f64| {
            pack(each.iter().map(|shape| constant(get(shape))))
        };
        let number = |k: usize| packed(&|shape| shape.shape.numbers()[k]);
        let shape = match &first.shape {
            ContactShape::Point => ContactShape::Point,
            ContactShape::Segment(_) => ContactShape::Segment(number(0)),
            ContactShape::Cuboid(_) => ContactShape::Cuboid([0, 1, 2].map(number)),
            ContactShape::Cylinder(_) => ContactShape::Cylinder([0, 1].map(number)),
            ContactShape::Ellipsoid(_) => ContactShape::Ellipsoid([0, 1, 2].map(number)),
            ContactShape::Points(points) => ContactShape::Points(
                (0..points.len()).map(|k| [0, 1, 2].map(|axis| number(3 * k + axis))).collect(),
            ),
        };
        let rotation = [0, 1, 2].map(|i| [0, 1, 2].map(|j| packed(&|x| x.pose.rotation[i][j])));
        let translation = [0, 1, 2].map(|i| packed(&|x| x.pose.translation[i]));
        ContactParameters {
            body: merged.body,
            pose: Pose { rotation, translation },
            shape,
            components: first.components,
            mobility: packed(&|shape| shape.mobility),
            power: first.power,
        }
    }

    /// Returns the numbers of the surfaces of the merged shapes, from the surfaces of the robot. A
    /// limb without the shape has a surface that is out of reach.
    pub(in crate::trace) fn surfaces(&self, numbers: &[Expr]) -> Vec<Expr> {
        const COUNT: usize = ContactSurface::<f64>::COUNT;
        let surface = ContactSurface { margin: -1e10, ..ContactSurface::<f64>::GROUND };
        let out_of_reach = surface.numbers().map(constant);
        let number = |lane: &Option<usize>, k: usize| {
            lane.map_or(out_of_reach[k], |shape| numbers[shape * COUNT + k])
        };
        let merged = self.merged.iter();
        let numbers = merged.flat_map(|merged| {
            (0..COUNT).map(|k| pack(merged.lanes.iter().map(|lane| number(lane, k))))
        });
        numbers.collect()
    }

    /// Returns the numbers of the robot's points, `count` numbers each, from the numbers of the
    /// merged shapes.
    pub(in crate::trace) fn unpack(&self, packs: &[Expr], count: usize) -> Vec<Expr> {
        let mut starts = vec![0];
        for shape in &self.soft.contacts {
            starts.push(starts[starts.len() - 1] + count * shape.shape.points());
        }
        let mut numbers = vec![constant(0.0); starts[starts.len() - 1]];
        let mut rest = packs;
        for merged in &self.merged {
            let (points, others) = rest.split_at(count * self.first(merged).shape.points());
            rest = others;
            for (lane, shape) in merged.lanes.iter().enumerate() {
                let Some(shape) = *shape else { continue };
                for (number, pack) in numbers[starts[shape]..].iter_mut().zip(points) {
                    *number = pack.extract_lane(lane);
                }
            }
        }
        numbers
    }

    /// Returns the shape in the first lane that has one.
    fn first(&self, merged: &MergedShape) -> &ContactParameters<f64> {
        let first = merged.lanes.iter().flatten().next().expect("a shape in some lane");
        &self.soft.contacts[*first]
    }
}
