//! The parameters of soft constraints, and the rows of contacts of points with planes.

use alloc::{vec, vec::Vec};

use super::law::{self, ContactLaw, Response, RowState, Separation};
use super::lengths::{CouplingParameters, TendonParameters};
use super::shapes;
use super::stops::StopParameters;
use crate::equations::Workspace;
use crate::mechanism::{BodyTree, Mechanism};
use crate::model::{Cone, ContactComponents, ContactShape, Impedance, Integrator, Softness};
use crate::scalar::Tangent;
use crate::spatial::{ArticulatedInertia, Matrix3, Pose, Symmetric3, Twist, Vector3, Wrench};
use crate::{ContactSurface, Scalar};

/// What a robot's soft constraints have beside the settings of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct SoftModel<S> {
    /// The cone of all contacts.
    pub cone: Cone,
    /// How dampers act.
    pub integrator: Integrator,
    /// The robot's weight on Earth, N: the unit of residuals.
    pub weight: S,
    /// The shapes that touch the ground.
    pub contacts: Vec<ContactParameters<S>>,
    /// The damping of each degree of freedom; `None` without damping.
    pub damping: Vec<Option<S>>,
    /// The limits and dry friction of each entry of qd; entries of joints with several degrees of freedom
    /// have none.
    pub joints: Vec<Option<JointParameters<S>>>,
    /// The tendons.
    pub tendons: Vec<TendonParameters<S>>,
    /// The couplings of joints and of tendons.
    pub couplings: Vec<CouplingParameters<S>>,
    /// The loop constraints.
    pub loops: Vec<LoopParameters<S>>,
    /// The entries of qd that each damper of `implicitfast` couples: of a tendon, or of an actuator that
    /// pulls one.
    pub coupled_dampers: Vec<Vec<usize>>,
    /// The bodies whose rotation is implicit.
    pub free_bodies: Vec<usize>,
}

/// The parameters of a loop constraint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopParameters<S> {
    /// The mobilities of displacements, 1/kg, and of rotations, 1/(kg m^2): the sums of MuJoCo's
    /// `body_invweight0` of both links.
    pub mobility: [S; 2],
    /// The softness.
    pub softness: Softness<S>,
    /// The factor of the rows of rotations, m: MuJoCo's `torquescale`.
    pub torque_scale: S,
}

/// The parameters of a shape that touches the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactParameters<S> {
    /// The body that carries the shape.
    pub body: usize,
    /// The pose of the shape's frame in the body's.
    pub pose: Pose<S>,
    /// The shape.
    pub shape: ContactShape<S>,
    /// The components of the contact's force.
    pub components: ContactComponents,
    /// The mobility of the link, 1/kg: MuJoCo's `body_invweight0`.
    pub mobility: S,
    /// The power of the curve of the impedance.
    pub power: u32,
}

/// The parameters of a joint's limits and of its dry friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointParameters<S> {
    /// The entry of q.
    pub coordinate: usize,
    /// The limits and the dry friction.
    pub stops: StopParameters<S>,
}

/// A point of a shape at a state, which can touch the ground.
#[derive(Clone, Debug)]
pub(super) struct ContactRows<S> {
    /// The body that carries the contact.
    pub body: usize,
    /// The contact's place on the body.
    pub place: Vector3<S>,
    /// The height of the shape above the plane at this point.
    pub gap: S,
    /// The normal and two tangents in the body's axes, as columns.
    axes: Matrix3<S>,
    /// The x and y axes of the plane along the first tangent; `None` if the tangents are these axes.
    along_tangent: Option<[S; 2]>,
    /// The law of the accelerations, those of floating bases relative to free fall.
    pub law: ContactLaw<S>,
    /// The damping of the reference accelerations, 1/s.
    pub damping: S,
    /// Minus the change of the normal's reference acceleration with the velocity of each other
    /// component, 1/s.
    closing: Vec<S>,
}

