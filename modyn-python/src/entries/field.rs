//! A step on a height field as a function of arrays, and its derivatives: before the step, the plane
//! of each touching shape's surface becomes the plane of the field below the shape.
//!
//! The planes do not depend on the coordinates in derivatives: each is held where it is in the step.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use modyn_codegen::plan::{Derivative, DerivativeMode, EntryFunction, EntrySource};
use modyn_codegen::{FloatType, Function};
use modyn_runtime::simulate::HeightGrid;
use modyn_runtime::{ContactSurface, Pose, SettingError, StepSettings};

use super::signature::{self, Signature};
use crate::codes::{ArrayShapes, Kernel, Lanes, OwnCode, OwnKernel, StateFunction};
use crate::number::Number;
use crate::robot::Robot;

/// The numbers of a pose. The plane of a surface is its first numbers.
const POSE: usize = 12;

/// Returns the function of the poses of the links that carry the touching shapes: twelve numbers for
/// each shape.
pub fn poses(robot: &Robot) -> EntryFunction {
    let shapes = robot.model().touching_shapes().into_iter();
    let numbers = shapes.flat_map(|shape| POSE * shape.end.link..POSE * (shape.end.link + 1));
    EntryFunction {
        source: EntrySource::Table { function: Function::LinkPoses, link: None },
        results: vec![numbers.collect()],
        feedback: None,
        cost: false,
        derivatives: Vec::new(),
    }
}

/// Returns the numbers of the plane of each touching shape among the settings.
pub fn planes(shapes: usize) -> impl Iterator<Item = Range<usize>> {
    let first = |shape| StepSettings::<f64>::COUNT + shape * ContactSurface::<f64>::COUNT;
    (0..shapes).map(move |shape| first(shape)..first(shape) + POSE)
}

/// Returns the CUDA text of the kernel that sets the planes of settings below shapes, on a field with this
/// many rows and columns: a function of `poses`, `settings`, `heights` and `grid`.
pub fn planes_text(robot: &Robot, [rows, columns]: [usize; 2]) -> String {
    let shapes = robot.model().touching_shapes();
    let (real, suffix) = match robot.scalar() {
        FloatType::F64 => ("double", ""),
        FloatType::F32 => ("float", "f"),
    };
    let numbers = shapes.iter().flat_map(|shape| shape.end.pose.translation);
    let centers: Vec<String> = numbers.map(|number| format!("{number:?}{suffix}")).collect();
    let [first, surface] = [StepSettings::<f64>::COUNT, ContactSurface::<f64>::COUNT];
    let count = shapes.len();
    let constants = [
        ("SHAPES", count),
        ("SETTINGS", first + count * surface),
        ("FIRST", first),
        ("SURFACE", surface),
        ("ROWS", rows),
        ("COLUMNS", columns),
    ];
    let lines = constants.map(|(name, value)| format!("#define {name} {value}\n")).concat();
    format!(
        "typedef {real} real;\n{lines}static __device__ const real centers[] = {{ {} }};\n\n{}",
        centers.join(", "),
        include_str!("planes.cu")
    )
}

/// How a step has a height field.
#[derive(Debug)]
pub struct FieldForm {
    /// The number of rows and of columns of the heights.
    shape: [usize; 2],
    /// The coordinates, by their index among the arguments.
    q: usize,
    /// The settings, by their index among the arguments.
    settings: usize,
    /// The heights, which the grid follows, by their index among the arguments.
    heights: usize,
    /// The derivative of the step.
    derivative: Option<Derivative>,
}

impl FieldForm {
    /// Returns how a step or its derivative has a height field with this many rows and columns.
    ///
    /// # Errors
    ///
    /// If there are too few rows or columns, or the function has no ground.
    pub fn new(robot: &Robot, function: &EntryFunction, shape: [usize; 2]) -> Result<Self, String> {
        let [rows, columns] = shape;
        if rows < 2 || columns < 2 {
            let expected = "two rows and two columns, or more";
            return Err(format!(
                "`heights` of `HeightField` has the shape ({rows}, {columns}); expected {expected}"
            ));
        }
        let Signature { name, arguments, .. } = Signature::of(robot, &function.source)?;
        let index = |named: &str| arguments.iter().position(|(argument, _)| argument.name == named);
        let [Some(q), Some(settings)] = ["q", "step_settings"].map(index) else {
            return Err(format!("`{name}` has no ground"));
        };
        let step = EntryFunction { derivatives: Vec::new(), ..function.clone() };
        let heights = signature::shapes(robot, &step)?.inputs().len();
        let derivative = function.derivatives.first().cloned();
        Ok(Self { shape, q, settings, heights, derivative })
    }
}

/// A step on a height field, or a derivative of one: after the arguments of the step, `heights` (rows,
/// columns) and `grid`, the x and y of the first height and the distances of neighbours along x and y.
pub struct FieldStep<S: Number + 'static> {
    step: Arc<StateFunction<S>>,
    /// The poses of the links that carry the shapes.
    poses: Arc<StateFunction<S>>,
    /// The centres of the shapes in the frames of their links.
    centers: Vec<[S; 3]>,
    form: FieldForm,
    shapes: ArrayShapes,
}

impl<S: Number> FieldStep<S> {
    /// Returns a step on a height field, given the code of the step or of its derivative, and of the
    /// poses of the links that carry the shapes.
    pub fn new(robot: &Robot, [step, poses]: [Arc<StateFunction<S>>; 2], form: FieldForm) -> Self {
        let touching = robot.model().touching_shapes().into_iter();
        let centers = touching.map(|shape| shape.end.pose.translation.map(S::from_f64)).collect();
        let ground = form.heights..form.heights + 2;
        let mut inputs = step.shapes().inputs().to_vec();
        inputs.splice(form.heights..form.heights, [form.shape.to_vec(), vec![4]]);
        let shapes = ArrayShapes::new(inputs, step.shapes().outputs().to_vec())
            .with_in_place(ground)
            .with_checks(step.shapes().checks().to_vec());
        Self { step, poses, centers, form, shapes }
    }

