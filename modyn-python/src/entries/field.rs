//! A step on a height field as a function of arrays, and its derivatives: before the step, the plane
//! of each touching shape's surface becomes the plane of the field below the shape.
//!
//! The planes do not depend on the coordinates in derivatives: each is held where it is in the step.

use std::ops::Range;
use std::sync::Arc;

use modyn_codegen::Function;
use modyn_codegen::plan::{Derivative, DerivativeMode, EntryFunction};
use modyn_runtime::simulate::HeightField;
use modyn_runtime::{ContactSurface, Pose, SettingError, StepSettings};

use crate::codes::{ArrayShapes, Kernel, OwnCode, OwnKernel, StateFunction};
use crate::number::Number;
use crate::robot::Robot;

/// The index of the settings among the arguments of `step`.
const SETTINGS: usize = 5;

/// The numbers of a pose. The plane of a surface is its first numbers.
const POSE: usize = 12;

/// The numbers of a `HeightField`.
pub struct FieldNumbers<'a> {
    /// The x and y of the first height, m.
    pub origin: [f64; 2],
    /// The distances of neighbours along x and y, m.
    pub spacing: [f64; 2],
    /// The number of heights along x.
    pub columns: usize,
    /// The heights, m, by rows.
    pub heights: &'a [f64],
}

impl FieldNumbers<'_> {
    /// Returns all bits.
    pub fn bits(&self) -> Vec<u64> {
        let numbers = self.origin.iter().chain(&self.spacing).chain(self.heights);
        numbers.map(|number| number.to_bits()).chain([self.columns as u64]).collect()
    }
}

/// Returns the function of the poses of the links that carry the touching shapes: twelve numbers for
/// each shape.
pub fn poses(robot: &Robot) -> EntryFunction {
    let shapes = robot.model().touching_shapes().into_iter();
    let numbers = shapes.flat_map(|shape| POSE * shape.end.link..POSE * (shape.end.link + 1));
    EntryFunction {
        function: Function::LinkPoses,
        link: None,
        results: vec![numbers.collect()],
        feedback: false,
        cost: false,
        derivatives: Vec::new(),
    }
}

/// A step on a height field, or a derivative of one.
pub struct FieldStep<S: Number + 'static> {
    step: Arc<StateFunction<S>>,
    /// The poses of the links that carry the shapes.
    poses: Arc<StateFunction<S>>,
    origin: [S; 2],
    spacing: [S; 2],
    columns: usize,
    heights: Vec<S>,
    /// The centres of the shapes in the frames of their links.
    centers: Vec<[S; 3]>,
    derivative: Option<Derivative>,
}

impl<S: Number> FieldStep<S> {
    /// Returns a step on a height field.
    ///
    /// # Errors
    ///
    /// If a number of the field is outside of its range.
    pub fn new(
        robot: &Robot,
        [step, poses]: [Arc<StateFunction<S>>; 2],
        field: &FieldNumbers<'_>,
        derivative: Option<Derivative>,
    ) -> Result<Self, SettingError> {
        let shapes = robot.model().touching_shapes().into_iter();
        let centers = shapes.map(|shape| shape.end.pose.translation.map(S::from_f64));
        let step = Self {
            step,
            poses,
            origin: field.origin.map(S::from_f64),
            spacing: field.spacing.map(S::from_f64),
            columns: field.columns,
            heights: field.heights.iter().map(|&height| S::from_f64(height)).collect(),
            centers: centers.collect(),
            derivative,
        };
        // In the scalar a number can be infinite, or zero.
        step.field()?;
        Ok(step)
    }

    /// Returns the field.
    fn field(&self) -> Result<HeightField<'_, S>, SettingError> {
        HeightField::new(self.origin, self.spacing, self.columns, &self.heights)
    }

    /// Returns the shapes of the arrays.
    pub fn shapes(&self) -> &ArrayShapes {
        self.step.shapes()
    }
}

impl<S: Number> OwnCode<S> for FieldStep<S> {
    fn ready(&self) -> Result<Box<dyn OwnKernel<S> + '_>, String> {
        let [step, poses] = [self.step.kernel()?, self.poses.kernel()?];
        let field = self.field().map_err(|error| error.to_string())?;
        Ok(Box::new(ReadyStep { function: self, field, step, poses }))
    }
}

