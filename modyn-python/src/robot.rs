//! The class `Robot`: a description with its functions, each compiled at its first use.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Mutex, OnceLock, PoisonError};

use modyn_codegen::diagnostics::{Code, suggest};
use modyn_codegen::plan::{Argument, EntryFunction, Shape, Sizes};
use modyn_codegen::trace::Parameters;
use modyn_codegen::{
    Builder, FloatType, Function, FusedFunction, ReadOptions, Shapes, joints_without_inertia,
};
use modyn_runtime::equations::identification::{BaseParameter, BaseParameters};
use modyn_runtime::model::{Keyframe, Model, ModuleTree, MovingLink};
use modyn_runtime::{ContactSurface, Inertial, Interpreter};
use numpy::prelude::*;
use numpy::{PyArray1, PyArray2, PyArrayDescr};
use pyo3::exceptions::{PyAttributeError, PyKeyError, PyTypeError, PyValueError};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

use crate::arrays::{Given, in_order, tuple};
use crate::change::Change;
use crate::codes::CodeHandle;
use crate::errors::{description_error, warn_of_description, warn_of_machine_code};
use crate::function::{self, RobotFunction};
use crate::number::Number;
use crate::options;
use crate::parameters::ParameterNumbers;

/// A robot: a description (URDF, xacro, SDF or MJCF) whose functions are compiled to machine code, each at
/// its first use.
///
/// `load` and `loads` make robots. Arguments and results are in SI units and radians, and joint
/// vectors have the order of `coordinate_names` and `velocity_names`. Each argument has one state,
/// or n states as n rows; the result then has n rows, too. `out` is an array (for several results:
/// an earlier result) that the call writes and returns.
#[pyclass(frozen, module = "modyn", weakref)]
pub struct Robot {
    builder: Builder,
    model: Model,
    modules: ModuleTree,
    /// A joint that moves no inertia, since its link has none.
    without_inertia: Option<String>,
    /// The index of each link of the description.
    links: HashMap<String, usize>,
    /// The source and the keyword arguments, for pickles.
    source: (Source, Py<PyDict>),
    scalar: FloatType,
    machine_code: bool,
    functions: Vec<Slot>,
    fused: Vec<Fused>,
    changes: Mutex<Vec<Change>>,
    parameters: Parameters,
    /// The functions of arrays that are compiled.
    pub array_codes: Mutex<Vec<(EntryFunction, CodeHandle)>>,
    /// What the package keeps of the robot: signatures and functions of arrays.
    kept: Py<PyDict>,
}

/// The place of a function, which is compiled at its first use.
type Slot = OnceLock<Box<dyn RobotFunction>>;

/// A fused function of a robot.
pub struct Fused {
    pub name: &'static str,
    function: FusedFunction,
    pub arguments: Vec<(Argument, Shape)>,
    /// Whether it depends on run-time parameters.
    pub depends_on_parameters: bool,
    pub result: Shape,
    slot: Slot,
}

/// A run-time parameter: the option, the link and the numbers.
pub type RunTimeParameter<'a> = (&'static str, Option<&'a str>, Vec<f64>);

/// A description.
#[derive(Clone)]
pub struct Source {
    pub text: String,
    /// The name of the file.
    pub file: String,
    /// The folder of files that the text names.
    pub folder: Option<PathBuf>,
}

