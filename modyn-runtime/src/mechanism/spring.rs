//! The joint forces of springs.

use super::{Mechanism, Rates};
use crate::Scalar;
use crate::spatial::{Matrix3, Quaternion, Vector3, inverse_rotation_jacobian};

/// The spring of a body's joint. Its force is proportional to the joint's displacement from a
/// reference.
#[derive(Clone, Copy, Debug)]
pub struct JointSpring<S> {
    /// The stiffness, N m/rad or N/m.
    pub stiffness: S,
    /// The coordinates without force.
    pub reference: SpringReference<S>,
}

/// The coordinates at which a spring exerts no force.
#[derive(Clone, Copy, Debug)]
pub enum SpringReference<S> {
    /// The coordinate of a revolute or prismatic joint.
    Coordinate(S),
    /// The quaternion of a spherical joint.
    Rotation([S; 4]),
    /// The position and the quaternion of a floating joint.
    Pose([S; 3], [S; 4]),
}

impl<S> JointSpring<S> {
    /// Returns the spring with `f` applied to its numbers: the stiffness, then the coordinates.
    pub fn map<T>(&self, mut f: impl FnMut(S) -> T) -> JointSpring<T>
    where
        S: Copy,
    {
        JointSpring {
            stiffness: f(self.stiffness),
            reference: match self.reference {
                SpringReference::Coordinate(x) => SpringReference::Coordinate(f(x)),
                SpringReference::Rotation(rotation) => {
                    SpringReference::Rotation(rotation.map(&mut f))
                }
                SpringReference::Pose(position, rotation) => {
                    SpringReference::Pose(position.map(&mut f), rotation.map(&mut f))
                }
            },
        }
    }
}

impl<S: Scalar> JointSpring<S> {
    /// Returns the displacement of a joint from the reference, along each degree of freedom.
    /// `coordinates` begins with the joint's coordinates, or with the coordinates of the leader of
    /// which it is a multiple with an offset.
    fn displacement(&self, coordinates: &[S], mimic: Option<(S, S)>) -> Rates<S> {
        let quaternion = |from: usize| Quaternion::from_components(entries(coordinates, from));
        let rotation = |from: usize, reference: [S; 4]| {
            let reference = Quaternion::from_components(reference);
            reference.conjugate().times(quaternion(from)).log()
        };
        let o = S::zero();
        match self.reference {
            SpringReference::Coordinate(reference) => {
                let x = mimic.map_or(coordinates[0], |(multiplier, offset)| {
                    multiplier * coordinates[0] + offset
                });
                Rates { numbers: [x - reference, o, o, o, o, o], count: 1 }
            }
            SpringReference::Rotation(reference) => {
                let [x, y, z] = rotation(0, reference).0;
                Rates { numbers: [x, y, z, o, o, o], count: 3 }
            }
            SpringReference::Pose(position, reference) => {
                let moved = Vector3(entries(coordinates, 0)) - Vector3(position);
                let [a, b, c] = quaternion(3).conjugate().rotate(moved).0;
                let [x, y, z] = rotation(3, reference).0;
                Rates { numbers: [a, b, c, x, y, z], count: 6 }
            }
        }
    }
}

impl<S: Scalar> Mechanism<S> {
    /// Returns the joint forces that hold the spring of body `i`'s joint at the coordinates `q`,
    /// one for each degree of freedom of the body; `None` without a spring.
    #[must_use]
    pub fn spring_forces(&self, i: usize, q: &[S]) -> Option<Rates<S>> {
        let body = &self.bodies[i];
        let spring = body.spring.as_ref()?;
        let Rates { numbers, count } = spring.displacement(&q[body.q..], body.mimic);
        Some(Rates { numbers: numbers.map(|x| spring.stiffness * x), count })
    }

    /// Returns the potential energy of all springs at the coordinates `q`, J; `None` without
    /// springs.
    #[must_use]
    pub fn spring_energy(&self, q: &[S]) -> Option<S> {
        let energies = self.bodies.iter().filter_map(|body| {
            let spring = body.spring.as_ref()?;
            let displacement = spring.displacement(&q[body.q..], body.mimic);
            let square = displacement.iter().map(|&x| x * x).reduce(|sum, x| sum + x)?;
            Some(S::from_f64(0.5) * spring.stiffness * square)
        });
        energies.reduce(|sum, energy| sum + energy)
    }

    /// Calls `add` for the derivatives of the [`spring_forces`](Self::spring_forces) with respect
    /// to the coordinates, in tangent space, with two degrees of freedom: the force's and the
    /// displacement's.
    pub(crate) fn spring_derivatives(&self, q: &[S], mut add: impl FnMut(usize, usize, S)) {
        for body in &self.bodies {
            let Some(spring) = &body.spring else { continue };
            let stiffness = spring.stiffness;
            let first = body.dofs.start;
            let displacement = spring.displacement(&q[body.q..], body.mimic);
            let vector = |from: usize| Vector3(entries(&displacement, from));
            let mut add_block = |row: usize, column: usize, block: Matrix3<S>| {
                for (i, entries) in block.0.iter().enumerate() {
                    for (j, &entry) in entries.iter().enumerate() {
                        add(first + row + i, first + column + j, stiffness * entry);
                    }
                }
            };
            match spring.reference {
                SpringReference::Coordinate(_) => add(first, first, stiffness),
                SpringReference::Rotation(_) => {
                    add_block(0, 0, inverse_rotation_jacobian(vector(0)));
                }
                SpringReference::Pose(..) => {
                    // A rotation of the axes about s changes the components d of the displacement
                    // by d x s.
                    add_block(0, 3, Matrix3::cross(vector(0)));
                    add_block(3, 3, inverse_rotation_jacobian(vector(3)));
                    (0..3).for_each(|i| add(first + i, first + i, stiffness));
                }
            }
        }
    }
}

fn entries<S: Copy, const N: usize>(x: &[S], from: usize) -> [S; N] {
    core::array::from_fn(|k| x[from + k])
}
