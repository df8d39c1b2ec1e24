//! A graph as the text of straight-line Rust functions.
//!
//! rustc takes more than linear time for long bodies, and with debug information crashes on some
//! thousands of `let`s in one scope. So statements go into blocks, `let (live, ...) = { ... };`,
//! and long functions into parts. Each returns what others need of it, and these take it from there
//! where they use it: values that parts copied to hand them on would be half of a long function's work.

use std::cell::{Cell, OnceCell};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::ops::Range;

use super::Shape;
use crate::expr::{Graph, Id, Node};
use crate::names::helper_type;

/// Most statements in one block.
const BLOCK: usize = 250;

/// How long functions are, in statements.
struct Length {
    /// What is no longer stays one function.
    whole: usize,
    /// Most in a part of what is.
    part: usize,
}

/// For many states: the compiler works on lanes in memory at first, in more than linear time.
const STATES: Length = Length { whole: 500, part: 500 };

/// For one state in numbers alone: short parts fit registers better, and take the compiler less time.
const NUMBERS: Length = Length { whole: 1500, part: 500 };

/// With some side by side: a humanoid's forward dynamics (1,600 statements) takes a fifth less time as one
/// function where there are 32 registers, as long where there are 16, and a tenth more of rustc's. Its derivatives
/// would gain as much, but take rustc twice as long; parts of 800 are as fast as longer ones that are not all.
const ABREAST: Length = Length { whole: 3000, part: 800 };

/// A parameter, given by reference.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    pub name: &'static str,
    pub shape: Shape,
    /// The type of its numbers, if they are constants.
    constants: Option<&'static str>,
}

impl Parameter {
    pub(super) fn new(name: &'static str, shape: Shape) -> Self {
        Self { name, shape, constants: None }
    }

    /// One of constants, in the type's own scalar.
    pub(super) fn constants(name: &'static str, shape: Shape, float: &'static str) -> Self {
        Self { name, shape, constants: Some(float) }
    }

    /// What entry `i` is called in the function. No temporary is called so: their names are letters and
    /// digits at first (`x1`, `s1_0`), those of parameters letters alone (but `k`, a function of constants).
    pub(super) fn entry(&self, i: usize) -> String {
        debug_assert!(self.name != "k" && !self.name.contains(|c: char| c.is_ascii_digit()));
        format!("{}_{i}", self.name)
    }

    /// With its type over scalar `t`.
    pub(super) fn typed(&self, t: &str) -> String {
        format!("{}: &{}", self.name, self.shape.type_of(self.constants.unwrap_or(t)))
    }
}

/// A private generic function `name<T: Scalar>` that computes the graph, with its parts.
pub(super) fn function(
    name: &str,
    parameters: &[Parameter],
    shape: &Shape,
    graph: &Graph,
) -> String {
    Writer::new(name, parameters, graph, On::Numbers).write(shape)
}

/// The same for lanes: always inlined into what is compiled for their instructions, with parts that the
/// lanes outline. Returns nothing, but puts each of the `shape`'s numbers into `outputs` at once: handed
/// on through the parts, a matrix would be copied several times.
pub(super) fn lanes_function(
    name: &str,
    parameters: &[Parameter],
    shape: &Shape,
    graph: &Graph,
) -> String {
    Writer::new(name, parameters, graph, On::States).write(shape)
}

/// The same for one state with some numbers side by side: over vectors `V`, inlined likewise. Returns how
/// many types of `V` stand before it among the parameters, too.
pub(super) fn abreast_function(
    name: &str,
    parameters: &[Parameter],
    shape: &Shape,
    graph: &Graph,
) -> (String, usize) {
    let writer = Writer::new(name, parameters, graph, On::Vectors);
    (writer.write(shape), writer.vectors().count())
}

/// What a function is written on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum On {
    /// Numbers of type `T`.
    Numbers,
    /// Lanes of type `T`, each of which is a state.
    States,
    /// Numbers of one state, some of them side by side, of the types of `V`.
    Vectors,
}

