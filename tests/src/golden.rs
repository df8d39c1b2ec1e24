//! The reference data of `golden/`: see the README there.

use std::fs;
use std::path::{Path, PathBuf};

use modyn_codegen::{Mimic, ReadOptions, read};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Contact, ContactKind, Inertial, LoopConstraintEnd, Model};
use modyn_runtime::spatial::{Pose, Vector3, Wrench};
use nalgebra::DMatrix;
use serde_json::Value;

use crate::floating::floated;

/// The robots with a fixed base.
pub const FIXED_BASE: [&str; 7] = [
    "double_pendulum",
    "double_pendulum_continuous",
    "ur5",
    "panda",
    "panda_fingers",
    "solo12",
    "g1",
];

/// The robots with a floating base.
pub const FLOATING_BASE: [&str; 2] = ["solo12_ff", "g1_ff"];

/// Random trees in general position with planar, spherical, floating and universal joints inside.
pub const GENERAL_TREES: [&str; 3] = ["joints_floating", "joints_planar", "joints_spherical"];

/// The four-bar linkage in general position.
pub const PLANAR_LOOP: &str = "four_bar_general";

/// Mechanisms in general position with one closed spatial loop each.
pub const SPATIAL_LOOPS: [&str; 3] = ["loop_spherical", "loop_revolute", "loop_fixed"];

/// Floating robots with contacts: point feet in one file, two soles and a hand in the other.
pub const CONTACTS: [&str; 2] = ["contacts_solo12", "contacts_g1"];

/// A robot, with its quantities at several states.
pub struct Golden {
    /// The robot.
    pub model: Model,
    /// The states.
    pub states: Vec<Quantities>,
}

/// The reference quantities at one state, in the order of the model's joint vectors.
pub struct Quantities {
    state: Value,
    order: Order,
}

/// The order of the numbers in a file.
#[derive(Clone, Default)]
struct Order {
    /// For a robot in Pinocchio's coordinates: the number of coordinates of a floating base, which come first, and the
    /// index in the file of each joint with one coordinate. `None` if the file has the model's coordinates.
    joints: Option<(usize, Vec<usize>)>,
    /// The index in the file of each of the model's velocities.
    velocities: Vec<usize>,
    /// The index in the file's regressor of each of the model's moving links.
    links: Vec<usize>,
}

/// The placement of a frame.
pub struct Placement {
    /// The frame's name.
    pub name: String,
    /// The rotation by rows, then the translation.
    pub numbers: Vec<f64>,
    /// The Jacobian of the frame's origin: linear rows, then angular rows, in world axes.
    pub jacobian: DMatrix<f64>,
}

/// Returns the robot of a URDF; mimic joints are independent.
///
/// # Panics
///
/// Panics if the URDF cannot be read.
#[must_use]
pub fn model(path: &Path) -> Model {
    let text = text(path);
    let options = ReadOptions { mimic: Mimic::Independent, ..ReadOptions::default() };
    read(&text, &path.to_string_lossy(), &options)
        .unwrap_or_else(|errors| panic!("{}: {errors}", path.display()))
        .model
}

/// Returns the text of the URDF `name` of the reference data.
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
    /// Reads the robot `name` and its quantities. The base floats if the name ends in `_ff`, or the file has
    /// contacts.
    ///
    /// # Panics
    ///
    /// Panics if a file cannot be read, or if the two files have different joints.
    #[must_use]
    pub fn load(name: &str) -> Self {
        let data: Value = serde_json::from_str(&text(&file(name, "json")))
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let contacts = data.get("contacts");
        let floats = name.ends_with("_ff") || contacts.is_some();
        assert_eq!(data["floating_base"], Value::Bool(floats), "{name}");
        let source = data["urdf"].as_str().expect("the name of a URDF");
        let model = model(&urdf(source.trim_end_matches(".urdf")));
        let model = if floats { floated(&model, Inertial::default()) } else { model };
        let model = contacts.map_or(model.clone(), |contacts| with_contacts(model, contacts));
        assert_eq!(numbers(&data["gravity"]), model.gravity(), "{name}: gravity");

        let order = if data["coordinates"] == "modyn" {
            let same = |n: usize| (0..n).collect();
            Order {
                joints: None,
                velocities: same(model.nv()),
                links: same(model.moving_links().len()),
            }
        } else {
            Order::by_name(&data, &model)
        };
        let states = list(&data["states"]).iter().cloned();
        let states = states.map(|state| Quantities { state, order: order.clone() }).collect();
        Self { model, states }
    }
}

