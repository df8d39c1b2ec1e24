"""modyn's generated C, compiled as CasADi's C is."""

from environment import HARNESS, HERE, Unavailable, call, newer
from measure import Program

from .modyn import runner

CPP = HERE / "cpp"


def build(toolbox):
    sources = toolbox.build / "modyn_c"
    call([runner("default"), "c", sources])
    programs = []
    for robot in toolbox.free:
        source = next((sources / robot.name).glob("*.c"))
        for variant, c, cpp, flags in toolbox.variants():
            library = source.with_name(f"{variant}.o")
            if not newer(library, [source, source.with_suffix(".h")]):
                try:
                    call([c, *flags, "-std=c99", "-c", source, "-o", library])
                except Unavailable as why:
                    toolbox.missing[f"modyn C, {variant}, {robot.name}"] = str(why)
                    continue
            for quantity in robot.quantities:
                executable = source.with_name(f"{quantity}-{variant}")
                if not newer(executable, [library, CPP / "modyn.cpp", *HARNESS]):
                    function = [f"-DFUNCTION={source.stem}_{quantity}", *["-DOF_Q"] * (quantity == "mass_matrix")]
                    call([cpp, *flags, "-std=c++17", *function, CPP / "modyn.cpp", library, "-o", executable])
                programs.append(Program("modyn C", variant, robot.name, quantity, executable))
    return programs
