"""Walks with a trained policy in MuJoCo, on the same file: whether modyn's motion is the same, and which velocities are reached.

    python examples/walk/evaluate.py policy.npz --animation walk.html --contacts contacts.svg
"""

import argparse

import jax
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
    """Returns a function of the state: the action of the policy in a file."""
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
    """Draws when each foot is on the ground, in the last two seconds of each walk. `walks` holds `touching` by the command."""
    left, second, height, out, y = 150, 300, 14, [], 0
    for command, touching in walks.items():
        y += 26
        out.append(f'<text x="{left}" y="{y - 4}">{command[0]} m/s forwards, {command[1]} m/s to the left, {command[2]} rad/s</text>')
        for foot, on_ground in zip(feet, touching[-round(2 / dt) :].T):
            y += height
            changes = np.diff(np.concatenate([[False], on_ground, [False]]).astype(int))
            begins, ends = (second * dt * np.flatnonzero(changes == sign) for sign in (1, -1))
            bars = "".join(f"M{left + x:.1f} {y - 11}h{end - x:.1f}v11h{x - end:.1f}z" for x, end in zip(begins, ends))
            out.append(f'<text x="{left - 8}" y="{y - 2}" text-anchor="end">{foot}</text><path d="{bars}"/>')
    y += 20
    out += [f'<text x="{left + second * time}" y="{y}" text-anchor="middle">{time:g} s</text>' for time in (0, 0.5, 1, 1.5, 2)]
    size = f'viewBox="0 0 {left + 2 * second + 30} {y + 8}" width="{left + 2 * second + 30}" height="{y + 8}"'
    with open(path, "w") as file:
        # This grey is seen on light and on dark grounds.
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" {size} fill="#768390" font-family="sans-serif" font-size="11" role="img">\n')
        file.write("<title>When each foot is on the ground</title>\n" + "\n".join(out) + "\n</svg>\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("policy")
    parser.add_argument("--task", choices=TASKS, default="quadruped")
    parser.add_argument("--seconds", type=float, default=10.0, help="the time of each walk")
    parser.add_argument("--animation", help="write a page that shows the robot walk in MuJoCo at 1 m/s")
    parser.add_argument("--contacts", help="draw when each foot is on the ground in MuJoCo, as SVG")
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
