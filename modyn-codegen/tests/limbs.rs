//! Equal limbs side by side give what they give one after the other.

use modyn_codegen::passes::optimize;
use modyn_codegen::trace::{Limbs, Tracer};
use modyn_codegen::urdf::{self, Base, ReadOptions};
use modyn_runtime::equations::Partition;
use modyn_runtime::equations::forward_dynamics::Elimination;
use modyn_runtime::model::ModuleTree;
use modyn_runtime::model::prepare::Prepared;

#[test]
fn try_out() {
    for (name, base) in [
        ("quadruped", Base::Fixed),
        ("quadruped", Base::Floating),
        ("humanoid", Base::Fixed),
        ("humanoid", Base::Floating),
    ] {
        let text = std::fs::read_to_string(format!("../robots/{name}.urdf")).unwrap();
        let options = ReadOptions { base, ..ReadOptions::default() };
        let model = urdf::read(&text, name, &options).unwrap().model;
        let prepared = Prepared::new(&model);
        let limbs = Limbs::find(&prepared).expect("equal limbs");
        let tracer = Tracer::new(&prepared);
        for modules in [ModuleTree::chains(&model), ModuleTree::links(&model)] {
            let partition = Partition::new(&prepared, &modules);
            let alone =
                optimize(tracer.forward_dynamics(&Elimination::Recursive(partition.clone())));
            let abreast = optimize(
                tracer
                    .abreast(&limbs)
                    .forward_dynamics(&Elimination::Recursive(limbs.partition(&partition))),
            );
            println!("{name} {base:?} {} -> {}", alone.count().total(), abreast.count().total());
            let x: Vec<f64> = (0..100).map(|i| (f64::from(i) * 0.7).sin()).collect();
            let (a, b) = (alone.evaluate(&x), abreast.evaluate(&x));
            for (a, b) in a.iter().zip(&b) {
                assert!((a - b).abs() < 1e-9 * a.abs().max(1.0), "{a} {b}");
            }
        }
        let (alone, abreast) = (
            optimize(tracer.inverse_dynamics()),
            optimize(tracer.abreast(&limbs).inverse_dynamics()),
        );
        println!("{name} {base:?} ID {} -> {}", alone.count().total(), abreast.count().total());
        let (alone, abreast) =
            (optimize(tracer.mass_matrix()), optimize(tracer.abreast(&limbs).mass_matrix()));
        println!("{name} {base:?} M {} -> {}", alone.count().total(), abreast.count().total());
        let x: Vec<f64> = (0..100).map(|i| (f64::from(i) * 0.7).sin()).collect();
        let (a, b) = (alone.evaluate(&x), abreast.evaluate(&x));
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() < 1e-9 * a.abs().max(1.0), "{a} {b}");
        }
    }
}
