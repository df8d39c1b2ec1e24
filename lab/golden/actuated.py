"""Steps of MuJoCo under controls, by each integrator: the robots of `floors.py` with the actuators of `actuators.py`.

There are robots of each kind: with closed loops, with tendons and couplings, and with further free bodies. Of these, some are
rigid bodies alone, one has a body that is fixed to it, and one has armature and damping.
"""

import re

import actuators
import floors
import mujoco
import numpy
import standing

STEP = 0.002
#: The robots of `floors.py`: some without loops and tendons, with loops, with tendons and couplings of high degrees.
KINDS = [*range(1, 6), *range(25, 28), *range(33, 41)]
STATES = 4
INTEGRATORS = ("Euler", "implicitfast")
#: Robots of `floors.py` by `Euler` with the flag `eulerdamp` disabled.
EXPLICIT = (2, 26, 34)


def limited(rng, text):
    """The text with limits of the sums of actuator forces on some joints and tendons, which contain zero, and names of all joints."""
    joints = []

    def joint(found):
        joints.append(f"j{len(joints)}")
        limit = f'actuatorfrcrange="{floors.numbers([-rng.uniform(1, 8), rng.uniform(1, 8)])}" ' * (rng.random() < 0.3)
        return f'<joint name="{joints[-1]}" {limit}type='

    def tendon(found):
        limit = f' actuatorfrcrange="{floors.numbers([-rng.uniform(0.5, 4), rng.uniform(0.5, 4)])}"' * (rng.random() < 0.5)
        return found[0] + limit

    text = re.sub(r'<joint (name="j\d+" ref="[^"]*" springref="[^"]*" )?type=(?="(hinge|slide))', joint, text)
    return re.sub(r'<fixed name="t\d"', tendon, text), joints


def bodies(rng, k):
    """Further free bodies."""
    geom = lambda i: floors.geom(rng, floors.KINDS[(k + i) % len(floors.KINDS)])
    fixed = f'<body pos="{floors.numbers(rng.uniform(-0.1, 0.1, 3))}">{geom(2)}</body>'
    damped = f'<joint type="free" damping="{floors.numbers(rng.uniform(0, 0.5))}" armature="{floors.numbers(rng.uniform(0, 0.2))}"/>'
    joint, inner = [("<freejoint/>", ""), (damped, ""), ("<freejoint/>", "<body/>"), ("<freejoint/>", fixed)][k % 4]
    return f"<body><freejoint/>{geom(0)}</body><body>{joint}{geom(1)}{inner}</body>"


def scene(rng, k, kind, integrator, flags=""):
    text, joints = limited(rng, floors.scene(rng, kind))
    maker = actuators.Maker(rng, joints, ["t0", "t1"] if "<tendon>" in text else [])
    head = f'<option integrator="{integrator}" actuatorgroupdisable="{rng.integers(1, 4)}" '
    text = text.replace("<option ", head).replace("</option>", "</option>" + maker.classes())
    if rng.random() < 0.2:
        flag = '<flag clampctrl="disable" '
        text = text.replace("<flag ", flag) if "<flag " in text else text.replace("</option>", flag + "/></option>")
    if flags:
        text = text.replace("<flag ", f"<flag {flags} ") if "<flag " in text else text.replace("</option>", f"<flag {flags}/></option>")
    others = bodies(rng, k) if k % 3 == 0 else ""
    text = text.replace("</worldbody>", others + "</worldbody>")
    return text.replace("</mujoco>", f"<actuator>{maker.section()}</actuator></mujoco>")


def to_modyn(model, qpos, qvel):
    """Coordinates and velocities in modyn's order: quaternions x y z w, linear velocities of free bodies in their axes."""
    q, qd = [], []
    for kind, at, dof in zip(model.jnt_type, model.jnt_qposadr, model.jnt_dofadr):
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            w, x, y, z = qpos[at + 3:at + 7]
            q += [*qpos[at:at + 3], x, y, z, w]
            qd += [*(standing.matrix(qpos[at + 3:at + 7]).T @ qvel[dof:dof + 3]), *qvel[dof + 3:dof + 6]]
        else:
            q.append(qpos[at])
            qd.append(qvel[dof])
    return [float(x) for x in q], [float(x) for x in qd]


def place(rng, model, data):
    """Sets a random state near the floor."""
    axes = standing.matrix(model.geom("floor").quat)
    data.qpos[:] = rng.normal(size=model.nq) * 0.3
    data.qvel[:] = rng.normal(size=model.nv)
    for kind, at, dof in zip(model.jnt_type, model.jnt_qposadr, model.jnt_dofadr):
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            data.qpos[at:at + 3] = model.geom("floor").pos + axes @ [*rng.uniform(-0.2, 0.2, 2), rng.uniform(0.0, 0.3)]
            turn = rng.normal(size=4)
            data.qpos[at + 3:at + 7] = turn / numpy.linalg.norm(turn)
            data.qvel[dof + 3:dof + 6] *= 4
    data.ctrl[:], data.act[:] = 2 * rng.normal(size=model.nu), rng.normal(size=model.na)


def robot(rng, k, kind, integrator, flags=""):
    text = scene(rng, k, kind, integrator, flags)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    model.opt.timestep, model.opt.tolerance, model.opt.ls_tolerance = STEP, 0.0, 1e-12
    model.opt.iterations, model.opt.ls_iterations = 300, 100
    found = {"mjcf": text, "step": STEP, "states": []}
    while len(found["states"]) < STATES:
        mujoco.mj_resetData(model, data)
        place(rng, model, data)
        free = [kind == mujoco.mjtJoint.mjJNT_FREE for kind in model.jnt_type[model.dof_jntid]]
        data.qfrc_applied[:] = numpy.where(free, 0.0, rng.normal(size=model.nv))
        q, qd = to_modyn(model, data.qpos, data.qvel)
        given = {"q": q, "qd": qd, "ctrl": data.ctrl.tolist(), "act": data.act.tolist(), "applied": data.qfrc_applied.tolist()}
        mujoco.mj_step(model, data)
        # A velocity gain that accelerates makes MuJoCo's matrix indefinite where the inertia is small.
        if data.ncon == 0 or (data.qHDiagInv < 0).any():
            continue
        next_q, next_qd = to_modyn(model, data.qpos, data.qvel)
        after = {"next_q": next_q, "next_qd": next_qd, "next_act": data.act.tolist()}
        found["states"].append({**given, **after, "contacts": int(data.ncon), "rows": int(data.nefc)})
    return found


def make(_root):
    rng = numpy.random.default_rng(17)
    implicit = [robot(rng, k, kind, INTEGRATORS[k % 2]) for k, kind in enumerate(KINDS)]
    return implicit + [robot(rng, k, kind, "Euler", 'eulerdamp="disable"') for k, kind in enumerate(EXPLICIT)]
