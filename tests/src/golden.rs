//! The reference data of `golden/`: see the README there.

use std::fs;
use std::path::{Path, PathBuf};

use modyn_codegen::{Mimic, ReadOptions, read};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Inertial, Model};
use nalgebra::DMatrix;
use serde_json::Value;

use crate::floating::floated;

/// The robots on a fixed base.
pub const FIXED_BASE: [&str; 7] = [
    "double_pendulum",
    "double_pendulum_continuous",
    "ur5",
    "panda",
    "panda_fingers",
    "solo12",
    "g1",
];

/// Robots on a floating base.
pub const FLOATING_BASE: [&str; 2] = ["solo12_ff", "g1_ff"];

/// A robot, with its quantities at a few states.
pub struct Golden {
    /// The robot.
    pub model: Model,
    /// The states.
    pub states: Vec<Quantities>,
}

/// What is known at one state, in the order of the model's joint vectors.
pub struct Quantities {
    state: Value,
    /// How many coordinates a floating base has in front of the joints.
    base: usize,
    /// For each of the model's joints of one coordinate, where the file has it.
    joints: Vec<usize>,
    /// For each of the model's velocities, where the file has it.
    order: Vec<usize>,
}

/// A frame's placement.
pub struct Placement {
    /// The frame's name.
    pub name: String,
    /// The rotation by rows, then the translation.
    pub numbers: Vec<f64>,
    /// From velocities to that of the frame's origin: linear rows, then angular ones, world axes.
    pub jacobian: DMatrix<f64>,
}

/// The robot of a URDF; joints that mimic another are independent.
///
/// # Panics
///
/// If it cannot be read.
#[must_use]
pub fn model(path: &Path) -> Model {
    let text = text(path);
    let options = ReadOptions { mimic: Mimic::Independent, ..ReadOptions::default() };
    read(&text, &path.to_string_lossy(), &options)
        .unwrap_or_else(|errors| panic!("{}: {errors}", path.display()))
        .model
}

/// The URDF `name` of the reference data.
#[must_use]
pub fn urdf(name: &str) -> PathBuf {
    file(name, "urdf")
}

fn file(name: &str, extension: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("golden").join(name).with_extension(extension)
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

impl Golden {
    /// Reads the robot `name` and its quantities; on a floating base where the name ends in `_ff`.
    ///
    /// # Panics
    ///
    /// If a file cannot be read, or if the two do not have the same joints.
    #[must_use]
    pub fn load(name: &str) -> Self {
        let data: Value = serde_json::from_str(&text(&file(name, "json")))
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let fixed = name.strip_suffix("_ff");
        assert_eq!(data["floating_base"], Value::Bool(fixed.is_some()), "{name}");
        let model = model(&urdf(fixed.unwrap_or(name)));
        let model = if fixed.is_some() { floated(&model, Inertial::default()) } else { model };
        assert_eq!(numbers(&data["gravity"]), model.gravity(), "{name}: gravity");

        let floats = |joint: JointType| joint == JointType::Floating;
        let (bases, links): (Vec<_>, Vec<_>) =
            model.links().iter().partition(|link| floats(link.joint.joint_type));
        let names = list(&data["joint_order"]).iter().filter_map(Value::as_str);
        let names: Vec<&str> = names.skip(bases.len()).collect();
        assert_eq!(names.len(), links.len(), "{name}: joints");
        let find = |joint: &str| names.iter().position(|&other| other == joint);
        let joints = links.iter().map(|link| {
            find(&link.joint.name).unwrap_or_else(|| panic!("{name}: no `{}`", link.joint.name))
        });
        let joints: Vec<usize> = joints.collect();
        let [base, velocities] =
            [JointType::nq, JointType::nv].map(|count| bases.len() * count(JointType::Floating));
        let behind = joints.iter().map(|joint| velocities + joint);
        let order: Vec<usize> = (0..velocities).chain(behind).collect();
        let states = list(&data["states"]).iter().cloned().map(|state| {
            let (joints, order) = (joints.clone(), order.clone());
            Quantities { state, base, joints, order }
        });
        Self { states: states.collect(), model }
    }
}

impl Quantities {
    /// The coordinates.
    #[must_use]
    pub fn q(&self) -> Vec<f64> {
        let mut q = numbers(self.get("q"));
        q.truncate(self.base);
        let angles = numbers(self.get("q_angle"));
        assert_eq!(angles.len(), self.joints.len(), "`q_angle`");
        q.extend(self.joints.iter().map(|&k| angles[k]));
        q
    }

    /// The vector of that name, one number a velocity.
    #[must_use]
    pub fn vector(&self, name: &str) -> Vec<f64> {
        let all = numbers(self.get(name));
        assert_eq!(all.len(), self.order.len(), "`{name}`");
        self.order.iter().map(|&k| all[k]).collect()
    }

    /// The square matrix of that name, a row and a column a velocity.
    #[must_use]
    pub fn matrix(&self, name: &str) -> DMatrix<f64> {
        let (matrix, n) = (matrix(self.get(name)), self.order.len());
        assert_eq!(matrix.shape(), (n, n), "`{name}`");
        matrix.select_rows(&self.order).select_columns(&self.order)
    }

    /// The number of that name.
    ///
    /// # Panics
    ///
    /// If there is none.
    #[must_use]
    pub fn number(&self, name: &str) -> f64 {
        number(self.get(name))
    }

    /// The placements of frames.
    #[must_use]
    pub fn frames(&self) -> Vec<Placement> {
        let frames = self.get("frames").as_object().expect("frames by name");
        let placement = |(name, frame): (&String, &Value)| {
            let mut rows: Vec<f64> = list(&frame["R"]).iter().flat_map(numbers).collect();
            rows.extend(numbers(&frame["p"]));
            let jacobian = matrix(&frame["J"]).select_columns(&self.order);
            Placement { name: name.clone(), numbers: rows, jacobian }
        };
        frames.iter().map(placement).collect()
    }

    fn get(&self, name: &str) -> &Value {
        self.state.get(name).unwrap_or_else(|| panic!("no `{name}` in the reference data"))
    }
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(number).collect()
}

/// A matrix of its rows.
fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = list(value).iter().map(numbers).collect();
    let columns = rows.first().map_or(0, Vec::len);
    assert!(rows.iter().all(|row| row.len() == columns), "rows of one length");
    DMatrix::from_row_iterator(rows.len(), columns, rows.concat())
}
