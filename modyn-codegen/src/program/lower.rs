//! Lowering of a graph to statements: order, fused products, signs, and angles that are evaluated
//! together.

use std::collections::BTreeMap;

use super::{
    Addend, Execution, InvalidProgram, LoopForm, Loops, MultiplyAdd, Operand, Operation, Products,
    Program, RowEquations, Source, Statement, Stored, Value, outline,
};
use crate::graph::dense::RowForm;
use crate::graph::{Graph, Id, Node};

/// The message of a panic about an invalid program.
const FAULT: &str = "a fault of modyn: please report it";

impl Program {
    /// Returns the program of a graph over `arguments` scalars.
    ///
    /// # Panics
    ///
    /// If the program is invalid, which no program of a graph on scalars is.
    #[must_use]
    pub fn new(graph: &Graph, arguments: usize, execution: Execution) -> Self {
        Self::try_new(graph, arguments, execution).expect(FAULT)
    }

    /// Returns the program of a graph, which may have packs of lanes, over `arguments` scalars. Its
    /// dense parts become loops.
    ///
    /// # Errors
    ///
    /// Returns the first violation of a rule.
    pub fn try_new(
        graph: &Graph,
        arguments: usize,
        execution: Execution,
    ) -> Result<Self, InvalidProgram> {
        let rows = graph.dense.rows.as_ref().map(|form| {
            let results = graph.outputs.len() - RowEquations::count(&form.blocks, form.sides);
            Apart::new(ApartForm::Rows(form), results, arguments)
        });
        let mut program = Self::lowered(graph, arguments, execution, rows);
        if let Some(form) = &graph.dense.products {
            let entries = program.results.split_off(form.results);
            let products = Products::new(form, entries, &program.results, execution);
            program.products = Some(products);
        }
        program.finished()
    }

    /// Returns the statements and results of a graph with loops, as a program that is not
    /// [`finished`](Self::finished). The last outputs of the graph are the stored values, and the
    /// inputs after the arguments are the results of the loops.
    pub(super) fn with_loops(
        graph: &Graph,
        form: &LoopForm,
        arguments: usize,
        execution: Execution,
    ) -> Self {
        let results = graph.outputs.len() - form.stored.len();
        let apart = Apart::new(ApartForm::Loops(form), results, arguments);
        Self::lowered(graph, arguments, execution, Some(apart))
    }

    /// Returns the statements and results of a graph, as a program that is not
    /// [`finished`](Self::finished), with an operation that the graph does not have.
    fn lowered(
        graph: &Graph,
        arguments: usize,
        execution: Execution,
        apart: Option<Apart<'_>>,
    ) -> Self {
        let results = apart.as_ref().map_or(graph.outputs.len(), |apart| apart.results);
        let lowering = Lowering::new(graph, apart);
        let statements = lowering.order.iter().map(|item| lowering.statement(item)).collect();
        let outputs = graph.outputs[..results].iter();
        let results = outputs.map(|&id| lowering.operand(id, 1)).collect();
        Self { statements, results, ..Self::without_statements(execution, arguments) }
    }

    /// Computes the last use of each value, cuts the statements into chunks, and checks the
    /// program.
    pub(super) fn finished(mut self) -> Result<Self, InvalidProgram> {
        for (i, stored) in self.all_stored().copied().collect::<Vec<_>>().into_iter().enumerate() {
            match stored.value() {
                Some(value) => self.statements[value.statement].stores.push(i),
                None => self.first_stores.push(i),
            }
        }
        for s in 0..self.statements.len() {
            for read in self.reads(s).collect::<Vec<_>>() {
                self.statements[read].last_use = s;
            }
        }
        for value in self.read_last().filter_map(Operand::value).collect::<Vec<_>>() {
            self.statements[value.statement].last_use = usize::MAX;
        }
        self.chunks = outline::chunks(&self);
        self.validate().map(|()| self)
    }
}

/// The content of one statement.
enum Item {
    /// A node, or all lanes of a vector that are read.
    Node(Id),
    /// The sines and cosines of angles.
    Angles(Vec<Id>),
    /// The operation that the graph does not have.
    Apart,
}

/// An operation that a graph does not have, within its program. The last outputs of the graph are
/// its operands, and the inputs after the arguments are its results.
struct Apart<'a> {
    form: ApartForm<'a>,
    /// The number of the program's results. The outputs after them are the operands.
    results: usize,
    /// The first input that is a result of the operation.
    first: usize,
    /// The statement.
    statement: usize,
}

