//! Machine code computes the bits that its program's evaluation does, for all robots, at every level of the processor.

mod common;

use common::{Fuse, ROBOTS, builder, evaluate, is_same, levels, program, random, robot};
use modyn_codegen::Function;
use modyn_jit::{Compiled, Options};

const FUNCTIONS: [Function; 8] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::BiasForces,
    Function::MassMatrix,
    Function::ForwardDynamicsDerivatives,
    Function::ConstrainedForwardDynamics,
    Function::Difference,
    Function::KineticEnergy,
];

fn numbers<F: Fuse>(seed: u64, count: usize, scale: f64) -> Vec<F> {
    let mut random = random::Random::new(seed);
    (0..count).map(|_| F::from_f64(random.between(-scale, scale))).collect()
}

fn same_bits<F: Fuse>() {
    let mut compared = 0;
    for name in ROBOTS {
        let model = robot(name);
        let builder = builder(&model, &FUNCTIONS);
        let planning = builder.plan().expect("good");
        for level in levels() {
            let mut options = Options::default();
            options.level = Some(level);
            let compiled = Compiled::<F>::build(&builder, options).expect("code");
            for function in compiled.functions() {
                let vectors = level.fuses() || size_of::<F>() == 4;
                let program = program(&planning, function, vectors).expect("not of a link");
                let call = compiled.function(function).expect("compiled");
                let lengths: Vec<usize> =
                    call.arguments().iter().map(|(_, shape)| shape.len()).collect();
                for (seed, scale) in [(1, 1.5), (2, 30.0), (3, 3e5), (4, 1e20)] {
                    let all: Vec<F> = numbers(seed, lengths.iter().sum(), scale);
                    let mut rest = &all[..];
                    let arguments: Vec<&[F]> = lengths
                        .iter()
                        .map(|&length| {
                            let (first, others) = rest.split_at(length);
                            rest = others;
                            first
                        })
                        .collect();
                    let mut found = vec![F::from_f64(f64::NAN); call.result().len()];
                    call.one(&arguments, &mut found).expect("fits");
                    let expected = evaluate(program, level, &all);
                    for (i, (a, b)) in found.iter().zip(&expected).enumerate() {
                        let function = function.name();
                        assert!(is_same(*a, *b), "{name} {function} {level:?} {scale} {i}: {a:?} {b:?}");
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 10_000, "{compared}");
}

#[test]
fn double_precision() {
    same_bits::<f64>();
}

#[test]
fn single_precision() {
    same_bits::<f32>();
}
