//! Results do not depend on the order of constraints, also where some rows are small after others: rows that are held or dropped by
//! themselves may be needed, or not, with the rows of later constraints.

use modyn_codegen::program::{Operand, RowEquations, Source};
use modyn_runtime::equations::constraints::RowSystem;

use super::*;

/// Returns the numbers 0 to `count` - 1 in a random order.
fn shuffled(random: &mut Random, count: usize) -> Vec<usize> {
    let keys = random.vector(count, 1.0);
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| keys[a].total_cmp(&keys[b]));
    order
}

/// Constraints of three rows each on a few joints whose mass matrix is the identity.
struct Rows {
    /// For each constraint its three rows.
    blocks: Vec<DMatrix<f64>>,
    /// Accelerations that meet all rows.
    accelerations: DVector<f64>,
}

impl Rows {
    /// Returns rows that are random combinations of earlier rows of their constraint, up to a part of random size; constraints
    /// have random scales.
    fn random(random: &mut Random) -> Self {
        let joints = 4 + (random.0 >> 40) as usize % 4;
        let mut block = |_| {
            let mut rows = DMatrix::zeros(3, joints);
            for i in 0..3 {
                let part = if i == 0 { 1.0 } else { 10.0_f64.powf(4.0 * (random.next() - 1.0)) };
                let own = DVector::from(random.vector(joints, part));
                let before = random.vector(i, 1.0);
                let mut row = own.transpose();
                before.iter().enumerate().for_each(|(k, x)| row += rows.row(k) * *x);
                rows.set_row(i, &row);
            }
            rows * 10.0_f64.powf(2.0 * random.next())
        };
        let blocks = (0..4).map(&mut block).collect();
        Self { blocks, accelerations: DVector::from(random.vector(joints, 1.0)) }
    }

    /// Returns the rows of all constraints in this order, each constraint's multiplied by `factor`.
    fn jacobian(&self, order: &[usize], factor: impl Fn(&DMatrix<f64>) -> f64) -> DMatrix<f64> {
        let joints = self.accelerations.len();
        DMatrix::from_fn(3 * order.len(), joints, |i, j| {
            let block = &self.blocks[order[i / 3]];
            factor(block) * block[(i % 3, j)]
        })
    }

    /// Returns the accelerations of least squares by singular values; `None` if some of these are neither large nor rounding errors.
    fn expected(&self) -> Option<(DVector<f64>, usize)> {
        let order: Vec<usize> = (0..self.blocks.len()).collect();
        let svd = self.jacobian(&order, |block| 1.0 / block.norm()).svd(false, true);
        let is_kept = |value: f64| value > 1e-2;
        if svd.singular_values.iter().any(|&value| !is_kept(value) && value > 1e-8) {
            return None;
        }
        let along = svd.v_t.expect("asked for");
        let mut sum = DVector::zeros(self.accelerations.len());
        for (row, &value) in along.row_iter().zip(&svd.singular_values) {
            if is_kept(value) {
                sum += row.transpose() * (row * &self.accelerations)[0];
            }
        }
        Some((sum, svd.singular_values.iter().filter(|&&value| is_kept(value)).count()))
    }

    /// Returns the equations of the constraints in this order, and their rows.
    fn system(&self, order: &[usize]) -> (RowSystem<f64>, DMatrix<f64>) {
        let jacobian = self.jacobian(order, |_| 1.0);
        let matrix = &jacobian * jacobian.transpose();
        let count = jacobian.nrows();
        let triangle = (0..count).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let system = RowSystem {
            blocks: vec![3; order.len()],
            matrix: triangle.map(|(i, j)| matrix[(i, j)]).collect(),
            sides: (&jacobian * &self.accelerations).as_slice().to_vec(),
            scales: order.iter().map(|&k| self.blocks[k].norm_squared()).collect(),
            tolerances: [1e-10, 1e-10],
        };
        (system, jacobian)
    }
}

