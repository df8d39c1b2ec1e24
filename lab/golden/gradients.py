"""Derivatives of steps by MJX's forward mode: a random robot on slides and hinges over a plane, with contacts of one to six components, joint
limits, dry friction and damping. The cones are pyramids: with elliptic cones, derivatives of MJX 3.17.0 are NaN. MJX compiles for minutes.
"""

import floors
import jax
import mujoco
import numpy
import standing
from mujoco import mjx

STEP = 0.002
STATES = 3
#: The largest difference between a step of MJX and a step of MuJoCo.
AGREEMENT = 1e-9
#: The kinds of geoms of the limbs, whose contacts with a plane MJX computes as MuJoCo does.
KINDS = ("sphere", "capsule")


def scene(rng):
    """The text of a robot over a plane: a body on three slides and three hinges, and two limbs."""
    axes = "1 0 0", "0 1 0", "0 0 1"
    base = "".join(f'<joint type="{kind}" axis="{axis}" damping="0.1"/>' for kind in ("slide", "hinge") for axis in axes)
    limbs = "".join(f"<body name='limb{i}' pos='{floors.numbers(rng.uniform(-0.2, 0.2, 3))}' {floors.turned(rng)}>"
                    f"{floors.joint(rng)}{floors.geom(rng, kind)}</body>" for i, kind in enumerate(KINDS))
    floor = (f'<geom name="floor" type="plane" size="0 0 1" quat="{floors.numbers(standing.rotation(rng.normal(size=3), 0.3))}" '
             f'contype="1" conaffinity="2" {floors.contact(rng)}/>')
    return (f'<mujoco model="gradient 0"><compiler angle="radian"/><option impratio="{floors.numbers(rng.uniform(0.5, 4))}" '
            f'timestep="{STEP}"/><worldbody>{floor}<body name="base">{base}{floors.geom(rng, KINDS[0])}{limbs}</body></worldbody>'
            "</mujoco>")


def steps(model):
    """The end of a step, and its derivatives with respect to coordinates, velocities and forces, compiled."""
    compiled = mjx.put_model(model)
    start = mjx.put_data(model, mujoco.MjData(model))

    def step(q, qd, tau):
        end = mjx.step(compiled, start.replace(qpos=q, qvel=qd, qfrc_applied=tau))
        return jax.numpy.concatenate([end.qpos, end.qvel])

    return jax.jit(step), jax.jit(jax.jacfwd(step, argnums=(0, 1, 2)))


def robot(rng):
    text = scene(rng)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    model.opt.tolerance, model.opt.ls_tolerance = 0.0, 1e-12
    model.opt.iterations, model.opt.ls_iterations = 100, 50
    step, derivatives = steps(model)
    found = {"mjcf": text, "step": STEP, "states": []}
    while len(found["states"]) < STATES:
        mujoco.mj_resetData(model, data)
        data.qpos[:] = rng.normal(size=model.nq) * 0.2
        data.qvel[:] = rng.normal(size=model.nv)
        data.qfrc_applied[:] = rng.normal(size=model.nv)
        given = [numpy.array(x) for x in (data.qpos, data.qvel, data.qfrc_applied)]
        mujoco.mj_step(model, data)
        end = numpy.concatenate([data.qpos, data.qvel])
        if data.ncon == 0 or numpy.abs(step(*given) - end).max() > AGREEMENT:
            continue
        names = "dq", "dqd", "dtau"
        matrices = {name: numpy.array(matrix).tolist() for name, matrix in zip(names, derivatives(*given))}
        found["states"].append({"q": given[0].tolist(), "qd": given[1].tolist(), "tau": given[2].tolist(), **matrices})
    return found


def make(_root):
    jax.config.update("jax_enable_x64", True)
    return [robot(numpy.random.default_rng(17))]
