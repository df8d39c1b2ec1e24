//! The robot of a command: its description, and the options of reading.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use modyn_codegen::Builder;
use modyn_codegen::diagnostics::{Code, Diagnostic, Diagnostics, Severity};
use modyn_codegen::read::file::{read_first, read_text};
use modyn_codegen::{
    Contact, ContactKind, Format, Friction, Loop, LoopConstraintKind, LoopEnd, ReadOptions,
    Reading, Rotor, read,
};

use crate::command::diagnostics;
use crate::command::numbers::{number, numbers};
use crate::command::outcome::{Failure, to_stderr};

/// A description, and the options of reading it.
#[derive(Args)]
pub struct Robot {
    /// The description (URDF or MJCF); `-` for standard input
    #[arg(value_name = "ROBOT.urdf")]
    pub path: PathBuf,
    #[command(flatten)]
    pub options: Options,
}

/// The options of reading a description.
#[derive(Args)]
#[command(next_help_heading = "Reading the description")]
pub struct Options {
    /// Whether the root link is fixed to the world or floats
    #[arg(long, value_enum, default_value_t)]
    base: Base,
    /// The treatment of mimic joints
    #[arg(long, value_enum, default_value_t)]
    mimic: Mimic,
    /// The rotor of a joint's drive, in place of the description's: inertia (kg m^2) and gear ratio
    #[arg(long = "rotor", value_name = "JOINT=INERTIA,RATIO", value_parser = rotor)]
    rotors: Vec<Rotor>,
    /// A joint that closes a loop, besides the description's: NAME=TYPE:LINK:X,Y,Z:LINK:X,Y,Z[:AXIS], of type spherical,
    /// fixed, revolute or prismatic; roll, pitch and yaw may follow each X,Y,Z
    #[arg(long = "loop", value_name = "JOINT", value_parser = loop_joint)]
    loops: Vec<Loop>,
    /// A frame of a link that may touch the world: NAME=point:LINK[:X,Y,Z] or NAME=surface:LINK[:X,Y,Z[,ROLL,PITCH,YAW]]
    #[arg(long = "contact", value_name = "CONTACT", value_parser = contact)]
    contacts: Vec<Contact>,
    /// The damping and friction of the description that act: none, viscous, coulomb, smooth=VELOCITY [default: none, with a
    /// warning if the description has any]
    #[arg(long, value_name = "KIND", value_parser = friction)]
    friction: Option<Friction>,
    /// The acceleration of free fall in world axes, m/s^2 [default: 0,0,-9.81, or that of an MJCF]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    gravity: Option<[f64; 3]>,
    /// The severity of inertias that no rigid body has
    #[arg(long, value_enum, default_value_t)]
    unphysical_inertia: Unphysical,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum Base {
    #[default]
    Fixed,
    Floating,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum Mimic {
    #[default]
    Follow,
    Independent,
    Refuse,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum Unphysical {
    #[default]
    Error,
    Warn,
}

/// A description.
pub struct Description {
    /// The name, as the user wrote it.
    pub name: String,
    /// The text.
    pub text: String,
    /// The path; `None` for standard input.
    path: Option<PathBuf>,
}

impl Description {
    /// Reads the text of the description.
    pub fn open(path: &Path) -> Result<Self, Diagnostics> {
        let name = path.display().to_string();
        if path == Path::new("-") {
            let name = String::from("standard input");
            let text = read_text(&name, std::io::stdin().lock())?;
            return Ok(Self { name, text, path: None });
        }
        if !path.exists() {
            let missing = Diagnostic::error(Code::MissingFile, format!("`{name}` does not exist"));
            let help = "give the path of a URDF file, or `-` for standard input";
            return Err(missing.with_help(help).into());
        }
        let (_, text) = read_first(&name, &[path.to_owned()])?;
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        Ok(Self { name, text, path: Some(path) })
    }

    /// Reads the robot.
    pub fn read(&self, options: &ReadOptions) -> Result<Reading, Diagnostics> {
        read(&self.text, &self.name, options)
    }

    /// Prints the warnings.
    pub fn warn(&self, warnings: Diagnostics) {
        to_stderr(&diagnostics::render(warnings.as_slice(), Some(&self.text)));
    }

    /// Returns the failure of a description with these diagnostics.
    pub fn failure(&self, found: Diagnostics) -> Failure {
        Failure::Diagnostics(found, Some(self.text.clone()))
    }
}

impl Robot {
    /// Reads the text of the description.
    pub fn open(&self) -> Result<Description, Failure> {
        Description::open(&self.path).map_err(|found| Failure::Diagnostics(found, None))
    }

    /// Returns the builder with these options, for this description.
    pub fn builder(&self, description: &Description) -> Builder {
        let Description { name, text, path } = description;
        let builder = Builder::new();
        // The path makes the comment of a generated file the same as that of a build script.
        let builder = match (path, Format::of(text, name)) {
            #[cfg(feature = "mjcf")]
            (Some(path), Format::Mjcf) => builder.mjcf(path),
            (Some(path), _) => builder.urdf(path),
            (None, _) => builder.text(text, name),
        };
        self.options.configure(builder)
    }
}

impl Robot {
    /// Returns the diagnostics with the file's name as the user wrote it; the builder receives the full path.
    pub fn named(&self, found: Diagnostics) -> Diagnostics {
        let name = self.path.display().to_string();
        let mut found = found.into_vec();
        found
            .iter_mut()
            .filter_map(|one| one.file.as_mut())
            .for_each(|file| file.clone_from(&name));
        Diagnostics::new(found)
    }
}

impl Options {
    /// Returns the options of reading only.
    pub fn read_options(&self) -> ReadOptions {
        ReadOptions {
            gravity: self.gravity,
            unphysical_inertia: self.unphysical_inertia.into(),
            mimic: self.mimic.into(),
            base: self.base.into(),
            rotors: self.rotors.clone(),
            friction: self.friction,
            loops: self.loops.clone(),
            contacts: self.contacts.clone(),
        }
    }

    fn configure(&self, builder: Builder) -> Builder {
        let builder = builder
            .base(self.base.into())
            .mimic(self.mimic.into())
            .unphysical_inertia(self.unphysical_inertia.into());
        let builder = self.rotors.iter().fold(builder, |builder, rotor| {
            builder.rotor(&rotor.joint, rotor.inertia, rotor.gear_ratio)
        });
        let builder = self.loops.iter().cloned().fold(builder, Builder::loop_joint);
        let builder = self.contacts.iter().cloned().fold(builder, Builder::contact);
        let builder = self.friction.into_iter().fold(builder, Builder::friction);
        self.gravity.into_iter().fold(builder, Builder::gravity)
    }
}

impl From<Base> for modyn_codegen::Base {
    fn from(base: Base) -> Self {
        match base {
            Base::Fixed => Self::Fixed,
            Base::Floating => Self::Floating,
        }
    }
}

impl From<Mimic> for modyn_codegen::Mimic {
    fn from(mimic: Mimic) -> Self {
        match mimic {
            Mimic::Follow => Self::Follow,
            Mimic::Independent => Self::Independent,
            Mimic::Refuse => Self::Refuse,
        }
    }
}

impl From<Unphysical> for Severity {
    fn from(unphysical: Unphysical) -> Self {
        match unphysical {
            Unphysical::Error => Self::Error,
            Unphysical::Warn => Self::Warning,
        }
    }
}

/// Parses `elbow=0.0001,100`.
fn rotor(text: &str) -> Result<Rotor, String> {
    let expected = || "expected JOINT=INERTIA,RATIO, such as elbow=0.0001,100".to_string();
    let (joint, figures) = text.rsplit_once('=').ok_or_else(expected)?;
    let (inertia, ratio) = figures.split_once(',').ok_or_else(expected)?;
    Ok(Rotor { joint: joint.into(), inertia: number(inertia)?, gear_ratio: number(ratio)? })
}

/// Parses `pin=revolute:coupler:0.5,0,0:rocker:0.4,0,0:0,1,0`.
fn loop_joint(text: &str) -> Result<Loop, String> {
    let expected = || {
        "expected NAME=TYPE:LINK:X,Y,Z:LINK:X,Y,Z[:AXIS], such as pin=spherical:coupler:0.5,0,0:rocker:0.4,0,0"
            .to_string()
    };
    let (name, rest) = text.split_once('=').ok_or_else(expected)?;
    let parts: Vec<&str> = rest.split(':').collect();
    let (&[joint_type, first, at_first, second, at_second], axis) =
        parts.split_first_chunk().ok_or_else(expected)?;
    let along = match axis {
        [] => [1.0, 0.0, 0.0],
        [axis] => vector(axis)?,
        _ => return Err(expected()),
    };
    let kind = LoopConstraintKind::of_joint(joint_type, along).ok_or_else(|| {
        format!("`{joint_type}` is none of spherical, fixed, revolute, continuous, prismatic")
    })?;
    if kind.axis().is_none() && !axis.is_empty() {
        return Err(format!("a loop joint of type {joint_type} has no axis"));
    }
    let ends = [frame(first, at_first)?, frame(second, at_second)?];
    Ok(Loop { name: name.into(), kind, ends })
}

/// The frame on a link at `0.5,0,0`, or `0.5,0,0,0,0,1.57` with roll, pitch and yaw.
fn frame(link: &str, place: &str) -> Result<LoopEnd, String> {
    let (xyz, rpy) = match *numbers(place)? {
        [x, y, z] => ([x, y, z], [0.0; 3]),
        [x, y, z, roll, pitch, yaw] => ([x, y, z], [roll, pitch, yaw]),
        _ => return Err(format!("`{place}` is not three numbers, or six with a rotation")),
    };
    Ok(LoopEnd { link: link.into(), xyz, rpy })
}

/// `left_foot=point:FL_FOOT`, `sole=surface:ankle:0.04,0,-0.03,0,0,0`
fn contact(text: &str) -> Result<Contact, String> {
    let expected = || {
        "expected NAME=point:LINK[:X,Y,Z] or NAME=surface:LINK[:X,Y,Z[,ROLL,PITCH,YAW]], such as foot=point:FL_FOOT"
            .to_string()
    };
    let (name, rest) = text.split_once('=').ok_or_else(expected)?;
    let (kind, rest) = rest.split_once(':').ok_or_else(expected)?;
    let kind = ContactKind::from_name(kind).ok_or_else(expected)?;
    let (link, place) = rest.split_once(':').unwrap_or((rest, "0,0,0"));
    Ok(Contact { name: name.into(), kind, end: frame(link, place)? })
}

/// Parses `none`, `viscous`, `coulomb` or `smooth=0.01`.
fn friction(text: &str) -> Result<Friction, String> {
    match (text, text.strip_prefix("smooth=")) {
        ("none", _) => Ok(Friction::None),
        ("viscous", _) => Ok(Friction::Viscous),
        ("coulomb", _) => Ok(Friction::Coulomb),
        (_, Some(velocity)) => number(velocity).map(Friction::Smooth),
        _ => Err("expected none, viscous, coulomb or smooth=VELOCITY (rad/s or m/s)".into()),
    }
}

/// Parses `0,0,-9.81`.
fn vector(text: &str) -> Result<[f64; 3], String> {
    let numbers = numbers(text)?;
    let count = numbers.len();
    numbers.try_into().map_err(|_| format!("expected three numbers, there are {count}"))
}
