//! The text of a program, which can be read again: for tests, pages and bug reports.
//!
//! ```text
//! program scalar, 3 arguments
//! x0 = sin_cos(a0)
//! x1 = x0.1 * a1
//! x2 = fused(-[x0 * a2] + x1)
//! results x2, -x1
//! ```
//!
//! `a0` is an argument, `x0` the first result of statement 0, `x0.1` its second result. A vector of
//! four lanes is defined as `x3<4>`. `equations 3 6, 1 (x4, ...)` are row equations: the numbers of
//! rows of the constraints, the number of right-hand sides, then the operands. The tables and
//! routines of loops come before the statements (`loops/text.rs`). Products of matrices come after
//! the results: `products 2, x5, x6, ...` is a matrix A of two rows, with its entries by columns,
//! and `of 0..2:12+1+4, x7, ...` a matrix B that it multiplies: the entries of A B are added to
//! results, rows 0 and 1 of the first column to results 12 and 13, of the next one to 16 and 17.

use std::fmt;
use std::ops::Range;
use std::str::{FromStr, Lines};

use super::{
    Addend, Execution, MultiplyAdd, Operand, Operation, Products, Program, RowEquations, Source,
    Statement, Value,
};
use crate::graph::dense::{ProductForm, ProductTarget};

impl Execution {
    const NAMES: [(&'static str, Self); 4] = [
        ("scalar", Self::Scalar),
        ("simd", Self::Simd),
        ("batch", Self::Batch),
        ("threads", Self::Threads),
    ];

    /// Returns the name in texts of programs.
    #[must_use]
    pub fn name(self) -> &'static str {
        let named = Self::NAMES.iter().find(|(_, execution)| *execution == self);
        named.map_or("", |(name, _)| name)
    }
}

type Unary = fn(Operand) -> Operation;
type Binary = fn(Operand, Operand) -> Operation;

/// Operations of one, two and three operands, by name.
const UNARY: [(&str, Unary); 4] = [
    ("reciprocal", Operation::Reciprocal),
    ("sqrt", Operation::SquareRoot),
    ("ln", Operation::Logarithm),
    ("abs", Operation::Absolute),
];
const BINARY: [(&str, Binary); 2] = [("atan2", Operation::Atan2), ("max", Operation::Maximum)];
const SELECT: &str = "select";

impl fmt::Display for Program {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "program {}, {} arguments", self.execution.name(), self.arguments)?;
        self.tables.iter().try_for_each(|table| table.fmt(f))?;
        self.routines.iter().try_for_each(|routine| routine.fmt(f))?;
        for (s, Statement { operation, lanes, .. }) in self.statements.iter().enumerate() {
            let lanes = if *lanes == 1 { String::new() } else { format!("<{lanes}>") };
            writeln!(f, "x{s}{lanes} = {operation}")?;
        }
        writeln!(f, "results {}", list(&self.results))?;
        self.products.iter().try_for_each(|products| products.fmt(f))
    }
}

impl fmt::Display for Products {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rows, terms, entries, targets, .. } = self;
        let (a, others) = entries.split_at(rows * terms);
        writeln!(f, "products {rows}, {}", list(a))?;
        for (b, targets) in others.chunks(terms * self.columns()).zip(targets) {
            let target = |ProductTarget { rows, first, by_row, by_column }: &ProductTarget| {
                format!("{rows:?}:{first}+{by_row}+{by_column}")
            };
            let targets: Vec<String> = targets.iter().map(target).collect();
            writeln!(f, "of {}, {}", targets.join(" "), list(b))?;
        }
        Ok(())
    }
}

