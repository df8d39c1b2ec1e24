//! The ground of springs and dampers.

use modyn::simulate::SpringGround;
use modyn::spatial::{Pose, Vector3};

use super::rotation;

/// The force of the soft ground, in a plane in general position.
#[test]
fn a_soft_ground_pushes_along_its_normal_and_against_sliding() {
    let (rows, _) = rotation([0.3, -0.7, 0.5], 1.1);
    let columns = [0, 1, 2].map(|k| Vector3(rows.map(|row| row[k])));
    let place = Vector3([0.2, 0.1, -0.4]);
    let plane = Pose { rotation: rows, translation: place.0 };
    let ground =
        SpringGround { plane, stiffness: 1000.0, damping: 10.0, friction: 0.5, slip: 0.01 };
    let at = |depth: f64| (place + columns[0].scale(0.3) - columns[2].scale(depth)).0;
    let close = |a: Vector3<f64>, b: Vector3<f64>| {
        let difference = a - b;
        assert!(difference.dot(difference) < 1e-18, "{a:?} instead of {b:?}");
    };
    close(ground.force(at(-0.1), columns[2].scale(-3.0)), Vector3([0.0; 3]));
    close(ground.force(at(0.01), columns[2].scale(-0.2)), columns[2].scale(10.0 + 2.0));
    close(ground.force(at(0.01), columns[2].scale(5.0)), Vector3([0.0; 3]));
    let sliding = ground.force(at(0.01), columns[1].scale(0.01));
    let drag = 0.5 * 10.0 * 0.5_f64.sqrt();
    close(sliding, columns[2].scale(10.0) - columns[1].scale(drag));
}
