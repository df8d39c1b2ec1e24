// The larger of two numbers; the other one where one is NaN.
fn modyn_maximum(a: f32, b: f32) -> f32 {
    return select(b, a, a >= b || b != b);
}
