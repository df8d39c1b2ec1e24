//! Layouts of results as arrays: each array is a view with strides into the numbers that a function writes.

use modyn_codegen::Function;
use modyn_codegen::plan::{Record, Shape, Sizes};

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
    /// A type of the robot's own: that of a bundle's results.
    Bundle(&'static str),
}

impl Class {
    /// Returns the name.
    pub fn name(self) -> &'static str {
        let (Self::Package(name) | Self::Bundle(name)) = self;
        name
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

    /// Returns the strides of the axes in bytes, after that of the states of a batch with `length` numbers each.
    pub fn strides<S>(&self, states: Option<usize>, length: usize) -> Vec<usize> {
        let strides = states.map(|_| length).into_iter().chain(self.axes.iter().map(|axis| axis.1));
        strides.map(|stride| stride * size_of::<S>()).collect()
    }
}

/// The number of degrees of freedom in layouts that tell its axes from others; no robot of these sizes exists.
const MARK: usize = 1_000_003;

/// Returns the layout of a function's result for a robot of these sizes.
pub fn of_function(function: Function, sizes: &Sizes) -> Layout {
    let row = function.row();
    let marked = (row.result)(&Sizes { nv: MARK, ..*sizes });
    Walk { is_pose: false }.layout(&(row.result)(sizes), &marked, 0, &[])
}

/// Returns the layout of a bundle's result, which has a field for each of its functions.
pub fn of_bundle(result: &Shape, sizes: &Sizes) -> Layout {
    let Shape::Record(Record::Own(name), fields) = result else {
        return Walk { is_pose: false }.layout(result, result, 0, &[]);
    };
    let mut offset = 0;
    let fields = fields.iter().map(|(field, shape)| {
        let row = member(field).row();
        let marked = (row.result)(&Sizes { nv: MARK, ..*sizes });
        let layout = Walk { is_pose: false }.layout(shape, &marked, offset, &[]);
        offset += shape.len();
        (*field, layout)
    });
    Layout::Tuple(Class::Bundle(name), fields.collect())
}

/// Returns the function of a bundle's field, whose name is that of the function, or of the function and a link.
fn member(field: &str) -> Function {
    let is_of = |function: &&Function| {
        let rest = field.strip_prefix(function.name());
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
    };
    let candidates = Function::ALL.iter().filter(is_of);
    *candidates.max_by_key(|function| function.name().len()).expect("a field has a function")
}

/// Returns the lengths of the axes of an argument. Wrenches are rows, one for each link.
pub fn of_argument(shape: &Shape) -> Vec<usize> {
    match shape {
        Shape::Scalar => Vec::new(),
        Shape::Array(inner, n) if **inner == Shape::Scalar => vec![*n],
        Shape::Array(inner, n) => vec![*n, inner.len()],
        Shape::Record(..) => vec![shape.len()],
    }
}

#[derive(Clone, Copy)]
struct Walk {
    /// Whether the shape is a part of a pose, whose rotation is by rows.
    is_pose: bool,
}

impl Walk {
    /// Returns the layout of a shape at this offset. The outer axes are before its own; `marked` is the shape of a robot
    /// with [`MARK`] degrees of freedom.
    fn layout(
        self,
        shape: &Shape,
        marked: &Shape,
        offset: usize,
        outer: &[(usize, usize)],
    ) -> Layout {
        let leaf =
            |axes: &[(usize, usize)]| Layout::Array(Leaf { offset, axes: [outer, axes].concat() });
        match (shape, marked) {
            (Shape::Scalar, _) => leaf(&[]),
            (Shape::Array(inner, n), _) if **inner == Shape::Scalar => leaf(&[(*n, 1)]),
            (Shape::Array(inner, n), Shape::Array(marked, count)) => match components(inner) {
                // Columns: vectors of a matrix, or spatial vectors for each degree of freedom.
                Some((k, spatial)) if !self.is_pose && (!spatial || *count == MARK) => {
                    leaf(&[(k, 1), (*n, k)])
                }
                Some((k, _)) => leaf(&[(*n, k), (k, 1)]),
                None => {
                    let outer = [outer, &[(*n, inner.len())]].concat();
                    self.layout(inner, marked, offset, &outer)
                }
            },
            (Shape::Record(Record::Spatial(name), _), _) if *name != "Pose" => {
                leaf(&[(shape.len(), 1)])
            }
            (Shape::Record(Record::Factorization | Record::Contacts, _), _) => {
                leaf(&[(shape.len(), 1)])
            }
            (Shape::Record(record, fields), Shape::Record(_, marked)) => {
                let (Record::Spatial(name)
                | Record::Plain(name)
                | Record::Several(name)
                | Record::Each(name)
                | Record::Own(name)) = record
                else {
                    return leaf(&[(shape.len(), 1)]);
                };
                let walk = Self { is_pose: *name == "Pose" };
                let mut offset = offset;
                let fields = fields.iter().zip(marked).map(|((field, shape), (_, marked))| {
                    let layout = walk.layout(shape, marked, offset, outer);
                    offset += shape.len();
                    (*field, layout)
                });
                Layout::Tuple(Class::Package(name), fields.collect())
            }
            _ => leaf(&[(shape.len(), 1)]),
        }
    }
}

/// Returns the number of components of a vector, and whether it is a spatial one; `None` for other shapes.
fn components(shape: &Shape) -> Option<(usize, bool)> {
    match shape {
        Shape::Array(inner, n) if **inner == Shape::Scalar => Some((*n, false)),
        Shape::Record(Record::Spatial(name), _) if *name != "Pose" => Some((shape.len(), true)),
        _ => None,
    }
}
