//! Joint forces over time, from a table.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_runtime::model::Model;

use crate::command::numbers::number;
use crate::command::outcome::Failure;
use crate::escape::cell;

/// Joint forces at ascending times; an empty table is zero.
pub struct Torques {
    times: Vec<f64>,
    /// For each time, a joint force for each velocity.
    rows: Vec<Vec<f64>>,
}

impl Torques {
    /// Returns joint forces that are always zero.
    pub fn none() -> Self {
        Self { times: Vec::new(), rows: Vec::new() }
    }

    /// Reads a file of rows with a time and a joint force for each velocity. A header may name the
    /// velocities in any order; forces of velocities that it does not name are zero.
    pub fn read(path: &Path, model: &Model) -> Result<Self, Failure> {
        let name = sanitize_for_display(&path.display().to_string());
        let bad = |line: u64, message: String| {
            Failure::usage(format!("error: {name}:{line}: {}", sanitize_for_display(&message)))
        };
        let opened = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .comment(Some(b'#'))
            .from_path(path);
        let mut reader = opened
            .map_err(|error| Failure::usage(format!("error: `{name}` cannot be read: {error}")))?;
        let names = model.velocity_names();
        let mut columns: Vec<usize> = (0..names.len()).collect();
        let mut torques = Self::none();
        for (i, record) in reader.records().enumerate() {
            let record = record.map_err(|error| bad(i as u64 + 1, error.to_string()))?;
            let line = record.position().map_or(i as u64 + 1, csv::Position::line);
            if i == 0 && record.get(0).is_some_and(|first| first.parse::<f64>().is_err()) {
                columns = columns_by_name(&record, &names).map_err(|message| bad(line, message))?;
                continue;
            }
            if record.len() != columns.len() + 1 {
                let cells = record.len();
                let count = columns.len();
                let expected =
                    format!("expected a time and {count} torques, there are {cells} cells");
                return Err(bad(line, expected));
            }
            let parsed: Result<Vec<f64>, String> = record.iter().map(number).collect();
            let numbers = parsed.map_err(|message| bad(line, message))?;
            if torques.times.last().is_some_and(|&last| numbers[0] <= last) {
                return Err(bad(line, "times must ascend".into()));
            }
            torques.times.push(numbers[0]);
            let mut row = vec![0.0; names.len()];
            columns.iter().zip(&numbers[1..]).for_each(|(&column, &x)| row[column] = x);
            torques.rows.push(row);
        }
        if torques.times.is_empty() {
            return Err(bad(1, "there is no row of numbers".into()));
        }
        Ok(torques)
    }

    /// Computes the joint forces at a time: linear between rows, constant before the first and
    /// after the last row.
    pub fn at(&self, time: f64, tau: &mut [f64]) {
        let next = self.times.partition_point(|&t| t <= time);
        let Some((below, above)) = self.place(next.saturating_sub(1)).zip(self.place(next)) else {
            return tau.fill(0.0);
        };
        let span = self.times[above] - self.times[below];
        let part =
            if span > 0.0 { ((time - self.times[below]) / span).clamp(0.0, 1.0) } else { 0.0 };
        for (k, tau) in tau.iter_mut().enumerate() {
            let a = self.rows[below][k];
            let b = self.rows[above][k];
            *tau = a + (b - a) * part;
        }
    }

    /// Returns the row's index, or the last row's.
    fn place(&self, row: usize) -> Option<usize> {
        self.times.len().checked_sub(1).map(|last| row.min(last))
    }
}

/// Returns the velocity of each column.
fn columns_by_name(head: &StringRecord, names: &[String]) -> Result<Vec<usize>, String> {
    let mut columns = Vec::new();
    for heading in head.iter().skip(1) {
        // Tables of `modyn simulate` have the unit after the name.
        let without_unit = heading
            .strip_suffix(" (N m)")
            .or_else(|| heading.strip_suffix(" (N)"))
            .unwrap_or(heading);
        let bare = without_unit.strip_prefix("tau ").unwrap_or(without_unit);
        let column = names.iter().position(|name| name == bare || cell(name) == bare);
        match column {
            Some(column) if columns.contains(&column) => {
                return Err(format!("`{heading}` is there twice"));
            }
            Some(column) => columns.push(column),
            None => {
                return Err(format!("`{heading}` is no velocity; there are: {}", names.join(", ")));
            }
        }
    }
    Ok(columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torques_are_linear_between_rows_and_held_outside() {
        let torques =
            Torques { times: vec![0.0, 1.0, 3.0], rows: vec![vec![0.0], vec![2.0], vec![4.0]] };
        let at = |time| {
            let mut tau = [f64::NAN];
            torques.at(time, &mut tau);
            tau[0]
        };
        let places = [-1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 9.0].map(at);
        let expected = [0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0];
        assert!(places.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{places:?}");
        let mut tau = [f64::NAN];
        Torques::none().at(1.0, &mut tau);
        assert_eq!(tau, [0.0]);
    }
}