enum ApartForm<'a> {
    Rows(&'a RowForm),
    Loops(&'a LoopForm),
}

impl<'a> Apart<'a> {
    fn new(form: ApartForm<'a>, results: usize, first: usize) -> Self {
        Self { form, results, first, statement: usize::MAX }
    }

    /// Returns the operation, given its operands, and its number of results.
    fn operation(&self, operands: Vec<Operand>) -> (Operation, usize) {
        match self.form {
            ApartForm::Rows(RowForm { blocks, sides }) => {
                let equations = RowEquations { blocks: blocks.clone(), sides: *sides, operands };
                let results = equations.results();
                (Operation::RowEquations(equations), results)
            }
            ApartForm::Loops(LoopForm { loops, stored }) => {
                let entries = stored.iter().zip(operands);
                let stored = entries.map(|(&entry, value)| Stored { entry, value }).collect();
                let results = loops.results.len();
                (Operation::Loops(Loops { stored, ..loops.clone() }), results)
            }
        }
    }
}

struct Lowering<'a> {
    graph: &'a Graph,
    live: Vec<bool>,
    /// The statements, in order.
    order: Vec<Item>,
    /// The operation that the graph does not have, if there is one.
    apart: Option<Apart<'a>>,
    /// For each node, the statement that computes it. `None` for operands, and for products and
    /// packs that are part of the operation that reads them.
    statement_of: Vec<Option<usize>>,
}

impl<'a> Lowering<'a> {
    fn new(graph: &'a Graph, apart: Option<Apart<'a>>) -> Self {
        let live = graph.live();
        let uses = graph.uses();
        let nodes = graph.nodes();
        // A product that is used once, in a sum, is fused into the sum. A pack that is used once,
        // in a wider pack, is part of that pack.
        let mut fused = vec![false; nodes.len()];
        for (i, (node, _)) in nodes.iter().zip(&live).enumerate().filter(|(_, (_, live))| **live) {
            let width = graph.width(i as Id);
            for operand in node.operands().filter(|&operand| uses[operand as usize] == 1) {
                fused[operand as usize] |= match (node, graph.node(operand)) {
                    (Node::Add(..) | Node::Sub(..), Node::Mul(..)) => graph.width(operand) == width,
                    (Node::Pack(..), Node::Pack(..)) => true,
                    _ => false,
                };
            }
        }
        let statement_of = vec![None; nodes.len()];
        let mut lowering = Self { graph, live, order: Vec::new(), apart, statement_of };
        lowering.schedule(&fused);
        lowering
    }

    /// Orders the statements as their nodes. Sines and cosines of angles that are known from the
    /// start come first, together: they share vector instructions, and no other operation waits for
    /// them one by one.
    fn schedule(&mut self, fused: &[bool]) {
        let graph = self.graph;
        let early = early_angles(graph, &self.live);
        for &angle in early.iter().flatten() {
            let operands = graph.node(angle).operands();
            let packs = operands.filter(|&id| matches!(graph.node(id), Node::Pack(..)));
            for id in packs.chain([angle]) {
                let index = id as usize;
                let is_operand = matches!(graph.node(id), Node::Input(_)) || fused[index];
                if !is_operand && self.statement_of[index].is_none() {
                    self.statement_of[index] = Some(self.push(Item::Node(id)));
                }
            }
        }
        let mut angles: BTreeMap<Id, usize> = BTreeMap::new();
        for early in early {
            angles.extend(early.iter().map(|&angle| (angle, self.order.len())));
            self.push(Item::Angles(early));
        }
        let mut unpacked: BTreeMap<Id, usize> = BTreeMap::new();
        if let Some(apart) = &self.apart {
            let operands = &graph.outputs[apart.results..];
            let is_before = graph.live_from(operands);
            self.push_nodes(fused, |i| is_before[i], &mut angles, &mut unpacked);
            let statement = self.push(Item::Apart);
            self.apart.iter_mut().for_each(|apart| apart.statement = statement);
        }
        self.push_nodes(fused, |_| true, &mut angles, &mut unpacked);
    }

