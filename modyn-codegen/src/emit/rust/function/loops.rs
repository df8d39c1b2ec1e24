//! Loops over tables: the functions of routines, the tables, and the statements that run them.
//!
//! Entries at places that a table gives are found with `get`: an index from a table can be out of
//! bounds as far as rustc knows, and a test that panics would remain in the code.

use std::fmt::Write as _;

use super::{Printer, function, literal, vector_types};
use crate::emit::rust::parameter::Parameter;
use crate::emit::rust::shape::Shape;
use crate::program::{
    Array, Call, Column, Entry, Execution, Loop, Loops, Place, Read, Routine, Step, Table,
    argument_of,
};

/// A row of an array, or consecutive numbers of an argument, at a place of a table.
struct Window {
    /// The name of the array or argument.
    array: String,
    row: Column,
    /// The number of consecutive numbers; `None` for a row.
    length: Option<usize>,
}

/// The windows of a call.
#[derive(Default)]
struct Windows(Vec<Window>);

impl Windows {
    /// Returns the index of the window with entry `index` of a row that has this length.
    fn with(&mut self, array: String, row: Column, index: usize, columns: usize) -> usize {
        let is_same = |window: &Window| window.array == array && window.row == row;
        let k = self.0.iter().position(is_same).unwrap_or_else(|| {
            let length = (columns == 1).then_some(0);
            self.0.push(Window { array, row, length });
            self.0.len() - 1
        });
        if let Some(length) = &mut self.0[k].length {
            *length = (*length).max(index + 1);
        }
        k
    }
}

