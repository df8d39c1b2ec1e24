"""Crates that compute dynamics in Rust, from `crates-runner`; robots on a fixed base."""

from environment import HERE, OUTPUT, cargo_build
from measure import Program

#: The quantities of each crate.
CRATES = {
    "phyz": ["forward_dynamics", "inverse_dynamics", "mass_matrix"],
    "dynamics-rs": ["forward_dynamics", "inverse_dynamics"],
    "dynibo": ["forward_dynamics", "inverse_dynamics", "mass_matrix"],
}
WHY_NOT = {
    "Rust crate featherstone 0.1":
        "f32 only; for descriptions with rotated placements its dynamics are wrong (errors of 1), "
        "and the sign of its joint angles is reversed",
    "Rust crate k": "kinematics only",
    "Rust crate rapier3d": "a simulator: no forward dynamics as a function of q, qd and tau",
}


def build(toolbox):
    models = toolbox.pinocchio_models()
    toolbox.missing.update(WHY_NOT)
    program = cargo_build(HERE / "crates-runner", OUTPUT / "crates", f"-C target-cpu={toolbox.processor}")
    programs = []
    for crate, quantities in CRATES.items():
        for robot in toolbox.free:
            if robot.base == "floating":
                continue
            for quantity in quantities:
                after = (robot.description if crate != "phyz" else models[robot.name],)
                programs.append(Program(crate, "native", robot.name, quantity, program, before=(crate,), after=after))
    return programs
