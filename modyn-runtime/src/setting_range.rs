//! The ranges of settings, and the error of a number outside of its range.

use core::fmt;

use crate::constraint_settings::{ConstraintSettings, ContactTarget};
use crate::step_settings::{ContactSurface, StepSettings};

/// A setting that is not finite, or outside of its range.
///
/// ```
/// use modyn_runtime::{ConstraintSettings, ContactTarget};
///
/// let soft = ContactTarget { compliance: -0.1, ..ContactTarget::<f64>::GROUND };
/// let settings = ConstraintSettings::<f64, [_; 1]> { targets: [soft], ..Default::default() };
/// let error = settings.check().expect_err("compliance is not negative");
/// assert_eq!(
///     error.to_string(),
///     "`compliance` of `settings.targets[0]` is -0.1; expected a finite number that is not negative"
/// );
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SettingError {
    /// The name of the setting.
    pub name: &'static str,
    /// Where the setting is.
    pub place: SettingPlace,
    /// The value. For a rotation whose columns are not orthonormal, the first entry of R^T R that
    /// is wrong, or the determinant.
    pub value: f64,
    /// The values that are allowed.
    pub range: SettingRange,
}

/// Where a setting is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SettingPlace {
    /// A setting of all constraints.
    Settings,
    /// The target of the contact with this index.
    Target(usize),
    /// The surface of the shape with this index among the shapes that touch the ground.
    Surface(usize),
    /// The height field.
    HeightField,
    /// The height with this row and this column in a height field.
    Height {
        /// The index of the row.
        row: usize,
        /// The index of the column.
        column: usize,
    },
    /// An argument of a step.
    Argument,
}

/// The values that a setting may have. Each range excludes NaN and infinities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SettingRange {
    /// Any finite number.
    Finite,
    /// Zero or above.
    NotNegative,
    /// Above zero.
    Positive,
    /// From zero to one.
    UpToOne,
    /// The rotation of a pose: R^T R is the identity within 1e-3, and the determinant is positive.
    Rotation,
    /// At least two rows and two columns, without a rest.
    Grid,
}

/// How far an entry of R^T R may be from the identity's entry: files often have three digits.
const ORTHONORMAL: f64 = 1e-3;

/// The names and the ranges of [`ConstraintSettings::numbers`].
const SETTINGS: [(&str, SettingRange); ConstraintSettings::<f64>::COUNT] = [
    ("alpha", SettingRange::NotNegative),
    ("beta", SettingRange::NotNegative),
    ("tolerance", SettingRange::NotNegative),
    ("rounding", SettingRange::NotNegative),
];

/// The names, the ranges and the counts of the numbers of [`ContactTarget::numbers`].
const TARGET: [(&str, SettingRange, usize); 9] = [
    ("rotation", SettingRange::Finite, 9),
    ("translation", SettingRange::Finite, 3),
    ("velocity", SettingRange::Finite, 6),
    ("tangential", SettingRange::NotNegative, 1),
    ("alpha", SettingRange::NotNegative, 1),
    ("beta", SettingRange::NotNegative, 1),
    ("compliance", SettingRange::NotNegative, 1),
    ("restitution", SettingRange::UpToOne, 1),
    ("weight", SettingRange::Positive, 1),
];

/// The names and the ranges of [`StepSettings::numbers`].
const STEP_SETTINGS: [(&str, SettingRange); StepSettings::<f64>::COUNT] = [
    ("tolerance", SettingRange::Positive),
    ("impratio", SettingRange::Positive),
    ("coulomb", SettingRange::UpToOne),
];

