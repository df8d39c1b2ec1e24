"""Steps of an MJCF in MuJoCo, for `modyn compare --mujoco`. The argument is the path of the MJCF.

Prints a description of the model as a line of JSON, reads states as a line, and prints the motions from these states as a line.
"""

import json
import sys

try:
    import mujoco
except ImportError:
    sys.exit(3)


def describe(model):
    """Returns the joints, the actuators and the settings of the model."""
    joints = [model.joint(i) for i in range(model.njnt)]
    option, name = model.opt, lambda value: value.name.split("_", 1)[1]
    return {
        "version": mujoco.__version__,
        "joints": [[joint.name, int(joint.type[0]), int(joint.qposadr[0]), int(joint.dofadr[0])] for joint in joints],
        "sizes": [model.nq, model.nv],
        "actuators": [model.actuator(i).name for i in range(model.nu)],
        "activations": model.na,
        "start": list(model.key_qpos[0] if model.nkey else model.qpos0),
        "timestep": option.timestep,
        "solver": name(mujoco.mjtSolver(option.solver)),
        "iterations": option.iterations,
        "tolerance": option.tolerance,
        "integrator": name(mujoco.mjtIntegrator(option.integrator)),
        "noslip_iterations": option.noslip_iterations,
    }


def solve_to_the_end(option):
    """Lets MuJoCo's Newton method solve each step to the end, by an integrator that modyn has, and without sweeps for friction."""
    option.solver, option.iterations, option.ls_iterations = mujoco.mjtSolver.mjSOL_NEWTON, 300, 100
    option.tolerance, option.ls_tolerance, option.noslip_iterations = 0, 1e-12, 0
    euler, fast = mujoco.mjtIntegrator.mjINT_EULER, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # modyn has `implicitfast` in place of `implicit`, and `Euler` in place of `RK4`.
    option.integrator = fast if option.integrator in (fast, mujoco.mjtIntegrator.mjINT_IMPLICIT) else euler


def left_out(model, contact):
    """Returns the names of a contact's shapes; `None` for a contact of a moving link with a plane of the world, which modyn has."""
    bodies = [model.geom_bodyid[geom] for geom in contact.geom]
    still = [model.body_weldid[body] == 0 for body in bodies]
    plane = [model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE for geom in contact.geom]
    if any(still[k] and plane[k] and not still[1 - k] for k in (0, 1)):
        return None
    return [model.geom(geom).name or model.body(body).name for geom, body in zip(contact.geom, bodies)]


def motion(model, state, steps):
    """Returns for the first step and for the last one the velocities after it, and the shapes of contacts that modyn leaves out."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.ctrl[:], data.act[:] = (state[name] for name in ("qpos", "qvel", "ctrl", "act"))
    warnings = [mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC]
    pairs, ends, contacts = set(), [], 0
    for step in range(1, steps + 1):
        mujoco.mj_step(model, data)
        found = (left_out(model, data.contact[k]) for k in range(data.ncon))
        pairs |= {tuple(sorted(pair)) for pair in found if pair}
        contacts = data.ncon if step == 1 else contacts
        if step in (1, steps):
            diverged = any(data.warning[warning].number for warning in warnings)
            ends.append({"qvel": None if diverged else list(data.qvel), "left_out": sorted(pairs)})
    return {"contacts": contacts, "ends": ends}


def main():
    # MuJoCo writes its warnings to a file in the current folder, unless they are taken.
    mujoco.set_mju_user_warning(lambda message: None)
    try:
        model = mujoco.MjModel.from_xml_path(sys.argv[1])
    except ValueError as error:
        print(json.dumps({"error": str(error)}))
        return
    print(json.dumps(describe(model)), flush=True)
    given = json.loads(sys.stdin.readline())
    if not given["actuated"]:
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    as_described = [motion(model, state, given["steps"]) for state in given["states"]]
    solve_to_the_end(model.opt)
    solved = [motion(model, state, given["steps"]) for state in given["states"]]
    print(json.dumps({"solved": solved, "as_described": as_described}))


main()
