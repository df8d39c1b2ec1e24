//! Centroidal momentum: the momentum of the moving links about their centre of mass, in world axes
//! (Orin, Goswami and Lee 2013, "Centroidal dynamics of a humanoid robot").
//!
//! The momentum of rotors is not included. The armature I of a joint adds I qd^2 / 2 to the kinetic
//! energy, but the description has no axis for the rotor. The momentum that the dynamics conserve
//! without external forces is the momentum of the links.
//!
//! Base inertias suffice for the momentum. Together with the static inertia they give the centre of
//! mass.

use crate::Scalar;
use crate::equations::kinematics::acceleration::parent_motion_at_joint;
use crate::equations::kinematics::{center_of_mass, kinematic_path, total_mass};
use crate::equations::{Motion, State, Workspace};
use crate::mechanism::Mechanism;
use crate::spatial::{Field, Momentum, RigidInertia, Twist, Vector3, Wrench};

/// Computes the matrix A of h = A(q) qd into `columns`. Column k is the momentum at unit rate k, in
/// world axes about the centre of mass.
pub fn centroidal_momentum_matrix<S: Scalar>(
    model: &Mechanism<S>,
    q: &[S],
    workspace: &mut Workspace<S>,
    columns: &mut [Momentum<S>],
) {
    workspace.move_to(model, q);
    columns.fill(Momentum::zero());
    let first_moment = accumulate_composites(model, workspace).first_moment;
    let center = first_moment.scale(total_mass(model).recip());
    for (i, body) in model.bodies.iter().enumerate() {
        kinematic_path::rotate_axes(model, i, workspace);
        let axes = kinematic_path::joint_axes(model, i, workspace);
        // The centre of mass, seen from the joint's parent side and from its child side.
        let center = body.parent.map_or(center, |parent| workspace.points[parent]);
        let at_joint = body.placement.point_to_child(center);
        let in_child = workspace.motions[i].point_to_child(at_joint);
        workspace.points[i] = in_child;
        let center = if body.elementary_joint.has_axis() { at_joint } else { in_child };
        for dof in model.dofs_of(i) {
            let Wrench { moment, force } = workspace.composite[i].column(dof.component);
            let along = Momentum {
                angular: axes.mul_vector(moment - center.cross(force)),
                linear: axes.mul_vector(force),
            };
            let column = &mut columns[dof.v];
            *column = *column + dof.multiplier.map_or(along, |multiplier| along.scale(multiplier));
        }
    }
}

/// Computes the centroidal composite inertia I into `columns`: I t is the momentum about the centre
/// of mass, in world axes, of all moving links as one rigid body with the twist t at the centre of
/// mass (Orin, Goswami and Lee 2013, equation 22).
pub fn centroidal_composite_inertia<S: Scalar>(
    model: &Mechanism<S>,
    q: &[S],
    workspace: &mut Workspace<S>,
    columns: &mut [Momentum<S>; 6],
) {
    workspace.move_to(model, q);
    let mass = total_mass(model);
    let total = RigidInertia { mass, ..accumulate_composites(model, workspace) };
    let center = total.first_moment.scale(mass.recip());
    let centroidal = RigidInertia { first_moment: Vector3::zero(), ..total.shifted(-center) };
    for (k, column) in columns.iter_mut().enumerate() {
        let Wrench { moment, force } = centroidal.column(k);
        *column = Momentum { angular: moment, linear: force };
    }
}

/// Computes composite inertias in the frame of each body's degrees of freedom: before the joint if
/// the joint has an axis, after it otherwise. Returns the inertia of all moving links about the
/// world's origin.
fn accumulate_composites<S: Scalar>(
    model: &Mechanism<S>,
    workspace: &mut Workspace<S>,
) -> RigidInertia<S> {
    for (composite, body) in workspace.composite.iter_mut().zip(&model.bodies) {
        *composite = body.base_inertia;
    }
    let mut total = model.static_inertia;
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let at_joint = workspace.motions[i].rigid_to_parent(&workspace.composite[i]);
        if body.elementary_joint.has_axis() {
            workspace.composite[i] = at_joint;
        }
        let at_parent = body.placement.rigid_to_parent(&at_joint);
        match body.parent {
            Some(parent) => workspace.composite[parent] = workspace.composite[parent] + at_parent,
            None => total = total + at_parent,
        }
    }
    total
}

/// Returns the momentum h of the moving links about their centre of mass, in world axes, kg m^2/s
/// and kg m/s.
pub fn centroidal_momentum<S: Scalar>(
    model: &Mechanism<S>,
    State { q, qd }: State<'_, S>,
    workspace: &mut Workspace<S>,
) -> Momentum<S> {
    workspace.move_to(model, q);
    for (i, body) in model.bodies.iter().enumerate() {
        let motion = &workspace.motions[i];
        let parent = body.parent.map_or_else(Twist::zero, |p| workspace.twists[p]);
        let twist = model.add_rates(i, body.twist_to_child(motion, parent), qd);
        workspace.twists[i] = twist;
        workspace.wrenches[i] = body.base_inertia.times(&twist);
    }
    // Momenta transform as wrenches do.
    about_center(model, workspace)
}

/// Returns the time derivative A qdd + A' qd of the momentum of the moving links about their centre
/// of mass, in world axes, N and N m: the wrench of gravity and of all forces from outside.
///
/// The Newton-Euler equations without gravity, from the world to the links. At qdd = 0 it is the
/// bias A' qd.
pub fn centroidal_momentum_rate<S: Scalar>(
    model: &Mechanism<S>,
    Motion { q, qd, qdd }: Motion<'_, S>,
    workspace: &mut Workspace<S>,
) -> Momentum<S> {
    workspace.move_to(model, q);
    for (i, body) in model.bodies.iter().enumerate() {
        let motion = &workspace.motions[i];
        let parent = body.parent.map_or_else(Field::zero, |parent| workspace.fields[parent]);
        let from_parent = parent_motion_at_joint(&parent, body, motion);
        let rates = model.rates(i, qd);
        let changes = model.rates(i, qdd);
        let field = motion.accelerate(from_parent, &rates, Some(&*changes));
        workspace.fields[i] = field;
        workspace.wrenches[i] = field.wrench(&body.base_inertia);
    }
    // The velocity of the centre of mass is along the linear momentum, so its part in the
    // derivative is zero.
    about_center(model, workspace)
}

/// Returns the sum of the bodies' `workspace.wrenches`, or momenta, about the centre of mass in
/// world axes.
fn about_center<S: Scalar>(model: &Mechanism<S>, workspace: &mut Workspace<S>) -> Momentum<S> {
    let mut total = Wrench::zero();
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let at_parent = body.wrench_to_parent(&workspace.motions[i], workspace.wrenches[i]);
        *body.parent.map_or(&mut total, |parent| &mut workspace.wrenches[parent]) += at_parent;
    }
    let center = center_of_mass::at_joints(model, workspace);
    let Wrench { moment, force } = total;
    Momentum { angular: moment - center.cross(force), linear: force }
}
