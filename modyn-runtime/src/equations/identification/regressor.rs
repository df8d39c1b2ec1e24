//! The regressor: inverse dynamics is linear in the links' inertial parameters.

use crate::Scalar;
use crate::equations::dynamics::newton_euler::{Accelerations, link_wrenches};
use crate::equations::{Motion, Workspace};
use crate::mechanism::{Body, Mechanism};
use crate::model::PARAMETERS_PER_LINK;
use crate::spatial::{Field, Matrix3, Twist, Vector3};

/// Computes the regressor Y(q, qd, qdd), tau = Y pi, by columns: nv rows, 10 columns for each
/// moving link.
///
/// Gravity is included; rotors, damping and friction are not (Atkeson, An and Hollerbach 1986,
/// "Estimation of inertial parameters of manipulator loads and links").
///
/// pi has ten parameters for each moving link of the model, the parameters of
/// [`Model::inertial_parameters`](crate::model::Model::inertial_parameters). An entry of Y is the
/// power of the wrench of a unit parameter under a unit motion of the joint. The unit motion of
/// each joint is therefore transformed towards the links, instead of ten wrenches from each link
/// towards the root.
pub fn regressor<S: Scalar>(
    model: &Mechanism<S>,
    Motion { q, qd, qdd }: Motion<'_, S>,
    workspace: &mut Workspace<S>,
    columns: &mut [S],
) {
    workspace.move_to(model, q);
    link_wrenches(model, qd, Accelerations::Given(qdd), workspace);
    let Workspace { motions, fields, twists, .. } = workspace;
    for &i in &model.links {
        fields[i] = field_in_link(&model.bodies[i], &fields[i]);
    }
    columns.fill(S::zero());
    for i in 0..model.bodies.len() {
        let end = subtree_end(model, i);
        for dof in model.dofs_of(i) {
            let mut unit = [S::zero(); 6];
            unit[dof.component] = dof.scale(S::one());
            twists[i] = Twist::from_components(unit);
            for k in i + 1..end {
                let body = &model.bodies[k];
                let from_parent = body.parent.map_or_else(Twist::zero, |parent| twists[parent]);
                twists[k] = body.twist_to_child(&motions[k], from_parent);
            }
            let links = model.links.iter().enumerate();
            for (link, &k) in links.filter(|(_, k)| (i..end).contains(*k)) {
                let powers = powers(&fields[k], twist_in_link(&model.bodies[k], twists[k]));
                for (parameter, power) in powers.into_iter().enumerate() {
                    let at = (PARAMETERS_PER_LINK * link + parameter) * model.nv + dof.v;
                    columns[at] = columns[at] + power;
                }
            }
        }
    }
}

/// Returns the end of body `i`'s subtree: its descendants follow it contiguously, in depth-first
/// order.
fn subtree_end<S>(model: &Mechanism<S>, i: usize) -> usize {
    let later = model.bodies[i + 1..].iter();
    i + 1 + later.take_while(|body| body.parent.is_some_and(|parent| parent >= i)).count()
}

/// Returns a body's motion at its link's origin, in the link's axes.
fn field_in_link<S: Scalar>(body: &Body<S>, field: &Field<S>) -> Field<S> {
    let to_link = Matrix3(body.link.rotation).transposed();
    let omega = to_link.mul_vector(field.omega);
    let alpha = to_link.mul_vector(field.alpha);
    let a = field.a + field.relative_acceleration(Vector3(body.link.translation));
    Field { a: to_link.mul_vector(a), ..Field::rotating(omega, alpha) }
}

/// Returns a body's twist at its link's origin, in the link's axes.
fn twist_in_link<S: Scalar>(body: &Body<S>, twist: Twist<S>) -> Twist<S> {
    let to_link = Matrix3(body.link.rotation).transposed();
    let linear = twist.linear + twist.angular.cross(Vector3(body.link.translation));
    Twist { angular: to_link.mul_vector(twist.angular), linear: to_link.mul_vector(linear) }
}

/// Returns the power, under `twist`, of the wrench of each inertial parameter at value 1.
///
/// The wrench has the force m a + E c and the moment c x a + I alpha + omega x I omega.
fn powers<S: Scalar>(motion: &Field<S>, twist: Twist<S>) -> [S; PARAMETERS_PER_LINK] {
    let Field { omega, alpha, a, gradient, .. } = *motion;
    let w = twist.angular;
    let v = twist.linear;
    let [cx, cy, cz] = (gradient.transposed().mul_vector(v) + a.cross(w)).0;
    // w . (omega x I omega) = (w x omega) . I omega
    let across = w.cross(omega);
    let entry = |i: usize, j: usize| w[i] * alpha[j] + across[i] * omega[j];
    let both = |i: usize, j: usize| entry(i, j) + entry(j, i);
    let xx = entry(0, 0);
    let xy = both(0, 1);
    let xz = both(0, 2);
    [v.dot(a), cx, cy, cz, xx, xy, xz, entry(1, 1), both(1, 2), entry(2, 2)]
}
