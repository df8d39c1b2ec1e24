//! The table of options: all that the builder, the macro, the command line, the first lines of
//! generated files and `docs/command.md` know about each, in one row.
//!
//! A new option is a row in `option_table!`; one about reading has a field in [`ReadOptions`], too.

mod fused;
mod own_names;
mod renamed;
mod types;
pub(crate) mod user;
mod value;

pub use fused::FusedFunction;
pub(crate) use own_names::shared_names;
pub use renamed::{renamed_option, unknown_option};
pub use types::{Field, ModuleChoice, OptionValue};
pub use value::{OptionError, Value, ValueKind};

use modyn_read::ReadOptions;

use crate::FloatType;
use crate::plan::{CodeForm, Function, NamedFunction};

/// The part of modyn that an option is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Reading the description.
    Reading,
    /// The generated code.
    Code,
}

/// The entries that know an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entries {
    /// The builder, the command line and the macro.
    All,
    /// The builder and the command line. (The macro has other words for it, or makes no file.)
    Files,
}

/// A row of the table.
pub struct OptionRow {
    /// The name, the same at every entry. (A method of `Builder` that would be a keyword has an
    /// underscore after it.)
    pub name: &'static str,
    /// The method of `Builder`.
    pub method: &'static str,
    /// The form of the values.
    pub form: &'static str,
    /// The default.
    pub default: &'static str,
    /// A value, as the macro has it.
    pub example: &'static str,
    /// The documentation.
    pub docs: &'static str,
    /// The part of modyn that it is about.
    pub stage: Stage,
    /// The entries that know it.
    pub entries: Entries,
    /// Takes a value.
    set: fn(&mut Options, &Value) -> Result<(), OptionError>,
    /// The arguments of the method that sets it so; `None` for the default.
    arguments: fn(&Options) -> Option<String>,
}

impl OptionRow {
    /// Whether it is switched on by its name alone on the command line and in the builder.
    #[must_use]
    pub fn is_flag(&self) -> bool {
        self.form == "true | false"
    }

    /// Whether its value is a text that the command line takes as it stands, without quotes.
    #[must_use]
    pub fn is_text(&self) -> bool {
        matches!(self.form, "name" | "text" | "path" | "links")
    }

    /// Whether it can be given several times on the command line, an item each.
    #[must_use]
    pub fn is_list(&self) -> bool {
        self.form == "links" || self.form.ends_with(", ...]") && self.form.starts_with("[\"")
    }
}