    /// Returns the shapes of the arrays.
    pub fn shapes(&self) -> &ArrayShapes {
        &self.shapes
    }
}

impl<S: Number> OwnCode<S> for FieldStep<S> {
    fn ready(&self) -> Result<Box<dyn OwnKernel<S> + '_>, String> {
        let [step, poses] = [self.step.kernel()?, self.poses.kernel()?];
        Ok(Box::new(ReadyStep { function: self, step, poses, fault: OnceLock::new() }))
    }
}

/// A step on a height field, ready to be called.
struct ReadyStep<'a, S: Number + 'static> {
    function: &'a FieldStep<S>,
    step: Kernel<'a, S>,
    poses: Kernel<'a, S>,
    /// The first number of a field that was found outside of its range.
    fault: OnceLock<String>,
}

impl<S: Number> OwnKernel<S> for ReadyStep<'_, S> {
    fn cost(&self) -> usize {
        self.poses.cost() + self.step.cost()
    }

    fn lanes(&self) -> usize {
        self.poses.lanes().min(self.step.lanes())
    }

    fn fault(&self) -> Option<String> {
        self.fault.get().cloned()
    }

    fn run(&self, numbers: &[S], result: &mut [S], lanes: &Lanes<'_, S>) {
        let mut numbers = numbers.to_vec();
        self.set_planes(&mut numbers, lanes);
        let count = lanes.count();
        let FieldStep { centers, form, step, .. } = self.function;
        let hold = |numbers: &mut [S], first: usize, stride: usize| {
            for plane in planes(centers.len()) {
                for entry in plane {
                    numbers[first + entry * stride..][..stride].fill(S::zero());
                }
            }
        };
        let at = form.derivative.as_ref().and_then(|derivative| {
            let mut variables = derivative.variables.iter();
            Some((derivative, variables.position(|&k| k == form.settings)?))
        });
        let Some((Derivative { mode, variables }, at)) = at else {
            return self.step.run(&numbers, result, lanes);
        };
        let [inputs, outputs] = step.shapes().lengths();
        match mode {
            DerivativeMode::Forward => {
                // The changes of the variables are the last arguments.
                let first = inputs.len() - variables.len() + at;
                let row: usize = inputs[..first].iter().sum();
                hold(&mut numbers, row * count, count);
                self.step.run(&numbers, result, lanes);
            }
            DerivativeMode::Reverse => {
                self.step.run(&numbers, result, lanes);
                let row: usize = outputs[..at].iter().sum();
                hold(result, row * count, count);
            }
            DerivativeMode::Matrix => {
                self.step.run(&numbers, result, lanes);
                // The matrices of each result follow each other, by rows.
                let columns = inputs[form.settings];
                let mut row = 0;
                for (k, &length) in outputs.iter().enumerate() {
                    if k % variables.len() == at {
                        for entry in (row..row + length).step_by(columns) {
                            hold(result, entry * count, count);
                        }
                    }
                    row += length;
                }
            }
        }
    }
}

impl<S: Number> ReadyStep<'_, S> {
    /// Sets the planes of the settings to the planes of the field below the shapes.
    fn set_planes(&self, numbers: &mut [S], lanes: &Lanes<'_, S>) {
        let FieldStep { centers, form, step, .. } = self.function;
        let [inputs, _] = step.shapes().lengths();
        let count = lanes.count();
        let mut poses = vec![S::zero(); POSE * centers.len() * count];
        let [q, settings] = [form.q, form.settings].map(|k| inputs[..k].iter().sum::<usize>());
        let coordinates = &numbers[q * count..][..inputs[form.q] * count];
        self.poses.run(coordinates, &mut poses, lanes);
        for lane in 0..count {
            let shapes = planes(centers.len()).zip(centers).zip(poses.chunks_exact(POSE * count));
            for ((plane, &center), pose) in shapes {
                let number = |k: usize| pose[k * count + lane];
                let [x, y, z, translation] =
                    [0, 3, 6, 9].map(|row| [0, 1, 2].map(|k| number(row + k)));
                let pose = Pose { rotation: [x, y, z], translation };
                let Pose { rotation, translation } =
                    match self.plane_below(pose, center, lanes, lane) {
                        Ok(plane) => plane,
                        Err(error) => {
                            let several = lanes.states() > 1;
                            let state = lanes.state(lane);
                            self.fault.get_or_init(|| match several {
                                true => format!("{error} (in state {state})"),
                                false => error.to_string(),
                            });
                            return;
                        }
                    };
                let entries = rotation.iter().flatten().chain(&translation);
                for (&entry, k) in entries.zip(plane) {
                    numbers[(settings + k) * count + lane] = entry;
                }
            }
        }
    }

    /// Returns the plane of the field below a point of a link, in the state of a lane.
    fn plane_below(
        &self,
        pose: Pose<S>,
        place: [S; 3],
        lanes: &Lanes<'_, S>,
        lane: usize,
    ) -> Result<Pose<S>, SettingError> {
        let FieldForm { shape: [rows, columns], heights, .. } = self.function.form;
        let [x, y, along_x, along_y] = [0, 1, 2, 3].map(|k| lanes.in_place(heights + 1, lane)[k]);
        let grid = HeightGrid::new([x, y], [along_x, along_y], [columns, rows])?;
        grid.plane_below(lanes.in_place(heights, lane), pose, place)
    }
}
