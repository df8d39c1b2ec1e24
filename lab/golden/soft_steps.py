"""Steps of MuJoCo with soft contacts, joint limits, dry friction and damping of joints: a quadruped on four feet and a humanoid
on eight points, from random states near the floor.

Each touching point is a sphere on a plane in general position. The law and its parameters are MuJoCo's defaults but for the
friction, dry friction and damping, which are random. MuJoCo solves to a tolerance far below its default.
"""

import mujoco
import numpy
import standing

STEP = 0.002
RADIUS = 0.011
STATES = 8
FLOOR = {"quaternion": tuple(standing.rotation([0.6, -0.8, 0.1], 0.3)), "place": (0.3, -0.2, 0.7)}
ROBOTS = {"quadruped": ("quadruped.urdf", standing.FEET), "humanoid": ("humanoid.urdf", standing.SOLES)}
CONES = {"pyramidal": mujoco.mjtCone.mjCONE_PYRAMIDAL, "elliptic": mujoco.mjtCone.mjCONE_ELLIPTIC}


def world(path, points):
    """The robot above the floor, with MuJoCo's default softness."""
    made = standing.World(path, points, 0.8, **FLOOR)
    model = made.model
    model.opt.timestep, model.opt.tolerance, model.opt.ls_tolerance = STEP, 0.0, 1e-10
    model.opt.iterations, model.opt.ls_iterations, model.opt.impratio = 200, 100, 1.5
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    model.geom_solref[:], model.geom_solimp[:] = [0.02, 1], [0.9, 0.95, 0.001, 0.5, 2]
    spheres = [model.geom(name).id for name in made.points]
    model.geom_size[spheres, 0] = RADIUS
    # The plane is `standing.RADIUS` below its place.
    model.geom("ground").pos[:] = made.place
    return made


def to_modyn(model, qpos, qvel):
    """Coordinates and velocities in modyn's order: quaternions x y z w, linear velocities in the axes of the base."""
    x, y, z, w, qx, qy, qz = qpos[:7]
    linear = standing.matrix(qpos[3:7]).T @ qvel[:3]
    return [x, y, z, qx, qy, qz, w, *qpos[7:]], [*linear, *qvel[3:]]


def states(name, path, points):
    rng = numpy.random.default_rng(5)
    made = world(path, points)
    model, data = made.model, made.data
    joints = range(1, model.njnt)
    # Narrow limits, so that random states are beyond some of them.
    model.jnt_limited[1:], model.jnt_range[1:] = 1, numpy.sort(rng.uniform(-0.8, 0.8, (model.nv - 6, 2)), axis=1)
    model.dof_frictionloss[6:] = rng.uniform(0.0, 0.4, model.nv - 6) * (rng.random(model.nv - 6) < 0.5)
    model.dof_damping[6:] = rng.uniform(0.0, 0.3, model.nv - 6)
    mujoco.mj_setConst(model, data)
    friction = [float(x) for x in rng.uniform(0.3, 1.2, len(made.points))]
    for point, coefficient in zip(made.points, friction):
        model.geom_friction[model.geom(point).id, 0] = coefficient
    model.geom_friction[model.geom("ground").id, 0] = 0.0
    bodies = [model.geom(point).bodyid[0] for point in made.points]
    found = {
        "robot": name, "step": STEP, "ratio": model.opt.impratio, "radius": RADIUS,
        "joints": [model.joint(j).name for j in joints],
        "floor": {"rotation": standing.matrix(numpy.array(FLOOR["quaternion"])).tolist(), "translation": list(FLOOR["place"])},
        "contacts": [{"name": point, "link": points[point][0], "position": list(points[point][1]), "friction": coefficient,
                      "mobility": float(model.body_invweight0[body, 0])}
                     for point, coefficient, body in zip(made.points, friction, bodies)],
        "range": model.jnt_range[1:].tolist(), "dry_friction": model.dof_frictionloss[6:].tolist(),
        "damping": model.dof_damping[6:].tolist(), "mobility": model.dof_invweight0[6:].tolist(),
        "gravity": model.opt.gravity.tolist(), "states": [],
    }
    for k in range(STATES):
        for cone, value in CONES.items():
            model.opt.cone = value
            mujoco.mj_resetData(model, data)
            # Half of the robots stand on several points, the others fall on one.
            stands = k % 2 == 0
            spin = rng.normal(size=3) * (0.02 if stands else 1.0)
            base = standing.rotation([0.6, -0.8, 0.1], 0.3) + numpy.array([0.0, *spin])
            data.qpos[3:7] = base / numpy.linalg.norm(base)
            data.qpos[7:] = rng.normal(size=model.nq - 7) * (0.03 if stands else 0.4)
            mujoco.mj_kinematics(model, data)
            depth = made.heights().min() - RADIUS + (0.03 if stands else 0.002) * rng.random()
            data.qpos[:3] -= depth * made.normal
            data.qvel[:] = rng.normal(size=model.nv) * (1.0 if k % 4 else 5.0)
            tau = rng.normal(size=model.nv - 6)
            q, qd = to_modyn(model, data.qpos, data.qvel)
            data.qfrc_applied[6:] = tau
            mujoco.mj_step(model, data)
            next_q, next_qd = to_modyn(model, data.qpos, data.qvel)
            found["states"].append({"cone": cone, "q": [float(x) for x in q], "qd": [float(x) for x in qd],
                                    "tau": [float(x) for x in tau], "next_q": [float(x) for x in next_q],
                                    "next_qd": [float(x) for x in next_qd], "contacts": int(data.ncon)})
    return found


def make(root):
    return [states(name, root / "robots" / file, points) for name, (file, points) in ROBOTS.items()]

