//! Times a Hessian of the robot whose text `run` has written, ns for each state. A feature selects the function.

#![allow(unused)] // Each build has one function, or none.

#[cfg(any(
    feature = "forward_dynamics_hessian",
    feature = "inverse_dynamics_hessian",
    feature = "step_semi_implicit_hessian"
))]
mod measured {
    use std::array::from_fn;
    use std::hint::black_box;
    use std::time::{Duration, Instant};

    include!(env!("ROBOT"));

    const N: usize = Bench::NV;
    const NQ: usize = Bench::NQ;
    /// A multiple of all numbers of lanes; columns do not begin at multiples of 4,096 bytes.
    const STATES: usize = 72;

    /// Numbers of at most this magnitude, the same on every machine: a linear congruential generator.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }

        fn states<const M: usize>(&mut self) -> Vec<[f64; M]> {
            (0..STATES).map(|_| from_fn(|_| self.next())).collect()
        }
    }

    /// Scales the quaternions of a state to length 1.
    fn normalized(mut q: [f64; NQ]) -> [f64; NQ] {
        for (_, first) in Bench::QUATERNIONS {
            let length = q[first..first + 4].iter().map(|x| x * x).sum::<f64>().sqrt();
            q[first..first + 4].iter_mut().for_each(|x| *x /= length);
        }
        q
    }

    /// Returns a column for each number of a state.
    fn columns<const M: usize>(states: &[[f64; M]]) -> [Vec<f64>; M] {
        from_fn(|j| states.iter().map(|state| state[j]).collect())
    }

    /// Prints the minimal time of many calls, ns for each state.
    fn time(mut all_states: impl FnMut()) {
        let (start, mut best) = (Instant::now(), Duration::MAX);
        while start.elapsed() < Duration::from_millis(1500) {
            let call = Instant::now();
            all_states();
            best = best.min(call.elapsed());
        }
        println!("ns {:.1}", best.as_nanos() as f64 / STATES as f64);
    }

    macro_rules! dynamics {
        ($one:ident, $batch:ident, $operations:ident) => {
            #[cfg(not(feature = "batch"))]
            pub fn run() {
                let mut numbers = Numbers(1);
                let q: Vec<[f64; NQ]> = numbers.states().into_iter().map(normalized).collect();
                let [qd, x, c]: [Vec<[f64; N]>; 3] = from_fn(|_| numbers.states());
                time(|| {
                    for i in 0..STATES {
                        black_box(Bench::$one(&q[i], &qd[i], &x[i], &c[i]));
                    }
                });
                println!("operations {}", Bench::$operations.total());
            }

            #[cfg(feature = "batch")]
            pub fn run() {
                let mut numbers = Numbers(1);
                let q: Vec<[f64; NQ]> = numbers.states().into_iter().map(normalized).collect();
                let q = columns(&q);
                let given: [[Vec<f64>; N]; 3] = from_fn(|_| columns(&numbers.states()));
                let slices = given.each_ref().map(|columns| columns.each_ref().map(|c| &c[..]));
                let q = q.each_ref().map(|column| &column[..]);
                let mut vectors: [[Vec<f64>; N]; 4] = from_fn(|_| from_fn(|_| vec![0.0; STATES]));
                let mut matrices: [[[Vec<f64>; N]; N]; 4] =
                    from_fn(|_| from_fn(|_| from_fn(|_| vec![0.0; STATES])));
                time(|| {
                    let [a, b, c, d] =
                        vectors.each_mut().map(|vector| vector.each_mut().map(|x| &mut x[..]));
                    let [e, f, g, h] = matrices.each_mut().map(|matrix| {
                        matrix.each_mut().map(|vector| vector.each_mut().map(|x| &mut x[..]))
                    });
                    let [qd, x, cotangent] = slices;
                    Bench::$batch(q, qd, x, cotangent, a, b, c, d, e, f, g, h).expect("sizes");
                });
            }
        };
    }

    #[cfg(feature = "forward_dynamics_hessian")]
    dynamics!(
        forward_dynamics_hessian,
        forward_dynamics_hessian_batch,
        FORWARD_DYNAMICS_HESSIAN_OPERATIONS
    );
    #[cfg(feature = "inverse_dynamics_hessian")]
    dynamics!(
        inverse_dynamics_hessian,
        inverse_dynamics_hessian_batch,
        INVERSE_DYNAMICS_HESSIAN_OPERATIONS
    );

    #[cfg(feature = "step_semi_implicit_hessian")]
    pub fn run() {
        let mut numbers = Numbers(1);
        let q: Vec<[f64; NQ]> = numbers.states().into_iter().map(normalized).collect();
        let [qd, tau]: [Vec<[f64; N]>; 2] = from_fn(|_| numbers.states());
        let cotangent: Vec<[f64; 2 * N]> = numbers.states();
        time(|| {
            for i in 0..STATES {
                black_box(Bench::step_semi_implicit_hessian(
                    &q[i],
                    &qd[i],
                    &tau[i],
                    0.01,
                    &cotangent[i],
                ));
            }
        });
        println!("operations {}", Bench::STEP_SEMI_IMPLICIT_HESSIAN_OPERATIONS.total());
    }
}

fn main() {
    #[cfg(any(
        feature = "forward_dynamics_hessian",
        feature = "inverse_dynamics_hessian",
        feature = "step_semi_implicit_hessian"
    ))]
    measured::run();
}
