//! The types of options: how each is read from a value and written as a Rust argument.

use modyn_read::diagnostics::Severity;
use modyn_read::{
    Armature, Base, Contact, ControlLaw, Ground, JointActuator, Loop, LoopEnd, Mimic, Package,
    Rotor, XacroArg,
};
use modyn_runtime::model::{ContactKind, JointFriction, LoopConstraintKind};

use super::renamed::renamed_word;
use super::value::{OptionError, Value, ValueKind};
use crate::FloatType;
use crate::plan::{CodeForm, Function, unknown_function};

/// The kinematic modules to compile with.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ModuleChoice {
    /// Maximal serial chains.
    #[default]
    Chains,
    /// A module for each link.
    Links,
    /// By the names of the links, each module from its parent outwards.
    List(Vec<Vec<String>>),
}

/// A type that options have.
pub trait OptionValue: Sized {
    /// Reads a value.
    ///
    /// # Errors
    ///
    /// If the value has another form; the message says which forms there are.
    fn read(value: &Value) -> Result<Self, OptionError>;

    /// The argument in Rust.
    fn rust(&self) -> String;
}

/// The storage of an option.
pub trait Field {
    /// Takes a value: a list gets longer, all others are replaced.
    ///
    /// # Errors
    ///
    /// As for [`OptionValue::read`].
    fn set(&mut self, value: &Value) -> Result<(), OptionError>;

    /// The arguments of the call of `Builder` that sets it; `None` if it has its default.
    fn arguments(&self) -> Option<String>;
}

impl<T: OptionValue> Field for Option<T> {
    fn set(&mut self, value: &Value) -> Result<(), OptionError> {
        *self = Some(T::read(value)?);
        Ok(())
    }

    fn arguments(&self) -> Option<String> {
        self.as_ref().map(T::rust)
    }
}

impl<T: OptionValue> Field for Vec<T> {
    fn set(&mut self, value: &Value) -> Result<(), OptionError> {
        for item in value.items() {
            self.push(T::read(item)?);
        }
        Ok(())
    }

    fn arguments(&self) -> Option<String> {
        (!self.is_empty()).then(|| list(self))
    }
}

impl Field for bool {
    fn set(&mut self, value: &Value) -> Result<(), OptionError> {
        *self = choice(value, &[("true", true), ("false", false)])?;
        Ok(())
    }

    fn arguments(&self) -> Option<String> {
        self.then(String::new)
    }
}

/// Items in brackets.
fn list<T: OptionValue>(items: &[T]) -> String {
    format!("[{}]", items.iter().map(T::rust).collect::<Vec<_>>().join(", "))
}

/// The value of one of these words.
fn choice<T: Clone>(value: &Value, choices: &[(&str, T)]) -> Result<T, OptionError> {
    let choice = match &value.kind {
        ValueKind::Word(word) => choices.iter().find(|(name, _)| name == word),
        _ => None,
    };
    choice.map(|(_, value)| value.clone()).ok_or_else(|| {
        let names: Vec<String> = choices.iter().map(|(name, _)| format!("`{name}`")).collect();
        let expected = format!("expected {}", names.join(" or "));
        let now = match &value.kind {
            ValueKind::Word(word) => renamed_word(word).map(|now| (word, now)),
            _ => None,
        };
        let message = match now.filter(|(_, now)| choices.iter().any(|(name, _)| name == now)) {
            Some((word, now)) => format!("{expected}; `{word}` is named `{now}` now"),
            None => expected,
        };
        OptionError::new(value.at, message)
    })
}

/// Types that are one of several words.
macro_rules! choices {
    ($($type:ident: $($word:literal $variant:ident),+;)*) => {$(
        impl OptionValue for $type {
            fn read(value: &Value) -> Result<Self, OptionError> {
                choice(value, &[$(($word, Self::$variant)),+])
            }

            fn rust(&self) -> String {
                format!("{}::{self:?}", stringify!($type))
            }
        }

        impl Field for $type {
            fn set(&mut self, value: &Value) -> Result<(), OptionError> {
                *self = Self::read(value)?;
                Ok(())
            }

            fn arguments(&self) -> Option<String> {
                (*self != Self::default()).then(|| self.rust())
            }
        }
    )*};
}

