"""Every description of public collections: whether modyn accepts it, and the differences from other libraries.

MJCF is compared with MuJoCo, URDF with Pinocchio, a xacro with Pinocchio on what ROS's program makes of it, SDF with
Drake. Writes docs/data/collections.tsv and docs/data/collected.tsv. Exit code 1 if an accepted file differs.
"""

import argparse
import concurrent.futures
import dataclasses
import json
import subprocess
import sys
import tempfile
import time
import zipfile
from importlib.metadata import version
from pathlib import Path

import numpy

import modyn
import table
from main import TOLERANCE
from reference import Unloaded

#: The wheels of PyPI whose files are read; those of Drake are installed.
WHEELS = ("dm_control==1.0.50", "genesis-world==1.4.5", "gymnasium==1.4.0", "gymnasium-robotics==1.4.2",
          "metaworld==3.1.1", "playground==0.2.0", "robosuite==1.5.2")
#: MuJoCo computes inertias of meshes from vertices in single precision.
MUJOCO_TOLERANCE = 1e-7
LOOP_TOLERANCE = 1e-6


@dataclasses.dataclass
class Row:
    collection: str
    file: str
    format: str
    #: That of `modyn check`; "by an option" if `option` has one with which a refused file is accepted.
    verdict: str
    option: str = ""
    #: Whether the robot has kinematics alone, since its links have no inertia.
    is_kinematic: bool = False
    #: The first error: its code, and what it says.
    code: str = ""
    why: str = ""
    joints: int | None = None
    #: "agrees", "differs", or why the other library has no numbers.
    compared: str = ""
    difference: float | None = None


def fetch(folder):
    """Unpacks the wheels. Returns the collections by name."""
    found = {}
    for wheel in WHEELS:
        name, number = wheel.split("==")
        place = folder / f"{name}-{number}"
        if not place.is_dir():
            command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", folder / "wheels", wheel]
            subprocess.run(command, check=True)
            archive, = (folder / "wheels").glob(f"{name.replace('-', '_')}-{number}-*.whl")
            with zipfile.ZipFile(archive) as content:
                content.extractall(place)
        found[f"{name} {number}"] = place
    drake = next(Path(sys.prefix).glob("lib/python3*/site-packages/pydrake/share/drake"))
    return {**found, f"drake {version('drake')}": drake}


def checked(collection, folder):
    """The rows of a collection, with the diagnostics of each file, by `modyn check`."""
    done = modyn.call(modyn.RELEASE / "modyn", "check", "--collection", "--json", folder)
    if done.returncode not in (0, 1):
        raise RuntimeError(f"{folder}: modyn check: {done.stderr}")
    for file in json.loads(done.stdout)["files"]:
        path = Path(file["file"])
        errors = [one for one in file["diagnostics"] if one["severity"] == "error"]
        row = Row(collection, str(path.relative_to(folder)), file["format"], file["verdict"])
        row.is_kinematic = any(one["code"] == "kinematics-only" for one in file["diagnostics"])
        if errors:
            subject = errors[0]["subject"]
            about = f"{subject['kind']} `{subject['name']}`: " if subject else ""
            row.code, row.why = errors[0]["code"], (about + errors[0]["message"]).replace(f"{folder}/", "")
        # With an option, a part of another MJCF may be a robot by itself.
        if row.verdict == "refused" or row.verdict == "part" and row.format == "mjcf":
            tried = (option for option in modyn.OPTIONS if not modyn.check(path, option)[0])
            row.option = next(tried, "")
            row.verdict = "by an option" if row.option else row.verdict
        yield row, path


def expanded(path):
    """The URDF of a xacro by ROS's own program, beside it; packages are folders beside those that the file is in."""
    import xacro
    from xacro import substitution_args

    def place(package):
        near = (one for folder in path.parents for one in (folder, folder / package) if one.name == package)
        found = next((folder for folder in near if folder.is_dir()), None)
        if found is None:
            raise Unloaded(f"the package {package} is not there")
        return str(found)

    substitution_args._eval_find = place
    try:
        return xacro.process_file(str(path)).toxml()
    except Exception as error:
        raise Unloaded(str(error)) from error


def reference(row, path, joints):
    """The other library's model of a file."""
    if row.format == "xacro":
        with tempfile.NamedTemporaryFile("w", suffix=".urdf") as urdf:
            urdf.write(expanded(path))
            urdf.flush()
            return reference(dataclasses.replace(row, format="urdf"), Path(urdf.name), joints)
    if row.format == "mjcf":
        import mujoco_reference
        return mujoco_reference.Reference(path, joints, with_forces="forces" not in row.option)
    if row.format == "sdf" and row.code == "inertia-without-mass":
        raise Unloaded("Drake gives a link that has inertia and no mass a mass of 1 kg")
    if row.format == "sdf":
        import drake_reference
        return drake_reference.Reference(path, joints)
    if row.format == "urdf":
        import reference as pinocchio_reference
        model, error = pinocchio_reference.load(path, "floating" in row.option)
        if model is None:
            raise Unloaded(error.splitlines()[0])
        mimics = {} if "--mimic independent" in row.option else pinocchio_reference.followers(path)
        return pinocchio_reference.Reference(model, joints, mimics)
    raise Unloaded("nothing to compare with")


