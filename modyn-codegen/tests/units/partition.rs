//! The search for modules.

use modyn_codegen::plan::partition::{ChosenPartition, choose};
use modyn_codegen::trace::Tracer;
use modyn_runtime::mechanism::Mechanism;

#[test]
fn a_search_beats_every_uniform_partition() {
    let text = include_str!("../../../robots/arm6.urdf");
    let model = modyn_codegen::read_urdf(text, "arm6.urdf", &modyn_codegen::ReadOptions::default())
        .expect("good")
        .model;
    let mechanism = Mechanism::new(&model);
    let ChosenPartition { modules, graph, candidates } =
        choose(&model, &mechanism, &Tracer::new(&mechanism));
    assert_eq!(candidates[0].0, "the modules found by the search");
    assert!(candidates.iter().all(|(_, cost)| *cost >= candidates[0].1));
    assert!(graph.count().total() <= candidates[0].1);
    assert!(modules.fits(&model) && modules.modules().len() > 1);
}