choices! {
    Base: "auto" Auto, "fixed" Fixed, "floating" Floating;
    CodeForm: "auto" Auto, "unrolled" Unrolled, "looped" Looped;
    FloatType: "f64" F64, "f32" F32;
    Mimic: "follow" Follow, "independent" Independent, "refuse" Refuse;
    Severity: "error" Error, "warn" Warning;
}

impl OptionValue for f64 {
    fn read(value: &Value) -> Result<Self, OptionError> {
        match value.kind {
            ValueKind::Number(x) => Ok(x),
            _ => Err(OptionError::new(value.at, "expected a number")),
        }
    }

    fn rust(&self) -> String {
        format!("{self:?}")
    }
}

impl OptionValue for [f64; 3] {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let ValueKind::List(items) = &value.kind else {
            return Err(OptionError::new(value.at, "expected three numbers: `[x, y, z]`"));
        };
        let numbers = items.iter().map(f64::read).collect::<Result<Vec<f64>, OptionError>>()?;
        let count = numbers.len();
        numbers.try_into().map_err(|_| {
            OptionError::new(value.at, format!("expected three numbers, there are {count}"))
        })
    }

    fn rust(&self) -> String {
        format!("{self:?}")
    }
}

impl OptionValue for String {
    fn read(value: &Value) -> Result<Self, OptionError> {
        match &value.kind {
            ValueKind::Word(text) | ValueKind::Text(text) => Ok(text.clone()),
            _ => Err(OptionError::new(value.at, "expected a name")),
        }
    }

    fn rust(&self) -> String {
        format!("{self:?}")
    }
}

impl OptionValue for ModuleChoice {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let ValueKind::List(modules) = &value.kind else {
            let words = [("chains", Self::Chains), ("links", Self::Links)];
            return choice(value, &words).map_err(|fault| {
                let lists = " or a list of links for each module: `[[\"a\", \"b\"], [\"c\"]]`";
                OptionError::new(fault.at, fault.message + lists)
            });
        };
        let module = |module: &Value| match &module.kind {
            ValueKind::List(names) => names.iter().map(String::read).collect(),
            _ => Err(OptionError::new(
                module.at,
                "expected the names of a module's links: `[\"a\", \"b\"]`",
            )),
        };
        modules.iter().map(module).collect::<Result<_, _>>().map(Self::List)
    }

    fn rust(&self) -> String {
        format!("ModuleChoice::{self:?}")
    }
}

impl Field for ModuleChoice {
    fn set(&mut self, value: &Value) -> Result<(), OptionError> {
        *self = Self::read(value)?;
        Ok(())
    }

    fn arguments(&self) -> Option<String> {
        (*self != Self::default()).then(|| self.rust())
    }
}

/// A list of names in which `default` and `all` stand for several functions.
impl OptionValue for Vec<Function> {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let mut functions = Self::new();
        for item in value.items() {
            let ValueKind::Word(name) = &item.kind else {
                let message = "expected names of functions, `default` or `all`";
                return Err(OptionError::new(item.at, message));
            };
            match name.as_str() {
                "all" => functions.extend(Function::ALL),
                "default" => functions.extend(Function::DEFAULT),
                name => functions.push(
                    Function::from_name(name)
                        .ok_or_else(|| OptionError::new(item.at, unknown_function(name)))?,
                ),
            }
        }
        Ok(functions)
    }

    fn rust(&self) -> String {
        let names: Vec<String> = self.iter().map(|f| format!("Function::{f:?}")).collect();
        format!("[{}]", names.join(", "))
    }
}