/// The settings of all contacts of a step.
#[derive(Clone, Copy)]
pub(super) struct ContactOptions<S> {
    pub cone: Cone,
    /// How many times stiffer friction is than the normal direction.
    pub ratio: S,
    /// The share of Coulomb's law in sliding.
    pub coulomb: S,
    /// The time of the step, s.
    pub dt: S,
}

/// The state of a body.
pub(super) struct BodyState<S> {
    /// The pose in the world.
    pub pose: Pose<S>,
    /// The velocity in the body's axes.
    pub velocity: Twist<S>,
    /// The linear acceleration in free fall, in the body's axes; zero for a body on a fixed base.
    pub fall: Vector3<S>,
}

impl<S: Scalar> BodyState<S> {
    /// Returns the state with the derivatives by a displacement of the body's origin. The velocity is
    /// constant in the body's axes.
    pub(super) fn displaced(&self, displacement: Twist<S>) -> BodyState<Tangent<S>> {
        let Twist { angular: turn, linear: moved } = displacement;
        let varies = |x: S, dx: S| Tangent { x, dx };
        let vector = |x: Vector3<S>, dx: Vector3<S>| {
            Vector3(core::array::from_fn(|k| varies(x.0[k], dx.0[k])))
        };
        let rotation = Matrix3(self.pose.rotation);
        let turned = rotation.times(&Matrix3::cross(turn)).0;
        let entry = |i: usize, j: usize| varies(self.pose.rotation[i][j], turned[i][j]);
        let translation = Vector3(self.pose.translation);
        BodyState {
            pose: Pose {
                rotation: core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j))),
                translation: vector(translation, rotation.mul_vector(moved)).0,
            },
            velocity: Twist::from_components(self.velocity.components().map(Tangent::constant)),
            fall: vector(self.fall, self.fall.cross(turn)),
        }
    }
}

impl<S: Scalar> ContactRows<S> {
    /// Returns the rows of each point of a shape.
    pub(super) fn of_shape(
        parameters: &ContactParameters<S>,
        state: &BodyState<S>,
        surface: &ContactSurface<S>,
        options: ContactOptions<S>,
    ) -> Vec<Self> {
        let to_body = Matrix3(state.pose.rotation).transposed();
        let plane = Matrix3(surface.plane.rotation);
        let axes = to_body.times(&Matrix3::from_columns(|k| plane.column((k + 2) % 3)));
        let on_body = Matrix3(parameters.pose.rotation);
        let normal = on_body.transposed().mul_vector(axes.column(0));
        let in_shape = shapes::tangent(&parameters.shape);
        let tangent = in_shape.map(|tangent| on_body.mul_vector(tangent));
        let points = shapes::points(&parameters.shape, normal).into_iter();
        let center = Vector3(parameters.pose.translation);
        points
            .map(|point| {
                let point = center + on_body.mul_vector(point);
                Self::new(parameters, state, surface, options, Point { point, axes, tangent })
            })
            .collect()
    }