impl fmt::Display for Operation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self {
            Self::Add(a, b) => return write!(f, "{a} + {b}"),
            Self::Subtract(a, b) => return write!(f, "{a} - {b}"),
            Self::Multiply(a, b) => return write!(f, "{a} * {b}"),
            Self::MultiplyAdd(MultiplyAdd {
                negative_product,
                factors,
                negative_addend,
                addend,
            }) => {
                let unsigned = format!("{} * {}", factors[0], factors[1]);
                let product = if *negative_product { format!("-[{unsigned}]") } else { unsigned };
                let addend = match addend {
                    Addend::Value(c) => c.to_string(),
                    Addend::Product(c, d) => format!("{c} * {d}"),
                };
                let sign = if *negative_addend { '-' } else { '+' };
                return write!(f, "fused({product} {sign} {addend})");
            }
            Self::Constants(lanes) => {
                let numbers: Vec<String> = lanes.iter().map(|x| format!("{x:?}")).collect();
                return write!(f, "constants({})", numbers.join(", "));
            }
            Self::Loops(loops) => return loops.fmt(f),
            Self::RowEquations(RowEquations { blocks, sides, operands }) => {
                let lengths: Vec<String> = blocks.iter().map(usize::to_string).collect();
                let blocks = lengths.join(" ");
                return write!(f, "equations {blocks}, {sides} ({})", list(operands));
            }
            Self::Reciprocal(_) => "reciprocal",
            Self::SinCos(_) => "sin_cos",
            Self::Atan2(..) => "atan2",
            Self::SquareRoot(_) => "sqrt",
            Self::Logarithm(_) => "ln",
            Self::Absolute(_) => "abs",
            Self::Maximum(..) => "max",
            Self::Select(..) => SELECT,
            Self::Pack(_) => "pack",
            Self::Unpack(_) => "unpack",
        };
        write!(f, "{name}({})", list(&self.operands()))
    }
}

impl fmt::Display for Operand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.negated {
            write!(f, "-")?;
        }
        match self.source {
            // A sign of the constant is no sign of the operand.
            Source::Constant(value) if value.is_sign_negative() => write!(f, "({value:?})"),
            Source::Constant(value) => write!(f, "{value:?}"),
            Source::Argument(number) => write!(f, "a{number}"),
            Source::Result(Value { statement, place: 0 }) => write!(f, "x{statement}"),
            Source::Result(Value { statement, place }) => write!(f, "x{statement}.{place}"),
        }
    }
}

/// Returns the texts of operands, separated by commas.
fn list(operands: &[Operand]) -> String {
    operands.iter().map(Operand::to_string).collect::<Vec<_>>().join(", ")
}

/// The error of a text that is no program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParseProgramError {
    /// The line, from 1 on; the line after the text, if that ends too early.
    pub line: usize,
    /// The fault and its remedy.
    pub message: String,
}

impl fmt::Display for ParseProgramError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.message)
    }
}

impl std::error::Error for ParseProgramError {}

impl FromStr for Program {
    type Err = ParseProgramError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut parser = Parser { lines: text.lines(), line: 0, depth: 0 };
        let program = parser.program()?;
        match parser.lines.find(|line| !line.trim().is_empty()) {
            None => Ok(program),
            Some(_) => {
                parser.line += 1;
                Err(parser.error("the program ended with its line `results`"))
            }
        }
    }
}

pub(super) struct Parser<'a> {
    lines: Lines<'a>,
    /// The number of the current line.
    line: usize,
    /// The number of routines around the current line.
    depth: usize,
}

impl<'a> Parser<'a> {
    pub(super) fn error(&self, message: impl Into<String>) -> ParseProgramError {
        ParseProgramError { line: self.line, message: message.into() }
    }

