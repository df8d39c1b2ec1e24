"""Walks with a trained policy in MuJoCo, on the same file: whether modyn's motion is the same, and which velocities are reached.

    python examples/walk/evaluate.py policy.npz --animation walk.html --contacts contacts.svg
"""

import argparse

import jax
import matplotlib.pyplot as plt
import mujoco
import numpy as np

jax.config.update("jax_enable_x64", True)

from environment import CONTROL, STEPS, Walk  # noqa: E402
from modyn.conventions import MuJoCo  # noqa: E402
from tasks import ASKED, TASKS  # noqa: E402
from train import load, output  # noqa: E402


class Simulation:
    """MuJoCo under the actions of the environment, with the file's friction and without loads, delays and pushes."""

    def __init__(self, environment):
        self.environment = environment
        self.model = mujoco.MjModel.from_xml_path(str(environment.task.robot))
        # The solution of the same problem as exactly as modyn's in double precision.
        self.model.opt.tolerance, self.model.opt.ls_tolerance, self.model.opt.iterations = 1e-14, 1e-10, 100
        self.data = mujoco.MjData(self.model)
        self.theirs = MuJoCo(environment.robot, self.model)
        bodies = [self.model.body(foot).id for foot in environment.task.feet]
        self.feet = [set(np.flatnonzero((self.model.geom_bodyid == body) & (self.model.geom_contype > 0)).tolist()) for body in bodies]

    def start(self, state):
        mujoco.mj_resetData(self.model, self.data)
        q, qd = np.asarray(state.q[0]), np.asarray(state.qd[0])
        self.data.qpos[:], self.data.qvel[:] = self.theirs.to_qpos(q), self.theirs.to_qvel(q, qd)

    def pushed(self):
        """Returns the geoms on which a contact pushes."""
        force = np.zeros((self.data.ncon, 6))
        for k, row in enumerate(force):
            mujoco.mj_contactForce(self.model, self.data, k, row)
        return set(self.data.contact.geom[force[:, 0] > 0].ravel().tolist())

    def advance(self, state, action):
        """Returns the state after an action, and which feet touched the ground in each step, (steps, feet)."""
        self.data.ctrl[:] = self.environment.targets(state.phase, state.command, action)[0]
        touching = []
        for _ in range(STEPS):
            mujoco.mj_step(self.model, self.data)
            pushed = self.pushed()
            touching.append([not foot.isdisjoint(pushed) for foot in self.feet])
        q = self.theirs.from_qpos(self.data.qpos)
        qd = self.theirs.from_qvel(q, self.data.qvel)
        phase = (state.phase + self.environment.task.frequency * CONTROL) % 1
        after = state._replace(q=q[None], qd=qd[None], action=action, phase=phase)
        return after, np.array(touching)


def actions(environment, policy):
    """Returns the actions of a policy, which is a file, as a function of the state."""
    worlds, actor = environment.worlds(0, 1), load(policy)
    return jax.jit(lambda state: output(actor, environment.observe(worlds, state).actor))


def first(environment, command):
    """Returns the state of a robot that stands, with a command."""
    state = environment.start(environment.stand[None], np.zeros((1, environment.robot.nv)))
    return state._replace(command=np.array([command], float))


def walk(act, state, advance, seconds):
    """Returns the states after each action, stacked, and which feet touched the ground in each step, (steps, feet)."""
    states, touching = [], []
    for _ in range(round(seconds / CONTROL)):
        state, touched = advance(state, act(state))
        states.append(state)
        touching.append(np.reshape(touched, (STEPS, -1)))
    return jax.tree.map(lambda *x: np.stack(x)[:, 0], *states), np.concatenate(touching)


def report(states, touching, fallen):
    """Returns cells of the table: the velocities and the height without the first third, the touchdowns of a foot per second, the falls."""
    q, qd = (x[len(states.q) // 3 :] for x in (states.q, states.qd))
    forwards, left, turn = qd[:, [0, 1, 5]].mean(0)
    touchdowns = (~touching[:-1] & touching[1:]).sum(0) / (len(states.q) * CONTROL)
    fell = "yes" if states.q[:, 2].min() < fallen else "no"
    return f"{forwards:.2f}, {left:.2f}, {turn:.2f} | {q[:, 2].mean():.3f} | {touchdowns.min():.1f} to {touchdowns.max():.1f} | {fell}"


def draw(walks, feet, dt, path):
    """Draws when each foot is on the ground, in the last two seconds of each walk. `walks` holds what touches by the command."""
    plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "walk"})
    figure, axes = plt.subplots(len(walks), 1, sharex=True, figsize=(8, 1.1 * len(walks)), layout="constrained")
    for plot, (command, touching) in zip(axes, walks.items()):
        last = touching[-round(2 / dt) :]
        for row, foot in enumerate(last.T):
            changes = np.diff(np.concatenate([[False], foot, [False]]).astype(int))
            begins, ends = np.flatnonzero(changes > 0), np.flatnonzero(changes < 0)
            plot.broken_barh(list(zip(begins * dt, (ends - begins) * dt)), (row + 0.1, 0.8), color="0.25")
        plot.set(xlim=(0, 2), ylim=(len(feet), 0), yticks=np.arange(len(feet)) + 0.5, yticklabels=feet)
        plot.set_title("{:g} m/s forwards, {:g} m/s left, {:g} rad/s".format(*command), loc="left", fontsize="small")
        plot.tick_params(labelsize="x-small")
    axes[-1].set_xlabel("time, s")
    figure.savefig(path, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("policy")
    parser.add_argument("--task", choices=TASKS, default="quadruped")
    parser.add_argument("--seconds", type=float, default=10.0, help="the time of each walk")
    parser.add_argument("--animation", help="write a page that shows the robot walk in MuJoCo at 1 m/s")
    parser.add_argument("--contacts", help="draw when each foot is on the ground in MuJoCo, a picture for Matplotlib")
    given = parser.parse_args()
    environment = Walk(TASKS[given.task], scalar="f64", randomize=False)
    worlds, act = environment.worlds(0, 1), actions(environment, given.policy)
    advance = jax.jit(lambda state, action: environment.advance(worlds, state, action))
    simulation, begin = Simulation(environment), first(environment, (0.5, 0, 0.3))
    simulation.start(begin)
    ours, _ = walk(act, begin, advance, 1.0)
    theirs, _ = walk(act, begin, simulation.advance, 1.0)
    way, error = np.linalg.norm(ours.q[-1, :2]), abs(ours.q - theirs.q).max()
    print(f"the first second in MuJoCo and in modyn: {way:.2f} m of way, coordinates differ by at most {error:.1e}\n")
    print("| asked: forwards, left (m/s), turn (rad/s) | simulator | reached | height, m | touchdowns of a foot per second | fell |")
    print("|---|---|---|---|---|---|")
    walks = {}
    for command in ASKED:
        begin = first(environment, command)
        simulation.start(begin)
        for name, simulator in (("modyn", advance), ("MuJoCo", simulation.advance)):
            states, touching = walk(act, begin, simulator, given.seconds)
            print(f"| {', '.join(map(str, command))} | {name} | {report(states, touching, environment.task.fallen)} |", flush=True)
        walks[command] = touching
        if given.animation and command[0] == 1.0:
            page = environment.robot.animation(CONTROL * np.arange(len(states.q)), states.q)
            with open(given.animation, "w") as file:
                file.write(page)
    if given.contacts:
        draw(walks, environment.task.feet, environment.dt, given.contacts)


if __name__ == "__main__":
    main()
