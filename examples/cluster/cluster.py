"""The training of `examples/walk` with sampling on Ray: a sampler for each core of a cluster, and one learner.

    python examples/cluster/cluster.py                     # on this machine
    python examples/cluster/cluster.py --address auto      # on the cluster of `ray start`
    python examples/cluster/cluster.py --check             # two samplers, one of which dies; the return has to rise
"""

import argparse
import os
import signal
import sys
import time
from pathlib import Path

# Every sampler has one core.
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false " + os.environ.get("XLA_FLAGS", "")
WALK = Path(__file__).resolve().parent.parent / "walk"
sys.path.insert(0, str(WALK))

import jax
import modyn
import numpy as np
import ray
import train as ppo
from environment import Walk


@ray.remote(num_cpus=1, max_restarts=-1, max_task_retries=-1)
class Sampler:
    """Worlds in a process of their own. Ray starts a sampler that died again, with new episodes, and repeats its task."""

    def __init__(self, seed, count):
        modyn.set_threads(1)
        environment = Walk()
        worlds = environment.worlds(seed, count)
        self._episodes = jax.jit(lambda key, worlds: ppo.begin(environment, key, worlds))(jax.random.key(seed), worlds)
        self._collect = jax.jit(lambda policy, episodes: ppo.collect(environment, policy, episodes))

    def sample(self, policy):
        """Returns samples of the policy, and their progress."""
        self._episodes, sample, progress = self._collect(policy, self._episodes)
        return jax.tree.map(np.asarray, (sample, progress))

    def process(self):
        return os.getpid()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--address", help="of the cluster; without it, one starts on this machine")
    parser.add_argument("--samplers", type=int, help="all cores of the cluster by default")
    parser.add_argument("--worlds", type=int, default=1024, help="the worlds of all samplers together")
    parser.add_argument("--steps", type=float, default=30e6, help="the control steps of all worlds together")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", default="policy.npz", help="the file of the policy")
    parser.add_argument("--check", action="store_true", help="kill one of two samplers, and fail if the return does not rise")
    given = parser.parse_args()
    paths = os.pathsep.join([str(WALK), os.environ.get("PYTHONPATH", "")])
    environment = {"env_vars": {"PYTHONPATH": paths, "XLA_FLAGS": os.environ["XLA_FLAGS"], "JAX_PLATFORMS": "cpu"}}
    ray.init(address=given.address, runtime_env=environment, include_dashboard=False)
    count = 2 if given.check else given.samplers or int(ray.cluster_resources()["CPU"])
    if given.worlds % (count * ppo.BATCHES):
        parser.error(f"--worlds: a multiple of {count * ppo.BATCHES} is needed, {ppo.BATCHES} times the samplers")
    samplers = [Sampler.remote(given.seed * count + k, given.worlds // count) for k in range(count)]
    learner, learn = ppo.start(Walk(), jax.random.key(given.seed)), jax.jit(ppo.learn)
    began, returns, died = time.perf_counter(), [], None
    iterations = ppo.CHECK if given.check else round(given.steps / (given.worlds * ppo.HORIZON))
    while len(returns) <= iterations:
        kills = given.check and len(returns) == 3
        if kills:
            died = ray.get(samplers[0].process.remote())
        # One copy of the policy on each machine.
        policy = ray.put(jax.tree.map(np.asarray, learner.policy))
        parts = [sampler.sample.remote(policy) for sampler in samplers]
        if kills:
            os.kill(died, signal.SIGKILL)
        parts = ray.get(parts)
        sample = jax.tree.map(lambda *parts: np.concatenate(parts, 1), *[sample for sample, _ in parts])
        progress = jax.tree.map(lambda *parts: np.mean(parts), *[progress for _, progress in parts])
        learner = learn(learner, sample)
        returns.append(float(progress.returns))
        if len(returns) % 20 == 0:
            ppo.show(progress, learner, time.perf_counter() - began, len(returns) * given.worlds * ppo.HORIZON)
            if not given.check:
                ppo.save(given.out, learner.policy)
    if given.check:
        if ray.get(samplers[0].process.remote()) == died:
            sys.exit("the first sampler has not died")
        ppo.check(returns)
    ppo.save(given.out, learner.policy)


if __name__ == "__main__":
    main()
