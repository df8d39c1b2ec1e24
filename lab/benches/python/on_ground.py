"""Steps of robots on the ground, f64: a quadruped on four feet and a humanoid on eight points, beside MuJoCo.

    lab/benches/python/run ground | lab/record "lab/benches/python/run ground" > docs/data/ground-speed.tsv

Each robot stands, is pushed, and falls on the ground, by the same constant torques in both. MuJoCo has the settings that its users
have: its default solver and contacts, `implicitfast`, steps of 2 ms, elliptic or pyramidal cones. Motions of 50 steps are one call
in both: `mujoco.rollout`, and `Robot.rollout` with `step="step"`, whose law and settings are MuJoCo's. Times are those of one step, the least of several runs; the
quotient is that to MuJoCo with pyramids, its default, which modyn has, too. `solved` are the motions in which modyn's residual is below its
tolerance in all steps.

The rows `A and B` have the matrices of one step, from the first states of the motions: `Robot.step_derivatives`, exact, for many
states in one call, and `mujoco.mjd_transitionFD`, one-sided differences, state by state. The latter has A alone, since the
models have no actuators.
"""

import os
import sys
import time
from pathlib import Path

import mujoco
import mujoco.rollout
import numpy as np

import modyn

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "lab/golden"))
import standing  # noqa: E402

STEPS, DT, MOTIONS, RUNS, TOLERANCE = 50, 0.002, 128, 5, 1e-8
ROBOTS = {"quadruped, four feet": ("quadruped.urdf", standing.FEET), "humanoid, eight points": ("humanoid.urdf", standing.SOLES)}


def worlds(file, points):
    """Returns MuJoCo's model with its users' settings, modyn's robot, and the posture: bent legs, the lowest point on the ground."""
    world = standing.World(ROOT / "robots" / file, points, 0.8)
    model = world.model
    model.opt.timestep, model.opt.tolerance, model.opt.impratio = DT, 1e-8, 1.0
    model.opt.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
    model.geom_solref[:], model.geom_solimp[:] = [0.02, 1], [0.9, 0.95, 0.001, 0.5, 2]
    bends = {"hip_pitch": -0.2, "knee": 0.42, "ankle_pitch": -0.22}
    posture = [next((bend for part, bend in bends.items() if part in joint.name), 0.0) for joint in world.joints]
    if file == "quadruped.urdf":
        posture = [[0.0, 0.6, -1.2][k % 3] * (1 if k < 6 else -1) for k in range(12)]
    world.place_at(posture, 0.0)
    contacts = {name: ("point", link, list(place)) for name, (link, place) in points.items()}
    robot = modyn.load(ROOT / "robots" / file, base="floating", contacts=contacts, joint_friction="none")
    return model, robot, world.data.qpos.copy()


def scenes(model, robot, qpos):
    """Returns the states and the torques of the motions by their names, in MuJoCo's order."""
    rng = np.random.default_rng(0)
    n, joints = MOTIONS, model.nv - 6
    q = np.repeat(qpos[None], n, 0)
    q[:, 7:] += 0.02 * rng.normal(size=(n, joints))
    still, torques = np.zeros((n, model.nv)), np.zeros((n, model.nv))
    # The torques that hold the posture, by modyn.
    convert = modyn.conventions.MuJoCo(robot, model)
    own = convert.from_qpos(qpos)
    found = robot.constrained_inverse_dynamics(own, np.zeros(robot.nv), np.zeros(robot.nv))
    torques[:] = convert.to_qfrc(own, found.tau)
    torques[:, :6] = 0
    pushed, high = still.copy(), q.copy()
    pushed[:, :2] = rng.normal(size=(n, 2))
    high[:, 2] += 0.05
    return {
        "stands": (q, still, torques),
        "pushed": (q, pushed, torques),
        "falls": (high, 0.3 * rng.normal(size=(n, model.nv)), 0.0 * torques),
    }


def differences(model, state):
    """Computes A of a step from each state by MuJoCo."""
    data, a = mujoco.MjData(model), np.zeros((2 * model.nv, 2 * model.nv))
    q, qd, tau = state
    for i in range(len(q)):
        data.qpos[:], data.qvel[:], data.qfrc_applied[:] = q[i], qd[i], tau[i]
        mujoco.mjd_transitionFD(model, data, 1e-6, False, a, None, None, None)


def least(call):
    """Returns the least time of several runs, s."""
    call()
    times = []
    for _ in range(RUNS):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)


def main():
    print("| robot | motion | motions | modyn, us | MuJoCo, pyramids, us | MuJoCo, ellipses, us | MuJoCo / modyn | solved, % |")
    print("|---|---|---|---|---|---|---|---|")
    for name, (file, points) in ROBOTS.items():
        model, robot, qpos = worlds(file, points)
        surface = modyn.ContactSurface(friction=0.8, radius=standing.RADIUS, translation=(0, 0, -standing.RADIUS))
        settings = modyn.StepSettings([surface] * len(points), tolerance=TOLERANCE)
        for motion, (q, qd, tau) in scenes(model, robot, qpos).items():
            convert = modyn.conventions.MuJoCo(robot, model)
            own_q = convert.from_qpos(q)
            own_qd = convert.from_qvel(own_q, qd)
            own_tau = np.repeat(convert.from_qfrc(own_q, tau)[:, None], STEPS, 1)
            control = np.repeat(tau[:, None], STEPS, 1)
            state = np.concatenate([np.zeros((MOTIONS, 1)), q, qd, np.zeros((MOTIONS, model.na))], 1)
            for label, count, threads in (("one motion", 1, 1), ("many, one core", MOTIONS, 1), ("many, all cores", MOTIONS, None)):
                modyn.set_threads(threads)
                own = lambda: robot.rollout(own_q[:count], own_qd[:count], own_tau[:count], DT, step="step", trajectory=False, settings=settings)
                solved = 100 * (own().residual <= TOLERANCE).mean()
                times = [least(own)]
                for cone in (mujoco.mjtCone.mjCONE_PYRAMIDAL, mujoco.mjtCone.mjCONE_ELLIPTIC):
                    model.opt.cone = cone
                    data = [mujoco.MjData(model) for _ in range(threads or len(os.sched_getaffinity(0)))]
                    with mujoco.rollout.Rollout(nthread=0 if len(data) == 1 else len(data)) as pool:
                        spec = mujoco.mjtState.mjSTATE_QFRC_APPLIED
                        times.append(least(lambda: pool.rollout(model, data, state[:count], control[:count], control_spec=int(spec))))
                times = [1e6 * x / (count * STEPS) for x in times]
                row = " | ".join(f"{x:.2f}" for x in times)
                print(f"| {name} | {motion} | {label} | {row} | {times[1] / times[0]:.1f} | {solved:.0f} |", flush=True)
            modyn.set_threads(1)
            derivatives = lambda: robot.step_derivatives(own_q, own_qd, own_tau[:, 0], DT, settings=settings)
            solved = 100 * (robot.step(own_q, own_qd, own_tau[:, 0], DT, settings=settings).residual <= TOLERANCE).mean()
            times = [least(derivatives)]
            for cone in (mujoco.mjtCone.mjCONE_PYRAMIDAL, mujoco.mjtCone.mjCONE_ELLIPTIC):
                model.opt.cone = cone
                times.append(least(lambda: differences(model, (q, qd, tau))))
            times = [1e6 * x / MOTIONS for x in times]
            row = " | ".join(f"{x:.2f}" for x in times)
            print(f"| {name} | {motion} | A and B, one core | {row} | {times[1] / times[0]:.1f} | {solved:.0f} |", flush=True)


if __name__ == "__main__":
    main()
