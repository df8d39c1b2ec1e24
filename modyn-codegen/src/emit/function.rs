//! A graph as the text of straight-line Rust functions.
//!
//! rustc takes more than linear time for long bodies, and with debug information crashes on some
//! thousands of `let`s in one scope. So statements go into blocks, `let (live, ...) = { ... };`,
//! and long functions into parts that hand each other what is still needed.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::ops::Range;

use super::Shape;
use crate::expr::{Graph, Id, Node};
use crate::names::type_name;

/// Most statements in one block.
const BLOCK: usize = 250;

/// Most statements in one function.
const PART: usize = 1500;

/// The same on lanes, which the compiler works on in memory at first, in more than linear time.
const LANES_PART: usize = 500;

/// A parameter, given by reference.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    pub name: &'static str,
    pub shape: Shape,
}

impl Parameter {
    pub(super) fn new(name: &'static str, shape: Shape) -> Self {
        Self { name, shape }
    }

    /// With its type over scalar `t`.
    pub(super) fn typed(&self, t: &str) -> String {
        format!("{}: &{}", self.name, self.shape.type_of(t))
    }
}

/// A private generic function `name<T: Scalar>` that computes the graph, with its parts.
pub(super) fn function(
    name: &str,
    parameters: &[Parameter],
    shape: &Shape,
    graph: &Graph,
) -> String {
    Writer::new(name, parameters, graph).write(shape, false)
}

/// The same for lanes: always inlined into what is compiled for their instructions, with parts that the
/// lanes outline.
pub(super) fn lanes_function(
    name: &str,
    parameters: &[Parameter],
    shape: &Shape,
    graph: &Graph,
) -> String {
    Writer::new(name, parameters, graph).write(shape, true)
}

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
    /// For each node the statement that computes it; `None` for what is written where it is used.
    statement_of: Vec<Option<usize>>,
    /// What is computed, statement by statement.
    statements: Vec<Statement>,
    /// The last statement that uses each statement's value; `usize::MAX` where it is an output.
    last_use: Vec<usize>,
    live: Vec<bool>,
}

