//! A compiled robot of the [fleet](crate::fleet), as a table of pointers to its functions. The packages in
//! `tests/fleet/` compile the robots. The package `modyn-fleet` has the table of all robots, and the tests over it.

use std::ops::Range;

use modyn_runtime::{JointLimits, KinematicModule, OperationCount};

use crate::fleet::Spec;
use crate::values::{Inputs, Values};

/// A compiled robot, for tests over all robots.
#[derive(Clone, Copy, Debug)]
pub struct Compiled {
    /// The description and the options of the robot.
    pub spec: Spec,
    /// The generated text.
    pub text: &'static str,
    /// The constants of the type and of the trait, which must be equal.
    pub consts: [Consts; 2],
    /// The gravitational acceleration, m/s^2.
    pub gravity: [f64; 3],
    /// The constants that only the type has.
    pub type_constants: TypeConstants,
    /// The announced operations of each function, by the function's name.
    pub operations: &'static [(&'static str, OperationCount)],
    /// Returns the enum of joints: the index and the name of each joint.
    pub joints: fn() -> Vec<(usize, &'static str)>,
    /// Returns the entries of q and of qd that belong to each joint.
    pub ranges: fn() -> Vec<[Range<usize>; 2]>,
    /// Returns the neutral coordinates of the type and of the trait.
    pub neutral: fn() -> [Vec<f64>; 2],
    /// Returns the enum of links: the index and the name of each link.
    pub links: fn() -> Vec<(usize, &'static str)>,
    /// Calls the functions through the trait [`Robot`](modyn_runtime::Robot), in double precision.
    pub double: fn(&Inputs<f64>) -> Values<f64>,
    /// Calls the functions through the trait [`Robot`](modyn_runtime::Robot), in single precision.
    pub single: fn(&Inputs<f32>) -> Values<f32>,
    /// Calls the type's own functions.
    pub own: Own,
}

/// The type's own functions, in the scalar that the type was compiled with.
#[derive(Clone, Copy, Debug)]
pub enum Own {
    /// In double precision.
    Double(fn(&Inputs<f64>) -> Values<f64>),
    /// In single precision.
    Single(fn(&Inputs<f32>) -> Values<f32>),
}

/// The constants of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Consts {
    pub name: &'static str,
    pub nq: usize,
    pub nv: usize,
    pub joint_names: &'static [&'static str],
    pub link_names: &'static [&'static str],
    pub coordinate_names: &'static [&'static str],
    pub velocity_names: &'static [&'static str],
    pub limits: JointLimits<'static>,
    pub modules: &'static [KinematicModule],
}

/// The constants of a type that the trait does not have.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct TypeConstants {
    pub parameters: &'static [f64],
    pub armature: &'static [f64],
    pub damping: &'static [f64],
    pub friction: &'static [f64],
}

impl Compiled {
    /// Returns the name of the robot in messages.
    #[must_use]
    pub fn name(&self) -> String {
        self.spec.module()
    }
}