/// Returns the program of the equations of four constraints.
fn program() -> Program {
    let operand = Operand { source: Source::Argument(0), negated: false, lanes: 1 };
    let (rows, constraints) = (12, 4);
    let numbers = rows * (rows + 1) / 2 + rows + constraints + 2;
    let operands = vec![operand; numbers + 1];
    RowEquations { blocks: vec![3; constraints], sides: 1, operands }.program()
}

#[test]
fn equations_of_rows_in_random_orders_are_as_singular_values_say() {
    let (mut random, mut compared, mut dependent) = (Random(71), 0, 0);
    let program = program();
    for _ in 0..4000 {
        let rows = Rows::random(&mut random);
        let expected = rows.expected();
        let mut first: Option<(DVector<f64>, f64)> = None;
        for _ in 0..4 {
            let order = shuffled(&mut random, rows.blocks.len());
            let (system, jacobian) = rows.system(&order);
            let RowSystem { matrix, sides, scales, tolerances, .. } = &system;
            let numbers = [&matrix[..], sides, scales, tolerances].concat();
            for found in [system.solve(), program.evaluate(&numbers)] {
                let count = jacobian.nrows();
                let multipliers = DVector::from_column_slice(&found[..count]);
                let rank = found[2 * count];
                let accelerations = jacobian.transpose() * multipliers;
                let (same, same_rank) = first.get_or_insert((accelerations.clone(), rank));
                assert_eq!(rank, *same_rank, "{order:?}");
                let off = (&accelerations - &*same).norm();
                assert!(off < 1e-4, "{order:?}: {off:e}");
                if let Some((expected, expected_rank)) = &expected {
                    let off = (accelerations - expected).norm();
                    assert!(
                        off < 1e-5 && (rank - *expected_rank as f64).abs() < 0.5,
                        "{order:?}: {off:e}, {rank}, {expected_rank}"
                    );
                    compared += 1;
                    dependent += usize::from(rank < count as f64);
                }
            }
        }
    }
    assert!(compared > 1000 && dependent > 1000, "{compared} {dependent}");
}

/// Returns the model with its loops and its contacts in these orders.
fn reordered(model: &Model, loops: &[usize], contacts: &[usize]) -> Model {
    let loops = loops.iter().map(|&k| model.loop_constraints()[k].clone()).collect();
    let contacts = contacts.iter().map(|&k| model.contacts()[k].clone()).collect();
    model
        .clone()
        .with_loop_constraints(loops)
        .and_then(|model| model.with_contacts(contacts))
        .expect("good")
}

/// Returns the solutions of the interpreter, of the program for rows of any rank, and of the program of independent rows where there
/// is one.
fn solutions(model: &Model, state: &State, active: &[bool], settings: &Settings) -> Vec<Solution> {
    let mechanism = Mechanism::new(model);
    let layout = UduLayout::new(&mechanism, &ModuleTree::chains(model));
    let tracer = Tracer::new(&mechanism);
    let numbers =
        [&*state.q, &state.qd, &state.tau, &switches(active), &numbers(settings)].concat();
    let any_rank = optimize(tracer.constrained_forward_dynamics(&layout)).evaluate(&numbers);
    let loops = DenseLoops { rows: Some(numbers.len()), products: false };
    let around = tracer.with_loops(loops).constrained_forward_dynamics(&layout);
    let around = around.dense.rows.is_some().then(|| {
        let program = Program::try_new(&around, numbers.len(), Execution::Scalar);
        program.expect("valid").evaluate(&numbers)
    });
    let (nv, count) = (model.nv(), model.constraints());
    let of_program = [Some(any_rank), around].into_iter().flatten().map(|found| Solution {
        qdd: found[..nv].into(),
        wrenches: found[nv..][..6 * count]
            .chunks(6)
            .map(|w| std::array::from_fn(|k| w[k]))
            .collect(),
        rank: found[found.len() - 1],
    });
    [interpreted(model, state, active, settings)].into_iter().chain(of_program).collect()
}

