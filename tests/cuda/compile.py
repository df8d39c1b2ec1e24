"""Compiles CUDA text of some robots with NVIDIA's compilers, without a graphics processor, and counts registers.

    compile.py FILE              writes the table docs/data/cuda.tsv
    compile.py --check FILE      writes nothing: fails where counts differ from the file's

NVRTC makes PTX of the text, and ptxas makes machine code of that. Both come from PyPI. With `--check` NVRTC also compiles
every function of an arm and of a quadruped with contacts. `MODYN` is the command that writes the text. `run` beside this file
sets all of this up.
"""

import ctypes
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import nvidia

ROOT = Path(__file__).resolve().parent.parent.parent
NVIDIA = Path(list(nvidia.__path__)[0])
ARCHITECTURES = ["80", "90"]
SCALARS = ["f32", "f64"]
FOUR_FEET = [f"{end}{side}: point({end}_{side}_foot)" for end in ("front", "hind") for side in ("left", "right")]
# The name in the table, the description, further options, the kernel, and the name of the kernel in the table.
ROBOTS = [
    ("Panda", "tests/golden/panda.urdf", ["--functions", "forward_dynamics"], "forward_dynamics"),
    ("Panda", "tests/golden/panda.urdf", ["--functions", "step_semi_implicit", "--rollout"], "rollout_semi_implicit"),
    (
        "Panda",
        "tests/golden/panda.urdf",
        ["--functions", "forward_dynamics_derivatives"],
        "forward_dynamics_derivatives",
    ),
    (
        "Solo12, floating base",
        "tests/golden/solo12.urdf",
        ["--base", "floating", "--functions", "forward_dynamics"],
        "forward_dynamics",
    ),
    (
        "Solo12, floating base",
        "tests/golden/solo12.urdf",
        ["--base", "floating", "--functions", "step_semi_implicit", "--rollout"],
        "rollout_semi_implicit",
    ),
    (
        "quadruped on four feet",
        "robots/quadruped.urdf",
        ["--base", "floating", *[word for foot in FOUR_FEET for word in ("--contacts", foot)], "--functions", "step"],
        "step",
    ),
    ("G1", "tests/golden/g1.urdf", ["--functions", "forward_dynamics"], "forward_dynamics"),
    (
        "G1",
        "tests/golden/g1.urdf",
        ["--functions", "forward_dynamics_derivatives"],
        "forward_dynamics_derivatives",
    ),
]
# NVRTC takes half a minute for one text of it.
LONG = ("G1", "forward_dynamics_derivatives")
FEET = ["--contacts", "fl: point(front_left_foot)", "--contacts", "hr: surface(hind_right_foot)"]
OF_CONTACTS = (
    "constrained_forward_dynamics,constrained_forward_dynamics_derivatives,constraint_residual,impact_dynamics,"
    "constrained_inverse_dynamics,constraint_jacobian,constraint_jacobian_dot_qd,operational_space_inertia"
)
# Texts that have all functions together.
EVERYTHING = [
    ["robots/arm6.urdf", "--functions", "all"],
    ["robots/quadruped.urdf", "--base", "floating", *FEET, "--functions", OF_CONTACTS],
]
TITLES = ["robot", "kernel", "scalar", "architecture", "registers", "stack, bytes", "spilled, bytes", "instructions"]
COMMAND = "tests/cuda/run docs/data/cuda.tsv"


class Nvrtc:
    """CUDA's compiler at run time."""

    def __init__(self):
        folder = NVIDIA / "cuda_nvrtc" / "lib"
        builtins = next(folder.glob("libnvrtc-builtins.so*"))
        ctypes.CDLL(str(builtins), mode=ctypes.RTLD_GLOBAL)
        self.library = ctypes.CDLL(str(next(folder.glob("libnvrtc.so*"))))

    def text_of(self, program, size, get):
        count = ctypes.c_size_t()
        getattr(self.library, size)(program, ctypes.byref(count))
        buffer = ctypes.create_string_buffer(count.value)
        getattr(self.library, get)(program, buffer)
        return buffer.value.decode()

    def ptx(self, text, architecture):
        """Returns the PTX of a text, with the compiler's default options."""
        program = ctypes.c_void_p()
        created = self.library.nvrtcCreateProgram(ctypes.byref(program), text.encode(), b"kernels.cu", 0, None, None)
        if created != 0:
            sys.exit(f"NVRTC cannot create a program: error {created}")
        option = f"--gpu-architecture=compute_{architecture}".encode()
        options = (ctypes.c_char_p * 1)(option)
        if self.library.nvrtcCompileProgram(program, 1, options) != 0:
            sys.exit(self.text_of(program, "nvrtcGetProgramLogSize", "nvrtcGetProgramLog"))
        ptx = self.text_of(program, "nvrtcGetPTXSize", "nvrtcGetPTX")
        self.library.nvrtcDestroyProgram(ctypes.byref(program))
        return ptx


