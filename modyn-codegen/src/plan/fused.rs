//! Fused functions: several functions in one, whose common work is done once.
//!
//! The graph of a fused function is the union of the graphs of its members, traced over the same
//! inputs: the arguments of all members by name, each once, then the run-time parameters. Equal
//! nodes of the graphs are one node of the union.
//!
//! A function of one link may have a second graph that shares more with the other members
//! (`in_fused`); the smallest union wins.

use std::collections::BTreeMap;

use modyn_runtime::quantities::{ARGUMENTS, Argument, Function, Record, Shape, Sizes};

use super::context::PlanContext;
use super::functions::{CForm, Lowering};
use super::user::TracedForm;
use super::wrapped::wrapped;
use crate::graph::{Graph, Id};
use crate::intern::intern;
use crate::names;
use crate::trace::Tracer;

/// A fused function.
#[derive(Clone, Debug)]
pub struct FusedFunction {
    /// The name, in snake case.
    pub name: &'static str,
    /// The functions, in the order of the result.
    pub members: Vec<Member>,
    /// Whether the fused function also has its form for many states.
    pub batch: bool,
}

/// A function in a fused function.
#[derive(Clone, Debug)]
pub struct Member {
    /// The function, one of a single state.
    pub function: MemberFunction,
    /// The field of the result.
    pub field: &'static str,
    /// The function in words.
    pub docs: &'static str,
}

/// The function of a member.
#[derive(Clone, Debug)]
pub enum MemberFunction {
    /// A function of the table.
    Table {
        /// The function.
        function: Function,
        /// The link of a function of one link, as an index into the model's links.
        link: Option<usize>,
    },
    /// A form of a user's function.
    User {
        /// The form.
        form: Box<TracedForm>,
        /// Whether it depends on run-time parameters.
        depends_on_parameters: bool,
    },
}

impl MemberFunction {
    /// Returns the function of the table; `None` for a user's.
    #[must_use]
    pub const fn of_table(&self) -> Option<Function> {
        match self {
            Self::Table { function, .. } => Some(*function),
            Self::User { .. } => None,
        }
    }

    /// Returns the arguments.
    pub(crate) fn arguments(&self) -> &[Argument] {
        match self {
            Self::Table { function, .. } => function.row().arguments,
            Self::User { form, .. } => &form.arguments,
        }
    }

    fn result(&self, sizes: &Sizes) -> Shape {
        match self {
            Self::Table { function, .. } => (function.row().result)(sizes),
            Self::User { form, .. } => form.result.clone(),
        }
    }

    fn depends_on_parameters(&self) -> bool {
        match self {
            Self::Table { function, .. } => function.row().depends_on_parameters,
            Self::User { depends_on_parameters, .. } => *depends_on_parameters,
        }
    }
}

impl Member {
    /// Returns the documentation of the field.
    pub(super) fn field_docs(&self) -> &'static str {
        intern(&format!("The result of {}.", self.docs))
    }
}

impl FusedFunction {
    /// Returns the arguments of all members, each once: the table's arguments, then other arguments
    /// of users' functions.
    pub(super) fn arguments(&self) -> Vec<Argument> {
        let arguments = || self.members.iter().flat_map(|member| member.function.arguments());
        let of_a_member =
            |argument: &&Argument| arguments().any(|arguments| arguments.name == argument.name);
        let mut all: Vec<Argument> = ARGUMENTS.iter().filter(of_a_member).copied().collect();
        for argument in arguments() {
            if all.iter().all(|other| other.name != argument.name) {
                all.push(*argument);
            }
        }
        all
    }

    /// Returns the layout of the result: a field for each member.
    pub(super) fn result(&self, sizes: &Sizes) -> Shape {
        let field = |member: &Member| (member.field, member.function.result(sizes));
        let name = intern(&names::type_name(self.name));
        Shape::Record(Record::Fused(name), self.members.iter().map(field).collect())
    }

    /// Returns whether a member of the table has this property.
    pub(super) fn any(&self, property: impl Fn(Function) -> bool) -> bool {
        let mut of_table = self.members.iter().filter_map(|member| member.function.of_table());
        of_table.any(property)
    }

    /// Returns whether a member depends on run-time parameters.
    pub(super) fn depends_on_parameters(&self) -> bool {
        self.members.iter().any(|member| member.function.depends_on_parameters())
    }

    /// Returns the forms that C can call: the forms that all members have.
    pub(super) fn c_form(&self) -> CForm {
        match self.any(|function| Lowering::of(function).c_form == CForm::Source) {
            true => CForm::Source,
            false => CForm::SourceAndExport,
        }
    }

    /// Returns the documentation of the form for one state.
    pub(super) fn docs(&self) -> &'static str {
        let members: Vec<&str> = self.members.iter().map(|member| member.docs).collect();
        let (last, others) = members.split_last().expect("a fused function has members");
        let list = match others {
            [] => (*last).to_string(),
            _ => format!("{} and {last}", others.join(", ")),
        };
        let text = format!("Returns the results of {list}, with their common work done once.");
        intern(&wrapped(&text))
    }
}

