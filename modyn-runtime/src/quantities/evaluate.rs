//! The evaluation of any function of the table on numbers.

use alloc::vec::Vec;

use super::row::Function;
use super::shape::{Record, Shape, Sizes};
use super::table;
use crate::equations::actuation::ActuatorInput;
use crate::equations::constraints::{
    ConstrainedCotangent, ConstrainedInverseOutputs, ConstrainedOutputs, ImpulseOutputs,
    OperationalInertiaOutputs, ProjectionOutputs, ResidualOutputs,
};
use crate::equations::derivatives::CentroidalOutputs;
use crate::equations::soft_constraints::{ActuatedInput, StepInput};
use crate::equations::{Forces, ForwardInput, Motion, State, TimeStepInput};
use crate::interpreter::{
    ActuatorOutputs, ConstrainedDerivatives, ConstrainedHessianOutputs, ForwardDerivatives,
    FrameError, HessianOutputs, Interpreter, ShapeError, StepHessianOutputs, StepOutputs,
    StepSolutionOutputs,
};
use crate::spatial::{Momentum, Pose, Twist, Vector3, Wrench};
use crate::{ConstraintSettings, ContactSurface, ContactTarget, Scalar, StepSettings};

/// An object that consists of a number of scalars.
trait Components<S>: Sized {
    /// The number of scalars.
    const COUNT: usize;

    /// Returns the object with these scalars.
    fn read(numbers: &[S]) -> Self;

    /// Writes the scalars.
    fn write(&self, numbers: &mut [S]);
}

/// Two vectors of three components.
macro_rules! pairs {
    ($($type:ident $first:ident $second:ident;)*) => {
        $(impl<S: Scalar> Components<S> for $type<S> {
            const COUNT: usize = 6;

            fn read(n: &[S]) -> Self {
                Self { $first: Vector3([n[0], n[1], n[2]]), $second: Vector3([n[3], n[4], n[5]]) }
            }

            fn write(&self, numbers: &mut [S]) {
                numbers.copy_from_slice(&self.components());
            }
        })*
    };
}

pairs! {
    Twist angular linear;
    Momentum angular linear;
    Wrench moment force;
}

impl<S: Scalar> Components<S> for Vector3<S> {
    const COUNT: usize = 3;

    fn read(n: &[S]) -> Self {
        Self([n[0], n[1], n[2]])
    }

    fn write(&self, numbers: &mut [S]) {
        numbers.copy_from_slice(&self.0);
    }
}

impl<S: Scalar> Components<S> for Pose<S> {
    const COUNT: usize = 12;

    fn read(n: &[S]) -> Self {
        let three = |i: usize| [n[i], n[i + 1], n[i + 2]];
        Self { rotation: [three(0), three(3), three(6)], translation: three(9) }
    }

    fn write(&self, numbers: &mut [S]) {
        let (rotation, translation) = numbers.split_at_mut(9);
        rotation.copy_from_slice(self.rotation.as_flattened());
        translation.copy_from_slice(&self.translation);
    }
}

/// Returns the objects with these scalars, one after the other.
fn read<S, X: Components<S>>(numbers: &[S]) -> Vec<X> {
    numbers.chunks(X::COUNT).map(X::read).collect()
}

/// Writes the scalars of objects, one after the other.
fn write<S, X: Components<S>>(objects: &[X], numbers: &mut [S]) {
    for (object, numbers) in objects.iter().zip(numbers.chunks_mut(X::COUNT)) {
        object.write(numbers);
    }
}

/// Writes the scalars of the objects that `compute` assigns.
fn fill<S, X: Components<S>, E>(
    numbers: &mut [S],
    compute: impl FnOnce(&mut [X]) -> Result<(), E>,
) -> Result<(), E> {
    let mut objects = read(numbers);
    compute(&mut objects)?;
    write(&objects, numbers);
    Ok(())
}

/// Returns the settings of constraints, and the targets of contacts, with these scalars.
fn settings_of<S: Scalar>(numbers: &[S]) -> ConstraintSettings<S, Vec<ContactTarget<S>>> {
    let (settings, targets) = numbers.split_at(ConstraintSettings::<S>::COUNT);
    let settings = core::array::from_fn(|i| settings[i]);
    let (targets, _) = targets.as_chunks();
    let contacts = targets.iter().map(|target| ContactTarget::from_numbers(*target)).collect();
    ConstraintSettings::from_numbers(settings, contacts)
}

/// Returns the settings of steps, and the surfaces of contacts, with these scalars.
fn step_settings_of<S: Scalar>(numbers: &[S]) -> StepSettings<S, Vec<ContactSurface<S>>> {
    let (settings, surfaces) = numbers.split_at(StepSettings::<S>::COUNT);
    let (surfaces, _) = surfaces.as_chunks();
    let contacts = surfaces.iter().map(|surface| ContactSurface::from_numbers(*surface)).collect();
    StepSettings::from_numbers([settings[0], settings[1]], contacts)
}