impl Robot {
    /// Reads a description.
    ///
    /// # Errors
    ///
    /// `DescriptionError` with all errors of the description; `TypeError` and `ValueError` for
    /// options.
    pub fn read(py: Python<'_>, source: Source, arguments: &Bound<'_, PyDict>) -> PyResult<Self> {
        let keywords = arguments.copy()?;
        let machine_code = match keywords.get_item("machine_code")? {
            Some(wanted) => wanted.extract()?,
            None => true,
        };
        for option in ["machine_code", "fused"] {
            if keywords.contains(option)? {
                keywords.del_item(option)?;
            }
        }
        // A type's name has no meaning here, and no warning about it is due.
        let builder = Builder::new().text(&*source.text, &*source.file).type_name("Robot");
        let in_folder = match &source.folder {
            Some(folder) => builder.folder(folder),
            None => builder,
        };
        let builder = options::apply(in_folder, &keywords)?.functions([]);
        let fused = match arguments.get_item("fused")? {
            Some(wanted) if !wanted.is_none() => options::fused(&wanted)?,
            _ => Vec::new(),
        };
        let whole = builder.clone().fused(fused.iter().cloned());
        let planning = whole.plan().map_err(|errors| description_error(py, &errors))?;
        let modules = options::modules(arguments, &planning.model)?;
        warn_of_description(py, &planning.warnings)?;
        let planned = planning.plan.functions.iter().zip(fused).map(|(planned, function)| Fused {
            name: planned.name,
            function,
            arguments: planned.arguments.clone(),
            depends_on_parameters: planned.parameters > 0,
            result: planned.result.clone(),
            slot: OnceLock::new(),
        });
        let fused = planned.collect();
        let model = planning.model;
        let parameters = planning.plan.parameters;
        let links = model.links().iter().enumerate();
        let without_inertia = joints_without_inertia(&model);
        let name = |&joint: &usize| model.moving_links()[joint].joint.name.clone();
        Ok(Self {
            without_inertia: without_inertia.first().map(name),
            links: links.map(|(i, link)| (link.name.clone(), i)).collect(),
            builder,
            source: (source, arguments.copy()?.unbind()),
            scalar: options::scalar(arguments)?,
            machine_code,
            functions: Function::ALL.iter().map(|_| OnceLock::new()).collect(),
            fused,
            changes: Mutex::default(),
            parameters,
            array_codes: Mutex::default(),
            kept: PyDict::new(py).unbind(),
            modules,
            model,
        })
    }

    /// Returns the shapes of the description, for pictures; none if it cannot be read again.
    pub fn shapes(&self) -> Shapes {
        let Source { text, file, .. } = &self.source.0;
        let options = ReadOptions { shapes: true, ..self.builder.read_options().clone() };
        modyn_codegen::read(text, file, &options).map(|reading| reading.shapes).unwrap_or_default()
    }

    /// Calls the function with this index in the table.
    ///
    /// # Errors
    ///
    /// If the robot does not have the function, or an argument does not fit.
    pub fn call<'py>(
        &self,
        py: Python<'py>,
        function: usize,
        arguments: &[Option<&Bound<'py, PyAny>>],
        link: Option<&Bound<'py, PyAny>>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let function = self.function(py, function)?;
        let link = link.map(|link| self.link(link)).transpose()?;
        function.call(py, link, arguments, out)
    }

