//! The rules that every recursion satisfies, checked once before it is printed. Those of its programs are checked with these.

use super::{Read, Recursion, Run, Step, Write};

impl Recursion {
    /// Returns the rule that the recursion breaks.
    pub(super) fn fault(&self) -> Option<&'static str> {
        let mut next = 1;
        for run in &self.runs {
            for body in &run.bodies {
                if body.own != next || body.parent >= next {
                    return Some("records are in the order of the bodies, parents before children");
                }
                next += 1;
            }
            let steps = self.steps.get(run.kind);
            if steps.is_none_or(|steps| steps.len() != self.sweeps.len()) {
                return Some("a body has a step in each sweep");
            }
            if steps.is_some_and(|steps| steps.iter().any(|step| !self.fits(run, step))) {
                return Some("a step has the arguments and the results that its bodies have");
            }
        }
        let slots = self.world.iter().flatten().map(|(slot, _)| *slot);
        let in_bounds = slots.into_iter().all(|slot| slot < self.record);
        (!in_bounds).then_some("the world has a record as all bodies")
    }

    /// Returns whether a step fits the bodies of a run.
    fn fits(&self, run: &Run, step: &Step) -> bool {
        let [nq, nv, _, parameters] = self.arguments;
        let ends = |of: &dyn Fn(&super::Places) -> u16, entry: usize, length: usize| {
            run.bodies.iter().all(|body| usize::from(of(body)) + entry < length)
        };
        let reads = step.reads.iter().all(|read| match *read {
            Read::Vector(0, entry) => ends(&|body| body.q, entry, nq),
            Read::Vector(vector, entry) => vector < 3 && ends(&|body| body.v, entry, nv),
            Read::Parameter(parameter) => parameter < parameters,
            Read::Own(slot) | Read::Parent(slot) => slot < self.record,
        });
        let writes = step.writes.iter().all(|write| match *write {
            Write::Own(slot) | Write::AddToParent(slot) => slot < self.record,
            Write::Result(entry) => ends(&|body| body.v, entry, self.results),
        });
        let constants = run.constants();
        reads
            && writes
            && run.table.len() == run.bodies.len()
            && run.table.iter().all(|row| row.len() == constants)
            && step.program.arguments == constants + step.reads.len()
            && step.program.results.len() == step.writes.len()
    }
}
