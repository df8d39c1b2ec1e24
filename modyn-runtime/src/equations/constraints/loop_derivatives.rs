//! The part of a loop constraint in the derivatives of forward dynamics.
//!
//! All vectors are in the axes of the closest common ancestor of the two frames, and motions are
//! relative to it: a displacement of the ancestor does not change the relative motion. P is the
//! second frame's origin. The first body has the angular velocity W and angular acceleration A, and
//! its material point at P the velocity v_1 and the acceleration b_1; the second body's frame has
//! V, B, v_2 and b_2. The relative motion has in the first frame's axes the components of
//!
//! ```text
//! velocity:     V - W,            y = v_2 - v_1
//! acceleration: B - A - W x V,    b_2 - b_1 - 2 W x y
//! ```
//!
//! A displacement along a joint of the second path moves P by v_k, so v_1 and b_1 change by W x v_k
//! and E v_k, with the field E = A x + W x W x of the first body. A joint of the first path moves
//! the material points away from P, so that the same terms are subtracted from the changes of v_1
//! and b_1; and it rotates the first frame's axes by w_k, which adds -w_k x to the change of each
//! component.
//!
//! The wrench (m, f) of the constraint acts on the second body at P, and its opposite on the first
//! body. It is constant in the first frame's axes, so it rotates with the joints of the first path.

use super::derivative_terms::{
    DerivativeWorkspace, PlacedConstraint, Stabilization, add_force, add_to_rows, clear_rows,
};
use super::path::{Path, PathBody, PathJoint, PathRoot, relative_fields};
use super::relative_motion::{common_ancestor, relative_to_ancestor};
use crate::Scalar;
use crate::equations::{Motion, Workspace};
use crate::mechanism::{ConstraintRow, Mechanism};
use crate::spatial::{Matrix3, Pose, Twist, Vector3, Wrench};

/// Adds a loop constraint's part to F, and sets the constraint's rows of c.
pub(super) fn add_loop<S: Scalar>(
    model: &Mechanism<S>,
    placed: PlacedConstraint<'_, S>,
    rates: Stabilization<S>,
    motion: Motion<'_, S>,
    workspace: &mut Workspace<S>,
    memory: &mut DerivativeWorkspace<S>,
) {
    let DerivativeWorkspace { forces, accelerations, paths, fields, multipliers, .. } = memory;
    let PlacedConstraint { constraint, row } = placed;
    let Motion { q, qd, .. } = motion;
    let ancestor = common_ancestor(model, constraint);
    let seen = constraint.ends.map(|end| relative_to_ancestor(model, end, ancestor, q, |_, _| {}));
    let place = seen[0].axes.mul_vector(seen[1].point - seen[0].point);
    let [first, second] = constraint.ends.map(|end| end.pose);
    let on_first = Vector3(first.translation) + Matrix3(first.rotation).mul_vector(place);
    let points = [on_first, Vector3(second.translation)];
    for ((path, end), point) in paths.iter_mut().zip(constraint.ends).zip(points) {
        relative_fields(model, end, ancestor, motion, workspace, fields);
        let axes = Some(Matrix3(Pose::identity().rotation));
        let root = PathRoot { body: PathBody::at_rest(), axes };
        path.fill(model, root, point, qd, workspace, fields);
    }
    let axes = seen.map(|frame| frame.axes.transposed());
    let relative = Relative { paths: [&paths[0], &paths[1]], axes, hinge: constraint.hinge };

    let components = constraint.along_rows(multipliers[row..].iter().copied());
    let wrench = Wrench {
        moment: axes[0].mul_vector(components.angular).scale(constraint.length),
        force: axes[0].mul_vector(components.linear),
    };
    relative.forces_under(wrench, |change, force, coordinate| {
        add_force(model, change, force, coordinate, &mut forces[0]);
    });

    clear_rows(model, placed, accelerations);
    let in_axes = |row: &ConstraintRow<S>| ConstraintRow {
        direction: axes[0].mul_vector(row.direction),
        ..*row
    };
    for second in [false, true] {
        for joint in &relative.paths[usize::from(second)].joints {
            let (by_coordinate, by_rate) = match second {
                true => relative.by_second(joint),
                false => relative.by_first(joint),
            };
            let [acceleration, velocity, displacement] = by_coordinate;
            let moved = match constraint.holds_rotation() {
                true => relative.displaced(displacement),
                false => displacement,
            };
            let changes = [
                rates.constrained(acceleration, velocity) + moved.scale(rates.beta * rates.beta),
                rates.constrained(by_rate[0], by_rate[1]),
            ];
            add_to_rows(model, placed, joint, changes, in_axes, accelerations);
        }
    }
}

/// The relative motion of the two frames of a loop constraint, in the axes of their closest common
/// ancestor.
struct Relative<'a, S> {
    /// The paths of the two bodies' material points at the second frame's origin.
    paths: [&'a Path<S>; 2],
    /// The axes of both frames, as columns.
    axes: [Matrix3<S>; 2],
    /// The common axis of a hinge in each frame.
    hinge: Option<Vector3<S>>,
}

