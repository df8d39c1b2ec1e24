//! The text of loops.
//!
//! ```text
//! table
//! row 0.5, 1.0; 3, 4
//! routine 2 constants
//! program scalar, 4 arguments
//! ..
//! end
//! x1 = loops 12, 7
//! store 0[3] = x0
//! for 0 reversed until 1[6]
//! call 0 (a[2+0.1], 0[3]) -> 0[5+0.0], +1[6]
//! end
//! end 1[0], 1[1]
//! ```
//!
//! A row of a table has its constants, then rows of arrays. `0[5+0.1]` is entry 5 of the row in
//! column 1 of the outermost loop, in array 0; `a` is the arguments. An array `3x4` has three rows
//! of length 4. A result is added to an entry behind `+`.

use std::fmt;
use std::str::FromStr;

use super::{
    Array, Call, Column, Entry, Loop, Loops, Place, Read, Routine, Row, Step, Stored, Table, Write,
};
use crate::program::Program;
use crate::program::text::{ParseProgramError, Parser, items};

/// The largest number of loops in each other in a text. Texts of strangers must not exhaust the
/// stack.
const MAX_DEPTH: usize = 16;

/// Returns the texts of a list, separated by commas.
fn list<T: fmt::Display>(items: &[T]) -> String {
    items.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "table")?;
        self.rows.iter().try_for_each(|Row { constants, places }| {
            let constants: Vec<String> = constants.iter().map(|x| format!("{x:?}")).collect();
            let places: Vec<String> = places.iter().map(|place| format!(" {place}")).collect();
            writeln!(f, "row {};{}", constants.join(", "), places.join(","))
        })
    }
}

impl fmt::Display for Routine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { program, constants, never_inline } = self;
        let inline = if *never_inline { ", never inlined" } else { "" };
        writeln!(f, "routine {constants} constants{inline}\n{program}end")
    }
}

impl fmt::Display for Loops {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "loops {}", list(&self.arrays))?;
        for Stored { entry, value } in &self.stored {
            writeln!(f, "store {entry} = {value}")?;
        }
        self.steps.iter().try_for_each(|step| step.fmt(f))?;
        write!(f, "end {}", list(&self.results))
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Call(Call { routine, reads, writes }) => {
                writeln!(f, "call {routine} ({}) -> {}", list(reads), list(writes))
            }
            Self::Loop(Loop { table, reversed, end, steps }) => {
                write!(f, "for {table}{}", if *reversed { " reversed" } else { "" })?;
                end.iter().try_for_each(|entry| write!(f, " until {entry}"))?;
                writeln!(f)?;
                steps.iter().try_for_each(|step| step.fmt(f))?;
                writeln!(f, "end")
            }
        }
    }
}

impl fmt::Display for Array {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self { rows, columns: 1 } => write!(f, "{rows}"),
            Self { rows, columns } => write!(f, "{rows}x{columns}"),
        }
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}[{}]", self.array, self.index)
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}", self.index)?;
        if let Some(Column { depth, column }) = self.row {
            write!(f, "+{depth}.{column}")?;
        }
        write!(f, "]")
    }
}

impl fmt::Display for Read {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Argument(place) => write!(f, "a{place}"),
            Self::Entry(array, place) => write!(f, "{array}{place}"),
        }
    }
}

impl fmt::Display for Write {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { array, place, adds } = self;
        write!(f, "{}{array}{place}", if *adds { "+" } else { "" })
    }
}

/// Returns the array and the place of a text such as `0[5+0.1]`.
fn array_and_place(text: &str) -> Option<(&str, Place)> {
    let (array, inside) = text.strip_suffix(']')?.split_once('[')?;
    let (index, row) = match inside.split_once('+') {
        None => (inside, None),
        Some((index, column)) => {
            let (depth, column) = column.split_once('.')?;
            let row = Column { depth: depth.parse().ok()?, column: column.parse().ok()? };
            (index, Some(row))
        }
    };
    Some((array, Place { index: index.parse().ok()?, row }))
}

/// Returns the array with this text, such as `12` or `3x4`.
fn array(text: &str) -> Option<Array> {
    let (rows, columns) = text.split_once('x').unwrap_or((text, "1"));
    let array = Array { rows: rows.parse().ok()?, columns: columns.parse().ok()? };
    // The sizes in texts of strangers are products of this range.
    (array.rows < 1 << 24 && array.columns < 1 << 24).then_some(array)
}

/// Returns the entry with this text.
fn entry(text: &str) -> Option<Entry> {
    let (array, Place { index, row: None }) = array_and_place(text)? else { return None };
    Some(Entry { array: array.parse().ok()?, index })
}

/// Returns the argument of a routine with this text.
fn read(text: &str) -> Option<Read> {
    let (array, place) = array_and_place(text)?;
    match array {
        "a" => Some(Read::Argument(place)),
        _ => Some(Read::Entry(array.parse().ok()?, place)),
    }
}

/// Returns the destination of a result with this text.
fn write(text: &str) -> Option<Write> {
    let sum = text.strip_prefix('+');
    let (array, place) = array_and_place(sum.unwrap_or(text))?;
    Some(Write { array: array.parse().ok()?, place, adds: sum.is_some() })
}