/// Calls the macro `$callback` with all options: about reading, then about code.
///
/// A row starts with the documentation, the name and the method with its argument. The field
/// follows, with its type and how the method changes it. The form of values, the default and an
/// example end the row, and `Files` if the macro does not have the option.
macro_rules! option_table {
    ($callback:ident) => {
        $callback! {
            read {
                /// The acceleration of free fall in world axes, m/s^2; an MJCF or a model has its
                /// own.
                "gravity" gravity(gravity: [f64; 3])
                    gravity: Option<[f64; 3]>, field => *field = Some(gravity),
                    "[x, y, z]", "`[0.0, 0.0, -9.81]`, or the MJCF's or the model's own", "[0, 0, -1.62]";
                /// Whether the root link is fixed to the world or floats. With `auto`, a
                /// URDF's root link is fixed, and an SDF's floats unless a joint connects it to the
                /// world. In every format, `fixed` fixes what floats in the world by itself, where
                /// the file places it, and `floating` is an error if the robot floats already.
                "base" base(base: Base)
                    base: Base, field => *field = base,
                    "auto | fixed | floating", "`auto`", "floating";
                /// How joints that mimic another one are read: they follow it and have no
                /// coordinate of their own, have one, or are refused. Joints with a coordinate of
                /// their own are free; `<equality>` of an MJCF couples them in the function `step`,
                /// softly as in MuJoCo.
                "mimic" mimic(mimic: Mimic)
                    mimic: Mimic, field => *field = mimic,
                    "follow | independent | refuse", "`follow`", "independent";
                /// Armatures of joints: the inertia of the drive after the gear (kg m^2, or kg for
                /// a prismatic joint), in place of the description's. It acts in all dynamics.
                "armature" armature(armature: impl IntoIterator<Item = Armature>)
                    armature: Vec<Armature>, field => field.extend(armature),
                    "[\"joint\": inertia, ...]", "the description's", "[\"elbow\": 1.0]";
                /// Armatures of joints by their rotors: the inertia of each before the gear
                /// (kg m^2) and the gear ratio. The armature is the inertia times the square of
                /// the ratio.
                "rotors" rotors(rotors: impl IntoIterator<Item = Rotor>)
                    rotors: Vec<Rotor>, field => field.extend(rotors),
                    "[\"joint\": (inertia, gear_ratio), ...]", "the description's", "[\"elbow\": (0.0001, 100)]";
                /// Joints that close loops, besides the `<loop_joint>`s of the description: of type
                /// `spherical`, `fixed`, `revolute`, `continuous` or `prismatic`, the last three
                /// with an `axis` at the end. Roll, pitch and yaw, `[r, p, y]`, may follow each
                /// origin.
                "loops" loops(loops: impl IntoIterator<Item = Loop>)
                    loops: Vec<Loop>, field => field.extend(loops),
                    "[\"name\": type(\"link\", [x, y, z], \"link\", [x, y, z]), \
                     ...]", "the description's", "[\"pin\": revolute(\"rod\", [0.5, 0, 0], \
                                                  \"crank\", [0.4, 0, 0], axis = [0, 1, 0])]";
                /// Frames of links that can touch the world, besides the `<contact_frame>`s of the
                /// description: of type `point`, which stops the motion of the frame's origin, or
                /// `surface`, which stops rotations too. The frame's origin may follow the link,
                /// and its roll, pitch and yaw may follow the origin.
                "contacts" contacts(contacts: impl IntoIterator<Item = Contact>)
                    contacts: Vec<Contact>, field => field.extend(contacts),
                    "[\"name\": type(\"link\", [x, y, z]), \
                     ...]", "the description's", "[\"fingertip\": point(\"hand\", [0, 0, 0.2])]";
                /// The ground that collision shapes touch in the function `step`: a plane by a point
                /// (m) and the normal away from the ground, `plane` for z = 0. `friction = 0.8` at
                /// the end is the coefficient of all contacts, in place of the description's. If
                /// there are contacts, their points touch the plane, and shapes do not.
                "ground" ground(ground: Ground)
                    ground: Option<Ground>, field => *field = Some(ground),
                    "plane | plane([x, y, z], [nx, ny, nz])",
                    "the planes in the world of an SDF or an MJCF",
                    "plane([0, 0, 0.1], [0, 0, 1])";
                /// The actuators of joints, in the function `step_actuated`, by names in which `*`
                /// stands for any text: `position(kp, kd)` with the target position as its control,
                /// `velocity(kd)` with the target velocity, or `motor` with the force. `effort`
                /// (N m or N) at the end is the largest force; by default the effort limit of the
                /// description. `saturation` is the stall force of a torque-speed line, and
                /// `velocity` its no-load speed, by default the velocity limit. `delay` is the
                /// number of steps before a control acts. The option replaces the actuators of an
                /// MJCF.
                "actuators" actuators(actuators: impl IntoIterator<Item = JointActuator>)
                    actuators: Vec<JointActuator>, field => field.extend(actuators),
                    "[\"joint\": position(kp, kd), ...]",
                    "the description's",
                    "[\"elb*\": position(20, 0.5, effort = 23.5, saturation = 30, velocity = 25, delay = 2)]";
                /// The damping and friction of the description that act on the joints.
                "joint_friction" joint_friction(friction: JointFriction)
                    joint_friction: Option<JointFriction>, field => *field = Some(friction),
                    "none | viscous | coulomb | \
                     smooth(velocity)", "`none`, with a warning if there are some", "smooth(0.01)";
                /// How inertias that no rigid body has are reported. A negative mass is always an
                /// error.
                "unphysical_inertia" unphysical_inertia(severity: Severity)
                    unphysical_inertia: Severity, field => *field = severity,
                    "error | warn", "`error`", "warn";
                /// How forces of fluids, such as air, and of tendons in an MJCF are reported, which
                /// are not read. With a warning the robot is without them; springs and dampers of
                /// fixed tendons then act in the function `step` only.
                "unsupported_forces" unsupported_forces(severity: Severity)
                    unsupported_forces: Severity, field => *field = severity,
                    "error | warn", "`error`", "warn";
                /// The folders of ROS packages, which a description names in `$(find ...)` and
                /// `package://`. Packages in the folders above the description are found without
                /// this option, and so are packages in the folders of `ROS_PACKAGE_PATH` and
                /// `AMENT_PREFIX_PATH`.
                "packages" packages(packages: impl IntoIterator<Item = Package>)
                    packages: Vec<Package>, field => field.extend(packages),
                    "[\"name\": \"folder\", ...]", "found by their names", "[\"arm_description\": \"robots/arm\"]";
                /// The values of arguments of a xacro, `<xacro:arg>`, in place of their defaults.
                "xacro_args" xacro_args(arguments: impl IntoIterator<Item = XacroArg>)
                    xacro_args: Vec<XacroArg>, field => field.extend(arguments),
                    "[\"name\": \"value\", ...]", "the defaults of the xacro", "[\"prefix\": \"left_\"]";
            }
            code {
                /// The functions that the robot has; `default` and `all` stand for several. The
                /// dynamics of a large robot take seconds to compile; a function that is left out
                /// costs nothing.
                "functions" functions(functions: impl IntoIterator<Item = Function>)
                    functions: Option<Vec<Function>>, field => *field = Some(functions.into_iter().collect()),
                    "[name, ...]", "`default`", "[default, regressor]";
                /// Fused functions: each computes several functions in one call, with their common
                /// work done once. It has the arguments of all its functions; its result is a type
                /// with a field for each of them (`jacobian_hand`). Functions of one link are named
                /// with the link. In generated code, `name: batch(..)` makes the form for many
                /// states as well.
                "fused" fused(fused: impl IntoIterator<Item = FusedFunction>)
                    fused: Vec<FusedFunction>, field => field.extend(fused),
                    "[\"name\": (function, function(\"link\"), ...), \
                     ...]", "none", "[\"control\": (mass_matrix, bias_forces, jacobian(\"hand\"))]";
                /// The kinematic modules: maximal serial chains, links, or lists of link names,
                /// each from its parent outwards.
                "modules" modules(modules: ModuleChoice)
                    modules: ModuleChoice, field => *field = modules,
                    "chains | links | [[\"link\", ...], ...]", "`chains`", "[[\"upper_arm\", \"forearm\"], [\"hand\"]]";
                /// The scalar of arguments and results: double or single precision.
                "scalar" scalar(scalar: FloatType)
                    scalar: FloatType, field => *field = scalar,
                    "f64 | f32", "`f64`", "f32";
                /// Makes gravity a run-time parameter, which can be changed; its value is then the
                /// default.
                "runtime_gravity" runtime_gravity()
                    runtime_gravity: bool, field => *field = true,
                    "true | false", "`false`", "true";
                /// The links whose own inertia is a run-time parameter: each replaces the
                /// description's, which is the default. (Of each link alone, without the links that
                /// are fixed to it.)
                "runtime_inertia" runtime_inertia(links: impl IntoIterator<Item = impl Into<String>>)
                    runtime_inertia: Vec<String>, field => field.extend(links.into_iter().map(Into::into)),
                    "links", "none", "[\"hand\"]";
                /// The links with a payload: an inertia that is a run-time parameter and is added
                /// to the link's. Its default is zero.
                "payload" payload(links: impl IntoIterator<Item = impl Into<String>>)
                    payload: Vec<String>, field => field.extend(links.into_iter().map(Into::into)),
                    "links", "none", "[\"hand\"]";
                /// Runs equal limbs (legs, arms, fingers) through one function, with a table of
                /// constants for each: the smallest code. Limbs of which one carries a `payload` or
                /// a `runtime_inertia` are not equal. Without this option equal limbs are packed
                /// into vectors where the processor has them.
                "share_limbs" share_limbs()
                    share_limbs: bool, field => *field = true,
                    "true | false", "`false`", "true";
                /// Embeds the model in the generated type, which then implements `EmbeddedModel`.
                /// Interpreters, GPU kernels and run-time compilers take the generated type in
                /// place of a description file. Needs the feature `alloc` of `modyn`, which is on
                /// by default.
                "embed_model" embed_model()
                    embed_model: bool, field => *field = true,
                    "true | false", "`false`", "true";
                /// The form of the code of forward and inverse dynamics. `unrolled` is
                /// straight-line code, whose length grows with the robot. `looped` is a loop over
                /// the bodies with a table of constants: a few kB for any robot, and for long
                /// chains quicker than straight-line code where other work has taken the caches.
                /// `auto` takes loops for long chains of some 45 joints and more. Robots with mimic
                /// joints, a `payload` or a `runtime_inertia` have straight-line code. The
                /// derivatives of forward dynamics, also with contacts or closed loops, and their
                /// Hessian have products of matrices in loops where that is shorter (`looped`), or
                /// where there are many products (`auto`); for many states with `looped` alone.
                /// Dependent rows of contacts and closed loops are solved for in loops, behind a
                /// branch, unless the code is `unrolled`.
                "code" code(form: CodeForm)
                    code: CodeForm, field => *field = form,
                    "auto | unrolled | looped", "`auto`", "looped";
                /// The path of the crate `modyn` where the text goes.
                "crate" crate_(path: impl Into<String>)
                    crate_path: Option<String>, field => *field = Some(path.into()),
                    "path", "`::modyn`", "::modyn";
                /// The name of the generated type, in upper camel case. (The macro:
                /// `Name = "robot.urdf"`.)
                "type_name" type_name(name: impl Into<String>)
                    type_name: Option<String>, field => *field = Some(name.into()),
                    "name", "made from the robot's name", "MyArm", Files;
                /// The visibility of the generated types, such as `pub(crate)`; nothing for
                /// private. (The macro: `pub(crate) Name = "robot.urdf"`.)
                "visibility" visibility(visibility: impl Into<String>)
                    visibility: Option<String>, field => *field = Some(visibility.into()),
                    "text", "`pub`", "pub(crate)", Files;
                /// Makes text that depends on `core` alone: it carries the part of the runtime that
                /// it needs, as a module `runtime`. Include it as a module of its own (`mod arm;`
                /// beside `arm.rs`). The type has its functions, but not the trait `Robot` nor
                /// batches.
                "self_contained" self_contained()
                    self_contained: bool, field => *field = true,
                    "true | false", "`false`", "true", Files;
                /// Adds functions for C, named `prefix_function`: `extern "C"` over pointers to
                /// arrays of fixed sizes, without namespaces (`#[unsafe(no_mangle)]`, so not under
                /// `forbid(unsafe_code)`: that two functions have one name is found by the linker
                /// alone). The arrays must be valid and aligned, and `out` must overlap nothing.
                /// `Generated::c_header` is their header.
                "c_functions" c_functions(prefix: impl Into<String>)
                    c_functions: Option<String>, field => *field = Some(prefix.into()),
                    "name", "none", "arm", Files;
            }
        }
    };
}
pub(crate) use option_table;