def ptxas(ptx, architecture):
    """Returns the registers, the bytes of the stack and of spills, and the instructions of PTX with one kernel."""
    with tempfile.TemporaryDirectory() as folder:
        path, output = Path(folder) / "kernel.ptx", Path(folder) / "kernel.cubin"
        path.write_text(ptx)
        command = [NVIDIA / "cuda_nvcc" / "bin" / "ptxas", "-v", f"-arch=sm_{architecture}", path, "-o", output]
        found = subprocess.run(command, capture_output=True, text=True)
        if found.returncode != 0:
            sys.exit(found.stderr)
        code = instructions(output.read_bytes())
    registers = re.search(r"Used (\d+) registers", found.stderr)
    stack = re.search(r"(\d+) bytes cumulative stack size", found.stderr)
    # Of the kernel and of the functions that it calls.
    spills = re.findall(r"(\d+) bytes spill (?:stores|loads)", found.stderr)
    return [int(registers[1]), int(stack[1]), sum(map(int, spills)), code]


def instructions(cubin):
    """Returns the instructions, of 16 bytes each, in the sections `.text` of an ELF file."""
    number = lambda at, size: int.from_bytes(cubin[at : at + size], "little")
    table, entry, count, names = number(0x28, 8), number(0x3A, 2), number(0x3C, 2), number(0x3E, 2)
    section = lambda i: table + i * entry
    strings = number(section(names) + 24, 8)
    total = 0
    for i in range(count):
        start = strings + number(section(i), 4)
        if cubin[start : cubin.index(b"\0", start)].startswith(b".text"):
            total += number(section(i) + 32, 8)
    return total // 16


def generated(path, scalar, options):
    """Returns the text of a robot's kernels."""
    command = [os.environ["MODYN"], "generate", path, "--target", "cuda", "--scalar", scalar, *options]
    found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if found.returncode != 0:
        sys.exit(found.stderr)
    return found.stdout


def table(nvrtc):
    work = []
    for robot, path, options, kernel in ROBOTS:
        is_long = (robot, kernel) == LONG
        for scalar in SCALARS[:1] if is_long else SCALARS:
            text = generated(path, scalar, options)
            for architecture in ARCHITECTURES[-1:] if is_long else ARCHITECTURES:
                key = [robot, f"`{kernel}`", scalar, f"sm_{architecture}"]
                work.append((key, nvrtc.ptx(text, architecture), architecture))
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        counts = list(threads.map(lambda item: ptxas(item[1], item[2]), work))
    rows = [[*key, *map(str, count)] for (key, _, _), count in zip(work, counts)]
    return f"# command: {COMMAND}\n" + "".join("\t".join(row) + "\n" for row in [TITLES, *rows])


def main():
    nvrtc = Nvrtc()
    match sys.argv[1:]:
        case ["--check", path]:
            for robot, *options in EVERYTHING:
                nvrtc.ptx(generated(robot, "f32", options), ARCHITECTURES[-1])
            expected, found = Path(path).read_text(), table(nvrtc)
            if found != expected:
                differing = [pair for pair in zip(expected.splitlines(), found.splitlines()) if pair[0] != pair[1]]
                for old, new in differing:
                    print(f"- {old}\n+ {new}", file=sys.stderr)
                sys.exit(f"{path} has other counts; to write it: {COMMAND}")
        case [path]:
            Path(path).write_text(table(nvrtc))
        case _:
            sys.exit(__doc__)


main()