/// A type of `V` for so many lanes.
struct VectorType {
    lanes: u8,
    /// As a parameter of functions: those are faster to compile with than projections.
    name: &'static str,
    /// What that is of `V`.
    of: &'static str,
    /// What it can do.
    bound: &'static str,
}

/// The types of `V`.
const VECTORS: [VectorType; 4] = [
    VectorType { lanes: 1, name: "A", of: "One", bound: "Scalar" },
    VectorType { lanes: 2, name: "B", of: "Two", bound: "batch::Beside<A, 2>" },
    VectorType { lanes: 4, name: "C", of: "Four", bound: "batch::Beside<A, 4>" },
    VectorType { lanes: 8, name: "D", of: "Eight", bound: "batch::Beside<A, 8>" },
];

/// What one `let` computes.
#[derive(Clone, Debug)]
enum Statement {
    /// A node, or a sine with its cosine.
    Node(Id),
    /// The sines and cosines of angles, which are given by their nodes.
    Angles(Vec<Id>),
}

struct Writer<'a> {
    name: &'a str,
    parameters: &'a [Parameter],
    graph: &'a Graph,
    on: On,
    /// For each node the statement that computes it; `None` for what is written where it is used.
    statement_of: Vec<Option<usize>>,
    /// What is computed, statement by statement.
    statements: Vec<Statement>,
    /// The last statement that uses each statement's value; `usize::MAX` where it is returned.
    last_use: Vec<usize>,
    /// The outputs that are put where they belong behind each statement, or before all; none if they are
    /// returned.
    put: BTreeMap<Option<usize>, Vec<usize>>,
    live: Vec<bool>,
    /// The first statement of the part that is being written.
    start: Cell<usize>,
    /// By name, where values are found that an earlier part has computed.
    places: OnceCell<BTreeMap<String, String>>,
}

impl<'a> Writer<'a> {
    fn new(name: &'a str, parameters: &'a [Parameter], graph: &'a Graph, on: On) -> Self {
        let (live, uses) = (graph.live(), graph.uses());
        let nodes = graph.nodes();
        // A product used once, in a sum, is written there; numbers side by side that are used once,
        // beside others, likewise.
        let mut in_place = vec![false; nodes.len()];
        for (i, (node, _)) in nodes.iter().zip(&live).enumerate().filter(|(_, (_, live))| **live) {
            let width = graph.width(i as Id);
            for operand in node.operands().filter(|&operand| uses[operand as usize] == 1) {
                in_place[operand as usize] |= match (node, graph.node(operand)) {
                    (Node::Add(..) | Node::Sub(..), Node::Mul(..)) => graph.width(operand) == width,
                    (Node::Beside(..), Node::Beside(..)) => true,
                    _ => false,
                };
            }
        }
        let mut statement_of = vec![None; nodes.len()];
        let mut statements = Vec::new();
        // Sines and cosines of what is known at once come first, together: they share vector
        // instructions, and the rest need not wait for them one by one.
        let early = early_angles(graph, &live);
        for &angle in early.iter().flatten() {
            let beside = graph.node(angle).operands();
            let beside = beside.filter(|&id| matches!(graph.node(id), Node::Beside(..)));
            for id in beside.chain([angle]) {
                let index = id as usize;
                let known = matches!(graph.node(id), Node::Input(_)) || in_place[index];
                if !known && statement_of[index].is_none() {
                    statement_of[index] = Some(statements.len());
                    statements.push(Statement::Node(id));
                }
            }
        }
        let mut angles: BTreeMap<Id, usize> = BTreeMap::new();
        for early in early {
            angles.extend(early.iter().map(|&angle| (angle, statements.len())));
            statements.push(Statement::Angles(early));
        }
        let mut apart: BTreeMap<Id, usize> = BTreeMap::new();
        for (i, node) in nodes.iter().enumerate() {
            let id = i as Id;
            match node {
                _ if !live[i] || in_place[i] || statement_of[i].is_some() => {}
                Node::Constant(_) | Node::Input(_) | Node::Neg(_) => {}
                Node::Sin(angle) | Node::Cos(angle) => {
                    let statement = *angles.entry(*angle).or_insert_with(|| {
                        statements.push(Statement::Node(id));
                        statements.len() - 1
                    });
                    statement_of[i] = Some(statement);
                }
                Node::Lane(lanes, _) => {
                    let statement = *apart.entry(*lanes).or_insert_with(|| {
                        statements.push(Statement::Node(id));
                        statements.len() - 1
                    });
                    statement_of[i] = Some(statement);
                }
                _ => {
                    statement_of[i] = Some(statements.len());
                    statements.push(Statement::Node(id));
                }
            }
        }
        let mut writer = Self {
            name,
            parameters,
            graph,
            on,
            statement_of,
            last_use: vec![0; statements.len()],
            put: BTreeMap::new(),
            statements,
            live,
            start: Cell::new(0),
            places: OnceCell::new(),
        };
        if on == On::States {
            for (i, &output) in graph.outputs.iter().enumerate() {
                let behind = writer.reached(output).into_iter().max();
                writer.put.entry(behind).or_default().push(i);
            }
        }
        for s in 0..writer.statements.len() {
            for used in writer.uses_of(s) {
                writer.last_use[used] = s;
            }
        }
        for &output in graph.outputs.iter().filter(|_| on != On::States) {
            for used in writer.reached(output) {
                writer.last_use[used] = usize::MAX;
            }
        }
        writer
    }

