//! Links that are fixed to one body share the code of their functions.
//!
//! The first few links of a body have functions of their own, in which their placements are folded. All others
//! of the body share one function, to which their placement on the body is an argument: a row of a table. So
//! the text grows by a row and a call for each further link, whatever the functions compute.

use std::fmt::Write as _;

use modyn_runtime::mechanism::{BodyFrame, Mechanism};
use modyn_runtime::spatial::Pose;

use super::FloatType;
use super::function::{Parameter, function};
use super::quantities::Quantity;
use super::shape::Shape;
use super::shared::figure;
use crate::expr::Graph;
use crate::trace::{LinkFrame, Tracer};

/// Most links of one body that have functions of their own.
pub(crate) const MAX_OWN_FUNCTIONS: usize = 8;

/// The table of placements, in the generated text.
const TABLE: &str = "__PLACEMENTS";

/// The parameter for a row of the table.
const PARAMETER: &str = "placement";

/// Where the code of a link's functions is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Code {
    /// A function of its own.
    Own,
    /// The function of all links on its body, with this row of the table.
    Shared(usize),
}

/// The links of a robot, by the code that they have.
pub(super) struct Frames {
    /// The robot without its links, to which a kernel's one is added.
    bare: Mechanism<f64>,
    frames: Vec<BodyFrame<f64>>,
    codes: Vec<Code>,
    /// The bodies with links that share a function.
    shared: Vec<Option<usize>>,
}

impl Frames {
    pub(super) fn new(prepared: &Mechanism<f64>) -> Self {
        // By body, the world first.
        let mut counts = vec![0; prepared.bodies.len() + 1];
        let (mut codes, mut shared, mut rows) = (Vec::new(), Vec::new(), 0);
        for frame in &prepared.frames {
            let count = &mut counts[frame.body.map_or(0, |body| body + 1)];
            *count += 1;
            codes.push(if *count <= MAX_OWN_FUNCTIONS {
                Code::Own
            } else {
                rows += 1;
                Code::Shared(rows - 1)
            });
            if *count == MAX_OWN_FUNCTIONS + 1 {
                shared.push(frame.body);
            }
        }
        let bare = Mechanism { frames: Vec::new(), ..prepared.clone() };
        Self { bare, frames: prepared.frames.clone(), codes, shared }
    }

    /// The robot without its links.
    pub(super) fn bare(&self) -> &Mechanism<f64> {
        &self.bare
    }

    /// Whether links share functions.
    pub(super) fn any_shared(&self) -> bool {
        !self.shared.is_empty()
    }

    /// The links with code of their own, each by its index.
    fn own(&self) -> impl Iterator<Item = usize> {
        (0..self.codes.len()).filter(|&link| self.codes[link] == Code::Own)
    }