    /// Appends the statements of nodes that have none, of those that are `taken`.
    fn push_nodes(
        &mut self,
        fused: &[bool],
        taken: impl Fn(usize) -> bool,
        angles: &mut BTreeMap<Id, usize>,
        unpacked: &mut BTreeMap<Id, usize>,
    ) {
        let graph = self.graph;
        for (i, node) in graph.nodes().iter().enumerate() {
            let id = i as Id;
            let statement = match node {
                _ if !taken(i) || !self.live[i] || fused[i] || self.statement_of[i].is_some() => {
                    continue;
                }
                Node::Constant(_) | Node::Input(_) | Node::Neg(_) => continue,
                Node::Sin(angle) | Node::Cos(angle) => match angles.get(angle) {
                    Some(&statement) => statement,
                    None => {
                        angles.insert(*angle, self.order.len());
                        self.push(Item::Angles(vec![*angle]))
                    }
                },
                Node::ExtractLane(vector, _) => match unpacked.get(vector) {
                    Some(&statement) => statement,
                    None => {
                        unpacked.insert(*vector, self.order.len());
                        self.push(Item::Node(id))
                    }
                },
                _ => self.push(Item::Node(id)),
            };
            self.statement_of[i] = Some(statement);
        }
    }

    /// Appends a statement, and returns its index.
    fn push(&mut self, item: Item) -> usize {
        self.order.push(item);
        self.order.len() - 1
    }

    fn statement(&self, item: &Item) -> Statement {
        let (operation, lanes, used) = match item {
            Item::Apart => {
                let apart = self.apart.as_ref().expect("the item is that of an operation apart");
                let operands = self.graph.outputs[apart.results..].iter();
                let (operation, results) =
                    apart.operation(operands.map(|&id| self.operand(id, 1)).collect());
                let inputs = apart.first..apart.first + results;
                let used = inputs.map(|input| self.is_live(Node::input(input))).collect();
                (operation, 1, used)
            }
            Item::Angles(angles) => {
                let operand_of = |&angle: &Id| self.operand(angle, self.graph.width(angle));
                let both = |angle: &Id| [Node::Sin(*angle), Node::Cos(*angle)];
                let used = angles.iter().flat_map(both).map(|node| self.is_live(node));
                let lanes = self.graph.width(angles[0]);
                (Operation::SinCos(angles.iter().map(operand_of).collect()), lanes, used.collect())
            }
            Item::Node(id) => {
                let used = match self.graph.node(*id) {
                    Node::ExtractLane(vector, _) => {
                        let lanes = 0..self.graph.width(vector);
                        lanes.map(|lane| self.is_live(Node::ExtractLane(vector, lane))).collect()
                    }
                    _ => vec![true],
                };
                (self.operation(*id), self.graph.width(*id), used)
            }
        };
        Statement { operation, lanes, used, last_use: 0, stores: Vec::new() }
    }

    fn is_live(&self, node: Node) -> bool {
        self.graph.find(node).is_some_and(|id| self.live[id as usize])
    }

    /// Returns the operation of a node with a statement of its own.
    fn operation(&self, id: Id) -> Operation {
        let width = self.graph.width(id);
        let at = |id| self.operand(id, width);
        match self.graph.node(id) {
            Node::Add(a, b) => match (self.product(a), self.product(b)) {
                (Some(factors), _) => self.multiply_add(factors, false, b, false, width),
                (None, Some(factors)) => self.multiply_add(factors, false, a, false, width),
                (None, None) => Operation::Add(at(a), at(b)),
            },
            Node::Sub(a, b) => match (self.product(a), self.product(b)) {
                (_, Some(factors)) => self.multiply_add(factors, true, a, false, width),
                (Some(factors), None) => self.multiply_add(factors, false, b, true, width),
                (None, None) => Operation::Subtract(at(a), at(b)),
            },
            Node::Mul(a, b) => Operation::Multiply(at(a), at(b)),
            Node::Recip(a) => Operation::Reciprocal(at(a)),
            Node::Atan2(a, b) => Operation::Atan2(at(a), at(b)),
            Node::Sqrt(a) => Operation::SquareRoot(at(a)),
            Node::Ln(a) => Operation::Logarithm(at(a)),
            Node::Abs(a) => Operation::Absolute(at(a)),
            Node::Max(a, b) => Operation::Maximum(at(a), at(b)),
            Node::Select(a, b, c) => Operation::Select(at(a), at(b), at(c)),
            Node::Pack(..) => {
                let lanes = || (0..width).map(|lane| self.graph.packed_at(id, lane));
                let constants: Option<Vec<f64>> = lanes().map(|id| self.graph.value(id)).collect();
                match constants {
                    Some(constants) => Operation::Constants(constants),
                    None => Operation::Pack(lanes().map(|id| self.operand(id, 1)).collect()),
                }
            }
            Node::ExtractLane(a, _) => Operation::Unpack(self.operand(a, self.graph.width(a))),
            Node::Constant(_) | Node::Input(_) | Node::Neg(_) | Node::Sin(_) | Node::Cos(_) => {
                unreachable!("operands and angles are no operations of a node")
            }
        }
    }