    /// The statements whose values the text of node `id`, written in place, mentions.
    fn reached(&self, id: Id) -> Vec<usize> {
        match self.statement_of[id as usize] {
            Some(statement) => vec![statement],
            None => self.reached_by(id),
        }
    }

    /// The statements whose values the text of node `id`'s operation mentions.
    fn reached_by(&self, id: Id) -> Vec<usize> {
        let operands: Vec<Id> = match self.graph.node(id) {
            // Numbers side by side are written one by one, even if some of them stand so elsewhere.
            Node::Beside(_, _, width) => {
                (0..width).map(|lane| self.graph.beside_at(id, lane)).collect()
            }
            node => node.operands().collect(),
        };
        operands.into_iter().flat_map(|operand| self.reached(operand)).collect()
    }

    /// The statements whose values statement `s` mentions, and what is put behind it.
    fn uses_of(&self, s: usize) -> Vec<usize> {
        let mut used: Vec<usize> = match &self.statements[s] {
            Statement::Node(id) => self.reached_by(*id),
            Statement::Angles(angles) => {
                angles.iter().flat_map(|&angle| self.reached(angle)).collect()
            }
        };
        let put = self.put.get(&Some(s)).into_iter().flatten();
        used.extend(put.flat_map(|&output| self.reached(self.graph.outputs[output])));
        used
    }

    /// Puts the outputs that belong behind a statement, or before all.
    fn puts(&self, behind: Option<usize>) -> String {
        let put = self.put.get(&behind).into_iter().flatten();
        put.map(|&i| format!("outputs.set::<{i}>({});\n", self.text(self.graph.outputs[i])))
            .collect()
    }

    /// The text of a node's value.
    fn text(&self, id: Id) -> String {
        let Some(s) = self.statement_of[id as usize] else { return self.operation(id) };
        let name = self.name(s, id);
        if s < self.start.get() { self.places()[&name].clone() } else { name }
    }

    /// What the value of node `id`, of statement `s`, is called.
    fn name(&self, s: usize, id: Id) -> String {
        match self.graph.node(id) {
            Node::Sin(angle) => format!("s{}", self.turn(s, angle)),
            Node::Cos(angle) => format!("c{}", self.turn(s, angle)),
            Node::Lane(_, lane) => format!("x{s}_{lane}"),
            _ => format!("x{s}"),
        }
    }