/// The names, the ranges and the counts of the numbers of [`ContactSurface::numbers`].
const SURFACE: [(&str, SettingRange, usize); 9] = [
    ("rotation", SettingRange::Finite, 9),
    ("translation", SettingRange::Finite, 3),
    ("radius", SettingRange::NotNegative, 1),
    ("friction", SettingRange::NotNegative, 1),
    ("torsional_friction", SettingRange::NotNegative, 1),
    ("rolling_friction", SettingRange::NotNegative, 1),
    ("margin", SettingRange::Finite, 1),
    ("solref", SettingRange::Finite, 2),
    ("solimp", SettingRange::Finite, 4),
];

impl SettingRange {
    /// Returns whether a number is within the range.
    fn contains(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::NotNegative => value >= 0.0,
                Self::Positive => value > 0.0,
                Self::UpToOne => (0.0..=1.0).contains(&value),
                Self::Finite | Self::Rotation | Self::Grid => true,
            }
    }

    /// Checks a number.
    ///
    /// # Errors
    ///
    /// If the number is not within the range.
    pub fn check(
        self,
        name: &'static str,
        place: SettingPlace,
        value: f64,
    ) -> Result<(), SettingError> {
        match self.contains(value) {
            true => Ok(()),
            false => Err(SettingError { name, place, value, range: self }),
        }
    }
}

