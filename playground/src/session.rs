//! The files, the robot and its motion, and the answers to requests about them.

use std::path::{Path, PathBuf};

use modyn_cli::contact_steps::GroundPoint;
use modyn_cli::loops::closed_start;
use modyn_cli::picture::{Sparsity, draw};
use modyn_cli::report::{render, verdict};
use modyn_cli::viewer::Scene;
use modyn_codegen::diagnostics::{Diagnostic, Diagnostics, Severity, sanitize_for_display};
use modyn_codegen::options::Value as OptionText;
use modyn_codegen::{
    Builder, FileStore, Format, Function, ReadOptions, Reading, Target, joints_without_inertia,
};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Model, ModuleTree};
use serde_json::{Value, json};

use crate::motion::{Motion, MotionOptions};

/// The files that were given, and the robot that was read.
///
/// ```
/// let mut session = modyn_playground::Session::default();
/// let urdf = include_bytes!("../../robots/double_pendulum.urdf");
/// session.answer(r#"{"do": "put", "file": "double_pendulum.urdf"}"#, urdf);
/// let answer = session.answer(r#"{"do": "read", "file": "double_pendulum.urdf"}"#, &[]);
/// assert!(answer.contains(r#""usable":true"#));
/// let cost = session.answer(r#"{"do": "cost", "function": "forward_dynamics"}"#, &[]);
/// assert!(cost.contains(r#""multiplications":"#));
/// ```
#[derive(Default)]
pub struct Session {
    files: Vec<(PathBuf, Vec<u8>)>,
    robot: Option<Robot>,
    motion: Option<Motion>,
}

/// A robot that was read.
struct Robot {
    name: String,
    text: String,
    /// The files that the description can name.
    files: FileStore,
    /// The description with its options.
    builder: Builder,
    model: Model,
    /// The data of the viewer, JSON.
    scene: String,
}

/// The fault of a request, or the reason why it has no answer.
type Answer = Result<Value, String>;

/// Returns a text of a request.
fn text<'r>(request: &'r Value, name: &str) -> Result<&'r str, String> {
    request[name].as_str().ok_or_else(|| format!("the request has no text `{name}`"))
}

impl Session {
    /// Returns the answer to a request, as JSON.
    ///
    /// The request is a JSON object whose `do` is one of
    ///
    /// - `clear`: forgets all files;
    /// - `put`: takes the bytes as the content of `file`, a path;
    /// - `read`: reads the description `file` with `options`, an object of the texts of options;
    /// - `scene`: returns the data of the viewer;
    /// - `modules`: returns a picture of the modules, SVG;
    /// - `cost`: returns the operations of a call of `function`;
    /// - `text`: returns the files that are generated for `functions` in the language `target`;
    /// - `start`: puts the robot at rest at `q`, with the choices `friction`, `limits` and `hold`;
    /// - `step`: makes `count` steps of `dt` seconds.
    ///
    /// An answer that has `error` says what is wrong.
    pub fn answer(&mut self, request: &str, bytes: &[u8]) -> String {
        let answer = serde_json::from_str(request)
            .map_err(|error| format!("the request is no JSON: {error}"))
            .and_then(|request: Value| {
                if request["do"] == "scene" {
                    return Ok(self.robot()?.scene.clone());
                }
                self.answer_of(&request, bytes).map(|answer| answer.to_string())
            });
        answer.unwrap_or_else(|error| json!({ "error": error }).to_string())
    }

    fn answer_of(&mut self, request: &Value, bytes: &[u8]) -> Answer {
        match text(request, "do")? {
            "clear" => {
                *self = Self::default();
                Ok(json!({}))
            }
            "put" => {
                let path = PathBuf::from(text(request, "file")?);
                self.files.retain(|(file_name, _)| *file_name != path);
                self.files.push((path, bytes.to_vec()));
                Ok(json!({}))
            }
            "read" => self.read(request),
            "modules" => {
                let robot = self.robot()?;
                let modules = ModuleTree::chains(&robot.model);
                let sparsity = Sparsity::of(&robot.model, &modules)?;
                Ok(json!({ "svg": draw(&robot.model, &modules, &sparsity) }))
            }
            "cost" => self.robot()?.cost(text(request, "function")?),
            "text" => self.robot()?.text(text(request, "target")?, text(request, "functions")?),
            "start" => {
                let array = request["q"].as_array().map(Vec::as_slice).unwrap_or_default();
                let q: Vec<f64> = array.iter().map(|x| x.as_f64().unwrap_or(f64::NAN)).collect();
                let options = MotionOptions {
                    friction: request["friction"].as_f64(),
                    limits: request["limits"] == true,
                    hold: request["hold"] == true,
                };
                let motion = Motion::new(self.movable()?, &q, options)?;
                self.motion = Some(motion);
                self.moved()
            }
            "step" => {
                let positive = request["dt"].as_f64().filter(|dt| *dt > 0.0);
                let dt = positive.ok_or("the request has no time step `dt`")?;
                let motion = self.motion.as_mut().ok_or("the motion has not been started")?;
                for _ in 0..request["count"].as_u64().unwrap_or(1) {
                    motion.step(dt)?;
                }
                self.moved()
            }
            other => Err(format!("there is no request `{}`", sanitize_for_display(other))),
        }
    }