    /// By name, where values are found that an earlier part has computed.
    fn places(&self) -> &BTreeMap<String, String> {
        self.places.get_or_init(|| {
            let parts = self.parts();
            let results = parts.iter().enumerate().take(parts.len() - 1);
            results.flat_map(|(k, range)| self.needed_after(range).places(k)).collect()
        })
    }

    /// The statements of each part, of about equal length; the last one has the result.
    fn parts(&self) -> Vec<Range<usize>> {
        let count = self.statements.len();
        let length = match self.on {
            On::States => STATES,
            On::Vectors if self.vectors().count() > 1 => ABREAST,
            On::Numbers | On::Vectors => NUMBERS,
        };
        let parts = if count <= length.whole { 1 } else { count.div_ceil(length.part) };
        (0..parts).map(|k| k * count / parts..(k + 1) * count / parts).collect()
    }

    /// The text of a node's value for an operation on so many lanes.
    fn wide(&self, id: Id, width: u8) -> String {
        match (self.graph.width(id), self.graph.node(id)) {
            (own, _) if own == width => self.text(id),
            (_, Node::Constant(bits)) => constant(f64::from_bits(bits), width),
            _ => format!("{}::all({})", self.kind(width), self.text(id)),
        }
    }

    /// The text of node `id`'s operation.
    fn operation(&self, id: Id) -> String {
        let width = self.graph.width(id);
        let (t, kind) = (|id| self.wide(id, width), self.kind(width));
        let f = |function: &str, of: Id, rest: &[String]| {
            let all = [&[t(of)], rest].concat();
            format!("{kind}::{function}({})", all.join(", "))
        };
        let mul_add = |x: String, y: String, z: String| format!("{kind}::mul_add({x}, {y}, {z})");
        match self.graph.node(id) {
            Node::Constant(bits) => constant(f64::from_bits(bits), 1),
            Node::Input(number) => self.input(number as usize),
            // Only sums have products written in place.
            Node::Neg(a) => negated(t(a)),
            Node::Add(a, b) => match (self.product(a), self.product(b)) {
                (Some([x, y]), _) => mul_add(x, y, t(b)),
                (None, Some([x, y])) => mul_add(x, y, t(a)),
                (None, None) => format!("{} + {}", t(a), t(b)),
            },
            Node::Sub(a, b) => match (self.product(a), self.product(b)) {
                (_, Some([x, y])) => mul_add(negated(x), y, t(a)),
                (Some([x, y]), None) => mul_add(x, y, negated(t(b))),
                (None, None) => format!("{} - {}", t(a), t(b)),
            },
            Node::Mul(a, b) => format!("{} * {}", t(a), t(b)),
            Node::Recip(a) => f("recip", a, &[]),
            Node::Sin(a) | Node::Cos(a) => f("sin_cos", a, &[]),
            Node::Atan2(a, b) => f("atan2", a, &[t(b)]),
            Node::Sqrt(a) => f("sqrt", a, &[]),
            Node::Ln(a) => f("ln", a, &[]),
            Node::Abs(a) => f("abs", a, &[]),
            Node::Max(a, b) => f("max", a, &[t(b)]),
            Node::Select(a, b, c) => f("select_nonnegative", a, &[t(b), t(c)]),
            Node::Beside(..) => match self.constants(id, width) {
                Some(constants) => format!("{kind}::constants([{}])", constants.join(", ")),
                None => format!("{kind}::beside([{}])", self.lanes(id, width).join(", ")),
            },
            Node::Lane(a, _) => {
                format!("{}::apart({})", self.kind(self.graph.width(a)), self.text(a))
            }
        }
    }

    /// The texts of what stands side by side in so many lanes.
    fn lanes(&self, id: Id, width: u8) -> Vec<String> {
        (0..width).map(|lane| self.text(self.graph.beside_at(id, lane))).collect()
    }

    /// The same, if all are constants.
    fn constants(&self, id: Id, width: u8) -> Option<Vec<String>> {
        let constant = |lane| match self.graph.node(self.graph.beside_at(id, lane)) {
            Node::Constant(bits) => Some(number(f64::from_bits(bits))),
            _ => None,
        };
        (0..width).map(constant).collect()
    }

