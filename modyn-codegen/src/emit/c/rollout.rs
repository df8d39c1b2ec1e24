//! Prints rollouts: loops that call the function of a time step.

use std::fmt::Write as _;

use super::{Array, Item, Printer};

impl Printer {
    /// Prints the function `name` that moves a state by several time steps of the function `step`: its arguments are the state,
    /// joint forces, the time step and what all steps share. `sizes` are the numbers of coordinates and of velocities.
    pub(super) fn rollout(&mut self, name: &str, step: &Item<'_>, [nq, nv]: [usize; 2]) {
        const MOVED: [&str; 3] = ["q", "qd", "impulses"];
        let real = self.real();
        let (moved, shared): (Vec<&Array>, Vec<&Array>) = step
            .arguments
            .iter()
            .filter(|array| array.name != "tau")
            .partition(|array| MOVED.contains(&&*array.name));
        let state = nq + nv;
        let shared: String = shared
            .iter()
            .map(|array| format!("const {}, ", self.array(&array.name, array.len)))
            .collect();
        let in_place: String =
            moved.iter().map(|array| format!("{}, ", self.array(&array.name, array.len))).collect();
        let head = format!(
            "void {name}(unsigned int steps, const {real} *controls, {shared}{in_place}{real} *trajectory)"
        );
        let of_ground = match moved.len() {
            3 => {
                "\n   `impulses` are those of the last step, or zeros; after the call those of the last step of the rollout."
            }
            _ => "",
        };
        let _ = writeln!(
            self.header,
            "/* Moves the state `q`, `qd` by `steps` steps of `{}`. `controls` has {nv} joint forces for each step.\n   \
             `trajectory` receives {state} numbers for each step, q and qd after it; it may be null.{of_ground} */\n{head};\n",
            step.name
        );
        let arguments: Vec<&str> = step
            .arguments
            .iter()
            .map(|array| if array.name == "tau" { "&controls[step * NV]" } else { &*array.name })
            .collect();
        let arguments = arguments.join(", ").replace("NV", &nv.to_string());
        let mut text = format!(
            "{head}\n{{\n    {real} next[{}];\n    unsigned int step;\n    int i;\n    \
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
            "        if (trajectory) {{\n            for (i = 0; i < {state}; ++i) {{ trajectory[step * {state} + i] = next[i]; }}\n        }}\n    }}\n}}\n"
        );
        self.source += &text;
    }
}