impl Order {
    /// Returns Pinocchio's order, in which joints are sorted by name.
    fn by_name(data: &Value, model: &Model) -> Self {
        let floats = |joint: JointType| joint == JointType::Floating;
        let (bases, links): (Vec<_>, Vec<_>) =
            model.moving_links().iter().partition(|link| floats(link.joint.joint_type));
        let names = list(&data["joint_order"]).iter().filter_map(Value::as_str);
        let names: Vec<&str> = names.skip(bases.len()).collect();
        assert_eq!(names.len(), links.len(), "{}: joints", model.name());
        let find = |joint: &str| names.iter().position(|&other| other == joint);
        let joints = links.iter().map(|link| {
            find(&link.joint.name).unwrap_or_else(|| panic!("no joint `{}`", link.joint.name))
        });
        let joints: Vec<usize> = joints.collect();
        let [base, velocities] =
            [JointType::nq, JointType::nv].map(|count| bases.len() * count(JointType::Floating));
        let after = |first: usize| {
            let places = joints.iter().map(move |joint| first + joint);
            (0..first).chain(places).collect()
        };
        let (velocities, links) = (after(velocities), after(bases.len()));
        Self { joints: Some((base, joints)), velocities, links }
    }
}

impl Quantities {
    /// Returns the coordinates.
    #[must_use]
    pub fn q(&self) -> Vec<f64> {
        let mut q = numbers(self.get("q"));
        if let Some((base, joints)) = &self.order.joints {
            q.truncate(*base);
            let angles = numbers(self.get("q_angle"));
            assert_eq!(angles.len(), joints.len(), "`q_angle`");
            q.extend(joints.iter().map(|&k| angles[k]));
        }
        q
    }

    /// Returns the vector with this name; one number for each velocity.
    #[must_use]
    pub fn vector(&self, name: &str) -> Vec<f64> {
        let all = numbers(self.get(name));
        assert_eq!(all.len(), self.order.velocities.len(), "`{name}`");
        self.order.velocities.iter().map(|&k| all[k]).collect()
    }

    /// Returns the square matrix with this name; a row and a column for each velocity.
    #[must_use]
    pub fn matrix(&self, name: &str) -> DMatrix<f64> {
        let (matrix, order) = (matrix(self.get(name)), &self.order.velocities);
        assert_eq!(matrix.shape(), (order.len(), order.len()), "`{name}`");
        matrix.select_rows(order).select_columns(order)
    }

    /// Returns the 3 numbers of a position.
    #[must_use]
    pub fn position(&self, name: &str) -> Vec<f64> {
        let position = numbers(self.get(name));
        assert_eq!(position.len(), 3, "`{name}`");
        position
    }

    /// Returns the momentum about the centre of mass: linear part, then angular part.
    #[must_use]
    pub fn centroidal_momentum(&self) -> Vec<f64> {
        let momentum = numbers(self.get("hg"));
        assert_eq!(momentum.len(), 6, "`hg`");
        momentum
    }

    /// Returns the centroidal momentum matrix: 3 linear rows, then 3 angular rows; a column for each velocity.
    #[must_use]
    pub fn centroidal_momentum_matrix(&self) -> DMatrix<f64> {
        let matrix = matrix(self.get("Ag")).select_columns(&self.order.velocities);
        assert_eq!(matrix.nrows(), 6, "`Ag`");
        matrix
    }

    /// Returns the regressor, a row for each velocity and ten columns for each moving link; some states have none.
    #[must_use]
    pub fn regressor(&self) -> Option<DMatrix<f64>> {
        let matrix = matrix(self.state.get("regressor")?);
        let Order { velocities, links, .. } = &self.order;
        assert_eq!(matrix.shape(), (velocities.len(), 10 * links.len()), "`regressor`");
        let columns: Vec<usize> =
            links.iter().flat_map(|link| 10 * link..10 * (link + 1)).collect();
        Some(matrix.select_rows(velocities).select_columns(&columns))
    }

    /// Returns the external wrenches on the links, in link axes at the links' origins, in the order of `model`'s frames;
    /// zero for a link that the file does not name.
    ///
    /// # Panics
    ///
    /// Panics if the file names a link that `model` does not have.
    #[must_use]
    pub fn wrenches(&self, model: &Model) -> Vec<Wrench<f64>> {
        let given = self.get("wrenches").as_object().expect("wrenches by link");
        let mut wrenches = vec![Wrench::zero(); model.links().len()];
        for (name, wrench) in given {
            let at = model.links().iter().position(|link| &link.name == name);
            let at = at.unwrap_or_else(|| panic!("no link `{name}`"));
            wrenches[at] = self::wrench(&numbers(wrench));
        }
        wrenches
    }

