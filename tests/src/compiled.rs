//! The robots of [`fleet`](crate::fleet), compiled by this crate's build script with it, and a
//! table of them.

use modyn_runtime::{KinematicModule, OperationCount};

use crate::fleet::{FLEET, Spec};
use crate::values::{Factors, Inputs, Values, columns, generated};

/// A compiled robot, for tests that go through all of them.
#[derive(Clone, Copy, Debug)]
pub struct Compiled {
    /// What was compiled.
    pub spec: Spec,
    /// The generated text.
    pub text: &'static str,
    /// What the type and the trait say about the robot; they must say the same.
    pub consts: [Consts; 2],
    /// The acceleration of free fall.
    pub gravity: [f64; 3],
    /// What each function is said to take, by the function's name.
    pub operations: &'static [(&'static str, OperationCount)],
    /// The enum of joints: each one's index and name.
    pub joints: fn() -> Vec<(usize, &'static str)>,
    /// The enum of links.
    pub links: fn() -> Vec<(usize, &'static str)>,
    /// Through the trait [`Robot`](modyn_runtime::Robot), in double precision.
    pub double: fn(&Inputs<f64>) -> Values<f64>,
    /// Through the trait [`Robot`](modyn_runtime::Robot), in single precision.
    pub single: fn(&Inputs<f32>) -> Values<f32>,
    /// Through the type's own functions.
    pub own: Own,
}

/// The type's own functions, in the scalar of its choice.
#[derive(Clone, Copy, Debug)]
pub enum Own {
    /// In double precision.
    Double(fn(&Inputs<f64>) -> Values<f64>),
    /// In single precision.
    Single(fn(&Inputs<f32>) -> Values<f32>),
}

/// What is known about a robot without running it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Consts {
    pub name: &'static str,
    pub nq: usize,
    pub nv: usize,
    pub joint_names: &'static [&'static str],
    pub link_names: &'static [&'static str],
    pub modules: &'static [KinematicModule],
}

impl Compiled {
    /// What to call it.
    #[must_use]
    pub fn name(&self) -> String {
        self.spec.module()
    }
}

/// The array that those numbers are.
fn fixed<T: Copy, const N: usize>(numbers: &[T]) -> [T; N] {
    numbers.try_into().expect("as many numbers as the robot has joints")
}

/// The consts of a type or, given `as Robot`, of the trait.
macro_rules! consts {
    ($robot:ty) => {
        Consts {
            name: <$robot>::NAME,
            nq: <$robot>::NQ,
            nv: <$robot>::NV,
            joint_names: &<$robot>::JOINT_NAMES,
            link_names: &<$robot>::LINK_NAMES,
            modules: &<$robot>::MODULES,
        }
    };
    ($robot:ty as Robot) => {
        Consts {
            name: <$robot as modyn_runtime::Robot>::NAME,
            nq: <$robot as modyn_runtime::Robot>::NQ,
            nv: <$robot as modyn_runtime::Robot>::NV,
            joint_names: <$robot as modyn_runtime::Robot>::JOINT_NAMES,
            link_names: <$robot as modyn_runtime::Robot>::LINK_NAMES,
            modules: <$robot as modyn_runtime::Robot>::MODULES,
        }
    };
}

/// The table; its rows are the build script's.
macro_rules! compiled {
    ($(
        $index:literal $robot:ident $joint:ident $link:ident $float:ident $precision:ident
        $module:literal [$($pivot:ident)*];
    )*) => {
        /// All robots that were compiled.
        pub static ROBOTS: [super::Compiled; super::FLEET.len()] = {
            use super::{Compiled, Consts, FLEET, Factors, Own, Values, columns, fixed, generated};
            [$(Compiled {
                spec: FLEET[$index],
                text: include_str!(concat!(env!("OUT_DIR"), "/", $module, ".rs")),
                consts: [consts!($robot), consts!($robot as Robot)],
                gravity: $robot::GRAVITY,
                operations: &[
                    ("forward_dynamics", $robot::FORWARD_DYNAMICS_OPERATIONS),
                    ("inverse_dynamics", $robot::INVERSE_DYNAMICS_OPERATIONS),
                    ("bias_forces", $robot::BIAS_FORCES_OPERATIONS),
                    ("gravity_torques", $robot::GRAVITY_TORQUES_OPERATIONS),
                    ("mass_matrix", $robot::MASS_MATRIX_OPERATIONS),
                    ("kinetic_energy", $robot::KINETIC_ENERGY_OPERATIONS),
                    ("potential_energy", $robot::POTENTIAL_ENERGY_OPERATIONS),
                    ("link_poses", $robot::LINK_POSES_OPERATIONS),
                    ("brge", $robot::BRGE_OPERATIONS),
                ],
                joints: || $joint::ALL.iter().map(|joint| (joint.index(), joint.name())).collect(),
                links: || $link::ALL.iter().map(|link| (link.index(), link.name())).collect(),
                double: |inputs| {
                    generated::<$robot, f64>(inputs, |brge| vec![$(brge.$pivot().concat()),*])
                },
                single: |inputs| {
                    generated::<$robot, f32>(inputs, |brge| vec![$(brge.$pivot().concat()),*])
                },
                own: Own::$precision(|inputs| {
                    let [q, qd, qdd, tau] =
                        [&inputs.q, &inputs.qd, &inputs.qdd, &inputs.tau].map(|x| fixed(x));
                    let brge = $robot::brge(&q);
                    let factors = Factors::<$float> {
                        u: columns(&brge.u()),
                        d: columns(&brge.d()),
                        u_inverse: columns(&brge.u_inverse()),
                        d_inverse: columns(&brge.d_inverse()),
                        solve: brge.solve(&tau).to_vec(),
                        inverse: columns(&brge.inverse()),
                        log_determinant: brge.log_determinant(),
                        pivot_blocks: vec![$(brge.$pivot().concat()),*],
                        condition_numbers: brge.condition_numbers().to_vec(),
                    };
                    let poses = $robot::link_poses(&q);
                    Values {
                        forward_dynamics: $robot::forward_dynamics(&q, &qd, &tau).to_vec(),
                        inverse_dynamics: $robot::inverse_dynamics(&q, &qd, &qdd).to_vec(),
                        bias_forces: $robot::bias_forces(&q, &qd).to_vec(),
                        gravity_torques: $robot::gravity_torques(&q).to_vec(),
                        mass_matrix: columns(&$robot::mass_matrix(&q)),
                        kinetic_energy: $robot::kinetic_energy(&q, &qd),
                        potential_energy: $robot::potential_energy(&q),
                        link_poses: poses.iter().flat_map(crate::quantities::numbers).collect(),
                        factors,
                    }
                }),
            }),*]
        };
    };
}

/// The types.
pub mod robots {
    include!(concat!(env!("OUT_DIR"), "/fleet.rs"));
}

pub use robots::ROBOTS;
