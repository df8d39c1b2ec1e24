//! The reference data of `golden/`: see the README there.

use std::fs;
use std::path::{Path, PathBuf};

use modyn_codegen::urdf::{Mimic, ReadOptions, read};
use modyn_runtime::model::Model;
use nalgebra::DMatrix;
use serde_json::Value;

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

/// A robot, with its quantities at a few states.
pub struct Golden {
    /// The robot.
    pub model: Model,
    /// The states.
    pub states: Vec<Quantities>,
}

/// What is known at one state, in the order of the model's joints.
pub struct Quantities {
    state: Value,
    /// For each of the model's joints, where the file has it.
    order: Vec<usize>,
}

/// A frame's placement.
pub struct Placement {
    /// The frame's name.
    pub name: String,
    /// The rotation by rows, then the translation.
    pub numbers: Vec<f64>,
}

/// The robot `name` as its URDF has it; joints that mimic another are independent.
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
    /// Reads the robot `name` on a fixed base and its quantities.
    ///
    /// # Panics
    ///
    /// If a file cannot be read, or if the two do not have the same joints.
    #[must_use]
    pub fn load(name: &str) -> Self {
        let data: Value = serde_json::from_str(&text(&file(name, "json")))
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(data["floating_base"], Value::Bool(false), "{name}");
        let model = model(&urdf(name));
        let joints: Vec<&str> =
            list(&data["joint_order"]).iter().filter_map(Value::as_str).collect();
        assert_eq!(joints.len(), model.nv(), "{name}: joints");
        let find = |joint: &str| joints.iter().position(|&other| other == joint);
        let order = model.links().iter().map(|link| {
            find(&link.joint.name).unwrap_or_else(|| panic!("{name}: no `{}`", link.joint.name))
        });
        let order: Vec<usize> = order.collect();
        assert_eq!(numbers(&data["gravity"]), model.gravity(), "{name}: gravity");
        let states = list(&data["states"]).iter().cloned();
        let states = states.map(|state| Quantities { state, order: order.clone() }).collect();
        Self { model, states }
    }
}

impl Quantities {
    /// The positions.
    #[must_use]
    pub fn q(&self) -> Vec<f64> {
        self.vector("q_angle")
    }

    /// The vector of that name, one number a joint.
    #[must_use]
    pub fn vector(&self, name: &str) -> Vec<f64> {
        let all = numbers(self.get(name));
        assert_eq!(all.len(), self.order.len(), "`{name}`");
        self.order.iter().map(|&k| all[k]).collect()
    }

    /// The square matrix of that name, a row and a column a joint.
    #[must_use]
    pub fn matrix(&self, name: &str) -> DMatrix<f64> {
        let rows: Vec<Vec<f64>> = list(self.get(name)).iter().map(numbers).collect();
        let n = self.order.len();
        assert!(rows.len() == n && rows.iter().all(|row| row.len() == n), "`{name}`");
        DMatrix::from_fn(n, n, |i, j| rows[self.order[i]][self.order[j]])
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
            Placement { name: name.clone(), numbers: rows }
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
