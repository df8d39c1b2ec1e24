"""Makes the reference data of tests/golden with Pinocchio, and of steps on planes with MuJoCo: see the README there.

The robots taken from elsewhere keep their states, which are read from their files; all quantities are computed
anew. The random mechanisms, the loops and their states come from seeds. With the versions of requirements.txt the
files come out byte for byte, up to last digits that numpy rounds differently on other processors.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy
import pinocchio

import actuated
import actuators
import contacts
import displacements
import floors
import gradients
import hessians
import loops
import mechanisms
import soft_steps
import urdf
from coordinates import Coordinates, moved
from quantities import Same, evaluate

ROOT = Path(__file__).resolve().parents[2]
GOLDEN = ROOT / "tests" / "golden"
ROBOTS = ["double_pendulum", "double_pendulum_continuous", "ur5", "panda", "panda_fingers", "solo12", "solo12_ff",
          "g1", "g1_ff"]
#: States of a tree, and of a mechanism with a loop.
STATES, CLOSED_STATES = 2, 4
#: The regressor is stored for robots with at most that many velocities, at their last states.
SHORT = 9
#: Of the checks below.
AGREEMENT = 1e-8
#: Of derivatives along motions of closed loops and differences of fourth order, whose step is 5e-4.
DIFFERENCES = 1e-6


def plain(value):
    """For JSON."""
    if isinstance(value, dict):
        return {key: plain(part) for key, part in value.items()}
    if isinstance(value, numpy.ndarray):
        return value.tolist()
    return value


def relative(found, expected):
    return float(numpy.abs(found - expected).max() / max(1.0, numpy.abs(expected).max()))


def wrenches(links, random):
    """A wrench on each link, force first; short numbers."""
    return {link: random.uniform(-20, 20, 6).round(2).tolist() for link in links}


def robot(name):
    """The file of a robot from elsewhere with its states as they are."""
    data = json.loads((GOLDEN / f"{name}.json").read_text())
    root = [pinocchio.JointModelFreeFlyer()] if data["floating_base"] else []
    model = pinocchio.buildModelFromUrdf(str(GOLDEN / data["urdf"]), *root)
    links = [frame.name for frame in model.frames if frame.type == pinocchio.FrameType.BODY]
    random = numpy.random.default_rng(7)
    turned = {joint: numpy.eye(3) for joint in range(1, model.njoints)}
    for number, state in enumerate(data["states"]):
        state["wrenches"] = wrenches(links, random)
        frames = list(state["frames"])
        regressor = number == len(data["states"]) - 1 and model.nv <= SHORT
        state.update(plain(evaluate(model, turned, frames, Same(model, state["q"]), state, regressor)))
    return data


def configuration(model, random):
    """A random one in modyn's coordinates."""
    parts = []
    for joint in list(model.joints)[1:]:
        part = random.uniform(-2, 2, joint.nv if joint.shortname() == "JointModelPlanar" else joint.nq)
        if joint.nq > joint.nv and len(part) == joint.nq:
            part[-4:] /= numpy.linalg.norm(part[-4:])
        parts.append(part)
    return numpy.concatenate(parts)


def mechanism(name):
    """The file of a random tree; its derivatives, which go through the coordinates, are checked by differences."""
    made = urdf.parse((GOLDEN / f"{name}.urdf").read_text())
    model = made.model
    random = numpy.random.default_rng(mechanisms.TREES[name][0] + 100)
    states, worst = [], 0.0
    for number in range(STATES):
        start = configuration(model, random)
        v, tau, a = (random.uniform(-size, size, model.nv) for size in (1.5, 10.0, 3.0))
        state = {"q": start, "v": v, "tau": tau, "a": a, "wrenches": wrenches(made.links[1:], random)}

        def at_state(q, v):
            return evaluate(model, made.turned, [], Coordinates(model, q), {**state, "v": v})

        found = evaluate(model, made.turned, made.links[1:], Coordinates(model, start), state, number == STATES - 1)
        for key, of in (("dqdd_dq", "qdd"), ("dtau_dq", "tau_rnea"), ("dqdd_dv", "qdd"), ("dtau_dv", "tau_rnea")):
            columns = []
            for unit in numpy.eye(model.nv):
                def slope(step):
                    ahead, back = ((moved(model, start, s * unit), v) if key.endswith("dq") else (start, v + s * unit)
                                   for s in (step, -step))
                    return (at_state(*ahead)[of] - at_state(*back)[of]) / (2 * step)
                near, far = slope(1e-4), slope(2e-4)
                columns.append(near + (near - far) / 3)
            worst = max(worst, relative(numpy.array(columns).T, found[key]))
        worst = max(worst, relative(found["M"] @ found["qdd"] + found["nle"], tau))
        states.append(plain({**state, **found}))
    if worst > AGREEMENT:
        sys.exit(f"{name}: Pinocchio disagrees with itself by {worst:e}")
    return {"robot": name, "urdf": f"{name}.urdf", "coordinates": "modyn", "floating_base": False,
            "gravity": [0.0, 0.0, -9.81], "moving_links": made.moving,
            "states": states, "generator": f"pinocchio {pinocchio.__version__}"}