/// `none`, `viscous`, `coulomb` or `smooth(0.01)`
impl OptionValue for JointFriction {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let help = "expected a velocity, rad/s or m/s: `smooth(0.01)`";
        match &value.kind {
            ValueKind::Call(word, arguments) if word == "smooth" => match arguments.as_slice() {
                [velocity] => f64::read(velocity).map(Self::Smooth),
                _ => Err(OptionError::form(value.at, help)),
            },
            // A shell needs no quotes for `smooth=0.01`.
            ValueKind::Pair(name, velocity) if name.kind == ValueKind::Word("smooth".into()) => {
                f64::read(velocity).map(Self::Smooth)
            }
            ValueKind::Word(word) if word == "smooth" => Err(OptionError::form(value.at, help)),
            _ => {
                let words =
                    [("none", Self::None), ("viscous", Self::Viscous), ("coulomb", Self::Coulomb)];
                choice(value, &words).map_err(|fault| {
                    OptionError::new(fault.at, fault.message + " or `smooth(velocity)`")
                })
            }
        }
    }

    fn rust(&self) -> String {
        format!("JointFriction::{self:?}")
    }
}

/// The name and the value of a pair.
pub(super) fn pair<'v>(
    value: &'v Value,
    expected: &str,
) -> Result<(String, &'v Value), OptionError> {
    match &value.kind {
        ValueKind::Pair(name, value) => Ok((String::read(name)?, value)),
        _ => Err(OptionError::form(value.at, expected)),
    }
}

/// `plane`, or `plane([x, y, z], [nx, ny, nz])`; `friction = coefficient` may be the last argument.
impl OptionValue for Ground {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let expected = "expected `plane` or `plane([x, y, z], [nx, ny, nz])`, and perhaps \
                        `friction = 0.8` as the last argument";
        let (name, arguments) = match &value.kind {
            ValueKind::Word(name) => (name, &[][..]),
            ValueKind::Call(name, arguments) => (name, arguments.as_slice()),
            _ => return Err(OptionError::form(value.at, expected)),
        };
        if name != "plane" {
            return Err(OptionError::form(value.at, expected));
        }
        let (place, friction) = match arguments {
            [place @ .., last] if matches!(last.kind, ValueKind::Pair(..)) => {
                let (name, coefficient) = pair(last, expected)?;
                if name != "friction" {
                    return Err(OptionError::form(last.at, expected));
                }
                (place, Some(f64::read(coefficient)?))
            }
            place => (place, None),
        };
        let ground = match place {
            [] => Self::default(),
            [point, normal] => Self::plane(<[f64; 3]>::read(point)?, <[f64; 3]>::read(normal)?),
            _ => return Err(OptionError::form(value.at, expected)),
        };
        Ok(friction.map_or(ground, |friction| ground.with_friction(friction)))
    }

    fn rust(&self) -> String {
        let plane = format!("Ground::plane({:?}, {:?})", self.point, self.normal);
        self.friction
            .map_or(plane.clone(), |friction| format!("{plane}.with_friction({friction:?})"))
    }
}

/// `"joint": inertia`
impl OptionValue for Armature {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let expected = "expected `\"joint\": inertia`";
        let (joint, inertia) = pair(value, expected)?;
        match inertia.kind {
            ValueKind::Number(number) => Ok(Self::new(joint, number)),
            _ => Err(OptionError::form(inertia.at, expected)),
        }
    }

    fn rust(&self) -> String {
        format!("Armature::new({:?}, {:?})", self.joint, self.inertia)
    }
}

/// `"joint": (inertia, gear_ratio)`
impl OptionValue for Rotor {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let expected = "expected `\"joint\": (inertia, gear_ratio)`";
        let (joint, numbers) = pair(value, expected)?;
        let [inertia, gear_ratio] = numbers.items() else {
            return Err(OptionError::form(numbers.at, expected));
        };
        Ok(Self::new(joint, f64::read(inertia)?, f64::read(gear_ratio)?))
    }

    fn rust(&self) -> String {
        format!("Rotor::new({:?}, {:?}, {:?})", self.joint, self.inertia, self.gear_ratio)
    }
}