    fn robot(&self) -> Result<&Robot, String> {
        self.robot.as_ref().ok_or_else(|| "no robot has been read".into())
    }

    /// Returns the model of a robot that has dynamics.
    fn movable(&self) -> Result<&Model, String> {
        let model = &self.robot()?.model;
        match joints_without_inertia(model).first() {
            None => Ok(model),
            Some(&joint) => Err(format!(
                "the robot has no dynamics: joint `{}` moves no inertia",
                sanitize_for_display(&model.moving_links()[joint].joint.name)
            )),
        }
    }

    fn moved(&self) -> Answer {
        let motion = self.motion.as_ref().ok_or("the motion has not been started")?;
        let numbers = || motion.points.iter().flat_map(GroundPoint::numbers).collect::<Vec<_>>();
        let forces = (!motion.points.is_empty()).then(numbers);
        Ok(json!({ "q": motion.q, "time": motion.time, "forces": forces }))
    }

    fn read(&mut self, request: &Value) -> Answer {
        (self.robot, self.motion) = (None, None);
        let name = text(request, "file")?;
        let file = self.files.iter().find(|(path, _)| path == Path::new(name));
        let (_, bytes) = file.ok_or_else(|| format!("there is no file `{name}`"))?;
        let files = FileStore::in_memory(self.files.iter().cloned());
        let text = match String::from_utf8(bytes.clone()) {
            Ok(text) => text,
            Err(error) => {
                let diagnostics = modyn_codegen::read::file::not_text(name, &error);
                return Ok(refused(name, "", &files, &diagnostics));
            }
        };
        let folder = Path::new(name).parent().unwrap_or(Path::new(""));
        let mut builder = Builder::new().text(&*text, name).folder(folder).files(files.clone());
        for (option, value) in request["options"].as_object().into_iter().flatten() {
            let value = value.as_str().unwrap_or_default().trim();
            if value.is_empty() {
                continue;
            }
            let set = OptionText::parse(value).and_then(|value| builder.set(option, &value));
            builder = set.map_err(|fault| format!("the option `{option}`: {}", fault.message))?;
        }
        let read = |builder: &Builder| {
            let options = ReadOptions { shapes: true, ..builder.read_options().clone() };
            modyn_codegen::read(&text, name, &options)
        };
        let reading = match read(&builder) {
            Ok(reading) => reading,
            Err(diagnostics) => return Ok(refused(name, &text, &files, &diagnostics)),
        };
        // A robot that floats without contacts would fall forever.
        let contacts = tips(&reading.model);
        let with_contacts = OptionText::parse(&contacts)
            .and_then(|value| builder.clone().set("contacts", &value))
            .ok()
            .filter(|_| !contacts.is_empty());
        let better = with_contacts.and_then(|builder| Some((read(&builder).ok()?, builder)));
        let (reading, contacts) = match better {
            Some((better, standing)) => {
                builder = standing;
                (better, contacts)
            }
            None => (reading, String::new()),
        };
        let Reading { model, warnings, shapes, .. } = reading;
        let has_loops = !model.loop_constraints().is_empty();
        let closed = has_loops.then(|| closed_start(&model)).flatten();
        let single = Function::ALL.iter().filter(|one| one.batched().is_none());
        let functions: Vec<_> = single
            .map(|one| {
                let row = one.row();
                let summary = row.docs.split(". ").next().unwrap_or_default();
                json!({ "name": one.name(), "docs": summary, "default": row.default })
            })
            .collect();
        let mut answer = report(name, true, &text, &files, &warnings);
        answer["robot"] = json!({
            "name": model.name(),
            "format": Format::of(&text, name).name(),
            "links": model.moving_links().len(),
            "nq": model.nq(),
            "nv": model.nv(),
            "mass": model.moving_links().iter().map(|link| link.inertial.mass).sum::<f64>(),
            "contacts": model.contacts().len(),
            "loops": model.loop_constraints().len(),
            "chosen_contacts": contacts,
            "rest": closed,
            "notes": shapes.notes,
            "functions": functions,
        });
        let mut scene = Scene::new(model.name());
        scene.robot(model.clone(), shapes);
        let scene = scene.data();
        let name = name.to_owned();
        self.robot = Some(Robot { name, text, files, builder, model, scene });
        Ok(answer)
    }
}