    /// The factors of a product that is written in place.
    fn product(&self, id: Id) -> Option<[String; 2]> {
        match (self.statement_of[id as usize], self.graph.node(id)) {
            (None, Node::Mul(a, b)) => {
                let width = self.graph.width(id);
                Some([self.wide(a, width), self.wide(b, width)])
            }
            _ => None,
        }
    }

    /// What the sine and cosine of `angle`, of statement `s`, are numbered.
    fn turn(&self, s: usize, angle: Id) -> String {
        match &self.statements[s] {
            Statement::Node(_) => s.to_string(),
            Statement::Angles(angles) => {
                let place = angles.iter().position(|&other| other == angle);
                format!("{s}_{}", place.unwrap_or_default())
            }
        }
    }

    fn input(&self, number: usize) -> String {
        let (name, parameter) = input(self.parameters, number);
        if parameter.constants.is_some() { format!("k(f64::from({name}))") } else { name }
    }

    /// The names of the sine and cosine of `angle` that are used.
    fn turn_names(&self, angle: Id) -> [Option<String>; 2] {
        [Node::Sin(angle), Node::Cos(angle)].map(|node| {
            let found = self.graph.find(node).filter(|&id| self.live[id as usize])?;
            Some(self.name(self.statement_of[found as usize]?, found))
        })
    }

    /// The names of the lanes of a node that are used, lane by lane.
    fn lane_names(&self, lanes: Id) -> Vec<Option<String>> {
        let name = |lane| {
            let found = self.graph.find(Node::Lane(lanes, lane));
            let found = found.filter(|&id| self.live[id as usize])?;
            Some(self.name(self.statement_of[found as usize]?, found))
        };
        (0..self.graph.width(lanes)).map(name).collect()
    }

    /// How many lanes what statement `s` defines has.
    fn width(&self, s: usize) -> u8 {
        match &self.statements[s] {
            Statement::Node(id) => self.graph.width(*id),
            Statement::Angles(angles) => self.graph.width(angles[0]),
        }
    }

    /// The names that statement `s` defines; a sine or cosine that nothing uses is left out.
    fn names(&self, s: usize) -> Vec<String> {
        let turns = |angle: Id| self.turn_names(angle).into_iter().flatten();
        match &self.statements[s] {
            Statement::Node(id) => match self.graph.node(*id) {
                Node::Sin(angle) | Node::Cos(angle) => turns(angle).collect(),
                Node::Lane(lanes, _) => self.lane_names(lanes).into_iter().flatten().collect(),
                _ => vec![format!("x{s}")],
            },
            Statement::Angles(angles) => angles.iter().copied().flat_map(turns).collect(),
        }
    }

    fn statement(&self, s: usize) -> String {
        let pattern = |angle: Id| {
            let [sin, cos] = self.turn_names(angle).map(|name| name.unwrap_or("_".into()));
            format!("({sin}, {cos})")
        };
        match &self.statements[s] {
            Statement::Node(id) => {
                let value = self.operation(*id);
                match self.graph.node(*id) {
                    Node::Sin(angle) | Node::Cos(angle) => {
                        format!("let {} = {value};", pattern(angle))
                    }
                    Node::Lane(lanes, _) => {
                        let names = self.lane_names(lanes).into_iter();
                        let names: Vec<String> = names.map(|n| n.unwrap_or("_".into())).collect();
                        format!("let [{}] = {value};", names.join(", "))
                    }
                    _ => format!("let x{s} = {value};"),
                }
            }
            Statement::Angles(angles) => {
                let patterns: Vec<String> = angles.iter().map(|&angle| pattern(angle)).collect();
                let values: Vec<String> = angles.iter().map(|&angle| self.text(angle)).collect();
                let (patterns, values) = (patterns.join(", "), values.join(", "));
                let kind = self.kind(self.width(s));
                format!("let [{patterns}] = {kind}::sin_cos_all([{values}]);")
            }
        }
    }