/// The table, the options about code, and how they are stored.
macro_rules! table {
    (
        read { $(
            $(#[doc = $read_docs:literal])+
            $read_name:literal $read_method:ident($($read_argument:ident: $read_argument_type:ty)?)
                $read_field:ident: $read_type:ty, $read_target:ident => $read_set:expr,
                $read_form:literal, $read_default:literal, $read_example:literal $(, $read_entries:ident)?;
        )* }
        code { $(
            $(#[doc = $docs:literal])+
            $name:literal $method:ident($($argument:ident: $argument_type:ty)?)
                $field:ident: $type:ty, $target:ident => $set:expr,
                $form:literal, $default:literal, $example:literal $(, $entries:ident)?;
        )* }
    ) => {
        /// The options about the generated code.
        #[derive(Clone, Debug, Default)]
        pub(crate) struct CodeOptions {
            $(pub $field: $type,)*
        }

        /// All options, about reading first.
        pub const OPTIONS: &[OptionRow] = &[
            $(OptionRow {
                name: $read_name,
                method: stringify!($read_method),
                form: $read_form,
                default: $read_default,
                example: $read_example,
                docs: concat!($($read_docs),+),
                stage: Stage::Reading,
                entries: entries!($($read_entries)?),
                set: |options, value| options.read.$read_field.set(value),
                arguments: |options| options.read.$read_field.arguments(),
            },)*
            $(OptionRow {
                name: $name,
                method: stringify!($method),
                form: $form,
                default: $default,
                example: $example,
                docs: concat!($($docs),+),
                stage: Stage::Code,
                entries: entries!($($entries)?),
                set: |options, value| options.code.$field.set(value),
                arguments: |options| options.code.$field.arguments(),
            },)*
        ];
    };
}

macro_rules! entries {
    () => {
        Entries::All
    };
    ($entries:ident) => {
        Entries::$entries
    };
}

option_table!(table);

/// All options of a compilation.
#[derive(Clone, Debug, Default)]
pub(crate) struct Options {
    pub read: ReadOptions,
    pub code: CodeOptions,
    /// The user's functions, which the builder alone has.
    pub user_functions: Vec<NamedFunction>,
}

impl Options {
    /// Takes a value for the option of this name.
    pub fn set(&mut self, name: &str, value: &Value) -> Result<(), OptionError> {
        match OPTIONS.iter().find(|row| row.name == name) {
            Some(row) => (row.set)(self, value),
            None => {
                let known: Vec<&str> = OPTIONS.iter().map(|row| row.name).collect();
                Err(OptionError::new(value.at, unknown_option(name, &known)))
            }
        }
    }

    /// Returns whether the option of this name differs from its default; `function` is the user's
    /// functions.
    pub fn has(&self, name: &str) -> bool {
        let row = OPTIONS.iter().find(|row| row.name == name);
        match row {
            Some(row) => (row.arguments)(self).is_some(),
            None => name == "function" && !self.user_functions.is_empty(),
        }
    }

    /// The calls of `Builder` that set the options which differ from their defaults.
    pub fn calls(&self) -> impl Iterator<Item = String> {
        let of_the_table = OPTIONS.iter().filter_map(|row| {
            (row.arguments)(self).map(|arguments| format!("{}({arguments})", row.method))
        });
        of_the_table.chain(self.user_functions.iter().map(|function| {
            let batch = if function.batch { "_batch" } else { "" };
            format!("function{batch}({:?}, function)", function.name)
        }))
    }
}
