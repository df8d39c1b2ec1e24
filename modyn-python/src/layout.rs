//! Layouts of results as arrays: each array is a view with strides into the numbers that a function
//! writes.

use modyn_codegen::plan::{Elements, Record, Shape};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// The layout of a result.
#[derive(Clone, Debug)]
pub enum Layout {
    /// One array.
    Array(Leaf),
    /// A named tuple: its type, and its fields.
    Tuple(Class, Vec<(&'static str, Layout)>),
}

/// The type of a named tuple, by its name.
#[derive(Clone, Copy, Debug)]
pub enum Class {
    /// A type of the package.
    Package(&'static str),
    /// The type of a fused function's results, which the robot defines.
    Fused(&'static str),
}

impl Class {
    /// Returns the name.
    pub fn name(self) -> &'static str {
        let (Self::Package(name) | Self::Fused(name)) = self;
        name
    }

    /// Returns a named tuple of the type; each field has its name and its value.
    ///
    /// # Errors
    ///
    /// If the package lacks the type.
    pub fn of_fields<'py>(
        self,
        py: Python<'py>,
        fields: Vec<(&'static str, Bound<'py, PyAny>)>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (names, values): (Vec<_>, Vec<_>) = fields.into_iter().unzip();
        let class = match self {
            Self::Package(name) => py.import("modyn._results")?.getattr(name)?,
            Self::Fused(name) => {
                let of_names = (name, PyTuple::new(py, names)?);
                py.import("modyn._types")?.getattr("fused")?.call1(of_names)?
            }
        };
        class.call1(PyTuple::new(py, values)?)
    }
}

/// An array within the numbers of one state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Leaf {
    /// The index of the first number.
    pub offset: usize,
    /// The axes: the length of each and its stride in numbers.
    pub axes: Vec<(usize, usize)>,
}

impl Leaf {
    /// Returns the lengths of the axes, after the number of states of a batch.
    pub fn shape(&self, states: Option<usize>) -> Vec<usize> {
        states.into_iter().chain(self.axes.iter().map(|axis| axis.0)).collect()
    }

    /// Returns the strides of the axes in bytes. The first is the stride of the states of a batch
    /// with `length` numbers each.
    pub fn strides<S>(&self, states: Option<usize>, length: usize) -> Vec<usize> {
        let strides = states.map(|_| length).into_iter().chain(self.axes.iter().map(|axis| axis.1));
        strides.map(|stride| stride * size_of::<S>()).collect()
    }
}

/// Returns the layout of a function's or a fused function's result.
pub fn of_result(result: &Shape) -> Layout {
    layout(result, 0, &[])
}

/// Returns the lengths of the axes of an argument. Wrenches are rows, one for each link.
pub fn of_argument(shape: &Shape) -> Vec<usize> {
    match shape {
        Shape::Scalar => Vec::new(),
        Shape::Array(inner, n, _) if **inner == Shape::Scalar => vec![*n],
        Shape::Array(inner, n, _) => vec![*n, inner.len()],
        Shape::Record(..) => vec![shape.len()],
    }
}

/// Returns the layout of a shape at this offset. The outer axes are before its own.
fn layout(shape: &Shape, offset: usize, outer: &[(usize, usize)]) -> Layout {
    let leaf =
        |axes: &[(usize, usize)]| Layout::Array(Leaf { offset, axes: [outer, axes].concat() });
    let class = |record: &Record| match record {
        Record::Fused(name) => Some(Class::Fused(name)),
        record => record.result_type().map(Class::Package),
    };
    match shape {
        Shape::Scalar => leaf(&[]),
        Shape::Array(inner, n, _) if **inner == Shape::Scalar => leaf(&[(*n, 1)]),
        Shape::Array(inner, n, elements) if inner.is_vector() => {
            let vectors = (*n, inner.len());
            let components = (inner.len(), 1);
            match elements {
                Elements::Columns => leaf(&[components, vectors]),
                Elements::List | Elements::Rows => leaf(&[vectors, components]),
            }
        }
        Shape::Array(inner, n, _) => layout(inner, offset, &[outer, &[(*n, inner.len())]].concat()),
        Shape::Record(record, fields) => match class(record) {
            None => leaf(&[(shape.len(), 1)]),
            Some(class) => {
                let mut offset = offset;
                let fields = fields.iter().map(|(field, shape)| {
                    let layout = layout(shape, offset, outer);
                    offset += shape.len();
                    (*field, layout)
                });
                Layout::Tuple(class, fields.collect())
            }
        },
    }
}
