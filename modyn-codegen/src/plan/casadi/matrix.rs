//! Sparse matrices: the inputs and results of `CasADi`'s functions.

/// A matrix of an input or a result: its size, and the entries that are not zero by structure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CasadiMatrix {
    /// The name.
    pub name: String,
    /// The number of rows.
    pub rows: usize,
    /// The number of columns.
    pub columns: usize,
    /// For each column, the rows of its nonzeros, in order.
    pub nonzeros: Vec<Vec<usize>>,
}

impl CasadiMatrix {
    pub(super) fn dense(name: &str, rows: usize, columns: usize) -> Self {
        let nonzeros = vec![(0..rows).collect(); columns];
        Self { name: name.into(), rows, columns, nonzeros }
    }

    /// Returns a matrix of this size without nonzeros.
    pub(super) fn empty(&self, name: String) -> Self {
        let nonzeros = vec![Vec::new(); self.columns];
        Self { name, nonzeros, ..*self }
    }

    pub(super) fn renamed(&self, name: String) -> Self {
        Self { name, ..self.clone() }
    }

    /// Returns the number of entries, zeros included.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.rows * self.columns
    }

    /// Returns the number of nonzeros.
    #[must_use]
    pub fn len(&self) -> usize {
        self.nonzeros.iter().map(Vec::len).sum()
    }

    /// Returns whether there are no nonzeros.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns, for each nonzero, the index among all entries, by columns.
    pub(super) fn places(&self) -> impl Iterator<Item = usize> {
        let column = |(column, rows): (usize, &Vec<usize>)| {
            rows.iter().map(|row| column * self.rows + row).collect::<Vec<usize>>()
        };
        self.nonzeros.iter().enumerate().flat_map(column)
    }

    /// Returns the pattern in compressed columns, as `CasADi` reads it: the number of rows and of
    /// columns; then the number of nonzeros before each column and in all, and the row of each
    /// nonzero. For a matrix without zeros, 1 in place of these.
    #[must_use]
    pub fn compressed_columns(&self) -> Vec<usize> {
        let mut numbers = vec![self.rows, self.columns];
        if self.len() == self.entries() {
            return [numbers, vec![1]].concat();
        }
        let mut before = 0;
        numbers.push(before);
        for rows in &self.nonzeros {
            before += rows.len();
            numbers.push(before);
        }
        numbers.extend(self.nonzeros.iter().flatten());
        numbers
    }
}