    /// Returns for each contact of `model` whether it is active.
    #[must_use]
    pub fn active(&self, model: &Model) -> Vec<bool> {
        let names = list(self.get("active"));
        model
            .contacts()
            .iter()
            .map(|contact| names.iter().any(|name| *name == contact.name))
            .collect()
    }

    /// Returns the wrenches with this name on the contacts of `model`; zero for a contact that is not active.
    #[must_use]
    pub fn contact_wrenches(&self, model: &Model, name: &str) -> Vec<Wrench<f64>> {
        let wrench = |found: Option<&Value>| {
            found.map_or_else(Wrench::zero, |found| wrench(&numbers(found)))
        };
        let found = self.get(name);
        model.contacts().iter().map(|contact| wrench(found.get(&contact.name))).collect()
    }

    /// Returns the derivatives with this name of the wrenches on the contacts of `model`: for each contact a wrench
    /// for each entry of the variable; zero for a contact that is not active.
    #[must_use]
    pub fn wrench_derivatives(&self, model: &Model, name: &str) -> Vec<Wrench<f64>> {
        let found = self.get(name);
        let of_contact = |contact: &Contact| match found.get(&contact.name) {
            None => vec![Wrench::zero(); model.nv()],
            Some(rows) => {
                let columns = matrix(rows).select_columns(&self.order.velocities);
                columns.column_iter().map(|column| wrench(column.as_slice())).collect()
            }
        };
        model.contacts().iter().flat_map(of_contact).collect()
    }

    /// Returns the number with this name.
    ///
    /// # Panics
    ///
    /// Panics if there is none.
    #[must_use]
    pub fn number(&self, name: &str) -> f64 {
        number(self.get(name))
    }

    /// Returns the placements of frames.
    #[must_use]
    pub fn frames(&self) -> Vec<Placement> {
        let frames = self.get("frames").as_object().expect("frames by name");
        let placement = |(name, frame): (&String, &Value)| {
            let mut rows: Vec<f64> = list(&frame["R"]).iter().flat_map(numbers).collect();
            rows.extend(numbers(&frame["p"]));
            let jacobian = matrix(&frame["J"]).select_columns(&self.order.velocities);
            Placement { name: name.clone(), numbers: rows, jacobian }
        };
        frames.iter().map(placement).collect()
    }

    fn get(&self, name: &str) -> &Value {
        self.state.get(name).unwrap_or_else(|| panic!("no `{name}` in the reference data"))
    }
}

/// Returns the robot with the contacts of a file.
fn with_contacts(model: Model, contacts: &Value) -> Model {
    let contact = |contact: &Value| {
        let text = |name: &str| contact[name].as_str().expect("a text");
        let three =
            |name: &str| <[f64; 3]>::try_from(numbers(&contact[name])).expect("three numbers");
        let frame = model.links().iter().position(|frame| frame.name == text("link"));
        Contact {
            name: text("name").into(),
            kind: ContactKind::from_name(text("kind")).expect("a kind of contact"),
            end: LoopConstraintEnd {
                link: frame.unwrap_or_else(|| panic!("no link `{}`", text("link"))),
                pose: Pose { rotation: roll_pitch_yaw(three("rpy")), translation: three("xyz") },
            },
        }
    };
    let contacts = list(contacts).iter().map(contact).collect();
    model.clone().with_contacts(contacts).unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// Returns the rotation matrix of roll, pitch and yaw, by rows.
fn roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> [[f64; 3]; 3] {
    let rotation = nalgebra::Rotation3::from_euler_angles(roll, pitch, yaw);
    core::array::from_fn(|i| core::array::from_fn(|j| rotation[(i, j)]))
}

/// Returns the wrench of a force, which may be followed by a moment.
fn wrench(numbers: &[f64]) -> Wrench<f64> {
    let three =
        |k: usize| Vector3(core::array::from_fn(|i| numbers.get(k + i).copied().unwrap_or(0.0)));
    assert!(matches!(numbers.len(), 3 | 6), "a force, or a force and a moment");
    Wrench { moment: three(3), force: three(0) }
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

/// Returns a matrix from its rows.
fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = list(value).iter().map(numbers).collect();
    let columns = rows.first().map_or(0, Vec::len);
    assert!(rows.iter().all(|row| row.len() == columns), "rows of one length");
    DMatrix::from_row_iterator(rows.len(), columns, rows.concat())
}