/// A leg whose light shank is stretched; its foot and its knee are held. With both, the leg is locked.
#[test]
fn a_leg_whose_foot_and_knee_are_held_is_locked() {
    let link = |name: &str, mass: f64, moment: f64, center: f64| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0 0 {center}'/><mass value='{mass}'/>
             <inertia ixx='{moment}' iyy='{moment}' izz='{moment}' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let text = format!(
        "<robot name='leg'><link name='base'/>{}{}
         <joint name='hip' type='continuous'><parent link='base'/><child link='thigh'/>
         <origin rpy='0.3 0.2 0.1'/><axis xyz='0 1 0'/></joint>
         <joint name='knee' type='continuous'><parent link='thigh'/><child link='shank'/>
         <origin xyz='0 0 -0.5'/><axis xyz='0 1 0'/></joint></robot>",
        link("thigh", 1.0, 0.1, -0.4),
        link("shank", 0.0008, 4e-5, -0.3)
    );
    let held = |name, link, z| contact(name, ContactKind::Point, link, [[0.0, 0.0, z], [0.0; 3]]);
    let contacts = vec![held("foot", "shank", -0.6), held("knee", "thigh", -0.5)];
    let model = model_of(&text, Base::Fixed, contacts);
    for order in [[0, 1], [1, 0]] {
        let model = reordered(&model, &[], &order);
        for bend in [0.0, 1e-5, 1e-4, 1e-3, 1.5e-3, 3e-3, 0.1] {
            let state = State { q: vec![0.4, bend], qd: vec![0.0; 2], tau: vec![1.0, -2.0] };
            for found in solutions(&model, &state, &[true; 2], &exact(&model)) {
                assert_eq!(found.rank, 2.0);
                // Free accelerations are 5 and 5e4 rad/s^2.
                let [hip, knee] = found.qdd[..] else { panic!("two joints") };
                assert!(
                    hip.abs() < 1e-9 && knee.abs() < 1e-5,
                    "{order:?}, {bend}: {hip:e}, {knee:e}"
                );
            }
        }
    }
}

/// The exact accelerations of a random robot at rest with some of its contacts active, from dense equations in 80 bits.
struct Exact<'a> {
    active: &'a [bool],
    rank: f64,
    qdd: &'a [f64],
}