impl<'a> Writer<'a> {
    fn new(name: &'a str, parameters: &'a [Parameter], graph: &'a Graph) -> Self {
        let (live, uses) = (graph.live(), graph.uses());
        let nodes = graph.nodes();
        // A product used once, in a sum, is written there.
        let mut in_place = vec![false; nodes.len()];
        for (node, &live) in nodes.iter().zip(&live) {
            if let (true, Node::Add(..) | Node::Sub(..)) = (live, node) {
                for operand in node.operands().map(|id| id as usize) {
                    in_place[operand] |=
                        uses[operand] == 1 && matches!(nodes[operand], Node::Mul(..));
                }
            }
        }
        let mut statement_of = vec![None; nodes.len()];
        let mut statements = Vec::new();
        // Sines and cosines of what is known at once come first, together: they share vector
        // instructions, and the rest need not wait for them one by one.
        let early = early_angles(graph, &live);
        for &angle in &early {
            if !matches!(graph.node(angle), Node::Input(_)) {
                statement_of[angle as usize] = Some(statements.len());
                statements.push(Statement::Node(angle));
            }
        }
        let mut angles: BTreeMap<Id, usize> =
            early.iter().map(|&angle| (angle, statements.len())).collect();
        if !early.is_empty() {
            statements.push(Statement::Angles(early));
        }
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
            statement_of,
            last_use: vec![0; statements.len()],
            statements,
            live,
        };
        for s in 0..writer.statements.len() {
            for used in writer.uses_of(s) {
                writer.last_use[used] = s;
            }
        }
        for &output in &graph.outputs {
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
            None => {
                self.graph.node(id).operands().flat_map(|operand| self.reached(operand)).collect()
            }
        }
    }

    /// The statements whose values statement `s` mentions.
    fn uses_of(&self, s: usize) -> Vec<usize> {
        match &self.statements[s] {
            Statement::Node(id) => {
                let node = self.graph.node(*id);
                node.operands().flat_map(|operand| self.reached(operand)).collect()
            }
            Statement::Angles(angles) => {
                angles.iter().flat_map(|&angle| self.reached(angle)).collect()
            }
        }
    }

    /// The text of a node's value.
    fn text(&self, id: Id) -> String {
        let node = self.graph.node(id);
        match (self.statement_of[id as usize], node) {
            (Some(s), Node::Sin(angle)) => format!("s{}", self.turn(s, angle)),
            (Some(s), Node::Cos(angle)) => format!("c{}", self.turn(s, angle)),
            (Some(s), _) => format!("x{s}"),
            (None, node) => self.operation(node),
        }
    }

    fn operation(&self, node: Node) -> String {
        let t = |id| self.text(id);
        match node {
            Node::Constant(bits) => constant(f64::from_bits(bits)),
            Node::Input(number) => self.input(number as usize),
            // Only sums have products written in place.
            Node::Neg(a) => negated(t(a)),
            Node::Add(a, b) => match (self.product(a), self.product(b)) {
                (Some([x, y]), _) => format!("T::mul_add({x}, {y}, {})", t(b)),
                (None, Some([x, y])) => format!("T::mul_add({x}, {y}, {})", t(a)),
                (None, None) => format!("{} + {}", t(a), t(b)),
            },
            Node::Sub(a, b) => match (self.product(a), self.product(b)) {
                (_, Some([x, y])) => format!("T::mul_add({}, {y}, {})", negated(x), t(a)),
                (Some([x, y]), None) => format!("T::mul_add({x}, {y}, {})", negated(t(b))),
                (None, None) => format!("{} - {}", t(a), t(b)),
            },
            Node::Mul(a, b) => format!("{} * {}", t(a), t(b)),
            Node::Recip(a) => format!("T::recip({})", t(a)),
            Node::Sin(a) | Node::Cos(a) => format!("T::sin_cos({})", t(a)),
            Node::Atan2(a, b) => format!("T::atan2({}, {})", t(a), t(b)),
            Node::Sqrt(a) => format!("T::sqrt({})", t(a)),
            Node::Ln(a) => format!("T::ln({})", t(a)),
            Node::Abs(a) => format!("T::abs({})", t(a)),
            Node::Max(a, b) => format!("T::max({}, {})", t(a), t(b)),
            Node::Select(a, b, c) => format!("T::select_nonnegative({}, {}, {})", t(a), t(b), t(c)),
        }
    }

    /// The factors of a product that is written in place.
    fn product(&self, id: Id) -> Option<[String; 2]> {
        match (self.statement_of[id as usize], self.graph.node(id)) {
            (None, Node::Mul(a, b)) => Some([self.text(a), self.text(b)]),
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
        let mut rest = number;
        for parameter in self.parameters {
            if rest < parameter.shape.len() {
                return format!("{}{rest}", parameter.name);
            }
            rest -= parameter.shape.len();
        }
        unreachable!("the graph's inputs are the function's parameters")
    }

    /// The names of the sine and cosine of `angle` that are used.
    fn turn_names(&self, angle: Id) -> [Option<String>; 2] {
        [Node::Sin(angle), Node::Cos(angle)].map(|node| {
            let found = self.graph.find(node).filter(|&id| self.live[id as usize]);
            found.map(|id| self.text(id))
        })
    }

    /// The names that statement `s` defines; a sine or cosine that nothing uses is left out.
    fn names(&self, s: usize) -> Vec<String> {
        let turns = |angle: Id| self.turn_names(angle).into_iter().flatten();
        match &self.statements[s] {
            Statement::Node(id) => match self.graph.node(*id) {
                Node::Sin(angle) | Node::Cos(angle) => turns(angle).collect(),
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
                let node = self.graph.node(*id);
                let value = self.operation(node);
                match node {
                    Node::Sin(angle) | Node::Cos(angle) => {
                        format!("let {} = {value};", pattern(angle))
                    }
                    _ => format!("let x{s} = {value};"),
                }
            }
            Statement::Angles(angles) => {
                let patterns: Vec<String> = angles.iter().map(|&angle| pattern(angle)).collect();
                let values: Vec<String> = angles.iter().map(|&angle| self.text(angle)).collect();
                let (patterns, values) = (patterns.join(", "), values.join(", "));
                format!("let [{patterns}] = T::sin_cos_all([{values}]);")
            }
        }
    }

    /// What is defined before `end` (and not before `start`) and used from `end` on.
    fn needed_after(&self, start: usize, end: usize) -> Vec<String> {
        (start..end).filter(|&s| self.last_use[s] >= end).flat_map(|s| self.names(s)).collect()
    }

    /// What is defined before the range and used in it.
    fn mentioned_before(&self, range: Range<usize>) -> Vec<String> {
        let used: BTreeSet<usize> = range.clone().flat_map(|s| self.uses_of(s)).collect();
        used.range(..range.start).flat_map(|&s| self.names(s)).collect()
    }

    fn write(&self, shape: &Shape, lanes: bool) -> String {
        let count = self.statements.len();
        let parts = count.div_ceil(if lanes { LANES_PART } else { PART }).max(1);
        // Parts of equal length, the last one with the result.
        let bounds: Vec<Range<usize>> =
            (0..parts).map(|k| k * count / parts..(k + 1) * count / parts).collect();
        let mut text = String::new();
        for (k, range) in bounds.iter().enumerate() {
            let last = k + 1 == parts;
            let handed = self.mentioned_before(range.clone());
            let needed = self.needed_after(range.start, range.end);
            let returned = if last { shape.type_of("T") } else { format!("[T; {}]", needed.len()) };
            let name = if last { self.name.to_string() } else { format!("{}_part{k}", self.name) };
            let mut inputs: Vec<String> = self.parameters.iter().map(|p| p.typed("T")).collect();
            if k > 0 && !last {
                inputs.push(format!("live: &[T; {}]", handed.len()));
            }
            text += &match (lanes, last) {
                (false, _) => head(&name, "Scalar", &inputs, &returned),
                (true, true) => {
                    let head = head(&name, "batch::Lanes", &inputs, &returned);
                    format!("#[inline(always)]\n{head}")
                }
                (true, false) => self.part_head(&name, &inputs, &returned),
            };
            let _ = writeln!(text, "    let k = T::from_f64;");
            for parameter in self.parameters {
                let _ = writeln!(text, "    {}", unpacked(parameter));
            }
            if last {
                self.call_parts(&mut text, &bounds[..k], lanes);
            } else if k > 0 {
                let _ = writeln!(text, "    let [{}] = *live;", handed.join(", "));
            }
            self.blocks(&mut text, range.clone());
            let value = if last {
                let outputs: Vec<String> =
                    self.graph.outputs.iter().map(|&id| self.text(id)).collect();
                shape.value(&outputs)
            } else {
                format!("[{}]", needed.join(", "))
            };
            let end = if lanes && !last { "}\n}" } else { "}" };
            let _ = writeln!(text, "    {value}\n{end}\n");
        }
        text
    }

    /// Where the text of a part begins that lanes outline: a type that holds the arguments, and what it
    /// does.
    fn part_head(&self, name: &str, inputs: &[String], returned: &str) -> String {
        let fields: Vec<String> = inputs.iter().map(|input| input.replace('&', "&'a ")).collect();
        let names: Vec<&str> = inputs.iter().filter_map(|i| i.split(':').next()).collect();
        let kind = type_name(name);
        format!(
            "struct {kind}<'a, T> {{ {} }}\n\
             impl<T: __modyn::batch::Lanes> __modyn::batch::Part for {kind}<'_, T> {{\n\
             type Output = {returned};\n\
             #[inline(always)]\nfn run(self) -> {returned} {{\n    let Self {{ {} }} = self;\n",
            fields.join(", "),
            names.join(", "),
        )
    }

    /// The calls of the earlier parts, in the last one.
    fn call_parts(&self, text: &mut String, parts: &[Range<usize>], lanes: bool) {
        for (k, range) in parts.iter().enumerate() {
            let needed = self.needed_after(range.start, range.end).join(", ");
            let handed = self.mentioned_before(range.clone()).join(", ");
            let mut arguments: Vec<String> =
                self.parameters.iter().map(|p| p.name.to_string()).collect();
            if k > 0 {
                let name = if lanes { "live: " } else { "" };
                arguments.push(format!("{name}&[{handed}]"));
            }
            let (name, arguments) = (format!("{}_part{k}", self.name), arguments.join(", "));
            let call = if lanes {
                format!("T::outlined({} {{ {arguments} }})", type_name(&name))
            } else {
                format!("{name}({arguments})")
            };
            let _ = writeln!(text, "    let [{needed}] = {call};");
        }
    }

    fn blocks(&self, text: &mut String, range: Range<usize>) {
        if range.len() <= BLOCK {
            for s in range {
                let _ = writeln!(text, "    {}", self.statement(s));
            }
            return;
        }
        let mut start = range.start;
        while start < range.end {
            let end = (start + BLOCK).min(range.end);
            let needed = self.needed_after(start, end).join(", ");
            let _ = writeln!(text, "    let ({needed},) = {{");
            for s in start..end {
                let _ = writeln!(text, "        {}", self.statement(s));
            }
            let _ = writeln!(text, "        ({needed},)\n    }};");
            start = end;
        }
    }
}

