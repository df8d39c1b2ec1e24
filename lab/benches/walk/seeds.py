"""Trains policies of `examples/walk` with several seeds, and prints after which time each follows its commands.

    pip install ./modyn-python -r examples/walk/requirements.txt
    python lab/benches/walk/seeds.py --seeds 0 1 2 3 4 --steps 40e6

A policy follows a command if, without noise, loads and pushes, the mean velocity differs from it by at most 15 %: the velocities
forwards and to the left together, and the turning rate by itself. Where 0 is asked, 0.05 m/s and 0.05 rad/s are allowed.
The time is that of training only.
"""

import argparse
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "examples" / "walk"))

import jax
import jax.numpy as jnp
import train as ppo
from environment import CONTROL, Walk
from tasks import ASKED, TASKS

#: The share of a command, and what is allowed where 0 is asked, m/s and rad/s.
SHARE, STILL = 0.15, 0.05
#: The iterations between two evaluations, and the time of a walk, s.
BETWEEN, SECONDS = 20, 8.0


def evaluation(task):
    """Returns a function of a policy: the largest error of a command, relative to what is allowed; infinite after a fall."""
    environment = Walk(task, randomize=False)
    worlds = environment.worlds(0, len(ASKED))
    command = jnp.array(ASKED, jnp.float32)
    q = jnp.tile(environment.stand, (len(ASKED), 1))
    first = environment.start(q, jnp.zeros((len(ASKED), environment.robot.nv), q.dtype))._replace(command=command)
    allowed = lambda asked: jnp.maximum(SHARE * asked, STILL)

    @jax.jit
    def worst(policy):
        def act(state, _):
            action = ppo.output(policy.actor, environment.observe(worlds, state).actor)
            after, _ = environment.advance(worlds, state, action)
            return after, (after.qd, after.q[:, 2])

        qd, height = jax.lax.scan(act, first, None, round(SECONDS / CONTROL))[1]
        mean = qd[len(qd) // 3 :].mean(0)
        speed = jnp.linalg.norm(mean[:, :2] - command[:, :2], axis=-1) / allowed(jnp.linalg.norm(command[:, :2], axis=-1))
        turn = jnp.abs(mean[:, 5] - command[:, 2]) / allowed(jnp.abs(command[:, 2]))
        return jnp.where((height > task.fallen).all(), jnp.maximum(speed, turn).max(), jnp.inf)

    return lambda policy: float(worst(policy))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--task", choices=TASKS, default="quadruped")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2, 3, 4])
    parser.add_argument("--steps", type=float, default=40e6, help="the control steps of all worlds together")
    parser.add_argument("--worlds", type=int, default=1024)
    parser.add_argument("--out", type=Path, default=Path("policies"), help="the folder of the policies")
    given = parser.parse_args()
    given.out.mkdir(exist_ok=True)
    task = TASKS[given.task]
    environment, worst = Walk(task), evaluation(task)
    iterate = ppo.iteration(environment)
    print("| seed | follows after, s | control steps, millions | steps per second | largest error at the end, % of a command |")
    print("|---|---|---|---|---|")
    for seed in given.seeds:
        learner, episodes = ppo.prepare(environment, seed, given.worlds)
        if seed == given.seeds[0]:
            jax.block_until_ready(iterate(learner, episodes))  # which compiles it
        seconds, steps, follows = 0.0, 0, None
        while steps < given.steps:
            began = time.perf_counter()
            for _ in range(BETWEEN):
                learner, episodes, _ = iterate(learner, episodes)
            jax.block_until_ready(learner)
            seconds, steps = seconds + time.perf_counter() - began, steps + BETWEEN * given.worlds * ppo.HORIZON
            error = worst(learner.policy)
            if follows is None and error <= 1:
                follows = f"{seconds:.0f} | {steps / 1e6:.1f}"
            print(f"{steps / 1e6:.1f} M steps, {seconds:.0f} s: {error:.2f} of what is allowed", file=sys.stderr, flush=True)
        ppo.save(given.out / f"{seed}.npz", learner.policy)
        print(f"| {seed} | {follows or 'not | '} | {steps / seconds:,.0f} | {100 * SHARE * error:.0f} |", flush=True)


if __name__ == "__main__":
    main()