def loop(name):
    """The file of a mechanism with a loop, checked by the dense solution."""
    made = urdf.parse((GOLDEN / f"{name}.urdf").read_text())
    closed = loops.Closed(made)
    random, directions = numpy.random.default_rng(11), numpy.random.default_rng(12)
    states, worst = [], 0.0
    for _ in range(CLOSED_STATES):
        q, v, rank = closed.closed_state(random, 1.0)
        tau = random.uniform(-5, 5, closed.model.nv)
        qdd, difference = closed.accelerations(q, v, tau)
        dq, dv, dqdd = closed.along(q, v, tau, directions)
        state = {"q": q, "v": v, "tau": tau, "qdd": qdd, "rank": rank, "along_q": dq, "along_v": dv, "along_qdd": dqdd}
        if all(rigid for rigid, _ in closed.frames):
            by = closed.derivatives(q, v, tau)
            state.update(zip(("dqdd_dq", "dqdd_dv", "dqdd_dtau"), by))
            along = relative(by[0] @ dq + by[1] @ dv, dqdd)
            if along > DIFFERENCES:
                sys.exit(f"{name}: Pinocchio's derivatives differ from differences by {along:e}")
        worst = max(worst, difference)
        states.append(plain(state))
    if worst > AGREEMENT:
        sys.exit(f"{name}: Pinocchio differs from the dense solution by {worst:e}")
    print(f"{name}: within {worst:.0e} of the dense solution")
    return {"robot": name, "urdf": f"{name}.urdf", "coordinates": "modyn", "floating_base": False,
            "gravity": [0.0, 0.0, -9.81], "states": states, "generator": f"pinocchio {pinocchio.__version__}"}


def standing(name):
    """The file of a floating robot with contacts, checked by dense solutions and by differences."""
    source, on_links, _ = contacts.ROBOTS[name]
    states, worst = contacts.states(name, GOLDEN)
    if worst > AGREEMENT:
        sys.exit(f"{name}: Pinocchio differs from the checks by {worst:e}")
    print(f"{name}: within {worst:.0e} of dense solutions and differences")
    order = json.loads((GOLDEN / f"{source}_ff.json").read_text())["joint_order"]
    return {"robot": name, "urdf": f"{source}.urdf", "floating_base": True, "joint_order": order,
            "gravity": [0.0, 0.0, -9.81], "contacts": [vars(contact) for contact in on_links],
            "restitution": contacts.RESTITUTION, "states": [plain(state) for state in states],
            "generator": f"pinocchio {pinocchio.__version__}"}


def files():
    """Returns, by name, the functions that make the texts of the files."""
    def text(value):
        return json.dumps(value, separators=(",", ":")) + "\n"

    for name in ROBOTS:
        yield f"{name}.json", lambda name=name: text(robot(name)).rstrip("\n")
    for name in mechanisms.TREES:
        yield f"{name}.urdf", lambda name=name: mechanisms.tree(name)
        yield f"{name}.json", lambda name=name: text(mechanism(name))
    yield "displacements.json", lambda: text(displacements.displacements())
    yield "hessians.urdf", hessians.tree
    yield "hessians.json", lambda: text(hessians.hessians(hessians.tree()))
    four_bar = (ROOT / "robots" / "four_bar.urdf").read_text()
    yield "four_bar_general.urdf", lambda: loops.in_general_position(four_bar, 8)
    yield "four_bar_general.json", lambda: text(loop("four_bar_general"))
    for name in mechanisms.LOOPS:
        yield f"{name}.urdf", lambda name=name: mechanisms.loop(name)
        yield f"{name}.json", lambda name=name: text(loop(name))
    for name in contacts.ROBOTS:
        yield f"{name}.json", lambda name=name: text(standing(name))
    yield "floors.json", lambda: json.dumps(floors.make(ROOT)) + "\n"
    yield "gradients.json", lambda: json.dumps(gradients.make(ROOT)) + "\n"
    yield "actuated.json", lambda: json.dumps(actuated.make(ROOT)) + "\n"
    yield "actuators.json", lambda: json.dumps(actuators.make(ROOT)) + "\n"
    yield "soft_steps.json", lambda: json.dumps(soft_steps.make(ROOT)) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="files whose name has this in it")
    parser.add_argument("--check", action="store_true", help="write nothing; fail where a file would change")
    options = parser.parse_args()
    changed = []
    for name, make in files():
        if options.only not in name:
            continue
        path, text = GOLDEN / name, make()
        if not path.exists() or path.read_text() != text:
            changed.append(name)
            if not options.check:
                path.write_text(text)
    print("changed:", ", ".join(changed) or "nothing")
    if options.check and changed:
        sys.exit(1)


if __name__ == "__main__":
    main()