    /// The type of so many numbers side by side.
    fn kind(&self, width: u8) -> &'static str {
        let vector = VECTORS.iter().find(|kind| self.on == On::Vectors && kind.lanes == width);
        vector.map_or("T", |kind| kind.name)
    }

    /// The types of `V` that are mentioned: numbers, and those side by side.
    fn vectors(&self) -> impl Iterator<Item = &'static VectorType> {
        let widths: BTreeSet<u8> = (0..self.statements.len()).map(|s| self.width(s)).collect();
        VECTORS.iter().filter(move |kind| kind.lanes == 1 || widths.contains(&kind.lanes))
    }

    /// Their parameters, with bounds.
    fn vector_parameters(&self) -> String {
        let bounded = self.vectors().map(|kind| format!("{}: __modyn::{}", kind.name, kind.bound));
        bounded.collect::<Vec<_>>().join(", ")
    }

    /// Their names.
    fn vector_names(&self) -> String {
        self.vectors().map(|kind| kind.name).collect::<Vec<_>>().join(", ")
    }

    /// What these statements define and later ones use.
    fn needed_after(&self, range: &Range<usize>) -> Values {
        let mut values = Values { on: self.on, names: Default::default() };
        for s in range.clone().filter(|&s| self.last_use[s] >= range.end) {
            let place = VECTORS.iter().position(|kind| kind.lanes == self.width(s));
            values.names[place.unwrap_or_default()].extend(self.names(s));
        }
        values
    }

    /// The earlier parts whose values these statements mention.
    fn mentioned(&self, parts: &[Range<usize>], range: &Range<usize>) -> BTreeSet<usize> {
        let used = range.clone().flat_map(|s| self.uses_of(s)).filter(|&s| s < range.start);
        used.filter_map(|s| parts.iter().position(|part| part.contains(&s))).collect()
    }

    fn write(&self, shape: &Shape) -> String {
        let inlined = self.on != On::Numbers;
        let parts = self.parts();
        let scalar = self.kind(1);
        let mut text = String::new();
        for (k, range) in parts.iter().enumerate() {
            let last = k + 1 == parts.len();
            self.start.set(range.start);
            let needed = self.needed_after(range);
            let returned = match (last, self.on) {
                (false, _) => needed.types(),
                (true, On::Vectors) => shape.type_of("V::Number"),
                (true, On::Numbers) => shape.type_of("T"),
                (true, On::States) => "()".into(),
            };
            let name = if last { self.name.to_string() } else { format!("{}_part{k}", self.name) };
            let mut inputs: Vec<String> = self.parameters.iter().map(|p| p.typed(scalar)).collect();
            if self.on == On::States {
                let count = shape.len();
                inputs.push(format!("outputs: &__modyn::batch::Outputs<'_, T, {count}>"));
            }
            if !last {
                let handed = self.mentioned(&parts, range).into_iter().map(|part| {
                    format!("part{part}: &{}", self.needed_after(&parts[part]).types())
                });
                inputs.extend(handed);
            }
            text += &match (self.on, last) {
                (On::Numbers, _) => head(&name, "T: __modyn::Scalar", &inputs, &returned),
                (On::States, true) => {
                    let head = head(&name, "T: __modyn::batch::Lanes", &inputs, &returned);
                    format!("#[inline(always)]\n{head}")
                }
                (On::Vectors, true) => {
                    let of = self.vectors().map(|kind| format!("{} = {}", kind.of, kind.name));
                    let of = of.collect::<Vec<_>>().join(", ");
                    let bounds =
                        format!("{}, V: __modyn::batch::Vectors<{of}>", self.vector_parameters());
                    let head = head(&name, &bounds, &inputs, &returned);
                    format!("#[inline(always)]\n{head}")
                }
                (On::States | On::Vectors, false) => self.part_head(&name, &inputs, &returned),
            };
            text += &self.prelude();
            for parameter in self.parameters {
                let _ = writeln!(text, "    {}", unpacked(parameter));
            }
            if last {
                text += &self.puts(None);
                self.call_parts(&mut text, &parts[..k]);
            }
            self.blocks(&mut text, range.clone());
            let value = if last && self.on == On::States {
                String::new()
            } else if last {
                let output = |&id: &Id| match self.on {
                    On::Vectors => format!("V::number({})", self.text(id)),
                    On::Numbers | On::States => self.text(id),
                };
                let outputs: Vec<String> = self.graph.outputs.iter().map(output).collect();
                shape.value(&outputs)
            } else {
                needed.text()
            };
            let end = if inlined && !last { "}\n}" } else { "}" };
            let _ = writeln!(text, "    {value}\n{end}\n");
        }
        text
    }

    /// What the text of a function's statements begins with.
    fn prelude(&self) -> String {
        let closure = |(width, kind): (u8, &str)| match width {
            1 => format!("    let k = {kind}::from_f64;\n"),
            _ => format!("    let k{width} = {kind}::from_f64;\n"),
        };
        match self.on {
            On::Numbers | On::States => closure((1, "T")),
            On::Vectors => self.vectors().map(|kind| closure((kind.lanes, kind.name))).collect(),
        }
    }

    /// Where the text of a part begins that lanes outline: a type that holds the arguments, and what it
    /// does.
    fn part_head(&self, name: &str, inputs: &[String], returned: &str) -> String {
        let in_field = |input: &String| input.replace('&', "&'a ").replace("'_", "'a");
        let mut fields: Vec<String> = inputs.iter().map(in_field).collect();
        let names: Vec<&str> = inputs.iter().filter_map(|i| i.split(':').next()).collect();
        let kind = helper_type(name);
        let (bounds, own) = match self.on {
            On::Vectors => (self.vector_parameters(), self.vector_names()),
            On::Numbers | On::States => ("T: __modyn::batch::Lanes".into(), "T".into()),
        };
        fields.push(format!("of: ::core::marker::PhantomData<({own},)>"));
        format!(
            "struct {kind}<'a, {bounds}> {{ {} }}\n\
             impl<{bounds}> __modyn::batch::Part for {kind}<'_, {own}> {{\n\
             type Output = {returned};\n\
             #[inline(always)]\nfn run(self) -> {returned} {{\n    let Self {{ {}, .. }} = self;\n",
            fields.join(", "),
            names.join(", "),
        )
    }

    /// The calls of the earlier parts, in the last one.
    fn call_parts(&self, text: &mut String, parts: &[Range<usize>]) {
        for (k, range) in parts.iter().enumerate() {
            let mut arguments: Vec<String> =
                self.parameters.iter().map(|p| p.name.to_string()).collect();
            if self.on == On::States {
                arguments.push("outputs".into());
            }
            arguments.extend(self.mentioned(parts, range).into_iter().map(|part| match self.on {
                On::Numbers => format!("&part{part}"),
                On::States | On::Vectors => format!("part{part}: &part{part}"),
            }));
            let (name, arguments) = (format!("{}_part{k}", self.name), arguments.join(", "));
            let call = match self.on {
                On::Numbers => format!("{name}({arguments})"),
                On::States | On::Vectors => {
                    let (by, own) = match self.on {
                        On::Vectors => ("V", self.vector_names()),
                        On::Numbers | On::States => ("T", "T".into()),
                    };
                    let part = format!("{}::<'_, {own}>", helper_type(&name));
                    format!(
                        "{by}::outlined({part} {{ {arguments}, of: ::core::marker::PhantomData }})"
                    )
                }
            };
            let _ = writeln!(text, "    let part{k} = {call};");
        }
    }

    fn blocks(&self, text: &mut String, range: Range<usize>) {
        if range.len() <= BLOCK {
            for s in range {
                let _ = writeln!(text, "    {}", self.statement(s));
                *text += &self.puts(Some(s));
            }
            return;
        }
        let mut start = range.start;
        while start < range.end {
            let end = (start + BLOCK).min(range.end);
            let needed = self.needed_after(&(start..end)).names.concat();
            let needed: String = needed.iter().map(|name| format!("{name}, ")).collect();
            let _ = writeln!(text, "    let ({needed}) = {{");
            for s in start..end {
                let _ = writeln!(text, "        {}", self.statement(s));
                *text += &self.puts(Some(s));
            }
            let _ = writeln!(text, "        ({needed})\n    }};");
            start = end;
        }
    }
}