def compare(task):
    """Fills in the comparison of an accepted file, or whether the other library loads a refused MJCF."""
    row, path, states = task
    # The folder of the collection is one of this machine.
    root = str(path).removesuffix(row.file)
    is_accepted = row.verdict in ("accepted", "by an option")
    if not is_accepted and (row.verdict == "static" or row.format != "mjcf"):
        return row
    if not is_accepted:
        import mujoco
        try:
            model = mujoco.MjModel.from_xml_path(str(path))
            row.compared = "loads" if model.nv else "static"
        except ValueError:
            row.compared = "not loaded"
        return row
    try:
        interpreter = modyn.Interpreter(path, modyn.OPTIONS.get(row.option, []))
        row.joints = len(interpreter.joints)
        theirs = reference(row, path, interpreter.joints)
        random = numpy.random.default_rng(1)
        given = [theirs.random_state(random) for _ in range(states)]
        tolerance = MUJOCO_TOLERANCE if row.format == "mjcf" else TOLERANCE
        row.difference, agrees = 0.0, True
        if row.is_kinematic:
            for (q, qd, _), found in zip(given, interpreter.evaluate_kinematics(given), strict=True):
                right = theirs.kinematics(q, qd)
                scale = max(1.0, numpy.abs(right).max())
                row.difference = max(row.difference, float(numpy.abs(found - right).max() / scale))
            row.compared = "agrees" if row.difference <= tolerance else "DIFFERS"
            return row
        for state, ours in zip(given, interpreter.evaluate(given), strict=True):
            expected = theirs.evaluate(*state)
            condition = numpy.linalg.cond(expected[2])
            # Bias forces may be zero: they count relative to the inertial forces of an acceleration of 1 m/s^2, too.
            least = numpy.abs(expected[2]).max()
            for k, (found, right) in enumerate(zip(ours, expected)):
                scale = max(numpy.abs(right).max(), least if k == 1 else 1e-300)
                difference = float(numpy.abs(found - right).max() / scale)
                agrees &= difference <= tolerance * (condition if k == 0 else 1.0)
                if k > 0:
                    row.difference = max(row.difference, difference)
        if row.format == "mjcf":
            agrees &= loops_agree(interpreter, theirs, random)
        row.compared = "agrees" if agrees else "DIFFERS"
    except (Unloaded, NotImplementedError, KeyError, RuntimeError) as error:
        if row.format == "mjcf" and row.option and isinstance(error, Unloaded):
            row.verdict, row.option, row.compared = "refused", "", "not loaded"
            return row
        row.compared = f"not compared: {error}".replace(f"{path.parent}/", "").replace(root, "")[:200]
    except Exception as error:  # The table has the fault, and the exit code.
        row.compared = f"DIFFERS: {type(error).__name__}: {error}"[:300]
    return row


def loops_agree(interpreter, theirs, random):
    """Whether accelerations with closed loops agree, in the pose in which the model is drawn."""
    q, qd, tau = state = theirs.drawn_state(random)
    ours, = interpreter.evaluate_loops([state])
    if ours is None:
        return True
    free, _, matrix = theirs.evaluate(q, qd, tau)
    expected, displacement = theirs.closed(q, tau, free, matrix)
    scale = max(numpy.abs(free).max(), numpy.abs(expected).max())
    # Rows of a loop that is open in this pose differ to first order in its displacement.
    open_by = max(displacement, ours[1])
    allowed = LOOP_TOLERANCE + 1e3 * open_by
    return abs(ours[1] - displacement) <= 1e-6 + open_by and numpy.abs(ours[0] - expected).max() <= allowed * scale


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", metavar="NAME=FOLDER", help="further collections")
    parser.add_argument("--only", default="", help="files whose path contains this; the tables go to the terminal")
    parser.add_argument("--states", type=int, default=10, help="random states (default: 10)")
    parser.add_argument("--jobs", type=int, default=2, help="files at a time (default: 2)")
    options = parser.parse_args()
    start = time.monotonic()
    modyn.build()
    folder = modyn.ROOT / "target" / "robots" / "collections"
    folder.mkdir(parents=True, exist_ok=True)
    collections = {} if options.only and options.folders else fetch(folder)
    for given in options.folders:
        name, _, place = given.partition("=")
        collections[name] = Path(place).resolve()
    tasks = [(*found, options.states) for name, place in sorted(collections.items())
             for found in checked(name, place) if options.only in str(found[1])]
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
        rows = list(pool.map(compare, tasks, chunksize=4))
    for name, text in table.collections(rows, time.monotonic() - start).items():
        if options.only:
            print(text)
        else:
            (modyn.ROOT / "docs" / "data" / f"{name}.tsv").write_text(text)
    wrong = [f"{row.collection}/{row.file}: {row.compared}" for row in rows if row.compared.startswith("DIFFERS")]
    if wrong:
        sys.exit("\n".join(["differs:", *wrong]))


if __name__ == "__main__":
    main()