    fn new(
        parameters: &ContactParameters<S>,
        state: &BodyState<S>,
        surface: &ContactSurface<S>,
        options: ContactOptions<S>,
        Point { point, axes, tangent }: Point<S>,
    ) -> Self {
        let softness = softness(surface, parameters.power);
        let BodyState { pose, velocity, fall } = state;
        let normal = Matrix3(surface.plane.rotation).column(2);
        let in_world = Vector3(pose.translation) + Matrix3(pose.rotation).mul_vector(point);
        let gap = normal.dot(in_world - Vector3(surface.plane.translation)) - surface.radius;
        // The contact is in the middle of the overlap.
        let depth = gap * S::from_f64(0.5) + surface.radius;
        let place = point - axes.column(0).scale(depth);
        let along_tangent = tangent.map(|tangent| along(&axes, tangent));
        let axes = along_tangent.map_or(axes, |[x, y]| {
            let [first, second] = [axes.column(1), axes.column(2)];
            let turned = [
                axes.column(0),
                first.scale(x) + second.scale(y),
                second.scale(x) - first.scale(y),
            ];
            Matrix3::from_columns(|k| turned[k])
        });
        let components = |v: Vector3<S>| [0, 1, 2].map(|k| axes.column(k).dot(v));
        let at_place = velocity.linear + velocity.angular.cross(place);
        let rates = [components(at_place), components(velocity.angular)].concat();
        let violation = gap - surface.margin;
        let mobility = parameters.mobility;
        let row = softness
            .row(&RowState { position: violation, velocity: rates[0], mobility }, options.dt);
        let falling = components(*fall).into_iter().chain([S::zero(); 3]);
        let damped = rates.iter().skip(1).map(|&rate| softness.damped(rate, options.dt));
        let [sliding, torsional, rolling] =
            [surface.friction, surface.torsional_friction, surface.rolling_friction]
                .map(law::friction);
        let count = parameters.components.count();
        let friction = [sliding, sliding, torsional, rolling, rolling][..count - 1].to_vec();
        let damping = -softness.damped(S::one(), options.dt);
        let Separation { speed, by_rate } = law::separation(options.cone, &friction, &rates[1..]);
        let closing = options.coulomb * damping;
        let normal = row.reference - closing * speed;
        let references = [normal].into_iter().chain(damped).zip(falling);
        let law = ContactLaw {
            cone: options.cone,
            friction,
            ratio: options.ratio,
            weight: violation.select_nonnegative(S::zero(), row.weight),
            reference: references.map(|(reference, fall)| reference - fall).take(count).collect(),
        };
        let closing = by_rate.into_iter().map(|by_rate| closing * by_rate).collect();
        Self { body: parameters.body, place, gap, axes, along_tangent, law, damping, closing }
    }

    /// Returns the number of rows.
    pub(super) fn count(&self) -> usize {
        self.law.reference.len()
    }

    /// Returns the accelerations of the rows, given the acceleration of the body.
    pub(super) fn acceleration(&self, of_body: &Twist<S>) -> impl Iterator<Item = S> {
        let at_place = of_body.linear + of_body.angular.cross(self.place);
        let components = |v: Vector3<S>| [0, 1, 2].map(|k| self.axes.column(k).dot(v));
        let turning = match self.count() {
            0..=3 => [S::zero(); 3],
            _ => components(of_body.angular),
        };
        components(at_place).into_iter().chain(turning).take(self.count())
    }

    /// Returns the velocity of the body at the contact's place, along the x and y axes of the plane, then
    /// along the normal.
    pub(super) fn velocity(&self, of_body: &Twist<S>) -> [S; 3] {
        let at_place = of_body.linear + of_body.angular.cross(self.place);
        self.in_plane(&[0, 1, 2].map(|k| self.axes.column(k).dot(at_place)))
    }

    /// Returns the wrench of the forces of the rows at the body's origin.
    pub(super) fn wrench(&self, forces: &[S]) -> Wrench<S> {
        let Wrench { moment, force } = self.wrench_at_place(forces);
        let lever = self.place.cross(force);
        Wrench { moment: if self.count() > 3 { lever + moment } else { lever }, force }
    }

    /// Returns the wrench of the forces of the rows at the contact's place.
    pub(super) fn wrench_at_place(&self, forces: &[S]) -> Wrench<S> {
        let moment = match forces.get(3..) {
            Some(moments) if !moments.is_empty() => self.axes.mul_vector(three(moments)),
            _ => Vector3::zero(),
        };
        Wrench { moment, force: self.axes.mul_vector(three(forces)) }
    }

    /// Returns minus the change of the wrench at the contact's place with the velocity of the body
    /// beside its damping: the wrench for each unit of the power of a twist at the second wrench.
    pub(super) fn change_by_slip(&self, response: &Response<S>) -> [Wrench<S>; 2] {
        let normal: Vec<S> = response.stiffness.iter().map(|row| row[0]).collect();
        let closing: Vec<S> = [S::zero()].into_iter().chain(self.closing.iter().copied()).collect();
        [self.wrench_at_place(&normal), self.wrench_at_place(&closing)]
    }

