//! Rotations and directions as descriptions write them.

/// Numbers of this size and above are refused: products of them could overflow.
pub const MAX_NUMBER: f64 = 1e60;

/// `Rz(yaw) Ry(pitch) Rx(roll)`. Sines are libm's, so that every host has the same figures.
pub fn roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> [[f64; 3]; 3] {
    let (sr, cr) = libm::sincos(roll);
    let (sp, cp) = libm::sincos(pitch);
    let (sy, cy) = libm::sincos(yaw);
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}

/// A direction of unit length, and how long it was; `None` for zero.
pub fn normalized(axis: [f64; 3]) -> Option<([f64; 3], f64)> {
    // Scaled first, so that no square overflows or vanishes.
    let largest = axis.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
    if largest == 0.0 {
        return None;
    }
    let scaled = axis.map(|x| x / largest);
    let length = libm::sqrt(scaled.iter().map(|x| x * x).sum());
    Some((scaled.map(|x| x / length), largest * length))
}