/// The graphs of a fused function on scalars. A function of one link, or of a user, may have
/// several graphs; the choice of the smallest union is made here.
pub(super) struct Graphs<'a> {
    fused: &'a FusedFunction,
    /// The inputs of each argument: the first, and their number.
    inputs: BTreeMap<&'static str, (usize, usize)>,
    /// The inputs of all arguments and run-time parameters.
    count: usize,
    /// The inputs of the arguments.
    arguments: usize,
    /// The graphs of the members, before all passes.
    members: Vec<Graph>,
}

impl<'a> Graphs<'a> {
    /// Traces the members; `parameters` is the number of run-time parameters.
    pub(super) fn new(
        fused: &'a FusedFunction,
        context: &PlanContext<'_>,
        parameters: usize,
    ) -> Self {
        let mut inputs = BTreeMap::new();
        let mut arguments = 0;
        for argument in fused.arguments() {
            let length = argument.shape(&context.sizes).len();
            inputs.insert(argument.name, (arguments, length));
            arguments += length;
        }
        let graphs = |member: &Member| {
            let (function, link) = match &member.function {
                MemberFunction::Table { function, link } => (*function, *link),
                MemberFunction::User { form, .. } => {
                    return [Some(&form.graph), form.in_fused.as_ref()]
                        .into_iter()
                        .flatten()
                        .cloned()
                        .collect();
                }
            };
            let Some(link) = link else { return vec![context.graph(function, &context.tracer)] };
            let evaluation = |tracer: &Tracer<'_>| context.evaluation(function, tracer);
            let in_fused = Lowering::of(function).in_fused;
            let other = in_fused.map(|trace| context.frames.of_link(link, trace));
            [context.frames.of_link(link, evaluation)].into_iter().chain(other).collect()
        };
        let candidates: Vec<Vec<Graph>> = fused.members.iter().map(graphs).collect();
        let count = arguments + parameters;
        let mut all = Self { fused, inputs, count, arguments, members: Vec::new() };
        all.members = all.cheapest(candidates);
        all
    }

    /// Returns a graph of each member, such that their union has few operations. The search starts
    /// with the first graphs of all members and with the last, and changes one member at a time.
    fn cheapest(&self, candidates: Vec<Vec<Graph>>) -> Vec<Graph> {
        let operations = |choice: &[usize]| {
            let members: Vec<&Graph> =
                candidates.iter().zip(choice).map(|(all, &k)| &all[k]).collect();
            self.union(&members).count().total()
        };
        let starts = [
            vec![0; candidates.len()],
            candidates.iter().map(|all| all.len() - 1).collect::<Vec<usize>>(),
        ];
        let improved = starts.into_iter().map(|mut choice| {
            let mut least = operations(&choice);
            for (member, all) in candidates.iter().enumerate().filter(|(_, all)| all.len() > 1) {
                for k in 0..all.len() {
                    let changed = std::mem::replace(&mut choice[member], k);
                    match operations(&choice) {
                        fewer if fewer < least => least = fewer,
                        _ => choice[member] = changed,
                    }
                }
            }
            (least, choice)
        });
        let (_, choice) = improved.min_by_key(|(least, _)| *least).unwrap_or_default();
        candidates.into_iter().zip(choice).map(|(mut all, k)| all.swap_remove(k)).collect()
    }

    /// Returns the union of the graphs of all members on scalars, before all passes.
    pub(super) fn scalar(&self) -> Graph {
        self.union(&self.members.iter().collect::<Vec<_>>())
    }

    /// Returns the union of the graphs of all members before all passes. `packed` returns the
    /// packed graph of a member, if it has one; `None` if no member has one.
    pub(super) fn packed(&self, packed: impl Fn(Function) -> Option<Graph>) -> Option<Graph> {
        let packed: Vec<Option<Graph>> = self
            .fused
            .members
            .iter()
            .map(|member| member.function.of_table().and_then(&packed))
            .collect();
        packed.iter().any(Option::is_some).then(|| {
            let all = packed.iter().zip(&self.members);
            self.union(
                &all.map(|(packed, scalar)| packed.as_ref().unwrap_or(scalar)).collect::<Vec<_>>(),
            )
        })
    }

    fn union(&self, members: &[&Graph]) -> Graph {
        let mut union = Graph::default();
        let inputs = union.inputs(0..self.count);
        let mut outputs = Vec::new();
        for (member, graph) in self.fused.members.iter().zip(members) {
            let own_inputs = member.function.arguments().iter().flat_map(|argument| {
                let (first, length) = self.inputs[argument.name];
                &inputs[first..first + length]
            });
            let inputs_of_member: Vec<Id> =
                own_inputs.chain(&inputs[self.arguments..]).copied().collect();
            outputs.extend(union.compose(graph, &inputs_of_member));
        }
        union.outputs = outputs;
        union
    }
}
