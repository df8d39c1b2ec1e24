"""MuJoCo's smooth dynamics, from the C library of its wheel."""

import shutil
from pathlib import Path

from environment import HARNESS, HERE, SITE, Unavailable, call, newer, python
from measure import Program


def build(toolbox):
    models = toolbox.pinocchio_models()
    toolbox.wheel("mujoco")
    package = SITE / "mujoco"
    library = next(iter(package.glob("libmujoco.so*")), None)
    if library is None or not toolbox.compilers:
        raise Unavailable("no library or no compiler")
    library = Path(shutil.copy2(library, toolbox.build))
    source = HERE / "cpp" / "mujoco.cpp"
    # Only the library is measured; the compiler of the harness does not matter.
    executable = toolbox.build / "mujoco"
    if not newer(executable, [source, *HARNESS]):
        call([toolbox.compilers[-1][2], "-std=c++17", "-O3", f"-march={toolbox.processor}", "-I", package / "include", source,
              library, "-Wl,-rpath,$ORIGIN", "-o", executable])
    toolbox.missing["MuJoCo, forward_dynamics_derivatives"] = "finite differences only"
    programs = []
    for robot in toolbox.free:
        model = toolbox.build / f"{robot.name}.mjb"
        python("mujoco_model.py", models[robot.name], model)
        for quantity in robot.quantities:
            if quantity == "forward_dynamics_derivatives":
                continue
            for how in ["forward", "pieces"] if quantity == "forward_dynamics" else ["pieces"]:
                programs.append(Program("MuJoCo", how, robot.name, quantity, executable,
                                        after=(model, how), libraries=(library,)))
    return programs