impl Printer<'_> {
    /// Prints the function of a routine.
    pub(super) fn routine(&self, text: &mut String, number: usize, routine: &Routine) {
        let Routine { program, constants, never_inline } = routine;
        if *never_inline {
            *text += "#[inline(never)]\n";
        }
        let shape = Shape::vector(*constants);
        let table = Parameter::constants("table", shape, self.float.name());
        let read = Parameter::new("read", Shape::vector(program.arguments - constants));
        let parameters: Vec<Parameter> =
            (*constants > 0).then_some(table).into_iter().chain([read]).collect();
        let result = Shape::vector(program.results.len());
        *text += &function(&self.routine_name(number), &parameters, &result, program, self.float);
    }

    /// Prints a table.
    pub(super) fn table(&self, text: &mut String, number: usize, table: &Table) {
        if table.is_empty() {
            return;
        }
        let name = self.table_name(number);
        let float = self.float.name();
        let constants = table.constants();
        let places = table.places();
        let rows = table.rows.len();
        let index = index_type(table);
        let _ = writeln!(
            text,
            "static {name}: [([{float}; {constants}], [{index}; {places}]); {rows}] = ["
        );
        for row in &table.rows {
            let constants: Vec<String> =
                row.constants.iter().map(|&x| literal(x, self.float)).collect();
            let _ = writeln!(text, "    ([{}], {:?}),", constants.join(", "), row.places);
        }
        *text += "];\n\n";
    }

    /// Returns an expression whose value is the results of loops, as an array.
    pub(super) fn loops(&self, loops: &Loops) -> String {
        let mut text = String::from("{\n");
        let arrays = loops.arrays.iter().enumerate().filter(|(_, array)| !array.is_empty());
        for (array, Array { rows, columns }) in arrays {
            let row = if *columns == 1 { "k(0.0)".into() } else { format!("[k(0.0); {columns}]") };
            let _ = writeln!(text, "    let mut array{array} = [{row}; {rows}];");
        }
        for stored in &loops.stored {
            let entry = entry(loops, &stored.entry);
            let value = self.operand(&stored.value);
            let _ = writeln!(text, "    {entry} = {value};");
        }
        self.steps(&mut text, loops, &loops.steps, 0);
        let results: Vec<String> =
            loops.results.iter().map(|result| entry(loops, result)).collect();
        // An array that is the result as a whole.
        let whole = loops.results.first().map(|first| first.array).filter(|&array| {
            let entries = (0..loops.arrays[array].len()).map(|index| Entry { array, index });
            loops.arrays[array].columns == 1 && loops.results.iter().copied().eq(entries)
        });
        match whole {
            Some(array) => text + &format!("    array{array}\n}}"),
            None => text + &format!("    [{}]\n}}", results.join(", ")),
        }
    }

    /// Prints steps that `depth` loops surround.
    fn steps(&self, text: &mut String, loops: &Loops, steps: &[Step], depth: usize) {
        for step in steps {
            match step {
                Step::Call(call) => self.call(text, loops, call, depth),
                Step::Loop(inner) => self.iterations(text, loops, inner, depth),
            }
        }
    }

    fn iterations(&self, text: &mut String, loops: &Loops, inner: &Loop, depth: usize) {
        let name = self.table_name(inner.table);
        let order = if inner.reversed { ".rev()" } else { "" };
        let table = &self.program.tables[inner.table];
        let _ = match table.is_empty() {
            true => writeln!(text, "    for _ in 0..{} {{", table.rows.len()),
            false => writeln!(
                text,
                "    for (constants{depth}, places{depth}) in {name}.iter(){order} {{"
            ),
        };
        if let Some(end) = &inner.end {
            let kind = self.kind(1);
            let _ = writeln!(
                text,
                "    if {kind}::is_known_nonnegative({}) {{ break }}",
                entry(loops, end)
            );
        }
        if table.places() > 0 {
            let names: Vec<String> =
                (0..table.places()).map(|column| place_name(Column { depth, column })).collect();
            let convert = match index_type(table) {
                "u16" => "usize::from",
                _ => "|place| place as usize",
            };
            let names = names.join(", ");
            let _ = writeln!(text, "    let [{names}] = places{depth}.map({convert});");
        }
        self.steps(text, loops, &inner.steps, depth + 1);
        *text += "    }\n";
    }

    /// Prints the statements of a call: its numbers are read, the routine is called, and the
    /// results are stored.
    fn call(&self, text: &mut String, loops: &Loops, call: &Call, depth: usize) {
        let mut windows = Windows::default();
        let reads: Vec<String> =
            call.reads.iter().map(|read| self.read(loops, read, &mut windows)).collect();
        if !windows.0.is_empty() {
            let names: Vec<String> =
                (0..windows.0.len()).map(|k| format!("Some(window{k})")).collect();
            let values: Vec<String> =
                windows.0.iter().map(|window| self.found(window, "")).collect();
            let names = names.join(", ");
            let values = values.join(", ");
            let _ = writeln!(text, "    let ({names},) = ({values},) else {{ break }};");
        }
        let has_constants = self.program.routines[call.routine].constants > 0;
        let constants =
            if has_constants { format!("constants{}, ", depth - 1) } else { String::new() };
        let routine = self.routine_name(call.routine);
        let reads = reads.join(", ");
        let program = &self.program.routines[call.routine].program;
        let types = match program.execution {
            Execution::Simd => format!("::<{}V>", "_, ".repeat(vector_types(program))),
            _ => String::new(),
        };
        let _ = writeln!(text, "    let results = {routine}{types}({constants}&[{reads}]);");
        let mut windows = Windows::default();
        let mut stores: Vec<String> = Vec::new();
        for (i, write) in call.writes.iter().enumerate() {
            let Place { index, row } = write.place;
            let columns = loops.arrays[write.array].columns;
            let (to, within) = match row {
                Some(row) => {
                    let array = format!("array{}", write.array);
                    (format!("to[{index}]"), Some(windows.with(array, row, index, columns)))
                }
                None => (entry(loops, &Entry { array: write.array, index }), None),
            };
            let sum = if write.adds { format!("{to} + ") } else { String::new() };
            let result = match program.execution {
                Execution::Simd => format!("V::one(results[{i}])"),
                _ => format!("results[{i}]"),
            };
            let store = format!("{to} = {sum}{result};");
            match within {
                None => *text += &format!("    {store}\n"),
                Some(k) => {
                    stores.resize(windows.0.len(), String::new());
                    stores[k] += &format!("        {store}\n");
                }
            }
        }
        for (window, stores) in windows.0.iter().zip(stores) {
            let element_found = self.found(window, "_mut");
            let _ = writeln!(text, "    if let Some(to) = {element_found} {{\n{stores}    }}");
        }
    }

    /// Returns the text of a number that a call reads.
    fn read(&self, loops: &Loops, read: &Read, windows: &mut Windows) -> String {
        let (k, index) = match *read {
            Read::Argument(Place { index, row: None }) => return self.argument(index),
            Read::Entry(array, Place { index, row: None }) => {
                return entry(loops, &Entry { array, index });
            }
            Read::Argument(Place { index, row: Some(row) }) => {
                let lengths = self.parameters.iter().map(|parameter| parameter.shape.len());
                let (parameter, i) = argument_of(index, lengths).expect("an argument");
                let name = self.parameters[parameter].name.to_string();
                (windows.with(name, row, i, 1), i)
            }
            Read::Entry(array, Place { index, row: Some(row) }) => {
                let columns = loops.arrays[array].columns;
                (windows.with(format!("array{array}"), row, index, columns), index)
            }
        };
        format!("window{k}[{index}]")
    }

    /// Returns the text that finds a window; `kind` ends the names of the functions for that.
    fn found(&self, window: &Window, kind: &str) -> String {
        let Window { array, row, length } = window;
        let start = place_name(*row);
        let t = self.kind(1);
        match length {
            None => format!("{array}.get{kind}({start})"),
            Some(length) => format!(
                "{array}.get{kind}({start}..).and_then(<[{t}]>::first_chunk{kind}::<{length}>)"
            ),
        }
    }

    fn routine_name(&self, number: usize) -> String {
        format!("{}_routine{number}", self.name)
    }

    fn table_name(&self, number: usize) -> String {
        format!("{}_TABLE_{number}", self.name.to_uppercase())
    }
}

/// Returns the text of an entry of an array.
fn entry(loops: &Loops, entry: &Entry) -> String {
    let Entry { array, index } = *entry;
    match loops.arrays[array].columns {
        1 => format!("array{array}[{index}]"),
        columns => format!("array{array}[{}][{}]", index / columns, index % columns),
    }
}

/// Returns the name of the place that a column gives in an iteration.
fn place_name(column: Column) -> String {
    format!("place{}_{}", column.depth, column.column)
}

/// Returns the type of the places of a table.
fn index_type(table: &Table) -> &'static str {
    if table.last_place() <= usize::from(u16::MAX) { "u16" } else { "u32" }
}