/// Defines the table `ROBOTS` of the robots that a package compiles; the build script writes the rows.
#[macro_export]
macro_rules! compiled {
    // The constants of a type or, with `as Robot`, of the trait.
    (@consts $robot:ty) => {
        Consts {
            name: <$robot>::NAME,
            nq: <$robot>::NQ,
            nv: <$robot>::NV,
            joint_names: &<$robot>::JOINT_NAMES,
            link_names: &<$robot>::LINK_NAMES,
            coordinate_names: &<$robot>::COORDINATE_NAMES,
            velocity_names: &<$robot>::VELOCITY_NAMES,
            limits: <$robot>::LIMITS,
            modules: &<$robot>::MODULES,
        }
    };
    (@consts $robot:ty as Robot) => {
        Consts {
            name: <$robot as modyn_runtime::Robot>::NAME,
            nq: <$robot as modyn_runtime::Robot>::NQ,
            nv: <$robot as modyn_runtime::Robot>::NV,
            joint_names: <$robot as modyn_runtime::Robot>::JOINT_NAMES,
            link_names: <$robot as modyn_runtime::Robot>::LINK_NAMES,
            coordinate_names: <$robot as modyn_runtime::Robot>::COORDINATE_NAMES,
            velocity_names: <$robot as modyn_runtime::Robot>::VELOCITY_NAMES,
            limits: <$robot as modyn_runtime::Robot>::LIMITS,
            modules: <$robot as modyn_runtime::Robot>::MODULES,
        }
    };
    // The further quantities of a robot with all functions.
    (@others all $others:expr) => { $others };
    (@others default $others:expr) => { Vec::new() };
    ($(
        $index:literal $robot:ident $joint:ident $link:ident $functions:ident $float:ident
        $precision:ident $module:literal [$($operations:literal $constant:ident)*] [$($pivot:ident)*];
    )*) => {
        /// The robots of this package.
        pub static ROBOTS: &[$crate::compiled::Compiled] = {
            use $crate::compiled::{Compiled, Consts, TypeConstants, Own};
            use $crate::fleet::FLEET;
            use $crate::values::{
                Factors, Given, Values, columns, each, generated, generated_others,
            };
            &[$(Compiled {
                spec: FLEET[$index],
                text: include_str!(concat!(env!("OUT_DIR"), "/", $module, ".rs")),
                consts: [$crate::compiled!(@consts $robot), $crate::compiled!(@consts $robot as Robot)],
                gravity: $robot::GRAVITY,
                type_constants: TypeConstants {
                    parameters: &$robot::PARAMETERS,
                    armature: &$robot::ARMATURE,
                    damping: &$robot::DAMPING,
                    friction: &$robot::FRICTION,
                },
                operations: &[$(($operations, $robot::$constant)),*],
                joints: || $joint::ALL.iter().map(|joint| (joint.index(), joint.name())).collect(),
                ranges: || {
                    $joint::ALL.iter().map(|joint| [joint.coordinates(), joint.velocities()]).collect()
                },
                neutral: || {
                    let of_the_trait: [f64; $robot::NQ] = <$robot as modyn_runtime::Robot>::neutral();
                    [$robot::NEUTRAL.map(f64::from).to_vec(), of_the_trait.to_vec()]
                },
                links: || $link::ALL.iter().map(|link| (link.index(), link.name())).collect(),
                double: |inputs| {
                    let mut values = generated::<$robot, f64>(inputs, &$link::ALL, |brge| {
                        vec![$(brge.$pivot().concat()),*]
                    });
                    values.others.extend($crate::compiled!(
                        @others $functions generated_others::<$robot, f64>(inputs, &$link::ALL)
                    ));
                    values
                },
                single: |inputs| {
                    let mut values = generated::<$robot, f32>(inputs, &$link::ALL, |brge| {
                        vec![$(brge.$pivot().concat()),*]
                    });
                    values.others.extend($crate::compiled!(
                        @others $functions generated_others::<$robot, f32>(inputs, &$link::ALL)
                    ));
                    values
                },
                own: Own::$precision(|inputs| {
                    let given: Given<
                        [$float; $robot::NQ],
                        [$float; $robot::NV],
                        [_; $robot::LINK_NAMES.len()],
                    > = Given::new(inputs);
                    let Given { q, qd, qdd, tau, .. } = &given;
                    let brge = $robot::brge(q);
                    let factors = Factors::<$float> {
                        u: columns(&brge.u()),
                        d: columns(&brge.d()),
                        u_inverse: columns(&brge.u_inverse()),
                        d_inverse: columns(&brge.d_inverse()),
                        solve: brge.solve(tau).to_vec(),
                        inverse: columns(&brge.inverse()),
                        log_determinant: brge.log_determinant(),
                        pivot_blocks: vec![$(brge.$pivot().concat()),*],
                        condition_numbers: brge.condition_numbers().to_vec(),
                    };
                    let mut values = Values {
                        forward_dynamics: $robot::forward_dynamics(q, qd, tau).to_vec(),
                        inverse_dynamics: $robot::inverse_dynamics(q, qd, qdd).to_vec(),
                        bias_forces: $robot::bias_forces(q, qd).to_vec(),
                        gravity_torques: $robot::gravity_torques(q).to_vec(),
                        mass_matrix: columns(&$robot::mass_matrix(q)),
                        kinetic_energy: $robot::kinetic_energy(q, qd),
                        potential_energy: $robot::potential_energy(q),
                        link_poses: each(&$robot::link_poses(q), $crate::quantities::numbers),
                        factors,
                        others: $crate::default_quantities!($robot, &given, &$link::ALL),
                    };
                    values.others.extend($crate::compiled!(
                        @others $functions $crate::other_quantities!($robot, &given, &$link::ALL)
                    ));
                    values
                }),
            }),*]
        };
    };
}
