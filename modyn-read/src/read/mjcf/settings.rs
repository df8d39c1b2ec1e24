//! The settings of `<compiler>` and `<option>`.

use modyn_runtime::model::Cone;

use super::check::{filled, list, numbers};
use super::element::{Attribute, Element};
use crate::diagnostics::{Code, Report};

/// The least positive number by which MuJoCo divides, its `mjMINVAL`.
pub const LEAST: f64 = 1e-15;

/// The settings of a model; the last of repeated attributes counts.
pub struct Settings<'e> {
    /// The factor of angles to rad.
    pub angle: f64,
    /// The axes of Euler angles.
    pub euler: [u8; 3],
    pub autolimits: bool,
    /// Whether geoms replace an `<inertial>`, or never have an inertia; `None`: they have one
    /// without an `<inertial>`.
    pub inertia_from_geom: Option<bool>,
    /// The lowest and highest group of geoms that have a mass.
    pub inertia_groups: [f64; 2],
    pub bound_mass: f64,
    pub bound_inertia: f64,
    pub balance_inertia: bool,
    /// The mass of the model, to which all masses and inertias are scaled; `None` if it is not
    /// positive.
    pub total_mass: Option<f64>,
    /// Whether a geom that is fitted to a mesh has its bounding box.
    pub fit_box: bool,
    /// Whether frames of free bodies are aligned if their joint does not say so.
    pub align_free: bool,
    /// The folder of meshes, relative to the model's folder.
    pub mesh_folder: &'e str,
    /// Whether only the last part of a mesh's path counts.
    pub strip_path: bool,
    pub gravity: [f64; 3],
    /// The groups of actuators that do not act.
    pub disabled_groups: Vec<f64>,
    pub flags: Flags,
    /// The cone of contacts' forces.
    pub cone: Cone,
    /// How many times stiffer friction is than the normal direction.
    pub impratio: Option<f64>,
    /// The time step, s.
    pub time_step: f64,
    /// Whether geoms touch each other.
    pub contacts: bool,
    /// Whether limits stop joints.
    pub limits: bool,
    /// The integrator, and the place of its name; `None`: MuJoCo's default, `Euler`.
    pub integrator: Option<&'e Attribute>,
    /// Whether the dampers of joints are implicit by `Euler`.
    pub implicit_euler: bool,
    /// The options that change MuJoCo's steps, and have no effect in `step`.
    pub ignored: Vec<&'e Attribute>,
    /// What replaces the parameters of all contacts.
    pub overriding: Option<ContactOverride>,
}

/// The switches that change MuJoCo's steps and have no effect in `step`, each with its position in
/// which it does.
/// `MuJoCo`'s time step of an MJCF without one, s.
const TIME_STEP: f64 = 0.002;

const IGNORED_SWITCHES: [(&str, &str); 3] =
    [("refsafe", "disable"), ("diagexact", "enable"), ("ipc", "enable")];

/// The parameters that all contacts have instead of their own, in the order of their attributes.
#[derive(Clone, Copy)]
pub struct ContactOverride {
    pub friction: [f64; 5],
    pub margin: f64,
    pub reference: [f64; 2],
    pub impedance: [f64; 5],
}

/// `MuJoCo`'s default of `solref`.
pub const REFERENCE: [f64; 2] = [0.02, 1.0];

/// `MuJoCo`'s default of `solimp`.
pub const IMPEDANCE: [f64; 5] = [0.9, 0.95, 0.001, 0.5, 2.0];