/// Where the text of a function begins.
fn head(name: &str, bound: &str, inputs: &[String], returned: &str) -> String {
    format!("fn {name}<T: __modyn::{bound}>({}) -> {returned} {{\n", inputs.join(", "))
}

/// The angles, of which sine or cosine are needed, that are inputs or inputs turned by a constant;
/// none if there is one alone.
fn early_angles(graph: &Graph, live: &[bool]) -> Vec<Id> {
    let mut angles = Vec::new();
    for (node, _) in graph.nodes().iter().zip(live).filter(|&(_, &live)| live) {
        let (Node::Sin(angle) | Node::Cos(angle)) = *node else { continue };
        let known = match graph.node(angle) {
            Node::Input(_) => true,
            node @ (Node::Add(..) | Node::Sub(..)) => node
                .operands()
                .all(|operand| matches!(graph.node(operand), Node::Input(_) | Node::Constant(_))),
            _ => false,
        };
        if known && !angles.contains(&angle) {
            angles.push(angle);
        }
    }
    if angles.len() < 2 { Vec::new() } else { angles }
}

/// The negative of what an operand's text gives.
fn negated(text: String) -> String {
    text.strip_prefix('-').map_or_else(|| format!("-{text}"), String::from)
}

/// A constant as an expression of type T.
fn constant(value: f64) -> String {
    if value == 0.0 {
        "T::zero()".into()
    } else if value == 1.0 {
        "T::one()".into()
    } else if value.is_finite() {
        format!("k({value:?})")
    } else {
        // Figures are below 1e60 (`urdf::build::LARGEST`), but folding multiplies them, along a
        // chain without end: what overflows is written as what it would be at run time.
        format!("k(f64::from_bits({}))", value.to_bits())
    }
}

/// Names for a parameter's entries.
fn unpacked(Parameter { name, shape }: &Parameter) -> String {
    let names: Vec<String> = (0..shape.len()).map(|i| format!("{name}{i}")).collect();
    format!("let {} = *{name};", shape.value(&names))
}