    /// Returns the index of the link of this name.
    fn link_named(&self, name: &str) -> PyResult<usize> {
        self.links.get(name).copied().ok_or_else(|| {
            let names = self.model.links().iter().map(|link| link.name.as_str());
            let help = match suggest(name, names) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => "`link_names` has all links".into(),
            };
            PyValueError::new_err(format!("there is no link `{name}`; {help}"))
        })
    }

    /// Returns the index of a link, given by its name or index.
    ///
    /// # Errors
    ///
    /// `ValueError` if there is no such link, `TypeError` if it is neither.
    pub fn link(&self, link: &Bound<'_, PyAny>) -> PyResult<usize> {
        if let Ok(name) = link.cast::<PyString>() {
            return self.link_named(name.to_str()?);
        }
        let index: usize = link.extract().map_err(|_| {
            PyTypeError::new_err("`link` must be the name of a link or its index in `link_names`")
        })?;
        let count = self.model.links().len();
        if index < count {
            return Ok(index);
        }
        Err(PyValueError::new_err(format!("there is no link {index}; the robot has {count} links")))
    }

    /// Returns a function of the table, which is compiled if this is its first use.
    fn function(&self, py: Python<'_>, index: usize) -> PyResult<&dyn RobotFunction> {
        let slot = &self.functions[index];
        if let Some(function) = slot.get() {
            return Ok(&**function);
        }
        let function = Function::ALL[index];
        self.check_has(function)?;
        self.compiled(py, self.builder.clone().functions([function]), Some(function), slot)
    }

    /// Checks that the robot has a function.
    ///
    /// # Errors
    ///
    /// `ValueError`, which names the robots that have it, or a joint that moves no inertia.
    pub fn check_has(&self, function: Function) -> PyResult<()> {
        if function.fits(&Sizes::new(&self.model, 0)) {
            let joint = self.without_inertia.as_ref().filter(|_| function.row().needs_inertia);
            let message = |joint| {
                format!(
                    "`{}` needs inertia, and joint `{joint}` moves none, since its link has none: \
                     the robot has kinematic \
                     functions alone; write the `<inertial>` of the link, or give the joint an armature, \
                     `armature={{\"{joint}\": 1}}`",
                    function.name()
                )
            };
            return joint.map_or(Ok(()), |joint| Err(PyValueError::new_err(message(joint))));
        }
        let row = function.row();
        let robots = if row.of_actuators {
            "robots with actuators (the option `actuators`, or the `<actuator>` of an MJCF)"
        } else if row.of_touching_shapes {
            "robots with shapes that touch the ground (the options `contacts` and `ground`, or \
             planes of an MJCF or an SDF)"
        } else {
            "robots with closed loops or contacts (the options `loops` and `contacts`)"
        };
        let message = format!("only {robots} have the function `{}`", function.name());
        Err(PyValueError::new_err(message))
    }

    /// Compiles the function of a builder; a function of the table that is too long is computed by
    /// the interpreter. Python's lock is held, so that no process is forked meanwhile.
    fn compiled<'s>(
        &self,
        py: Python<'_>,
        builder: Builder,
        function: Option<Function>,
        slot: &'s Slot,
    ) -> PyResult<&'s dyn RobotFunction> {
        let planning = match (builder.plan(), function) {
            (Ok(planning), _) => planning,
            (Err(errors), Some(function)) if errors.iter().all(|e| e.code == Code::TooLarge) => {
                let message = format!(
                    "`{}` of {} joints is too long for machine code; it is interpreted, which is slow",
                    function.name(),
                    self.model.moving_links().len()
                );
                warn_of_machine_code(py, &message)?;
                let function = function::interpreted(function, self.interpreter()?, self.scalar);
                return Ok(&**slot.get_or_init(|| function));
            }
            (Err(errors), _) => return Err(description_error(py, &errors)),
        };
        let (function, reason) = function::compiled(planning, self.scalar, self.machine_code)
            .ok_or_else(|| PyValueError::new_err("the robot does not have this function"))?;
        for change in &*self.changes.lock().unwrap_or_else(PoisonError::into_inner) {
            function.apply(change, &self.model).map_err(PyValueError::new_err)?;
        }
        if let Some(reason) = reason {
            let message = format!("functions are evaluated, which is slow: {reason}");
            warn_of_machine_code(py, &message)?;
        }
        Ok(&**slot.get_or_init(|| function))
    }

    /// Applies a change of the run-time parameters to all functions.
    fn change(&self, py: Python<'_>, change: Change) -> PyResult<()> {
        // The interpreter refuses inertias that no rigid body has, also where no function has
        // machine code.
        change.set(&mut self.interpreter()?).map_err(PyValueError::new_err)?;
        // A function that depends on all parameters refuses those that the robot does not have.
        let first =
            Function::ALL.iter().position(|&function| function == Function::InverseDynamics);
        self.function(py, first.unwrap_or_default())?
            .apply(&change, &self.model)
            .map_err(PyValueError::new_err)?;
        let fused = self.fused.iter().map(|fused| &fused.slot);
        for function in self.functions.iter().chain(fused).filter_map(OnceLock::get) {
            function.apply(&change, &self.model).map_err(PyValueError::new_err)?;
        }
        self.changes.lock().unwrap_or_else(PoisonError::into_inner).push(change);
        Ok(())
    }

    /// Returns the interpreter of the robot with its present parameters.
    pub fn interpreter(&self) -> PyResult<Interpreter<f64>> {
        let modules = self.modules.clone();
        let created = Interpreter::with_modules(self.model.clone(), modules);
        let mut interpreter = created.map_err(|error| PyValueError::new_err(error.to_string()))?;
        for change in &*self.changes.lock().unwrap_or_else(PoisonError::into_inner) {
            change.set(&mut interpreter).map_err(PyValueError::new_err)?;
        }
        Ok(interpreter)
    }

    /// Returns the present inertial parameters of all moving links.
    fn present_parameters(&self) -> PyResult<Vec<f64>> {
        let interpreter = self.interpreter()?;
        let links = 0..self.model.moving_links().len();
        Ok(links.filter_map(|link| interpreter.inertial_parameters(link)).flatten().collect())
    }

    /// Returns these parameters, which are the description's, with the robot's changes.
    ///
    /// # Errors
    ///
    /// If a change is of another parameter.
    pub fn changed<S: Number>(
        &self,
        parameters: &ParameterNumbers<S>,
    ) -> PyResult<ParameterNumbers<S>> {
        let mut changed = parameters.clone();
        for change in &*self.changes.lock().unwrap_or_else(PoisonError::into_inner) {
            changed.apply(change, &self.model).map_err(PyValueError::new_err)?;
        }
        Ok(changed)
    }

    /// Returns the builder of the robot, without functions.
    pub fn builder(&self) -> &Builder {
        &self.builder
    }

    /// Returns the scalar of arguments and results.
    pub fn scalar(&self) -> FloatType {
        self.scalar
    }

    /// Returns whether functions are compiled to machine code.
    pub fn has_machine_code(&self) -> bool {
        self.machine_code
    }

    /// Returns the number of the numbers of all run-time parameters.
    pub fn parameter_count(&self) -> usize {
        self.parameters.len()
    }

    /// Returns the run-time parameters in the order of their numbers: the option, the link and the
    /// present numbers of each.
    ///
    /// # Errors
    ///
    /// If a change is of another parameter.
    pub fn run_time_parameters(&self) -> PyResult<Vec<RunTimeParameter<'_>>> {
        let described = ParameterNumbers::of(&self.parameters, self.model.gravity());
        let numbers = self.changed::<f64>(&described)?;
        let Parameters { gravity, inertias, payloads, .. } = &self.parameters;
        let name = |link: usize| Some(self.model.links()[link].name.as_str());
        let gravity = gravity.then_some(("gravity", None, 3));
        let inertias = inertias.iter().map(|(link, _)| ("inertia", name(*link), 10));
        let payloads = payloads.iter().map(|link| ("payload", name(*link), 10));
        let mut rest = numbers.as_slice();
        let mut next = |count: usize| {
            let (first, others) = rest.split_at(count);
            rest = others;
            first.to_vec()
        };
        let all = gravity.into_iter().chain(inertias).chain(payloads);
        Ok(all.map(|(option, link, count)| (option, link, next(count))).collect())
    }

    /// Returns the fused functions.
    pub fn fused_functions(&self) -> impl Iterator<Item = &FusedFunction> {
        self.fused.iter().map(|fused| &fused.function)
    }

    /// Returns the fused function of this name.
    pub fn fused_named(&self, name: &str) -> Option<&Fused> {
        self.fused.iter().find(|fused| fused.name == name)
    }

    /// Returns the robot.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Returns the kinematic modules.
    pub fn modules(&self) -> &ModuleTree {
        &self.modules
    }

    /// Returns the numbers of the joints that have coordinates of their own, one for each entry.
    fn entries(
        &self,
        count: fn(&MovingLink) -> usize,
        number: impl Fn(usize, &MovingLink) -> f64,
    ) -> Vec<f64> {
        let links = self.model.moving_links().iter().enumerate();
        let independent = links.filter(|(_, link)| link.joint.mimic.is_none());
        independent.flat_map(|(i, link)| vec![number(i, link); count(link)]).collect()
    }
}