/// `"joint": position(kp, kd)`, `"joint": velocity(kd)` or `"joint": motor`; limits and the delay may
/// follow as `name = number`.
impl OptionValue for JointActuator {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let expected = "expected `\"joint\": position(kp, kd)`, `\"joint\": velocity(kd)` or \
                        `\"joint\": motor`, and perhaps `effort = 20`, `saturation = 30`, \
                        `velocity = 25` and `delay = 2` as the last arguments";
        let (joint, actuator) = pair(value, expected)?;
        let (name, arguments) = match &actuator.kind {
            ValueKind::Word(name) => (name, &[][..]),
            ValueKind::Call(name, arguments) => (name, arguments.as_slice()),
            _ => return Err(OptionError::form(actuator.at, expected)),
        };
        let is_named = |argument: &&Value| matches!(argument.kind, ValueKind::Pair(..));
        let gains = arguments.iter().take_while(|argument| !is_named(argument));
        let numbers = gains.map(f64::read).collect::<Result<Vec<f64>, OptionError>>()?;
        let law = match (name.as_str(), numbers.as_slice()) {
            ("position", &[kp, kd]) => ControlLaw::Position { kp, kd },
            ("velocity", &[kd]) => ControlLaw::Velocity { kd },
            ("motor", []) => ControlLaw::Motor,
            _ => return Err(OptionError::form(actuator.at, expected)),
        };
        let mut read = Self::new(joint, law);
        for argument in &arguments[numbers.len()..] {
            let (name, number) = pair(argument, expected)?;
            match name.as_str() {
                "effort" if read.effort.is_none() => read.effort = Some(f64::read(number)?),
                "saturation" if read.saturation.is_none() => {
                    read.saturation = Some(f64::read(number)?);
                }
                "velocity" if read.velocity.is_none() => {
                    read.velocity = Some(f64::read(number)?);
                }
                "delay" if read.delay == 0 => read.delay = steps(number)?,
                _ => return Err(OptionError::form(argument.at, expected)),
            }
        }
        Ok(read)
    }

    fn rust(&self) -> String {
        let Self { joint, law, effort, saturation, velocity, delay, .. } = self;
        let mut text = match *law {
            ControlLaw::Position { kp, kd } => {
                format!("JointActuator::position({joint:?}, {kp:?}, {kd:?})")
            }
            ControlLaw::Velocity { kd } => format!("JointActuator::velocity({joint:?}, {kd:?})"),
            ControlLaw::Motor => format!("JointActuator::motor({joint:?})"),
            _ => unreachable!("the law {law:?} has no form as an option"),
        };
        let numbers = [("effort", effort), ("saturation", saturation), ("velocity", velocity)];
        for (name, number) in numbers {
            if let Some(number) = number {
                text += &format!(".with_{name}({number:?})");
            }
        }
        if *delay > 0 {
            text += &format!(".with_delay({delay})");
        }
        text
    }
}

/// Returns a number of steps.
fn steps(value: &Value) -> Result<usize, OptionError> {
    let number = f64::read(value)?;
    let steps = number as usize;
    let message = "expected a whole number of steps: `delay = 2`";
    (steps as f64 == number).then_some(steps).ok_or_else(|| OptionError::new(value.at, message))
}

/// `"name": "value"`, where a number or a word needs no quotes
impl OptionValue for XacroArg {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let (name, value) = pair(value, "expected `\"name\": \"value\"`")?;
        match value.kind {
            ValueKind::Number(number) => Ok(Self::new(name, number.to_string())),
            _ => Ok(Self::new(name, String::read(value)?)),
        }
    }

    fn rust(&self) -> String {
        format!("XacroArg::new({:?}, {:?})", self.name, self.value)
    }
}

/// `"name": "folder"`
impl OptionValue for Package {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let (name, folder) = pair(value, "expected `\"name\": \"folder\"`")?;
        Ok(Self::new(name, String::read(folder)?))
    }

    fn rust(&self) -> String {
        format!("Package::new({:?}, {:?})", self.name, self.folder)
    }
}