/// A step on a height field, ready to be called.
struct ReadyStep<'a, S: Number + 'static> {
    function: &'a FieldStep<S>,
    field: HeightField<'a, S>,
    step: Kernel<'a, S>,
    poses: Kernel<'a, S>,
}

impl<S: Number> OwnKernel<S> for ReadyStep<'_, S> {
    fn cost(&self) -> usize {
        self.poses.cost() + self.step.cost()
    }

    fn lanes(&self) -> usize {
        self.poses.lanes().min(self.step.lanes())
    }

    fn run(&self, numbers: &[S], result: &mut [S], lanes: usize) {
        let mut numbers = numbers.to_vec();
        self.set_planes(&mut numbers, lanes);
        let shapes = self.function.shapes();
        let hold = |numbers: &mut [S], first: usize, stride: usize| {
            for plane in self.planes() {
                for entry in plane {
                    numbers[first + entry * stride..][..stride].fill(S::zero());
                }
            }
        };
        let derivative = self.function.derivative.as_ref();
        let at = derivative.and_then(|derivative| {
            let mut variables = derivative.variables.iter();
            Some((derivative, variables.position(|&k| k == SETTINGS)?))
        });
        let Some((Derivative { mode, variables }, at)) = at else {
            return self.step.run(&numbers, result, lanes);
        };
        let [inputs, outputs] = shapes.lengths();
        match mode {
            DerivativeMode::Forward => {
                // The changes of the variables are the last arguments.
                let first = inputs.len() - variables.len() + at;
                let row: usize = inputs[..first].iter().sum();
                hold(&mut numbers, row * lanes, lanes);
                self.step.run(&numbers, result, lanes);
            }
            DerivativeMode::Reverse => {
                self.step.run(&numbers, result, lanes);
                let row: usize = outputs[..at].iter().sum();
                hold(result, row * lanes, lanes);
            }
            DerivativeMode::Matrix => {
                self.step.run(&numbers, result, lanes);
                // The matrices of each result follow each other, by rows.
                let columns = inputs[SETTINGS];
                let mut row = 0;
                for (k, &length) in outputs.iter().enumerate() {
                    if k % variables.len() == at {
                        for entry in (row..row + length).step_by(columns) {
                            hold(result, entry * lanes, lanes);
                        }
                    }
                    row += length;
                }
            }
        }
    }
}

impl<S: Number> ReadyStep<'_, S> {
    /// Returns the numbers of each plane among the settings.
    fn planes(&self) -> impl Iterator<Item = Range<usize>> {
        let first = |shape| StepSettings::<S>::COUNT + shape * ContactSurface::<S>::COUNT;
        (0..self.function.centers.len()).map(move |shape| first(shape)..first(shape) + POSE)
    }

    /// Sets the planes of the settings to the planes of the field below the shapes.
    fn set_planes(&self, numbers: &mut [S], lanes: usize) {
        let FieldStep { centers, .. } = self.function;
        let [inputs, _] = self.function.shapes().lengths();
        let mut poses = vec![S::zero(); POSE * centers.len() * lanes];
        self.poses.run(&numbers[..inputs[0] * lanes], &mut poses, lanes);
        let settings: usize = inputs[..SETTINGS].iter().sum();
        let shapes = self.planes().zip(centers).zip(poses.chunks_exact(POSE * lanes));
        for ((plane, &center), pose) in shapes {
            for lane in 0..lanes {
                let number = |k: usize| pose[k * lanes + lane];
                let [x, y, z, translation] =
                    [0, 3, 6, 9].map(|row| [0, 1, 2].map(|k| number(row + k)));
                let pose = Pose { rotation: [x, y, z], translation };
                let Pose { rotation, translation } = self.field.plane_below(pose, center);
                let entries = rotation.iter().flatten().chain(&translation);
                for (&entry, k) in entries.zip(plane.clone()) {
                    numbers[(settings + k) * lanes + lane] = entry;
                }
            }
        }
    }
}
