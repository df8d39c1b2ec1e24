//! The implementation of the trait `Robot`.

use std::fmt::Write as _;

use modyn_runtime::ShapeCenter;
use modyn_runtime::model::{PARAMETERS_PER_LINK, TouchingShape};

use super::Robot;
use super::quantity::Quantity;

impl Robot<'_> {
    /// Prints the implementation of `Robot`.
    pub(super) fn robot_trait(&self, text: &mut String, quantities: &[Quantity<'_>]) {
        let name = self.name;
        let nq = self.model.nq();
        let nv = self.model.nv();
        let links = self.model.links().len();
        let constraints = self.model.constraints();
        let contacts = self.model.contacts().len();
        let contacts_type = self.contacts_type();
        let sizes = &self.plan.sizes;
        let names = |count: usize, name: &str| match count {
            0 => String::new(),
            _ => format!("const {name}: &'static [&'static str] = &Self::{name};\n"),
        };
        let constraint_names = names(self.model.loop_constraints().len(), "LOOP_CONSTRAINT_NAMES")
            + &names(contacts, "CONTACT_NAMES")
            + &names(sizes.touching_shapes, "TOUCHING_SHAPE_NAMES")
            + &names(sizes.controls, "CONTROL_NAMES")
            + &names(sizes.activations, "ACTIVATION_NAMES");
        let shapes = self.model.touching_shapes();
        let center = |TouchingShape { end, .. }: &TouchingShape| {
            let center = ShapeCenter { link: end.link, place: end.pose.translation };
            format!("__modyn::{center:?}, ")
        };
        let centers = match shapes.iter().map(center).collect::<String>() {
            texts if texts.is_empty() => String::new(),
            texts => format!(
                "const TOUCHING_SHAPE_CENTERS: &'static [__modyn::ShapeCenter] = &[{texts}];\n"
            ),
        };
        let params =
            if self.plan.parameters.is_empty() { "()".into() } else { format!("{name}Params<T>") };
        let brge = if self.factorizes() {
            format!("{name}UduFactorization<T>")
        } else {
            format!("__modyn::NotGenerated<[T; {nv}], [[T; {nv}]; {nv}]>")
        };
        let _ = writeln!(
            text,
            "impl __modyn::Robot for {name} {{\n\
             const NAME: &'static str = Self::NAME;\n\
             const NQ: usize = {nq};\n\
             const NV: usize = {nv};\n\
             const JOINT_NAMES: &'static [&'static str] = &Self::JOINT_NAMES;\n\
             const LINK_NAMES: &'static [&'static str] = &Self::LINK_NAMES;\n\
             const COORDINATE_NAMES: &'static [&'static str] = &Self::COORDINATE_NAMES;\n\
             const VELOCITY_NAMES: &'static [&'static str] = &Self::VELOCITY_NAMES;\n\
             {constraint_names}\
             {centers}\
             const QUATERNIONS: &'static [(&'static str, usize)] = &Self::QUATERNIONS;\n\
             const LIMITS: __modyn::JointLimits<'static> = Self::LIMITS;\n\
             const MODULES: &'static [__modyn::KinematicModule] = &Self::MODULES;\n\
             type Params<T: __modyn::Scalar> = {params};\n\
             type Link = {name}Link;\n\
             type Q<T: __modyn::Scalar> = [T; {nq}];\n\
             type V<T: __modyn::Scalar> = [T; {nv}];\n\
             type M<T: __modyn::Scalar> = [[T; {nv}]; {nv}];\n\
             type PerVelocity<X: ::core::marker::Copy> = [X; {nv}];\n\
             type PerState<X: ::core::marker::Copy> = [X; {state}];\n\
             type PerLink<X: ::core::marker::Copy> = [X; {links}];\n\
             type PerQuaternion<X: ::core::marker::Copy> = [X; {quaternions}];\n\
             type Contacts = {contacts_type};\n\
             type PerContact<X: ::core::marker::Copy> = [X; {contacts}];\n\
             type PerTouchingShape<X: ::core::marker::Copy> = [X; {shapes}];\n\
             type PerTouchingPoint<X: ::core::marker::Copy> = [X; {points}];\n\
             type PerControl<X: ::core::marker::Copy> = [X; {controls}];\n\
             type PerActivation<X: ::core::marker::Copy> = [X; {activations}];\n\
             type PerActuatedState<X: ::core::marker::Copy> = [X; {states}];\n\
             type PerConstraint<X: ::core::marker::Copy> = [X; {constraints}];\n\
             type PerConstraintRow<X: ::core::marker::Copy> = [X; {rows}];\n\
             type Regressor<T: __modyn::Scalar> = [[T; {nv}]; {columns}];\n\
             type UduFactorization<T: __modyn::Scalar> = {brge};\n\
             fn neutral<T: __modyn::Scalar>() -> [T; {nq}] {{\n    Self::NEUTRAL.map(|x| \
             T::from_f64(::core::convert::Into::into(x)))\n}}",
            state = 2 * nv,
            quaternions = sizes.quaternions,
            shapes = sizes.touching_shapes,
            points = sizes.touching_points,
            controls = sizes.controls,
            activations = sizes.activations,
            states = 2 * sizes.nv + sizes.activations,
            rows = self.model.constraint_rows(),
            columns = PARAMETERS_PER_LINK * self.model.moving_links().len(),
        );
        // The trait, which all robots share, has no fused functions.
        for quantity in quantities.iter().filter(|quantity| quantity.function.is_some()) {
            let with = if quantity.dynamic { "_with" } else { "" };
            let first = quantity.dynamic.then(|| "params: &Self::Params<T>".into());
            let _ = writeln!(
                text,
                "fn {}{with}<T: __modyn::Scalar>({}) -> {} {{\n    {}\n}}",
                quantity.name,
                self.typed(quantity, first, "T"),
                quantity.shape.type_of("T"),
                self.call(quantity, "&params.numbers"),
            );
        }
        text.push_str("}\n\n");
    }
}
