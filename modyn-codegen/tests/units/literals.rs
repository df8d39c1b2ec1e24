//! Constants as literals.

use modyn_codegen::FloatType;
use modyn_codegen::internals::literal;

#[test]
fn constants_are_literals_of_their_type() {
    assert_eq!(literal(0.1, FloatType::F64), "0.1");
    assert_eq!(literal(0.1, FloatType::F32), "0.1");
    assert_eq!(literal(-1e50, FloatType::F64), "-1e50");
    assert_eq!(literal(-1e50, FloatType::F32), "f32::from_bits(4286578688)");
    assert_eq!(literal(f64::INFINITY, FloatType::F64), "f64::from_bits(9218868437227405312)");
}
