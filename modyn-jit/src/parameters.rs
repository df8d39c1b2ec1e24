//! The parameters of a robot that can be changed at run time: gravity, inertias of links, and
//! payloads.

use std::fmt;

use modyn_codegen::plan::Plan;
use modyn_codegen::program::Program;
use modyn_codegen::trace::Parameters;
use modyn_runtime::model::{Inertial, Model};
use modyn_runtime::{InertialDefect, Scalar};

use crate::real::Real;

/// The reason why a parameter was not changed.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ParameterError<S> {
    /// The robot was compiled without this parameter.
    NotAParameter {
        /// The option of the `Builder` that makes it a run-time parameter.
        option: &'static str,
        /// The link; `None` for gravity.
        link: Option<String>,
    },
    /// No rigid body has this inertia.
    Defect(InertialDefect<S>),
    /// A joint would have no inertia, so that its acceleration would be infinite.
    NoInertia {
        /// The name of the joint.
        joint: String,
    },
    /// A component of gravity is infinite or NaN.
    Gravity,
}

impl<S: Real> fmt::Display for ParameterError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAParameter { option, link: Some(link) } => write!(
                f,
                "link `{link}` has no `{option}`: name it in `Builder::{option}` before the robot is compiled"
            ),
            Self::NotAParameter { option, link: None } => {
                write!(
                    f,
                    "gravity is a constant: call `Builder::{option}` before the robot is compiled"
                )
            }
            Self::Defect(defect) => defect.fmt(f),
            Self::NoInertia { joint } => write!(
                f,
                "joint `{joint}` would move no inertia that it alone would feel, so its acceleration would be \
                 infinite; give a link that it moves a mass, and a rotational inertia if it turns"
            ),
            Self::Gravity => write!(f, "gravity has three finite components, m/s^2"),
        }
    }
}

impl<S: Real> std::error::Error for ParameterError<S> {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Defect(defect) => Some(defect),
            _ => None,
        }
    }
}

/// The numbers of the parameters, and their meaning.
pub(crate) struct RunTimeParameters<S> {
    pub numbers: Vec<S>,
    parameters: Parameters,
    /// The joints without inertia if all run-time inertias are zero, and the program that computes
    /// each joint's inertia.
    pivots: Option<(Vec<String>, Program)>,
}

impl<S: Real> RunTimeParameters<S> {
    /// Returns the parameters with the numbers of the description.
    pub fn new(plan: &Plan, model: &Model) -> Self {
        let numbers = plan.parameters.described(model.gravity());
        let joint = |v: &usize| {
            let is_independent =
                |i: &usize| model.mimic(*i).is_none() && model.v_range(*i).contains(v);
            let link = (0..model.moving_links().len()).find(is_independent);
            link.map_or(String::new(), |link| model.moving_links()[link].joint.name.clone())
        };
        let pivots = plan.inertia_pivots.as_ref();
        Self {
            numbers: numbers.into_iter().map(S::from_f64).collect(),
            parameters: plan.parameters.clone(),
            pivots: pivots
                .map(|(entries, program)| (entries.iter().map(joint).collect(), program.clone())),
        }
    }

    pub fn set_gravity(&mut self, gravity: [S; 3]) -> Result<(), ParameterError<S>> {
        if !self.parameters.gravity {
            let option = "runtime_gravity";
            return Err(ParameterError::NotAParameter { option, link: None });
        }
        if !gravity.iter().all(|x| x.has_value()) {
            return Err(ParameterError::Gravity);
        }
        self.numbers[..3].copy_from_slice(&gravity);
        Ok(())
    }

    /// Sets the inertia of a link itself, or the payload on it.
    pub fn set_inertial(
        &mut self,
        model: &Model,
        is_payload: bool,
        link: &str,
        inertial: &Inertial<S>,
    ) -> Result<(), ParameterError<S>> {
        let index = model.links().iter().position(|other| other.name == link);
        let inertias = self.parameters.inertias.iter().map(|(index, _)| *index);
        let payloads = self.parameters.payloads.iter().copied();
        let (option, place) = if is_payload {
            let place = payloads.into_iter().position(|other| Some(other) == index);
            ("payload", place.map(|place| self.parameters.inertias.len() + place))
        } else {
            ("runtime_inertia", inertias.into_iter().position(|other| Some(other) == index))
        };
        let Some(place) = place else {
            return Err(ParameterError::NotAParameter { option, link: Some(link.into()) });
        };
        if let Some(defect) = inertial.defect() {
            return Err(ParameterError::Defect(defect));
        }
        let Inertial { mass, center_of_mass, inertia } = *inertial;
        let new = [mass].into_iter().chain(center_of_mass).chain(inertia);
        let mut numbers = self.numbers.clone();
        for (number, new) in numbers[self.parameters.inertial(place)..].iter_mut().zip(new) {
            *number = new;
        }
        if let Some((joints, program)) = &self.pivots {
            // The difference between 1 and the next larger number.
            let third = S::from_f64(4.0) / S::from_f64(3.0) - S::one();
            let epsilon = Scalar::abs(third + third + third - S::one());
            let pivots = program.evaluate(&[&[epsilon], &*numbers].concat());
            let moves_inertia = |pivot: &S| *pivot > S::zero();
            if let Some((_, joint)) =
                pivots.iter().zip(joints).rev().find(|(p, _)| !moves_inertia(p))
            {
                return Err(ParameterError::NoInertia { joint: joint.clone() });
            }
        }
        self.numbers = numbers;
        Ok(())
    }
}
