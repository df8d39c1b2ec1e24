"""Pinocchio's C++ templates, from the headers of its wheel."""

from environment import HARNESS, HERE, SITE, Unavailable, call, newer
from measure import Program

PREFIX = SITE / "cmeel.prefix" / "include"
#: As the wheel's own CMake files have it.
DEFINED = ["BOOST_MPL_LIMIT_LIST_SIZE=30", "BOOST_MPL_LIMIT_VECTOR_SIZE=30",
           "BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS", "BOOST_FUSION_INVOKE_MAX_ARITY=12"]
HEADERS = ["-std=c++17", "-w", "-isystem", PREFIX, "-isystem", PREFIX / "eigen3",
           *[f"-D{definition}" for definition in DEFINED]]


def build(toolbox):
    models = toolbox.pinocchio_models()
    toolbox.wheel("cmeel-eigen")
    source = HERE / "cpp" / "pinocchio.cpp"
    depends = [source, HERE / "cpp" / "model.hpp", *HARNESS]
    programs = []
    for variant, _, compiler, flags in toolbox.variants():
        executable = toolbox.build / f"pinocchio-{variant}"
        if not newer(executable, depends):
            try:
                call([compiler, *flags, *HEADERS, source, "-o", executable])
            except Unavailable as why:
                toolbox.missing[f"Pinocchio C++, {variant}"] = str(why)
                continue
        for robot in toolbox.robots:
            for quantity in robot.quantities:
                programs.append(Program("Pinocchio C++", variant, robot.name, quantity, executable,
                                        after=(models[robot.name],)))
    if not programs:
        raise Unavailable("no compiler took it")
    return programs
