"""The environment as a `VecEnv` of rsl_rl, whose PPO trains legged robots in Isaac Lab and mjlab.

    pip install rsl-rl-lib==5.5.1 tensorboard
    python examples/walk/rsl_rl_env.py --iterations 1000
"""

import argparse

import jax
import jax.numpy as jnp
import torch
from environment import EPISODE, Walk
from rsl_rl.env import VecEnv
from rsl_rl.runners import OnPolicyRunner
from tensordict import TensorDict
from train import BATCHES, DISCOUNT, DIVERGENCE, ENTROPY, HIDDEN, HORIZON, PASSES

NETWORK = {"class_name": "MLPModel", "hidden_dims": [*HIDDEN], "activation": "tanh"}
SETTINGS = {
    "num_steps_per_env": HORIZON,
    "save_interval": 100,
    "obs_groups": {"actor": ["actor"], "critic": ["critic"]},
    "actor": NETWORK | {"distribution_cfg": {"class_name": "GaussianDistribution", "init_std": 0.5}},
    "critic": NETWORK,
    "algorithm": {
        "class_name": "PPO", "gamma": DISCOUNT, "entropy_coef": ENTROPY, "num_learning_epochs": PASSES, "num_mini_batches": BATCHES,
        "desired_kl": DIVERGENCE,
    },
}


class WalkRslRl(VecEnv):
    """Worlds whose episodes begin again in the step in which they end. The tensors share the memory of JAX's arrays."""

    def __init__(self, num_envs=1024, seed=0):
        self.device, self.cfg, self.environment = "cpu", {}, Walk()
        self.num_envs, self.num_actions, self.max_episode_length = num_envs, self.environment.actions, EPISODE
        self._worlds, self._key = self.environment.worlds(seed, num_envs), jax.random.key(seed)
        self._state = jax.jit(self.environment.reset)(self._key, self._worlds)
        self._observe, self._step = jax.jit(self.environment.observe), jax.jit(self.environment.step)

    def _next_key(self):
        self._key, key = jax.random.split(self._key)
        return key

    @property
    def episode_length_buf(self):
        return torch.from_dlpack(self._state.time)

    @episode_length_buf.setter
    def episode_length_buf(self, lengths):
        self._state = self._state._replace(time=jnp.array(lengths.numpy()))

    def get_observations(self):
        seen = self._observe(self._worlds, self._state, self._next_key())
        return TensorDict({name: torch.from_dlpack(x) for name, x in seen._asdict().items()}, batch_size=[self.num_envs])

    def step(self, actions):
        after = self._step(self._worlds, self._state, jnp.from_dlpack(actions.contiguous()), self._next_key())
        self._state = after.state
        rewards = {f"/reward/{name}": float(reward.mean()) for name, reward in after.rewards.items()}
        extras = {"time_outs": torch.from_dlpack(after.timed_out), "log": rewards}
        ended = after.fell | after.timed_out
        return self.get_observations(), torch.from_dlpack(after.reward), torch.from_dlpack(ended), extras


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--iterations", type=int, default=1000)
    parser.add_argument("--worlds", type=int, default=1024)
    parser.add_argument("--log", default="runs/walk", help="the folder of the policies and of the log")
    given = parser.parse_args()
    runner = OnPolicyRunner(WalkRslRl(given.worlds), SETTINGS, given.log)
    runner.learn(given.iterations, init_at_random_ep_len=True)


if __name__ == "__main__":
    main()