    /// What `of` makes of each kernel's tracer, which has one link: first those of single links, then those
    /// that links share.
    pub(super) fn kernels(&self, of: impl Fn(&Tracer<'_>) -> Graph) -> Vec<Graph> {
        let own = self.own().map(|link| LinkFrame::Known(self.frames[link]));
        let all = own.chain(self.shared.iter().copied().map(LinkFrame::On));
        all.map(|frame| of(&Tracer::with_link(&self.bare, frame))).collect()
    }

    /// The poses of the links with code of their own and of the bodies with links that share a function, and
    /// the pose of such a link from that of its body.
    pub(super) fn poses(&self) -> [Graph; 2] {
        let own = self.own().map(|link| self.frames[link]);
        let bodies = self.shared.iter().map(|&body| BodyFrame { body, pose: Pose::identity() });
        let model = Mechanism { frames: own.chain(bodies).collect(), ..self.bare.clone() };
        [Tracer::new(&model).link_poses(), Tracer::placed_pose()]
    }

    /// How many links share a function.
    pub(super) fn rows(&self) -> usize {
        self.codes.iter().filter(|code| **code != Code::Own).count()
    }

    /// The functions of single links and those that links share, by `graphs` of [`kernels`](Self::kernels).
    pub(super) fn functions(
        &self,
        text: &mut String,
        quantity: &Quantity,
        graphs: &[Graph],
        float: FloatType,
    ) {
        let name = quantity.function.name();
        let (own, shared) = graphs.split_at(self.codes.len() - self.rows());
        for (link, graph) in self.own().zip(own) {
            let name = format!("{name}_{link}");
            *text += &function(&name, &quantity.parameters, &quantity.shape, graph);
        }
        let mut parameters = quantity.parameters.clone();
        parameters.push(parameter(float));
        for (body, graph) in shared.iter().enumerate() {
            let name = format!("{name}_on_{body}");
            *text += &function(&name, &parameters, &quantity.shape, graph);
        }
    }

    /// The call of the function that has the code for `link`.
    pub(super) fn call(&self, name: &str, link: usize, arguments: &str) -> String {
        match self.codes[link] {
            Code::Own => format!("{name}_{link}({arguments})"),
            Code::Shared(row) => {
                format!("{name}_on_{}({arguments}, &{TABLE}[{row}])", self.shared_place(link))
            }
        }
    }

    /// Where the body of `link` stands among those with links that share a function.
    fn shared_place(&self, link: usize) -> usize {
        let body = self.frames[link].body;
        self.shared.iter().position(|&other| other == body).unwrap_or_default()
    }

    /// `link_poses`, by `graphs` of [`poses`](Self::poses).
    pub(super) fn poses_function(
        &self,
        text: &mut String,
        quantity: &Quantity,
        graphs: &[Graph; 2],
        float: FloatType,
    ) {
        let (name, links) = (quantity.function.name(), self.codes.len());
        let own = links - self.rows();
        let bodies = Shape::pose().array(own + self.shared.len());
        *text += &function(&format!("{name}_of_bodies"), &quantity.parameters, &bodies, &graphs[0]);
        let placed = [Parameter::new("body", Shape::pose()), parameter(float)];
        *text += &function(&format!("{name}_placed"), &placed, &Shape::pose(), &graphs[1]);
        let mut next = 0;
        let poses = (0..links).map(|link| match self.codes[link] {
            Code::Own => {
                next += 1;
                format!("bodies[{}],\n", next - 1)
            }
            Code::Shared(row) => {
                let body = own + self.shared_place(link);
                format!("{name}_placed(&bodies[{body}], &{TABLE}[{row}]),\n")
            }
        });
        let poses: String = poses.collect();
        let typed: Vec<String> = quantity.parameters.iter().map(|p| p.typed("T")).collect();
        let names: Vec<&str> = quantity.parameters.iter().map(|p| p.name).collect();
        let _ = writeln!(
            text,
            "fn {name}<T: __modyn::Scalar>({}) -> {} {{\n    let bodies = {name}_of_bodies({});\n    [\n{poses}    ]\n}}\n",
            typed.join(", "),
            quantity.shape.type_of("T"),
            names.join(", "),
        );
    }

    /// The table of placements: of each link that shares a function, its pose on its body.
    pub(super) fn table(&self, text: &mut String, float: FloatType) {
        let shared = self.frames.iter().zip(&self.codes).filter(|(_, code)| **code != Code::Own);
        let rows = shared.map(|(frame, _)| {
            let numbers = frame.pose.rotation.iter().flatten().chain(&frame.pose.translation);
            let numbers: Vec<String> = numbers.map(|&x| figure(x, float)).collect();
            format!("[{}],\n", numbers.join(", "))
        });
        let (count, rows) = (self.rows(), rows.collect::<String>());
        let _ = writeln!(
            text,
            "static {TABLE}: [[{}; {PLACEMENT}]; {count}] = [\n{rows}];\n",
            float.name()
        );
    }
}

/// The numbers of a placement: nine of a rotation, then three of a translation.
const PLACEMENT: usize = 12;

fn parameter(float: FloatType) -> Parameter {
    Parameter::constants(PARAMETER, Shape::vector(PLACEMENT), float.name())
}
