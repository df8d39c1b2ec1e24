//! The vector types of functions for [`Execution::Simd`], and lists of values by their types.

use super::Printer;
use crate::program::{Execution, Value};

/// A vector type of `V` with this number of lanes.
pub(super) struct VectorType {
    pub(super) lanes: u8,
    /// The name as a type parameter of functions, which compiles faster than a projection.
    pub(super) name: &'static str,
    /// The name of the associated type of `V`.
    pub(super) of: &'static str,
    /// The trait that the type implements.
    pub(super) bound: &'static str,
}

/// The vector types of `V`.
pub(super) const VECTORS: [VectorType; 4] = [
    VectorType { lanes: 1, name: "A", of: "One", bound: "Scalar" },
    VectorType { lanes: 2, name: "B", of: "Two", bound: "batch::Pack<A, 2>" },
    VectorType { lanes: 4, name: "C", of: "Four", bound: "batch::Pack<A, 4>" },
    VectorType { lanes: 8, name: "D", of: "Eight", bound: "batch::Pack<A, 8>" },
];

impl Printer<'_> {
    /// Returns values grouped by their lanes, as in [`VECTORS`].
    pub(super) fn by_width(&self, values: &[Value]) -> [Vec<Value>; VECTORS.len()] {
        VECTORS.each_ref().map(|kind| {
            let of_kind =
                |value: &&Value| self.program.statements[value.statement].lanes == kind.lanes;
            values.iter().filter(of_kind).copied().collect()
        })
    }

    /// Returns the values that a chunk returns, as an expression.
    pub(super) fn list(&self, values: &[Value]) -> String {
        let lists = self.by_width(values).map(|values| {
            let names: Vec<String> = values.iter().map(|&value| self.name(value)).collect();
            format!("[{}]", names.join(", "))
        });
        match self.program.execution {
            Execution::Simd => format!("({})", lists.join(", ")),
            _ => lists[0].clone(),
        }
    }

    /// Returns the type of the values that a chunk returns.
    pub(super) fn types(&self, values: &[Value]) -> String {
        if self.program.execution != Execution::Simd {
            return format!("[T; {}]", values.len());
        }
        let groups = self.by_width(values);
        let types = VECTORS.iter().zip(&groups).map(|(kind, values)| {
            // An empty array has no values of a type that the function does not mention.
            let kind = if values.is_empty() { "A" } else { kind.name };
            format!("[{kind}; {}]", values.len())
        });
        format!("({})", types.collect::<Vec<_>>().join(", "))
    }

    /// Returns the type for this number of lanes.
    pub(super) fn kind(&self, lanes: u8) -> &'static str {
        let vector = VECTORS.iter().find(|kind| kind.lanes == lanes);
        match (self.program.execution, vector) {
            (Execution::Simd, Some(vector)) => vector.name,
            _ => "T",
        }
    }

    /// Returns the vector types that the function mentions, scalars included.
    pub(super) fn vectors(&self) -> impl Iterator<Item = &'static VectorType> {
        let widths = self.program.widths();
        VECTORS.iter().filter(move |kind| widths.contains(&kind.lanes))
    }

    /// Returns the type parameters of these types, with bounds.
    pub(super) fn vector_bounds(&self) -> String {
        let bounded = self.vectors().map(|kind| format!("{}: __modyn::{}", kind.name, kind.bound));
        bounded.collect::<Vec<_>>().join(", ")
    }

    /// Returns the type parameters of these types and of their instruction set `V`, with bounds.
    pub(super) fn backend_bounds(&self) -> String {
        let bounds = self.vectors().map(|kind| format!("{} = {}", kind.of, kind.name));
        let list = bounds.collect::<Vec<_>>().join(", ");
        format!("{}, V: __modyn::batch::SimdBackend<{list}>", self.vector_bounds())
    }

    /// Returns the names of these types.
    pub(super) fn vector_names(&self) -> String {
        self.vectors().map(|kind| kind.name).collect::<Vec<_>>().join(", ")
    }
}
