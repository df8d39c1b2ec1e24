//! iLQR plans the swing-up of a double pendulum, and model predictive control follows it after a push.

modyn::modyn! {
    Pendulum = "robots/double_pendulum.urdf",
    functions = [step_semi_implicit, step_semi_implicit_derivatives]
}

type Vector<const N: usize> = [f64; N];
/// A matrix by rows.
type Matrix<const R: usize, const C: usize> = [[f64; C]; R];

fn product<const R: usize, const K: usize, const C: usize>(
    a: &Matrix<R, K>,
    b: &Matrix<K, C>,
) -> Matrix<R, C> {
    core::array::from_fn(|i| core::array::from_fn(|j| (0..K).map(|k| a[i][k] * b[k][j]).sum()))
}

fn transposed<const R: usize, const C: usize>(a: &Matrix<R, C>) -> Matrix<C, R> {
    core::array::from_fn(|i| core::array::from_fn(|j| a[j][i]))
}

fn apply<const R: usize, const C: usize>(a: &Matrix<R, C>, x: &Vector<C>) -> Vector<R> {
    a.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
}

const DT: f64 = 0.02;
const STEPS: usize = 50;
/// Upright and at rest.
const GOAL: Vector<4> = [core::f64::consts::PI, 0.0, 0.0, 0.0];
// The weights of the cost: of the state's error in each step, of the torques, and of the last state's error.
const RUNNING: f64 = 0.01;
const EFFORT: f64 = 0.001;
const FINAL: f64 = 100.0;

/// The state x = (q, qd) after a step of semi-implicit Euler.
fn step(&[q0, q1, v0, v1]: &Vector<4>, tau: &Vector<2>) -> Vector<4> {
    let next = Pendulum::step_semi_implicit(&[q0, q1], &[v0, v1], tau, DT);
    [next.q[0], next.q[1], next.qd[0], next.qd[1]]
}

/// The derivatives A and B of the step.
fn linearized_step(&[q0, q1, v0, v1]: &Vector<4>, tau: &Vector<2>) -> (Matrix<4, 4>, Matrix<4, 2>) {
    let found = Pendulum::step_semi_implicit_derivatives(&[q0, q1], &[v0, v1], tau, DT);
    (transposed(&found.a), transposed(&found.b))
}

fn error(x: &Vector<4>) -> Vector<4> {
    core::array::from_fn(|i| x[i] - GOAL[i])
}

fn cost(states: &[Vector<4>], torques: &[Vector<2>]) -> f64 {
    let square = |x: &[f64]| -> f64 { x.iter().map(|x| x * x).sum() };
    let running: f64 = states[..STEPS].iter().map(|x| RUNNING * square(&error(x))).sum();
    let effort: f64 = torques.iter().map(|tau| EFFORT * square(tau)).sum();
    0.5 * (running + effort + FINAL * square(&error(&states[STEPS])))
}

fn roll_out(start: &Vector<4>, torques: &[Vector<2>]) -> Vec<Vector<4>> {
    let next = |x: &mut Vector<4>, tau: &Vector<2>| {
        *x = step(x, tau);
        Some(*x)
    };
    core::iter::once(*start).chain(torques.iter().scan(*start, next)).collect()
}

/// Improves the torques by one iteration of iLQR, and returns the cost.
fn improve(start: &Vector<4>, torques: &mut Vec<Vector<2>>) -> f64 {
    let states = roll_out(start, torques);
    let before = cost(&states, torques);

    // The backward pass: `v` and `w` are the gradient and the Hessian of the cost from here to the end.
    let mut v = error(&states[STEPS]).map(|e| FINAL * e);
    let mut w: Matrix<4, 4> =
        core::array::from_fn(|i| core::array::from_fn(|j| if i == j { FINAL } else { 0.0 }));
    let mut gains = Vec::new();
    for (x, tau) in states.iter().zip(&*torques).rev() {
        let (a, b) = linearized_step(x, tau);
        let (at, bt, wa) = (transposed(&a), transposed(&b), product(&w, &a));
        let (mut qx, mut qu) = (apply(&at, &v), apply(&bt, &v));
        let (mut qxx, mut quu) = (product(&at, &wa), product(&bt, &product(&w, &b)));
        let qux = product(&bt, &wa);
        for (i, e) in error(x).into_iter().enumerate() {
            qx[i] += RUNNING * e;
            qxx[i][i] += RUNNING;
        }
        for (i, tau) in tau.iter().enumerate() {
            qu[i] += EFFORT * tau;
            quu[i][i] += EFFORT;
        }
        let determinant = quu[0][0] * quu[1][1] - quu[0][1] * quu[1][0];
        let inverse = [[quu[1][1], -quu[0][1]], [-quu[1][0], quu[0][0]]];
        let negative_inverse = inverse.map(|row| row.map(|x| -x / determinant));
        let change = apply(&negative_inverse, &qu);
        let feedback = product(&negative_inverse, &qux);
        let xu = transposed(&qux);
        let (dv, dw) = (apply(&xu, &change), product(&xu, &feedback));
        v = core::array::from_fn(|i| qx[i] + dv[i]);
        w = core::array::from_fn(|i| core::array::from_fn(|j| qxx[i][j] + dw[i][j]));
        gains.push((change, feedback));
    }
    gains.reverse();

    // The forward pass: the longest step that lowers the cost.
    for halvings in 0..12 {
        let length = 0.5_f64.powi(halvings);
        let (mut x, mut found) = (*start, Vec::new());
        for (k, (change, feedback)) in gains.iter().enumerate() {
            let off: Vector<4> = core::array::from_fn(|i| x[i] - states[k][i]);
            let correction = apply(feedback, &off);
            let tau = core::array::from_fn(|i| torques[k][i] + length * change[i] + correction[i]);
            x = step(&x, &tau);
            found.push(tau);
        }
        let after = cost(&roll_out(start, &found), &found);
        if after < before {
            *torques = found;
            return after;
        }
    }
    before
}

fn main() {
    // A plan for the swing-up, from hanging at rest.
    let hanging = [0.0; 4];
    let mut torques = vec![[0.0; 2]; STEPS];
    for _ in 0..10 {
        improve(&hanging, &mut torques);
    }
    let planned = roll_out(&hanging, &torques);
    assert!(error(&planned[STEPS]).iter().all(|e| e.abs() < 0.05), "{:?}", planned[STEPS]);

    // Model predictive control: one iteration after each step, and a push on the way.
    let mut x = hanging;
    for k in 0..150 {
        x = step(&x, &torques[0]);
        if k == 20 {
            x[2] += 0.5; // rad/s
        }
        torques.rotate_left(1);
        torques[STEPS - 1] = [0.0; 2];
        improve(&x, &mut torques);
    }
    assert!(error(&x).iter().all(|e| e.abs() < 0.05), "{x:?}");
}