/// `"name": type("link", [x, y, z], "link", [x, y, z], axis = [x, y, z])`; roll, pitch and yaw may
/// follow each origin.
impl OptionValue for Loop {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let expected = "expected `\"name\": type(\"link\", [x, y, z], \"link\", [x, y, z])`, and perhaps \
                        `axis = [x, y, z]`";
        let (name, joint) = pair(value, expected)?;
        let types = ["spherical", "fixed", "revolute", "continuous", "prismatic"];
        let ValueKind::Call(joint_type, arguments) = &joint.kind else {
            return Err(OptionError::form(joint.at, expected));
        };
        let word = Value { at: joint.at, kind: ValueKind::Word(joint_type.clone()) };
        choice(&word, &types.map(|name| (name, ())))?;
        let mut rest = arguments.as_slice();
        let mut end = || {
            let missing = || OptionError::form(joint.at, expected);
            let [link, origin, others @ ..] = rest else { return Err(missing()) };
            rest = others;
            let mut rpy = [0.0; 3];
            if let [angles, others @ ..] = rest
                && matches!(angles.kind, ValueKind::List(_))
            {
                (rpy, rest) = (<[f64; 3]>::read(angles)?, others);
            }
            Ok(LoopEnd { link: String::read(link)?, xyz: <[f64; 3]>::read(origin)?, rpy })
        };
        let ends = [end()?, end()?];
        let axis = match rest {
            [] => None,
            [axis] => match pair(axis, expected)? {
                (word, value) if word == "axis" => Some((<[f64; 3]>::read(value)?, axis.at)),
                _ => return Err(OptionError::form(axis.at, "expected `axis`")),
            },
            [_, other, ..] => return Err(OptionError::form(other.at, "expected `)`")),
        };
        let along = axis.map_or([1.0, 0.0, 0.0], |(axis, _)| axis);
        let kind = LoopConstraintKind::of_joint(joint_type, along)
            .ok_or_else(|| OptionError::new(joint.at, "expected the type of a joint"))?;
        match axis {
            Some((_, at)) if kind.axis().is_none() => Err(OptionError::new(
                at,
                format!("a loop joint of type `{joint_type}` has no axis"),
            )),
            _ => Ok(Self { name, kind, ends }),
        }
    }

    fn rust(&self) -> String {
        format!("{self:?}")
    }
}

/// `"name": type("link", [x, y, z], [roll, pitch, yaw])`; the last two are zero if they are left
/// out.
impl OptionValue for Contact {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let expected = "expected `\"name\": point(\"link\")` or `\"name\": surface(\"link\")`, and perhaps `[x, y, z]` \
                        and `[roll, pitch, yaw]` after the link";
        let (name, contact) = pair(value, expected)?;
        let ValueKind::Call(contact_type, arguments) = &contact.kind else {
            return Err(OptionError::form(contact.at, expected));
        };
        let word = Value { at: contact.at, kind: ValueKind::Word(contact_type.clone()) };
        let types = [("point", ContactKind::Point), ("surface", ContactKind::Surface)];
        let kind = choice(&word, &types)?;
        let [link, numbers @ ..] = arguments.as_slice() else {
            return Err(OptionError::form(contact.at, expected));
        };
        let (xyz, rpy) = match numbers {
            [] => (None, None),
            [origin] => (Some(origin), None),
            [origin, angles] => (Some(origin), Some(angles)),
            [_, _, other, ..] => return Err(OptionError::form(other.at, "expected `)`")),
        };
        let vector = |value: Option<&Value>| value.map_or(Ok([0.0; 3]), <[f64; 3]>::read);
        let end = LoopEnd { link: String::read(link)?, xyz: vector(xyz)?, rpy: vector(rpy)? };
        Ok(Self { name, kind, end })
    }

    fn rust(&self) -> String {
        format!("{self:?}")
    }
}
