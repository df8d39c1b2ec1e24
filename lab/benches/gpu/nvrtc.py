"""Processor time of the first call of a function on CUDA, by its parts, and what NVRTC makes of it; needs no GPU.

    measure="python lab/benches/gpu/nvrtc.py"
    $measure | lab/record "$measure" "NOTE" > docs/data/nvrtc.tsv

Needs the package `modyn`, built for release, and `nvidia-cuda-nvrtc`. The columns are the robot's function, the scalar, NVRTC's further options;
ms of modyn (the description is read, planned and printed); ms until PTX, and from PTX to machine code of sm_90; the registers, and the bytes that
a thread spills. A gradient is in reverse mode, with respect to the state and the forces or controls. `--quick` measures a few functions.
"""

import ctypes
import re
import sys
import time
import warnings
from pathlib import Path

import modyn
from modyn import _cuda
from modyn._arrays import ArrayFunction, Signature

ROOT = Path(__file__).resolve().parent.parent.parent.parent
# The name, the file, the functions.
ROBOTS = [
    ("Panda", "tests/golden/panda.urdf", ["forward_dynamics", "step_semi_implicit"]),
    ("quadruped", "examples/walk/quadruped.xml", ["forward_dynamics", "step_semi_implicit", "step", "step_actuated"]),
    ("humanoid", "examples/walk/humanoid.xml", ["forward_dynamics", "step_semi_implicit", "step", "step_actuated"]),
]
VARIABLES = {"q", "qd", "tau", "ctrl"}
OPTIONS = ["", "--Ofast-compile=min"]
TITLES = ["function", "scalar", "options", "modyn, ms", "to PTX, ms", "to machine code, ms", "registers", "spilled, bytes"]


def compiled(nvrtc, text, architecture, options):
    """Returns the milliseconds that a compilation takes, and the log of its program."""
    program = ctypes.c_void_p()
    nvrtc.library.nvrtcCreateProgram(ctypes.byref(program), text.encode(), b"modyn.cu", 0, None, None)
    given = [f"--gpu-architecture={architecture}".encode(), *_cuda.OPTIONS, *(option.encode() for option in options)]
    start = time.process_time()
    error = nvrtc.library.nvrtcCompileProgram(program, len(given), (ctypes.c_char_p * len(given))(*given))
    duration = 1e3 * (time.process_time() - start)
    log = nvrtc.bytes_of(program, "ProgramLog").rstrip(b"\0").decode()
    nvrtc.library.nvrtcDestroyProgram(ctypes.byref(program))
    if error:
        sys.exit(log)
    return duration, log


def main():
    found = [path for folder in sys.path for path in Path(folder).glob("nvidia/*/lib/libnvrtc.so.*")]
    if not found:
        sys.exit("NVRTC is not installed: pip install nvidia-cuda-nvrtc")
    nvrtc = _cuda.Nvrtc(str(found[0]))
    print(f"NVRTC {nvrtc.version}", file=sys.stderr)
    line = lambda cells: print(f"| {' | '.join(cells)} |", flush=True)
    line(TITLES)
    line(["---"] * len(TITLES))
    warnings.simplefilter("ignore", modyn.DescriptionWarning)
    robots = ROBOTS[:2] if "--quick" in sys.argv else ROBOTS
    for title, path, functions in robots:
        for name in functions:
            for scalar in ["f32", "f64"]:
                for gradient in [False, True]:
                    start = time.process_time()
                    robot = modyn.load(ROOT / path, scalar=scalar)
                    function = ArrayFunction(robot, name)
                    if gradient:
                        names = Signature.of(robot, name, None).names
                        function = function.derivative("reverse", [k for k, name in enumerate(names) if name in VARIABLES])
                    text = function.cuda_text()
                    own = 1e3 * (time.process_time() - start)
                    for options in OPTIONS:
                        further = options.split()
                        ptx, _ = compiled(nvrtc, text, "compute_90", further)
                        total, log = compiled(nvrtc, text, "sm_90", [*further, "--ptxas-options=-v"])
                        registers = re.search(r"Used (\d+) registers", log)[1]
                        spilled = sum(map(int, re.findall(r"(\d+) bytes spill (?:stores|loads)", log)))
                        row = [f"{title}, `{name}`" + ", gradient" * gradient, scalar, f"`{options}`" if options else "-"]
                        row += [f"{own:.0f}", f"{ptx:.0f}", f"{max(total - ptx, 0):.0f}", registers, str(spilled)]
                        line(row)


main()