    pub(super) fn next(&mut self) -> Result<&'a str, ParseProgramError> {
        self.line += 1;
        let line = self.lines.next().map(str::trim);
        line.ok_or_else(|| self.error("the text ends; a program ends with a line `results`"))
    }

    fn program(&mut self) -> Result<Program, ParseProgramError> {
        let head = self.next()?;
        let words = head.strip_prefix("program ").and_then(|rest| rest.split_once(", "));
        let (execution, arguments) = words
            .and_then(|(name, rest)| {
                let execution =
                    Execution::NAMES.iter().find(|(execution_name, _)| *execution_name == name)?.1;
                Some((execution, rest.strip_suffix(" arguments")?.parse().ok()?))
            })
            .ok_or_else(|| {
                self.error(format!(
                    "{head:?} does not begin a program, as `program scalar, 3 arguments` does"
                ))
            })?;
        let mut program = Program::without_statements(execution, arguments);
        loop {
            let line = self.next()?;
            if let Some(results) = line.strip_prefix("results") {
                program.results = self.operands(&program, results, 1)?;
                program.products = self.products(&program)?;
                break;
            } else if let Some(head) = line.strip_prefix("routine ") {
                let routine = self.routine(head)?;
                program.routines.push(routine);
            } else if line == "table" {
                program.tables.push(self.table()?);
            } else {
                let statement = self.statement(&program, line)?;
                program.statements.push(statement);
            }
        }
        for value in values(&program) {
            program.statements[value.statement].used[value.place] = true;
        }
        program.finished().map_err(|invalid| self.error(format!("the rule is: {}", invalid.rule)))
    }

    /// Returns the products of a program whose results were read; `None` if the next line is
    /// something else.
    fn products(&mut self, program: &Program) -> Result<Option<Products>, ParseProgramError> {
        let Some(head) = self.next_after("products ") else { return Ok(None) };
        let parts = head.split_once(", ").and_then(|(rows, a)| Some((rows.parse().ok()?, a)));
        let (rows, a): (usize, _) = parts
            .ok_or_else(|| self.error(format!("{head:?} are no products, as `2, x5, x6` are")))?;
        let mut operands = self.operands(program, a, 1)?;
        let entries = operands.len();
        let mut targets = Vec::new();
        while let Some(text) = self.next_after("of ") {
            let parts = text.split_once(", ").and_then(|(all, b)| {
                Some((all.split(' ').map(target).collect::<Option<Vec<_>>>()?, b))
            });
            let (all, b) = parts.ok_or_else(|| {
                self.error(format!("{text:?} is no matrix, as `0..2:12+1+4, x7` is"))
            })?;
            targets.push(all);
            operands.extend(self.operands(program, b, 1)?);
        }
        if rows == 0 || entries == 0 || targets.is_empty() || !entries.is_multiple_of(rows) {
            return Err(
                self.error("products have a matrix A of whole columns, and others after it")
            );
        }
        let results = program.results.len();
        let form = ProductForm { rows, terms: entries / rows, results, targets };
        let columns = (operands.len() - entries) / (form.terms * form.targets.len());
        if operands.len() != entries + columns * form.terms * form.targets.len() {
            return Err(self.error("matrices of products are whole"));
        }
        Ok(Some(Products::new(&form, operands, &program.results, program.execution)))
    }

    /// Returns the rest of the next line if that begins with `word`; otherwise the line is not
    /// read.
    pub(super) fn next_after(&mut self, word: &str) -> Option<&'a str> {
        let rest = self.lines.clone().next()?.trim().strip_prefix(word)?;
        self.lines.next();
        self.line += 1;
        Some(rest)
    }

    /// Reads the program of a routine.
    pub(super) fn inner_program(&mut self) -> Result<Program, ParseProgramError> {
        // Routines of modyn call no routines; texts of strangers must not exhaust the stack.
        if self.depth > 3 {
            return Err(self.error("a routine is inside of too many others"));
        }
        self.depth += 1;
        let program = self.program()?;
        self.depth -= 1;
        Ok(program)
    }

    fn statement(&mut self, program: &Program, line: &str) -> Result<Statement, ParseProgramError> {
        let wrong = |expected: &str| self.error(format!("{line:?} is no statement: {expected}"));
        let (name, text) = line.split_once(" = ").ok_or_else(|| wrong("it has no ` = `"))?;
        let number = format!("x{}", program.statements.len());
        let suffix = match name.strip_prefix(&number) {
            Some("") => Some(1),
            Some(rest) => {
                let lanes = rest.strip_prefix('<').and_then(|rest| rest.strip_suffix('>'));
                lanes.and_then(|lanes| lanes.parse().ok()).filter(|lanes| (2..=64).contains(lanes))
            }
            None => None,
        };
        let lanes: u8 = suffix.ok_or_else(|| {
            wrong(&format!("the next one is `{number}`, or `{number}<4>` for four lanes"))
        })?;
        let operation = match text.strip_prefix("loops ") {
            Some(lengths) => Operation::Loops(self.loops(program, lengths)?),
            None => self.operation(program, text, lanes)?,
        };
        let results = match &operation {
            Operation::SinCos(angles) => 2 * angles.len(),
            Operation::Unpack(vector) => vector.lanes.into(),
            Operation::RowEquations(equations) => equations.results(),
            Operation::Loops(loops) => loops.results.len(),
            _ => 1,
        };
        // All results of loops are there. A statement with one result has it, also if nothing reads
        // it, as the constants within wider constants.
        let used = vec![results == 1 || matches!(operation, Operation::Loops(_)); results];
        Ok(Statement { operation, lanes, used, last_use: 0, stores: Vec::new() })
    }

    fn operation(
        &self,
        program: &Program,
        text: &str,
        lanes: u8,
    ) -> Result<Operation, ParseProgramError> {
        let wrong = || self.error(format!("{text:?} is no operation"));
        let operand = |text: &str| self.operand(program, text, lanes);
        if let Some(rest) = text.strip_prefix("equations ") {
            let (form, operands) = rest.split_once(" (").ok_or_else(wrong)?;
            let operands = operands.strip_suffix(')').ok_or_else(wrong)?;
            let (blocks, sides) = form.split_once(", ").ok_or_else(wrong)?;
            // Larger numbers are not the rows of a constraint.
            let number = |number: &str| Some(usize::from(number.parse::<u8>().ok()?));
            let blocks: Option<Vec<usize>> = blocks.split(' ').map(number).collect();
            return Ok(Operation::RowEquations(RowEquations {
                blocks: blocks.ok_or_else(wrong)?,
                sides: number(sides).ok_or_else(wrong)?,
                operands: self.operands(program, operands, 1)?,
            }));
        }
        let named = text.strip_suffix(')').and_then(|text| text.split_once('('));
        let Some((name, inside)) = named.filter(|(name, _)| {
            !name.is_empty()
                && name.starts_with(char::is_alphabetic)
                && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        }) else {
            let (a, operator, b) = binary(text).ok_or_else(wrong)?;
            let a = operand(a)?;
            let b = operand(b)?;
            return match operator {
                '+' => Ok(Operation::Add(a, b)),
                '-' => Ok(Operation::Subtract(a, b)),
                _ => Ok(Operation::Multiply(a, b)),
            };
        };
        match name {
            "fused" => self.fused(program, inside, lanes),
            "constants" => Ok(Operation::Constants(self.numbers(inside)?)),
            "pack" => Ok(Operation::Pack(self.operands(program, inside, 1)?)),
            "sin_cos" => Ok(Operation::SinCos(self.operands(program, inside, lanes)?)),
            // The operand of `unpack` has lanes, but no result.
            "unpack" => {
                let mut vector = operand(inside)?;
                vector.lanes = program.lanes_of(vector.source);
                Ok(Operation::Unpack(vector))
            }
            _ => {
                let operands = self.operands(program, inside, lanes)?;
                match *operands {
                    [a] => UNARY
                        .iter()
                        .find(|(operator, _)| *operator == name)
                        .map(|(_, build)| build(a)),
                    [a, b] => BINARY
                        .iter()
                        .find(|(operator, _)| *operator == name)
                        .map(|(_, build)| build(a, b)),
                    [a, b, c] => (name == SELECT).then_some(Operation::Select(a, b, c)),
                    _ => None,
                }
                .ok_or_else(wrong)
            }
        }
    }

    fn fused(
        &self,
        program: &Program,
        text: &str,
        lanes: u8,
    ) -> Result<Operation, ParseProgramError> {
        let wrong = || self.error(format!("{text:?} is no fused sum, as `a0 * a1 + x0` is"));
        let operand = |text: &str| self.operand(program, text, lanes);
        let (product, rest, negative_product) = match text.strip_prefix("-[") {
            Some(inside) => {
                let (product, rest) = inside.split_once(']').ok_or_else(wrong)?;
                (product, rest, true)
            }
            None => {
                let end = [" + ", " - "].iter().filter_map(|end| text.find(end)).min();
                let (product, rest) = text.split_at(end.ok_or_else(wrong)?);
                (product, rest, false)
            }
        };
        let (negative_addend, addend) = match (rest.strip_prefix(" + "), rest.strip_prefix(" - ")) {
            (Some(addend), _) => (false, addend),
            (None, Some(addend)) => (true, addend),
            (None, None) => return Err(wrong()),
        };
        let (a, b) = product.split_once(" * ").ok_or_else(wrong)?;
        let addend = match addend.split_once(" * ") {
            Some((c, d)) => Addend::Product(operand(c)?, operand(d)?),
            None => Addend::Value(operand(addend)?),
        };
        let factors = [operand(a)?, operand(b)?];
        let fused = MultiplyAdd { negative_product, factors, negative_addend, addend };
        Ok(Operation::MultiplyAdd(fused))
    }

    fn operands(
        &self,
        program: &Program,
        text: &str,
        lanes: u8,
    ) -> Result<Vec<Operand>, ParseProgramError> {
        items(text).map(|text| self.operand(program, text, lanes)).collect()
    }

    pub(super) fn operand(
        &self,
        program: &Program,
        text: &str,
        lanes: u8,
    ) -> Result<Operand, ParseProgramError> {
        let wrong = |why: &str| self.error(format!("{text:?} is no operand: {why}"));
        let (negated, text) = match text.strip_prefix('-') {
            Some(rest) => (true, rest),
            None => (false, text),
        };
        let numbered = |rest: &str| rest.parse::<usize>().ok();
        let source = if let Some(number) = text.strip_prefix('a').and_then(numbered) {
            Source::Argument(number)
        } else if let Some(value) = text.strip_prefix('x') {
            let (statement, place) = value.split_once('.').unwrap_or((value, "0"));
            let value = numbered(statement).zip(numbered(place));
            let (statement, place) = value.ok_or_else(|| wrong("a result is `x0` or `x0.1`"))?;
            let computed = program.statements.get(statement);
            if computed.is_none_or(|computed| place >= computed.used.len()) {
                return Err(wrong("no statement before this one has that result"));
            }
            Source::Result(Value { statement, place })
        } else {
            let inside = text.strip_prefix('(').and_then(|text| text.strip_suffix(')'));
            let number = inside.unwrap_or(text).parse();
            Source::Constant(number.map_err(|_| wrong("use `a0`, `x0` or a number"))?)
        };
        Ok(Operand { source, negated, lanes })
    }

    fn numbers(&self, text: &str) -> Result<Vec<f64>, ParseProgramError> {
        let number =
            |text: &str| text.parse().map_err(|_| self.error(format!("{text:?} is not a number")));
        items(text).map(number).collect()
    }
}