/// Named values that a part hands on.
struct Values {
    on: On,
    /// By their lanes, as in [`VECTORS`].
    names: [Vec<String>; VECTORS.len()],
}

impl Values {
    /// Where each is found in the result of part `k`.
    fn places(self, k: usize) -> impl Iterator<Item = (String, String)> {
        let on = self.on;
        self.names.into_iter().enumerate().flat_map(move |(kind, names)| {
            let kind = if on == On::Vectors { format!(".{kind}") } else { String::new() };
            let place = move |(i, name)| (name, format!("part{k}{kind}[{i}]"));
            names.into_iter().enumerate().map(place)
        })
    }

    /// As an expression.
    fn text(&self) -> String {
        let lists = self.names.each_ref().map(|names| format!("[{}]", names.join(", ")));
        if self.on == On::Vectors { format!("({})", lists.join(", ")) } else { lists[0].clone() }
    }

    /// Their type.
    fn types(&self) -> String {
        if self.on != On::Vectors {
            return format!("[T; {}]", self.names[0].len());
        }
        let types = VECTORS.iter().zip(&self.names).map(|(kind, names)| {
            // No values are of a type that is not mentioned.
            let kind = if names.is_empty() { "A" } else { kind.name };
            format!("[{kind}; {}]", names.len())
        });
        format!("({})", types.collect::<Vec<_>>().join(", "))
    }
}

