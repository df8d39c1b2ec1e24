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
    let beyond = t > $TAN_15$;
    let u = select(t, (t * $ROOT_3$ - 1.0f) / (t + $ROOT_3$), beyond);
    let z = u * u;
    let rest = u * z * $ARCTANGENT$;
    var angle = u + rest;
    if (beyond) {
        angle = $SIXTH_PI$ + (u + (rest + ($SIXTH_REST$)));
    }
    if (steep) {
        angle = $HALF_PI$ - (angle - ($HALF_REST$));
    }
    if ((bitcast<u32>(x) >> 31u) != 0u) {
        angle = $PI$ - (angle - ($PI_REST$));
    }
    return select(angle, -angle, (bitcast<u32>(y) >> 31u) != 0u);
}
