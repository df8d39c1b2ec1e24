//! A graph as the text of straight-line Rust functions.
//!
//! rustc takes more than linear time for long bodies, and with debug information crashes on some
//! thousands of `let`s in one scope. So statements go into blocks, `let (live, ...) = { ... };`,
//! and long functions into parts that hand each other what is still needed.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::ops::Range;

use crate::expr::{Graph, Id, Node};

/// Most statements in one block.
const BLOCK: usize = 250;

/// Most statements in one function.
const PART: usize = 1500;

/// A parameter: an array of that many scalars.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    pub name: &'static str,
    pub len: usize,
}

/// What a function returns, built from the graph's outputs in order.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shape {
    Scalar,
    Vector(usize),
    /// Columns, rows.
    Matrix(usize, usize),
    Poses(usize),
}

impl Shape {
    /// The Rust type over scalar `t`.
    pub(super) fn type_of(self, t: &str) -> String {
        match self {
            Self::Scalar => t.into(),
            Self::Vector(n) => format!("[{t}; {n}]"),
            Self::Matrix(columns, rows) => format!("[[{t}; {rows}]; {columns}]"),
            Self::Poses(n) => format!("[__modyn::spatial::Pose<{t}>; {n}]"),
        }
    }

    /// The value, from the text of each output.
    fn value(self, outputs: &[String]) -> String {
        let list = |items: &[String]| format!("[{}]", items.join(", "));
        let lines = |items: &[String]| match items {
            [] => "[]".into(),
            items => format!("[\n        {},\n    ]", items.join(",\n        ")),
        };
        match self {
            Self::Scalar => outputs.concat(),
            Self::Vector(_) => list(outputs),
            Self::Matrix(_, rows) => lines(&outputs.chunks(rows).map(list).collect::<Vec<_>>()),
            Self::Poses(_) => {
                let pose = |numbers: &[String]| {
                    let rows: Vec<String> = numbers[..9].chunks(3).map(list).collect();
                    let (rotation, translation) = (list(&rows), list(&numbers[9..]));
                    format!(
                        "__modyn::spatial::Pose {{ rotation: {rotation}, translation: {translation} }}"
                    )
                };
                lines(&outputs.chunks(12).map(pose).collect::<Vec<_>>())
            }
        }
    }
}

/// A private generic function `name<T: Scalar>` that computes the graph, with its parts.
pub(super) fn function(
    name: &str,
    parameters: &[Parameter],
    shape: Shape,
    graph: &Graph,
) -> String {
    Writer::new(name, parameters, graph).write(shape)
}