    /// Returns a product fused with a sum. Signs that cancel are omitted.
    fn multiply_add(
        &self,
        [mut a, b]: [Operand; 2],
        mut negative_product: bool,
        addend: Id,
        mut negative_addend: bool,
        lanes: u8,
    ) -> Operation {
        let cancel = |operand: &mut Operand, negative: &mut bool| {
            if *negative && operand.negated {
                (operand.negated, *negative) = (false, false);
            }
        };
        cancel(&mut a, &mut negative_product);
        let addend = match self.product(addend) {
            Some([a, b]) => Addend::Product(a, b),
            None => {
                let mut addend = self.operand(addend, lanes);
                cancel(&mut addend, &mut negative_addend);
                Addend::Value(addend)
            }
        };
        Operation::MultiplyAdd(MultiplyAdd {
            negative_product,
            factors: [a, b],
            negative_addend,
            addend,
        })
    }

    /// Returns the factors of a product that is part of the sum that reads it.
    fn product(&self, id: Id) -> Option<[Operand; 2]> {
        match (self.statement_of[id as usize], self.graph.node(id)) {
            (None, Node::Mul(a, b)) => {
                let width = self.graph.width(id);
                Some([self.operand(a, width), self.operand(b, width)])
            }
            _ => None,
        }
    }

    /// Returns a node as the operand of an operation on `lanes` lanes.
    fn operand(&self, id: Id, lanes: u8) -> Operand {
        let operand = |source| Operand { source, negated: false, lanes };
        let node = self.graph.node(id);
        if let Some(statement) = self.statement_of[id as usize] {
            return operand(Source::Result(Value {
                statement,
                place: self.place(statement, node),
            }));
        }
        match node {
            Node::Constant(bits) => operand(Source::Constant(f64::from_bits(bits))),
            Node::Input(number) => {
                let number = number as usize;
                let result = self.apart.iter().find_map(|apart| {
                    let place = number.checked_sub(apart.first)?;
                    Some(Source::Result(Value { statement: apart.statement, place }))
                });
                operand(result.unwrap_or(Source::Argument(number)))
            }
            Node::Neg(a) => {
                let operand = self.operand(a, lanes);
                Operand { negated: !operand.negated, ..operand }
            }
            _ => unreachable!("an operation that is read has a statement"),
        }
    }

    /// Returns the index of a node among its statement's results.
    fn place(&self, statement: usize, node: Node) -> usize {
        let place_of = |angle: Id| match &self.order[statement] {
            Item::Angles(angles) => 2 * angles.iter().position(|&a| a == angle).unwrap_or(0),
            Item::Node(_) | Item::Apart => 0,
        };
        match node {
            Node::Sin(angle) => place_of(angle),
            Node::Cos(angle) => place_of(angle) + 1,
            Node::ExtractLane(_, lane) => lane.into(),
            _ => 0,
        }
    }
}

/// Returns the angles that are arguments, or arguments plus a constant, grouped by lanes; groups of
/// one are omitted.
fn early_angles(graph: &Graph, live: &[bool]) -> Vec<Vec<Id>> {
    let mut angles: BTreeMap<u8, Vec<Id>> = BTreeMap::new();
    for (node, _) in graph.nodes().iter().zip(live).filter(|&(_, &live)| live) {
        let (Node::Sin(angle) | Node::Cos(angle)) = *node else { continue };
        let known = match graph.node(angle) {
            node @ (Node::Add(..) | Node::Sub(..)) => node.operands().all(|id| is_known(graph, id)),
            _ => is_known(graph, angle),
        };
        let same = angles.entry(graph.width(angle)).or_default();
        if known && !same.contains(&angle) {
            same.push(angle);
        }
    }
    angles.into_values().filter(|same| same.len() > 1).collect()
}

/// Returns whether a node is an argument, a constant, or a pack of these.
fn is_known(graph: &Graph, id: Id) -> bool {
    match graph.node(id) {
        Node::Input(_) | Node::Constant(_) => true,
        Node::Pack(a, b, _) => is_known(graph, a) && is_known(graph, b),
        _ => false,
    }
}
