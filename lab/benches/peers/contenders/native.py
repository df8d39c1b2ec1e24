"""Machine code that modyn makes at run time, from `native-runner`; a program for each instruction set of the processor."""

from environment import HERE, OUTPUT, call, cargo_build
from measure import Program

#: In the table.
NAME = "modyn machine code"
BATCH = "modyn machine code, batch"


def runner():
    return cargo_build(HERE / "native-runner", OUTPUT / "native", "")


def build(toolbox):
    program = runner()
    programs = []
    for instructions in call([program, "sets"]).split():
        for robot in toolbox.robots:
            for quantity in robot.quantities:
                programs.append(Program(NAME, instructions, robot.name, quantity, program, before=("one", instructions)))
                if robot.batch and quantity.endswith("forward_dynamics"):
                    programs.append(Program(BATCH, instructions, robot.name, quantity, program,
                                            before=("batch", instructions)))
    return programs
