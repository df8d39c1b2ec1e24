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

/// The derivatives of a step.
struct LinearStep {
    /// With respect to the state.
    a: Matrix<4, 4>,
    /// With respect to the torques.
    b: Matrix<4, 2>,
}

fn linearized_step(&[q0, q1, v0, v1]: &Vector<4>, tau: &Vector<2>) -> LinearStep {
    let step = Pendulum::step_semi_implicit_derivatives(&[q0, q1], &[v0, v1], tau, DT);
    // modyn's matrices are arrays of columns.
    LinearStep { a: transposed(&step.a), b: transposed(&step.b) }
}

/// How the torques of a step change: by `change`, and by `feedback` times the deviation of the state.
struct Correction {
    change: Vector<2>,
    feedback: Matrix<2, 4>,
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
    let mut corrections = Vec::new();
    for (x, tau) in states.iter().zip(&*torques).rev() {
        let LinearStep { a, b } = linearized_step(x, tau);
        let a_transposed = transposed(&a);
        let b_transposed = transposed(&b);
        let w_a = product(&w, &a);
        let mut grad_x = apply(&a_transposed, &v);
        let mut grad_u = apply(&b_transposed, &v);
        let mut hess_xx = product(&a_transposed, &w_a);
        let hess_ux = product(&b_transposed, &w_a);
        let mut hess_uu = product(&b_transposed, &product(&w, &b));
        for (i, e) in error(x).into_iter().enumerate() {
            grad_x[i] += RUNNING * e;
            hess_xx[i][i] += RUNNING;
        }
        for (i, tau) in tau.iter().enumerate() {
            grad_u[i] += EFFORT * tau;
            hess_uu[i][i] += EFFORT;
        }
        let [[p, q], [r, s]] = hess_uu;
        let determinant = p * s - q * r;
        let negative_inverse = [[-s, q], [r, -p]].map(|row| row.map(|x| x / determinant));
        let change = apply(&negative_inverse, &grad_u);
        let feedback = product(&negative_inverse, &hess_ux);
        let hess_xu = transposed(&hess_ux);
        let dv = apply(&hess_xu, &change);
        let dw = product(&hess_xu, &feedback);
        v = core::array::from_fn(|i| grad_x[i] + dv[i]);
        w = core::array::from_fn(|i| core::array::from_fn(|j| hess_xx[i][j] + dw[i][j]));
        corrections.push(Correction { change, feedback });
    }
    corrections.reverse();

    // The forward pass: the longest step that lowers the cost.
    for halvings in 0..12 {
        let length = 0.5_f64.powi(halvings);
        let mut x = *start;
        let mut tried = Vec::new();
        for (k, Correction { change, feedback }) in corrections.iter().enumerate() {
            let deviation: Vector<4> = core::array::from_fn(|i| x[i] - states[k][i]);
            let by_state = apply(feedback, &deviation);
            let tau = core::array::from_fn(|i| torques[k][i] + length * change[i] + by_state[i]);
            x = step(&x, &tau);
            tried.push(tau);
        }
        let after = cost(&roll_out(start, &tried), &tried);
        if after < before {
            *torques = tried;
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
