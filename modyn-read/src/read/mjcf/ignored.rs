//! Warnings of what acts in `MuJoCo`'s steps and not in the function `step`, or in no other function.

use std::collections::BTreeMap;

use crate::diagnostics::{Code, Place, Report};

/// The places of what acts in `MuJoCo`'s steps and not in `step`, or in no function but `step`.
#[derive(Default)]
pub struct Ignored {
    /// Height fields that a geom touches.
    pub fields: Vec<Place>,
    /// Geoms that touch a plane and whose contacts are not computed, by the reason.
    pub untouched: BTreeMap<String, Vec<Place>>,
    /// Geoms and pairs with parameters that are not read.
    pub parameters: Vec<Place>,
    /// Contacts with other friction along the second tangent.
    pub anisotropic: Vec<Place>,
    /// Curves of impedance whose power is no integer.
    pub powers: Vec<Place>,
    /// Integrators that make other steps than `Euler`.
    pub explicit_integrators: Vec<Place>,
    /// Integrators that make other steps than `implicitfast`.
    pub implicit_integrators: Vec<Place>,
    /// Options of the solver, by their names.
    pub options: BTreeMap<String, Vec<Place>>,
    /// Tendons with limits that do not act in steps.
    pub tendons: Vec<Place>,
    /// Couplings of joints and tendons that act in steps only.
    pub couplings: Vec<Place>,
}

impl Ignored {
    /// Adds an integrator if none of `step` makes its steps.
    pub fn integrator(&mut self, name: &str, place: Place) {
        match name {
            "RK4" => self.explicit_integrators.push(place),
            "implicit" => self.implicit_integrators.push(place),
            _ => {}
        }
    }

    /// Warns once of each kind.
    pub fn report(self, report: &mut Report<'_>) {
        let Self {
            fields,
            untouched,
            parameters,
            anisotropic,
            powers,
            explicit_integrators,
            implicit_integrators,
            options,
            tendons,
            couplings,
        } = self;
        let mut warn = |mut places: Vec<Place>, message: &str, help: &str| {
            places.sort_by_key(|(at, _)| *at);
            places.dedup();
            report.warn_once(Code::NotRead, &places, message, help);
        };
        warn(
            fields,
            "a height field does not stop the robot in `step`",
            "use a plane, or steps on the ground with a `HeightField` of the caller",
        );
        warn(
            parameters,
            "`adhesion`, `surfacevel` and `solreffriction` of contacts have no effect in `step`",
            "write zeros; apply the forces of adhesion and of moving surfaces as external wrenches",
        );
        warn(
            anisotropic,
            "contacts have in `step` the friction of the first tangent in all directions",
            "write the same coefficient for both tangents, and for both directions of rolling",
        );
        warn(
            powers,
            "the power of `solimp` is rounded to an integer",
            "write an integer as the fifth number; contacts mix the powers of two geoms",
        );
        warn(
            explicit_integrators,
            "`step` has the integrator `Euler` in place of `RK4`",
            "write `integrator=\"Euler\"` or `\"implicitfast\"`; or simulate without contacts by `step_rk4`",
        );
        warn(
            implicit_integrators,
            "`step` has the integrator `implicitfast` in place of `implicit`: Coriolis and centrifugal forces act with \
             the velocities before the step",
            "write `integrator=\"implicitfast\"`, which MuJoCo recommends, to compare with MuJoCo",
        );
        warn(
            tendons,
            "the limits of a tendon that is not `<fixed>` do not act in `step`",
            "limit its joints by `range`, or write `limited=\"false\"` if the tendon never reaches them",
        );
        warn(
            couplings,
            "a coupling of joints by a polynomial of a degree above one, or of more than two joints, acts in \
             `step` only: in all other functions its joints move freely",
            "couple two joints linearly, for all functions; or write `active=\"false\"`, for no function",
        );
        for (option, places) in options {
            let message = format!("`{option}` changes the steps of MuJoCo, and not `step`");
            warn(places, &message, "leave it out to compare with MuJoCo");
        }
        for (why, places) in untouched {
            let message = format!("a geom does not touch the ground in `step`: {why}");
            let help = "give the body a geom of another type for its contacts";
            warn(places, &message, help);
        }
    }
}