/// Where the text of a function begins.
fn head(name: &str, bound: &str, inputs: &[String], returned: &str) -> String {
    format!("fn {name}<{bound}>({}) -> {returned} {{\n", inputs.join(", "))
}

/// The angles, of which sine or cosine are needed, that are inputs or inputs turned by a constant, by
/// their lanes; none if there is one alone.
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

/// Whether a node is an input or a constant, or such side by side.
fn is_known(graph: &Graph, id: Id) -> bool {
    match graph.node(id) {
        Node::Input(_) | Node::Constant(_) => true,
        Node::Beside(a, b, _) => is_known(graph, a) && is_known(graph, b),
        _ => false,
    }
}

/// The negative of what an operand's text gives.
fn negated(text: String) -> String {
    text.strip_prefix('-').map_or_else(|| format!("-{text}"), String::from)
}

/// What the input of that number is called, and the parameter that it belongs to.
pub(super) fn input(parameters: &[Parameter], number: usize) -> (String, &Parameter) {
    let mut rest = number;
    for parameter in parameters {
        if rest < parameter.shape.len() {
            return (parameter.entry(rest), parameter);
        }
        rest -= parameter.shape.len();
    }
    unreachable!("the graph's inputs are the function's parameters")
}

/// A constant as an expression, the same in so many lanes.
pub(super) fn constant(value: f64, width: u8) -> String {
    let k = if width == 1 { "k".to_string() } else { format!("k{width}") };
    format!("{k}({})", number(value))
}

/// A constant as a number.
fn number(value: f64) -> String {
    if value.is_finite() {
        format!("{value:?}")
    } else {
        // Figures are below 1e60 (`urdf::build::LARGEST`), but folding multiplies them, along a
        // chain without end: what overflows is written as what it would be at run time.
        format!("f64::from_bits({})", value.to_bits())
    }
}

/// Names for a parameter's entries.
pub(super) fn unpacked(parameter: &Parameter) -> String {
    let Parameter { name, shape, .. } = parameter;
    let names: Vec<String> = (0..shape.len()).map(|i| parameter.entry(i)).collect();
    format!("let {} = *{name};", shape.value(&names))
}