/// Returns the argument `name` of `function` as a vector.
fn vector<const N: usize>(
    function: &str,
    name: &str,
    object: &Bound<'_, PyAny>,
) -> PyResult<[f64; N]> {
    let array = in_order::<f64>(function, name, object)?;
    if array.shape() != [N] {
        let given_shape = tuple(array.shape());
        let expected = tuple(&[N]);
        let entries = match (name, N) {
            ("inertia", 6) => ": ixx, ixy, ixz, iyy, iyz, izz",
            _ => "",
        };
        return Err(PyValueError::new_err(format!(
            "`{name}` of `{function}` has the shape {given_shape}; expected {expected}{entries}"
        )));
    }
    let mut vector = [0.0; N];
    vector.copy_from_slice(&array.to_vec()?);
    Ok(vector)
}

impl Robot {
    /// Returns coordinates as an array of the robot's numbers.
    fn coordinates<'py>(&self, py: Python<'py>, q: Vec<f64>) -> Bound<'py, PyAny> {
        match self.scalar {
            FloatType::F64 => PyArray1::from_vec(py, q).into_any(),
            FloatType::F32 => PyArray1::from_iter(py, q.into_iter().map(|x| x as f32)).into_any(),
        }
    }

    /// Returns a keyframe as a `Keyframe` of the package, with the scalars of the robot.
    fn keyframe_of<'py>(
        &self,
        py: Python<'py>,
        keyframe: &Keyframe,
    ) -> PyResult<Bound<'py, PyAny>> {
        let full = |numbers: &[f64], count: usize| match numbers {
            [] => vec![0.0; count],
            numbers => numbers.to_vec(),
        };
        let actuation = self.model.actuation();
        let all = [
            keyframe.q.clone(),
            full(&keyframe.qd, self.model.nv()),
            full(&keyframe.ctrl, actuation.actuators.len()),
            full(&keyframe.act, actuation.states()),
        ];
        let arrays = all.map(|numbers| self.coordinates(py, numbers));
        py.import("modyn._types")?.getattr("Keyframe")?.call1(PyTuple::new(py, arrays)?)
    }
}