/// Returns the values that statements and results read.
fn values(program: &Program) -> Vec<Value> {
    let statements = program.statements.iter();
    let of_statements = statements.flat_map(|statement| statement.operation.operands());
    let operands = of_statements.chain(program.all_stored().chain(program.read_last()).copied());
    operands.filter_map(|operand| operand.value()).collect()
}

/// Returns the results to which rows of products are added.
fn target(text: &str) -> Option<ProductTarget> {
    let (rows, places) = text.split_once(':')?;
    let places: Option<Vec<usize>> = places.split('+').map(|place| place.parse().ok()).collect();
    match *places? {
        [first, by_row, by_column] => {
            Some(ProductTarget { rows: range(rows)?, first, by_row, by_column })
        }
        _ => None,
    }
}

/// Returns a range of numbers.
fn range(text: &str) -> Option<Range<usize>> {
    let (start, end) = text.split_once("..")?;
    Some(start.parse().ok()?..end.parse().ok()?)
}

/// Returns the items of a list that commas separate.
pub(super) fn items(text: &str) -> impl Iterator<Item = &str> {
    text.split(',').map(str::trim).filter(|item| !item.is_empty())
}

/// Returns the operands and the operator of a sum, difference or product.
fn binary(text: &str) -> Option<(&str, char, &str)> {
    let operator = |operator| Some((text.split_once(operator)?, operator));
    let ((a, b), operator) =
        operator(" + ").or_else(|| operator(" - ")).or_else(|| operator(" * "))?;
    Some((a, operator.chars().nth(1)?, b))
}