impl ContactOverride {
    /// Returns the parameters that are in the options `o_friction` and so on.
    fn read(option: impl Fn(&'static str) -> Option<Vec<f64>>) -> Self {
        Self {
            friction: filled(option("o_friction").as_deref(), [1.0, 1.0, 0.005, 0.0001, 0.0001]),
            margin: filled(option("o_margin").as_deref(), [0.0])[0],
            reference: filled(option("o_solref").as_deref(), REFERENCE),
            impedance: filled(option("o_solimp").as_deref(), IMPEDANCE),
        }
    }
}

/// The switches of `<flag>`.
#[derive(Clone, Copy)]
pub struct Flags {
    /// Whether springs exert forces.
    pub springs: bool,
    /// Whether damping acts.
    pub dampers: bool,
    /// Whether the friction loss of joints and tendons acts.
    pub friction: bool,
    /// Whether constraints of `<equality>` hold.
    pub equality: bool,
    /// Whether actuators exert forces.
    pub actuation: bool,
    /// Whether controls are clamped to their ranges.
    pub clamps_controls: bool,
}

impl Flags {
    /// Returns whether passive forces other than springs and dampers act: gravity compensation, and
    /// forces of fluids.
    pub fn is_passive(&self) -> bool {
        self.springs || self.dampers
    }
}

impl<'e> Settings<'e> {
    /// Returns the settings of the model whose root element is `root`; their errors are in the
    /// report.
    pub fn new(root: &'e Element, report: &mut Report<'_>) -> Self {
        let last = |section: &'e str, name: &str| {
            root.named(section).filter_map(|section| section.attribute(name)).last()
        };
        let text = |name| last("compiler", name).map(|attribute| attribute.value.as_str());
        let number = |name| text(name).and_then(numbers::<1>).map(|[number]| number);
        let flag = |name| text(name).map(|value| value == "true");
        let switch = |name| {
            let flags = root.in_sections("option").filter(|child| child.name == "flag");
            flags.filter_map(|flag| flag.attribute(name)).last()
        };
        let is_set = |name, position| switch(name).is_some_and(|flag| flag.value == position);
        let disabled = |name| is_set(name, "disable");
        let noslip = last("option", "noslip_iterations")
            .filter(|attribute| numbers(&attribute.value).is_some_and(|[count]| count > 0.0));
        let switches = IGNORED_SWITCHES.iter();
        let ignored = switches.filter(|(name, position)| is_set(name, position));
        let option = |name| last("option", name).map(|attribute| attribute.value.as_str());
        let impratio = option("impratio").and_then(numbers).map(|[ratio]| ratio);
        if let Some(ratio) = impratio.filter(|ratio| *ratio <= 0.0) {
            let message = format!("`impratio` is {ratio}, which is not above 0");
            let at = last("option", "impratio").map_or(root.at, |attribute| attribute.at);
            report.error(Code::NotRead, at, None, message, "write 1, or a larger number");
        }
        let time_step = option("timestep").and_then(numbers).map(|[step]| step);
        if let Some(step) = time_step.filter(|step| *step <= 0.0) {
            let message = format!("`timestep` is {step}, which is not above 0");
            let at = last("option", "timestep").map_or(root.at, |attribute| attribute.at);
            report.error(Code::BadNumber, at, None, message, "write a time in s, such as 0.002");
        }
        let euler = last("compiler", "eulerseq").map_or(Some(*b"xyz"), |attribute| {
            let letters = <[u8; 3]>::try_from(attribute.value.as_bytes()).ok();
            let axes =
                letters.filter(|letters| letters.iter().all(|letter| b"xyzXYZ".contains(letter)));
            if axes.is_none() {
                let message =
                    format!("`eulerseq=\"{}\"` of `<compiler>` is not read", attribute.value);
                let help = "write three of the letters x, y, z, X, Y and Z";
                report.error(Code::NotRead, attribute.at, None, message, help);
            }
            axes
        });
        let gravity = last("option", "gravity").and_then(|attribute| numbers(&attribute.value));
        Self {
            angle: if text("angle") == Some("radian") {
                1.0
            } else {
                core::f64::consts::PI / 180.0
            },
            euler: euler.unwrap_or(*b"xyz"),
            autolimits: flag("autolimits").unwrap_or(true),
            inertia_from_geom: text("inertiafromgeom")
                .filter(|value| *value != "auto")
                .map(|value| value == "true"),
            inertia_groups: text("inertiagrouprange").and_then(numbers).unwrap_or([0.0, 5.0]),
            bound_mass: number("boundmass").unwrap_or(0.0),
            bound_inertia: number("boundinertia").unwrap_or(0.0),
            balance_inertia: flag("balanceinertia").unwrap_or(false),
            total_mass: number("settotalmass").filter(|mass| *mass > 0.0),
            fit_box: flag("fitaabb").unwrap_or(false),
            align_free: flag("alignfree").unwrap_or(false),
            mesh_folder: text("meshdir").or_else(|| text("assetdir")).unwrap_or(""),
            strip_path: flag("strippath").unwrap_or(false),
            gravity: if disabled("gravity") {
                [0.0; 3]
            } else {
                gravity.unwrap_or([0.0, 0.0, -9.81])
            },
            disabled_groups: last("option", "actuatorgroupdisable")
                .and_then(|attribute| list(&attribute.value))
                .unwrap_or_default(),
            // MuJoCo before 3.4 has one switch of springs and dampers.
            flags: Flags {
                springs: !disabled("spring") && !disabled("passive"),
                dampers: !disabled("damper") && !disabled("passive"),
                friction: !disabled("frictionloss") && !disabled("constraint"),
                equality: !disabled("equality") && !disabled("constraint"),
                actuation: !disabled("actuation"),
                clamps_controls: !disabled("clampctrl"),
            },
            cone: match option("cone") {
                Some("elliptic") => Cone::Elliptic,
                _ => Cone::Pyramidal,
            },
            impratio: impratio.filter(|ratio| *ratio > 0.0),
            time_step: time_step.filter(|step| *step > 0.0).unwrap_or(TIME_STEP),
            contacts: !disabled("contact") && !disabled("constraint"),
            limits: !disabled("limit") && !disabled("constraint"),
            integrator: last("option", "integrator"),
            implicit_euler: !disabled("eulerdamp"),
            ignored: noslip
                .into_iter()
                .chain(ignored.filter_map(|(name, _)| switch(name)))
                .collect(),
            overriding: is_set("override", "enable")
                .then(|| ContactOverride::read(|name| option(name).and_then(list))),
        }
    }
}
