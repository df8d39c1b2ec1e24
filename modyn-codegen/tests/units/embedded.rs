//! The runtime within self-contained files.

use modyn_codegen::internals::in_any_edition;

#[test]
fn core_is_found_through_the_module_and_strings_stay() {
    let text = "/// ::core::x\nf::<::core::x>(\"::core::\\\"::core::\\\\\", ::core::y);\n";
    let expected = "/// ::core::x\nf::<self::runtime::__core::x>(\"::core::\\\"::core::\\\\\", self::runtime::__core::y);\n";
    assert_eq!(in_any_edition(text), expected);
}
