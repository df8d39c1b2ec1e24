"""The environment: folders, robots, compilers, versions."""

import dataclasses
import os
import platform
import re
import shutil
import site
import subprocess
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
OUTPUT = ROOT / "target" / "peers"
SITE = Path(site.getsitepackages()[0])
#: What all programs in C and C++ share.
HARNESS = [HERE / "cpp" / "harness.hpp", HERE / "cpp" / "cold.hpp"]
#: Of robots without contacts; derivatives of some only.
FREE = ["forward_dynamics", "inverse_dynamics", "mass_matrix", "forward_dynamics_derivatives"]
#: Of robots with contacts.
CONSTRAINED = ["constrained_forward_dynamics", "constrained_forward_dynamics_derivatives"]
QUANTITIES = FREE + CONSTRAINED


#: Debian's package, the endings of the commands' names, the commands for C and C++.
COMPILERS = {
    "gcc": ("g++", [""], ("gcc", "g++")),
    "clang": ("clang-19", ["-19", "", "-18", "-17", "-16"], ("clang", "clang++")),
}


class Unavailable(Exception):
    """Why a contender cannot be had."""


@dataclasses.dataclass
class Robot:
    name: str
    description: Path
    base: str
    #: The words of the last column.
    timed: list

    @property
    def contacts(self):
        """KIND:LINK of each contact."""
        return [word for word in self.timed if ":" in word]

    @property
    def batch(self):
        """Whether forward dynamics is also measured for many states a call."""
        return "batch" in self.timed

    def __post_init__(self):
        quantities = CONSTRAINED if self.contacts else FREE
        #: What is measured; `--quantities` leaves some out.
        self.quantities = quantities if "derivatives" in self.timed else quantities[:-1]


def robots():
    lines = (HERE / "robots.txt").read_text().splitlines()
    rows = [line.split() for line in lines if line and not line.startswith("#")]
    rows = [Robot(name, description(name, urdf), base, timed.split(",")) for name, urdf, base, timed in rows]
    return [robot for robot in rows if robot.description.exists()]


def description(name, urdf):
    """Where a robot's description is; one of a wheel is copied to where modyn's runner looks."""
    if not urdf.startswith("wheel:"):
        return ROOT / urdf
    source = SITE / "cmeel.prefix/share/example-robot-data/robots" / urdf.removeprefix("wheel:")
    copy = folder(OUTPUT / "robots") / f"{name}.urdf"
    if source.exists() and not newer(copy, [source]):
        shutil.copy(source, copy)
    return copy


def folder(path):
    path = Path(path)
    path.mkdir(parents=True, exist_ok=True)
    return path


def call(command, **options):
    """Runs a command and returns its output; raises `Unavailable` with the end of its messages."""
    command = [str(word) for word in command]
    done = subprocess.run(command, capture_output=True, text=True, **options)
    if done.returncode != 0:
        (OUTPUT / "failed.log").write_text(" ".join(command) + "\n" + done.stdout + done.stderr)
        said = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines()
        reason = said[0][-160:] if said else f"exit {done.returncode}"
        raise Unavailable(f"{Path(command[0]).name}: {reason}")
    return done.stdout


def cargo_build(crate, built, flags):
    """Builds a crate's program in the folder `built`, and returns the program. The flags are not for its build script, which runs here."""
    host = re.search(r"host: (\S+)", call(["rustc", "-vV"])).group(1)
    call(["cargo", "build", "--release", "--manifest-path", crate / "Cargo.toml", "--target-dir", built, "--target", host],
         env={**os.environ, "RUSTFLAGS": flags})
    return built / host / "release" / crate.name


def newer(target, sources):
    """Whether `target` is there and newer than all of `sources`."""
    sources = [source for source in map(Path, sources) if source.exists()]
    return target.exists() and all(target.stat().st_mtime > source.stat().st_mtime for source in sources)


def machine():
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    fields = dict(reversed([tuple(map(str.strip, line.split(":", 1))) for line in lines if ":" in line]))
    model = fields.get("model name", platform.machine())
    features = set(fields.get("flags", "").split())
    best = next((name for flag, name in [("avx512f", "AVX-512"), ("avx2", "AVX2")] if flag in features), "")
    parts = [model, f"family {fields['cpu family']} model {fields['model']}" if "cpu family" in fields else "", best]
    return ", ".join(filter(None, parts))


class Toolbox:
    """The compilers and flags of the programs."""

    def __init__(self, robots, install, beside, compilers, processor):
        self.robots, self.install, self.beside, self.processor = robots, install, beside, processor
        self.build = folder(OUTPUT / f"build-{processor}")
        self.data = folder(OUTPUT / "data")
        self.versions, self.missing = {}, {}
        self.compilers = self._compilers(compilers)

    @property
    def free(self):
        """The robots without contacts."""
        return [robot for robot in self.robots if not robot.contacts]

    def version(self, name, text):
        """Records the first version number in a program's output."""
        self.versions[name] = re.search(r"\d+\.\d+(\.\d+)?", text).group()

    def wheel(self, name):
        """Notes the version of a wheel, which must be there."""
        from importlib import metadata
        try:
            self.versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            raise Unavailable(f"the wheel `{name}` could not be installed") from None

    def _compilers(self, names):
        """The compilers of these names: the name in the table, C, C++."""
        found = []
        for name in names:
            package, suffixes, (c, cpp) = COMPILERS[name]
            def first():
                return next((s for s in suffixes if shutil.which(c + s) and shutil.which(cpp + s)), None)
            suffix = first()
            if suffix is None and self.install and shutil.which("apt-get") and os.geteuid() == 0:
                subprocess.run(["apt-get", "update", "-qq"], check=False)
                subprocess.run(["apt-get", "install", "-qq", "-y", "--no-install-recommends", package], check=False)
                suffix = first()
            if suffix is None:
                self.missing[name] = f"no such compiler: `apt-get install {package}`, or run with --install as root"
                continue
            found.append((name, c + suffix, cpp + suffix))
            self.version(name, call([cpp + suffix, "-dumpfullversion" if name == "gcc" else "--version"]))
        return found

    def variants(self):
        """Compilers with flags: name, C compiler, C++ compiler, flags."""
        base = ["-O3", f"-march={self.processor}", "-DNDEBUG"]
        for name, c, cpp in self.compilers:
            yield name, c, cpp, base
            yield f"{name}+F", c, cpp, [*base, "-ffp-contract=fast", "-fno-math-errno"]

    def pinocchio_models(self):
        """Pinocchio's models as text, by robot."""
        self.wheel("pin")
        models = {}
        for robot in self.robots:
            models[robot.name] = self.build / f"{robot.name}.pinocchio"
            if not newer(models[robot.name], [robot.description, HERE / "pinocchio_model.py", HERE / "robots.txt"]):
                python("pinocchio_model.py", robot.description, robot.base, models[robot.name], *robot.contacts)
        return models


def python(script, *arguments):
    import sys
    return call([sys.executable, HERE / script, *arguments])