/// Compares a robot with exact accelerations, relative to `weights`, with its constraints in all orders.
fn assert_exact(model: &Model, state: &State, weights: &[f64], exacts: &[Exact<'_>], free: f64) {
    let [loops, contacts] = [model.loop_constraints().len(), model.contacts().len()];
    let mut random = Random(5);
    for reversed in [false, true] {
        let mut order: Vec<usize> = (0..loops).collect();
        if reversed {
            order.reverse();
        }
        let places = shuffled(&mut random, contacts);
        let model = reordered(model, &order, &places);
        for Exact { active, rank, qdd } in exacts {
            let active: Vec<bool> = places.iter().map(|&k| active[k]).collect();
            for found in solutions(&model, state, &active, &exact(&model)) {
                assert_eq!(found.rank, *rank, "loops {order:?}, contacts {active:?}");
                for ((found, exact), weight) in found.qdd.iter().zip(*qdd).zip(weights) {
                    let off = ((found - exact) / weight).abs() / free;
                    assert!(off < 1e-8, "loops {order:?}, contacts {active:?}: {off:e}");
                }
            }
        }
    }
}

fn described(text: &str, gravity: [f64; 3]) -> Model {
    let options = ReadOptions { gravity: Some(gravity), ..ReadOptions::default() };
    read(text, "robot.urdf", &options).unwrap_or_else(|errors| panic!("{errors}")).model
}

#[test]
fn a_random_robot_with_a_sliding_loop_is_exact_in_all_orders() {
    let gravity = [2.171539777901324, 4.814979984170315, 5.149546931483888];
    let model = described(include_str!("seed5339.urdf"), gravity);
    let state = State {
        q: vec![
            0.854749672173627,
            0.03985258310209037,
            0.0,
            0.03031543112769353,
            0.06259330745321667,
            1.624508497021477,
            2.5068583438792,
        ],
        qd: vec![0.0; 7],
        tau: vec![
            0.9855646104592204,
            21.171568507028564,
            0.005866580259996231,
            -1.9376402464235434,
            -5.635109698365529,
            -0.2355939031397414,
            -0.015061340331983074,
        ],
    };
    let weights = [
        4.151172449482974,
        1.0162723365227548,
        28.911495295031674,
        2.031422314918226,
        2.1048336630472626,
        48.69121170179558,
        81.02075940778639,
    ];
    let exacts = [
        Exact { active: &[true], rank: 7.0, qdd: &[0.0; 7] },
        Exact {
            active: &[false],
            rank: 5.0,
            qdd: &[122.70898071182334, 13.050618268851018, 0.0, 0.0, 0.0, 0.0, 0.0],
        },
    ];
    assert_exact(&model, &state, &weights, &exacts, 244.0);
}

#[test]
fn a_random_robot_with_contacts_and_loops_is_exact_in_all_orders() {
    let model = described(include_str!("seed124.urdf"), [0.0, 0.0, -9.81]);
    let state = State {
        q: vec![
            0.0,
            0.0,
            -0.21724574452451653,
            -0.4118368567101766,
            0.8878841461674191,
            0.14520675224841456,
            -0.14480036443704916,
            0.7974454180616256,
            0.1841085717042357,
            0.5940901555978944,
            0.06529994889370966,
            0.7803184205958328,
            -6.431579263073763,
            -9.268521762979628,
            1.700242898264829,
        ],
        qd: vec![0.0; 13],
        tau: vec![
            -1794.464192221684,
            -2293.8317155685213,
            85.4599526032749,
            -209.6842131875816,
            697.070765749354,
            149.46173435184724,
            2554.2027280137645,
            23021.69880264109,
            7105.203892033998,
            -5021.795305643014,
            29.567437511681366,
            10.0561274958649,
            -19.307388028055925,
        ],
    };
    let weights = [
        0.030503886298844676,
        0.04909076436079831,
        0.6459687824237872,
        0.16427363964638608,
        0.125104540780083,
        0.13869719481490472,
        0.043566327543900586,
        0.005616054102033205,
        0.00724246413275264,
        0.005092871160257263,
        2.5480258266630442,
        2.5480258266630447,
        6.547115698908067,
    ];
    let swing = [-18.648736417123207, 15.22386560829759, 12.36108436140777];
    let [a, b, c] = swing;
    let locked = [0.0, 0.0, 0.0, a, b, c, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let hand = [-2.2871055975676158, 6.567932812506552, -0.38103893658670795];
    let [d, e, f] = hand;
    let swinging = [0.0, 0.0, 0.0, a, b, c, 0.0, 0.0, 0.0, 0.0, d, e, f];
    let exacts = [
        Exact { active: &[true; 3], rank: 10.0, qdd: &locked },
        Exact { active: &[false, false, true], rank: 9.0, qdd: &swinging },
    ];
    assert_exact(&model, &state, &weights, &exacts, 1113.0);
}

/// Feet of a quadruped on its belly, with knees that are bent by any angle, in random orders: in each order the rank and the
/// accelerations are the same.
#[test]
fn contacts_of_nearly_stretched_legs_in_random_orders() {
    let (model, mut random) = (stretched::lying_quadruped(), Random(73));
    let count = model.contacts().len();
    for _ in 0..40 {
        let bends = [0; 4].map(|_| 10.0_f64.powf(3.5 * (random.next() - 1.0)));
        let state = stretched::with_knees(&model, bends, &mut random);
        let expected = interpreted(&model, &state, &vec![true; count], &exact(&model));
        let free = interpreted(&model, &state, &vec![false; count], &exact(&model));
        let scale = free.qdd.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for _ in 0..4 {
            let model = reordered(&model, &[], &shuffled(&mut random, count));
            let found = interpreted(&model, &state, &vec![true; count], &exact(&model));
            assert_eq!(found.rank, expected.rank, "{bends:?}");
            for (a, b) in found.qdd.iter().zip(&expected.qdd) {
                assert!((a - b).abs() < 1e-6 * scale, "{bends:?}: {a} {b}");
            }
        }
    }
}
