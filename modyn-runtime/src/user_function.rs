//! Functions that users write once over [`Scalar`]: the interpreter runs them on numbers, and the
//! compiler traces them.

use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use core::error::Error;

use crate::interpreter::Interpreter;
use crate::scalar::Scalar;

/// A function of a robot's state that a user writes, such as a cost or a constraint of an optimal
/// control problem.
///
/// It is written once, over any [`Scalar`], with the quantities of an [`Interpreter`]. Called on
/// numbers, it returns its value. `modyn_codegen::Builder::function` compiles it in a build script,
/// with its derivatives. `N` is the number of arguments.
///
/// ```
/// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
/// use modyn_runtime::{Interpreter, Scalar, UserArgument, UserError, UserFunction};
///
/// /// The squared distance from a link's origin to a target.
/// struct Reach {
///     link: &'static str,
/// }
///
/// impl UserFunction<2> for Reach {
///     fn docs(&self) -> String {
///         "Returns the squared distance (m^2) from the bob to `target` (m, world axes).".into()
///     }
///
///     fn arguments(&self) -> [UserArgument; 2] {
///         [UserArgument::Q, UserArgument::numbers("target", 3)]
///     }
///
///     fn evaluate<S: Scalar>(
///         &self,
///         robot: &mut Interpreter<S>,
///         [q, target]: [&[S]; 2],
///     ) -> Result<Vec<S>, UserError> {
///         let link = robot.model().link_index(self.link).ok_or("no such link")?;
///         let pose = robot.link_pose(q, link)?;
///         let squares = pose.translation.iter().zip(target).map(|(&x, &t)| (x - t) * (x - t));
///         Ok(vec![squares.fold(S::zero(), |sum, square| sum + square)])
///     }
/// }
///
/// // A pendulum with its bob 0.5 m below its joint.
/// let mut robot = Interpreter::<f64>::new(model);
/// let cost = Reach { link: "bob" }.evaluate(&mut robot, [&[0.0], &[0.0, 0.0, 0.5]])?;
/// assert!((cost[0] - 1.0).abs() < 1e-12);
/// # Ok::<(), UserError>(())
/// ```
pub trait UserFunction<const N: usize> {
    /// Returns the text that documents the generated function. The text says what the function
    /// returns, with units and frames.
    fn docs(&self) -> String;

    /// Returns the arguments in their order.
    fn arguments(&self) -> [UserArgument; N];

    /// Returns the derivatives that are compiled. First and second derivatives by default.
    fn derivatives(&self) -> UserDerivatives {
        UserDerivatives::Second
    }

    /// Returns the value at these arguments, whose lengths are those that
    /// [`arguments`](Self::arguments) has. The number of results must not depend on `S`.
    ///
    /// The function must not branch on values. It may branch on the model, such as on the number of
    /// joints.
    ///
    /// # Errors
    ///
    /// Errors of the function's own, such as a link that the robot does not have. They become
    /// errors of the compilation.
    fn evaluate<S: Scalar>(
        &self,
        robot: &mut Interpreter<S>,
        arguments: [&[S]; N],
    ) -> Result<Vec<S>, UserError>;
}

/// An error of a user's function.
pub type UserError = Box<dyn Error>;

/// The derivatives of a user's function that are compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum UserDerivatives {
    /// None: the value alone.
    None,
    /// First derivatives.
    First,
    /// First and second derivatives.
    Second,
}

/// An argument of a user's function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UserArgument {
    name: &'static str,
    kind: UserArgumentKind,
    varies: bool,
}

/// The meaning of an argument's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UserArgumentKind {
    /// Coordinates, in which the quaternions have length 1.
    Coordinates,
    /// A number for each degree of freedom.
    Velocities,
    /// One number.
    Number,
    /// This many numbers.
    Numbers(usize),
}

impl UserArgument {
    /// The coordinates `q`, a variable.
    pub const Q: Self = Self::coordinates("q").variable();
    /// The velocities `qd`, a variable.
    pub const QD: Self = Self::velocities("qd").variable();
    /// The accelerations `qdd`, a variable.
    pub const QDD: Self = Self::velocities("qdd").variable();
    /// The joint forces `tau`, a variable.
    pub const TAU: Self = Self::velocities("tau").variable();

    const fn new(name: &'static str, kind: UserArgumentKind) -> Self {
        Self { name, kind, varies: false }
    }

    /// Returns an argument of coordinates, such as a reference posture's.
    #[must_use]
    pub const fn coordinates(name: &'static str) -> Self {
        Self::new(name, UserArgumentKind::Coordinates)
    }

    /// Returns an argument with a number for each degree of freedom.
    #[must_use]
    pub const fn velocities(name: &'static str) -> Self {
        Self::new(name, UserArgumentKind::Velocities)
    }

    /// Returns an argument of one number.
    #[must_use]
    pub const fn number(name: &'static str) -> Self {
        Self::new(name, UserArgumentKind::Number)
    }

    /// Returns an argument of `count` numbers.
    #[must_use]
    pub const fn numbers(name: &'static str, count: usize) -> Self {
        Self::new(name, UserArgumentKind::Numbers(count))
    }

    /// Returns the argument as a variable: derivatives are with respect to it. Those with respect
    /// to coordinates are in tangent space.
    #[must_use]
    pub const fn variable(self) -> Self {
        Self { varies: true, ..self }
    }

    /// Returns the argument as a constant: derivatives are taken at constant values of it.
    #[must_use]
    pub const fn constant(self) -> Self {
        Self { varies: false, ..self }
    }

    /// Returns the name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// Returns the meaning of the numbers.
    #[must_use]
    pub const fn kind(&self) -> UserArgumentKind {
        self.kind
    }

    /// Returns whether derivatives are with respect to the argument.
    #[must_use]
    pub const fn is_variable(&self) -> bool {
        self.varies
    }
}
