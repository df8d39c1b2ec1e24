//! What deviations of accelerations are to the joints.

use super::Deviation;
use crate::Scalar;
use crate::equations::Workspace;
use crate::joint::Motion;
use crate::model::prepare::{Body, Dof, Prepared};
use crate::spatial::{Matrix3, RigidInertia, Vector3, VelocityMoments, Wrench};

/// What the deviations are by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum By {
    /// Coordinates: what is behind the joint is displaced with its wrench.
    Coordinates,
    /// Rates: it stays where it is.
    Rates,
}

/// The derivatives of the joint torques by columns, of `workspace.deviations`. Expects composites
/// (by coordinates, with their wrenches) and angular velocities.
pub(super) fn project<S: Scalar>(
    model: &Prepared<S>,
    by: By,
    workspace: &Workspace<S>,
    columns: &mut [S],
) {
    columns.fill(S::zero());
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let composite = Composite::new(i, workspace);
        for (column, deviation) in
            model.dofs_of(i).iter().zip(&workspace.deviations[body.dofs.clone()])
        {
            let mut add = |row: &Dof<S>, column: &Dof<S>, entry: S| {
                let sum = &mut columns[column.v * model.nv + row.v];
                *sum = *sum + row.scale(column.scale(entry));
            };
            let mut wrench = composite.answer(deviation);
            for row in model.dofs_of(i) {
                add(row, column, wrench.components()[row.component]);
            }
            if by == By::Coordinates {
                wrench += displaced(workspace.wrenches[i], column.component);
            }
            let mut weights = composite.weights(column.component);
            let mut at = i;
            while let Some(parent) = model.bodies[at].parent {
                let (body, motion) = (&model.bodies[at], &workspace.motions[at]);
                wrench = body.wrench_to_parent(motion, wrench);
                weights = weights.carried(body, motion, workspace.levers[at]);
                at = parent;
                let dofs = model.bodies[at].dofs.clone();
                for (other, deviation) in
                    model.dofs[dofs.clone()].iter().zip(&workspace.deviations[dofs])
                {
                    add(other, column, wrench.components()[other.component]);
                    add(column, other, weights.of(deviation));
                }
            }
        }
    }
}

/// How a wrench changes, as it is in front of a joint, when it is displaced with its body.
fn displaced<S: Scalar>(wrench: Wrench<S>, component: usize) -> Wrench<S> {
    if let Some(k) = component.checked_sub(3) {
        let moment = Vector3::unit(k).cross(wrench.force);
        return Wrench { moment, force: Vector3::zero() };
    }
    let s = Vector3::unit(component);
    Wrench { moment: s.cross(wrench.moment), force: s.cross(wrench.force) }
}

/// All that hangs together behind a joint, on a body that turns with half of `twice_omega`.
struct Composite<'a, S> {
    inertia: &'a RigidInertia<S>,
    /// Against the body's frame.
    velocities: &'a VelocityMoments<S>,
    twice_omega: Vector3<S>,
    /// What 2 integral x x (g x x') dm is of g, x' against the body's frame.
    rotational: Matrix3<S>,
}

impl<'a, S: Scalar> Composite<'a, S> {
    fn new(i: usize, workspace: &'a Workspace<S>) -> Self {
        let (inertia, velocities) = (&workspace.composite[i], &workspace.velocities[i]);
        let omega = workspace.fields[i].omega;
        let rotational = velocities.rotational();
        Self { inertia, velocities, twice_omega: omega + omega, rotational }
    }

    /// The wrench that gives it a deviation of its accelerations: with x' against the body's frame,
    /// relative x x + turning x 2 x' + 2 omega x (turning x x) + uniform.
    fn answer(&self, deviation: &Deviation<S>) -> Wrench<S> {
        let Deviation { relative, turning, uniform, .. } = *deviation;
        let RigidInertia { mass, first_moment, second_moment } = *self.inertia;
        let turned = second_moment.full().mul_vector(self.twice_omega);
        Wrench {
            moment: self.inertia.rotational().full().mul_vector(relative)
                + self.rotational.mul_vector(turning)
                + turned.cross(turning)
                + first_moment.cross(uniform),
            force: relative.cross(first_moment)
                + turning.cross(self.velocities.first)
                + self.twice_omega.cross(turning.cross(first_moment))
                + uniform.scale(mass),
        }
    }

    /// What a unit displacement in `component` feels of deviations.
    fn weights(&self, component: usize) -> Weights<S> {
        let RigidInertia { first_moment, second_moment, .. } = *self.inertia;
        let turning = if let Some(k) = component.checked_sub(3) {
            let momentum = self.velocities.first + self.twice_omega.cross(first_moment);
            momentum.cross(Vector3::unit(k))
        } else {
            let spun = self.twice_omega.cross(Vector3::unit(component));
            self.rotational.row(component) + second_moment.full().mul_vector(spun)
        };
        Weights { wrench: self.inertia.column(component), turning }
    }
}

/// How much of a deviation's parts a unit displacement feels that is further behind.
#[derive(Clone, Copy, Debug)]
struct Weights<S> {
    /// Of the gradient (moment) and of the uniform part (force): the wrench of the displacement as
    /// an acceleration.
    wrench: Wrench<S>,
    turning: Vector3<S>,
}

impl<S: Scalar> Weights<S> {
    /// The weights at the parent, over whose origin that of `body` moves with half of `lever`.
    fn carried(&self, body: &Body<S>, motion: &Motion<S>, lever: Vector3<S>) -> Self {
        let wrench = body.wrench_to_parent(motion, self.wrench);
        let turning = body.to_parent(motion, self.turning) + lever.cross(wrench.force);
        Self { wrench, turning }
    }

    fn of(&self, deviation: &Deviation<S>) -> S {
        self.turning.dot(deviation.turning)
            + self.wrench.moment.dot(deviation.gradient)
            + self.wrench.force.dot(deviation.uniform)
    }
}
