//! Robots of any size: thresholds are relative to lengths of the robot.

use modyn_runtime::Interpreter;
use modyn_runtime::equations::identification::BaseParameters;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    INERTIAL_PARAMETERS, Inertial, Joint, Limits, Link, Mimic, Model, MovingLink,
    PARAMETERS_PER_LINK,
};
use modyn_runtime::spatial::Pose;
use modyn_tests::changed::scaled;
use modyn_tests::dense::square;
use modyn_tests::naive::Naive;
use modyn_tests::quantities::Quantities;
use modyn_tests::random::{Random, general_tree, tree};
use nalgebra::DMatrix;

/// Returns the frame of each link.
fn frames(links: &[MovingLink]) -> Vec<Link> {
    let frame = |(i, link): (usize, &MovingLink)| Link {
        name: link.name.clone(),
        moving_link: Some(i),
        pose: Pose::identity(),
        inertial: link.inertial,
    };
    links.iter().enumerate().map(frame).collect()
}

/// Returns a chain of revolute joints. Each joint is on the z axis of its parent, and its axis is tilted out of it by an angle
/// between `tilt / 10` and `tilt`; the lengths of link i are multiplied by the entry i of `sizes`.
fn nearly_parallel(seed: u64, tilt: f64, sizes: &[f64]) -> Model {
    let mut random = Random::new(seed);
    let mut links: Vec<MovingLink> = Vec::new();
    for (i, &size) in sizes.iter().enumerate() {
        let before = if i == 0 { size } else { sizes[i - 1] };
        let [x, y] = [0, 1].map(|_| random.between(0.1, 1.0) * tilt);
        let length = (1.0 + x * x + y * y).sqrt();
        let translation = [0.0, 0.0, before * random.between(0.2, 0.4)];
        let origin = Pose { translation, ..Pose::identity() };
        let axis = [x / length, y / length, 1.0 / length];
        let Inertial { mass, center_of_mass, inertia } = random.inertial();
        let inertial = Inertial {
            mass,
            center_of_mass: center_of_mass.map(|x| size * x),
            inertia: inertia.map(|x| size * size * x),
        };
        let joint = Joint::new(format!("joint{i}"), JointType::Revolute, axis, origin);
        links.push(MovingLink {
            name: format!("link{i}"),
            parent: i.checked_sub(1),
            joint,
            inertial,
        });
    }
    let frames = frames(&links);
    Model::new("nearly_parallel", [0.0, 0.0, -9.81], links, frames).expect("sound parts")
}

/// Returns the largest error of the interpreter's mass matrix and of the places of its links: entry (i, j) relative to
/// sqrt(M_ii M_jj), a place relative to the longest one.
fn error(model: &Model, q: &[f64]) -> f64 {
    let naive = Naive::new(model, q);
    let expected = naive.mass_matrix();
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    let found = square(&interpreter.dense_mass_matrix(q));
    let scale = |i: usize| expected[(i, i)].sqrt();
    let entry = |i: usize, j: usize| (found[(i, j)] - expected[(i, j)]).abs() / scale(i) / scale(j);
    let n = model.nv();
    let entries = (0..n * n).map(|k| entry(k / n, k % n)).fold(0.0, f64::max);
    let mut poses = vec![Pose::identity(); model.links().len()];
    interpreter.link_poses(q, &mut poses).expect("fits");
    let places: Vec<_> = naive.poses().iter().map(|pose| pose.translation).collect();
    let longest = places.iter().flatten().fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()));
    let pairs = poses.iter().zip(&places).flat_map(|(a, b)| a.translation.into_iter().zip(*b));
    pairs.map(|(a, b)| (a - b).abs() / longest).fold(entries, f64::max)
}

#[test]
fn the_offsets_of_small_robots_are_kept() {
    for size in [1e-6, 1e-4, 1e-3, 1.0, 1e3] {
        for tilt in [1e-9, 1e-8, 1e-7, 1e-3] {
            for seed in 0..20 {
                let model = nearly_parallel(seed, tilt, &[size; 5]);
                let mut random = Random::new(seed);
                let q: Vec<f64> = (0..5).map(|_| random.between(-3.0, 3.0)).collect();
                let error = error(&model, &q);
                assert!(error < 1e-10, "size {size}, tilt {tilt}, seed {seed}: {error:e}");
            }
        }
    }
}

