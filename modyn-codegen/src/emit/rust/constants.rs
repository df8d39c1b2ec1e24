//! The constants of a generated type.

use std::fmt::Write as _;

use modyn_runtime::OperationCount;
use modyn_runtime::model::{Keyframe, MovingLink};

use super::Robot;
use crate::names;
use crate::plan::{BaseParameterTable, Constants};

impl Robot<'_> {
    /// Prints the type's constants.
    pub(super) fn constants(&self, text: &mut String, operations: &[(&str, OperationCount)]) {
        let name = self.name;
        let model = self.model;
        let nq = model.nq();
        let nv = model.nv();
        let float = self.options.scalar.name();
        let joints = self.joint_names();
        let link_names = self.link_names();
        let Constants { neutral, link_parents, inertial_parameters, base_parameters } =
            self.constants;
        let parent = |parent: &Option<usize>| format!("::core::option::Option::{parent:?}");
        let link_parents: Vec<String> = link_parents.iter().map(parent).collect();
        let links = link_names.len();
        let link_parents = link_parents.join(", ");
        let quaternions: Vec<(&str, usize)> = model.quaternions().collect();
        let _ = writeln!(
            text,
            "impl {name} {{\n\
             /// The robot's name in its description.\n\
             pub const NAME: &'static str = {:?};\n\
             /// nq, the length of the coordinate vector `q`.\n\
             pub const NQ: usize = {nq};\n\
             /// nv, the length of the velocity vector `qd`: the number of degrees of freedom.\n\
             pub const NV: usize = {nv};\n\
             /// The names of the moving joints, depth first, including mimic joints.\n\
             pub const JOINT_NAMES: [&'static str; {}] = {joints:?};\n\
             /// The names of all links of the description, in its order.\n\
             pub const LINK_NAMES: [&'static str; {links}] = {link_names:?};\n\
             /// For each link of `LINK_NAMES`, the index there of its parent: for a moving link, \
             the moving link that its\n\
             /// joint is on; for a link that is fixed to a moving link, that link. `None` is the world.\n\
             pub const LINK_PARENTS: [::core::option::Option<usize>; {links}] = [{link_parents}];\n\
             /// The name of each entry of `q`: the joint's name, and the component for joints \
             with several coordinates.\n\
             pub const COORDINATE_NAMES: [&'static str; {nq}] = {:?};\n\
             /// The name of each entry of `qd`.\n\
             pub const VELOCITY_NAMES: [&'static str; {nv}] = {:?};\n\
             /// The quaternions in `q`, which must have length 1: each joint's name, and the \
             index in `q` of the quaternion's\n\
             /// x.\n\
             pub const QUATERNIONS: [(&'static str, usize); {}] = {quaternions:?};\n\
             /// The neutral coordinates: zero for every joint, the identity for quaternions.\n\
             pub const NEUTRAL: [{float}; {nq}] = {neutral:?};\n\
             /// The inertial parameters of the moving links, ten for each link, as in `regressor`.\n\
             pub const PARAMETERS: [f64; {}] = {inertial_parameters:?};\n\
             /// The acceleration of free fall in world axes, m/s^2.\n\
             pub const GRAVITY: [f64; 3] = {:?};",
            model.name(),
            joints.len(),
            model.coordinate_names(),
            model.velocity_names(),
            quaternions.len(),
            inertial_parameters.len(),
            model.gravity(),
        );
        let loop_constraints: Vec<&str> =
            model.loop_constraints().iter().map(|c| c.name.as_str()).collect();
        if !loop_constraints.is_empty() {
            let _ = writeln!(
                text,
                "/// The joints that close loops, in the description's order.\n\
                 pub const LOOP_CONSTRAINT_NAMES: [&'static str; {}] = {loop_constraints:?};",
                loop_constraints.len()
            );
        }
        let contacts = self.contact_names();
        if !contacts.is_empty() {
            let _ = writeln!(
                text,
                "/// The names of the contacts: frames of links that can touch the world.\n\
                 pub const CONTACT_NAMES: [&'static str; {}] = {contacts:?};",
                contacts.len()
            );
        }
        let shapes = model.touching_shapes();
        if !shapes.is_empty() {
            let names: Vec<&str> = shapes.iter().map(|shape| shape.name.as_str()).collect();
            let _ = writeln!(
                text,
                "/// The names of the shapes that touch the ground in a step.\n\
                 pub const TOUCHING_SHAPE_NAMES: [&'static str; {}] = {names:?};",
                names.len()
            );
        }
        let states = model.activation_names();
        let lists = [
            (
                model.control_names(),
                "CONTROL_NAMES",
                "The names of the controls: of the actuators.",
            ),
            (
                states.iter().map(String::as_str).collect(),
                "ACTIVATION_NAMES",
                "The names of the activations: of the actuators that have a state.",
            ),
        ];
        for (names, constant, docs) in lists {
            if !names.is_empty() {
                let _ = writeln!(
                    text,
                    "/// {docs}\npub const {constant}: [&'static str; {}] = {names:?};",
                    names.len()
                );
            }
        }
        self.keyframes(text);
        if let Some(time_step) = self.model.time_step() {
            let float = self.options.scalar.name();
            let _ = writeln!(
                text,
                "/// The time step of the description, s.\npub const TIME_STEP: {float} = {time_step:?};"
            );
        }
        self.limits(text);
        if let Some(base) = base_parameters {
            print_base_parameters(text, base);
        }
        self.module_table(text);
        for (quantity, count) in operations {
            let OperationCount { multiplications, additions, divisions, sin_cos, others } = count;
            let _ = writeln!(
                text,
                "/// The operations of a call of `{quantity}`; for a function of one link, those \
                 of the most expensive link.\n\
                 pub const {}_OPERATIONS: __modyn::OperationCount = __modyn::OperationCount {{ \
                 multiplications: {multiplications}, \
                 additions: {additions}, divisions: {divisions}, sin_cos: {sin_cos}, others: {others} }};",
                quantity.to_uppercase()
            );
        }
        text.push_str("}\n\n");
    }

    /// Prints the keyframes: a constant of its name for each, constants for its velocities, controls
    /// and activations that are not zero, and a table of all.
    fn keyframes(&self, text: &mut String) {
        let nq = self.model.nq();
        let float = self.options.scalar.name();
        let keyframes = self.model.keyframes();
        if keyframes.is_empty() {
            return;
        }
        let mut table = String::new();
        for Keyframe { name: keyframe, q, qd, ctrl, act } in keyframes {
            let mut print = |what: &str, ending: &str, numbers: &[f64]| {
                let name = constant_name(&format!("{keyframe}{ending}"), text);
                let _ = writeln!(
                    text,
                    "/// The {what} of the keyframe {keyframe:?}.\n\
                     pub const {name}: [{float}; {}] = {numbers:?};",
                    numbers.len()
                );
                name
            };
            table += &format!("({keyframe:?}, Self::{}), ", print("coordinates", "", q));
            for (what, ending, numbers) in [
                ("velocities", "_qd", qd),
                ("controls", "_ctrl", ctrl),
                ("activations", "_act", act),
            ] {
                if !numbers.is_empty() {
                    print(what, ending, numbers);
                }
            }
        }
        let _ = writeln!(
            text,
            "/// The keyframes, by name: named coordinates of the description.\n\
             pub const KEYFRAMES: [(&'static str, [{float}; {nq}]); {}] = [{table}];",
            keyframes.len()
        );
    }

    fn module_table(&self, text: &mut String) {
        let joints = self.joint_names();
        let _ = writeln!(
            text,
            "/// The kinematic modules, parents before children.\n\
             pub const MODULES: [__modyn::KinematicModule; {}] = [",
            self.modules.modules().len()
        );
        for (module, block) in self.modules.modules().iter().zip(self.plan.layout.blocks()) {
            let range = module.links.clone();
            let link_names: Vec<&str> =
                self.model.moving_links()[range.clone()].iter().map(|l| l.name.as_str()).collect();
            let _ = writeln!(
                text,
                "__modyn::KinematicModule {{ parent: ::core::option::Option::{:?}, children: &{:?}, \
                 links: &{link_names:?}, joints: &{:?}, first: {}, dofs: {} }},",
                module.parent,
                module.children,
                &joints[range],
                block.dofs.start,
                block.dofs.len(),
            );
        }
        text.push_str("];\n");
    }

    /// Prints limits, armature, damping and friction, by coordinate or velocity.
    fn limits(&self, text: &mut String) {
        let independent = || {
            let links = self.model.moving_links().iter().enumerate();
            links.filter(|(_, link)| link.joint.mimic.is_none())
        };
        let list = |length: fn(&MovingLink) -> usize,
                    number: &dyn Fn(usize, &MovingLink) -> f64| {
            let numbers: Vec<String> = independent()
                .flat_map(|(i, link)| std::iter::repeat_n(number(i, link), length(link)))
                .map(|x| match x {
                    x if x == f64::INFINITY => "f64::INFINITY".into(),
                    x if x == f64::NEG_INFINITY => "f64::NEG_INFINITY".into(),
                    x => format!("{x:?}"),
                })
                .collect();
            numbers.join(", ")
        };
        let limit = |link: &MovingLink, pick: fn(&modyn_runtime::model::Limits) -> Option<f64>| {
            link.joint.limits.as_ref().and_then(pick)
        };
        let nq = |link: &MovingLink| link.joint.joint_type.nq();
        let nv = |link: &MovingLink| link.joint.joint_type.nv();
        let _ = writeln!(
            text,
            "/// The joint limits of the description; infinite without a limit.\n\
             pub const LIMITS: __modyn::JointLimits<'static> = __modyn::JointLimits {{\n\
             lower: &[{}],\nupper: &[{}],\nvelocity: &[{}],\neffort: &[{}],\n}};\n\
             /// The armature (rotor inertia) at each degree of freedom, kg m^2 or kg; part of the dynamics.\n\
             pub const ARMATURE: [f64; {n}] = [{}];\n\
             /// The description's viscous damping, N m s/rad or N s/m. It acts if the option\n\
             /// `joint_friction` enables it.\n\
             pub const DAMPING: [f64; {n}] = [{}];\n\
             /// The description's Coulomb friction, N m or N. It acts if the option\n\
             /// `joint_friction` enables it.\n\
             pub const FRICTION: [f64; {n}] = [{}];",
            list(nq, &|i, _| self.model.coordinate_range(i)[0]),
            list(nq, &|i, _| self.model.coordinate_range(i)[1]),
            list(nv, &|i, _| self.model.velocity_limit(i)),
            list(nv, &|_, link| limit(link, |l| l.effort).unwrap_or(f64::INFINITY)),
            list(nv, &|_, link| link.joint.dynamics.armature),
            list(nv, &|_, link| link.joint.dynamics.damping),
            list(nv, &|_, link| link.joint.dynamics.friction),
            n = self.model.nv(),
        );
    }
}

