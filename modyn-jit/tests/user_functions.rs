//! Functions of users as machine code give the numbers of the same functions on numbers, and derivatives along displacements.

use modyn_codegen::{
    Builder, Function, FusedFunction, Interpreter, Scalar, UserArgument, UserDerivatives,
    UserError, UserFunction,
};
use modyn_jit::{Compiled, InstructionSet, Options};
use modyn_tests::random;

/// The kinetic energy and the distance of the last link to a target.
struct Terms;

impl UserFunction<3> for Terms {
    fn docs(&self) -> String {
        "Returns the kinetic energy and the distance to `target`.".into()
    }

    fn arguments(&self) -> [UserArgument; 3] {
        [UserArgument::Q, UserArgument::QD, UserArgument::numbers("target", 3)]
    }

    fn derivatives(&self) -> UserDerivatives {
        UserDerivatives::First
    }

    fn evaluate<S: Scalar>(
        &self,
        robot: &mut Interpreter<S>,
        [q, qd, target]: [&[S]; 3],
    ) -> Result<Vec<S>, UserError> {
        let pose = robot.link_pose(q, robot.model().links().len() - 1)?;
        let squares = pose.translation.iter().zip(target).map(|(&x, &t)| (x - t) * (x - t));
        let distance = squares.fold(S::zero(), |sum, square| sum + square).sqrt();
        Ok(vec![robot.kinetic_energy(q, qd)?, distance])
    }
}

#[test]
fn machine_code_gives_the_numbers_of_the_function() {
    for seed in 0..4 {
        let model = random::general_zoo(seed, 4);
        let n = model.nv();
        let stage =
            FusedFunction::new("stage").own_function("terms_jacobian").own_function("terms");
        let stage = stage.function(Function::ForwardDynamics);
        let planning = Builder::new().model(model.clone()).functions([Function::ForwardDynamics]);
        let planning = planning.fused([stage]).function("terms", Terms).plan().expect("good");
        let random::State { q, qd, tau, .. } = random::state(seed, &model);
        let target = [0.3, -0.4, 0.5];
        let mut robot = Interpreter::<f64>::new(model);
        let mut random = random::Random::new(seed);
        let mut numbers = || (0..n).map(|_| random.between(-1.0, 1.0)).collect::<Vec<f64>>();
        let dq = numbers();
        let dqd = numbers();
        let mut at = |step: f64| {
            let along = |x: &[f64]| x.iter().map(|x| step * x).collect::<Vec<f64>>();
            let mut moved = q.clone();
            robot.integrate(&q, &along(&dq), &mut moved).expect("fits");
            let faster: Vec<f64> = qd.iter().zip(along(&dqd)).map(|(x, dx)| x + dx).collect();
            Terms.evaluate(&mut robot, [&moved, &faster, &target]).expect("good")
        };
        let value = at(0.0);
        let h = 1e-3;
        let [a, b, c, d] = [h, -h, 2.0 * h, -2.0 * h].map(&mut at);
        // Of fourth order.
        let change: Vec<f64> =
            (0..2).map(|i| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h)).collect();
        for instruction_set in InstructionSet::available() {
            let mut options = Options::default();
            (options.instruction_set, options.batches) = (Some(instruction_set), true);
            let compiled = Compiled::<f64>::from_plan(&planning, options).expect("code");
            let names = ["stage", "terms", "terms_jvp", "terms_vjp", "terms_jacobian"];
            assert!(compiled.fused_names().eq(names));
            let call = compiled.fused("terms").expect("compiled");
            let mut found = vec![f64::NAN; 2];
            call.one(&[&q, &qd, &target], &mut found).expect("fits");
            let close = |found: &[f64], expected: &[f64], tolerance: f64| {
                for (found, expected) in found.iter().zip(expected) {
                    let size = expected.abs().max(1.0);
                    assert!(
                        (found - expected).abs() < tolerance * size,
                        "{seed}: {found} {expected}"
                    );
                }
            };
            close(&found, &value, 1e-12);
            let call = compiled.fused("terms_jvp").expect("compiled");
            let mut found = vec![f64::NAN; 4];
            call.one(&[&q, &qd, &target, &dq, &dqd], &mut found).expect("fits");
            close(&found[..2], &value, 1e-12);
            close(&found[2..], &change, 1e-7);
            let states = 5;
            let repeated = [&q[..], &qd, &target, &dq, &dqd].map(|x| x.repeat(states));
            let mut many = vec![f64::NAN; 4 * states];
            call.many(&repeated.each_ref().map(Vec::as_slice), &mut many).expect("fits");
            many.chunks(4).for_each(|state| close(state, &found, 1e-12));
            // A fused function has the numbers of its functions.
            let jacobian = compiled.fused("terms_jacobian").expect("compiled");
            let mut expected = vec![f64::NAN; jacobian.result().len()];
            jacobian.one(&[&q, &qd, &target], &mut expected).expect("fits");
            expected.extend(&value);
            let dynamics = compiled.function(Function::ForwardDynamics).expect("compiled");
            let mut qdd = vec![f64::NAN; n];
            dynamics.one(&[&q, &qd, &tau], &mut qdd).expect("fits");
            expected.extend(qdd);
            let stage = compiled.fused("stage").expect("compiled");
            let mut found = vec![f64::NAN; expected.len()];
            stage.one(&[&q, &qd, &tau, &target], &mut found).expect("fits");
            close(&found, &expected, 1e-9);
        }
    }
}
