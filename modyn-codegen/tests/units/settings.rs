//! The layout of settings of constraints.

use modyn_codegen::internals::settings;
use modyn_codegen::plan::{Shape, Sizes};
use modyn_runtime::{ConstraintSettings, ContactTarget};

/// The runtime reads settings from numbers in the order of the layout.
#[test]
fn settings_have_the_order_of_the_runtime() {
    let sizes = Sizes { contacts: 2, ..Sizes::default() };
    let Shape::Record(_, mut settings) = settings(&sizes) else { panic!() };
    let Some(("contacts", Shape::Array(target, 2, _))) = settings.pop() else { panic!() };
    let Shape::Record(_, target) = *target else { panic!() };

    let numbers = core::array::from_fn(|k| 2.0 + k as f64);
    let own = ConstraintSettings::from_numbers(numbers, ());
    assert_eq!(own.numbers(), numbers);
    let value = |name| match name {
        "alpha" => own.alpha,
        "beta" => own.beta,
        "tolerance" => own.tolerance,
        "rounding" => own.rounding,
        _ => panic!("{name}"),
    };
    assert!(settings.iter().map(|(name, _)| value(name)).eq(numbers));
    assert!(settings.iter().all(|(_, shape)| *shape == Shape::Scalar));

    let numbers = core::array::from_fn(|k| 7.0 + k as f64);
    let own = ContactTarget::from_numbers(numbers);
    assert_eq!(own.numbers(), numbers);
    let values = |(name, shape): &(&str, Shape)| {
        let scalar = |value| (Shape::Scalar, vec![value]);
        let (expected, values) = match *name {
            "pose" => {
                let rotation = own.pose.rotation.as_flattened();
                (Shape::pose(), [rotation, &own.pose.translation].concat())
            }
            "velocity" => (Shape::twist(), own.velocity.components().to_vec()),
            "tangential" => scalar(own.tangential),
            "alpha" => scalar(own.alpha),
            "beta" => scalar(own.beta),
            "compliance" => scalar(own.compliance),
            "restitution" => scalar(own.restitution),
            "weight" => scalar(own.weight),
            _ => panic!("{name}"),
        };
        assert_eq!(*shape, expected, "{name}");
        values
    };
    assert!(target.iter().flat_map(values).eq(numbers));
}
