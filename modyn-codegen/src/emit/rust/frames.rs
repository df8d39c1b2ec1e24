//! The functions of links: of single links, and of links that share a function and a table of
//! placements.

use std::fmt::Write as _;

use super::function::{function, literal};
use super::parameter::Parameter;
use super::quantity::Quantity;
use super::shape::Shape;
use super::{FloatType, Robot};
use crate::plan::{Frames, LinkProgram};
use crate::program::Program;

/// The name of the table of placements in the generated text.
const TABLE: &str = "__PLACEMENTS";

/// The name of the parameter for a row of the table.
const PARAMETER: &str = "placement";

impl Robot<'_> {
    /// Prints the functions of single links and the functions that links share.
    pub(super) fn link_functions(
        &self,
        text: &mut String,
        quantity: &Quantity<'_>,
        programs: &[Program],
    ) {
        let frames = &self.plan.frames;
        let float = self.options.scalar;
        let name = quantity.name;
        let mut parameters = quantity.all_parameters();
        let (known, shared) = programs.split_at(frames.links_with_own_program().count());
        for (link, program) in frames.links_with_own_program().zip(known) {
            let name = format!("{name}_{link}");
            *text += &function(&name, &parameters, &quantity.shape, program, float);
        }
        parameters.push(placement(float));
        for (body, program) in shared.iter().enumerate() {
            let name = format!("{name}_on_{body}");
            *text += &function(&name, &parameters, &quantity.shape, program, float);
        }
    }

    /// Returns the call of the function that has the code for `link`.
    pub(super) fn link_call(&self, name: &str, link: usize, arguments: &str) -> String {
        let LinkProgram { program, placement } = self.plan.frames.programs()[link];
        match placement {
            None => format!("{name}_{link}({arguments})"),
            Some(row) => {
                let body = program - self.plan.frames.links_with_own_program().count();
                format!("{name}_on_{body}({arguments}, &{TABLE}[{row}])")
            }
        }
    }

    /// Prints the function of the poses of all links, from the functions for `bodies` and for links
    /// `placed` on them.
    pub(super) fn poses_function(
        &self,
        text: &mut String,
        quantity: &Quantity<'_>,
        bodies: &Program,
        placed: &Program,
    ) {
        let frames = &self.plan.frames;
        let float = self.options.scalar;
        let name = quantity.name;
        let parameters = quantity.all_parameters();
        let shape = Shape::new(&frames.poses_of_bodies(), self.name);
        *text += &function(&format!("{name}_of_bodies"), &parameters, &shape, bodies, float);
        let pose = Shape::new(&crate::plan::Shape::pose(), self.name);
        let of_placed = [Parameter::new("body", pose.clone()), placement(float)];
        *text += &function(&format!("{name}_placed"), &of_placed, &pose, placed, float);
        let pose = |LinkProgram { program, placement }: &LinkProgram| match placement {
            None => format!("bodies[{program}],\n"),
            Some(row) => format!("{name}_placed(&bodies[{program}], &{TABLE}[{row}]),\n"),
        };
        let each = frames.programs().iter().map(pose);
        let poses: String = each.collect();
        let typed: Vec<String> = parameters.iter().map(|p| p.typed("T")).collect();
        let names: Vec<&str> = parameters.iter().map(|p| p.name).collect();
        let _ = writeln!(
            text,
            "fn {name}<T: __modyn::Scalar>({}) -> {} {{\n    let bodies = \
             {name}_of_bodies({});\n    [\n{poses}    ]\n}}\n",
            typed.join(", "),
            quantity.shape.type_of("T"),
            names.join(", "),
        );
    }

    /// Prints the table of placements: the pose on its body of each link with a shared function.
    pub(super) fn placements(&self, text: &mut String) {
        let frames = &self.plan.frames;
        let float = self.options.scalar;
        let lines = frames.placements().map(|numbers| {
            let numbers: Vec<String> = numbers.iter().map(|&x| literal(x, float)).collect();
            format!("[{}],\n", numbers.join(", "))
        });
        let rows: String = lines.collect();
        let _ = writeln!(
            text,
            "static {TABLE}: [[{}; {}]; {}] = [\n{rows}];\n",
            float.name(),
            Frames::PLACEMENT,
            frames.rows(),
        );
    }
}

fn placement(float: FloatType) -> Parameter {
    Parameter::constants(PARAMETER, Shape::vector(Frames::PLACEMENT), float.name())
}