#[pymethods]
impl Robot {
    /// What the package keeps of the robot: signatures and functions of arrays.
    #[getter]
    fn _kept<'py>(&self, py: Python<'py>) -> Bound<'py, PyDict> {
        self.kept.bind(py).clone()
    }

    /// Shows Python's garbage collector what is kept, which refers to the robot.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.kept)
    }

    /// The robot's name in its description.
    #[getter]
    fn name(&self) -> &str {
        self.model.name()
    }

    /// The type of the numbers in arguments and results: `float64`, or `float32` with the option
    /// `scalar="f32"`.
    #[getter]
    fn dtype<'py>(&self, py: Python<'py>) -> Bound<'py, PyArrayDescr> {
        match self.scalar {
            FloatType::F64 => numpy::dtype::<f64>(py),
            FloatType::F32 => numpy::dtype::<f32>(py),
        }
    }

    /// The length of the coordinate vector `q`.
    #[getter]
    fn nq(&self) -> usize {
        self.model.nq()
    }

    /// The length of the velocity vector `qd`: the number of degrees of freedom.
    #[getter]
    fn nv(&self) -> usize {
        self.model.nv()
    }

    /// The names of the moving joints, depth first, including mimic joints.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.model.moving_links().iter().map(|link| link.joint.name.as_str()).collect()
    }

    /// The names of all links of the description, in its order.
    #[getter]
    fn link_names(&self) -> Vec<&str> {
        self.model.links().iter().map(|link| link.name.as_str()).collect()
    }

    /// The name of each entry of `q`: the joint's name, and the component for joints with several
    /// coordinates.
    #[getter]
    fn coordinate_names(&self) -> Vec<String> {
        self.model.coordinate_names()
    }

    /// The name of each entry of `qd`.
    #[getter]
    fn velocity_names(&self) -> Vec<String> {
        self.model.velocity_names()
    }

    /// The names of the joints that close loops, in the description's order.
    #[getter]
    fn loop_constraint_names(&self) -> Vec<&str> {
        self.model.loop_constraints().iter().map(|constraint| constraint.name.as_str()).collect()
    }

    /// The names of the contacts, in the order of the option.
    #[getter]
    fn contact_names(&self) -> Vec<&str> {
        self.model.contacts().iter().map(|contact| contact.name.as_str()).collect()
    }

    /// The names of the controls of `actuate`: of the actuators.
    #[getter]
    fn control_names(&self) -> Vec<&str> {
        self.model.control_names()
    }

    /// The names of the activations of `actuate`: of the actuators that have a state. An actuator with
    /// a delay has the controls that do not act yet.
    #[getter]
    fn activation_names(&self) -> Vec<String> {
        self.model.activation_names()
    }

    /// The ranges of the controls, (controls, 2); -inf and inf for a control without a range.
    #[getter]
    fn control_ranges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let actuators = self.model.actuation().actuators.iter();
        let unlimited = [f64::NEG_INFINITY, f64::INFINITY];
        let ranges: Vec<f64> =
            actuators.flat_map(|actuator| actuator.control_range.unwrap_or(unlimited)).collect();
        PyArray1::from_vec(py, ranges).reshape([self.model.actuation().actuators.len(), 2])
    }

    /// The names of the shapes that touch the ground in a `step`: the contacts if there are any,
    /// else the shapes of the description.
    #[getter]
    fn touching_shape_names(&self) -> Vec<String> {
        self.model.touching_shapes().into_iter().map(|shape| shape.name).collect()
    }

    /// Returns the settings of `step` by the description, to be changed: `StepSettings`, with the
    /// surface of each of `touching_shape_names`.
    fn step_settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let types = py.import("modyn._types")?;
        let settings = self.model.step_settings();
        let surface = |surface: &ContactSurface<f64>| {
            let keywords = PyDict::new(py);
            keywords.set_item("rotation", surface.plane.rotation)?;
            keywords.set_item("translation", surface.plane.translation)?;
            keywords.set_item("radius", surface.radius)?;
            keywords.set_item("friction", surface.friction)?;
            keywords.set_item("torsional_friction", surface.torsional_friction)?;
            keywords.set_item("rolling_friction", surface.rolling_friction)?;
            keywords.set_item("margin", surface.margin)?;
            keywords.set_item("solref", surface.solref)?;
            keywords.set_item("solimp", surface.solimp)?;
            types.getattr("ContactSurface")?.call((), Some(&keywords))
        };
        let surfaces: Vec<Bound<'py, PyAny>> =
            settings.surfaces.iter().map(surface).collect::<PyResult<_>>()?;
        let keywords = PyDict::new(py);
        keywords.set_item("surfaces", surfaces)?;
        keywords.set_item("impratio", settings.impratio)?;
        types.getattr("StepSettings")?.call((), Some(&keywords))
    }

    /// The acceleration of free fall at present, in world axes, (3,), m/s^2: from the description,
    /// or from `set_gravity`.
    #[getter]
    fn gravity<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let changes = self.changes.lock().unwrap_or_else(PoisonError::into_inner);
        let last = changes.iter().rev().find_map(|change| match change {
            Change::Gravity(gravity) => Some(*gravity),
            _ => None,
        });
        PyArray1::from_slice(py, &last.unwrap_or(self.model.gravity()))
    }

    /// The joint limits, infinite without a limit: `lower` and `upper` (nq,), rad or m; `velocity`
    /// (nv,), rad/s or m/s; `effort` (nv,), N m or N.
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let nq = |link: &MovingLink| link.joint.joint_type.nq();
        let nv = |link: &MovingLink| link.joint.joint_type.nv();
        let limits = |link: &MovingLink| link.joint.limits;
        let vectors = [
            self.entries(nq, |i, _| self.model.coordinate_range(i)[0]),
            self.entries(nq, |i, _| self.model.coordinate_range(i)[1]),
            self.entries(nv, |i, _| self.model.velocity_limit(i)),
            self.entries(nv, |_, link| {
                limits(link).and_then(|l| l.effort).unwrap_or(f64::INFINITY)
            }),
        ];
        let all = vectors.map(|numbers| PyArray1::from_vec(py, numbers));
        py.import("modyn._types")?.getattr("JointLimits")?.call1(PyTuple::new(py, all)?)
    }

    /// The joints with coordinates of their own: the name, the type and the entries of `q` and `qd`
    /// of each.
    #[getter]
    fn joints<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let class = py.import("modyn._types")?.getattr("Joint")?;
        // Without a step, as `slice(start, end)` has it.
        let slice = py.import("builtins")?.getattr("slice")?;
        let links = self.model.moving_links().iter().enumerate();
        let independent = links.filter(|(_, link)| link.joint.mimic.is_none());
        independent
            .map(|(i, link)| {
                let kind = link.joint.joint_type.name();
                let q = self.model.q_range(i);
                let v = self.model.v_range(i);
                let q = slice.call1((q.start, q.end))?;
                let v = slice.call1((v.start, v.end))?;
                class.call1((link.joint.name.as_str(), kind, q, v))
            })
            .collect()
    }

    /// Returns the mimic joints that follow others: the name of each, the entries of `q` and `qd`
    /// of its leader, and the multiplier and the offset of its coordinate. For `modyn.conventions`.
    fn _followers(&self) -> Vec<(&str, usize, usize, f64, f64)> {
        let links = self.model.moving_links().iter().enumerate();
        let followers = links.filter_map(|(i, link)| {
            let mimic = self.model.mimic(i)?;
            let q = self.model.q_range(i).start;
            let v = self.model.v_range(i).start;
            Some((link.joint.name.as_str(), q, v, mimic.multiplier, mimic.offset))
        });
        followers.collect()
    }

    /// The inertial parameters of the moving links at present, ten for each link, as in
    /// `regressor`: the description's parameters, with the changes of `set_inertia` and
    /// `set_payload`.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_vec(py, self.present_parameters()?))
    }

    /// Returns the base parameters: a smallest set of combinations of inertial parameters that
    /// determines all joint forces. `names` has each combination as text, `columns` the column of
    /// `regressor` of each, and `values` the present numbers. Finding them takes a while (Gautier
    /// 1991).
    fn base_parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let base = py.detach(|| BaseParameters::new(&self.model));
        let names: Vec<&str> = base.parameters.iter().map(BaseParameter::name).collect();
        let indices = base.regressor_columns().into_iter().map(|column| column as i64);
        let columns = PyArray1::from_iter(py, indices);
        let values = PyArray1::from_vec(py, base.values_of(&self.present_parameters()?));
        let class = py.import("modyn._types")?.getattr("BaseParameters")?;
        class.call1((names, columns, values))
    }

    /// The names of the fused functions, each of which is a method.
    #[getter]
    pub fn fused_names(&self) -> Vec<&str> {
        self.fused.iter().map(|fused| fused.name).collect()
    }

    /// Returns the neutral coordinates, (nq,): zero for every joint, the identity for quaternions.
    fn neutral<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut q = vec![0.0; self.model.nq()];
        let interpreter = Interpreter::<f64>::new(self.model.clone());
        interpreter.neutral(&mut q).map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(self.coordinates(py, q))
    }

    /// The keyframes of the description: named states, in its order.
    #[getter]
    fn keyframes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for keyframe in self.model.keyframes() {
            all.set_item(&keyframe.name, self.keyframe_of(py, keyframe)?)?;
        }
        Ok(all)
    }

    /// Returns the keyframe of this name: a `Keyframe`; `KeyError` names those that there are.
    fn keyframe<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let Some(keyframe) = self.model.keyframe(name) else {
            let known: Vec<&str> =
                self.model.keyframes().iter().map(|keyframe| keyframe.name.as_str()).collect();
            let message = match known.is_empty() {
                true => format!("no keyframe `{name}`: the description has none"),
                false => format!("no keyframe `{name}`; there are: {}", known.join(", ")),
            };
            return Err(PyKeyError::new_err(message));
        };
        self.keyframe_of(py, keyframe)
    }

    /// The time step of the description, s, such as `<option timestep>` of an MJCF; `None` without one.
    #[getter]
    fn time_step(&self) -> Option<f64> {
        self.model.time_step()
    }

    /// Checks that the quaternions of spherical and floating joints in `q`, (nq,), have length 1;
    /// `ValueError` names the first joint whose quaternion does not.
    fn check_configuration(&self, q: &Bound<'_, PyAny>) -> PyResult<()> {
        let q = Given::<f64>::read("check_configuration", "q", &[self.model.nq()], q)?;
        let interpreter = Interpreter::<f64>::new(self.model.clone());
        let checked = interpreter.check_configuration(q.as_slice()?);
        checked.map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// Sets gravity, the acceleration of free fall in world axes, (3,), m/s^2. Needs the option
    /// `runtime_gravity`.
    fn set_gravity(&self, py: Python<'_>, gravity: &Bound<'_, PyAny>) -> PyResult<()> {
        self.change(py, Change::Gravity(vector("set_gravity", "gravity", gravity)?))
    }

    /// Sets the inertia of a link, in its own frame, in place of the description's: the mass, kg;
    /// the centre of mass (3,), m; ixx, ixy, ixz, iyy, iyz, izz about the centre of mass, (6,), kg
    /// m^2. Needs the option `runtime_inertia`.
    fn set_inertia(
        &self,
        py: Python<'_>,
        link: String,
        mass: f64,
        center_of_mass: &Bound<'_, PyAny>,
        inertia: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        self.link_named(&link)?;
        let center_of_mass = vector("set_inertia", "center_of_mass", center_of_mass)?;
        let inertia = vector("set_inertia", "inertia", inertia)?;
        self.change(py, Change::Inertia(link, Inertial { mass, center_of_mass, inertia }))
    }

    /// Sets the payload of a link, in the link's frame: an inertia that is added to the link's,
    /// with the units of `set_inertia`. The default is a point mass at the link's origin. Needs the
    /// option `payload`.
    #[pyo3(signature = (link, mass, center_of_mass=None, inertia=None))]
    fn set_payload(
        &self,
        py: Python<'_>,
        link: String,
        mass: f64,
        center_of_mass: Option<&Bound<'_, PyAny>>,
        inertia: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        self.link_named(&link)?;
        let center_of_mass = center_of_mass
            .map_or(Ok([0.0; 3]), |center| vector("set_payload", "center_of_mass", center))?;
        let inertia =
            inertia.map_or(Ok([0.0; 6]), |inertia| vector("set_payload", "inertia", inertia))?;
        self.change(py, Change::Payload(link, Inertial { mass, center_of_mass, inertia }))
    }

    /// Calls a fused function by its name, with the arguments of all its functions by position or
    /// name.
    #[pyo3(signature = (name, *arguments, out=None, **named))]
    fn fused<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        arguments: &Bound<'py, PyTuple>,
        out: Option<&Bound<'py, PyAny>>,
        named: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let Some(Fused { function, slot, .. }) = self.fused_named(name) else {
            let names = self.fused_names().join(", ");
            let message = format!("there is no fused function `{name}`; there are: {names}");
            return Err(PyValueError::new_err(message));
        };
        let function = match slot.get() {
            Some(function) => &**function,
            None => {
                self.compiled(py, self.builder.clone().fused([function.clone()]), None, slot)?
            }
        };
        let parameters = function.arguments();
        let count = parameters.len();
        if arguments.len() > count {
            let message =
                format!("`{name}` takes {count} arguments, and {} were given", arguments.len());
            return Err(PyTypeError::new_err(message));
        }
        let mut given = Vec::with_capacity(count);
        let mut used = 0;
        for (i, (parameter, _)) in parameters.iter().enumerate() {
            let by_name = named.map(|named| named.get_item(parameter.name)).transpose()?.flatten();
            used += usize::from(by_name.is_some());
            let argument = match (arguments.get_item(i).ok(), by_name) {
                (Some(_), Some(_)) => {
                    let message = format!("`{name}` has the argument `{}` twice", parameter.name);
                    return Err(PyTypeError::new_err(message));
                }
                (by_place, by_name) => by_place.or(by_name),
            };
            given.push(argument);
        }
        if let Some(named) = named.filter(|named| named.len() > used) {
            let names: Vec<&str> = parameters.iter().map(|(parameter, _)| parameter.name).collect();
            let message = format!("`{name}` takes {}, not {}", names.join(", "), named.keys());
            return Err(PyTypeError::new_err(message));
        }
        let given: Vec<_> = given.iter().map(Option::as_ref).collect();
        function.call(py, None, &given, out)
    }

    /// Returns a fused function as a callable.
    fn __getattr__<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        if slf.get().fused_named(name).is_some() {
            let partial = slf.py().import("functools")?.getattr("partial")?;
            return partial.call1((slf.getattr("fused")?, name));
        }
        let class = slf.get_type();
        let names: Vec<String> = class.dir()?.extract()?;
        let help = match suggest(name, names.iter().map(String::as_str)) {
            Some(meant) => format!("; did you mean `{meant}`?"),
            None => String::new(),
        };
        Err(PyAttributeError::new_err(format!("`Robot` has no attribute `{name}`{help}")))
    }

    /// Returns the names of attributes, fused functions included.
    fn __dir__(slf: &Bound<'_, Self>) -> PyResult<Vec<String>> {
        let mut names: Vec<String> = slf.get_type().dir()?.extract()?;
        names.extend(slf.get().fused.iter().map(|fused| fused.name.to_owned()));
        Ok(names)
    }

    fn __repr__(&self) -> String {
        let name = self.model.name();
        let nq = self.model.nq();
        let nv = self.model.nv();
        format!("<modyn.Robot '{name}', nq = {nq}, nv = {nv}>")
    }

    /// Pickles the description with the options and the present parameters; machine code is made
    /// again.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let robot = slf.get();
        let (Source { text, file, folder }, options) = &robot.source;
        let changes = robot.changes.lock().unwrap_or_else(PoisonError::into_inner);
        let calls = changes.iter().map(|change| match change {
            Change::Gravity(gravity) => ("set_gravity", (*gravity,)).into_pyobject(py),
            Change::Inertia(link, Inertial { mass, center_of_mass, inertia }) => {
                ("set_inertia", (link, *mass, *center_of_mass, *inertia)).into_pyobject(py)
            }
            Change::Payload(link, Inertial { mass, center_of_mass, inertia }) => {
                ("set_payload", (link, *mass, *center_of_mass, *inertia)).into_pyobject(py)
            }
        });
        let changes = calls.collect::<PyResult<Vec<_>>>()?;
        let restore = py.import("modyn")?.getattr("_restore")?;
        (restore, (text, file, folder, options, changes)).into_pyobject(py)
    }
}
