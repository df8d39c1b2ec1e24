//! Prints rollouts: loops that call the function of a time step.

use std::fmt::Write as _;

use super::{Array, Item, Parameter, Printer};
use crate::plan::{CARRIED, PLANNED};

/// Returns whether an argument of a step is a result of it, too.
fn is_moved(name: &str) -> bool {
    ["q", "qd"].contains(&name) || CARRIED.contains(&name)
}

/// The arguments of a rollout.
pub(super) struct RolloutArguments<'a> {
    /// The argument that each step has of its own.
    pub(super) planned: &'a Parameter,
    /// What its numbers are.
    pub(super) numbers: &'static str,
    /// The arguments that all steps share.
    pub(super) shared: Vec<&'a Parameter>,
    /// The arguments that a step replaces by its first results.
    pub(super) moved: Vec<&'a Parameter>,
}

impl<'a> RolloutArguments<'a> {
    /// Returns the arguments of the rollout of a time step.
    pub(super) fn new(step: &'a Item<'_>) -> Self {
        let parameter = |name: &str| step.parameters.iter().find(|p| p.array.name == name);
        let (planned, numbers) = PLANNED
            .into_iter()
            .find_map(|(name, numbers)| Some((parameter(name)?, numbers)))
            .expect("a time step has forces");
        let others = step.parameters.iter().filter(|p| p.array.name != planned.array.name);
        let (moved, shared) = others.partition(|parameter| is_moved(&parameter.array.name));
        Self { planned, numbers, shared, moved }
    }
}

impl Printer {
    /// Prints the function `name`, which moves a state by several time steps of the function
    /// `step`. `sizes` are the numbers of coordinates and of velocities.
    pub(super) fn rollout(&mut self, name: &str, step: &Item<'_>, [nq, nv]: [usize; 2]) {
        let real = self.real();
        let state = nq + nv;
        let RolloutArguments { planned, numbers, shared, moved } = RolloutArguments::new(step);
        let moved: Vec<&Array> = moved.into_iter().map(|parameter| &parameter.array).collect();
        let in_place: String =
            moved.iter().map(|array| self.array(&array.name, array.len) + ", ").collect();
        let shared: String = shared.into_iter().map(|p| self.read(p)).collect();
        let count = planned.array.len;
        let head = format!(
            "void {name}(unsigned int steps, const {real} *controls, {shared}{in_place}{real} *trajectory)"
        );
        let notes = moved.iter().map(|array| match &*array.name {
            "q" | "qd" => String::new(),
            "act" => "\n   `act` are the activations before the call, and after it.".into(),
            name => format!(
                "\n   `{name}` is the result of the last step before the call, or zeros, and after it."
            ),
        });
        let carried: String = notes.collect();
        let _ = writeln!(
            self.header,
            "/* Moves the state `q`, `qd` by `steps` steps of `{}`. `controls` has {count} {numbers} \
             for each step.\n   \
             `trajectory` receives {state} numbers for each step, q and qd after it; it may be \
             null.{carried} */\n{head};\n",
            step.name
        );
        let numbers_of_step = format!("&controls[step * {count}]");
        let passed = step.parameters.iter().map(|parameter| {
            match parameter.array.name == planned.array.name {
                true => numbers_of_step.clone(),
                false => self.numbers_of(parameter),
            }
        });
        let arguments = passed.collect::<Vec<String>>().join(", ");
        let mut text = format!(
            "{head}\n{{\n    {real} next[{}];\n    unsigned int step;\n    unsigned int i;\n    \
             for (step = 0; step < steps; ++step) {{\n        {}({arguments}, next);\n",
            step.result.len(),
            step.own_name(),
        );
        let mut first = 0;
        for Array { name, len } in moved {
            let _ = writeln!(
                text,
                "        for (i = 0; i < {len}; ++i) {{ {name}[i] = next[{first} + i]; }}"
            );
            first += len;
        }
        let _ = writeln!(
            text,
            "        if (trajectory) {{\n            \
             for (i = 0; i < {state}; ++i) {{ trajectory[step * {state} + i] = next[i]; }}\n        }}\n    }}\n}}\n"
        );
        self.source += &text;
    }
}
