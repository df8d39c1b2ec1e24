"""Walks with a trained policy in MuJoCo, on the same file: whether modyn's motion is the same, and which velocities are reached.

    python examples/walk/evaluate.py policy.npz --animation walk.html
"""

import argparse

import jax
import mujoco
import numpy as np

jax.config.update("jax_enable_x64", True)

from environment import ACTION, ASKED, CONTROL, FEET, FREQUENCY, ROBOT, STEPS, Walk  # noqa: E402
from modyn.conventions import MuJoCo  # noqa: E402
from train import load, output  # noqa: E402


class Simulation:
    """MuJoCo under the actions of the environment, with the file's friction and without loads, delays and pushes."""

    def __init__(self, environment):
        self.stand = np.asarray(environment.stand)
        self.model = mujoco.MjModel.from_xml_path(str(ROBOT))
        # The solution of the same problem as exactly as modyn's in double precision.
        self.model.opt.tolerance, self.model.opt.ls_tolerance, self.model.opt.iterations = 1e-14, 1e-10, 100
        self.data = mujoco.MjData(self.model)
        self.theirs = MuJoCo(environment.robot, self.model)
        self.feet = [self.model.geom(foot).id for foot in FEET]

    def start(self, state):
        mujoco.mj_resetData(self.model, self.data)
        q, qd = np.asarray(state.q[0]), np.asarray(state.qd[0])
        self.data.qpos[:], self.data.qvel[:] = self.theirs.to_qpos(q), self.theirs.to_qvel(q, qd)

    def advance(self, state, action):
        """Returns the state after an action, and which feet touched the ground in each step, (steps, 4)."""
        self.data.ctrl[:] = self.stand[7:] + ACTION * np.asarray(action[0])
        touching = []
        for _ in range(STEPS):
            mujoco.mj_step(self.model, self.data)
            pairs = {int(geom) for geom in self.data.contact.geom.ravel()}
            touching.append([foot in pairs for foot in self.feet])
        q = self.theirs.from_qpos(self.data.qpos)
        qd = self.theirs.from_qvel(q, self.data.qvel)
        after = state._replace(q=q[None], qd=qd[None], action=action, phase=(state.phase + FREQUENCY * CONTROL) % 1)
        return after, np.array(touching)


def walk(act, state, advance, seconds):
    """Returns the states after each action, stacked, and which feet touched the ground in each step, (steps, 4)."""
    states, touching = [], []
    for _ in range(round(seconds / CONTROL)):
        state, touched = advance(state, act(state))
        states.append(state)
        touching.append(np.reshape(touched, (STEPS, 4)))
    return jax.tree.map(lambda *x: np.stack(x)[:, 0], *states), np.concatenate(touching)


def report(states, touching):
    """Returns cells of the table: the velocities and the height without the first third, the touchdowns of a foot per second, the falls."""
    q, qd = (x[len(states.q) // 3 :] for x in (states.q, states.qd))
    forwards, left, turn = qd[:, [0, 1, 5]].mean(0)
    touchdowns = (~touching[:-1] & touching[1:]).sum(0) / (len(states.q) * CONTROL)
    fell = "yes" if states.q[:, 2].min() < 0.12 else "no"
    return f"{forwards:.2f}, {left:.2f}, {turn:.2f} | {q[:, 2].mean():.3f} | {touchdowns.min():.1f} to {touchdowns.max():.1f} | {fell}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("policy")
    parser.add_argument("--seconds", type=float, default=10.0, help="the time of each walk")
    parser.add_argument("--animation", help="write a page that shows the robot walk in MuJoCo at 1 m/s")
    given = parser.parse_args()
    environment = Walk(scalar="f64", randomize=False)
    worlds, actor = environment.worlds(0, 1), load(given.policy)
    act = jax.jit(lambda state: output(actor, environment.observe(worlds, state).actor))
    advance = jax.jit(lambda state, action: environment.advance(worlds, state, action))
    simulation = Simulation(environment)

    def first(command):
        state = environment.start(environment.stand[None], np.zeros((1, environment.robot.nv)))
        state = state._replace(command=np.array([command], float))
        simulation.start(state)
        return state

    ours, _ = walk(act, first((0.5, 0, 0.3)), advance, 1.0)
    theirs, _ = walk(act, first((0.5, 0, 0.3)), simulation.advance, 1.0)
    way, error = np.linalg.norm(ours.q[-1, :2]), abs(ours.q - theirs.q).max()
    print(f"the first second in MuJoCo and in modyn: {way:.2f} m of way, coordinates differ by at most {error:.1e}\n")
    print("| asked: forwards, left (m/s), turn (rad/s) | simulator | reached | height, m | touchdowns of a foot per second | fell |")
    print("|---|---|---|---|---|---|")
    for command in ASKED:
        for name, simulator in (("modyn", advance), ("MuJoCo", simulation.advance)):
            states, touching = walk(act, first(command), simulator, given.seconds)
            print(f"| {', '.join(map(str, command))} | {name} | {report(states, touching)} |", flush=True)
        if given.animation and command[0] == 1.0:
            page = environment.robot.animation(CONTROL * np.arange(len(states.q)), states.q)
            with open(given.animation, "w") as file:
                file.write(page)


if __name__ == "__main__":
    main()
