"""Runs programs: several copies each, and the best of all.

Where a program's code and data lie in physical memory changes its times, by up to a factor of two;
a fresh copy of the file lies elsewhere.
"""

import dataclasses
import math
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

from environment import ROOT

#: The median, the 99th percentile and the largest time of a call with empty caches.
COLD = ["cold", "cold_99", "cold_most"]
#: As the programs have it too.
LARGEST_ERROR = 1e-8


@dataclasses.dataclass
class Program:
    """`executable *before DATA ROBOT QUANTITY REPETITIONS *after` prints its error, its time, and its time with empty caches.

    It runs in the root of the repository.
    """

    contender: str
    #: The variant of the contender's program; the table shows the fastest one.
    variant: str
    robot: str
    quantity: str
    executable: Path
    before: tuple = ()
    after: tuple = ()
    #: Shared libraries that are copied with it, found by an rpath of $ORIGIN.
    libraries: tuple = ()


class Measurer:
    def __init__(self, data, copies, repetitions, seconds, warm):
        self.data, self.copies, self.repetitions, self.warm = data, copies, repetitions, warm
        self.end = time.monotonic() + seconds
        # The last core: the first one serves interrupts.
        self.pin = []
        if shutil.which("taskset"):
            self.pin = ["taskset", "-c", str(max(os.sched_getaffinity(0)))]

    def all(self, programs):
        """Returns the results of all programs. Each runs once, then each again: other work of the machine meets all of them."""
        results = [dict(contender=program.contender, variant=program.variant, robot=program.robot, quantity=program.quantity,
                        error=math.nan, ns=None, runs=[], cold_runs=[], why=None, **dict.fromkeys(COLD))
                   for program in programs]
        for copy in range(self.copies):
            print(f"copy {copy + 1} of {self.copies}", flush=True)
            for program, result in zip(programs, results):
                if result["why"] is None and time.monotonic() < self.end:
                    self._add(result, self._run(program))
        for result in results:
            if result["why"] is None and not result["runs"]:
                result["why"] = "no time left"
            if result["why"] is None:
                result["ns"] = min(result["runs"])
                # All three of the copy with the least median.
                result.update(zip(COLD, min(result["cold_runs"], default=[None] * 3)))
            print("{contender:24} {variant:28} {robot:10} {quantity:30} error {error:8.1e}  "
                  .format(**result) + (f"{result['ns']:10.1f} ns" if result["ns"] else result["why"])
                  + (f", cold {result['cold']:10.1f} ns" if result["cold"] else ""), flush=True)
        return results

    def _add(self, result, said):
        """Adds the output of a copy, or the reason why there is none."""
        if isinstance(said, str):
            result["why"] = said
            return
        result["error"] = said["error"]
        result["runs"].append(said["ns"])
        result["cold_runs"] += [[said[name] for name in COLD]] if "cold" in said else []

    def _output(self, command):
        """Returns the lines that a program prints, up to its time if `warm`, and its messages."""
        # Programs in C keep their lines back unless told.
        lines, command = [], ["stdbuf", "-oL", *command] if self.warm else command
        with (tempfile.TemporaryFile("w+") as errors,
              subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True, cwd=ROOT) as running):
            for line in running.stdout:
                lines.append(line)
                if self.warm and line.startswith("ns "):
                    running.kill()
            errors.seek(0)
            return lines, errors.read()

    def _run(self, program):
        """Returns the output of a fresh copy of the program, or the reason why there is none."""
        with tempfile.TemporaryDirectory(dir=self.data.parent) as place:
            for file in [program.executable, *program.libraries]:
                shutil.copy2(ROOT / file, place)
            executable = Path(place) / Path(program.executable).name
            command = [*self.pin, executable, *program.before, self.data, program.robot, program.quantity,
                       self.repetitions, *program.after]
            said, errors = self._output(list(map(str, command)))
        said = dict(line.split() for line in said if len(line.split()) == 2)
        said = {key: float(value) for key, value in said.items()}
        if not said.get("error", math.inf) < LARGEST_ERROR:
            if "error" in said:
                return f"wrong: error {said['error']:.1e}"
            # The message of a panic is on the line after the line with its place.
            lines = [line for line in errors.splitlines() if line.strip() and not line.startswith("thread ")]
            return lines[0][:160] if lines else "crashed"
        return said if "ns" in said else "no time"