/// Returns the name of the constant of a keyframe: its name in capitals, with an ending if the type
/// has another constant of the name. `text` has the constants so far.
fn constant_name(keyframe: &str, text: &str) -> String {
    /// Constants that follow the keyframes' constants in the text.
    const LATER: &[&str] = &[
        "ARMATURE",
        "BASE_COLUMNS",
        "BASE_PARAMETERS",
        "BASE_PARAMETER_NAMES",
        "DAMPING",
        "FRICTION",
        "KEYFRAMES",
        "LIMITS",
        "MODULES",
        "TIME_STEP",
    ];
    let constant = names::snake(keyframe).to_ascii_uppercase();
    let is_taken = |name: &str| {
        LATER.contains(&name)
            || name.ends_with("_OPERATIONS")
            || text.contains(&format!("pub const {name}: "))
    };
    let numbered = (2..).map(|n| format!("{constant}_KEYFRAME_{n}"));
    let mut all = [constant.clone(), format!("{constant}_KEYFRAME")].into_iter().chain(numbered);
    all.find(|name| !is_taken(name)).unwrap_or_default()
}

/// Prints the base parameters.
fn print_base_parameters(text: &mut String, base: &BaseParameterTable) {
    let BaseParameterTable { values, columns, names } = base;
    let _ = writeln!(
        text,
        "/// The base parameters, a minimal set of combinations of `PARAMETERS` that determines all joint forces:\n\
         /// tau is the sum of the base parameters times the columns `BASE_COLUMNS` of `regressor`.\n\
         pub const BASE_PARAMETERS: [f64; {n}] = {values:?};\n\
         /// The columns of `regressor` that belong to `BASE_PARAMETERS`.\n\
         pub const BASE_COLUMNS: [usize; {n}] = {columns:?};\n\
         /// The combinations of `BASE_PARAMETERS`, as text.\n\
         pub const BASE_PARAMETER_NAMES: [&'static str; {n}] = {names:?};",
        n = names.len(),
    );
}
