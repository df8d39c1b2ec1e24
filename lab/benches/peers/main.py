"""Builds all contenders, measures them, and writes a table and a plot: `run --help`."""

import argparse
import dataclasses
import datetime
import json
import math
import subprocess
import sys

import environment
import measure
import plot
import table
from contenders import CONTENDERS, modyn
from environment import OUTPUT, QUANTITIES, ROOT, Unavailable

#: What was built last, for `--built`.
BUILT = OUTPUT / "built.json"


def options():
    parser = argparse.ArgumentParser(prog="run", description=__doc__)
    parser.add_argument("--robots", metavar="NAME,...", help="only these of robots.txt")
    parser.add_argument("--only", metavar="NAME,...", help=f"only these contenders: {', '.join(CONTENDERS)}")
    parser.add_argument("--quantities", metavar="NAME,...", help=f"only these: {', '.join(QUANTITIES)}")
    parser.add_argument("--compilers", metavar="NAME,...", help="only these of gcc, clang")
    parser.add_argument("--data", metavar="NAME", default="speed",
                        help="the name of the data files: NAME.tsv, NAME-cold.tsv, NAME-errors.tsv (speed)")
    parser.add_argument("--processor", metavar="NAME", default="native",
                        help="compile for this processor, as compilers name it; if it is another machine's, see README.md")
    parser.add_argument("--built", action="store_true", help="measure what was built last; compile nothing")
    parser.add_argument("--quick", action="store_true", help="2 copies and 5 repetitions, for debugging")
    parser.add_argument("--warm", action="store_true", help="no calls with empty caches, for machines where flushes are slow")
    parser.add_argument("--copies", type=int, default=5, help="processes, each of a fresh copy of its program (5)")
    parser.add_argument("--seconds", type=float, default=math.inf, metavar="S",
                        help="start no program after this time, and report what was measured")
    parser.add_argument("--beside", metavar="CHECKOUT", help="measure the modyn of another checkout, too")
    parser.add_argument("--install", action="store_true", help="install missing compilers with apt-get")
    parser.add_argument("--output", default=OUTPUT, help="where to put the table and the plot (target/peers)")
    arguments = parser.parse_args()
    if arguments.copies < 1:
        parser.error("--copies: at least 1")
    return arguments, {action.dest: action.default for action in parser._actions}


def command(arguments, defaults):
    """The command that measures the same again, without where its files go."""
    words = ["lab/benches/peers/run"]
    for name, value in vars(arguments).items():
        if name not in ("output", "built", "processor", "seconds") and value != defaults[name]:
            words += [f"--{name}"] if value is True else [f"--{name}", str(value)]
    return " ".join(words)


def chosen(names, all_names, what):
    names = names.split(",") if names else list(all_names)
    unknown = set(names) - set(all_names)
    if unknown:
        sys.exit(f"no {what} {', '.join(sorted(unknown))}: there are {', '.join(all_names)}")
    return names


def build(arguments, robots, names, compilers):
    """Builds the contenders of these names; returns their programs, and what is said of them."""
    toolbox = environment.Toolbox(robots, arguments.install, arguments.beside, compilers, arguments.processor)
    contenders = {"beside": modyn.build_beside} if arguments.beside else {}
    contenders.update((name, CONTENDERS[name]) for name in names)
    modyn.states(toolbox)
    programs = {}
    for name, its_build in contenders.items():
        print(f"{name}: building", flush=True)
        try:
            programs[name] = [dataclasses.asdict(program) for program in its_build(toolbox)]
        except Unavailable as why:
            print(f"{name}: left out: {why}", flush=True)
            toolbox.missing[name] = str(why)
    commit = subprocess.run(["git", "describe", "--always", "--dirty"], capture_output=True, text=True, check=True,
                            cwd=environment.HERE).stdout.strip()
    return dict(programs=programs, versions=toolbox.versions, missing=toolbox.missing, commit=commit)


def written(path):
    """A path from the root of the repository, which may be elsewhere on the machine that measures."""
    return str(path.relative_to(ROOT) if path.is_relative_to(ROOT) else path)


def main():
    arguments, defaults = options()
    robots = environment.robots()
    names = chosen(arguments.robots, [robot.name for robot in robots], "robot")
    robots = [robot for robot in robots if robot.name in names]
    only = chosen(arguments.only, CONTENDERS, "contender")
    quantities = chosen(arguments.quantities, QUANTITIES, "quantity")
    for robot in robots:
        robot.quantities = [quantity for quantity in robot.quantities if quantity in quantities]
    compilers = chosen(arguments.compilers, environment.COMPILERS, "compiler")

    if not arguments.built:
        BUILT.write_text(json.dumps(build(arguments, robots, only, compilers), default=written, indent=1))
        if arguments.processor != "native":
            return
    elif not BUILT.exists():
        sys.exit(f"{written(BUILT)} is not there: run without --built first")
    built = json.loads(BUILT.read_text())
    programs = [measure.Program(**program) for name, all_its in built["programs"].items() if name in [*only, "beside"]
                for program in all_its if program["robot"] in names and program["quantity"] in quantities]
    copies, repetitions = (2, 5) if arguments.quick else (arguments.copies, 21)
    results = measure.Measurer(OUTPUT / "data", copies, repetitions, arguments.seconds, arguments.warm).all(programs)

    report = dict(command=command(arguments, defaults), machine=environment.machine(), versions=built["versions"],
                  quick=arguments.quick, copies=copies, robots=names, quantities=QUANTITIES, results=results,
                  missing=built["missing"])
    output = environment.folder(arguments.output)
    (output / "results.json").write_text(json.dumps(report, indent=1))
    (output / "table.md").write_text(table.markdown(report))
    (output / "plot.svg").write_text(plot.svg(report))
    for ending, data in [("", table.data), ("-cold", table.cold_data), ("-errors", table.errors_data)]:
        (output / f"{arguments.data}{ending}.tsv").write_text(data(report, built["commit"], datetime.date.today()))
    print((output / "table.md").read_text())


if __name__ == "__main__":
    main()
