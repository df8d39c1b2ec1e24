//! Derivatives of the centroidal momentum and of its rate.
//!
//! A degree of freedom displaces the composite of its body and the body's descendants. The momentum
//! of the composite, and the wrench that its accelerations need, move with it. In addition the
//! motion of the ancestors is another one at the displaced points. The momenta of all other bodies
//! stay as they are. So each derivative is one wrench on one composite, about the centre of mass,
//! which moves as well.

use super::composite::{accumulate_composites, accumulate_wrenches};
use super::perturbation::{perturbations_by_coordinates, perturbations_by_rates};
use super::projection::{Composite, displaced};
use crate::Scalar;
use crate::equations::dynamics::newton_euler::{Accelerations, link_wrenches};
use crate::equations::kinematics::{kinematic_path, total_mass};
use crate::equations::{Motion, Workspace};
use crate::mechanism::{Dof, Mechanism};
use crate::spatial::{Field, Momentum, SpatialAxis, Twist, Vector3, Wrench};

/// The results of [`centroidal_momentum_derivatives`], in world axes about the centre of mass.
/// Columns are of the entries of qd; columns of coordinates are in tangent space.
#[derive(Debug)]
pub struct CentroidalOutputs<'a, S> {
    /// The momentum, kg m^2/s and kg m/s.
    pub momentum: &'a mut Momentum<S>,
    /// The time derivative of the momentum, N and N m.
    pub rate: &'a mut Momentum<S>,
    /// The derivatives of the momentum by the coordinates.
    pub dmomentum_dq: &'a mut [Momentum<S>],
    /// The derivatives of the rate by the coordinates.
    pub drate_dq: &'a mut [Momentum<S>],
    /// The derivatives of the rate by the velocities.
    pub drate_dqd: &'a mut [Momentum<S>],
}

/// Computes the momentum of the moving links about their centre of mass, its time derivative, and
/// the derivatives of both.
///
/// The derivatives of the momentum by qd and of its rate by qdd are the
/// [`centroidal_momentum_matrix`](crate::equations::dynamics::centroidal_momentum_matrix).
pub fn centroidal_momentum_derivatives<S: Scalar>(
    model: &Mechanism<S>,
    Motion { q, qd, qdd }: Motion<'_, S>,
    workspace: &mut Workspace<S>,
    outputs: CentroidalOutputs<'_, S>,
) {
    let CentroidalOutputs { momentum, rate, dmomentum_dq, drate_dq, drate_dqd } = outputs;
    workspace.move_to(model, q);
    // Gravity is an upward acceleration of the world. It has no moment about the centre of mass,
    // and a constant force.
    link_wrenches(model, qd, Accelerations::Given(qdd), workspace);
    accumulate_composites(model, qd, workspace);
    accumulate_wrenches(model, |_| None, workspace);
    perturbations_by_coordinates(model, qd, false, workspace);
    let share = total_mass(model).recip();
    let center = see_center(model, share, workspace);

    let at_rest = Field { a: -model.gravity, ..Field::zero() };
    let total = total(model, at_rest.wrench(&model.static_inertia), workspace);
    *rate = Momentum {
        angular: total.moment - center.cross(total.force),
        linear: total.force + model.gravity.scale(total_mass(model)),
    };
    // The centre of mass moves by the linear part of the momentum matrix divided by the mass.
    let with_center = |i, component, workspace: &Workspace<S>, wrench, total: Vector3<S>| {
        let Momentum { angular, linear } = about_center(i, workspace, wrench);
        let moved = workspace.composite[i].column(component).force.scale(share);
        Momentum { angular: angular - workspace.axes[i].mul_vector(moved).cross(total), linear }
    };
    columns(model, drate_dq, |i, d, component| {
        let wrench = Composite::new(i, workspace).required_wrench(&workspace.perturbations[d])
            + displaced(workspace.wrenches[i], component);
        with_center(i, component, workspace, wrench, total.force)
    });
    perturbations_by_rates(model, qd, false, workspace);
    columns(model, drate_dqd, |i, d, _| {
        let composite = Composite::new(i, workspace);
        about_center(i, workspace, composite.required_wrench(&workspace.perturbations[d]))
    });

    for (i, body) in model.bodies.iter().enumerate() {
        let from_parent = twist_from_parent(model, i, workspace);
        workspace.twists[i] = model.add_rates(i, from_parent, qd);
        workspace.wrenches[i] = body.base_inertia.times(&workspace.twists[i]);
    }
    accumulate_wrenches(model, |_| None, workspace);
    let total = self::total(model, Wrench::zero(), workspace);
    *momentum = Momentum { angular: total.moment - center.cross(total.force), linear: total.force };
    columns(model, dmomentum_dq, |i, _, component| {
        let Twist { angular, linear } = twist_from_parent(model, i, workspace);
        // The velocity of the ancestors at the displaced points, as a twist.
        let change = match SpatialAxis::of(component) {
            SpatialAxis::Linear(k) => {
                Twist { linear: angular.cross(Vector3::unit(k)), angular: Vector3::zero() }
            }
            SpatialAxis::Angular(k) => {
                let s = Vector3::unit(k);
                Twist { linear: linear.cross(s), angular: angular.cross(s) }
            }
        };
        let wrench =
            workspace.composite[i].times(&change) + displaced(workspace.wrenches[i], component);
        with_center(i, component, workspace, wrench, total.force)
    });
}