struct Writer<'a> {
    name: &'a str,
    parameters: &'a [Parameter],
    graph: &'a Graph,
    /// For each node the statement that computes it; `None` for what is written where it is used.
    statement_of: Vec<Option<usize>>,
    /// The nodes that have statements: one, or a sine with its cosine.
    statements: Vec<Id>,
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
        let mut angles = BTreeMap::new();
        for (i, node) in nodes.iter().enumerate() {
            let id = i as Id;
            match node {
                _ if !live[i] || in_place[i] => {}
                Node::Constant(_) | Node::Input(_) | Node::Neg(_) => {}
                Node::Sin(angle) | Node::Cos(angle) => {
                    let statement = *angles.entry(*angle).or_insert_with(|| {
                        statements.push(id);
                        statements.len() - 1
                    });
                    statement_of[i] = Some(statement);
                }
                _ => {
                    statement_of[i] = Some(statements.len());
                    statements.push(id);
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
        let node = self.graph.node(self.statements[s]);
        node.operands().flat_map(|operand| self.reached(operand)).collect()
    }

    /// The text of a node's value.
    fn text(&self, id: Id) -> String {
        let node = self.graph.node(id);
        match (self.statement_of[id as usize], node) {
            (Some(s), Node::Sin(_)) => format!("s{s}"),
            (Some(s), Node::Cos(_)) => format!("c{s}"),
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
            Node::Neg(a) => format!("-{}", t(a)),
            Node::Add(a, b) => format!("{} + {}", t(a), t(b)),
            Node::Sub(a, b) => format!("{} - {}", t(a), t(b)),
            Node::Mul(a, b) => format!("{} * {}", t(a), t(b)),
            Node::Recip(a) => format!("T::recip({})", t(a)),
            Node::Sin(a) | Node::Cos(a) => format!("T::sin_cos({})", t(a)),
            Node::Sqrt(a) => format!("T::sqrt({})", t(a)),
            Node::Ln(a) => format!("T::ln({})", t(a)),
            Node::Abs(a) => format!("T::abs({})", t(a)),
            Node::Max(a, b) => format!("T::max({}, {})", t(a), t(b)),
            Node::Select(a, b, c) => format!("T::select_nonnegative({}, {}, {})", t(a), t(b), t(c)),
        }
    }

    fn input(&self, number: usize) -> String {
        let mut rest = number;
        for parameter in self.parameters {
            if rest < parameter.len {
                return format!("{}{rest}", parameter.name);
            }
            rest -= parameter.len;
        }
        unreachable!("the graph's inputs are the function's parameters")
    }

    /// The names that statement `s` defines; a sine or cosine that nothing uses is left out.
    fn names(&self, s: usize) -> Vec<String> {
        match self.graph.node(self.statements[s]) {
            Node::Sin(angle) | Node::Cos(angle) => {
                let pair = |node| {
                    let found = self.graph.find(node).filter(|&id| self.live[id as usize]);
                    found.map(|id| self.text(id))
                };
                [pair(Node::Sin(angle)), pair(Node::Cos(angle))].into_iter().flatten().collect()
            }
            _ => vec![format!("x{s}")],
        }
    }

    fn statement(&self, s: usize) -> String {
        let node = self.graph.node(self.statements[s]);
        let value = self.operation(node);
        match node {
            Node::Sin(_) | Node::Cos(_) => match self.names(s).as_slice() {
                [only] if only.starts_with('s') => format!("let ({only}, _) = {value};"),
                [only] => format!("let (_, {only}) = {value};"),
                pair => format!("let ({}) = {value};", pair.join(", ")),
            },
            _ => format!("let x{s} = {value};"),
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

    fn write(&self, shape: Shape) -> String {
        let count = self.statements.len();
        let parts = count.div_ceil(PART).max(1);
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
            let inputs: Vec<String> =
                self.parameters.iter().map(|p| format!("{}: &[T; {}]", p.name, p.len)).collect();
            let handed_on = if k == 0 || last {
                String::new()
            } else {
                format!(", live: &[T; {}]", handed.len())
            };
            let _ = writeln!(
                text,
                "fn {name}<T: __modyn::Scalar>({}{handed_on}) -> {returned} {{",
                inputs.join(", ")
            );
            let _ = writeln!(text, "    let k = T::from_f64;");
            for parameter in self.parameters {
                let _ = writeln!(text, "    {}", unpacked(parameter));
            }
            if last {
                self.call_parts(&mut text, &bounds[..k]);
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
            let _ = writeln!(text, "    {value}\n}}\n");
        }
        text
    }

    /// The calls of the earlier parts, in the last one.
    fn call_parts(&self, text: &mut String, parts: &[Range<usize>]) {
        let arguments: Vec<&str> = self.parameters.iter().map(|p| p.name).collect();
        let arguments = arguments.join(", ");
        for (k, range) in parts.iter().enumerate() {
            let needed = self.needed_after(range.start, range.end).join(", ");
            let handed = self.mentioned_before(range.clone()).join(", ");
            let live = if k == 0 { String::new() } else { format!(", &[{handed}]") };
            let _ =
                writeln!(text, "    let [{needed}] = {}_part{k}({arguments}{live});", self.name);
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
fn unpacked(Parameter { name, len }: &Parameter) -> String {
    let names: Vec<String> = (0..*len).map(|i| format!("{name}{i}")).collect();
    format!("let [{}] = *{name};", names.join(", "))
}