/// Checks that the columns of a matrix, which is given by rows, are orthonormal and right-handed.
fn check_rotation(matrix: &[f64], place: SettingPlace) -> Result<(), SettingError> {
    let column = |k: usize| [matrix[k], matrix[3 + k], matrix[6 + k]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let wrong =
        |value| SettingError { name: "rotation", place, value, range: SettingRange::Rotation };
    for k in 0..9 {
        let expected = if k / 3 == k % 3 { 1.0 } else { 0.0 };
        let entry = dot(column(k / 3), column(k % 3));
        if (entry - expected).abs() > ORTHONORMAL {
            return Err(wrong(entry));
        }
    }
    let [a, b, c] = [column(0), column(1), column(2)];
    let normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let determinant = dot(normal, c);
    if determinant > 0.0 { Ok(()) } else { Err(wrong(determinant)) }
}

/// Checks the numbers of settings: [`ConstraintSettings::numbers`], then [`ContactTarget::numbers`]
/// for each contact.
///
/// # Errors
///
/// If a number is not finite or outside of its range.
pub fn check_settings<T: Copy + Into<f64>>(numbers: &[T]) -> Result<(), SettingError> {
    let (settings, targets) = numbers.split_at(SETTINGS.len().min(numbers.len()));
    for ((name, range), &number) in SETTINGS.iter().zip(settings) {
        range.check(name, SettingPlace::Settings, number.into())?;
    }
    for (contact, target) in targets.chunks_exact(ContactTarget::<f64>::COUNT).enumerate() {
        check_numbers(SettingPlace::Target(contact), &TARGET, target)?;
    }
    Ok(())
}

/// Checks the numbers of the settings of steps: [`StepSettings::numbers`], then
/// [`ContactSurface::numbers`] for each contact.
///
/// # Errors
///
/// If a number is not finite or outside of its range.
pub fn check_step_settings<T: Copy + Into<f64>>(numbers: &[T]) -> Result<(), SettingError> {
    let (settings, surfaces) = numbers.split_at(STEP_SETTINGS.len().min(numbers.len()));
    for ((name, range), &number) in STEP_SETTINGS.iter().zip(settings) {
        range.check(name, SettingPlace::Settings, number.into())?;
    }
    for (shape, surface) in surfaces.chunks_exact(ContactSurface::<f64>::COUNT).enumerate() {
        check_numbers(SettingPlace::Surface(shape), &SURFACE, surface)?;
    }
    Ok(())
}

/// Checks the numbers of a target or a surface, which begin with a rotation, by their names, ranges
/// and counts.
fn check_numbers<T: Copy + Into<f64>>(
    place: SettingPlace,
    rows: &[(&'static str, SettingRange, usize)],
    given: &[T],
) -> Result<(), SettingError> {
    let mut numbers = given.iter().map(|&number| number.into());
    for &(name, range, count) in rows {
        for number in numbers.by_ref().take(count) {
            range.check(name, place, number)?;
        }
    }
    let mut rotation = [0.0; 9];
    rotation.iter_mut().zip(given).for_each(|(entry, &number)| *entry = number.into());
    check_rotation(&rotation, place)
}

impl<T: Copy + Into<f64>, C: AsRef<[ContactTarget<T>]>> ConstraintSettings<T, C> {
    /// Checks that all settings are finite and within their ranges: friction, compliance, `alpha`,
    /// `beta`, `tolerance`, `rounding` and `tangential` are not negative, the weight is above zero,
    /// the restitution is at most 1, and rotations are rotations.
    ///
    /// Functions do not check their settings, since some are called in real time: NaN gives NaN.
    ///
    /// # Errors
    ///
    /// The first setting that is not.
    pub fn check(&self) -> Result<(), SettingError> {
        check_settings(&self.numbers())?;
        self.targets.as_ref().iter().enumerate().try_for_each(|(contact, target)| {
            check_numbers(SettingPlace::Target(contact), &TARGET, &target.numbers())
        })
    }
}

impl<T: Copy + Into<f64>> ContactSurface<T> {
    /// Checks that all settings are finite and within their ranges.
    ///
    /// # Errors
    ///
    /// The first setting that is not.
    pub fn check(&self) -> Result<(), SettingError> {
        check_numbers(SettingPlace::Surface(0), &SURFACE, &self.numbers())
    }
}

impl<T: Copy + Into<f64>, C: AsRef<[ContactSurface<T>]>> StepSettings<T, C> {
    /// Checks that all settings are finite and within their ranges: the tolerance and `impratio`
    /// are above zero, `coulomb` is from 0 to 1, radii and frictions are not negative, and rotations
    /// are rotations.
    ///
    /// # Errors
    ///
    /// The first setting that is not.
    pub fn check(&self) -> Result<(), SettingError> {
        check_step_settings(&self.numbers())?;
        self.surfaces.as_ref().iter().enumerate().try_for_each(|(shape, surface)| {
            check_numbers(SettingPlace::Surface(shape), &SURFACE, &surface.numbers())
        })
    }
}

impl fmt::Display for SettingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, place, value, range } = self;
        write!(f, "`{name}`")?;
        match place {
            SettingPlace::Settings => write!(f, " of `settings`")?,
            SettingPlace::Target(contact) => write!(f, " of `settings.targets[{contact}]`")?,
            SettingPlace::Surface(shape) => write!(f, " of `settings.surfaces[{shape}]`")?,
            SettingPlace::HeightField => write!(f, " of the height field")?,
            SettingPlace::Height { row, column } => {
                write!(f, "[{row}, {column}] of the height field")?
            }
            SettingPlace::Argument => {}
        }
        match range {
            SettingRange::Rotation => write!(
                f,
                " is no rotation: R^T R must be the identity within 1e-3, with determinant 1, and has {value}"
            ),
            SettingRange::Grid => write!(
                f,
                " has {value} values; expected at least two full rows of at least two columns"
            ),
            range => write!(f, " is {value}; expected {range}"),
        }
    }
}

impl fmt::Display for SettingRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Finite => "a finite number",
            Self::NotNegative => "a finite number that is not negative",
            Self::Positive => "a finite number above 0",
            Self::UpToOne => "a number from 0 to 1",
            Self::Rotation => "a rotation",
            Self::Grid => "at least two full rows of at least two columns",
        })
    }
}

impl core::error::Error for SettingError {}

#[cfg(test)]
mod tests {
    use super::{SettingPlace, TARGET, check_settings};
    use crate::{ConstraintSettings, ContactTarget};

    const COUNT: usize = 4 + 2 * 24;

