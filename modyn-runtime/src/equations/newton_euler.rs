//! The wrenches that a motion asks of each link by itself, by Newton and Euler.
//!
//! Accelerations are the classical ones of the links' origins, in the links' own axes. The
//! acceleration of a link's point at r is a + E r, with E = alpha x + omega x omega x, so the
//! wrench on a rigid body needs nothing but its mass and moments:
//! F = m a + E c and N = c x a + the axial vector of E S - (E S)^T.
//! Gravity is an acceleration of the world upwards.

use super::Workspace;
use crate::Scalar;
use crate::joint::Motion;
use crate::model::prepare::Prepared;
use crate::spatial::{Matrix3, RigidInertia, Vector3, Wrench};

/// A link's motion, and the acceleration of its points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field<S> {
    omega: Vector3<S>,
    alpha: Vector3<S>,
    /// The acceleration of the origin.
    a: Vector3<S>,
    /// E.
    gradient: Matrix3<S>,
    /// E_zz - E_yy, E_xx - E_zz, E_yy - E_xx.
    differences: Vector3<S>,
}

impl<S: Scalar> Field<S> {
    pub(super) fn zero() -> Self {
        let zero = Vector3::zero();
        Self { omega: zero, alpha: zero, a: zero, gradient: Matrix3::zero(), differences: zero }
    }

    fn new(omega: Vector3<S>, alpha: Vector3<S>) -> Self {
        let [x, y, z] = omega.0;
        let (xx, yy, zz, xy, xz, yz) = (x * x, y * y, z * z, x * y, x * z, y * z);
        Self {
            omega,
            alpha,
            a: Vector3::zero(),
            gradient: Matrix3([
                [-(yy + zz), xy - alpha[2], xz + alpha[1]],
                [xy + alpha[2], -(xx + zz), yz - alpha[0]],
                [xz - alpha[1], yz + alpha[0], -(xx + yy)],
            ]),
            differences: Vector3([zz - yy, xx - zz, yy - xx]),
        }
    }

    /// The wrench that gives a rigid body this motion.
    fn wrench(&self, body: &RigidInertia<S>) -> Wrench<S> {
        let e = &self.gradient.0;
        let d = self.differences;
        let s = &body.second_moment;
        let turning = Vector3([
            e[2][0] * s.xy - e[1][0] * s.xz + e[2][1] * s.yy - e[1][2] * s.zz + s.yz * d[0],
            e[0][1] * s.yz - e[2][1] * s.xy + e[0][2] * s.zz - e[2][0] * s.xx + s.xz * d[1],
            e[1][0] * s.xx - e[0][1] * s.yy + e[1][2] * s.xz - e[0][2] * s.yz + s.xy * d[2],
        ]);
        Wrench {
            moment: turning + body.first_moment.cross(self.a),
            force: self.a.scale(body.mass) + self.gradient.mul_vector(body.first_moment),
        }
    }
}

/// Fills `workspace.wrenches` with each link's own wrench, those of its children left out.
///
/// Without `qdd` all joint accelerations are zero. Expects the joints at q.
pub(super) fn link_wrenches<S: Scalar>(
    model: &Prepared<S>,
    qd: &[S],
    qdd: Option<&[S]>,
    workspace: &mut Workspace<S>,
) {
    for (i, body) in model.bodies.iter().enumerate() {
        let motion = &workspace.motions[i];
        let to_child = |v| body.to_child(motion, v);
        let (omega, alpha, a) = match body.parent {
            None => (Vector3::zero(), Vector3::zero(), to_child(-model.gravity)),
            Some(parent) => {
                let parent = &workspace.fields[parent];
                let at_joint = parent.gradient.mul_vector(body.placement.origin());
                (to_child(parent.omega), to_child(parent.alpha), to_child(parent.a + at_joint))
            }
        };
        let (rate, acceleration) = (qd[i], qdd.map(|qdd| qdd[i]));
        workspace.fields[i] = match motion {
            Motion::Revolute(_) => {
                let mut alpha = alpha + omega.cross_z(rate);
                if let Some(acceleration) = acceleration {
                    alpha[2] = alpha[2] + acceleration;
                }
                Field { a, ..Field::new(omega + Vector3::along_z(rate), alpha) }
            }
            Motion::Prismatic(q) => {
                let field = Field::new(omega, alpha);
                let coriolis = omega.cross_z(rate + rate);
                let mut a = a + field.gradient.column(2).scale(*q) + coriolis;
                if let Some(acceleration) = acceleration {
                    a[2] = a[2] + acceleration;
                }
                Field { a, ..field }
            }
        };
        workspace.wrenches[i] = workspace.fields[i].wrench(&body.minimal);
    }
}