/// Returns the number with this text.
fn number<T: FromStr>(text: &str) -> Option<T> {
    text.parse().ok()
}

/// Returns the items of a list that commas separate; `None` if one is not as `item` expects.
fn parsed<T>(text: &str, item: fn(&str) -> Option<T>) -> Option<Vec<T>> {
    items(text).map(item).collect()
}

impl<'a> Parser<'a> {
    /// Reads the rows of a table, whose first line was read.
    pub(in crate::program) fn table(&mut self) -> Result<Table, ParseProgramError> {
        let mut rows = Vec::new();
        while let Some(text) = self.next_after("row ") {
            let parts = text.split_once(';').and_then(|(constants, places)| {
                Some(Row { constants: parsed(constants, number)?, places: parsed(places, number)? })
            });
            let row = parts.ok_or_else(|| {
                self.error(format!("{text:?} is no row of a table, as `0.5, 1.0; 3, 4` is"))
            })?;
            rows.push(row);
        }
        Ok(Table { rows })
    }

    /// Reads a routine after `routine` in its first line.
    pub(in crate::program) fn routine(&mut self, head: &str) -> Result<Routine, ParseProgramError> {
        let (count, never_inline) = match head.strip_suffix(", never inlined") {
            Some(count) => (count, true),
            None => (head, false),
        };
        let count = count.strip_suffix(" constants").and_then(|count| count.parse().ok());
        let constants = count
            .ok_or_else(|| self.error(format!("{head:?} is not a routine, as `2 constants` is")))?;
        let program = self.inner_program()?;
        if self.next()? != "end" {
            return Err(self.error("a routine ends with a line `end`"));
        }
        Ok(Routine { program, constants, never_inline })
    }

    /// Reads loops whose arrays have these lengths, in the first line.
    pub(in crate::program) fn loops(
        &mut self,
        program: &Program,
        lengths: &str,
    ) -> Result<Loops, ParseProgramError> {
        let lengths_read = parsed(lengths, array);
        let arrays = lengths_read
            .ok_or_else(|| self.error(format!("{lengths:?} are no lengths, as `12, 7` are")))?;
        let mut stored = Vec::new();
        while let Some(text) = self.next_after("store ") {
            let wrong = || self.error(format!("{text:?} stores no value, as `0[3] = x2` does"));
            let (place, value) = text.split_once(" = ").ok_or_else(wrong)?;
            let entry = entry(place).ok_or_else(wrong)?;
            stored.push(Stored { entry, value: self.operand(program, value, 1)? });
        }
        let (steps, results) = self.steps(0)?;
        let results = parsed(results, entry).ok_or_else(|| {
            self.error(format!("{results:?} are no entries, as `1[0], 1[1]` are"))
        })?;
        Ok(Loops { arrays, stored, steps, results })
    }

    /// Reads steps that `depth` loops surround, to the line `end`. Returns the rest of that line,
    /// too.
    fn steps(&mut self, depth: usize) -> Result<(Vec<Step>, &'a str), ParseProgramError> {
        let mut steps = Vec::new();
        loop {
            let line = self.next()?;
            if let Some(rest) = line.strip_prefix("end") {
                return Ok((steps, rest));
            }
            let step = if let Some(head) = line.strip_prefix("for ") {
                self.iterations(head, depth)?
            } else {
                let call = line.strip_prefix("call ").and_then(call);
                Step::Call(call.ok_or_else(|| {
                    self.error(format!(
                        "{line:?} is no step, as `call 0 (a[2], 0[3]) -> 0[5]`, `for 1` and `end` are"
                    ))
                })?)
            };
            steps.push(step);
        }
    }

    /// Reads a loop after `for` in its first line.
    fn iterations(&mut self, head: &str, depth: usize) -> Result<Step, ParseProgramError> {
        if depth == MAX_DEPTH {
            return Err(self.error("a loop is inside of too many others"));
        }
        let mut words = head.split(' ');
        let table = words.next().and_then(|table| table.parse().ok());
        let mut reversed = false;
        let mut end = None;
        let mut is_whole = table.is_some();
        while let Some(word) = words.next() {
            match word {
                "reversed" => reversed = true,
                "until" => end = words.next().and_then(entry),
                _ => is_whole = false,
            }
            is_whole &= word != "until" || end.is_some();
        }
        let table = table.filter(|_| is_whole).ok_or_else(|| {
            self.error(format!("{head:?} is no loop, as `0 reversed until 1[6]` is"))
        })?;
        let (steps, _) = self.steps(depth + 1)?;
        Ok(Step::Loop(Loop { table, reversed, end, steps }))
    }
}

/// Returns the call with this text, such as `0 (a[2], 0[3]) -> 0[5]`.
fn call(text: &str) -> Option<Call> {
    let (routine, rest) = text.split_once(" (")?;
    let (reads, writes) = rest.split_once(") ->")?;
    let routine = routine.parse().ok()?;
    Some(Call { routine, reads: parsed(reads, read)?, writes: parsed(writes, write)? })
}