    /// Returns a force or a velocity along the x and y axes of the plane, then along the normal.
    pub(super) fn in_plane(&self, components: &[S]) -> [S; 3] {
        let Vector3([normal, first, second]) = three(components);
        match self.along_tangent {
            None => [first, second, normal],
            Some([x, y]) => [x * first - y * second, y * first + x * second, normal],
        }
    }

    /// Returns the normal of the plane in the body's axes.
    pub(super) fn normal(&self) -> Vector3<S> {
        self.axes.column(0)
    }

    /// Returns the inertia that a stiffness adds to the body.
    pub(super) fn inertia(&self, response: &Response<S>) -> ArticulatedInertia<S> {
        self.inertia_at_place(response).shifted(self.place)
    }

    /// Returns the inertia that a stiffness adds to the body, about the contact's place.
    pub(super) fn inertia_at_place(&self, response: &Response<S>) -> ArticulatedInertia<S> {
        let entry = |i: usize, j: usize| {
            let row = response.stiffness.get(i);
            row.and_then(|row| row.get(j)).copied().unwrap_or_else(S::zero)
        };
        let block = |first: usize, second: usize| {
            let block = [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(first + i, second + j)));
            self.axes.congruence(&Matrix3(block))
        };
        let symmetric = |m: Matrix3<S>| Symmetric3::from_fn(|i, j| m.0[i][j]);
        let turns = self.count() > 3;
        ArticulatedInertia {
            rotational: if turns { symmetric(block(3, 3)) } else { Symmetric3::zero() },
            coupling: if turns { block(3, 0) } else { Matrix3::zero() },
            translational: symmetric(block(0, 0)),
        }
    }
}

/// A point of a shape on its body.
struct Point<S> {
    point: Vector3<S>,
    /// The normal of the plane and its x and y axes, in the body's axes.
    axes: Matrix3<S>,
    /// The direction of the first tangent; `None`: the plane's x axis.
    tangent: Option<Vector3<S>>,
}

/// Returns the direction of `tangent` within the plane, along the plane's axes: the x axis if the
/// tangent is along the normal.
fn along<S: Scalar>(axes: &Matrix3<S>, tangent: Vector3<S>) -> [S; 2] {
    let [x, y] = [1, 2].map(|k| axes.column(k).dot(tangent));
    let square = x * x + y * y;
    let is_along_normal = S::from_f64(1e-30) - square;
    let length = is_along_normal.select_nonnegative(S::one(), square).sqrt();
    [
        is_along_normal.select_nonnegative(S::one(), x / length),
        is_along_normal.select_nonnegative(S::zero(), y / length),
    ]
}

/// Returns up to three numbers as a vector.
fn three<S: Scalar>(numbers: &[S]) -> Vector3<S> {
    Vector3([0, 1, 2].map(|k| numbers.get(k).copied().unwrap_or_else(S::zero)))
}

impl<S: Copy> LoopParameters<S> {
    /// Returns the parameters with `f` applied to their numbers.
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> LoopParameters<T> {
        LoopParameters {
            mobility: self.mobility.map(f),
            softness: self.softness.map(f),
            torque_scale: f(self.torque_scale),
        }
    }
}

impl<S: Copy> JointParameters<S> {
    /// Returns the parameters with `f` applied to their numbers.
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> JointParameters<T> {
        JointParameters { coordinate: self.coordinate, stops: self.stops.map(f) }
    }
}

impl<S: Copy> ContactParameters<S> {
    /// Returns the parameters with `f` applied to their numbers.
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> ContactParameters<T> {
        let Pose { rotation, translation } = self.pose;
        ContactParameters {
            body: self.body,
            pose: Pose {
                rotation: rotation.map(|row| row.map(f)),
                translation: translation.map(f),
            },
            shape: self.shape.map(f),
            components: self.components,
            mobility: f(self.mobility),
            power: self.power,
        }
    }
}

