"""A quadruped trots over a step, controlled by sampling: model-predictive path integral control (MPPI) on the cores of a processor.

    python examples/mppi/walk.py            # 6 s of the motion, some 10 s on two cores

Each 20 ms the controller simulates 48 motions of 0.3 s on the ground, in one call. A motion follows a trot with offsets of the joint
angles; the offsets of the next motions are the mean of these, weighted by exp(-cost / temperature) (Williams, Aldrich and Theodorou
2017, "Model predictive path integral control"). The robot itself is simulated with steps of 1 ms.
"""

import argparse
import math
import time
from pathlib import Path

import numpy as np

import modyn

ROBOT = Path(__file__).resolve().parents[2] / "robots/quadruped.urdf"
FEET = [f"{end}_{side}_foot" for end in ("front", "hind") for side in ("left", "right")]
#: The length of a thigh and of a shank, the height of the hips above the ground, and that of the step, m.
LEG, HIP, STEP = 0.16, 0.24, 0.03
#: The period of the trot, s; its speed, m/s; the height to which a foot is lifted, m.
PERIOD, SPEED, LIFT = 0.4, 0.25, 0.06
SAMPLES, STEPS, DT, KNOTS = 48, 75, 0.004, 5
#: The time between two plans, and the steps of the simulation, s.
PLAN, FINE = 0.02, 0.001
NOISE, TEMPERATURE = 0.08, 0.1


def stairs():
    """Returns the ground: from x = 0.5 m on it is higher by STEP, within 1 cm."""
    heights = np.zeros((2, 300))
    heights[:, 101:] = STEP
    return modyn.HeightField(heights, origin=(-0.5, -5.0), spacing=(0.01, 10.0))


def trot(times):
    """Returns the joint angles of a trot, (n, 12)."""
    angles = []
    for leg in range(4):
        phase = 2 * ((times / PERIOD + (0.5 if leg in (1, 2) else 0.0)) % 1)
        length = SPEED * PERIOD / 2
        swings = phase < 1
        x = np.where(swings, -length / 2 * np.cos(math.pi * phase), length / 2 - length * (phase - 1))
        z = np.where(swings, LIFT * np.sin(math.pi * phase) ** 2, 0) - HIP
        bend = (1 if leg < 2 else -1) * np.arccos(np.hypot(x, z) / (2 * LEG))
        angles += [np.zeros_like(x), np.arctan2(-x, -z) + bend, -2 * bend]
    return np.stack(angles, -1)


class Controller:
    """MPPI of offsets to a trot."""

    def __init__(self, robot, on_ground):
        self.robot, self.on_ground = robot, on_ground
        self.rng = np.random.default_rng(0)
        self.offsets = np.zeros((KNOTS, 12))
        self.gains = np.zeros((robot.nv, 2 * robot.nv))
        self.gains[range(6, 18), range(6, 18)] = 12
        self.gains[range(6, 18), range(24, 36)] = 0.12
        self.steps = 0

    def plan(self, state, now):
        """Improves the offsets from a state on."""
        noise = NOISE * self.rng.normal(size=(SAMPLES, KNOTS, 12))
        noise[0] = 0
        offsets = self.offsets + noise
        motion = self.robot.rollout(
            *state, np.zeros((STEPS, 18)), DT, **self.on_ground, gains=self.gains, qd_ref=np.zeros(18),
            q_ref=self.references(offsets, now + DT * np.arange(1, STEPS + 1)),
        )
        self.steps += SAMPLES * STEPS
        cost = self.cost(motion, state[0], now) + 0.02 * (offsets**2).mean((1, 2)) / NOISE**2
        weights = np.exp((cost.min() - cost) / TEMPERATURE)
        self.offsets = np.einsum("n,nkj->kj", weights / weights.sum(), offsets)

    def references(self, offsets, times):
        """Returns the coordinates that motions follow, (n, steps, nq)."""
        at = np.linspace(0, KNOTS - 1, len(times))
        left = np.minimum(at.astype(int), KNOTS - 2)
        part = (at - left)[:, None]
        smooth = offsets[..., left, :] * (1 - part) + offsets[..., left + 1, :] * part
        q = np.zeros((*offsets.shape[:-2], len(times), self.robot.nq))
        q[..., 6] = 1
        q[..., 7:] = trot(times) + smooth
        return q

    def cost(self, motion, start, now):
        """Returns the cost of each motion: the way, the height, the tilt and the heading of the trunk."""
        x, y, z = np.moveaxis(motion.q[..., :3], -1, 0)
        wanted = SPEED * (now + DT * STEPS)
        ground = STEP * np.clip((x - 0.5) / 0.1 + 0.5, 0, 1)
        qx, qy, qz, qw = np.moveaxis(motion.q[..., 3:7], -1, 0)
        tilt, heading = qx**2 + qy**2, 2 * (qx * qy + qz * qw)
        whole = 400 * (z - HIP - ground) ** 2 + 30 * tilt + 3 * heading**2 + 10 * y**2
        return whole.mean(-1) + 10 * np.abs(x[:, -1] - wanted)

    def advance(self, times):
        """Moves the offsets on by the time of a plan."""
        at = np.arange(KNOTS) + PLAN / (DT * STEPS) * (KNOTS - 1)
        self.offsets = np.stack([np.interp(at, np.arange(KNOTS), own) for own in self.offsets.T], -1)


def walk(seconds, watch=lambda motion: None):
    """Walks for a time; returns the last coordinates and velocities. `watch` gets each part of the motion, in steps of FINE."""
    robot = modyn.load(ROBOT, base="floating", contacts={foot: ("point", foot, [0, 0, 0]) for foot in FEET})
    settings = robot.step_settings()
    settings.tolerance = 1e-6
    on_ground = {"step": "step", "settings": settings, "ground": stairs()}
    controller = Controller(robot, on_ground)
    q = robot.neutral()
    q[7:] = trot(np.zeros(1))[0]
    q[2] -= min(robot.link_pose(q, foot).translation[2] for foot in FEET)
    state, spent = (q, np.zeros(18)), 0.0
    for k in range(round(seconds / PLAN)):
        now, start = k * PLAN, time.perf_counter()
        controller.plan(state, now)
        spent += time.perf_counter() - start
        # The robot itself.
        times = now + FINE * np.arange(1, round(PLAN / FINE) + 1)
        references = controller.references(controller.offsets, now + DT * np.arange(1, STEPS + 1))
        own = np.stack([np.interp(times, now + DT * np.arange(1, STEPS + 1), angle) for angle in references.T], -1)
        last = robot.rollout(
            *state, np.zeros((len(times), 18)), FINE, **on_ground, gains=controller.gains, q_ref=own, qd_ref=np.zeros(18),
        )
        watch(last)
        state = last.q[-1], last.qd[-1]
        controller.advance(times)
        if k % 25 == 0:
            x, y, z = last.q[-1, :3]
            print(f"{now + PLAN:5.2f} s: {x:5.2f} m along, {y:5.2f} m aside, {z:.3f} m high; {controller.steps / spent:,.0f} steps/s", flush=True)
    print(f"{controller.steps:,} steps on the ground in {spent:.2f} s: {controller.steps / spent:,.0f} steps/s")
    return state


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=6.0)
    walk(parser.parse_args().seconds)