impl Robot {
    /// Returns the operations of a call of a function, or the reason why the robot does not have
    /// it.
    fn cost(&self, function: &str) -> Answer {
        let known = Function::from_name(function);
        let named = known.ok_or_else(|| format!("there is no function `{function}`"))?;
        let plan = self.builder.clone().functions([named]).plan();
        let planning = plan.map_err(|diagnostics| first(&diagnostics))?;
        let counts = planning.plan.operations_per_call();
        let (_, count) = counts.first().ok_or("the robot does not have it")?;
        Ok(json!({
            "multiplications": count.multiplications,
            "additions": count.additions,
            "divisions": count.divisions,
            "sin_cos": count.sin_cos,
            "total": count.total(),
        }))
    }

    /// Returns the generated files of functions in a language.
    fn text(&self, target: &str, functions: &str) -> Answer {
        let wanted = Target::ALL.into_iter().find(|one| one.name() == target);
        let target = wanted.ok_or("there is no such language")?;
        let value = OptionText::parse(functions).map_err(|fault| fault.message)?;
        let builder = self.builder.clone().set("functions", &value);
        let emitted = match builder.map_err(|fault| fault.message)?.emit(target) {
            Ok(emitted) => emitted,
            Err(diagnostics) => {
                return Ok(refused(&self.name, &self.text, &self.files, &diagnostics));
            }
        };
        let emitted_files = emitted.files.iter();
        let files: Vec<_> =
            emitted_files.map(|file| json!({ "name": file.name, "text": file.text })).collect();
        Ok(json!({ "files": files }))
    }
}

/// Returns the first error.
fn first(diagnostics: &Diagnostics) -> String {
    let error = diagnostics.iter().find(|one| one.severity == Severity::Error);
    error.map_or_else(|| diagnostics.to_string(), |one| one.message.clone())
}

/// Returns the answer about a description with errors.
fn refused(name: &str, text: &str, files: &FileStore, diagnostics: &Diagnostics) -> Value {
    report(name, false, text, files, diagnostics.as_slice())
}

/// Returns what `modyn check` prints, and the place of each diagnostic.
fn report(
    name: &str,
    is_usable: bool,
    text: &str,
    files: &FileStore,
    diagnostics: &[Diagnostic],
) -> Value {
    let shown = render(diagnostics, Some((name, text)), |file| files.text(Path::new(file)));
    let place = |one: &Diagnostic| {
        json!({
            "file": one.file,
            "line": one.position.map(|at| at.line),
            "is_error": one.severity == Severity::Error,
            "code": one.code.name(),
        })
    };
    json!({
        "usable": is_usable,
        "report": shown + &verdict(name, is_usable, diagnostics),
        "diagnostics": diagnostics.iter().map(place).collect::<Vec<_>>(),
    })
}

/// Returns contacts of a floating robot that has none, as the option has them: the frame of each
/// last link that is farthest from the link's origin, such as a foot. Empty for another robot.
fn tips(model: &Model) -> String {
    let floats =
        model.moving_links().iter().any(|link| link.joint.joint_type == JointType::Floating);
    if !floats || !model.contacts().is_empty() {
        return String::new();
    }
    let children = model.children();
    let leaves = (0..model.moving_links().len()).filter(|&link| children[link].is_empty());
    let tip = |link: usize| {
        let distance = |frame: &&modyn_runtime::model::Link| {
            frame.pose.translation.iter().map(|x| x * x).sum::<f64>()
        };
        let tips_of_link = model.links().iter().filter(|frame| frame.moving_link == Some(link));
        tips_of_link.max_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let tips = leaves.filter_map(tip).map(|frame| format!("{0:?}: point({0:?})", frame.name));
    tips.collect::<Vec<_>>().join(", ")
}
