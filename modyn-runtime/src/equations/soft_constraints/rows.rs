//! The rows of soft constraints at a state: contacts of points with planes, joint limits, dry joint
//! friction.

use alloc::vec::Vec;

use super::law::{self, Cone, ContactLaw, Impedance, Response, RowState, Softness};
use crate::equations::Workspace;
use crate::mechanism::{BodyFrame, BodyTree};
use crate::scalar::{at_least, at_most};
use crate::spatial::{ArticulatedInertia, Matrix3, Pose, Symmetric3, Twist, Vector3, Wrench};
use crate::{ContactSurface, Scalar};

/// The state of a robot, its joint forces, and the time of a step.
#[derive(Clone, Copy, Debug)]
pub struct StepInput<'a, S> {
    /// The coordinates.
    pub q: &'a [S],
    /// The velocities.
    pub qd: &'a [S],
    /// The joint forces, N m or N.
    pub tau: &'a [S],
    /// The accelerations from which the solver starts, such as those of the last step.
    pub warm_start: &'a [S],
    /// The time, s.
    pub dt: S,
}

/// What a robot's soft constraints have beside the settings of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct SoftModel<S> {
    /// The cone of all contacts.
    pub cone: Cone,
    /// The robot's weight on Earth, N: the unit of residuals.
    pub weight: S,
    /// The mobility of the link of each contact, 1/kg: MuJoCo's `body_invweight0`.
    pub mobilities: Vec<S>,
    /// The limits and dry friction of each entry of qd; entries of joints with several degrees of freedom
    /// have none.
    pub joints: Vec<Option<JointParameters<S>>>,
}

/// The parameters of a joint's limits and of its dry friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointParameters<S> {
    /// The entry of q.
    pub coordinate: usize,
    /// The least and the largest coordinate, rad or m; farther from each other than twice the margin.
    pub range: [Option<S>; 2],
    /// The distance from which on a limit acts, rad or m.
    pub margin: S,
    /// The mobility of the joint, 1/(kg m^2) or 1/kg: MuJoCo's `dof_invweight0`.
    pub mobility: S,
    /// The softness of the limits.
    pub limit: Softness<S>,
    /// The dry friction, N m or N; `None` without friction.
    pub dry_friction: Option<S>,
    /// The softness of dry friction.
    pub friction: Softness<S>,
}

/// A contact at a state.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactRows<S> {
    /// The body that carries the contact.
    pub body: usize,
    /// The contact's place on the body.
    place: Vector3<S>,
    /// The normal and two tangents in the body's axes, as columns.
    axes: Matrix3<S>,
    /// The law of the accelerations, those of floating bases relative to free fall.
    pub law: ContactLaw<S>,
}

/// The part of a contact's law that no surface decides.
#[derive(Clone, Copy)]
pub(super) struct Law<S> {
    pub cone: Cone,
    /// How many times stiffer friction is than the normal direction.
    pub ratio: S,
    /// The mobility of the link.
    pub mobility: S,
}

/// The state of a body.
pub(super) struct BodyState<S> {
    /// The index of the body.
    pub body: usize,
    /// The pose in the world.
    pub pose: Pose<S>,
    /// The velocity in the body's axes.
    pub velocity: Twist<S>,
    /// The linear acceleration in free fall, in the body's axes; zero for a body on a fixed base.
    pub fall: Vector3<S>,
}

/// A limit or the dry friction of a joint at a state.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointRow<S> {
    /// The degree of freedom, which is also the entry of qd.
    pub dof: usize,
    /// The sign of the row: 1 for the lower limit and for friction, -1 for the upper limit, whichever
    /// limit is nearer.
    pub sign: S,
    pub weight: S,
    pub reference: S,
    /// The largest force of dry friction; `None` for a limit.
    most: Option<S>,
}

impl<S: Scalar> ContactRows<S> {
    /// Returns the rows of a contact on a body, whose sphere is about the origin of `frame`.
    pub(super) fn new(
        frame: &BodyFrame<S>,
        state: &BodyState<S>,
        law: Law<S>,
        contact: &ContactSurface<S>,
        dt: S,
    ) -> Self {
        let softness = softness(contact);
        let BodyState { body, pose, velocity, fall } = state;
        let to_body = Matrix3(pose.rotation).transposed();
        let plane = Matrix3(contact.plane.rotation);
        let normal = plane.column(2);
        let center = Vector3(frame.pose.translation);
        let in_world = Vector3(pose.translation) + Matrix3(pose.rotation).mul_vector(center);
        let gap = normal.dot(in_world - Vector3(contact.plane.translation)) - contact.radius;
        // The contact is in the middle of the overlap.
        let depth = gap * S::from_f64(0.5) + contact.radius;
        let axes = to_body.times(&Matrix3::from_columns(|k| plane.column((k + 2) % 3)));
        let place = center - axes.column(0).scale(depth);
        let at_place = |twist: &Twist<S>| twist.linear + twist.angular.cross(place);
        let components = |v: Vector3<S>| [0, 1, 2].map(|k| axes.column(k).dot(v));
        let rates = components(at_place(velocity));
        let violation = gap - contact.margin;
        let state = RowState { position: violation, velocity: rates[0], mobility: law.mobility };
        let row = softness.row(&state, dt);
        let falling = components(*fall);
        let reference =
            [row.reference, softness.damped(rates[1], dt), softness.damped(rates[2], dt)];
        let law = ContactLaw {
            cone: law.cone,
            friction: law::friction(contact.friction),
            ratio: law.ratio,
            weight: violation.select_nonnegative(S::zero(), row.weight),
            reference: core::array::from_fn(|k| reference[k] - falling[k]),
        };
        Self { body: *body, place, axes, law }
    }

