"""C that CasADi writes of Pinocchio's algorithms, traced on its symbols."""

from environment import HARNESS, HERE, SITE, Unavailable, call, newer
from measure import Program

from .pinocchio import HEADERS

#: CasADi's own elimination of common subexpressions, or none.
TRACES = ["plain", "cse"]
CPP = HERE / "cpp"


def tracer(toolbox):
    toolbox.wheel("casadi")
    library = SITE / "casadi"
    executable = toolbox.build / "trace"
    if not newer(executable, [CPP / "trace.cpp", CPP / "model.hpp"]):
        compilers = [cpp for _, _, cpp in toolbox.compilers]
        if not compilers:
            raise Unavailable("no compiler")
        call([compilers[0], "-O0", "-DNDEBUG", *HEADERS, "-isystem", library / "include", CPP / "trace.cpp",
              "-o", executable, f"-L{library}", "-lcasadi", f"-Wl,-rpath,{library}"])
    return executable


def build(toolbox):
    trace, models = tracer(toolbox), toolbox.pinocchio_models()
    programs = []
    for robot in toolbox.free:
        for quantity in robot.quantities:
            for how in TRACES:
                stem = f"{robot.name}_{quantity}"
                place = toolbox.build / how
                place.mkdir(exist_ok=True)
                source = place / f"{stem}.c"
                if not newer(source, [trace, models[robot.name]]):
                    said = call([trace, toolbox.data, robot.name, quantity, how, models[robot.name]], cwd=place)
                    print(f"casadi: {stem}, {how}: {said.strip()}", flush=True)
                for variant, c, cpp, flags in toolbox.variants():
                    executable = place / f"{stem}-{variant}"
                    if not newer(executable, [source, CPP / "casadi.cpp", *HARNESS]):
                        try:
                            call([c, *flags, "-c", source, "-o", f"{executable}.o"])
                            call([cpp, *flags, "-std=c++17", CPP / "casadi.cpp", f"{executable}.o", "-o", executable])
                        except Unavailable as why:
                            toolbox.missing[f"CasADi C, {variant}, {how}, {robot.name}, {quantity}"] = str(why)
                            continue
                    programs.append(Program("CasADi C", f"{variant}, {how}", robot.name, quantity, executable))
    return programs