/// Derivatives by a coordinate (of the acceleration, the velocity and the displacement) and by a
/// rate (of the acceleration and the velocity).
type Changes<S> = ([Twist<S>; 3], [Twist<S>; 2]);

impl<S: Scalar> Relative<'_, S> {
    /// Returns the derivatives of the relative motion by a joint of the second path.
    fn by_second(&self, joint: &PathJoint<S>) -> Changes<S> {
        let [first, second] = self.paths;
        let omega = first.last().omega;
        let twist = joint.twist;
        let [velocity, acceleration] = self.relative_to_first(second, joint);
        (
            [less_transport(acceleration, omega, velocity), velocity, twist],
            [less_transport(second.by_rate(joint), omega, twist), twist],
        )
    }

    /// Returns the derivatives of the relative motion by a joint of the first path.
    fn by_first(&self, joint: &PathJoint<S>) -> Changes<S> {
        let [path, second] = self.paths;
        let first = path.last();
        let second = second.last();
        let twist = joint.twist;
        let relative =
            Twist { angular: second.omega - first.omega, linear: second.velocity - first.velocity };
        let coriolis = first.omega.cross(relative.linear);
        let whole = Twist {
            angular: second.alpha - first.alpha - first.omega.cross(relative.angular),
            linear: second.acceleration - first.acceleration - (coriolis + coriolis),
        };
        // The changes of the first body's motion at the fixed point.
        let [velocity, acceleration] = self.relative_to_first(path, joint);
        let change = |acceleration: Twist<S>, velocity: Twist<S>| {
            let Twist { angular, linear } = less_transport(acceleration, first.omega, velocity);
            let coriolis = velocity.angular.cross(relative.linear);
            Twist {
                angular: -(angular + velocity.angular.cross(relative.angular)),
                linear: -(linear + coriolis + coriolis),
            }
        };
        let rotated = |t: Twist<S>| Twist {
            angular: twist.angular.cross(t.angular),
            linear: twist.angular.cross(t.linear),
        };
        let opposite = |t: Twist<S>| Twist { angular: -t.angular, linear: -t.linear };
        (
            [
                change(acceleration, velocity) + opposite(rotated(whole)),
                opposite(velocity + rotated(relative)),
                opposite(twist),
            ],
            [change(path.by_rate(joint), twist), opposite(twist)],
        )
    }

    /// Returns the derivatives of the velocity and the acceleration of the material point of a path
    /// by a joint's coordinate, less the changes of the first body's motion along the displacement
    /// of that point.
    fn relative_to_first(&self, path: &Path<S>, joint: &PathJoint<S>) -> [Twist<S>; 2] {
        let first = self.paths[0].last();
        let moved = joint.twist.linear;
        let [velocity, acceleration] = path.by_coordinate(joint);
        let field = first.alpha.cross(moved) + first.omega.cross(first.omega.cross(moved));
        [
            Twist { linear: velocity.linear - first.omega.cross(moved), ..velocity },
            Twist { linear: acceleration.linear - field, ..acceleration },
        ]
    }

    /// Returns a displacement of the second frame relative to the first with the rotation replaced
    /// by the change of the rotation error.
    fn displaced(&self, displacement: Twist<S>) -> Twist<S> {
        let [first, second] = &self.axes;
        let change = |a: Vector3<S>, b: Vector3<S>| a.cross(displacement.angular.cross(b));
        let angular = match self.hinge {
            Some(hinge) => change(first.mul_vector(hinge), second.mul_vector(hinge)),
            None => {
                let columns = |k| change(first.column(k), second.column(k));
                (columns(0) + columns(1) + columns(2)).scale(S::from_f64(0.5))
            }
        };
        Twist { angular, ..displacement }
    }

    /// Calls `add` with the change of each joint force of the constraint's wrench for each
    /// coordinate: the change, the degree of freedom of the force, and the degree of freedom of the
    /// coordinate.
    fn forces_under(
        &self,
        wrench: Wrench<S>,
        mut add: impl FnMut(S, &PathJoint<S>, &PathJoint<S>),
    ) {
        let [first, second] = self.paths;
        second.forces_under(wrench, &mut add);
        for a in &first.joints {
            let [rotated, moved] = a.moments_under(wrench);
            for b in &first.joints {
                if a.body <= b.body {
                    // `a` rotates the axis of `b` as it rotates the wrench, but the point stays.
                    add(b.twist.angular.dot(moved), b, a);
                }
                if b.body > a.body {
                    add(b.twist.angular.dot(rotated), a, b);
                }
            }
            for b in &second.joints {
                let [rotated_b, moved_b] = b.moments_under(wrench);
                add(-a.twist.angular.dot(rotated_b), b, a);
                add(-a.twist.angular.dot(moved_b), a, b);
            }
        }
    }
}

/// Returns the change of an acceleration in axes that rotate with `omega`, given the changes in
/// axes that do not.
fn less_transport<S: Scalar>(
    acceleration: Twist<S>,
    omega: Vector3<S>,
    velocity: Twist<S>,
) -> Twist<S> {
    let coriolis = omega.cross(velocity.linear);
    Twist {
        angular: acceleration.angular - omega.cross(velocity.angular),
        linear: acceleration.linear - (coriolis + coriolis),
    }
}