/// Returns the destinations of the solution of a step: q, qd, qdd, the forces, the residual and the
/// number of iterations.
fn solution_of<S>(
    [q, qd, qdd, forces, residual, iterations]: [&mut [S]; 6],
) -> StepSolutionOutputs<'_, S> {
    let [residual, iterations] = [residual, iterations].map(|number| &mut number[0]);
    StepSolutionOutputs { q, qd, qdd, forces, residual, iterations }
}

/// Returns the parts of a result: the fields of a function with several results, else the whole
/// result.
fn parts<'a, S, const N: usize>(shape: &Shape, mut numbers: &'a mut [S]) -> [&'a mut [S]; N] {
    let Shape::Record(Record::Several(_) | Record::Each(_), fields) = shape else {
        let mut whole = Some(numbers);
        return core::array::from_fn(|_| whole.take().unwrap_or_default());
    };
    core::array::from_fn(|k| {
        let (part, rest) = core::mem::take(&mut numbers).split_at_mut(fields[k].1.len());
        numbers = rest;
        part
    })
}

/// Defines the evaluation of all functions of one state.
macro_rules! declare_evaluation {
    ($(
        $function:ident $name:ident $(/ $with:ident)? ($($argument:ident),* $(; $link:ident)?)
        -> $result:ident $(as $named:literal)?, $flags:tt, $docs:literal, $message:literal
        $(, batch $batch:ident $batch_message:literal)?
        => |$robot:ident, [$($out:ident),*]| $body:expr;
    )*) => {
        impl Function {
            /// Evaluates the function on arguments of the right lengths.
            fn on<S: Scalar>(
                self,
                robot: &mut Interpreter<S>,
                arguments: &[&[S]],
                of: usize,
                (shape, numbers): (&Shape, &mut [S]),
            ) -> Result<(), FrameError> {
                match self {
                    $(Self::$function => {
                        let [$($argument),*] = *arguments else { unreachable!("as many as in the row") };
                        let [$($out),*] = parts(shape, numbers);
                        let $robot = robot;
                        $(let $link = of;)?
                        $body;
                    })*
                    _ => {
                        let one = self.batched().unwrap_or(self);
                        return one.on(robot, arguments, of, (shape, numbers));
                    }
                }
                Ok(())
            }
        }
    };
}

table::quantities!(declare_evaluation);

impl<S: Scalar> Interpreter<S> {
    /// Computes any function of the table from numbers: `arguments` has a slice for each argument
    /// of its [row](Function::row), and `result` receives the numbers in the order of the row's
    /// result. `link` is the link of a function of one link, as an index into the links of the
    /// description; other functions ignore it. A function of many states is computed for one.
    ///
    /// A set of active contacts is a number for each contact, 1 or 0. The settings of constraints
    /// are [`ConstraintSettings::numbers`], then [`ContactTarget::numbers`] for each contact.
    /// Allocates memory at each call.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    /// use modyn_runtime::quantities::Function;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let mut energy = [0.0];
    /// pendulum.evaluate(Function::KineticEnergy, &[&[0.3], &[2.0]], 0, &mut energy)?;
    /// assert_eq!(energy, [0.5 * 2.0 * 1.0]);
    /// # Ok::<(), modyn_runtime::FrameError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If there are not as many arguments as in the row, if a slice does not have the length of its
    /// argument, if there is no such link, or if the function needs inertia and a joint
    /// [moves none](Self::joint_without_inertia).
    pub fn evaluate(
        &mut self,
        function: Function,
        arguments: &[&[S]],
        link: usize,
        result: &mut [S],
    ) -> Result<(), FrameError> {
        let row = function.row();
        let sizes = self.sizes();
        if let Some(joint) = self.joint_without_inertia().filter(|_| row.needs_inertia) {
            return Err(FrameError::NoInertia { joint });
        }
        if arguments.len() != row.arguments.len() {
            let expected = row.arguments.len();
            let count = arguments.len();
            return Err(ShapeError::new("arguments", expected, count).into());
        }
        let check = |name, numbers: &[S], expected| match numbers.len() {
            length if length == expected => Ok(()),
            length => Err(ShapeError::new(name, expected, length)),
        };
        for (argument, numbers) in row.arguments.iter().zip(arguments) {
            check(argument.name, numbers, argument.shape(&sizes).len())?;
        }
        let shape = (row.result)(&sizes);
        check(function.result_name(), result, shape.len())?;
        function.on(self, arguments, link, (&shape, result))
    }

    /// Returns the sizes of the robot, which the lengths of arguments and results follow from.
    #[must_use]
    pub fn sizes(&self) -> Sizes {
        Sizes::new(self.model(), self.layout().size())
    }
}