impl<S: Copy> SoftModel<S> {
    /// Returns the model with `f` applied to its numbers.
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> SoftModel<T> {
        SoftModel {
            cone: self.cone,
            integrator: self.integrator,
            coupled_dampers: self.coupled_dampers.clone(),
            free_bodies: self.free_bodies.clone(),
            weight: f(self.weight),
            contacts: self.contacts.iter().map(|contact| contact.map(f)).collect(),
            damping: self.damping.iter().map(|damping| damping.map(f)).collect(),
            loops: self.loops.iter().map(|parameters| parameters.map(f)).collect(),
            tendons: self.tendons.iter().map(|tendon| tendon.map(f)).collect(),
            couplings: self.couplings.iter().map(|coupling| coupling.map(f)).collect(),
            joints: self.joints.iter().map(|joint| joint.map(|joint| joint.map(f))).collect(),
        }
    }
}

impl<S: Scalar> SoftModel<S> {
    /// Returns the mechanism of steps: with the damping of this model, and without Coulomb friction,
    /// which is a constraint.
    #[must_use]
    pub fn mechanism(&self, robot: &Mechanism<S>) -> Mechanism<S> {
        let mut mechanism = robot.clone();
        for (dof, &damping) in mechanism.dofs.iter_mut().zip(&self.damping) {
            dof.friction = None;
            dof.damping = damping;
        }
        mechanism
    }
}

impl<S: Copy> SoftModel<S> {
    /// Returns the constraints of the solvers, of which a step needs one: without limits if there
    /// are any, for steps in which none acts, then with all constraints.
    #[must_use]
    pub fn solvers(&self) -> Vec<Self> {
        let mut unlimited = self.clone();
        let mut has_limits = false;
        for stops in unlimited.stops() {
            has_limits |= stops.range.iter().any(Option::is_some);
            stops.range = [None; 2];
        }
        match has_limits {
            true => vec![unlimited, self.clone()],
            false => vec![unlimited],
        }
    }

    /// Returns the limits and the dry friction of joints and tendons.
    pub fn stops(&mut self) -> impl Iterator<Item = &mut StopParameters<S>> {
        let joints = self.joints.iter_mut().flatten().map(|joint| &mut joint.stops);
        joints.chain(self.tendons.iter_mut().map(|tendon| &mut tendon.stops))
    }

    /// Returns whether loops, tendons or couplings are on several limbs, or can be.
    #[must_use]
    pub fn acts_across_limbs(&self) -> bool {
        let rows = [self.loops.len(), self.tendons.len(), self.couplings.len()];
        rows.iter().any(|count| *count > 0) || !self.coupled_dampers.is_empty()
    }

    /// Returns whether rows or dampers couple limbs, so that the mass matrix is factorized as a whole.
    #[must_use]
    pub fn couples_limbs(&self) -> bool {
        !self.loops.is_empty() || self.coupled_joints().next().is_some()
    }

    /// Returns the entries of qd that each tendon, each coupling and each damper moves, if they are
    /// several.
    pub fn coupled_joints(&self) -> impl Iterator<Item = Vec<usize>> {
        let tendons = self.tendons.iter().filter(|tendon| tendon.stops.softness().next().is_some());
        let tendons = tendons.map(|tendon| core::slice::from_ref(&tendon.length));
        let lengths = tendons.chain(self.couplings.iter().map(|coupling| &coupling.lengths[..]));
        let of_rows = lengths.filter_map(|lengths| {
            let terms = lengths.iter().flat_map(|length| &length.terms);
            let mut joints: Vec<usize> = terms.map(|term| term.dof).collect();
            joints.sort_unstable();
            joints.dedup();
            (joints.len() > 1).then_some(joints)
        });
        of_rows.chain(self.coupled_dampers.iter().cloned())
    }
}

/// Returns the softness of a surface, with the power of its curve.
pub(super) fn softness<S: Scalar>(surface: &ContactSurface<S>, power: u32) -> Softness<S> {
    let [least, most, width, midpoint] = surface.solimp;
    Softness {
        reference: surface.solref,
        impedance: Impedance { least, most, width, midpoint, power },
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