#[test]
fn the_offsets_of_a_small_hand_on_a_large_arm_are_kept() {
    for tilt in [1e-8, 1e-7] {
        for seed in 0..20 {
            let model = nearly_parallel(seed, tilt, &[1.0, 1.0, 1e-3, 1e-3, 1e-3]);
            let error = error(&model, &[0.3, -0.7, 1.9, -2.3, 0.8]);
            assert!(error < 1e-10, "tilt {tilt}, seed {seed}: {error:e}");
        }
    }
}

/// A power of two scales all numbers without a rounding error.
#[test]
fn scaled_robots_have_the_same_digits() {
    for seed in 0..40 {
        let model = if seed % 2 == 0 { tree(seed, 8) } else { general_tree(seed, 8) };
        let slides: Vec<bool> = model
            .moving_links()
            .iter()
            .map(|link| link.joint.joint_type == JointType::Prismatic)
            .collect();
        let mut random = Random::new(seed);
        let q: Vec<f64> = slides.iter().map(|_| random.between(-1.0, 1.0)).collect();
        let matrix = |scale: f64| {
            let lengths: Vec<f64> = slides.iter().map(|&is| if is { scale } else { 1.0 }).collect();
            let q: Vec<f64> = q.iter().zip(&lengths).map(|(q, length)| q * length).collect();
            let mut interpreter = Interpreter::<f64>::new(scaled(&model, scale));
            let matrix = square(&interpreter.dense_mass_matrix(&q));
            // M_ij has the dimension kg m^2, and kg m or kg for sliding joints.
            DMatrix::from_fn(q.len(), q.len(), |i, j| {
                matrix[(i, j)] * lengths[i] * lengths[j] / (scale * scale)
            })
        };
        let expected = matrix(1.0);
        for exponent in [-40, -20, -10, 10, 20] {
            assert_eq!(matrix(2.0_f64.powi(exponent)), expected, "seed {seed}, 2^{exponent}");
        }
    }
}

#[test]
fn base_parameters_of_scaled_robots_are_the_same() {
    // A mass, three first moments and six second moments: their dimension in lengths.
    let dimension = |parameter: usize| match INERTIAL_PARAMETERS[parameter % PARAMETERS_PER_LINK] {
        "m" => 0,
        name if name.starts_with('m') => 1,
        _ => 2,
    };
    for seed in 0..6 {
        let model = general_tree(seed, 4);
        let model =
            Model::new("still", [0.0; 3], model.moving_links().to_vec(), model.links().to_vec());
        let model = model.expect("sound parts");
        let expected = BaseParameters::new(&model);
        for scale in [1e-6, 1e-3, 1e3, 1e6] {
            let found = BaseParameters::new(&scaled(&model, scale));
            assert_eq!(found.regressor_columns(), expected.regressor_columns(), "{seed}, {scale}");
            for (found, expected) in found.parameters.iter().zip(&expected.parameters) {
                let indices =
                    |of: &[(usize, f64)]| of.iter().map(|part| part.0).collect::<Vec<_>>();
                let [indices, others] =
                    [&found.combination, &expected.combination].map(|all| indices(all));
                assert_eq!(indices, others, "{seed}, {scale}");
                for (&(index, found), &(_, one)) in
                    found.combination.iter().zip(&expected.combination)
                {
                    let power = dimension(expected.kept) - dimension(index);
                    let one = one * scale.powi(power);
                    assert!(
                        (found - one).abs() < 1e-6 * one.abs(),
                        "{seed}, {scale}: {found} {one}"
                    );
                }
            }
        }
    }
}

#[test]
fn ranges_of_small_mimic_joints_are_kept() {
    for scale in [1e-6, 1.0, 1e6] {
        let joint = |name: &str, upper: f64| {
            let limits = Limits {
                lower: Some(0.0),
                upper: Some(scale * upper),
                velocity: None,
                effort: None,
            };
            let joint = Joint::new(name, JointType::Prismatic, [0.0, 0.0, 1.0], Pose::identity());
            Joint { limits: Some(limits), ..joint }
        };
        let mimic = Mimic { leader: 0, multiplier: 1.0, offset: 0.0 };
        let joints =
            [joint("leader", 2e-3), Joint { mimic: Some(mimic), ..joint("follower", 0.5e-3) }];
        let links = joints.map(|joint| MovingLink {
            name: joint.name.clone(),
            parent: None,
            joint,
            inertial: Random::new(1).inertial(),
        });
        let frames = frames(&links);
        let model = Model::new("mimic", [0.0; 3], links.to_vec(), frames).expect("sound parts");
        assert_eq!(model.coordinate_range(0), [0.0, scale * 0.5e-3]);
    }
}