    /// Returns the acceleration of the contact, given that of its body.
    pub(super) fn acceleration(&self, of_body: &Twist<S>) -> [S; 3] {
        let at_place = of_body.linear + of_body.angular.cross(self.place);
        [0, 1, 2].map(|k| self.axes.column(k).dot(at_place))
    }

    /// Returns the wrench of a force at the body's origin.
    pub(super) fn wrench(&self, force: [S; 3]) -> Wrench<S> {
        let force = self.axes.mul_vector(Vector3(force));
        Wrench { moment: self.place.cross(force), force }
    }

    /// Returns the inertia that a stiffness adds to the body.
    pub(super) fn inertia(&self, response: &Response<S>) -> ArticulatedInertia<S> {
        let stiffness = self.axes.congruence(&Matrix3(response.stiffness)).0;
        let at_place = ArticulatedInertia {
            rotational: Symmetric3::zero(),
            coupling: Matrix3::zero(),
            translational: Symmetric3::from_fn(|i, j| stiffness[i][j]),
        };
        at_place.shifted(self.place)
    }
}

impl<S: Copy> JointParameters<S> {
    /// Returns the parameters with `f` applied to their numbers.
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> JointParameters<T> {
        JointParameters {
            coordinate: self.coordinate,
            range: self.range.map(|end| end.map(f)),
            margin: f(self.margin),
            mobility: f(self.mobility),
            limit: self.limit.map(f),
            dry_friction: self.dry_friction.map(f),
            friction: self.friction.map(f),
        }
    }
}

impl<S: Copy> SoftModel<S> {
    /// Returns the model with `f` applied to its numbers.
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> SoftModel<T> {
        SoftModel {
            cone: self.cone,
            weight: f(self.weight),
            mobilities: self.mobilities.iter().map(|&mobility| f(mobility)).collect(),
            joints: self.joints.iter().map(|joint| joint.map(|joint| joint.map(f))).collect(),
        }
    }
}

/// Returns the softness of a surface.
pub(super) fn softness<S: Scalar>(surface: &ContactSurface<S>) -> Softness<S> {
    let [least, most, width, midpoint] = surface.solimp;
    Softness {
        reference: surface.solref,
        impedance: Impedance { least, most, width, midpoint, power: 2 },
    }
}

/// Returns the rows of joints with one degree of freedom.
pub(super) fn joint_rows<S: Scalar>(
    parameters: &[Option<JointParameters<S>>],
    input: StepInput<'_, S>,
) -> Vec<JointRow<S>> {
    let mut rows = Vec::new();
    for (dof, parameters) in parameters.iter().enumerate() {
        let Some(parameters) = parameters else { continue };
        let JointParameters { range: [low, high], margin, mobility, .. } = *parameters;
        let coordinate = input.q[parameters.coordinate];
        let velocity = input.qd[dof];
        let one = S::one();
        let [below, above] = [low.map(|low| coordinate - low), high.map(|high| high - coordinate)];
        // Only the nearer limit can be violated.
        let nearer = match (below, above) {
            (Some(below), Some(above)) => Some((
                (above - below).select_nonnegative(one, -one),
                (above - below).select_nonnegative(below, above),
            )),
            (Some(below), None) => Some((one, below)),
            (None, Some(above)) => Some((-one, above)),
            (None, None) => None,
        };
        if let Some((sign, distance)) = nearer {
            let position = distance - margin;
            let state = RowState { position, velocity: sign * velocity, mobility };
            let row = parameters.limit.row(&state, input.dt);
            rows.push(JointRow {
                dof,
                sign,
                weight: position.select_nonnegative(S::zero(), row.weight),
                reference: position.select_nonnegative(S::zero(), row.reference),
                most: None,
            });
        }
        if let Some(most) = parameters.dry_friction {
            let state = RowState { position: S::zero(), velocity, mobility };
            let row = parameters.friction.row(&state, input.dt);
            rows.push(JointRow {
                dof,
                sign: S::one(),
                weight: row.weight,
                reference: parameters.friction.damped(velocity, input.dt),
                most: Some(most),
            });
        }
    }
    rows
}

impl<S: Scalar> JointRow<S> {
    /// Returns the row with the weight times `scale`.
    pub(super) fn scaled(&self, scale: S) -> Self {
        Self { weight: self.weight * scale, ..*self }
    }

    /// Returns the force at an acceleration of the row, and minus its derivative.
    pub(super) fn response(&self, acceleration: S) -> [S; 2] {
        let zero = S::zero();
        let force = -(self.weight * (acceleration - self.reference));
        match self.most {
            // A limit only pushes.
            None => {
                [force.select_nonnegative(force, zero), force.select_nonnegative(self.weight, zero)]
            }
            Some(most) => {
                let within = (most - force.abs()).select_nonnegative(self.weight, zero);
                [at_least(at_most(force, most), -most), within]
            }
        }
    }
}

/// Computes the velocities (or accelerations) of all bodies from those of the joints, in the
/// bodies' axes. Expects the joint transforms at q.
pub(super) fn body_twists<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    rates: &[S],
    workspace: &mut Workspace<S>,
) {
    let model = tree.mechanism();
    for (i, body) in model.bodies.iter().enumerate() {
        let parents = tree.broadcast_from_parents(i, |parent| {
            parent.map_or_else(Twist::zero, |parent| workspace.twists[parent]).components()
        });
        let of_parent = match body.parent {
            Some(_) => body.twist_to_child(&workspace.motions[i], Twist::from_components(parents)),
            None => Twist::zero(),
        };
        workspace.twists[i] = model.add_rates(i, of_parent, rates);
    }
}
