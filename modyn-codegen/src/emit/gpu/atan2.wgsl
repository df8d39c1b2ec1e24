// The angle from the x axis to (x, y); conventions for zeros and infinities as in IEEE 754.
fn modyn_atan2(y: f32, x: f32) -> f32 {
    let width = abs(x);
    let height = abs(y);
    let steep = height > width;
    let small = select(height, width, steep);
    let large = select(width, height, steep);
    var t = small / large;
    if (bitcast<u32>(small) == 0x7f800000u) {
        t = 1.0f;
    } else if (large == 0.0f) {
        t = 0.0f;
    }
    let beyond = t > 0.2679492f;
    let u = select(t, (t * 1.7320508f - 1.0f) / (t + 1.7320508f), beyond);
    let z = u * u;
    let rest = u * z * $ARCTANGENT$;
    var angle = u + rest;
    if (beyond) {
        angle = 0.5235988f + (u + (rest - 1.457046305830545e-08f));
    }
    if (steep) {
        angle = 1.5707964f - (angle + 4.371138828673793e-08f);
    }
    if ((bitcast<u32>(x) >> 31u) != 0u) {
        angle = 3.1415927f - (angle + 8.742277657347586e-08f);
    }
    return select(angle, -angle, (bitcast<u32>(y) >> 31u) != 0u);
}
