//! A compiled robot of the [fleet](crate::fleet), as a table of pointers to its functions. The packages in
//! `tests/fleet/` compile the robots. The package `modyn-fleet` has the table of all robots, and the tests over it.

use std::ops::Range;

use modyn_runtime::{JointLimits, KinematicModule, OperationCount};

use crate::fleet::Spec;
use crate::values::{Arguments, Values};

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
    pub double: fn(Arguments<'_>) -> Values<f64>,
    /// Calls the functions through the trait [`Robot`](modyn_runtime::Robot), in single precision.
    pub single: fn(Arguments<'_>) -> Values<f32>,
    /// Calls the type's own functions.
    pub own: Own,
}

/// The type's own functions, in the scalar that the type was compiled with.
#[derive(Clone, Copy, Debug)]
pub enum Own {
    /// In double precision.
    Double(fn(Arguments<'_>) -> Values<f64>),
    /// In single precision.
    Single(fn(Arguments<'_>) -> Values<f32>),
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
    // The results of the trait's functions.
    (@results $robot:ident $link:ident $functions:ident $float:ident [$($pivot:ident)*]) => {
        |arguments| {
            use $crate::values::{FromNumbers, Values, factors};
            let given = arguments(modyn_runtime::quantities::Function::ForwardDynamics);
            let [q, tau] = [&given[0], &given[2]];
            let brge = <$robot as modyn_runtime::Robot>::brge::<$float>(&FromNumbers::from_numbers(q));
            let pivots = vec![$(brge.$pivot().concat()),*];
            Values {
                functions: $crate::results!(of_trait $robot, $float, $functions, arguments, &$link::ALL),
                factors: factors::<$robot, $float>(&brge, &FromNumbers::from_numbers(tau), pivots),
            }
        }
    };
    ($(
        $index:literal $robot:ident $joint:ident $link:ident $functions:ident $float:ident
        $precision:ident $module:literal [$($operations:literal $constant:ident)*] [$($pivot:ident)*];
    )*) => {
        /// The robots of this package.
        pub static ROBOTS: &[$crate::compiled::Compiled] = {
            use $crate::compiled::{Compiled, Consts, TypeConstants, Own};
            use $crate::fleet::FLEET;
            use $crate::values::{Factors, FromNumbers, Values, columns};
            use modyn_runtime::quantities::Function;
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
                double: $crate::compiled!(@results $robot $link $functions f64 [$($pivot)*]),
                single: $crate::compiled!(@results $robot $link $functions f32 [$($pivot)*]),
                own: Own::$precision(|arguments| {
                    let given = arguments(Function::ForwardDynamics);
                    let brge = $robot::brge(&FromNumbers::from_numbers(&given[0]));
                    let factors = Factors {
                        u: columns(&brge.u()),
                        d: columns(&brge.d()),
                        u_inverse: columns(&brge.u_inverse()),
                        d_inverse: columns(&brge.d_inverse()),
                        solve: brge.solve(&FromNumbers::from_numbers(&given[2])).to_vec(),
                        inverse: columns(&brge.inverse()),
                        log_determinant: brge.log_determinant(),
                        pivot_blocks: vec![$(brge.$pivot().concat()),*],
                        condition_numbers: brge.condition_numbers().to_vec(),
                    };
                    let functions =
                        $crate::results!(own $robot, $float, $functions, arguments, &$link::ALL);
                    Values { functions, factors }
                }),
            }),*]
        };
    };
}
