//! Functions that are printed twice, on scalars and on vectors; the scalar type chooses.

use std::fmt::Write as _;

use super::Robot;
use super::function::{function, vector_types};
use super::parameter::{Parameter, unpacked};
use super::quantity::Quantity;
use crate::names::helper_type;
use crate::program::Program;

impl Robot<'_> {
    /// Prints a private function that lets its scalar type choose between the program on `vectors`
    /// and that on `scalars`.
    pub(super) fn dispatched(
        &self,
        text: &mut String,
        quantity: &Quantity<'_>,
        parameters: &[Parameter],
        scalars: &Program,
        vectors: &Program,
    ) {
        let name = quantity.name;
        let shape = &quantity.shape;
        let scalar = format!("{name}_scalar");
        let vectorized = format!("{name}_vectorized");
        *text += &function(&scalar, parameters, shape, scalars, self.options.scalar);
        *text += &function(&vectorized, parameters, shape, vectors, self.options.scalar);
        let types = vector_types(vectors);
        let kind = format!("{}SimdTask", helper_type(name));
        let fields: Vec<String> =
            parameters.iter().map(|p| p.typed("T").replace('&', "&'a ")).collect();
        let typed: Vec<String> = parameters.iter().map(|p| p.typed("T")).collect();
        let names: Vec<&str> = parameters.iter().map(|p| p.name).collect();
        let self_fields: Vec<String> = names.iter().map(|name| format!("self.{name}")).collect();
        let unpacked: Vec<String> =
            parameters.iter().map(|p| format!("    {}\n", unpacked(p))).collect();
        let ones: Vec<String> = parameters.iter().map(ones).collect();
        let returned = shape.type_of("T");
        let names = names.join(", ");
        let _ = writeln!(
            text,
            "struct {kind}<'a, T> {{ {} }}\n\
             impl<T: __modyn::Scalar> __modyn::batch::SimdTask<T> for {kind}<'_, T> {{\n\
             type Output = {returned};\n\
             const HAS_PACKS: bool = {};\n\
             #[inline(always)]\n\
             fn vectorized<V: __modyn::batch::SimdBackend<Number = T>>(self) -> {returned} {{\n    \
             let Self {{ {names} }} = self;\n{}    \
             {vectorized}::<{}V>({})\n}}\n\
             #[inline]\nfn scalar(self) -> {returned} {{\n    {scalar}({})\n}}\n}}\n\
             fn {name}<T: __modyn::Scalar>({}) -> {returned} {{\n    \
             T::run_simd({kind} {{ {names} }})\n}}\n",
            fields.join(", "),
            types > 1,
            unpacked.concat(),
            "_, ".repeat(types),
            ones.join(", "),
            self_fields.join(", "),
            typed.join(", "),
        );
    }
}

/// Returns a parameter converted to vector lanes of one.
fn ones(parameter: &Parameter) -> String {
    let shape = &parameter.shape;
    let one = |i| format!("V::one({})", parameter.entry(i));
    format!("&{}", shape.value(&(0..shape.len()).map(one).collect::<Vec<_>>()))
}