    /// Returns the default settings of two contacts.
    fn numbers() -> [f64; COUNT] {
        let settings = ConstraintSettings::<f64, [ContactTarget<f64>; 2]>::DEFAULT;
        let mut numbers = [0.0; COUNT];
        let targets = settings.targets.iter().flat_map(|target| target.numbers());
        let all = settings.numbers().into_iter().chain(targets);
        numbers.iter_mut().zip(all).for_each(|(place, number)| *place = number);
        numbers
    }

    /// Returns the name and the place of each number.
    fn names() -> [(&'static str, SettingPlace); COUNT] {
        let names = ["alpha", "beta", "tolerance", "rounding"];
        let settings = names.into_iter().map(|name| (name, SettingPlace::Settings));
        let target = |contact| {
            TARGET.iter().flat_map(move |&(name, _, count)| {
                core::iter::repeat_n((name, SettingPlace::Target(contact)), count)
            })
        };
        let mut all = settings.chain(target(0)).chain(target(1));
        core::array::from_fn(|_| all.next().unwrap_or(("", SettingPlace::Settings)))
    }

    /// Changes each number in turn; the error must name the number that was changed.
    #[test]
    fn every_number_is_checked() {
        assert_eq!(check_settings(&numbers()), Ok(()));
        for (k, expected) in names().into_iter().enumerate() {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut numbers = numbers();
                numbers[k] = value;
                let error = check_settings(&numbers).expect_err("not finite");
                assert_eq!((error.name, error.place), expected, "{k}: {error}");
                assert_eq!(error.value.to_bits(), value.to_bits(), "{k}: {error}");
            }
        }
    }

    /// The borders of each range of a single number, within and beyond.
    #[test]
    fn ranges_end_where_the_error_says() {
        let ranges = [
            ("alpha", [0.0, 1e9], [-1e-9, f64::NAN]),
            ("beta", [0.0, 1e9], [-1e-9, f64::NAN]),
            ("tolerance", [0.0, 1.0], [-1e-9, f64::NAN]),
            ("rounding", [0.0, 1.0], [-1e-9, f64::NAN]),
            ("tangential", [0.0, 1.0], [-1e-9, f64::NAN]),
            ("compliance", [0.0, 1e9], [-1e-9, f64::NAN]),
            ("restitution", [0.0, 1.0], [-1e-9, 1.0 + 1e-9]),
            ("weight", [1e-9, 1e9], [0.0, -1.0]),
            ("translation", [-1e9, 1e9], [f64::NEG_INFINITY, f64::NAN]),
            ("velocity", [-1e9, 1e9], [f64::NEG_INFINITY, f64::NAN]),
        ];
        for (k, (name, _)) in names().into_iter().enumerate() {
            let Some((_, within, beyond)) = ranges.iter().find(|row| row.0 == name) else {
                assert_eq!(name, "rotation");
                continue;
            };
            let with = |value: f64| {
                let mut numbers = numbers();
                numbers[k] = value;
                check_settings(&numbers).is_ok()
            };
            assert!(within.iter().all(|&value| with(value)), "{name}");
            assert!(!beyond.iter().any(|&value| with(value)), "{name}");
        }
    }

    #[test]
    fn rotations_are_orthonormal_and_right_handed() {
        let mut ground = ContactTarget::<f64>::GROUND;
        let mut is_allowed = |rotation: [[f64; 3]; 3]| {
            ground.pose.rotation = rotation;
            let settings = ConstraintSettings::<f64, [_; 1]>::DEFAULT;
            ConstraintSettings { targets: [ground], ..settings }.check().is_ok()
        };
        assert!(is_allowed([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]));
        // Three digits, as in many files.
        assert!(is_allowed([[0.707, -0.707, 0.0], [0.707, 0.707, 0.0], [0.0, 0.0, 1.0]]));
        assert!(!is_allowed([[0.0; 3]; 3]));
        assert!(!is_allowed([[5.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 5.0]]));
        assert!(!is_allowed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]));
        assert!(!is_allowed([[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]));
    }
}