/// Computes `columns` from the column of each degree of freedom: its body, its number and its
/// component.
fn columns<S: Scalar>(
    model: &Mechanism<S>,
    columns: &mut [Momentum<S>],
    mut entry: impl FnMut(usize, usize, usize) -> Momentum<S>,
) {
    columns.fill(Momentum::zero());
    for (d, dof) in model.dofs.iter().enumerate() {
        let Dof { body, component, v, multiplier, .. } = *dof;
        let along = entry(body, d, component);
        columns[v] = columns[v] + multiplier.map_or(along, |multiplier| along.scale(multiplier));
    }
}

/// Computes the axes of each body in the world, and the centre of mass as each body sees it
/// (`points`). Returns the centre of mass in world axes. Expects composite inertias; `share` is the
/// reciprocal of the mass.
fn see_center<S: Scalar>(
    model: &Mechanism<S>,
    share: S,
    workspace: &mut Workspace<S>,
) -> Vector3<S> {
    let mut first_moment = model.static_inertia.first_moment;
    for (i, body) in model.bodies.iter().enumerate() {
        if body.parent.is_none() {
            let at_joint = workspace.motions[i].rigid_to_parent(&workspace.composite[i]);
            first_moment += body.placement.rigid_to_parent(&at_joint).first_moment;
        }
    }
    let center = first_moment.scale(share);
    for (i, body) in model.bodies.iter().enumerate() {
        kinematic_path::rotate_axes(model, i, workspace);
        let center = body.parent.map_or(center, |parent| workspace.points[parent]);
        let at_joint = body.placement.point_to_child(center);
        workspace.points[i] = workspace.motions[i].point_to_child(at_joint);
    }
    center
}

/// Returns a wrench on body `i` about the centre of mass, in world axes.
fn about_center<S: Scalar>(i: usize, workspace: &Workspace<S>, wrench: Wrench<S>) -> Momentum<S> {
    let axes = &workspace.axes[i];
    let Wrench { moment, force } = wrench;
    Momentum {
        angular: axes.mul_vector(moment - workspace.points[i].cross(force)),
        linear: axes.mul_vector(force),
    }
}

/// Returns the sum of `rest` and the wrenches of the composites on the world, at the world's
/// origin.
fn total<S: Scalar>(model: &Mechanism<S>, rest: Wrench<S>, workspace: &Workspace<S>) -> Wrench<S> {
    let mut sum = rest;
    for (i, body) in model.bodies.iter().enumerate().filter(|(_, body)| body.parent.is_none()) {
        sum += body.wrench_to_parent(&workspace.motions[i], workspace.wrenches[i]);
    }
    sum
}

/// Returns the velocity of the parent frame of body `i`'s joint, in the body's axes at its origin.
fn twist_from_parent<S: Scalar>(
    model: &Mechanism<S>,
    i: usize,
    workspace: &Workspace<S>,
) -> Twist<S> {
    let body = &model.bodies[i];
    let parent = body.parent.map_or_else(Twist::zero, |parent| workspace.twists[parent]);
    body.twist_to_child(&workspace.motions[i], parent)
}
