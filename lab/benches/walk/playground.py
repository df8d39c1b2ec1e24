"""Trains a quadruped by `examples/walk` and by mujoco_playground on the same cores, and prints the control steps per second.

    pip install ./modyn-python -r examples/walk/requirements.txt
    python -m venv peer && peer/bin/pip install playground==0.2.0 mujoco==3.6.0 mujoco-mjx==3.6.0 brax==0.14.2 "jax<0.8"
    python lab/benches/walk/playground.py --playground peer/bin/python

The time is that of sampling and learning together, after compilation; no policy is evaluated. Both programs use JAX in single
precision, control steps of 20 ms with five simulation steps of 4 ms, twelve joints with dry friction, four feet on a floor, and
pyramidal friction cones. They differ in the rest:

- modyn trains the robot of `examples/walk`: no joint limits; ground friction, load and delay that differ between the worlds. The
  solver ends at `TOLERANCE` of `environment.py`. An iteration has 24 control steps of each world, 4 passes over 4 batches, and
  networks with two layers of 128.
- mujoco_playground trains the Go1 of its task `Go1JoystickFlatTerrain` in MJX (`impl="jax"`): joint limits; the same model in all
  worlds. The solver makes one Newton iteration, whose line search has at most five. brax's PPO has playground's parameters
  for this task: 163,840 control steps in an iteration, 4 passes over 32 batches, and networks with layers of 512, 256 and 128.
  The worlds are not reset between iterations.

At its first use, playground clones mujoco_menagerie, of which this task needs the meshes that are drawn. No mesh takes part in
the simulation. MJX compiles for minutes; `JAX_COMPILATION_CACHE_DIR` keeps the compiled programs for another run, whose column
*compilation* is then the time of loading them.
"""

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

WALK = Path(__file__).resolve().parents[3] / "examples" / "walk"
TASK = "Go1JoystickFlatTerrain"


class Enough(Exception):
    """Ends brax's training after the time of the measurement."""


def row(name, compilation, steps, seconds):
    print(f"| {name} | {compilation:.0f} | {steps / 1e6:.2f} | {seconds:.0f} | {steps / seconds:,.0f} |", flush=True)


def modyn(given):
    sys.path.insert(0, str(WALK))
    import jax
    import train as ppo
    from environment import Walk

    environment, began = Walk(), time.perf_counter()
    iterate = ppo.iteration(environment)
    learner, episodes, _ = jax.block_until_ready(iterate(*ppo.prepare(environment, 0, given.worlds)))
    compilation, began, count = time.perf_counter() - began, time.perf_counter(), 0
    while (seconds := time.perf_counter() - began) < given.seconds:
        learner, episodes, _ = jax.block_until_ready(iterate(learner, episodes))
        count += 1
    row(f"modyn, {given.worlds} worlds", compilation, count * given.worlds * ppo.HORIZON, seconds)


def playground(given):
    from functools import partial

    from brax.training.agents.ppo import networks, train
    from mujoco_playground import registry, wrapper
    from mujoco_playground.config import locomotion_params

    environment = registry.load(TASK, config_overrides={"impl": "jax"})
    config = dict(locomotion_params.brax_ppo_config(TASK, "jax"))
    iteration = config["batch_size"] * config["num_minibatches"] * config["unroll_length"]
    factory = partial(networks.make_ppo_networks, **config.pop("network_factory"))
    # An evaluation would come after each iteration, but none is made.
    config |= {"num_envs": given.envs, "num_evals": 1001, "num_timesteps": 1000 * iteration, "num_resets_per_eval": 0}
    times = [time.perf_counter()]

    def progress(_steps, _metrics):
        times.append(time.perf_counter())
        print(f"an iteration: {times[-1] - times[-2]:.1f} s", file=sys.stderr, flush=True)
        if times[-1] - times[1] >= given.seconds:
            raise Enough

    try:
        train.train(
            environment, **config, network_factory=factory, wrap_env_fn=wrapper.wrap_for_brax_training, run_evals=False,
            progress_fn=progress,
        )
    except Enough:
        seconds, count = times[-1] - times[1], len(times) - 2
        row(f"mujoco_playground, {given.envs} worlds", times[1] - times[0] - seconds / count, count * iteration, seconds)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--playground", default=sys.executable, help="the Python that has mujoco_playground")
    parser.add_argument("--worlds", type=int, default=1024, help="the worlds of examples/walk")
    parser.add_argument("--envs", type=int, default=8192, help="the worlds of mujoco_playground")
    parser.add_argument("--seconds", type=float, default=60.0, help="the least time of a training")
    parser.add_argument("--only", choices=["modyn", "playground"])
    given = parser.parse_args()
    if given.only:
        return globals()[given.only](given)
    print("| | compilation, s | control steps, millions | time, s | control steps per second |")
    print("|---|---|---|---|---|", flush=True)
    for name, python in (("modyn", sys.executable), ("playground", given.playground)):
        subprocess.run([python, *sys.argv, "--only", name], check=True, env=os.environ | {"JAX_PLATFORMS": "cpu"})


if __name__ == "__main__":
    main()
